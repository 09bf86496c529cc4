"""Charts of numbers: convergence (Figs. 14 and 26), and curl before and after (Table 1)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.ticker import LogLocator, MaxNLocator, NullFormatter
from numpy.typing import ArrayLike

from geoweave.errors import RenderError
from geoweave.viz import style
from geoweave.viz.picture import Picture, sheet


def convergence_chart(
    curls: ArrayLike,
    changes: ArrayLike,
    *,
    reference: float | None = None,
    reference_label: str = "globally smoothest field (Knöppel et al. 2013)",
    width: int = 1500,
    height: int = 900,
    alt: str = "",
) -> Picture:
    """Draw total curl (blue, left axis) and change per iteration (red, right axis, logarithmic), as Fig. 26.

    Parameters
    ----------
    curls : (n + 1,) total curl of the start and after each iteration
    changes : (n,) change of w in each iteration, positive; zeros are left out of the logarithmic axis
    reference : total curl of the field to compare with, a dotted blue line
    reference_label : words on that line

    Raises
    ------
    RenderError
        If the lengths do not fit.

    Examples
    --------
    >>> viz.convergence_chart([9.0, 3.0, 2.0], [0.5, 0.1]).alt
    'Total curl falls from 9.00 to 2.00 in 2 iterations'
    """
    curl, change = np.asarray(curls, dtype=np.float64), np.asarray(changes, dtype=np.float64)
    if curl.ndim != 1 or len(change) < 1 or len(curl) != len(change) + 1:
        raise RenderError(
            f"a convergence chart needs one curl more than changes, not {curl.shape} and {change.shape}"
        )
    figure = sheet(width, height)
    with style.applied():
        left = figure.add_axes((0.095, 0.125, 0.80, 0.83))
        right = left.twinx()
        right.spines["right"].set_visible(True)
        steps = np.arange(len(curl))
        left.plot(steps, curl, color=style.BLUE, marker="o", markersize=3.2)
        left.set_ylim(0.0, 1.08 * max(float(curl.max()), reference or 0.0))
        left.set_xlim(-0.01 * len(change), 1.01 * len(change))
        left.xaxis.set_major_locator(MaxNLocator(integer=True))
        left.set_xlabel("iteration")
        _paint_axis(left, "left", style.BLUE, "total curl (bounding radius 1)")
        positive = change > 0
        right.plot(steps[1:][positive], change[positive], color=style.RED, marker="s", markersize=2.8)
        right.set_yscale("log")
        right.yaxis.set_major_locator(LogLocator(numticks=8))
        right.yaxis.set_minor_formatter(NullFormatter())
        _paint_axis(right, "right", style.RED, "change of $\\hat{w}$ per iteration (root mean square)")
        if reference is not None:
            left.axhline(reference, color=style.BLUE, linestyle=(0, (1, 1.8)), linewidth=1.4)
            left.annotate(
                reference_label, (len(change), reference), xytext=(-4, 4), textcoords="offset points",
                ha="right", va="bottom", color=style.BLUE, size=8.5,
            )  # fmt: skip
    end = f"Total curl falls from {curl[0]:.2f} to {curl[-1]:.2f} in {len(change)} iterations"
    return Picture(figure, alt or end)


def alternation_chart(
    energies: ArrayLike,
    theta_changes: ArrayLike,
    s_changes: ArrayLike,
    *,
    others: Mapping[str, ArrayLike] | None = None,
    mark: int = 10,
    width: int = 1500,
    height: int = 900,
    alt: str = "",
) -> Picture:
    """Draw the energy of Eq. 8 (blue, bold) and the changes of theta (red, dashed) and s (green), as Fig. 14.

    Parameters
    ----------
    energies : (n + 1,) at the start and after each alternation
    theta_changes, s_changes : (n,) in each alternation; zeros are left out of the logarithmic axis
    others : energies of other runs on the same scale, by what they are, dashed lines
    mark : the number of alternations that the paper finds sufficient, a thin line

    Raises
    ------
    RenderError
        If the lengths do not fit.

    Examples
    --------
    >>> viz.alternation_chart([9.0, 3.0, 2.0], [0.5, 0.1], [0.2, 0.1]).alt
    'The energy falls from 9 to 2 in 2 alternations'
    """
    energy = np.asarray(energies, dtype=np.float64)
    changes = [np.asarray(each, dtype=np.float64) for each in (theta_changes, s_changes)]
    if energy.ndim != 1 or any(len(each) < 1 or len(energy) != len(each) + 1 for each in changes):
        raise RenderError(
            "a chart of alternations needs one energy more than changes, not "
            f"{energy.shape}, {changes[0].shape} and {changes[1].shape}"
        )
    figure = sheet(width, height)
    count = len(changes[0])
    with style.applied():
        left = figure.add_axes((0.10, 0.125, 0.79, 0.83))
        right = left.twinx()
        right.spines["right"].set_visible(True)
        left.plot(np.arange(count + 1), energy, color=style.BLUE, linewidth=3.2, label="ours")
        for (name, other), pattern in zip((others or {}).items(), ("--", ":", "-."), strict=False):
            high = np.asarray(other, dtype=np.float64)
            left.plot(
                np.arange(len(high)), high, color=style.BLUE, linewidth=1.8, linestyle=pattern, label=name
            )
        if others:
            left.legend(loc="upper center", labelcolor="linecolor")
        left.set_ylim(0.0, 1.08 * float(energy.max()))
        left.set_xlim(-0.01 * count, 1.01 * count)
        left.xaxis.set_major_locator(MaxNLocator(integer=True, steps=[1, 2, 5, 10]))
        left.set_xlabel("alternation")
        _paint_axis(left, "left", style.BLUE, "energy (Eq. 8)")
        names = (r"$\|\Delta\theta\|$, radians", r"$\|\Delta s\|$, share of $s$")
        for change, name, colour, dashes in zip(
            changes, names, (style.RED, style.GREEN), ((0, (4, 2)), "-"), strict=True
        ):
            positive = change > 0
            steps = np.arange(1, count + 1)[positive]
            right.plot(steps, change[positive], color=colour, linestyle=dashes, linewidth=1.6, label=name)
        right.set_yscale("log")
        right.yaxis.set_major_locator(LogLocator(numticks=8))
        right.yaxis.set_minor_formatter(NullFormatter())
        _paint_axis(right, "right", style.INK, "change per alternation (root mean square)")
        right.legend(loc="upper right", labelcolor="linecolor")
        if mark < count:
            left.axvline(mark, color=style.FAINT, linewidth=0.9, linestyle=(0, (1, 1.8)))
    end = f"The energy falls from {energy[0]:.3g} to {energy[-1]:.3g} in {count} alternations"
    return Picture(figure, alt or end)


def _paint_axis(axes: Axes, side: str, colour: str, label: str) -> None:
    axes.set_ylabel(label, color=colour)
    axes.tick_params(axis="y", which="both", colors=colour, labelcolor=colour)
    axes.spines[side].set_color(colour)


@dataclass(frozen=True)
class Drop:
    """Total curl of one model before and after, ours and (if known) the paper's."""

    model: str
    before: float
    after: float
    paper_before: float | None = None
    paper_after: float | None = None


