"""Lines on which a field is singular: chains of edges across which it turns sharply (Section 4.1, Fig. 3)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import sparse
from scipy.sparse import csgraph

from geoweave.arrays import Indices, Scalars, frozen
from geoweave.errors import FieldError
from geoweave.fields import FaceField, edge_curl, rotation_across
from geoweave.surface import TriMesh

LINE_ANGLE = 45.0
"""Degrees by which a field turns across an edge of a singular line."""

SHORTEST_LINE = 4.0
"""Chains that reach less far than so many mean edges count as points: a star of edges round a singularity."""


@dataclass(frozen=True, eq=False)
class SingularLines:
    """Connected chains of mesh edges across which a field turns sharply.

    Attributes
    ----------
    mesh : the surface
    edges : (n,) the edges, indices into ``mesh.edges``
    line_of_edge : (n,) line that each edge belongs to, numbered from 0
    lengths : (lines,) length of the edges of each line
    curls : (lines,) ``sum |(w_j - w_i) . e_ij|`` over its edges: the curl on the line. An edge adds
        nothing where the vectors on both sides make equal angles with it.
    """

    mesh: TriMesh
    edges: Indices
    line_of_edge: Indices
    lengths: Scalars
    curls: Scalars

    def __len__(self) -> int:
        return len(self.lengths)

    @property
    def length(self) -> float:
        """Length of all lines together."""
        return float(self.lengths.sum())

    @property
    def curl(self) -> float:
        """Curl on all lines together, a length for a unit field."""
        return float(self.curls.sum())


def singular_lines(
    field: FaceField, angle: float = LINE_ANGLE, shortest: float = SHORTEST_LINE
) -> SingularLines:
    """Find the lines on which a field is singular.

    Edges across which the field turns by more than the angle are joined at their vertices. A line is dropped
    if its span, the diagonal of its bounding box, is too short.

    Parameters
    ----------
    field : the field; lengths matter for ``curls`` only
    angle : degrees, between 0 and 180
    shortest : least span, in mean edge lengths of the mesh

    Raises
    ------
    FieldError
        If the angle or the shortest span is out of range.
    """
    if not (0 < angle < 180 and shortest >= 0):
        raise FieldError(
            f"singular lines need an angle between 0 and 180 degrees and a span, not {angle} and {shortest}"
        )
    mesh = field.mesh
    sharp = np.abs(rotation_across(field)) > np.radians(angle)
    edges = mesh.interior_edges[sharp]
    ends = mesh.edges[edges]
    graph = sparse.coo_array(
        (np.ones(len(edges), dtype=np.int8), tuple(ends.T)), shape=(mesh.n_vertices,) * 2
    )
    _, of_vertex = csgraph.connected_components(graph, directed=False)
    _, line = np.unique(of_vertex[ends[:, 0]], return_inverse=True)
    count = int(line.max(initial=-1)) + 1
    low, high = np.full((count, 3), np.inf), np.full((count, 3), -np.inf)
    for end in (0, 1):
        np.minimum.at(low, line, mesh.vertices[ends[:, end]])
        np.maximum.at(high, line, mesh.vertices[ends[:, end]])
    long = np.linalg.norm(high - low, axis=1) >= shortest * mesh.mean_edge
    kept = long[line]
    renumbered = np.cumsum(long) - 1
    line = renumbered[line[kept]]
    return SingularLines(
        mesh,
        frozen(edges[kept]),
        frozen(line),
        *(
            frozen(np.asarray(np.bincount(line, each[kept], long.sum()), dtype=np.float64))
            for each in (mesh.edge_lengths[edges], np.abs(edge_curl(field)[sharp]))
        ),
    )
