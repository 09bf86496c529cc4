from .anti_holomorphic_fields import anti_holomorphic_field as anti_holomorphic_field
from .curl_correction import curl_corrected_scale as curl_corrected_scale
from .curl_sweeps import (
    curl_by_last_smoothness as curl_by_last_smoothness,
    curl_by_resolution as curl_by_resolution,
)
from .domains import (
    area_holding as area_holding,
    ordered_domains as ordered_domains,
    worst_share as worst_share,
)
from .great_circles import meridian_angle as meridian_angle, meridian_axis as meridian_axis
from .integration_methods import (
    PAPER as PAPER,
    TITLES as TITLES,
    Integration as Integration,
    geodesic_from as geodesic_from,
    integrated as integrated,
)
from .pottmann_fields import pottmann_field as pottmann_field
from .singular_curves import singular_lines as singular_lines
