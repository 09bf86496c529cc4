"""Operators of a page: every text is there in letters, as high and as wide as its strokes."""

from __future__ import annotations

import re

import numpy as np
import pytest
from laidflat import NAMES, sheet

from geoweave.fabrication.colours import Colours
from geoweave.fabrication.pdf_marks import CAPITAL, strip_operators
from geoweave.fabrication.pieces import Making

OPERATOR = r"BT /F1 (\S+) Tf \S+ Tz (\S+) (\S+) \S+ \S+ (\S+) (\S+) Tm \(([^)]*)\) Tj"


@pytest.mark.parametrize("name", NAMES)
def test_every_text_is_written_where_it_stands(name: str) -> None:
    page = sheet(name)
    found = re.findall(OPERATOR, "\n".join(strip_operators(page, Colours("paper"), 12.0, 33.0)))
    wanted = [f for laid in page.laid for f in laid.figures if f.text]
    assert sorted(each[-1] for each in found) == sorted(f.text for f in wanted)
    for size, c, s, x, y, text in found:
        high = CAPITAL * float(size)
        assert high >= 1.8 - 1e-3
        # Half a letter above the corner where the text begins is the left end of its strokes.
        start = [float(x) - 12 - 0.5 * high * float(s), float(y) - 33 + 0.5 * high * float(c)]
        off = []
        for figure in wanted:
            if figure.text == text and figure.spot is not None:
                points = np.concatenate(figure.paths)
                if figure.spot.turn:
                    off.append(np.hypot(figure.spot.x - start[0], points[:, 1].min() - start[1]))
                else:
                    off.append(np.hypot(points[:, 0].min() - start[0], figure.spot.y - start[1]))
        assert min(off) < 0.35 * high


def test_holes_are_closed_curves_of_their_size() -> None:
    page = sheet("flat", Making(holes=2.0))
    code = strip_operators(page, Colours("paper"), 0.0, 0.0)
    rings = [each for each in code if each.count(" c") == 4]
    assert len(rings) == sum(figure.role == "hole" for laid in page.laid for figure in laid.figures)
    for ring in rings:
        numbers = np.array(re.findall(r"-?[\d.]+", ring), dtype=np.float64).reshape(-1, 2)
        assert np.ptp(numbers, axis=0) == pytest.approx([2.0, 2.0], abs=2e-3)
        np.testing.assert_allclose(numbers[0], numbers[-1], atol=1e-9)
