"""Charts of what a choice changes."""

from __future__ import annotations

import numpy as np
import pytest
from pictures import near

from geoweave.errors import RenderError
from geoweave.viz import style
from geoweave.viz.sweeps import Sweep, sweep_chart


def test_a_line_rises_with_its_shares_and_a_mark_stands_at_the_right() -> None:
    sweep = Sweep("faces", [1000, 2000, 4000], {"cow": [0.1, 0.5, 0.9]}, {"cow": 0.2})
    pixels = sweep_chart([sweep], what="drop", width=800).pixels
    rows, columns = np.nonzero(near(pixels, style.BLUE))
    plot = rows < 0.7 * pixels.shape[0]
    rows, columns = rows[plot], columns[plot]
    assert rows[columns < columns.min() + 20].mean() > rows[columns > columns.max() - 20].min()
    last = columns > columns.max() - 15
    assert np.ptp(rows[last]) < 12, "the mark is a short bar"


def test_lengths_are_checked() -> None:
    with pytest.raises(RenderError, match="'cow' has 1 shares for 2 values"):
        sweep_chart([Sweep("faces", [1, 2], {"cow": [0.5]})], what="drop")
    with pytest.raises(RenderError, match="at least one sweep"):
        sweep_chart([], what="drop")
