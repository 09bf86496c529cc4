"""A finished figure: a matplotlib figure that turns into the same bytes every time."""

from __future__ import annotations

import io
import os
import platform
import sys
import tempfile
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

import click
import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.colors import Colormap
from matplotlib.figure import Figure
from numpy.typing import NDArray
from PIL import Image

from geoweave.errors import RenderError
from geoweave.viz import style

if TYPE_CHECKING:
    from geoweave.viz.scene import Scene

COLOURS = 256
"""Colours in the palette of a picture within a notebook; a published one has them all, in twice the bytes."""

INLINE_WIDTH, INLINE_BYTES = 1100, 200_000
"""Pixels across, and size, of a picture within a notebook."""


@dataclass(frozen=True, eq=False)
class Picture:
    """A figure ready to be shown or published.

    In a notebook it displays itself as a PNG of reduced size, with a palette.

    Attributes
    ----------
    figure : matplotlib figure, at the resolution it is published in
    alt : one sentence that says what is to be seen, for those who cannot see it
    colormaps : maps shown as bars, whose steps the palette must hold
    scenes : what is drawn in space, panel by panel, for `turn`
    """

    figure: Figure
    alt: str = ""
    colormaps: tuple[Colormap, ...] = ()
    scenes: tuple[Scene, ...] = ()

    @cached_property
    def pixels(self) -> NDArray[np.uint8]:
        """(height, width, 3) uint8: the figure at full size and in full colour."""
        with style.applied():
            canvas: Any = FigureCanvasAgg(self.figure)
            canvas.draw()
            pixels: NDArray[np.uint8] = np.asarray(canvas.buffer_rgba())[..., :3].copy()
            return pixels

    def png(self, width: int | None = None, *, palette: bool = False) -> bytes:
        """Encode as a PNG, at most ``width`` pixels wide; no date, no version, no path.

        Every pixel keeps its colour; with a ``palette`` it gets one of 256, in about half the bytes.
        """
        image = Image.fromarray(self.pixels)
        if width is not None and width < image.width:
            image = image.resize((width, round(image.height * width / image.width)), Image.Resampling.LANCZOS)
        if palette:
            chosen = self._palette(image)
            image = with_palette(np.asarray(image), chosen, COLOURS, Image.Dither.FLOYDSTEINBERG)
        buffer = io.BytesIO()
        image.save(buffer, format="PNG", optimize=True)
        return buffer.getvalue()

    def png_within(self, limit: int, width: int | None = None, *, palette: bool = False) -> bytes:
        """Encode as large as fits into ``limit`` bytes, in steps of a twentieth of the width or more."""
        full = min(width or self.pixels.shape[1], self.pixels.shape[1])
        now = full
        while now >= full // 5:
            encoded = self.png(now, palette=palette)
            if len(encoded) <= limit:
                return encoded
            # Bytes grow with the area, but slower: this is seldom too small.
            now = min(now - max(1, full // 20), int(now * (limit / len(encoded)) ** 0.5))
        raise RenderError(f"the figure does not fit into {limit:,} bytes even at a fifth of its size")

    def show(self) -> None:
        """Show the picture: below the cell in a notebook, elsewhere as a PNG in a viewer.

        Outside a notebook the PNG goes to the folder of temporary files and its path is printed. If there is
        a screen, the system's viewer of pictures opens it.

        Examples
        --------
        >>> viz.drop_chart([viz.Drop("Cow", 20.0, 7.0)]).show()  # doctest: +SKIP
        the picture is in /tmp/geoweave-1f2e3d4c.png
        """
        if _in_notebook():
            from IPython.display import display

            display(self)  # type: ignore[no-untyped-call]
            return
        with tempfile.NamedTemporaryFile(prefix="geoweave-", suffix=".png", delete=False) as file:
            file.write(self.png())
        print(f"the picture is in {file.name}")
        if _has_screen():
            click.launch(file.name)

    def _palette(self, image: Image.Image) -> Image.Image:
        """Choose colours by what the picture holds, with a place for every step of its colour bars.

        White keeps a place of its own, so that the ground stays exactly white.
        """
        seen = np.asarray(image)[::2, ::2].reshape(-1, 3)
        seen = seen[(seen < 255).any(axis=1)]
        if self.colormaps:
            steps = [
                np.rint(255 * each(np.linspace(0, 1, 48))[:, :3]).astype(np.uint8) for each in self.colormaps
            ]
            ramp = np.concatenate(steps)
            times = max(1, len(seen) // (2 * len(ramp)))
            seen = np.concatenate([seen, np.repeat(ramp, times, axis=0)])
        if not len(seen):
            seen = np.zeros((1, 3), dtype=np.uint8)
        return palette_of(seen, COLOURS)

    def _repr_mimebundle_(self, **_: Any) -> dict[str, Any]:
        return {
            "image/png": self.png_within(INLINE_BYTES, INLINE_WIDTH, palette=True),
            "text/plain": f"Picture({self.alt!r})",
        }


def palette_of(seen: NDArray[np.uint8], count: int) -> Image.Image:
    """Choose so many colours for the colours (N, 3) that are seen; the last one is white."""
    palette = Image.fromarray(seen[None]).quantize(count - 1, method=Image.Quantize.MEDIANCUT)
    chosen = (palette.getpalette() or [])[: 3 * (count - 1)]
    palette.putpalette([*chosen, *[0] * (3 * (count - 1) - len(chosen)), 255, 255, 255])
    return palette


def with_palette(
    pixels: NDArray[np.uint8], palette: Image.Image, count: int, dither: Image.Dither
) -> Image.Image:
    """Give every pixel a colour of a palette; white stays white, the last of its colours."""
    index = np.array(Image.fromarray(pixels).quantize(palette=palette, dither=dither))
    # Pillow looks colours up in steps of eight, and so takes an off-white for white.
    index[(pixels == 255).all(axis=2)] = count - 1
    held = Image.fromarray(index)
    held.putpalette(palette.getpalette() or [])
    return held


def sheet(width: int, height: int) -> Figure:
    """Make an empty white figure of a size in pixels, which draws nothing by itself."""
    with style.applied():
        return Figure(figsize=(width / style.DPI, height / style.DPI), dpi=style.DPI)


def _in_notebook() -> bool:
    """Whether this runs in a kernel, which can show pictures; IPython in a terminal cannot."""
    ipython = sys.modules.get("IPython")
    shell = None if ipython is None else ipython.get_ipython()
    return hasattr(shell, "kernel")


def _has_screen() -> bool:
    if platform.system() == "Linux":
        return bool(os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY"))
    return True
