"""A layout is saved by the ending of the name, like the files of a folder, and needs millimetres."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest
from laidflat import circles, cone, flat, patterns

from geoweave.errors import FieldError
from geoweave.fabrication.bench import Bench
from geoweave.fabrication.maker_files import write
from geoweave.fabrication.nesting import Stock
from geoweave.fabrication.strip_layout import layout
from geoweave.files import OutputError
from geoweave.rods.weave_at_rest import relaxed_weave

SAME = {
    "cutlist.csv": ("csv", "a.csv", "a4"),
    "pattern.json": ("pattern", "a.json", "a4"),
    "pattern.svg": ("svg", "a.svg", "a4"),
    "pattern.dxf": ("dxf", "a.DXF", "a4"),
    "pattern-a4.pdf": ("pdf", "a.pdf", "a4"),
    "pattern-letter.pdf": ("pdf", "a.pdf", "letter"),
    "weave.glb": ("glb", "a.glb", "a4"),
    "guide.html": ("guide", "a.html", "a4"),
}


@pytest.mark.parametrize("name", SAME)
def test_a_file_is_the_one_that_a_folder_gets(name: str, tmp_path: Path) -> None:
    kind, saved, paper = SAME[name]
    bench = Bench(papers=(paper,))
    files = write(patterns()["circles"], tmp_path / "all", [kind], weave=circles(), bench=bench)
    (path,) = layout(circles(), bench).save(tmp_path / saved, paper)
    assert path.name == Path(saved).with_suffix(Path(saved).suffix.lower()).name
    assert path.read_bytes() == files[name].read_bytes()


def test_a_weave_as_designed_and_at_rest_is_laid_out() -> None:
    designed, rest = layout(cone()), layout(relaxed_weave(cone()))
    for laid in (designed, rest):
        assert len(laid.pattern.strips) == len(cone().ribbons)
        assert sum(len(sheet.laid) for sheet in laid.sheets) == len(laid.pattern.strips)
        assert sorted(step.strip for step in laid.order) == list(range(len(laid.pattern.strips)))
    # What is relaxed has slid, so its strips are others.
    assert rest.pattern.document() != designed.pattern.document()


def test_several_sheets_are_several_files(tmp_path: Path) -> None:
    laid = layout(circles(), Bench(stock=Stock(220.0, 40.0)))
    paths = laid.save(tmp_path / "three.svg")
    assert [path.name for path in paths] == [f"three-{k:02d}.svg" for k in range(1, len(laid.sheets) + 1)]
    assert len(paths) > 1


def test_refusals_name_what_is_missing(tmp_path: Path) -> None:
    laid = layout(flat())
    with pytest.raises(OutputError, match=r"one of \.svg, \.dxf, \.pdf"):
        laid.save(tmp_path / "weave.stl")
    with pytest.raises(OutputError, match="no paper 'b5'"):
        laid.save(tmp_path / "weave.pdf", paper="b5")
    with pytest.raises(OutputError, match="there is no folder"):
        laid.save(tmp_path / "away" / "weave.svg")
    with pytest.raises(FieldError, match="needs lengths in mm"):
        layout(flat() | {"units": "mesh"})
    alone = layout(patterns()["flat"])
    for name, what in (("a.glb", "GLB"), ("a.html", "guide")):
        with pytest.raises(OutputError, match=f"the {what} needs the weave itself"):
            alone.save(tmp_path / name)
    assert list(tmp_path.iterdir()) == []


def test_libraries_of_a_format_are_loaded_by_those_who_write_it() -> None:
    code = (
        "import sys, geoweave.fabrication.strip_layout, geoweave.fabrication.maker_files;"
        "print(sorted({'reportlab', 'ezdxf', 'PIL', 'trimesh'} & set(sys.modules)))"
    )
    out = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout
    assert out.strip() == "[]"
