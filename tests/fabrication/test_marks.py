"""Marks differ however they lie, and no two crossings of a pair share one."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from geoweave.errors import FieldError
from geoweave.fabrication.marks import MARKS, NEAR, assigned, outline


def inside(polygon: NDArray[np.float64], points: NDArray[np.float64]) -> NDArray[np.bool_]:
    """By crossing number."""
    found = np.zeros(len(points), dtype=bool)
    for a, b in zip(polygon, np.roll(polygon, -1, axis=0), strict=True):
        spans = (a[1] > points[:, 1]) != (b[1] > points[:, 1])
        at = a[0] + (points[:, 1] - a[1]) / np.where(spans, b[1] - a[1], 1) * (b[0] - a[0])
        found ^= spans & (points[:, 0] < at)
    return found


def test_marks_lie_in_their_square() -> None:
    for mark in range(len(MARKS)):
        assert 0.7 < np.abs(outline(mark)).max() <= 1.0
        assert not outline(mark).flags.writeable
    with pytest.raises(FieldError, match="8 marks"):
        outline(8)


def test_marks_differ_however_they_are_turned() -> None:
    ticks = np.linspace(-1.1, 1.1, 61)
    grid = np.stack(np.meshgrid(ticks, ticks), axis=-1).reshape(-1, 2)
    for mark in range(len(MARKS)):
        own = inside(outline(mark), grid)
        for other in range(mark):
            most = 0.0
            for angle in np.radians(np.arange(0, 360, 15)):
                turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
                shape = inside(outline(other) @ turn.T, grid)
                most = max(most, (own & shape).sum() / (own | shape).sum())
            # the disc and the square, told apart by corners, share 0.83 of their area
            assert most < 0.85, (MARKS[mark], MARKS[other], most)


def test_crossings_of_a_pair_never_share_mark_and_round() -> None:
    rng = np.random.default_rng(3)
    ribbons = rng.integers(0, 6, (150, 2))
    at = rng.uniform(0, 100, (150, 2))
    mark, again = assigned(ribbons, at, np.array([True, False] * 3))
    keys = np.column_stack([np.sort(ribbons, axis=1), mark, again])
    assert len(np.unique(keys, axis=0)) == 150
    counts = np.unique(np.sort(ribbons, axis=1), axis=0, return_counts=True)[1]
    assert counts.max() > len(MARKS)
    assert again.max() == (counts.max() - 1) // len(MARKS)
    assert ((mark >= 0) & (mark < len(MARKS))).all()


def test_neighbours_on_a_ribbon_differ() -> None:
    """A grid leaves enough freedom for all neighbours to differ, and so they do."""
    count = 9
    one, other = np.divmod(np.arange(count * count), count)
    at = np.stack([other, one], axis=1).astype(float)
    mark, again = assigned(np.stack([one, count + other], axis=1), at, np.zeros(2 * count, dtype=bool))
    assert not again.any()
    table = mark.reshape(count, count)
    assert (table[:, 1:] != table[:, :-1]).all()
    assert (table[1:] != table[:-1]).all()
    same = [(table[:, k:] == table[:, :-k]).mean() for k in range(1, NEAR + 1)]
    assert max(same) < 0.1
    assert np.bincount(mark, minlength=len(MARKS)).min() > 0
