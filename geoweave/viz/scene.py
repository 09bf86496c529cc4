"""One rendered view of a surface with curves and singularities on it, as an array of pixels."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import pyvista as pv
from matplotlib.colors import Colormap, to_rgb
from numpy.typing import NDArray
from PIL import Image, ImageFilter

from geoweave.arrays import Indices, Scalars, Vectors
from geoweave.curves import Curves
from geoweave.errors import RenderError
from geoweave.surface import Similarity, TriMesh
from geoweave.viz import style
from geoweave.viz.shot import Actor, Camera, Pixels, shot
from geoweave.viz.views import View

SUPERSAMPLING = 2
"""Pictures are rendered this much larger in both directions and averaged down."""

MARGIN = 0.03
"""White border of a picture, as a share of the longer side of the model."""

OCCLUSION_RADIUS = 0.08
"""Radius of ambient occlusion, as a share of the diagonal of the model's box."""

OCCLUSION_OPEN = 0.96
"""Share of directions that nothing blocks, above which a point has no shade.

The renderer finds a little shade everywhere.
"""

OCCLUSION_STRENGTH = 1.5
"""Exponent on the share of directions that nothing blocks."""

OCCLUSION_BLUR = 0.002
"""Blur of the occlusion, as a share of the height of the picture."""

EDGE = 1.0
"""Width of the edges of a solid, pixels; where two of one colour cross, only their edges tell them apart."""


