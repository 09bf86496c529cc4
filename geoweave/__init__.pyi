from . import (
    comparisons as comparisons,
    curves as curves,
    fabrication as fabrication,
    fields as fields,
    foliation as foliation,
    meshing as meshing,
    models as models,
    pipeline as pipeline,
    rods as rods,
    surface as surface,
    twin as twin,
    weave as weave,
)
from .curves import (
    Crossings as Crossings,
    Curves as Curves,
    bending as bending,
    crossings as crossings,
    geodesic_curvature as geodesic_curvature,
    straightest as straightest,
    streamlines as streamlines,
)
from .errors import (
    DataError as DataError,
    FieldError as FieldError,
    GeoweaveError as GeoweaveError,
    MeshError as MeshError,
)
from .fields import (
    FaceField as FaceField,
    GeodesicSolve as GeodesicSolve,
    Handles as Handles,
    RoSyField as RoSyField,
    circulation as circulation,
    diffused_field as diffused_field,
    edge_curl as edge_curl,
    geodesic_field as geodesic_field,
    index_sum as index_sum,
    integrated_curl as integrated_curl,
    merged_pairs as merged_pairs,
    prescribed_rosy as prescribed_rosy,
    random_field as random_field,
    sharpening_schedule as sharpening_schedule,
    signed_curl as signed_curl,
    singular_vertices as singular_vertices,
    smoothest_field as smoothest_field,
    smoothest_rosy as smoothest_rosy,
    total_curl as total_curl,
    vertex_indices as vertex_indices,
)
from .foliation import (
    CircleFunction as CircleFunction,
    Foliation as Foliation,
    foliate as foliate,
    isolines as isolines,
)
from .meshing import isotropic_remesh as isotropic_remesh, read_mesh as read_mesh
from .models import datasets as datasets, shapes as shapes
from .pipeline import (
    CutRequest as CutRequest,
    MeshSource as MeshSource,
    WeaveRequest as WeaveRequest,
    WovenFiles as WovenFiles,
    cut_folder as cut_folder,
    edit_folder as edit_folder,
    show_folder as show_folder,
    weave_file as weave_file,
)
from .rods import (
    elastic_rods as elastic_rods,
    relax as relax,
    relaxed_weave as relaxed_weave,
    slide as slide,
)
from .surface import TriMesh as TriMesh
from .weave import (
    Cover as Cover,
    Weave as Weave,
    branched_cover as branched_cover,
    weave_curves as weave_curves,
    weave_field as weave_field,
    weave_pattern as weave_pattern,
)
