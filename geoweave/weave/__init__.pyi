from . import interlacing as interlacing
from .as_cut import (
    AsCut as AsCut,
    moved_out_of_order as moved_out_of_order,
    turned_over as turned_over,
)
from .body import SECTIONS as SECTIONS, Body as Body, Centreline as Centreline, bodies as bodies
from .cover import Cover as Cover, Leaves as Leaves, branched_cover as branched_cover
from .design import (
    WeaveField as WeaveField,
    weave_curves as weave_curves,
    weave_field as weave_field,
    weave_pattern as weave_pattern,
)
from .edits import (
    Edits as Edits,
    Flip as Flip,
    design_key as design_key,
    edited as edited,
    read_edits as read_edits,
)
from .flat_curve import FlatCurve as FlatCurve, check_curvature as check_curvature
from .inspection import Inspection as Inspection, inspected as inspected
from .passages import Passages as Passages, merged as merged
from .phase import PHASES as PHASES, Phase as Phase, phase_of as phase_of
from .regularity import Regularity as Regularity, piled_crossings as piled_crossings
from .ribbons import Cutting as Cutting, Ribbons as Ribbons
from .singularity_search import Stage as Stage, searched as searched
from .steering import (
    Singularity as Singularity,
    Steering as Steering,
)
from .steering_files import read_guide as read_guide, read_singularities as read_singularities
from .validity import violations as violations
from .weave import (
    Design as Design,
    Weave as Weave,
)
from .weave_format import WEAVE_FORMAT as WEAVE_FORMAT, WEAVE_VERSION as WEAVE_VERSION
from .weave_types import (
    FLOATING as FLOATING,
    WEAVE_TYPES as WEAVE_TYPES,
    WeaveType as WeaveType,
    rules_of as rules_of,
    weave_type_of as weave_type_of,
)
