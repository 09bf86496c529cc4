"""Pictures of an N-RoSy and of the sheets of its cover (Figs. 16 to 18)."""

from __future__ import annotations

import numpy as np
from matplotlib.colors import to_hex, to_rgb
from scipy.spatial import KDTree

from geoweave.arrays import Flags, Indices
from geoweave.curves import Curves
from geoweave.errors import RenderError
from geoweave.fields import RoSyField
from geoweave.foliation import Foliation
from geoweave.surface import TriMesh, part_of
from geoweave.viz import style
from geoweave.viz.arrows import Arrows
from geoweave.viz.periodic import angles_of_faces
from geoweave.viz.plate import Lines
from geoweave.viz.scene import Scene
from geoweave.viz.views import View, view_of
from geoweave.weave import Cover

PALE = 0.42
"""Share of white in the colour of a vector whose opposite has the full colour."""


def sheet_colours(degree: int) -> tuple[str, ...]:
    """One colour for each sheet: a hue for each family, paler on the sheet of the opposite vector.

    Examples
    --------
    >>> viz.sheet_colours(4)
    ('#3f7d8c', '#d9a441', ..., ...)
    """
    families = degree // 2 if degree % 2 == 0 else degree
    full = [style.FAMILIES[k % len(style.FAMILIES)] for k in range(families)]
    pale = [_lighter(colour, PALE) for colour in full]
    return (*full, *pale) if degree % 2 == 0 else tuple(full)


