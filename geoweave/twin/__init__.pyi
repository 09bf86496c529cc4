from .begun_at_weave import begun_at as begun_at
from .contradictions import (
    Contradiction as Contradiction,
    check_sound as check_sound,
    contradiction_sentence as contradiction_sentence,
    contradictions_of as contradictions_of,
)
from .joints import HangingPart as HangingPart, hanging_parts as hanging_parts
from .pattern_surface import (
    PatternSurface as PatternSurface,
    openings_of as openings_of,
    surface_of as surface_of,
)
from .twin import Likeness as Likeness, Twin as Twin, assembled as assembled
