"""Arrows of vector fields for drawings in one plane (Figs. 6, 9, 10 and 12)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from geoweave.arrays import Flags, Vectors
from geoweave.errors import RenderError
from geoweave.fields import FaceField
from geoweave.surface import TriMesh
from geoweave.viz import style
from geoweave.viz.views import FROM_ABOVE, View


@dataclass(frozen=True, eq=False)
class Arrows:
    """Arrows of one colour, from ``points`` along ``vectors``.

    Attributes
    ----------
    points, vectors : (N, 3); the lengths are drawn as they are
    colour : of shaft and head
    width : of the shaft, a length
    label : words for the legend under the plate, none if empty
    """

    points: Vectors
    vectors: Vectors
    colour: str = style.INK
    width: float = 0.01
    label: str = ""

    def __post_init__(self) -> None:
        if self.points.shape != self.vectors.shape or self.points.ndim != 2 or self.points.shape[1] != 3:
            raise RenderError(
                "arrows need points and vectors of one shape (N, 3), not "
                f"{self.points.shape} and {self.vectors.shape}"
            )


def face_arrows(
    field: FaceField,
    *,
    length: float | None = None,
    faces: Flags | None = None,
    start: FaceField | None = None,
    colour: str = style.INK,
    width: float | None = None,
    label: str = "",
) -> Arrows:
    """Make one arrow per face from a field; a unit vector is drawn at ``length``.

    Parameters
    ----------
    field : what to draw
    length : of a unit vector; 0.6 mean edges by default
    faces : (F,) those to draw, all by default
    start : if given, arrows start where the centred arrows of this field end: ``delta`` at the tip of ``w``
    colour, width, label : as in `Arrows`; the width is a twelfth of the length by default

    Examples
    --------
    >>> field = gw.smoothest_field(gw.shapes.disk(faces=100))
    >>> arrows = viz.face_arrows(field, length=0.1)
    >>> bool(np.allclose(np.linalg.norm(arrows.vectors, axis=1), 0.1))
    True
    """
    mesh = field.mesh
    unit = 0.6 * mesh.mean_edge if length is None else length
    base = field if start is None else start
    points = mesh.barycenters - 0.5 * unit * base.ambient
    if start is not None:
        points = points + unit * start.ambient
    keep = np.ones(mesh.n_faces, dtype=bool) if faces is None else faces
    thick = unit / 12.0 if width is None else width
    return Arrows(points[keep], unit * field.ambient[keep], colour, thick, label)


def mark(point: Sequence[float], vector: Sequence[float], colour: str) -> Arrows:
    """One bold arrow with its middle at a point: a handle (Fig. 10).

    Examples
    --------
    >>> viz.mark([0.5, 0, 0], [0, 0.2, 0], "#ff0000").points.tolist()
    [[0.5, -0.1, 0.0]]
    """
    along = np.array([vector], dtype=np.float64)
    return Arrows(np.array([point]) - 0.5 * along, along, colour, float(np.linalg.norm(along)) / 12.0)


def scattered(mesh: TriMesh, spacing: float, view: View | None = None) -> Flags:
    """Choose (F,) faces about so far apart, on a square grid seen from the eye: arrows that do not crowd.

    Examples
    --------
    >>> disk = gw.shapes.disk(faces=2_000)
    >>> bool(5 < viz.scattered(disk, 0.5).sum() < viz.scattered(disk, 0.25).sum())
    True
    """
    flat = mesh.barycenters @ (view or FROM_ABOVE).axes[:2].T
    cell = np.floor((flat - flat.min(axis=0)) / spacing)
    middle = flat.min(axis=0) + (cell + 0.5) * spacing
    off = np.linalg.norm(flat - middle, axis=1)
    order = np.lexsort((off, cell[:, 1], cell[:, 0]))
    first = np.ones(len(order), dtype=bool)
    first[1:] = (np.diff(cell[order], axis=0) != 0).any(axis=1)
    chosen = np.zeros(mesh.n_faces, dtype=bool)
    # A cell at the rim may have its nearest face far from its middle, close to another cell's.
    chosen[order[first]] = off[order[first]] < 0.35 * spacing
    return chosen
