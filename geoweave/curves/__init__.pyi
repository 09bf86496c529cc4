from .curves import (
    Curves as Curves,
    bending as bending,
    geodesic_curvature as geodesic_curvature,
    lifted as lifted,
)
from .straightest_geodesics import (
    Crossings as Crossings,
    crossings as crossings,
    straightest as straightest,
    taken as taken,
)
from .tracing import streamlines as streamlines
