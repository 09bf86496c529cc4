"""What is drawn of a scene, and one rendering of it by a camera under four lights."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
import pyvista as pv
from numpy.typing import NDArray

from geoweave.arrays import Vectors
from geoweave.viz import style

__all__ = ["Actor", "Camera", "Pixels", "shot"]

Pixels = NDArray[np.uint8]
"""(height, width, 3) uint8."""


class Actor(NamedTuple):
    """One thing that is drawn."""

    data: pv.PolyData
    """Its faces and lines, where the renderer has them."""
    look: dict[str, Any]
    """What pyvista is told of it; also "occludes", if it casts shade, and "wheel", the colours of angles."""
    lean: pv.PolyData | None = None
    """The same with less in it, for a page: the lines that tubes are drawn round, coarser balls."""
    radius: float | None = None
    """Of the tubes round these lines."""


class Camera(NamedTuple):
    """Where a picture is taken from."""

    axes: Vectors
    """(3, 3) to the right, up, and towards the eye."""
    centre: Vectors
    """(3,) what it looks at."""
    distance: float
    """Of the eye from there."""
    half: float
    """Half the height of what is seen there."""


def shot(
    actors: Sequence[Actor],
    camera: Camera,
    extent: float,
    size: tuple[int, int],
    occlusion: float = 0.0,
) -> Pixels:
    """Render once; with ``occlusion`` > 0 the renderer darkens what is hidden within that radius."""
    plotter = pv.Plotter(
        off_screen=True, window_size=list(size), lighting="none", theme=pv.themes.DocumentTheme()
    )
    plotter.background_color = style.GROUND
    for actor in actors:
        options = {name: value for name, value in actor.look.items() if name not in ("occludes", "wheel")}
        plotter.add_mesh(actor.data, smooth_shading=True, show_scalar_bar=False, copy_mesh=False, **options)
    right, up, eye = camera.axes
    # A key light over the left shoulder, a soft fill from the right and from the eye, a weak rim from behind.
    for direction, intensity, colour in (
        (-0.6 * right + 0.8 * up + 1.0 * eye, 0.68, "#fffaf2"),
        (eye, 0.18, "#ffffff"),
        (1.0 * right + 0.1 * up + 0.9 * eye, 0.36, "#fdf8f0"),
        (0.2 * right + 0.9 * up - 1.0 * eye, 0.20, "#ffffff"),
    ):
        light = pv.Light(position=direction, focal_point=(0, 0, 0), color=colour, intensity=intensity)
        plotter.add_light(light)
    plotter.camera.position = camera.centre + camera.distance * eye
    plotter.camera.focal_point = camera.centre
    plotter.camera.up = up
    plotter.camera.view_angle = np.degrees(2.0 * np.arctan(camera.half / camera.distance))
    plotter.camera.clipping_range = (camera.distance - extent, camera.distance + extent)
    if occlusion > 0.0:
        plotter.enable_ssao(radius=occlusion, bias=0.08 * occlusion, kernel_size=128, blur=True)
    picture = np.asarray(plotter.screenshot(return_img=True))[..., :3]
    plotter.close()
    return np.ascontiguousarray(picture)
