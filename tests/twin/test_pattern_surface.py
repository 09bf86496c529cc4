"""A pattern's own topology: faces from signed angles, the genus, and what contradicts itself."""

from __future__ import annotations

from dataclasses import replace

import laidflat
import numpy as np
import pytest
from twinned import inner, pattern, woven

from geoweave.errors import FieldError
from geoweave.fabrication.pattern import pattern_of
from geoweave.twin.pattern_surface import surface_of


def test_lines_in_the_plane_have_the_faces_one_sees() -> None:
    surface = surface_of(pattern_of(laidflat.flat(each=2)))
    assert surface.euler_characteristic == 2
    assert surface.genus == 0
    assert not surface.tangled
    assert surface.slips == ()
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


@pytest.mark.parametrize("name", ["cone", "sphere", "torus"])
def test_a_wrong_sign_is_found_at_its_crossing(name: str) -> None:
    sound = pattern(name, "designed")
    among = inner(surface_of(sound))
    assert len(among) > 10
    for x in among[::3]:
        angle = sound.angle.copy()
        angle[x] *= -1
        surface = surface_of(replace(sound, angle=angle))
        assert surface.euler_characteristic == 2 - 2 * woven(name).genus - 2
        assert (x,) in [slip.crossings for slip in surface.slips]
        assert f"crossing {x} of" in surface.said(surface.slips[0])


@pytest.mark.parametrize("name", ["cone", "sphere"])
def test_a_place_beyond_its_neighbours_is_found(name: str) -> None:
    sound = pattern(name, "designed")
    rng = np.random.default_rng(0)
    moved = named = 0
    for x in inner(surface_of(sound)):
        side = int(rng.integers(2))
        r = int(sound.ribbons[x, side])
        at = sound.at.copy()
        at[x, side] = rng.uniform(0, sound.strips[r].length)
        wrong = replace(sound, at=at)
        before, after = ([each.crossing for each in one.passages[r]] for one in (sound, wrong))
        if before == after:
            continue
        moved += 1
        surface = surface_of(wrong)
        assert surface.tangled
        named += any(x in slip.crossings for slip in surface.slips)
    assert moved >= 10
    assert named >= 0.9 * moved


def test_two_neighbours_in_the_wrong_order_are_told() -> None:
    sound = pattern("sphere", "designed")
    surface = surface_of(sound)
    long = int(np.argmax(surface.stretch[surface.edges[:, 0]]))
    here, there = surface.edges[long].tolist()
    (x, s), (y, t) = divmod(here // 2, 2), divmod(there // 2, 2)
    at = sound.at.copy()
    at[x, s], at[y, t] = sound.at[y, t], sound.at[x, s]
    wrong = surface_of(replace(sound, at=at))
    plain = [slip for slip in wrong.slips if slip.plain]
    assert {x, y} & {each for slip in plain for each in slip.crossings}
    for slip in wrong.slips:
        assert sound.strips[slip.strip].label in wrong.said(slip)


def test_nothing_to_weave() -> None:
    flat = laidflat.flat()
    with pytest.raises(FieldError, match="no strip of the pattern crosses another"):
        surface_of(pattern_of(flat | {"crossings": []}))