@dataclass
class Scene:
    """A surface and what lies on it, ready to be drawn from one view.

    ``draw`` frames the surface tightly: the picture's aspect is that of the projected model, and a margin on
    every side stays white. With a ``focus``, a place and a radius, the picture is a square round that place.
    """

    view: View = field(default_factory=View)
    focus: tuple[Sequence[float], float] | None = None
    _actors: list[Actor] = field(default_factory=list)
    _points: list[Vectors] = field(default_factory=list)
    _placement: Similarity | None = None

    # -- what is in it ----------------------------------------------------------------------------------

    def add_surface(
        self,
        mesh: TriMesh,
        *,
        values: Scalars | None = None,
        limit: float | None = None,
        limits: tuple[float, float] | None = None,
        log: bool = False,
        colormap: Colormap | None = None,
        colour: str = style.SURFACE,
        crease: float = 80.0,
        opacity: float = 1.0,
        behind: bool = False,
    ) -> None:
        """Add the surface, smooth but for creases sharper than ``crease`` degrees.

        ``values`` are shown, (F,) one colour a face or (V,) joined over the faces, on the diverging map from
        ``-limit`` to ``limit`` or on the given map between ``limits`` (equal ratios equally far apart if
        ``log``); what is not a number has the plain ``colour``. With an ``opacity`` below 1 what lies behind
        it shows through; if ``behind``, only its far side is drawn, and lies on nothing.
        """
        if self._placement is None:
            # The renderer's depths and radii have absolute tolerances: it gets models of one size only.
            self._placement = mesh.normalized()[1]
        placed = self._placement.apply(mesh.vertices)
        soup = pv.PolyData(placed, np.insert(mesh.faces, 0, 3, axis=1).ravel())
        look: dict[str, Any] = {"color": colour}
        if values is not None:
            held = soup.cell_data if len(values) == mesh.n_faces else soup.point_data
            held["values"] = values
            reach = float(np.nanmax(np.abs(values))) if limit is None else limit
            look = {"scalars": "values", "cmap": colormap or style.diverging(), "nan_color": colour}
            look["clim"] = limits or (-reach, reach)
            look["log_scale"] = log
        soup = soup.compute_normals(
            cell_normals=False, split_vertices=True, feature_angle=crease, consistent_normals=False
        )
        look |= {"ambient": 0.30, "diffuse": 0.74, "specular": 0.08, "specular_power": 10.0, "occludes": True}
        look |= {"culling": "front"} if behind else {}
        if opacity < 1.0:
            # A transparent surface casts no shade on what lies behind it.
            look |= {"opacity": opacity, "occludes": False}
        self._actors.append(Actor(soup, look))
        self._points.append(placed)

    def add_periodic(
        self,
        mesh: TriMesh,
        angles: Scalars,
        *,
        colormap: Colormap | None = None,
        colour: str = style.SURFACE,
        crease: float = 80.0,
    ) -> None:
        """Add a surface in the colours of angles that grow linearly over each face and may pass full turns.

        ``angles`` (F, 3) at the corners of each face, radians, of which neighbours need to agree only up to
        full turns; a face with an angle that is not a number has the plain ``colour``.
        """
        if self._placement is None:
            self._placement = mesh.normalized()[1]
        placed = self._placement.apply(mesh.vertices)
        smooth = pv.PolyData(placed, np.insert(mesh.faces, 0, 3, axis=1).ravel()).compute_normals(
            cell_normals=False, split_vertices=True, feature_angle=crease, consistent_normals=False
        )
        corners = smooth.regular_faces.ravel()
        soup = pv.PolyData(
            smooth.points[corners], np.insert(np.arange(len(corners)).reshape(-1, 3), 0, 3, axis=1).ravel()
        )
        soup.point_data.active_normals = smooth.point_data.active_normals[corners]
        plain = np.repeat(~np.isfinite(angles).all(axis=1), 3)
        turns = np.where(plain, 0.0, angles.ravel() / (2.0 * np.pi))
        soup.active_texture_coordinates = np.stack([turns, np.where(plain, 0.25, 0.75)], axis=1)
        wheel = colormap or style.cyclic()
        look: dict[str, Any] = {"texture": _wheel(wheel, colour), "color": "white", "wheel": wheel}
        look |= {"ambient": 0.30, "diffuse": 0.74, "specular": 0.08, "specular_power": 10.0, "occludes": True}
        self._actors.append(Actor(soup, look))
        self._points.append(placed)

    def add_curves(
        self,
        curves: Curves,
        radius: float,
        *,
        values: Scalars | None = None,
        limits: tuple[float, float] = (0.0, 1.0),
        colormap: Colormap | None = None,
        colour: str = style.INK,
    ) -> None:
        """Add curves as round tubes of a radius, coloured by ``values`` (P,) at their points if given."""
        owner, lines = _joined(curves)
        placement = self._placed()
        # Half sunk into the surface, a tube would flicker where the facets are coarse.
        lifted = curves.points[owner] + 0.35 * radius * curves.normals[owner]
        thread = pv.PolyData(placement.apply(lifted), lines=lines)
        look: dict[str, Any] = {"color": colour}
        if values is not None:
            thread.point_data["values"] = values[owner]
            look = {"scalars": "values", "cmap": colormap or style.sequential(), "clim": limits}
        tubes = thread.tube(radius=radius / placement.scale, n_sides=8)
        look |= {"ambient": 0.45, "diffuse": 0.60, "specular": 0.05}
        self._actors.append(Actor(tubes, look, thread, radius / placement.scale))

    def add_segments(self, ends: Vectors, radius: float, colour: str = style.INK) -> None:
        """Add straight bars between pairs of points, ``ends`` (N, 2, 3), such as the edges of the mesh."""
        placement = self._placed()
        count = len(ends)
        lines = np.insert(np.arange(2 * count).reshape(-1, 2), 0, 2, axis=1).ravel()
        bars = pv.PolyData(placement.apply(ends.reshape(-1, 3)), lines=lines)
        look = {"color": colour, "ambient": 0.45, "diffuse": 0.60, "specular": 0.05}
        radius /= placement.scale
        self._actors.append(Actor(bars.tube(radius=radius, n_sides=6), look, bars, radius))

    def add_arrows(self, points: Vectors, vectors: Vectors, colour: str) -> None:
        """Add solid arrows from points (N, 3) along vectors (N, 3), as long as these."""
        placement = self._placed()
        shafts = pv.PolyData(placement.apply(points))
        shafts.point_data["vectors"] = vectors / placement.scale
        arrow = pv.Arrow(tip_length=0.36, tip_radius=0.13, shaft_radius=0.05, tip_resolution=16)
        glyphs = shafts.glyph(orient="vectors", scale="vectors", factor=1.0, geom=arrow)
        self._actors.append(Actor(glyphs, {"color": colour, "ambient": 0.45, "diffuse": 0.6}))

    def add_solid(
        self,
        points: Vectors,
        quads: NDArray[np.int64],
        colour: str = style.INK,
        *,
        values: Scalars | None = None,
        limits: tuple[float, float] = (0.0, 1.0),
        colormap: Colormap | None = None,
        framed: bool = False,
    ) -> None:
        """Add quadrilaterals (Q, 4) with sharp edges, such as the outside of ribbons.

        They have one colour, or that of ``values`` (P,) at their points. If ``framed``, the picture makes
        room for them; if not, they lie on the surface, for which it does.
        """
        placed = self._placed().apply(points)
        solid = pv.PolyData(placed, np.insert(quads, 0, 4, axis=1).ravel())
        look: dict[str, Any] = {"color": colour}
        if values is not None:
            solid.point_data["values"] = values
            look = {"scalars": "values", "cmap": colormap or style.sequential(), "clim": limits}
        shaded = solid.compute_normals(cell_normals=False, split_vertices=True, feature_angle=40.0)
        look |= {"ambient": 0.32, "diffuse": 0.70, "specular": 0.06, "occludes": True}
        self._actors.append(Actor(shaded, look))
        if values is None:
            edges = solid.extract_feature_edges(
                feature_angle=60.0, boundary_edges=False, non_manifold_edges=False, manifold_edges=False
            )
            line = {"color": style.darker(colour), "line_width": EDGE * SUPERSAMPLING, "lighting": False}
            self._actors.append(Actor(edges, line))
        if framed:
            self._points.append(placed)

    def add_dots(self, points: Vectors, radius: float, colours: Sequence[str]) -> None:
        """Add small balls, one colour each."""
        placement = self._placed()
        ball = pv.Sphere(radius=radius / placement.scale, theta_resolution=24, phi_resolution=24)
        for colour in sorted(set(colours)):
            centres = placement.apply(points[np.array([each == colour for each in colours])])
            balls = pv.PolyData(centres).glyph(geom=ball, scale=False, orient=False)
            coarse = pv.Sphere(radius=radius / placement.scale, theta_resolution=8, phi_resolution=6)
            lean = pv.PolyData(centres).glyph(geom=coarse, scale=False, orient=False)
            look = {"color": colour, "ambient": 0.35, "diffuse": 0.7, "specular": 0.2}
            self._actors.append(Actor(balls, look, lean))

    def add_singularities(self, vertices: Vectors, indices: Indices, radius: float) -> None:
        """Add a dot at each vertex of index (V,) other than 0: warm where positive, blue where negative."""
        marked = np.flatnonzero(indices)
        colours = [style.SOURCE if indices[v] > 0 else style.SADDLE for v in marked]
        self.add_dots(vertices[marked], radius, colours)

    def actors(self) -> list[Actor]:
        """What is drawn and how it looks."""
        return self._actors

    def framed(self) -> list[Vectors]:
        """Points that the picture makes room for, as they are placed."""
        return self._points

    def placed(self, points: Vectors) -> Vectors:
        """Put points where the renderer has them."""
        return self._placed().apply(points)

    def _placed(self) -> Similarity:
        if self._placement is None:
            raise RenderError("the scene holds no surface: add one before what lies on it")
        return self._placement

    # -- what it looks like -----------------------------------------------------------------------------

    @property
    def aspect(self) -> float:
        """Width of the framed picture over its height."""
        return self._frame()[2]

    def draw(self, height: int, *, width: int | None = None) -> Pixels:
        """Render at a height in pixels; the width follows from the model unless given (then it is centred).

        Returns
        -------
        (height, width, 3) uint8 on white.

        Raises
        ------
        RenderError
            If the renderer returns nothing but background.
        """
        centre, distance, aspect, half = self._frame()
        if width is None:
            width = max(8, round(height * aspect))
        # A picture narrower than the model would clip it: open the lens until the width fits.
        half *= max(1.0, aspect * height / width)
        camera = Camera(self.view.axes, centre, distance, half)
        extent = max(float(np.linalg.norm(np.ptp(p, axis=0))) for p in self._points)
        picture = shot(self._actors, camera, extent, (SUPERSAMPLING * width, SUPERSAMPLING * height))
        if (picture == 255).all():
            raise RenderError("the renderer drew nothing: run 'geoweave doctor' to see what it needs")
        small = Image.fromarray(picture).resize((width, height), Image.Resampling.BOX)
        # Occlusion by the surface alone: threads are too thin to cast shade, and would only make noise.
        white = {"color": "white", "ambient": 0.98, "diffuse": 0.02}
        surfaces = [Actor(each.data, white) for each in self._actors if each.look.get("occludes")]
        shade = shot(surfaces, camera, extent, (width, height), occlusion=OCCLUSION_RADIUS * extent)
        soft = Image.fromarray(shade).filter(ImageFilter.GaussianBlur(OCCLUSION_BLUR * height))
        light = np.minimum(1.0, np.asarray(soft) / (255.0 * OCCLUSION_OPEN)) ** OCCLUSION_STRENGTH
        lit = np.asarray(small)
        light[(lit == 255).all(axis=2)] = 1.0
        return np.rint(lit * light).astype(np.uint8)

    def _frame(self) -> tuple[Vectors, float, float, float]:
        """Centre, distance of the eye, aspect, and half height of the picture at the centre.

        The eye is moved sideways until the perspective picture of the points lies centred, which takes a few
        rounds since its bounds move too.
        """
        if not self._points:
            raise RenderError("the scene holds no surface: add one before drawing")
        points = np.concatenate(self._points)
        axes = self.view.axes
        centre = 0.5 * (points.min(axis=0) + points.max(axis=0))
        radius = float(np.linalg.norm(points - centre, axis=1).max())
        distance = radius / np.sin(np.radians(0.5 * self.view.opening))
        half = np.ones(2)
        for _ in range(8):
            seen = (points - centre) @ axes.T
            plane = seen[:, :2] * (distance / (distance - seen[:, 2:]))
            low, high = plane.min(axis=0), plane.max(axis=0)
            half = 0.5 * (high - low)
            centre = centre + 0.5 * (low + high) @ axes[:2]
        if self.focus is not None:
            place, reach = np.asarray(self.focus[0], dtype=np.float64), self.focus[1]
            placement = self._placed()
            # The eye stays as far away as it is from the whole; the lens closes.
            return placement.apply(place), distance, 1.0, reach / placement.scale
        # What lies on the surface sticks out a little: the margin also covers it.
        half = half + 2.0 * MARGIN * half.max()
        return centre, distance, float(half[0] / half[1]), float(half[1])