def sheet_names(degree: int) -> tuple[str, ...]:
    """Names of the sheets: A, B, C, -A, -B, -C of Fig. 16.

    Examples
    --------
    >>> viz.sheet_names(6)
    ('A', 'B', 'C', '−A', '−B', '−C')
    """
    letters = "ABCDEFGHIJKLMNOPQRSTUVWXYZ"
    if degree % 2:
        return tuple(letters[:degree])
    return (*letters[: degree // 2], *(f"−{each}" for each in letters[: degree // 2]))


def sheet_arrows(
    cover: Cover, *, length: float, shown: Flags | None = None, width: float | None = None
) -> list[Arrows]:
    """Make arrows of the lifted field, one set for each sheet in its colour, with its name for the legend.

    Parameters
    ----------
    cover : whose field
    length : of an arrow
    shown : (N F',) faces of the cover that get an arrow, all by default
    width : of the shaft; a ninth of the length by default

    Examples
    --------
    >>> cover = gw.weave_field(gw.shapes.cone(faces=200)).cover
    >>> arrows = viz.sheet_arrows(cover, length=0.1)
    >>> sum(len(each.points) for each in arrows) == cover.mesh.n_faces
    True
    """
    vectors = length * cover.field.ambient
    keep = np.ones(cover.mesh.n_faces, dtype=bool) if shown is None else shown
    made = []
    for sheet, (colour, name) in enumerate(
        zip(sheet_colours(cover.degree), sheet_names(cover.degree), strict=True)
    ):
        own = keep & (cover.combed == sheet)
        # A rosette starts at the middle of its face.
        made.append(Arrows(cover.mesh.barycenters[own], vectors[own], colour, width or length / 9.0, name))
    return made


def family_lines(cover: Cover, curves: Curves, width: float = 1.6) -> list[Lines]:
    """Colour lines drawn on the cover by family; the family of a line changes at the cuts.

    Raises
    ------
    RenderError
        If the curves do not lie on the cover.

    Examples
    --------
    >>> field = gw.weave_field(gw.shapes.cone(faces=200))
    >>> curves = gw.streamlines(field.cover.field, separation=0.3)
    >>> [lines.label for lines in viz.family_lines(field.cover, curves)]
    ['A', 'B', 'C']
    """
    if curves.mesh is not cover.mesh:
        raise RenderError("the lines lie on another mesh than the cover's: draw them before projecting")
    families = cover.degree // 2 if cover.degree % 2 == 0 else cover.degree
    begin = np.flatnonzero(curves.following != np.arange(len(curves.points)))
    pieces = np.stack([curves.points[begin], curves.points[curves.following[begin]]], axis=1)
    family = cover.combed[curves.faces[begin]] % families
    names, colours = sheet_names(cover.degree), sheet_colours(cover.degree)
    return [Lines(pieces[family == k], colours[k], width, label=names[k]) for k in range(families)]


def cut_edges(cover: Cover) -> tuple[Indices, Indices]:
    """Find the branch cuts: the edges of the cover across which the number of the sheet changes.

    Returns
    -------
    edges : (n,) edges of the cover's mesh
    sheets : (n, 2) sheet of the face on either side, in the order of `TriMesh.edge_faces`

    Examples
    --------
    >>> cover = gw.weave_field(gw.shapes.cone(faces=200)).cover
    >>> edges, sheets = viz.cut_edges(cover)
    >>> bool((sheets[:, 0] != sheets[:, 1]).all())
    True
    """
    sheets = cover.combed[cover.mesh.edge_faces[cover.mesh.interior_edges]]
    torn = sheets[:, 0] != sheets[:, 1]
    return cover.mesh.interior_edges[torn], sheets[torn]


def spread(mesh: TriMesh, spacing: float) -> Indices:
    """Choose faces in their order, as many as fit, so that no two centres are closer than a distance."""
    middles = mesh.barycenters
    near, free, chosen = KDTree(middles), np.ones(len(middles), dtype=bool), []
    while free.any():
        face = int(free.argmax())
        chosen.append(face)
        free[near.query_ball_point(middles[face], spacing)] = False
    return np.array(chosen, dtype=np.int64)


def rosy_scene(
    rosy: RoSyField, view: View | str, *, spacing: float = 0.085, thickness: float = 0.0035
) -> Scene:
    """Draw an N-RoSy as rosettes, and its singularities as dots: warm if positive, blue if negative.

    Parameters
    ----------
    rosy : the N-RoSy
    view : where from, or the name of a model in `VIEWS`
    spacing, thickness : of the rosettes and radius of their bars, in bounding radii

    Examples
    --------
    >>> scene = viz.rosy_scene(gw.smoothest_rosy(gw.shapes.sphere(faces=320), degree=4), "sphere")
    >>> 0.9 < scene.aspect < 1.1
    True
    """
    scene, mesh = Scene(view_of(view)), rosy.mesh
    scene.add_surface(mesh, crease=35.0)
    radius = mesh.bounding_radius
    chosen = spread(mesh, spacing * radius)
    middle = mesh.barycenters[chosen] + 0.6 * thickness * radius * mesh.face_normals[chosen]
    values = rosy.vectors[chosen]
    along, aside = mesh.frames[chosen].swapaxes(0, 1)
    for k in range(rosy.degree):
        vector = values[:, k, None].real * along + values[:, k, None].imag * aside
        ends = np.stack([middle, middle + 0.36 * spacing * radius * vector], axis=1)
        scene.add_segments(ends, thickness * radius)
    scene.add_singularities(mesh.vertices, rosy.index_numerators, 0.026 * radius)
    return scene


def theta_scene(cover: Cover, foliation: Foliation, view: View | str, *, sheet: int = 0) -> Scene:
    """Draw theta on one sheet of a cover, laid on the surface below; its colours jump at the branch cuts.

    Parameters
    ----------
    cover : the cover
    foliation : of the cover; one of its quotient is lifted by `Quotient.lifted`
    view : where from, or the name of a model in `VIEWS`
    sheet : number of the sheet, as `Cover.combed` counts

    Raises
    ------
    RenderError
        If the foliation is not one of the cover.

    Examples
    --------
    >>> field = gw.weave_field(gw.shapes.torus(faces=400))
    >>> design = field.pattern(scale=0.8).design
    >>> theta = field.cover.quotient.lifted(design.foliation)
    >>> 1 < viz.theta_scene(field.cover, theta, "torus").aspect < 3
    True
    """
    if foliation.part.whole is not cover.mesh:
        raise RenderError("the foliation is not one of the cover: lift it from the quotient first")
    faces, corners = foliation.part.faces, angles_of_faces(foliation.circle)
    below = cover.rosy.mesh
    angles = np.full((below.n_faces, 3), np.nan)
    own = cover.combed[faces] == sheet
    angles[cover.faces[faces[own]]] = corners[own]
    scene = Scene(view_of(view))
    scene.add_periodic(below, angles)
    return scene


def stacked_sheets(
    cover: Cover, view: View, *, rise: float, flatten: float = 1.0, thickness: float = 0.012
) -> Scene:
    """Draw the sheets of a cover apart, one above the other, each with its vectors and its cuts (Fig. 17).

    A bar along each side of a cut has the colour of the sheet that this side is glued to.

    Parameters
    ----------
    cover : of a surface that spreads out in x and y
    view : where from
    rise : distance between sheets
    flatten : factor on heights within a sheet, so that sheets do not hide one another
    thickness : radius of the bars

    Examples
    --------
    >>> cover = gw.weave_field(gw.shapes.cone(faces=200)).cover
    >>> viz.stacked_sheets(cover, viz.View(), rise=2.0).aspect < 1
    True
    """
    scene, mesh, colours = Scene(view), cover.mesh, sheet_colours(cover.degree)
    lift, squeeze = np.array([0.0, 0.0, rise]), np.array([1.0, 1.0, flatten])
    middles = mesh.barycenters * squeeze
    for sheet, colour in enumerate(colours):
        own = np.flatnonzero(cover.combed == sheet)
        copy = part_of(mesh, cover.combed == sheet).mesh
        tint = _lighter(colour, 0.75)
        scene.add_surface(TriMesh(copy.vertices * squeeze + sheet * lift, copy.faces), colour=tint)
        vector = 0.5 * mesh.mean_edge * cover.field.ambient[own] * squeeze
        middle = middles[own] + sheet * lift + thickness * mesh.face_normals[own]
        scene.add_arrows(middle - 0.5 * vector, vector, colour)
    edges, sheets = cut_edges(cover)
    ends = mesh.vertices[mesh.edges[edges]] * squeeze
    for side in range(2):
        faces = mesh.edge_faces[edges, side]
        # A little way into the face that the bar belongs to.
        inwards = middles[faces] - ends.mean(axis=1)
        bars = ends + (0.12 * inwards)[:, None] + (sheets[:, side, None, None] * lift)
        for sheet, colour in enumerate(colours):
            scene.add_segments(bars[sheets[:, 1 - side] == sheet], thickness, colour)
    return scene


def _lighter(colour: str, white: float) -> str:
    """Mix a colour with a share of white."""
    red, green, blue = ((1.0 - white) * each + white for each in to_rgb(colour))
    return to_hex((red, green, blue))
