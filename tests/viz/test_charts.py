"""Charts draw every row of numbers that they are given."""

from __future__ import annotations

import numpy as np
import pytest
from pictures import blank_frame, near

from geoweave import viz
from geoweave.errors import RenderError
from geoweave.viz import style


def test_the_chart_of_alternations_draws_three_curves() -> None:
    energies, changes = np.geomspace(3.0, 1.0, 21), np.geomspace(1e-1, 1e-6, 20)
    both = viz.alternation_chart(energies, changes, 0.3 * changes).pixels
    assert (both != viz.alternation_chart(energies, changes, np.zeros(20)).pixels).any()
    assert (both != viz.alternation_chart(energies, changes, 0.3 * changes, mark=30).pixels).any()
    with pytest.raises(RenderError, match="one energy more"):
        viz.alternation_chart(energies, energies, changes)


def test_the_convergence_chart_draws_both_curves_and_the_dotted_line() -> None:
    steps = np.arange(21)
    curls, changes = 1 + 10 * np.exp(-steps / 4), 0.3 * np.exp(-steps[1:] / 5)
    with_line = viz.convergence_chart(curls, changes, reference=12.0).pixels
    without = viz.convergence_chart(curls, changes).pixels
    assert near(with_line, style.BLUE).sum() > near(without, style.BLUE).sum()
    assert near(without, style.RED).sum() > 2000
    assert blank_frame(with_line, 6)
    with pytest.raises(RenderError, match="one curl more"):
        viz.convergence_chart(curls, curls)


def test_the_chart_of_drops_shows_ours_and_the_papers() -> None:
    ours = viz.Drop("Cow", 20.0, 7.0)
    both = viz.Drop("Cow", 20.0, 7.0, 13.36, 4.19)
    grey = [near(viz.drop_chart([row]).pixels, "#a9a59c", 12).sum() for row in (ours, both)]
    assert grey[1] > grey[0] + 1000
    with pytest.raises(RenderError, match="at least one model"):
        viz.drop_chart([])


def test_the_chart_of_fronts_draws_every_choice() -> None:
    line = viz.Front("merged", [9.0, 5.0, 3.0], [1.0, 2.0, 4.0])
    both = viz.front_chart([line, viz.Front("start", [9.0], [1.0])]).pixels
    assert (both != viz.front_chart([line]).pixels).any()
    assert (both != viz.front_chart([line, viz.Front("start", [8.0], [1.0])]).pixels).any()
    for bad in ([], [viz.Front("none", [], [])], [viz.Front("odd", [1.0], [1.0, 2.0])]):
        with pytest.raises(RenderError, match="two numbers for every choice"):
            viz.front_chart(bad)


def test_other_runs_stand_beside_the_energy() -> None:
    plain = viz.alternation_chart([9.0, 3.0, 2.0], [0.5, 0.1], [0.2, 0.1])
    beside = viz.alternation_chart(
        [9.0, 3.0, 2.0], [0.5, 0.1], [0.2, 0.1], others={"in turns": [9.0, 6.0, 4.0]}
    )
    (left, _), (before, _) = beside.figure.axes, plain.figure.axes
    assert len(left.lines) == len(before.lines) + 1
    (line,) = [each for each in left.lines if each.get_label() == "in turns"]
    assert list(line.get_ydata()) == [9.0, 6.0, 4.0]
    assert line.get_linestyle() == "--"
    assert [text.get_text() for text in left.get_legend().get_texts()] == ["ours", "in turns"]