def drop_chart(rows: Sequence[Drop], *, width: int = 1500, alt: str = "") -> Picture:
    """Draw each model's total curl as an arrow from before to after, the paper's above ours (Table 1).

    Examples
    --------
    >>> viz.drop_chart([viz.Drop("Cow", 20.0, 7.0), viz.Drop("Torus", 3.0, 1.0)], width=600).pixels.shape
    (450, 600, 3)
    """
    if not rows:
        raise RenderError("a chart of drops needs at least one model")
    height = 190 + 130 * len(rows)
    figure = sheet(width, height)
    with style.applied():
        # Room for the longest name: about 16 pixels a letter.
        left = (40 + 16 * max(len(row.model) for row in rows)) / width
        axes = figure.add_axes((left, 110 / height, 0.96 - left, 1 - 170 / height))
        for level, row in enumerate(rows):
            if row.paper_before is not None and row.paper_after is not None:
                _arrow(axes, row.paper_before, row.paper_after, level - 0.17, "#a9a59c", style.FAINT)
            _arrow(axes, row.before, row.after, level + 0.17, style.BLUE, style.BLUE)
        axes.set_yticks(range(len(rows)), [row.model for row in rows])
        axes.set_ylim(len(rows) - 0.5, -0.5)
        most = max(max(row.before, row.paper_before or 0.0) for row in rows)
        axes.set_xlim(0.0, 1.12 * most)
        axes.set_xlabel("total curl (bounding radius 1)")
        axes.tick_params(axis="y", length=0, labelsize=10)
        axes.spines["left"].set_visible(False)
        axes.grid(axis="x", color=style.LINE, linewidth=0.5)
        axes.set_axisbelow(True)
        figure.text(left, 1 - 14 / height, "paper", color=style.FAINT, va="top", size=9.5)
        figure.text(left + 0.07, 1 - 14 / height, "this package", color=style.BLUE, va="top", size=9.5)
    return Picture(figure, alt or "Total curl before and after optimisation, paper and ours")


