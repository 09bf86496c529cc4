from .contradictions import (
    Contradiction as Contradiction,
    contradiction_sentence as contradiction_sentence,
    contradictions_of as contradictions_of,
)
from .pattern_surface import (
    PatternSurface as PatternSurface,
    openings_of as openings_of,
    surface_of as surface_of,
)
from .twin import Likeness as Likeness, Twin as Twin, assembled as assembled
