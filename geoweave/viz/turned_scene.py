"""A scene in a notebook, to be turned: one small page within a cell, which needs nothing but itself.

three.js would take 0.6 MB in every notebook. Faces and lines in one colour each point need none of it: the
page asks WebGL itself.
"""

from __future__ import annotations

import base64
import html
import json
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Protocol

import numpy as np
import pyvista as pv
from matplotlib import colormaps
from matplotlib.colors import LogNorm, Normalize, to_rgb
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from geoweave.checkout import PACKAGE
from geoweave.errors import RenderError
from geoweave.viz.picture import Picture
from geoweave.viz.scene import Scene

__all__ = ["Turned", "page_within", "turn"]

HEIGHT = 460
"""Of the page within a cell, pixels."""

FACES, POINTS = 14_000, 9_000
"""So many triangles of solids and points of lines a page holds at most; what has more is thinned out."""


class Staged(Protocol):
    """What can build its scene, such as a `Panel` or a `Woven`."""

    def scene(self) -> Scene:
        """Build the scene."""


@dataclass(frozen=True, eq=False)
class Turned:
    """A scene to be turned.

    In JupyterLab, and wherever pages within pages are shown, it displays itself as a page. Where these are
    taken out, as on GitHub, a line of text says so: the notebook's picture shows the same scene.

    Attributes
    ----------
    scene : what is shown
    title : what it is, for those who cannot see it
    detail : share of the triangles and points that a page holds otherwise
    """

    scene: Scene
    title: str
    detail: float = 1.0

    @cached_property
    def page(self) -> str:
        """The page, which needs nothing but itself; same scene, same text."""
        data = json.dumps(_content(self.scene, self.detail), separators=(",", ":"), allow_nan=False)
        template = (PACKAGE / "viz" / "turn.html").read_text(encoding="utf-8")
        # The content first: it holds no mark of the template, as a title may.
        filled = template.replace("@CONTENT@", data.replace("</", "<\\/"))
        return filled.replace("@TITLE@", html.escape(self.title))

    def _repr_mimebundle_(self, **_: Any) -> dict[str, Any]:
        frame = page_within(self.page, self.title, f"width:100%;height:{HEIGHT}px;border:0")
        return {
            "text/html": f"{frame}\n"
            "<p><small>In JupyterLab and on the site this view can be turned. Where it is not seen, the "
            "picture above shows the same.</small></p>",
            "text/plain": f"Turned({self.title!r})",
        }


def turn(what: Picture | Scene | Staged, panel: int = 0, *, title: str = "", detail: float = 1.0) -> Turned:
    """Show a scene in a notebook, to be turned with the mouse, a finger or the arrow keys.

    Parameters
    ----------
    what : a picture of scenes, of which one is turned; or a scene, or a panel of a gallery
    panel : which scene of the picture, from 0
    title : what it is, for those who cannot see it; by default what the picture says of itself
    detail : share of the triangles and points of a page, for a notebook that holds much else

    Returns
    -------
    What displays itself at the end of a cell.

    Raises
    ------
    RenderError
        If the picture has no such scene: charts and plates are flat.

    See Also
    --------
    show : a weave with its controls, as on the page of ``geoweave show``

    Examples
    --------
    >>> field = gw.smoothest_field(gw.shapes.sphere(faces=320))
    >>> panel = viz.Panel("smooth", gw.streamlines(field, separation=0.4))
    >>> "<title>a ball</title>" in viz.turn(panel, title="a ball").page
    True
    """
    if isinstance(what, Picture):
        if not -len(what.scenes) <= panel < len(what.scenes):
            raise RenderError(
                f"the picture has {len(what.scenes)} scenes, there is no scene {panel}; "
                "give a panel or a scene to turn"
            )
        return Turned(what.scenes[panel], title or what.alt, detail)
    if isinstance(what, Scene):
        return Turned(what, title or "a scene", detail)
    return Turned(what.scene(), title or str(getattr(what, "title", "")) or "a scene", detail)


def page_within(page: str, title: str, style: str) -> str:
    """A page within another one, as HTML of one line."""
    # Quotes alone would end the attribute; "<" may stand in it, and as "&lt;" would make it longer.
    held = page.replace("&", "&amp;").replace('"', "&quot;")
    return f'<iframe srcdoc="{held}" title="{html.escape(title)}" style="{style}"></iframe>'


