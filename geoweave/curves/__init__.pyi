from .curve_crossings import Crossings as Crossings, crossings as crossings
from .curves import (
    Curve as Curve,
    Curves as Curves,
    bending as bending,
    geodesic_curvature as geodesic_curvature,
    lifted as lifted,
)
from .nearest_curve import nearest_curves as nearest_curves
from .straightest_geodesics import straightest as straightest
from .stretch import stretches as stretches
from .tracing import streamlines as streamlines
