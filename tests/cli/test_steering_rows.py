"""The table of ``geoweave weave`` says how far the field is what was asked of it."""

from __future__ import annotations

from geoweave.cli.steering_rows import aligned, mirrored, prescribed


def test_the_table_says_where_the_finished_field_differs() -> None:
    places = [
        {"point": [0.0, 0.25, 1.0], "index": 5, "found": -1},
        {"point": [0.0] * 3, "index": 0, "found": 6},
    ]
    ((_, text),) = prescribed({"kept": False, "displaced": places}, 6)
    assert text == (
        "the finished field differs at 2 points, first at (0, 0.25, 1): index -1/6 in place of 5/6"
    )
    assert prescribed(None, 6) == []


def test_the_table_says_how_far_the_field_is_from_its_image() -> None:
    ((_, text),) = mirrored({"normal": [0.0, 1.0, 0.0], "surface": 0.004, "field_deg": 2.5})
    assert text == (
        "across (0.00, 1.00, 0.00): the field is 2.5 degrees from its image in the mean, "
        "the surface 0.40% of its size"
    )
    assert mirrored(None) == []
    assert aligned(None) == []
    assert aligned(2.5)[0][1].startswith("2.5 degrees")