def _content(scene: Scene, detail: float) -> dict[str, Any]:
    """What the page knows: faces and lines, in units of the largest distance from the middle.

    A surface that others show through is left out: from another side it would hide them.
    """
    solids: list[tuple[pv.PolyData, NDArray[np.uint8]]] = []
    threads: list[tuple[pv.PolyData, NDArray[np.uint8], float]] = []
    for actor in scene.actors():
        look, radius = actor.look, actor.radius
        data = actor.data if actor.lean is None else actor.lean
        # The dark edges of ribbons are lines of no thickness: a page has no place for so many.
        if look.get("opacity", 1.0) < 1.0 or (radius is None and not len(data.faces)):
            continue
        if radius is None:
            triangles = data.triangulate()
            solids.append((triangles, _colours(triangles, look)))
        else:
            threads.append((data, _colours(data, look), radius))
    if not solids:
        raise RenderError("the scene holds no surface: add one before it is turned")
    framed = np.concatenate(scene.framed())
    middle = 0.5 * (framed.min(axis=0) + framed.max(axis=0))
    if scene.focus is not None:
        middle = scene.placed(np.asarray(scene.focus[0], dtype=np.float64))
    points = np.concatenate(
        [data.points for data in [each[0] for each in solids] + [each[0] for each in threads]]
    )
    reach = float(np.linalg.norm(points - middle, axis=1).max())
    total = sum(data.n_cells for data, _ in solids)
    faces = []
    for data, colours in solids:
        thin, tint = _thinned(data, colours, detail * FACES / total)
        # At most three points a triangle: two bytes count them.
        used, index = np.unique(thin.regular_faces, return_inverse=True)
        faces.append(
            {
                "points": _steps(thin.points[used], middle, reach),
                "colours": _text(tint[used]),
                "faces": _text(index.ravel().astype("<u2")),
            }
        )
    lines = []
    count = sum(data.n_points for data, *_ in threads)
    for data, colours, radius in threads:
        order, counts = _fewer(data, detail * POINTS / max(count, 1))
        lines.append(
            {
                "points": _steps(data.points[order], middle, reach),
                "colours": _text(colours[order]),
                "counts": _text(counts.astype("<u4")),
                "radius": round(radius / reach, 5),
            }
        )
    axes = [[round(float(each), 6) for each in row] for row in scene.view.axes]
    return {"faces": faces, "lines": lines, "axes": axes}


def _colours(data: pv.PolyData, look: dict[str, Any]) -> NDArray[np.uint8]:
    """(P, 3) the colour of every point."""
    plain = np.broadcast_to(np.array(to_rgb(look.get("nan_color", look.get("color", "white")))), (1, 3))
    if "wheel" in look:
        turns, kind = data.active_texture_coordinates.T
        found = np.asarray(look["wheel"](turns % 1.0))[:, :3]
        found = np.where((kind < 0.5)[:, None], plain, found)
    elif "scalars" in look:
        held = data.point_data if look["scalars"] in data.point_data else None
        if held is None:
            data = data.cell_data_to_point_data()
        values = np.asarray(data.point_data[look["scalars"]], dtype=np.float64)
        low, high = look["clim"]
        scale = LogNorm(low, high, clip=True) if look.get("log_scale") else Normalize(low, high, clip=True)
        colormap = look["cmap"] if callable(look["cmap"]) else colormaps[look["cmap"]]
        found = np.asarray(colormap(np.asarray(scale(np.nan_to_num(values, nan=high)))))[:, :3]
        found = np.where(np.isfinite(values)[:, None], found, plain)
    else:
        found = np.repeat(plain, data.n_points, axis=0)
    return np.rint(255.0 * found).astype(np.uint8)


def _thinned(
    data: pv.PolyData, colours: NDArray[np.uint8], share: float
) -> tuple[pv.PolyData, NDArray[np.uint8]]:
    """The same with a share of its triangles; each point has the colour of the nearest one before."""
    if share >= 1.0 or data.n_cells < 100:
        return data, colours
    bare = pv.PolyData(data.points, data.faces)
    fewer = bare.decimate(1.0 - share)
    if not fewer.n_cells:
        return data, colours
    return fewer, colours[cKDTree(data.points).query(fewer.points)[1]]


def _fewer(data: pv.PolyData, share: float) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Points of lines to keep, line by line, and how many each line has; ends are kept."""
    step, kept, counts, at = max(1, int(np.ceil(1.0 / share))), [], [], 0
    cells = np.asarray(data.lines)
    while at < len(cells):
        line = cells[at + 1 : at + 1 + cells[at]]
        at += 1 + int(cells[at])
        chosen = line[np.unique(np.append(np.arange(0, len(line), step), len(line) - 1))]
        kept.append(chosen)
        counts.append(len(chosen))
    return np.concatenate(kept).astype(np.int64), np.array(counts)


def _steps(points: NDArray[Any], middle: NDArray[Any], reach: float) -> str:
    return _text(np.rint(32767.0 * (np.asarray(points, dtype=np.float64) - middle) / reach).astype("<i2"))


def _text(values: NDArray[Any]) -> str:
    return base64.b64encode(np.ascontiguousarray(values).tobytes()).decode("ascii")
