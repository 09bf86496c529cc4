"""What is measured on strips as they are cut."""

from __future__ import annotations

import numpy as np
import pytest
from laidlines import made

from geoweave.errors import GeoweaveError
from geoweave.weave.as_cut import AsCut, moved_out_of_order, turned_over
from geoweave.weave.inspection import inspected
from geoweave.weave.passages import Passages

RIBBONS = [[0, 1], [0, 2], [0, 3]]
"""One strip of length 4 that crosses three others of length 2 in their middles."""


def strips(*places: float, width: float = 0.5, closed: bool = False) -> AsCut:
    return AsCut(
        Passages(RIBBONS, [[at, 1.0] for at in places], [closed, False, False, False]),
        np.array([0, 1, 0]),
        np.full(3, np.pi / 2),
        np.array([4.0, 2.0, 2.0, 2.0]),
        width,
    )


def test_a_design_measured_as_strips_is_as_its_report_says() -> None:
    weave = made()
    cut, told = AsCut.of(weave), weave.metrics()
    numbers = cut.metrics(1.001 * weave.ribbons.cutting.tail * weave.ribbons.spacing)
    assert numbers["alternation"]["fraction"] == told["alternation"]["fraction"]
    assert numbers["crossing_angle_deg"] == told["crossing_angle_deg"]
    assert numbers["loose_ends"] == told["loose_ends"] == 0
    assert numbers["crossings"] == told["crossings"]
    assert cut.share_that_fits == inspected(weave).share_that_fits
    assert numbers["interleaved_triples"] == told["interleaved_triples"]


def test_strips_that_slid_past_each_other_are_measured_in_their_new_order() -> None:
    design, cut = strips(1.0, 2.0, 3.0), strips(1.0, 3.2, 3.0)
    assert design.alternation == 1.0
    # over, over, under: of two pairs one stays on a side
    assert cut.alternation == 0.5
    assert cut.metrics(5.0)["alternation"] == {"fraction": 0.5, "pairs": 2, "on_one_side": 1}
    assert moved_out_of_order(design.passages, cut.passages).tolist() == [0, 1, 2]
    assert not len(moved_out_of_order(design.passages, strips(0.1, 0.2, 3.9).passages))


def test_a_closed_strip_may_start_anywhere() -> None:
    design, cut = strips(1.0, 2.0, 3.0, closed=True), strips(3.5, 0.5, 1.5, closed=True)
    assert not len(moved_out_of_order(design.passages, cut.passages))
    assert len(moved_out_of_order(design.passages, strips(2.0, 1.0, 3.0, closed=True).passages)) == 3
    np.testing.assert_allclose(np.sort(cut.neighbours.distance), [1.0, 1.0, 2.0])


def test_room_between_neighbours_and_ends() -> None:
    cut = strips(0.25, 0.5, 3.0, width=0.3)
    np.testing.assert_allclose(cut.neighbours.distance, [0.25, 2.5])
    assert cut.share_that_fits == 0.5
    np.testing.assert_allclose(cut.overhang, [[0.25, 1.0], [1, 1], [1, 1], [1, 1]])
    assert cut.loose(0.5).tolist() == [[False, True], [True, True], [True, True], [True, True]]
    assert cut.metrics(1.5)["loose_ends"] == 0
    assert cut.metrics(1.5)["longest_end"] == 1.0
    assert strips(1.0, 2.0, 3.0, closed=True).overhang[0].tolist() == [0.0, 0.0]


def test_a_strip_that_crosses_nothing_hangs_all_along() -> None:
    alone = AsCut(Passages([], [], [False]), np.zeros(0, int), np.zeros(0), np.array([3.0]), 0.1)
    assert alone.overhang.tolist() == [[3.0, 3.0]]
    assert alone.metrics(1.0)["gap"]["median"] is None


def test_crossings_that_turned_over_are_found() -> None:
    assert turned_over([60.0, -60.0], [50.0, 10.0]).tolist() == [1]


def test_what_does_not_fit_is_refused() -> None:
    good = strips(1.0, 2.0, 3.0)
    with pytest.raises(GeoweaveError, match="'lengths' of the strips"):
        AsCut(good.passages, good.over, good.angle, np.ones(3), 0.1)
    other = Passages([[0, 1], [0, 2], [1, 3]], [[1.0, 1.0]] * 3, [False] * 4)
    with pytest.raises(GeoweaveError, match="same ribbons"):
        moved_out_of_order(good.passages, other)
