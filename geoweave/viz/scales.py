"""What a colour means: a map with its limits, the bar that shows it, and the scales that figures share."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from matplotlib.cm import ScalarMappable
from matplotlib.colorbar import Colorbar
from matplotlib.colors import Colormap, LogNorm, Normalize
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, LogLocator, MaxNLocator, NullLocator

from geoweave.arrays import Scalars
from geoweave.errors import RenderError
from geoweave.viz import style

FOOT = 156
"""Pixels of a full-width figure for colour bars below the panels."""


@dataclass(frozen=True)
class Scale:
    """What a colour means: the map, its limits and the words beside its bar."""

    colormap: Colormap
    low: float
    high: float
    label: str
    ticks: Mapping[float, str] | None = None
    """Values and their words, for a bar that is closed at both ends; about six round numbers if not given."""
    log: bool = False
    """Whether equal ratios, and not equal differences, are equally far apart on the bar."""

    def __post_init__(self) -> None:
        if self.log and not 0 < self.low < self.high:
            raise RenderError(f"a logarithmic scale needs 0 < low < high, not {self.low:g} and {self.high:g}")

    @property
    def limits(self) -> tuple[float, float]:
        """Least and greatest value that have a colour of their own."""
        return self.low, self.high

    @property
    def norm(self) -> Normalize:
        """Where a value lies on the bar, from 0 to 1."""
        return (LogNorm if self.log else Normalize)(self.low, self.high)

    @property
    def ends(self) -> Literal["both", "max"]:
        """Which ends of the bar stand for everything beyond."""
        return "both" if self.low < 0 or self.log else "max"


def heat_scale(values: Scalars, label: str, percentile: float = 98.0) -> Scale:
    """Scale of magnitudes on a pale surface, from zero to a percentile of the given values.

    Examples
    --------
    >>> viz.heat_scale(np.arange(101.0), "distance", percentile=90).high
    90.0
    """
    high = float(np.percentile(values, percentile))
    return Scale(style.heat(), 0.0, high if high > 0 else 1.0, label)


def factor_scale(low: float, high: float, label: str = "integrating factor s") -> Scale:
    """Scale of a positive factor, dark where it is large; equal ratios are equally far apart.

    Raises
    ------
    RenderError
        Unless ``0 < low < high``.

    Examples
    --------
    >>> float(viz.factor_scale(0.5, 8.0).norm(2.0))
    0.5
    """
    return Scale(style.heat(), low, high, label, log=True)


def theta_scale() -> Scale:
    """Scale of an angle: one full turn of the colour wheel, which ends as it begins.

    Examples
    --------
    >>> viz.theta_scale().ticks[0.0]
    '0'
    """
    quarters = ("0", "π/2", "π", "3π/2", "2π")
    ticks = {k * 0.5 * np.pi: words for k, words in enumerate(quarters)}
    return Scale(style.cyclic(), 0.0, 2 * np.pi, "θ (2π is 0 again)", ticks)


def deviation_scale(high: float = 30.0) -> Scale:
    """Scale of the angle between level sets and field: black where they are aligned, as in Fig. 15.

    Examples
    --------
    >>> scale = viz.deviation_scale(30.0)
    >>> scale.low, scale.high
    (0.0, 30.0)
    """
    return Scale(style.shade(), 0.0, high, "angle between level sets and field (degrees)")


def energy_scale(
    values: Sequence[Scalars], unit: str, percentile: float = 98.0, decades: float | None = None
) -> Scale:
    """One scale for the energy per length on all rods, from 0 to a percentile of all values.

    With ``decades`` it is logarithmic, and begins so many powers of ten lower.

    Raises
    ------
    RenderError
        If no value is positive.

    Examples
    --------
    >>> viz.energy_scale([np.arange(101.0)], "N").high
    98.0
    """
    high = float(np.percentile(np.concatenate(list(values)), percentile))
    if not high > 0:
        raise RenderError("no rod has any energy, so there is nothing to show by colour")
    label = f"elastic energy per length, {unit} (clamped at the {percentile:g}th percentile)"
    if decades is None:
        return Scale(style.sequential(), 0.0, high, label)
    return Scale(style.sequential(), high * 10.0**-decades, high, label, log=True)


def rounded_up(value: float) -> float:
    """Round up to two leading digits; 1 if the value is not positive."""
    if value <= 0:
        return 1.0
    step = 10.0 ** (np.floor(np.log10(value)) - 1)
    return float(np.ceil(value / step - 1e-9) * step)


def colour_bar(
    figure: Figure,
    scale: Scale,
    box: tuple[float, float, float, float],
    unit: float,
    *,
    upright: bool = False,
) -> None:
    """Draw the bar of a scale with its label.

    Parameters
    ----------
    figure : where
    scale : what its colours mean
    box : left, bottom, width and height as shares of the figure
    unit : pixels of this figure for one of a figure of full width
    upright : whether the bar stands; else it lies
    """
    axes = figure.add_axes(box)
    bar = Colorbar(
        axes, ScalarMappable(scale.norm, scale.colormap),
        orientation="vertical" if upright else "horizontal",
        extend="neither" if scale.ticks else scale.ends, extendfrac=0.03,
        ticks=list(scale.ticks) if scale.ticks else None,
    )  # fmt: skip
    bar.outline.set_visible(False)
    axes.tick_params(length=unit * 3, width=unit * 0.7, pad=unit * 3, labelsize=unit * 8.5)
    if scale.ticks:
        bar.set_ticklabels(list(scale.ticks.values()))
    elif scale.log:
        bar.locator = LogLocator(2.0 if scale.high < 50.0 * scale.low else 10.0, numticks=9)
        bar.formatter = FuncFormatter(lambda value, _: f"{value:g}")
        bar.minorlocator = NullLocator()
        bar.update_ticks()
    else:
        bar.locator = MaxNLocator(6)
        bar.update_ticks()
    bar.set_label(scale.label, size=unit * 9, labelpad=unit * 4)


def colour_bars(figure: Figure, scales: Sequence[Scale]) -> None:
    """Draw the bars of one or two scales at the bottom of a figure, side by side."""
    width, height = round(figure.bbox.width), round(figure.bbox.height)
    unit, long = width / style.WIDTH, 0.34
    for number, scale in enumerate(scales):
        centre = 0.5 if len(scales) == 1 else 0.27 + 0.46 * number
        box = (centre - 0.5 * long, unit * 108 / height, long, unit * 18 / height)
        colour_bar(figure, scale, box, unit)
