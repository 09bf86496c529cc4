"""The DXF, read back by its library: version, unit, layers, lengths, marks."""

from __future__ import annotations

from pathlib import Path

import ezdxf
import numpy as np
import pytest
from ezdxf._options import options
from ezdxf.document import Drawing
from laidflat import patterns, sheet

from geoweave.fabrication.colours import Colours
from geoweave.fabrication.dxf import APPLICATION, write_dxf
from geoweave.fabrication.pieces import Making
from geoweave.fabrication.presets import Labels


def read(name: str, folder: Path, colours: Colours | None = None) -> Drawing:
    write_dxf(folder / "pattern.dxf", patterns()[name], sheet(name), colours or Colours())
    return ezdxf.readfile(folder / "pattern.dxf")


@pytest.mark.parametrize("name", ["circles", "bow tie", "cone"])
def test_strips_are_as_long_as_their_ribbons(name: str, tmp_path: Path) -> None:
    pattern, drawing = patterns()[name], read(name, tmp_path)
    found = {}
    for line in drawing.modelspace().query('LWPOLYLINE[layer=="cut"]'):
        assert line.closed
        (label, *_), points = (
            [tag.value for tag in line.get_xdata(APPLICATION)],
            np.array(line.get_points("xy")),
        )
        found[label] = np.ptp(points, axis=0)
    assert sorted(found) == sorted(strip.label for strip in pattern.strips)
    for strip in pattern.strips:
        tab = 15.0 if strip.closed else 0.0
        np.testing.assert_allclose(found[strip.label], [strip.length + tab, pattern.width], atol=0.01)


def test_version_unit_and_layers(tmp_path: Path) -> None:
    drawing = read("circles", tmp_path, Colours(cut="#ff8000"))
    assert drawing.acad_release == "R2010"
    assert drawing.units == ezdxf.units.MM
    assert {"cut", "score", "guide", "label"} <= {layer.dxf.name for layer in drawing.layers}
    assert drawing.layers.get("cut").rgb == (255, 128, 0)
    assert not drawing.audit().errors
    kinds = {(each.dxftype(), each.dxf.layer) for each in drawing.modelspace()}
    assert kinds == {
        ("LWPOLYLINE", "cut"),
        ("LINE", "score"),
        ("LINE", "guide"),
        ("LWPOLYLINE", "guide"),
        ("INSERT", "guide"),
        ("INSERT", "label"),
    }


def test_layers_come_in_working_order_and_arcs_are_arcs(tmp_path: Path) -> None:
    pattern = patterns()["cone"]
    laid = sheet("cone", Making(holes=3.0, score=True))
    write_dxf(tmp_path / "pattern.dxf", pattern, laid, Colours())
    drawing = ezdxf.readfile(tmp_path / "pattern.dxf")
    layers = [each.dxf.layer for each in drawing.modelspace()]
    assert list(dict.fromkeys(layers)) == ["guide", "label", "score", "hole", "cut"]
    assert layers == sorted(layers, key=["guide", "label", "score", "hole", "cut"].index)
    holes = drawing.modelspace().query("CIRCLE")
    assert {each.dxf.radius for each in holes} == {1.5}
    assert len(holes) >= 2 * len(pattern.ribbons)
    discs = [block for block in drawing.blocks if block.name.startswith("DISC")]
    assert all(each.dxftype() in ("CIRCLE", "HATCH") for block in discs for each in block)


@pytest.mark.parametrize("labels", ["engraved", "printed"])
def test_names_are_blocks_of_lines_or_texts(labels: Labels, tmp_path: Path) -> None:
    laid = sheet("cone", Making(labels=labels))
    write_dxf(tmp_path / "pattern.dxf", patterns()["cone"], laid, Colours())
    space = ezdxf.readfile(tmp_path / "pattern.dxf").modelspace()
    wanted = [f for piece in laid.laid for f in piece.figures if f.text]
    kind = "TEXT" if labels == "printed" else "INSERT"
    found = list(space.query(f'{kind}[layer=="label"]'))
    assert len(found) == len(wanted) == len(space.query('*[layer=="label"]'))
    for each, figure in zip(found, sorted(wanted, key=lambda f: 0), strict=True):
        points = np.concatenate(figure.paths)
        if labels == "printed":
            assert (each.dxf.text, round(each.dxf.height, 3)) == (figure.text, round(figure.spot.size, 3))
        else:
            # the lines of the block are those of the drawing
            lines = [
                np.array(e.get_points("xy"))
                if e.dxftype() == "LWPOLYLINE"
                else np.array([e.dxf.start.vec2, e.dxf.end.vec2])
                for e in each.virtual_entities()
            ]
            np.testing.assert_allclose(np.concatenate(lines), points, atol=1e-2)


def test_every_crossing_is_solid_on_one_strip_and_hollow_on_the_other(tmp_path: Path) -> None:
    pattern, drawing = patterns()["cone"], read("cone", tmp_path)
    seen: dict[int, set[tuple[str, str]]] = {}
    for line in drawing.modelspace().query('INSERT[layer=="guide"]'):
        label, _, role, crossing = [tag.value for tag in line.get_xdata(APPLICATION)]
        if role in ("hollow", "solid"):
            seen.setdefault(crossing, set()).add((label, role))
    for x, pair in enumerate(pattern.ribbons):
        above, below = pair[pattern.over[x]], pair[1 - pattern.over[x]]
        assert seen[x] == {(pattern.strips[above].label, "hollow"), (pattern.strips[below].label, "solid")}
    for block in drawing.blocks:
        kinds = [each.dxftype() for each in block]
        assert ("HATCH" in kinds) == block.name.endswith("_SOLID")


def test_the_same_weave_gives_the_same_bytes_and_the_library_is_left_as_it_was(tmp_path: Path) -> None:
    data = []
    for _ in range(2):
        read("circles", tmp_path)
        data.append((tmp_path / "pattern.dxf").read_bytes())
        assert options.write_fixed_meta_data_for_testing is False
    assert data[0] == data[1]
