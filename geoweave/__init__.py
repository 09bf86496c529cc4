"""Weaving Geodesic Foliations (Vekhter et al. 2019), reproducible: from a mesh to a geodesic field and on.

The package is cut like the paper. `TriMesh` is the surface, `smoothest_field` and `diffused_field` make a
start, `geodesic_field` is Algorithm 1, `streamlines` shows what came of it. Pictures are in `geoweave.viz`,
which is imported only when asked for.
"""

from __future__ import annotations

from geoweave import datasets, models, shapes
from geoweave.circle import CircleFunction
from geoweave.cover import Cover, branched_cover
from geoweave.curves import Curves, geodesic_curvature
from geoweave.errors import DataError, FieldError, GeoweaveError, MeshError
from geoweave.fields import FaceField, Handles, random_field, signed_curl, total_curl
from geoweave.geodesic import GeodesicSolve, geodesic_field, sharpening_schedule
from geoweave.integration import Foliation, foliate
from geoweave.isolines import isolines
from geoweave.mesh import TriMesh
from geoweave.prepare import read_mesh
from geoweave.remesh import isotropic_remesh
from geoweave.rosy import RoSyField, diffused_field, smoothest_field, smoothest_rosy
from geoweave.singularities import circulation, index_sum, singular_vertices, vertex_indices
from geoweave.straightest import Crossings, crossings, straightest
from geoweave.tracing import streamlines

__all__ = [
    "CircleFunction",
    "Cover",
    "Crossings",
    "Curves",
    "DataError",
    "FaceField",
    "FieldError",
    "Foliation",
    "GeodesicSolve",
    "GeoweaveError",
    "Handles",
    "MeshError",
    "RoSyField",
    "TriMesh",
    "branched_cover",
    "circulation",
    "crossings",
    "datasets",
    "diffused_field",
    "foliate",
    "geodesic_curvature",
    "geodesic_field",
    "index_sum",
    "isolines",
    "isotropic_remesh",
    "models",
    "random_field",
    "read_mesh",
    "shapes",
    "sharpening_schedule",
    "signed_curl",
    "singular_vertices",
    "smoothest_field",
    "smoothest_rosy",
    "straightest",
    "streamlines",
    "total_curl",
    "vertex_indices",
]
