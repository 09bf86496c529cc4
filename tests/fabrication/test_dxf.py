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
    assert kinds == {("LWPOLYLINE", layer) for layer in ("cut", "score", "guide", "label")} | {
        ("HATCH", "guide")
    }


def test_every_crossing_is_solid_on_one_strip_and_hollow_on_the_other(tmp_path: Path) -> None:
    pattern, drawing = patterns()["cone"], read("cone", tmp_path)
    seen: dict[int, set[tuple[str, str]]] = {}
    for line in drawing.modelspace().query('LWPOLYLINE[layer=="guide"]'):
        label, _, role, crossing = [tag.value for tag in line.get_xdata(APPLICATION)]
        if role in ("hollow", "solid"):
            seen.setdefault(crossing, set()).add((label, role))
    for x, pair in enumerate(pattern.ribbons):
        above, below = pair[pattern.over[x]], pair[1 - pattern.over[x]]
        assert seen[x] == {(pattern.strips[above].label, "hollow"), (pattern.strips[below].label, "solid")}
    hatches = len(drawing.modelspace().query("HATCH"))
    assert hatches == len(pattern.ribbons)


def test_the_same_weave_gives_the_same_bytes_and_the_library_is_left_as_it_was(tmp_path: Path) -> None:
    data = []
    for _ in range(2):
        read("circles", tmp_path)
        data.append((tmp_path / "pattern.dxf").read_bytes())
        assert options.write_fixed_meta_data_for_testing is False
    assert data[0] == data[1]
