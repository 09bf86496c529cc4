"""The pattern that is measured on a drawing is the one that was drawn."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest
from laidflat import NAMES, cone, patterns

from geoweave.errors import FieldError
from geoweave.fabrication.bench import Bench
from geoweave.fabrication.hoops import hooped
from geoweave.fabrication.nesting import Stock
from geoweave.fabrication.pattern import Pattern
from geoweave.fabrication.pieces import Making
from geoweave.fabrication.strip_layout import StripLayout, layout
from geoweave.fabrication.svg_pattern import pattern_of_svg


def measured(pattern: Pattern, folder: Path, making: Making, stock: Stock) -> Pattern:
    laid = StripLayout(pattern, Bench(making, stock))
    return pattern_of_svg(laid.save(folder / "pattern.svg")).pattern


def check(found: Pattern, pattern: Pattern) -> None:
    """To a hundredth of a millimetre and of a degree: a file has micrometres, and edges are some mm long."""
    assert [each[:3] for each in found.strips] == [each[:3] for each in pattern.strips]
    assert [each.openings for each in found.strips] == [each.openings for each in pattern.strips]
    assert [each.length for each in found.strips] == pytest.approx(
        [each.length for each in pattern.strips], abs=2e-3
    )
    assert found.width == pytest.approx(pattern.width, abs=2e-3)
    for x in range(len(pattern.ribbons)):
        one, other = pattern.ribbons[x].tolist(), found.ribbons[x].tolist()
        turned = one != other or (one[0] == one[1] and abs(pattern.at[x, 0] - found.at[x, 0]) > 1)
        assert sorted(one) == sorted(other)
        at = found.at[x][::-1] if turned else found.at[x]
        off = at - pattern.at[x]
        for side in (0, 1):
            strip = pattern.strips[one[side]]
            away = (off[side] + 0.5 * strip.length) % strip.length - 0.5 * strip.length
            assert abs(away if strip.closed else off[side]) < 0.02, (x, off)
        wanted = -pattern.angle[x] if turned else pattern.angle[x]
        assert abs((found.angle[x] - wanted + 180) % 360 - 180) < 0.1
        assert found.over[x] == (1 - pattern.over[x] if turned else pattern.over[x])


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize(
    ("making", "stock"),
    [
        (Making(), Stock()),
        (Making(kerf=0.3, extra=6.0, mirror=True), Stock()),
        (Making(overlap=12.0, holes=2.0, score=True, labels="none"), Stock(150.0, 90.0, margin=4.0)),
    ],
    ids=["plain", "mirrored", "pieces"],
)
def test_what_is_measured_is_what_was_drawn(name: str, making: Making, stock: Stock, tmp_path: Path) -> None:
    pattern = patterns()[name]
    check(measured(pattern, tmp_path, making, stock), pattern)


def test_hoops_are_read_too(tmp_path: Path) -> None:
    document = hooped(cone().document(), None, 9.0)["weave.json"]
    laid = layout(document, Bench(Making(hoops=9.0)))
    found = pattern_of_svg(laid.save(tmp_path / "pattern.svg"))
    assert found.hoops == 9.0
    assert [each.hoop for each in found.pattern.strips] == [each.hoop for each in laid.pattern.strips]
    check(found.pattern, laid.pattern)


def test_a_mark_alone_says_where_a_crossing_is(tmp_path: Path) -> None:
    """On one of the two strips; the angle is then that of the other one."""
    path = layout(cone()).save(tmp_path / "cone.svg")[0]
    text = path.read_text(encoding="utf-8")
    before = pattern_of_svg([path]).pattern
    count = 0
    for x in range(len(before.ribbons)):
        line = f'class="over" data-crossing="{x}"'
        count += line in text
        text = text.replace(line, f'class="none" data-crossing="{x}"')
    assert count == len(before.ribbons)
    path.write_text(text, encoding="utf-8")
    after = pattern_of_svg([path]).pattern
    assert np.abs(after.at - before.at).max() < 0.02
    assert np.abs(after.angle - before.angle).max() < 0.1
    assert (after.over == before.over).all()


def test_a_line_that_is_moved_is_found(tmp_path: Path) -> None:
    """What is measured are the lines; nothing in the file says where a crossing is."""
    path = tmp_path / "pattern.svg"
    path.write_bytes(layout(cone()).save(tmp_path / "cone.svg")[0].read_bytes())
    text = path.read_text(encoding="utf-8")
    before = pattern_of_svg([path]).pattern
    start = text.index('class="over" data-crossing="7"')
    first = text.index(' d="', start) + 4
    last = text.index('"', first)
    # A path is a place and steps from there.
    moved = re.sub(r"M([\d.]+)", lambda found: f"M{float(found[1]) + 2:.3f}", text[first:last])
    path.write_text(text[:first] + moved + text[last:], encoding="utf-8")
    after = pattern_of_svg([path]).pattern
    off = np.abs(after.at - before.at)
    assert off[7].max() == pytest.approx(2.0, abs=0.01)
    assert np.delete(off, 7, axis=0).max() == 0.0


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("<svg", "<svg <", "cannot be read as an SVG"),
        ("data-kerf", "data-cut", "does not say how its strips are made"),
        ('data-piece="1/1"', 'data-piece="1/2"', "is not whole on these sheets"),
        ('data-family="0"', 'data-family="x"', "an entry of strip A1 is missing or wrong"),
        (
            'class="over" data-crossing="7"',
            'class="under" data-crossing="7"',
            "do not agree about crossing 7",
        ),
        ('data-crossing="7"', 'data-crossing="8"', "crossing 8 is drawn on"),
        ('class="outline"', 'class="line"', "an entry of strip"),
    ],
)
def test_refusals(old: str, new: str, words: str, tmp_path: Path) -> None:
    path = layout(cone()).save(tmp_path / "cone.svg")[0]
    text = path.read_text(encoding="utf-8")
    assert old in text
    path.write_text(text.replace(old, new, 1), encoding="utf-8")
    with pytest.raises(FieldError, match=words):
        pattern_of_svg([path])
