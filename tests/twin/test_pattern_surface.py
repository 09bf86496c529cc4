"""A pattern's own topology: faces from signed angles, and the genus."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import laidflat
import numpy as np
import pytest
from twinned import pattern, woven

from geoweave.errors import FieldError
from geoweave.fabrication.flattening import pattern_of
from geoweave.fabrication.pattern import Pattern
from geoweave.twin.contradictions import contradictions_of
from geoweave.twin.pattern_surface import openings_of, surface_of


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
    assert surface.openings == openings_of(surface.pattern) == 0
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
    assert surface.openings == openings_of(surface.pattern) == (1 if name == "cone" else 0)


def ends_at(flat: dict[str, Any], opening: Callable[[int], int]) -> dict[str, Any]:
    """The same weave, with both ends of each ribbon at the opening that is given for its family."""
    ribbons = [each | {"openings": [opening(each["family"])] * 2} for each in flat["ribbons"]]
    return flat | {"ribbons": ribbons}


def test_only_what_is_said_makes_a_face_an_opening() -> None:
    flat = laidflat.flat()
    around = surface_of(pattern_of(ends_at(flat, lambda family: 0)))
    assert around.openings == openings_of(around.pattern) == 1
    # Every strip ends twice in the face around, which has the most corners.
    (opening,) = around.opening_faces
    assert around.tails[opening] == sum(around.tails) == 2 * len(flat["ribbons"])
    assert len(around.faces[opening]) == max(len(walk) for walk in around.faces)
    assert len(around.meshes) == len(around.faces) - 1
    # The same ends in a closed surface leave a wide mesh.
    closed = surface_of(pattern_of(ends_at(flat, lambda family: -1)))
    assert closed.openings == openings_of(closed.pattern) == 0
    assert len(closed.meshes) == len(closed.faces)
    silent = surface_of(pattern_of(flat))
    assert silent.openings is openings_of(silent.pattern) is None


def test_openings_that_no_strip_parts_are_one() -> None:
    surface = surface_of(pattern_of(ends_at(laidflat.flat(), lambda family: min(family, 1))))
    assert (surface.openings, openings_of(surface.pattern)) == (1, 2)


def test_a_crossing_of_the_wrong_sign_tears_the_opening() -> None:
    whole = pattern_of(ends_at(laidflat.flat(), lambda family: 0))
    outer = np.unique(surface_of(whole).faces[min(surface_of(whole).opening_faces)] // 4)
    torn = []
    for x in outer.tolist():
        angle = whole.angle.copy()
        angle[x] *= -1
        torn.append(surface_of(replace(whole, angle=angle)).openings)
    assert max(each for each in torn if each is not None) > 1


def test_what_is_said_of_ends_is_written_and_read() -> None:
    said = pattern_of(ends_at(laidflat.flat(), lambda family: family - 1))
    again = Pattern.from_document(said.document())
    assert [strip.openings for strip in again.strips] == [(strip.family - 1,) * 2 for strip in said.strips]
    silent = pattern_of(laidflat.flat())
    assert {strip.openings for strip in Pattern.from_document(silent.document()).strips} == {None}


def test_nothing_to_weave() -> None:
    flat = laidflat.flat()
    with pytest.raises(FieldError, match="no strip of the pattern crosses another"):
        surface_of(pattern_of(flat | {"crossings": []}))