def _joined(curves: Curves) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Curve points to draw, and VTK's list of lines over them; closed curves come back to their start.

    Points closer than a hundredth of a mean edge to the one before are left out: a tube needs a direction.
    """
    arc, least = curves.arclength, 0.01 * curves.mesh.mean_edge
    owners, cells, total = [], [], 0
    for c in range(len(curves)):
        own = np.arange(curves.offsets[c], curves.offsets[c + 1])
        own = own[np.concatenate([[True], np.diff(np.floor(arc[own] / least)) > 0])]
        if curves.closed[c]:
            own = np.append(own, own[0])
        if len(own) > 1:
            owners.append(own)
            cells.append(np.concatenate([[len(own)], total + np.arange(len(own))]))
            total += len(own)
    return np.concatenate(owners), np.concatenate(cells)


def _wheel(colormap: Colormap, colour: str) -> pv.Texture:
    """Make a texture that repeats to the right: the upper half the map, the lower half one colour."""
    ramp = np.asarray(colormap((np.arange(1024) + 0.5) / 1024.0))[:, :3]
    plain = np.broadcast_to(to_rgb(colour), ramp.shape)
    image = np.rint(255.0 * np.concatenate([np.tile(ramp, (8, 1, 1)), np.tile(plain, (8, 1, 1))]))
    texture = pv.Texture(image.astype(np.uint8))
    texture.repeat, texture.interpolate = True, True
    return texture
