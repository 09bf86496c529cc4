from .closest_point import (
    BoxTree as BoxTree,
    closest_points as closest_points,
    nearest as nearest,
    segment_tree as segment_tree,
    triangle_tree as triangle_tree,
)
from .components import connected_components as connected_components
from .mesh import SMALLEST_ASPECT as SMALLEST_ASPECT, Similarity as Similarity, TriMesh as TriMesh
from .mirror_symmetry import (
    MIRROR_AXES as MIRROR_AXES,
    MirrorAxis as MirrorAxis,
    MirrorPlane as MirrorPlane,
    mirror_plane as mirror_plane,
)
from .smooth_normal import smooth_normals as smooth_normals
from .submesh import Part as Part, part_of as part_of
from .twisted_mesh import TwistedMesh as TwistedMesh
