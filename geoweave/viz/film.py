"""Pictures that move: an animated PNG, which shows its first frame wherever it cannot move."""

from __future__ import annotations

import io
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from PIL import Image

from geoweave.arrays import Indices
from geoweave.errors import RenderError
from geoweave.rods import Rods
from geoweave.surface import TriMesh
from geoweave.viz.picture import palette_of, with_palette
from geoweave.viz.rods import Sprung
from geoweave.viz.scene import Scene
from geoweave.viz.shot import Pixels
from geoweave.viz.views import View

LARGEST = 300_000
"""Bytes that a film may take within a notebook."""

COLOURS = 48
"""Colours of all frames together: enough for shaded ribbons, and small."""


@dataclass(frozen=True, eq=False)
class Film:
    """Scenes one after the other, again and again.

    In a notebook it displays itself as an animated PNG (APNG). Elsewhere its first frame stands still.

    Attributes
    ----------
    scenes : the frames; each is drawn as large as the first, so that nothing jumps
    alt : one sentence that says what is to be seen
    height : of a frame, pixels
    step, rest : how long a frame is shown, and the first and the last one, milliseconds
    """

    scenes: Sequence[Scene]
    alt: str
    height: int = 320
    step: int = 160
    rest: int = 1200

    def frames(self) -> list[Pixels]:
        """Draw the scenes.

        Raises
        ------
        RenderError
            If there are fewer than two.
        """
        if len(self.scenes) < 2:
            raise RenderError("a film needs two frames or more")
        width = max(8, round(self.height * self.scenes[0].aspect))
        return [scene.draw(self.height, width=width) for scene in self.scenes]

    def apng(self) -> bytes:
        """Encode the frames with one palette; no date, no path.

        Raises
        ------
        RenderError
            If it gets larger than a notebook should hold.
        """
        drawn = self.frames()
        seen = np.concatenate([each[::3, ::3].reshape(-1, 3) for each in drawn])
        seen = seen[(seen < 255).any(axis=1)]
        palette = palette_of(seen, COLOURS)
        images = [with_palette(each, palette, COLOURS, Image.Dither.NONE) for each in drawn]
        times = [self.rest if k in (0, len(images) - 1) else self.step for k in range(len(images))]
        buffer = io.BytesIO()
        first, *others = images
        first.save(
            buffer, format="PNG", save_all=True, append_images=others, duration=times, loop=0, optimize=True
        )
        if buffer.tell() > LARGEST:
            raise RenderError(
                f"the film takes {buffer.tell():,} bytes, more than {LARGEST:,}; make it smaller or shorter"
            )
        return buffer.getvalue()

    def _repr_mimebundle_(self, **_: Any) -> dict[str, Any]:
        return {"image/png": self.apng(), "text/plain": f"Film({self.alt!r})"}


def relaxing(
    states: Sequence[Rods],
    target: TriMesh,
    view: View | str,
    hues: Indices | None = None,
    *,
    frames: int = 8,
    times: float = 2.0,
    alt: str = "",
) -> Film:
    """Film how rods come to rest: early steps, which move most, get most frames.

    Parameters
    ----------
    states : the rods, from the first to the last
    target : the surface they were designed on, drawn as a veil
    view : where from, or the name of a model in `VIEWS`
    hues : (R,) colour of each rod
    frames : how many states are drawn
    times : factor that exaggerates the distance of each vertex from the first state
    alt : one sentence that says what is to be seen

    Raises
    ------
    RenderError
        If there are fewer than two states.

    Examples
    --------
    >>> surface = gw.shapes.cone(faces=400)
    >>> rods = gw.elastic_rods(gw.weave_pattern(surface, ribbons=8)).rods
    >>> film = viz.relaxing([rods, rods, rods], surface, "cone", frames=3)
    >>> len(film.scenes)
    3
    """
    if len(states) < 2:
        raise RenderError("a film needs two states or more")
    picked = np.unique(np.rint(np.geomspace(1, len(states), frames)).astype(int)) - 1
    first = states[0].points
    middle = 0.5 * (target.vertices.min(axis=0) + target.vertices.max(axis=0))
    reach = 1.05 * float(np.linalg.norm(target.vertices - middle, axis=1).max())
    scenes = [
        Sprung(
            replace(states[k], points=first + times * (states[k].points - first)),
            target,
            view=view,
            hues=hues,
            opacity=0.35,
            focus=(tuple(middle), reach),
        ).scene()
        for k in picked
    ]
    return Film(scenes, alt or f"A weave comes to rest, its motion {times:g} times as large as it is")
