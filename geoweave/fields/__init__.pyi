from .alignment import (
    Guide as Guide,
    aligned_connection as aligned_connection,
    aligned_rosy as aligned_rosy,
    along_curve as along_curve,
    along_direction as along_direction,
)
from .closed_projection import ClosedProjection as ClosedProjection, ordering_of as ordering_of
from .connected_rosy import ConnectedRoSy as ConnectedRoSy
from .face_field import (
    FaceField as FaceField,
    Handles as Handles,
    edge_curl as edge_curl,
    integrated_curl as integrated_curl,
    random_field as random_field,
    signed_curl as signed_curl,
    total_curl as total_curl,
    unit as unit,
)
from .geodesic import (
    INTEGRABLE_END as INTEGRABLE_END,
    SHARPENING_END as SHARPENING_END,
    GeodesicSolve as GeodesicSolve,
    Step as Step,
    geodesic_field as geodesic_field,
    sharpening_schedule as sharpening_schedule,
)
from .index_pairs import (
    EdgePaths as EdgePaths,
    Merged as Merged,
    Pair as Pair,
    merged_pairs as merged_pairs,
    moved as moved,
)
from .least_bending import bending_directions as bending_directions, bending_power as bending_power
from .mirror_images import MirrorImages as MirrorImages, symmetrized as symmetrized
from .operators import (
    ClosedFields as ClosedFields,
    as_complex as as_complex,
    as_real as as_real,
    curl as curl,
    differences as differences,
    dual_weights as dual_weights,
    face_laplacian as face_laplacian,
    face_mass as face_mass,
    field_mass as field_mass,
    gradient as gradient,
    sharp as sharp,
    spectral_shift as spectral_shift,
    transport_differences as transport_differences,
)
from .rosy import (
    RoSyField as RoSyField,
    diffused_field as diffused_field,
    smoothest_field as smoothest_field,
    smoothest_rosy as smoothest_rosy,
)
from .singularities import (
    circulation as circulation,
    index_sum as index_sum,
    rotation_across as rotation_across,
    singular_vertices as singular_vertices,
    vertex_indices as vertex_indices,
    windings as windings,
)
from .triples import Triples as Triples
from .trivial_connection import prescribed_rosy as prescribed_rosy
from .zero_sum import LAST_ETA as LAST_ETA, PRESCRIBED_ETA as PRESCRIBED_ETA
