"""A wrong sign, a wrong place and a wrong order in a pattern are found where they are."""

from __future__ import annotations

from dataclasses import replace

import laidflat
import numpy as np
import pytest
from twinned import inner, pattern, woven

from geoweave.fabrication.flattening import pattern_of
from geoweave.twin.contradictions import contradiction_sentence, contradictions_of
from geoweave.twin.pattern_surface import surface_of


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
        assert (x,) in [each.crossings for each in contradictions_of(surface)]
        assert f"crossing {x} of" in contradiction_sentence(surface.pattern, contradictions_of(surface)[0])


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
        surface = surface_of(wrong)
        # Without a handle more, the strips close into a sphere as well as before.
        if before == after or surface.genus == 0:
            continue
        moved += 1
        assert surface.tangled
        named += any(x in each.crossings for each in contradictions_of(surface))
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
    wrong = replace(sound, at=at)
    found = contradictions_of(surface_of(wrong))
    plain = [each for each in found if each.plain]
    assert {x, y} & {each for one in plain for each in one.crossings}
    for each in found:
        assert sound.strips[each.strip].label in contradiction_sentence(wrong, each)


def test_what_hangs_on_one_crossing_contradicts_nothing() -> None:
    """The end of a strip crosses one line of a net, and that end is crossed by a short strip of its own."""
    flat = laidflat.flat()
    way = np.subtract(flat["ribbons"][0]["points"][1], flat["ribbons"][0]["points"][0])
    along = way / np.linalg.norm(way)
    across = np.cross([0.0, 0.0, 1.0], along)
    first = [x for x in flat["crossings"] if 0 in x["ribbons"]]
    outermost = min(x["arclength"][x["ribbons"].index(0)] for x in first)
    middle = np.add(flat["ribbons"][0]["points"][0], 0.5 * outermost * along)
    short = laidflat.ribbon("S1", 3, [middle - 5 * across, middle + 5 * across], laidflat.UP)
    met = laidflat.crossing(0, len(flat["ribbons"]), (0.5 * outermost, 5.0), 0)
    hung = flat | {"ribbons": [*flat["ribbons"], short], "crossings": [*flat["crossings"], met]}
    surface = surface_of(pattern_of(hung))
    assert surface.tangled
    assert surface.genus == 0
    assert contradictions_of(surface) == ()
