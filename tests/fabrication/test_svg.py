"""The SVG, read back: millimetres, layers, lengths, marks, and texts that meet nothing."""

from __future__ import annotations

from itertools import combinations
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest
from laidflat import NAMES, patterns, sheet
from numpy.typing import NDArray

from geoweave.errors import FieldError
from geoweave.fabrication.colours import Colours
from geoweave.fabrication.marks import DISC, MARKS, outline
from geoweave.fabrication.pieces import Making
from geoweave.fabrication.stroke_font import Box, boxes_overlap
from geoweave.fabrication.svg import read_svg, svg_text, write_svg
from geoweave.fabrication.svg_paths import path_lines

SVG = "{http://www.w3.org/2000/svg}"
INKSCAPE = "{http://www.inkscape.org/namespaces/inkscape}"


def read(name: str, colours: Colours | None = None, making: Making | None = None) -> ElementTree.Element:
    text = svg_text(patterns()[name], sheet(name, making), colours or Colours(), "a <title>")
    return ElementTree.fromstring(text)


def paths(element: ElementTree.Element) -> list[NDArray[np.float64]]:
    """The subpaths of a path, y upwards."""
    if element.tag == f"{SVG}circle":
        x, y, r = (float(element.attrib[each]) for each in ("cx", "cy", "r"))
        return [np.array([[x, -y]]) + r / DISC * outline(MARKS.index("disc"))]
    return [points * [1, -1] for points in path_lines(element.attrib["d"])]


def box(element: ElementTree.Element, pen: float) -> Box:
    points = np.concatenate(paths(element))
    return Box(*points.min(axis=0).tolist(), *points.max(axis=0).tolist()).grown(0.5 * pen)


def test_one_unit_is_a_millimetre() -> None:
    root = read("flat")
    width, height = (root.attrib[key] for key in ("width", "height"))
    assert width.endswith("mm")
    assert root.attrib["viewBox"] == f"0 0 {width[:-2]} {height[:-2]}"
    assert not [each for each in root.iter() if "transform" in each.attrib]
    assert root[0].text == "a <title>"


def test_layers_are_those_of_inkscape() -> None:
    for style, wanted in (
        ("laser", ["guide", "label", "score", "hole", "cut"]),
        ("paper", ["colour", "guide", "label", "score", "hole", "cut"]),
    ):
        root = read("flat", Colours(style), Making(extra=4.0, holes=2.0))
        groups = root.findall(f"{SVG}g")
        assert [each.attrib["id"] for each in groups] == wanted
        assert [each.attrib[f"{INKSCAPE}label"] for each in groups] == wanted
        assert {each.attrib[f"{INKSCAPE}groupmode"] for each in groups} == {"layer"}
    ids = [each.attrib["id"] for each in root.iter() if "id" in each.attrib]
    assert len(ids) == len(set(ids))


@pytest.mark.parametrize("name", NAMES)
def test_strips_are_as_long_as_their_ribbons(name: str) -> None:
    pattern = patterns()[name]
    root = read(name, making=Making(overlap=20.0))
    for strip in pattern.strips:
        (group,) = [each for each in root.iter(f"{SVG}g") if each.attrib.get("id") == f"cut-{strip.label}"]
        (cut,) = group
        around = box(cut, 0.0)
        tab = 20.0 if strip.closed else 0.0
        assert around.right - around.left - tab == pytest.approx(strip.length, abs=0.01)
        assert around.top - around.bottom == pytest.approx(pattern.width, abs=0.01)


@pytest.mark.parametrize("name", NAMES)
def test_crossings_are_where_they_belong_with_equal_marks(name: str) -> None:
    """Each crossing is on two strips, one hollow and one solid, with the shape of its mark."""
    pattern, root = patterns()[name], read(name)
    seen: dict[int, list[str]] = {}
    for group in root.iter(f"{SVG}g"):
        if not group.attrib["id"].startswith("guide-"):
            continue
        for each in group:
            if each.attrib["class"] in ("hollow", "solid"):
                x = int(each.attrib["data-crossing"])
                seen.setdefault(x, []).append(each.attrib["class"])
                (shape,), wanted = paths(each), outline(int(pattern.mark[x]))
                size = np.ptp(shape[:, 0]) / np.ptp(wanted[:, 0])
                np.testing.assert_allclose(shape - shape[0], size * (wanted - wanted[0]), atol=0.02)
    assert sorted(seen) == list(range(len(pattern.ribbons)))
    closed = {x for x, pair in enumerate(pattern.ribbons) if any(pattern.strips[r].closed for r in pair)}
    for x, roles in seen.items():
        assert set(roles) == {"hollow", "solid"}
        assert len(roles) == 2 or x in closed  # the tab of a closed strip repeats its start


