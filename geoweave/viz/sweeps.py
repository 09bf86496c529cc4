"""A chart of what a choice changes: one line a model, one axes a choice (Table 1)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from matplotlib.axes import Axes
from matplotlib.ticker import FixedLocator, NullFormatter, NullLocator, PercentFormatter

from geoweave.errors import RenderError
from geoweave.viz import style
from geoweave.viz.picture import Picture, sheet


@dataclass(frozen=True)
class Sweep:
    """One axes: a number on a logarithmic axis, and shares that follow from it.

    Attributes
    ----------
    label : words below the axis
    values : (n,) positive, rising or falling; drawn from left to right as given
    shares : for each model (n,) shares from 0 to 1
    marks : for each model a share to compare with, drawn as a short bar at the right
    words : (n,) words at the ticks; the numbers if not given
    """

    label: str
    values: Sequence[float]
    shares: Mapping[str, Sequence[float]]
    marks: Mapping[str, float] = field(default_factory=dict)
    words: Sequence[str] = ()


def sweep_chart(
    sweeps: Sequence[Sweep], *, what: str, mark: str = "paper", width: int = 1700, alt: str = ""
) -> Picture:
    """Draw axes side by side with the same shares upwards, one line a model.

    Parameters
    ----------
    sweeps : the axes, from left to right
    what : what the shares are, beside the first axes
    mark : what the bars at the right are

    Raises
    ------
    RenderError
        If there is no axes, or a model has not one share for each value.

    Examples
    --------
    >>> viz.sweep_chart([viz.Sweep("faces", [100, 200], {"cow": [0.5, 0.6]})], what="drop", width=400).alt
    'drop by faces'
    """
    if not sweeps:
        raise RenderError("a chart needs at least one sweep")
    for sweep in sweeps:
        for model, shares in sweep.shares.items():
            if len(shares) != len(sweep.values):
                raise RenderError(f"'{model}' has {len(shares)} shares for {len(sweep.values)} values")
    height = round(0.42 * width)
    figure = sheet(width, height)
    models = list(dict.fromkeys(model for sweep in sweeps for model in sweep.shares))
    colours = dict(zip(models, [style.BLUE, style.RED, style.GREEN, *style.FAMILIES], strict=False))
    across = 0.80 / len(sweeps)
    with style.applied():
        for number, sweep in enumerate(sweeps):
            axes = figure.add_axes((0.085 + number * (across + 0.05), 0.26, across, 0.68))
            _draw(axes, sweep, colours)
            axes.set_ylabel(what if number == 0 else "")
        handles = [axes.plot([], [], color=colours[model], linewidth=2)[0] for model in models]
        names = list(models)
        if any(sweep.marks for sweep in sweeps):
            handles.append(axes.plot([], [], color=style.FAINT, linewidth=3)[0])
            names.append(f"{mark}, in the same colours")
        figure.legend(handles, names, loc="lower center", ncol=len(names), frameon=False, fontsize=9)
    return Picture(figure, alt or f"{what} by " + ", ".join(sweep.label for sweep in sweeps))


def _draw(axes: Axes, sweep: Sweep, colours: Mapping[str, str]) -> None:
    """Draw one line a model, and the bars at the right."""
    at = np.log(np.asarray(sweep.values, dtype=np.float64))
    at = np.sign(at[-1] - at[0]) * (at - at[0])
    for model, shares in sweep.shares.items():
        axes.plot(at, shares, color=colours[model], marker="o", markersize=4, linewidth=1.8)
    reach = float(np.ptp(at))
    for model, share in sweep.marks.items():
        axes.plot([1.04 * reach, 1.10 * reach], [share, share], color=colours[model], linewidth=3)
    axes.set_xlim(-0.04 * reach, (1.13 if sweep.marks else 1.04) * reach)
    axes.set_ylim(0.0, 1.0)
    axes.xaxis.set_major_locator(FixedLocator(at.tolist()))
    axes.set_xticks(at, list(sweep.words) or [f"{value:,g}" for value in sweep.values])
    axes.xaxis.set_minor_locator(NullLocator())
    axes.xaxis.set_minor_formatter(NullFormatter())
    axes.yaxis.set_major_formatter(PercentFormatter(1.0, decimals=0))
    axes.set_xlabel(sweep.label)
    axes.grid(axis="y", color=style.LINE, linewidth=0.5)
    axes.set_axisbelow(True)
