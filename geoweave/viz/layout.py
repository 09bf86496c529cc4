"""Where rendered pixels and the words under them go on a sheet; every gallery is laid out here."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

import numpy as np
from matplotlib.colors import Colormap, ListedColormap, to_rgb
from matplotlib.figure import Figure

from geoweave.errors import RenderError
from geoweave.viz import style
from geoweave.viz.picture import Picture, sheet
from geoweave.viz.scene import Scene
from geoweave.viz.shot import Pixels

SIDE, GAP, TITLE, SUBTITLE = 34, 50, 58, 40
"""Pixels of a full-width figure: its border, between panels, for each line of words under one."""

SHADES = (0.45, 0.65, 0.85, 1.0)
"""How dark an accent gets where light falls on it aslant; each shade has its place in the palette."""


class Drawable(Protocol):
    """What a gallery can show: a `Scene`, or a `Page` of a pattern."""

    @property
    def aspect(self) -> float:
        """Width over height."""

    def draw(self, height: int) -> Pixels:
        """Draw it this many pixels tall."""


def place(figure: Figure, pixels: Pixels, left: float, top: float) -> None:
    """Put pixels on a figure without resampling, ``left`` and ``top`` from its upper left corner."""
    width, height = round(figure.bbox.width), round(figure.bbox.height)
    rows, columns = pixels.shape[:2]
    box = (round(left) / width, 1 - (round(top) + rows) / height, columns / width, rows / height)
    axes = figure.add_axes(box)
    axes.imshow(pixels, interpolation="none", aspect="auto")
    axes.set_axis_off()


def caption(figure: Figure, words: tuple[str, str], middle: float, top: float, unit: float) -> None:
    """Write title and subtitle, centred at a share of the width, under a picture that ends at ``top``."""
    height = round(figure.bbox.height)
    for text, below, size, colour in ((words[0], 14, 11.5, style.INK), (words[1], 62, 9.0, style.FAINT)):
        where = 1.0 - (top + unit * below) / height
        figure.text(middle, where, text, ha="center", va="top", size=unit * size, color=colour)


def grid(
    scenes: Sequence[Drawable],
    words: Sequence[tuple[str, str]],
    *,
    columns: int | None,
    width: int,
    tallest: int,
    foot: float,
    gap: float = GAP,
    equal_columns: bool = True,
    filling: bool = False,
) -> Figure:
    """Draw scenes in rows, models of a row equally tall, and leave room at the bottom.

    Parameters
    ----------
    scenes : what to draw; the order is kept
    words : title and subtitle of each
    columns : scenes in a row; all in one row if None
    width : pixels across the figure; a narrower one is the same figure, smaller
    tallest, foot, gap : height that no scene exceeds, room below, room between, in pixels at full width
    equal_columns : whether all columns are equally wide; if not, a scene takes the width it needs, and what
        is left of the row is shared out between its scenes
    filling : whether each scene fills a square as wide as its column; if not, scenes of a row have one height

    Raises
    ------
    RenderError
        If there is nothing to draw.
    """
    if not scenes:
        raise RenderError("a gallery needs at least one panel")
    per_row, unit = columns or len(scenes), width / style.WIDTH
    inside = width - unit * (2 * SIDE + gap * (per_row - 1))
    cell = inside / per_row
    rows = [range(start, min(start + per_row, len(scenes))) for start in range(0, len(scenes), per_row)]
    heights = []
    for row in rows:
        if filling:
            fitting = int(max(cell * min(1.0, 1.0 / scenes[k].aspect) for k in row))
        elif equal_columns:
            fitting = min(int(cell / scenes[k].aspect) for k in row)
        else:
            # A last row with fewer panels is no taller than a full one.
            fitting = int(inside / (sum(scenes[k].aspect for k in row) * per_row / len(row)))
        heights.append(min(round(unit * tallest), fitting))
    room = unit * (TITLE + (SUBTITLE if any(subtitle for _, subtitle in words) else 0))
    # A row of close-ups may have no words of its own.
    below = [room if any(words[k] != ("", "") for k in row) else 0.0 for row in rows]
    total = sum(heights) + sum(below) + unit * gap * len(rows) + unit * (SIDE + foot)
    figure = sheet(width, round(total))
    with style.applied():
        top = unit * SIDE
        for row, height, words_below in zip(rows, heights, below, strict=True):
            tall = [min(height, int(cell / scenes[k].aspect)) if filling else height for k in row]
            pictures = [scenes[k].draw(each) for k, each in zip(row, tall, strict=True)]
            if equal_columns or filling:
                # A row that is not full stands in the middle.
                first = unit * SIDE + 0.5 * (per_row - len(row)) * (cell + unit * gap) + 0.5 * cell
                middles = [first + k * (cell + unit * gap) for k in range(len(row))]
            else:
                spare = (width - sum(each.shape[1] for each in pictures)) / (len(row) + 1)
                before = np.cumsum([0, *(each.shape[1] + spare for each in pictures)])
                middles = [
                    spare + start + 0.5 * each.shape[1] for start, each in zip(before, pictures, strict=False)
                ]
            for k, pixels, middle in zip(row, pictures, middles, strict=True):
                place(figure, pixels, middle - 0.5 * pixels.shape[1], top + 0.5 * (height - len(pixels)))
                caption(figure, words[k], middle / width, top + height, unit)
            top += height + words_below + unit * gap
    return figure


def gallery(
    scenes: Sequence[Drawable],
    words: Sequence[tuple[str, str]],
    *,
    columns: int | None = None,
    width: int = style.WIDTH,
    tallest: int = 1100,
    alt: str = "",
    colormaps: Sequence[Colormap] = (),
    accents: Sequence[str] = (),
    filling: bool = False,
) -> Picture:
    """Draw scenes of any kind side by side: the stages of a pipeline (Fig. 18).

    Parameters
    ----------
    scenes : what to draw; the order is kept
    words : title and subtitle of each
    columns : scenes in a row; all in one row if not given
    width : pixels across the figure; a narrower one is the same figure, smaller
    tallest : height that no scene exceeds, in pixels of a figure of full width
    alt : one sentence that says what is to be seen
    colormaps, accents : maps, and colours of small things, for which the palette must keep a place
    filling : whether each scene fills a square as wide as its column; if not, scenes of a row have one height

    Raises
    ------
    RenderError
        If there is nothing to draw.

    Examples
    --------
    >>> scene = viz.Scene()
    >>> scene.add_surface(gw.shapes.sphere(faces=80))
    >>> picture = viz.gallery([scene, scene], [("left", ""), ("right", "")], width=300)
    >>> picture.pixels.shape[1], picture.alt
    (300, 'left, right')
    """
    figure = grid(scenes, words, columns=columns, width=width, tallest=tallest, foot=0, filling=filling)
    shades = [
        [share * each for each in to_rgb(colour)] for colour in sorted(set(accents)) for share in SHADES
    ]
    maps = [*colormaps, ListedColormap(shades)] if accents else colormaps
    turnable = tuple(each for each in scenes if isinstance(each, Scene))
    return Picture(figure, alt or ", ".join(title for title, _ in words), tuple(maps), turnable)
