from .circle_function import TURN as TURN, CircleFunction as CircleFunction
from .foliation import (
    LEAST_FIRST as LEAST_FIRST,
    QUANTILE as QUANTILE,
    Foliation as Foliation,
    Steps as Steps,
    Weighting as Weighting,
    foliate as foliate,
    global_scale as global_scale,
    punctured as punctured,
)
from .integrability import (
    integrating_factor as integrating_factor,
    perpendicular as perpendicular,
    vertices_and_faces as vertices_and_faces,
)
from .level_set_alignment import Alignment as Alignment, alignment as alignment, deviation as deviation
from .level_sets import isolines as isolines
