"""Of curves that lie on each other the longest stays."""

from __future__ import annotations

from surfaces import lines_on_square

from geoweave.weave.doubled_curves import doubled


def test_of_lines_on_each_other_the_longest_stays() -> None:
    """Three along one axis and one across: of the three the shortest runs apart for most of its length."""
    found = lines_on_square(
        (-0.4, 0.0, 0.4, 0.0),
        (-0.1, 0.01, 0.3, 0.01),  # along the first
        (-0.1, 0.015, 0.3, 0.16),  # leaves it at once, by 20 degrees
        (0.02, -0.3, 0.02, 0.3),
    )
    assert doubled(found, 0.02).tolist() == [False, True, False, False]
    assert not doubled(found, 0.009).any()
