"""Which ribbon meets which, and in which order."""

from __future__ import annotations

import numpy as np
import pytest
from surfaces import lines_on_square

from geoweave.curves.curve_crossings import crossings
from geoweave.errors import GeoweaveError
from geoweave.weave.passages import Passages, merged


def test_passages_of_curves_follow_each_other_along_them() -> None:
    lines = lines_on_square((-0.4, 0.0, 0.4, 0.0), (0.3, -0.3, 0.3, 0.3), (-0.1, -0.3, -0.1, 0.3))
    passages = Passages.on(lines, crossings(lines))
    assert passages.ribbons.tolist() == [[0, 2], [0, 1]]
    np.testing.assert_allclose(passages.arclengths, [[0.3, 0.3], [0.7, 0.3]])
    # passage 2 c + s is ribbon number s of crossing c: ribbon 0 first, in the order of its crossings
    assert passages.order.tolist() == [0, 2, 3, 1]
    assert passages.following.tolist() == [2, -1, -1, -1]
    assert [each.tolist() for each in passages.relations] == [[0], [1], [0], [1]]


def test_a_closed_ribbon_goes_round() -> None:
    passages = Passages([[0, 1], [0, 1], [0, 2]], [[1.0, 5.0], [2.0, 6.0], [3.0, 0.0]], [True, False, True])
    assert passages.following.tolist() == [2, 3, 4, -1, 0, -1]


def test_duplicates_are_merged() -> None:
    ribbons = [[0, 1], [1, 0], [0, 1], [0, 2], [2, 2], [2, 2], [0, 1]]
    lengths = [[5.0, 2.0], [2.1, 5.1], [5.2, 2.2], [5.1, 2.1], [1.0, 7.0], [7.05, 1.05], [9.95, 2.1]]
    crossings = Passages(ribbons, lengths, [True, False, False])
    result = merged(crossings, 0.11)
    # a chain of three whose ends are further apart, and a ribbon that crosses itself
    assert result.kept.tolist() == [1, 3, 4, 6]
    assert result.group.tolist() == [0, 0, 0, 1, 2, 2, 3]
    np.testing.assert_array_equal(result.passages.arclengths, np.array(lengths)[result.kept])
    assert len(merged(crossings, 0.0).kept) == 7
    again = Passages([[0, 1], [0, 1]], [[0.02, 3.0], [9.98, 3.01]], [True, False])
    assert len(merged(again, 0.1).kept) == 2
    assert len(merged(again, 0.1, np.array([10.0, 5.0])).kept) == 1


def test_what_is_no_passage_is_refused() -> None:
    with pytest.raises(GeoweaveError, match="flags are 1"):
        Passages([[0, 1]], [[0.0, 0.0]], [False])
    with pytest.raises(GeoweaveError, match="not finite"):
        Passages([[0, 1]], [[0.0, np.nan]], [False, False])
    with pytest.raises(GeoweaveError, match="arclengths"):
        Passages([[0, 1]], [[0.0]], [False, False])
    one = Passages([[0, 1]], [[0.0, 0.0]], [False, False])
    with pytest.raises(GeoweaveError, match="negative"):
        merged(one, -1.0)
    with pytest.raises(GeoweaveError, match="lengths"):
        merged(one, 1.0, np.array([1.0]))
