"""A pattern's own topology: faces from signed angles, and the genus."""

from __future__ import annotations

import laidflat
import numpy as np
import pytest
from twinned import pattern, woven

from geoweave.errors import FieldError
from geoweave.fabrication.flattening import pattern_of
from geoweave.twin.contradictions import contradictions_of
from geoweave.twin.pattern_surface import surface_of


def test_lines_in_the_plane_have_the_faces_one_sees() -> None:
    surface = surface_of(pattern_of(laidflat.flat(each=2)))
    assert surface.euler_characteristic == 2
    assert surface.genus == 0
    assert not surface.tangled
    assert contradictions_of(surface) == ()
    # A stretch is gone along once on each side.
    darts = np.concatenate(surface.faces)
    assert len(np.unique(darts)) == len(darts) == 2 * len(surface.edges)


def test_three_great_circles_make_an_octahedron() -> None:
    surface = surface_of(pattern_of(laidflat.circles(radius=60.0)))
    assert [len(walk) for walk in surface.faces] == [3] * 8
    assert surface.tails == (0,) * 8
    assert surface.openings == 0
    np.testing.assert_allclose(surface.stretch, 30 * np.pi, rtol=1e-3)


def test_a_loop_of_one_strip() -> None:
    surface = surface_of(pattern_of(laidflat.bow_tie()))
    assert sorted(len(walk) for walk in surface.faces) == [1, 1]
    assert surface.euler_characteristic == 2


def test_chords_of_flat_faces_are_distances() -> None:
    flat = laidflat.flat()
    pattern = pattern_of(flat)
    one = pattern.ribbons[:, 0]
    start = np.array([each["points"][0] for each in flat["ribbons"]])
    way = np.array([np.subtract(each["points"][1], each["points"][0]) for each in flat["ribbons"]])
    way /= np.linalg.norm(way, axis=1)[:, None]
    places = start[one] + pattern.at[:, :1] * way[one]
    chords = surface_of(pattern).chords()
    assert len(chords.ends) >= 9  # a hexagon alone has nine
    apart = np.linalg.norm(places[chords.ends[:, 0]] - places[chords.ends[:, 1]], axis=1)
    np.testing.assert_allclose(chords.lengths, apart, rtol=1e-3)


@pytest.mark.parametrize("name", ["cone", "sphere", "torus"])
def test_the_genus_is_that_of_the_designed_surface(name: str) -> None:
    surface = surface_of(pattern(name, "designed"))
    assert surface.genus == woven(name).genus
    assert surface.euler_characteristic == 2 - 2 * woven(name).genus
    assert len(surface.pieces) == 1
    assert not surface.tangled
    assert surface.openings == (1 if name == "cone" else 0)


def test_nothing_to_weave() -> None:
    flat = laidflat.flat()
    with pytest.raises(FieldError, match="no strip of the pattern crosses another"):
        surface_of(pattern_of(flat | {"crossings": []}))