@pytest.mark.parametrize("name", NAMES)
def test_texts_meet_no_mark_and_no_text(name: str) -> None:
    for style in ("laser", "paper"):
        boxes = []
        for layer in read(name, Colours(style)).findall(f"{SVG}g"):
            for each in layer.iter():
                # What most of a layer has in common is said of the layer.
                pen = each.attrib.get("stroke-width", layer.attrib.get("stroke-width", "0"))
                if each.attrib.get("class") in ("label", "name"):
                    boxes.append(box(each, float(pen)))
                elif each.attrib.get("class") in ("hollow", "solid"):
                    boxes.append(box(each, 0.0))
        assert len(boxes) > 3
        assert not any(boxes_overlap(one, other) for one, other in combinations(boxes, 2))


def test_angles_turn_to_the_left_as_seen_on_the_sheet() -> None:
    """On A1 the lines of family B lean to the right at 60 degrees, those of C at 120: not mirrored."""
    pattern, root = patterns()["flat"], read("flat")
    (group,) = [each for each in root.iter(f"{SVG}g") if each.attrib.get("id") == "guide-A1"]
    for passage in pattern.passages[0]:
        for each in group:
            if each.attrib.get("data-crossing") == str(passage.crossing) and each.attrib["class"] in (
                "over",
                "under",
            ):
                steps = np.concatenate([np.diff(path, axis=0) for path in paths(each)])
                angles = np.degrees(np.arctan2(steps[:, 1], steps[:, 0])) % 180
                wanted = 60.0 if passage.label.startswith("B") else 120.0
                long = np.hypot(*steps.T) > 0.3
                np.testing.assert_allclose(angles[long], wanted, atol=0.1)


def test_the_same_weave_gives_the_same_bytes(tmp_path: Path) -> None:
    for name in ("one.svg", "two.svg"):
        write_svg(tmp_path / name, patterns()["cone"], sheet("cone"), Colours(), "cone")
    assert (tmp_path / "one.svg").read_bytes() == (tmp_path / "two.svg").read_bytes()


@pytest.mark.parametrize("name", NAMES)
def test_what_is_drawn_is_read(name: str, tmp_path: Path) -> None:
    pattern, path = patterns()[name], tmp_path / "drawn.svg"
    path.write_text(svg_text(pattern, sheet(name), Colours(), name), encoding="utf-8")
    lengths, marks = read_svg(path)
    for strip in pattern.strips:
        tab = Making().overlap if strip.closed else 0.0
        assert lengths[strip.label] - tab == pytest.approx(strip.length, abs=0.01)
    upper = {
        (x, pattern.strips[pair[side]].label, "hollow" if pattern.over[x] == side else "solid")
        for x, pair in enumerate(pattern.ribbons)
        for side in (0, 1)
    }
    assert not {each[:3] for each in marks} ^ upper
    shapes = [{each.outline for each in marks if each.crossing == x} for x in range(len(pattern.ribbons))]
    assert all(len(each) == 1 for each in shapes)
    assert len(set.union(*shapes)) == len(set(pattern.mark.tolist()))


def test_what_is_no_svg_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "text.svg"
    path.write_text("<svg><g>")
    with pytest.raises(FieldError, match=r"text.svg: cannot be read as an SVG"):
        read_svg(path)


def test_arrows_are_one_path_and_nicks_are_not() -> None:
    """What belongs to a crossing stays an element; arrows are many, and say nothing by themselves."""
    root, count = read("flat", making=Making(score=True)), len(patterns()["flat"].ribbons)
    assert len([each for each in root.iter() if each.attrib.get("class") == "nick"]) == 2 * count
    for group in root.iter(f"{SVG}g"):
        arrows = [each for each in group if each.attrib.get("class") == "heading"]
        # one for each colour that partners have
        assert len(arrows) <= 2
        assert all("data-crossing" not in each.attrib for each in arrows)
        assert all(len(path) == 3 for each in arrows for path in paths(each))