def _arrow(axes: Axes, start: float, end: float, level: float, colour: str, ink: str) -> None:
    axes.annotate(
        "", (end, level), (start, level),
        arrowprops={"arrowstyle": "-|>", "color": colour, "linewidth": 2.2, "shrinkA": 0, "shrinkB": 0},
    )  # fmt: skip
    axes.plot([start], [level], "o", color=colour, markersize=4.5)
    side = 6 if start >= end else -6
    axes.annotate(f"{start:.2f}", (start, level), (side, 0), textcoords="offset points",
                  ha="left" if side > 0 else "right", va="center", size=8.5, color=ink)  # fmt: skip
    axes.annotate(f"{end:.2f}", (end, level), (-side, 0), textcoords="offset points",
                  ha="right" if side > 0 else "left", va="center", size=8.5, color=ink)  # fmt: skip


@dataclass(frozen=True)
class Front:
    """Choices that trade one number against another, such as fewer branch points against curl."""

    label: str
    across: Sequence[float]
    upwards: Sequence[float]


def front_chart(
    fronts: Sequence[Front],
    *,
    across: str = "branch points",
    upwards: str = "total curl (bounding radius 1)",
    width: int = 1500,
    height: int = 900,
    alt: str = "",
) -> Picture:
    """Draw fronts as lines with a dot for each choice; one of a single choice is a larger dot.

    Raises
    ------
    RenderError
        If there is nothing to draw, or numbers do not come in pairs.

    Examples
    --------
    >>> viz.front_chart([viz.Front("merged", [9, 5], [1.0, 2.0]), viz.Front("start", [9], [1.0])]).alt
    'total curl (bounding radius 1) over branch points: merged, start'
    """
    if not fronts or any(not len(each.across) or len(each.across) != len(each.upwards) for each in fronts):
        raise RenderError("a chart of fronts needs one front or more, and two numbers for every choice")
    figure = sheet(width, height)
    with style.applied():
        axes = figure.add_axes((0.085, 0.125, 0.88, 0.83))
        colours = (style.BLUE, style.RED, style.GREEN, style.INK)
        for k, each in enumerate(fronts):
            colour, single = colours[k % len(colours)], len(each.across) == 1
            axes.plot(
                each.across, each.upwards, "o" if single else "o-", color=colour, label=each.label,
                markersize=9 if single else 4, linewidth=1.6, zorder=3 if single else 2,
            )  # fmt: skip
        axes.set_xlabel(across)
        axes.set_ylabel(upwards)
        axes.set_ylim(0.0, None)
        axes.grid(axis="y", color=style.LINE, linewidth=0.5)
        axes.set_axisbelow(True)
        axes.legend(frameon=False, fontsize=10)
    return Picture(figure, alt or f"{upwards} over {across}: {', '.join(each.label for each in fronts)}")
