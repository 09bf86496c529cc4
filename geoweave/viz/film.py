"""Pictures that move: an animated PNG, which shows its first frame wherever it cannot move."""

from __future__ import annotations

import io
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from PIL import Image

from geoweave.errors import RenderError
from geoweave.viz.scene import Pixels, Scene

LARGEST = 900_000
"""Bytes that a film may take within a notebook."""

COLOURS = 64
"""Colours of all frames together: enough for shaded ribbons, and small."""


@dataclass(frozen=True, eq=False)
class Film:
    """Scenes one after the other, there and back again without an end.

    In a notebook it displays itself as an animated PNG (APNG). Elsewhere its first frame stands still.

    Attributes
    ----------
    scenes : the frames; each is drawn as large as the first, so that nothing jumps
    alt : one sentence that says what is to be seen
    height : of a frame, pixels
    step, rest : how long a frame is shown, and the last one, milliseconds
    """

    scenes: Sequence[Scene]
    alt: str
    height: int = 420
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
        """Encode the frames, there and back, with one palette; no date, no path.

        Raises
        ------
        RenderError
            If it gets larger than a notebook should hold.
        """
        drawn = self.frames()
        seen = np.concatenate([each[::3, ::3].reshape(-1, 3) for each in drawn])
        seen = seen[(seen < 255).any(axis=1)]
        palette = Image.fromarray(seen[None]).quantize(COLOURS - 1, method=Image.Quantize.MEDIANCUT)
        chosen = (palette.getpalette() or [])[: 3 * (COLOURS - 1)]
        colours = [*chosen, *[0] * (3 * (COLOURS - 1) - len(chosen)), 255, 255, 255]
        palette.putpalette(colours)
        images = []
        for each in drawn:
            index = np.array(Image.fromarray(each).quantize(palette=palette, dither=Image.Dither.NONE))
            index[(each == 255).all(axis=2)] = COLOURS - 1  # the ground stays white
            image = Image.fromarray(index)
            image.putpalette(colours)
            images.append(image)
        order = [*range(len(images)), *range(len(images) - 2, 0, -1)]
        times = [self.rest if k in (0, len(images) - 1) else self.step for k in order]
        buffer = io.BytesIO()
        first, *others = (images[k] for k in order)
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
