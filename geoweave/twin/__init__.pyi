from .pattern_surface import surface_of as surface_of
from .twin import Likeness as Likeness, Twin as Twin, assembled as assembled
