"""Circle-valued functions in the colours of a wheel, with their level sets (Figs. 4 and 11).

Theta is painted as it is defined: linear over each face, with the turns along its edges. No seam shows where
the angle wraps round, however coarse the mesh.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from matplotlib.colors import Colormap, LinearSegmentedColormap, to_hex
from matplotlib.figure import Figure

from geoweave.arrays import Indices, Scalars, Vectors
from geoweave.curves import Curves
from geoweave.errors import RenderError
from geoweave.foliation import TURN, CircleFunction
from geoweave.surface import Part, TriMesh
from geoweave.viz import style
from geoweave.viz.layout import grid
from geoweave.viz.picture import Picture
from geoweave.viz.scales import colour_bar, theta_scale
from geoweave.viz.scene import Scene
from geoweave.viz.views import View, view_of

FOOT = 150
"""Pixels of a full-width figure for the colour bar."""

SHADES = 24
"""Colours in which dots at vertices are drawn."""

MARK = "#f5b83d"
"""Colour of dots on dislocations: amber, which is not among the colours of angles."""


def angles_of_faces(circle: CircleFunction) -> Vectors:
    """(F, 3) angles at the corners of each face, radians: theta at the first, and its changes from there."""
    change = circle.corner_jumps
    start = circle.theta[circle.mesh.faces[:, 0]]
    return np.asarray(
        start[:, None] + np.stack([0 * start, change[:, 2], change[:, 2] + change[:, 0]], axis=1)
    )


def theta_values(circle: CircleFunction) -> Scalars:
    """Angle in the middle of each face, from 0 to 2 pi: theta at its first corner and a third of the changes.

    Returns
    -------
    (F,) radians

    Examples
    --------
    >>> circle = gw.foliate(gw.smoothest_field(gw.shapes.torus(faces=400))).circle
    >>> values = viz.theta_values(circle)
    >>> bool(values.min() >= 0 and values.max() < 2 * np.pi), values.shape == (circle.mesh.n_faces,)
    (True, True)
    """
    return np.asarray(angles_of_faces(circle).mean(axis=1) % TURN)


def corner_angles(circle: CircleFunction, part: Part | None = None) -> tuple[TriMesh, Vectors]:
    """Find the angles to paint: linear over each face, so that both faces of an edge agree on it.

    A face with an edge dislocation is cut into three about its centre, because no linear function has the
    changes of its sides. Round the centre the angles grow by full turns.

    Parameters
    ----------
    circle : the function
    part : if it lives on a part of a surface, that part; the rest of the whole gets no angles

    Returns
    -------
    mesh : what to paint, with dislocated faces cut
    angles : (F, 3) at the corners of its faces, radians; not a number outside the part
    """
    whole = circle.mesh if part is None else part.whole
    faces = np.arange(whole.n_faces) if part is None else part.faces
    if len(faces) != circle.mesh.n_faces:
        raise RenderError(
            f"theta lives on {circle.mesh.n_faces} faces, the part has {len(faces)}: give the part it is on"
        )
    change = circle.corner_jumps
    angles = np.full((whole.n_faces, 3), np.nan)
    angles[faces] = angles_of_faces(circle)
    cut = np.flatnonzero(circle.dislocated)
    if not len(cut):
        return whole, angles
    # One piece beside each side, from corner k + 1 to corner k + 2; the centre is half way between them.
    centre = whole.n_vertices + np.arange(len(cut))
    own = whole.faces[faces[cut]]
    pieces = np.stack(
        [np.stack([own[:, (k + 1) % 3], own[:, (k + 2) % 3], centre], axis=1) for k in range(3)]
    )
    theta = circle.theta[circle.mesh.faces[cut]]
    painted = np.stack(
        [theta[:, [1, 2, 0]], theta[:, [1, 2, 0]] + change[cut], theta[:, [1, 2, 0]] + 0.5 * change[cut]],
        axis=2,
    ).swapaxes(0, 1)
    kept = np.ones(whole.n_faces, dtype=bool)
    kept[faces[cut]] = False
    mesh = TriMesh(
        np.concatenate([whole.vertices, whole.barycenters[faces[cut]]]),
        np.concatenate([whole.faces[kept], pieces.reshape(-1, 3)]),
    )
    return mesh, np.concatenate([angles[kept], painted.reshape(-1, 3)])


def add_theta(
    scene: Scene, circle: CircleFunction, *, part: Part | None = None, colormap: Colormap | None = None
) -> None:
    """Add a surface in the colours of a circle-valued function; faces it does not live on stay plain.

    Parameters
    ----------
    scene : where to add it
    circle : the function
    part : the part of a surface it lives on, if the whole is to be seen
    colormap : of angles, ending where it starts; `style.cyclic` by default

    Examples
    --------
    >>> circle = gw.foliate(gw.smoothest_field(gw.shapes.torus(faces=400))).circle
    >>> scene = viz.Scene()
    >>> viz.add_theta(scene, circle)
    >>> 1 < scene.aspect < 3
    True
    """
    mesh, angles = corner_angles(circle, part)
    scene.add_periodic(mesh, angles, colormap=colormap)


@dataclass(frozen=True, eq=False)
class Periodic:
    """One surface with a circle-valued function.

    Attributes
    ----------
    circle : the function
    title, subtitle : lines under the picture
    part : the part of a surface that the function lives on, if the whole is to be seen
    coloured : whether to paint theta; else the surface is plain
    curves : curves on it, such as level sets
    edges : whether to draw the edges of the mesh
    dots : whether to mark the vertices, in the colours of theta
    dislocations : whether to mark the faces that hold an edge dislocation
    thickness : radius of the curves in bounding radii
    view : where from, or the name of a model in `VIEWS`
    """

    circle: CircleFunction
    title: str = ""
    subtitle: str = ""
    part: Part | None = None
    coloured: bool = True
    curves: Curves | None = None
    edges: bool = False
    dots: bool = False
    dislocations: bool = False
    thickness: float = 0.006
    view: View | str = field(default_factory=View)

    def __post_init__(self) -> None:
        view_of(self.view)

    def scene(self) -> Scene:
        """Build the scene."""
        scene = Scene(view_of(self.view))
        mesh = self.circle.mesh if self.part is None else self.part.whole
        radius = mesh.bounding_radius
        if self.coloured:
            add_theta(scene, self.circle, part=self.part)
        else:
            scene.add_surface(mesh)
        if self.edges:
            scene.add_segments(mesh.vertices[mesh.edges], 0.0022 * radius, style.INK)
        if self.curves is not None and len(self.curves):
            scene.add_curves(self.curves, self.thickness * radius)
        if self.dots:
            share = np.rint(self.circle.theta / TURN * SHADES).astype(np.int64) % SHADES
            wheel = [to_hex(style.cyclic()(k / SHADES)) for k in range(SHADES)]
            scene.add_dots(self.circle.mesh.vertices, 0.016 * radius, [wheel[k] for k in share])
        if self.dislocations:
            found = _dislocations(self.circle)
            scene.add_dots(self.circle.mesh.barycenters[found], 0.026 * radius, [MARK] * len(found))
        return scene


def _dislocations(circle: CircleFunction) -> Indices:
    return np.flatnonzero(circle.dislocated)


def periodic_gallery(
    panels: Sequence[Periodic],
    *,
    columns: int | None = None,
    width: int = style.WIDTH,
    tallest: int = 900,
    alt: str = "",
) -> Picture:
    """Draw panels in rows of equal columns, models of a row equally tall, with the wheel of theta below.

    Parameters
    ----------
    panels : what to draw; the order is kept
    columns, width, tallest, alt : as of `gallery`

    Raises
    ------
    RenderError
        If there is nothing to draw.

    Examples
    --------
    >>> circle = gw.foliate(gw.smoothest_field(gw.shapes.torus(faces=400))).circle
    >>> viz.periodic_gallery([viz.Periodic(circle, "theta")], width=200).pixels.shape[1]
    200
    """
    foot = FOOT if any(panel.coloured or panel.dots for panel in panels) else 0
    scenes = [panel.scene() for panel in panels]
    figure = grid(
        scenes,
        [(panel.title, panel.subtitle) for panel in panels],
        columns=columns,
        width=width,
        tallest=tallest,
        foot=foot,
    )
    if foot:
        with style.applied():
            _wheel_bar(figure, width / style.WIDTH)
    described = alt or "Circle-valued functions: " + ", ".join(panel.title for panel in panels)
    maps = [style.cyclic()]
    if any(panel.dislocations for panel in panels):
        # A few small dots would get no colour of their own in the palette of a PNG.
        maps.append(LinearSegmentedColormap.from_list("geoweave-marks", ["#8a5f10", MARK, "#ffe2a0"]))
    return Picture(figure, described, tuple(maps), tuple(scenes))


def _wheel_bar(figure: Figure, unit: float) -> None:
    """Draw the colours of one full turn at the bottom."""
    height = figure.bbox.height
    box = (0.37, unit * 100 / height, 0.26, unit * 18 / height)
    colour_bar(figure, theta_scale(), box, unit)
