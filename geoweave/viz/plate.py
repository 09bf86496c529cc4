"""Plates: a flat or gently curved mesh seen from one side, with arrows, lines and words (Figs. 6, 9, 10, 12).

Drawn as polygons in parallel projection, so that edges, arrows and labels stay sharp at any size. What faces
away from the eye is left out; parts of a surface that hide one another want `geoweave.viz.Scene`.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from geoweave.arrays import Scalars, Vectors
from geoweave.curves import Curves
from geoweave.errors import RenderError
from geoweave.fields import FaceField
from geoweave.surface import TriMesh, part_of
from geoweave.viz import style
from geoweave.viz.arrows import Arrows
from geoweave.viz.scales import Scale
from geoweave.viz.views import FROM_ABOVE, View

MARGIN = 0.02
"""Air around the mesh on a plate, as a share of its longer side; more where arrows stick out."""


@dataclass(frozen=True, eq=False)
class Lines:
    """Lines of one look: (N, 2, 3) straight pieces, or the curves of a foliation.

    Attributes
    ----------
    what : the lines
    colour, width : width in points of a figure of full width
    dashed : whether to draw dashes
    label : words for the legend under the plate, none if empty
    """

    what: Vectors | Curves
    colour: str = style.INK
    width: float = 0.6
    dashed: bool = False
    label: str = ""


@dataclass(frozen=True)
class Note:
    """A few words beside a point of the plate, ``offset`` in points to the right and up."""

    point: tuple[float, float, float]
    text: str
    colour: str = style.INK
    offset: tuple[float, float] = (0.0, 0.0)
    size: float = 10.0


@dataclass(frozen=True, eq=False)
class Plate:
    """One mesh and what lies on it.

    Attributes
    ----------
    mesh : what to draw
    title, subtitle : lines under the plate
    values : (F,) shown as colours of the faces
    scale : what the colours mean; needed with values
    edges : whether to draw the mesh's edges
    arrows, lines, notes : what lies on it, drawn in this order: lines, arrows, notes
    dots : (N, 3) points marked
    dot_colour : their colour
    view : where from; from above by default
    """

    mesh: TriMesh
    title: str = ""
    subtitle: str = ""
    values: Scalars | None = None
    scale: Scale | None = None
    edges: bool = False
    arrows: Sequence[Arrows] = ()
    lines: Sequence[Lines] = ()
    notes: Sequence[Note] = ()
    dots: Vectors | None = None
    dot_colour: str = style.SOURCE
    view: View = field(default=FROM_ABOVE)

    def __post_init__(self) -> None:
        if (self.values is None) != (self.scale is None):
            raise RenderError(f"plate '{self.title}': values and the scale of their colours go together")
        if self.values is not None and self.values.shape != (self.mesh.n_faces,):
            raise RenderError(
                f"plate '{self.title}': values of faces need shape ({self.mesh.n_faces},), "
                f"not {self.values.shape}"
            )

    @property
    def box(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Lower left and upper right of what is drawn, in the plane of the picture."""
        points = [self.mesh.vertices]
        for each in self.arrows:
            points += [each.points, each.points + each.vectors]
        flat = np.concatenate(points) @ self.view.axes[:2].T
        low, high = flat.min(axis=0), flat.max(axis=0)
        air = MARGIN * float((high - low).max())
        return low - air, high + air


def projections(
    field: FaceField, vertex: int, title: str = "", subtitle: str = "", *, view: View | None = None
) -> Plate:
    """Show around a vertex what the discrete curl compares: projections on the common edges (Fig. 6, left).

    Beside each edge lie the projections of the vectors on its two sides (teal and ochre), each from the foot
    of the vector's tail to the foot of its tip. They are equally long where the curl vanishes (Eq. 3).
    Without a view one looks along the normal of the vertex.

    Examples
    --------
    >>> plate = viz.projections(gw.smoothest_field(gw.shapes.sphere(faces=320)), vertex=5)
    >>> vectors, left, right = plate.arrows
    >>> len(vectors.points) == len(left.points) == len(right.points)
    True
    """
    if view is None:
        x, y, z = field.mesh.vertex_normals[vertex]
        view = View(float(np.degrees(np.arctan2(y, x))), float(np.degrees(np.arcsin(np.clip(z, -1, 1)))))
    fan = part_of(field.mesh, (field.mesh.faces == vertex).any(axis=1))
    mesh, vectors = fan.mesh, 0.4 * fan.mesh.mean_edge * field.ambient[fan.faces]
    size = mesh.mean_edge
    spokes = mesh.interior_edges
    along = mesh.edge_vectors[spokes] / mesh.edge_lengths[spokes, None]
    base = mesh.vertices[mesh.edges[spokes, 0]]
    tails = mesh.barycenters - 0.5 * vectors
    arrows, feet = [Arrows(tails, vectors, width=0.028 * size)], []
    for side, colour in ((0, style.FAMILIES[0]), (1, style.FAMILIES[1])):
        face = mesh.edge_faces[spokes, side]
        tail, vector = tails[face], vectors[face]
        foot = base + np.einsum("ex,ex->e", tail - base, along)[:, None] * along
        shadow = np.einsum("ex,ex->e", vector, along)[:, None] * along
        # Face i lies to the left of its edge.
        aside = (1 - 2 * side) * 0.03 * size * np.cross(mesh.face_normals[face], along)
        arrows.append(Arrows(foot + aside, shadow, colour, 0.022 * size))
        feet += [np.stack([tail, foot], axis=1), np.stack([tail + vector, foot + shadow], axis=1)]
    dashes, dots = Lines(np.concatenate(feet), style.FAINT, dashed=True), field.mesh.vertices[[vertex]]
    return Plate(mesh, title, subtitle, edges=True, arrows=arrows, lines=[dashes], dots=dots, view=view)
