"""``geoweave cut``: every option, in the files that it writes."""

from __future__ import annotations

import csv
import io
import json
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np
import pytest
from laidflat import circles, cone, flat

from geoweave.cli import main
from geoweave.fabrication.svg import read_svg
from geoweave.fabrication.svg_paths import path_lines
from geoweave.pipeline.weave_folder import write_weave

SVG = "{http://www.w3.org/2000/svg}"

Run = Callable[..., dict[str, Any]]


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A weave of twelve strips 8 mm wide and 150 mm long, every angle known."""
    found = tmp_path / "flat"
    found.mkdir()
    (found / "weave.json").write_text(json.dumps(flat()), encoding="utf-8")
    return found


@pytest.fixture
def cut(folder: Path, capfd: pytest.CaptureFixture[str]) -> Run:
    def run(*options: str, status: int = 0, of: Path = folder) -> dict[str, Any]:
        code = main.main(["cut", str(of), "-o", str(folder.with_name("cut")), "--json", *options])
        out, err = capfd.readouterr()
        assert code == status, err
        return {"error": err} if status else json.loads(out)

    return run


def root(folder: Path, name: str = "pattern.svg") -> ElementTree.Element:
    return ElementTree.parse(folder.with_name("cut") / name).getroot()


def paths(tree: ElementTree.Element, role: str) -> list[ElementTree.Element]:
    return [each for each in tree.iter() if each.get("class") == role]


def box(element: ElementTree.Element) -> tuple[float, float, float, float]:
    """Of a path of straight lines."""
    points = np.concatenate(path_lines(element.get("d", "")))
    return (*points.min(axis=0).tolist(), *points.max(axis=0).tolist())


@pytest.mark.parametrize(
    ("sheet", "size"),
    [("300x200", (300, 200)), ("12x24in", (609.6, 304.8)), ("a3", (420, 297)), ("letter", (279.4, 215.9))],
)
def test_sheet(cut: Run, folder: Path, sheet: str, size: tuple[float, float]) -> None:
    result = cut("--sheet", sheet, "--formats", "svg")
    tree = root(folder)
    assert [float(tree.get(each, "").removesuffix("mm")) for each in ("width", "height")] == list(size)
    assert result["sheet_size"] == list(size)
    for each in paths(tree, "outline"):
        left, top, right, bottom = box(each)
        assert left >= 5 - 1e-3
        assert top >= 5 - 1e-3
        assert right <= size[0] - 5 + 1e-3
        assert bottom <= size[1] - 5 + 1e-3


def test_roll(cut: Run, folder: Path) -> None:
    """As high as the roll is wide, in one piece each, and no longer than it must be."""
    cut("--sheet", "roll:40", "--margin", "2", "--formats", "svg")
    tree = root(folder)
    assert tree.get("height") == "40mm"
    assert len(paths(tree, "outline")) == 12
    # four strips of 8 mm and their gaps fit across 36 mm
    total = sum(box(each)[2] - box(each)[0] + 1 for each in paths(tree, "outline"))
    assert total / 4 < float(tree.get("width", "").removesuffix("mm")) < 1.2 * total / 4


def test_margin_gap_kerf_and_width(cut: Run, folder: Path) -> None:
    cut(
        "--margin",
        "9",
        "--gap",
        "3",
        "--kerf",
        "0.4",
        "--width",
        "6",
        "--formats",
        "svg",
        "--sheet",
        "300x200",
    )
    boxes = sorted(box(each) for each in paths(root(folder), "outline"))
    assert min(each[0] for each in boxes) == pytest.approx(9, abs=1e-3)
    assert {round(each[3] - each[1], 3) for each in boxes} == {6.4}
    assert max(round(each[2] - each[0], 3) for each in boxes) == 150.4
    tops = sorted({round(each[1], 3) for each in boxes})
    assert np.diff(tops).tolist() == pytest.approx([6.4 + 3] * (len(tops) - 1), abs=1e-3)


def test_paper(cut: Run, folder: Path) -> None:
    import pypdfium2 as pdfium

    result = cut("--paper", "a3,tabloid", "--formats", "pdf")
    assert set(result["pages"]) == {"a3", "tabloid"}
    for name, size in (("a3", (420, 297)), ("tabloid", (431.8, 279.4))):
        document = pdfium.PdfDocument(folder.with_name("cut") / f"pattern-{name}.pdf")
        assert document[0].get_size() == pytest.approx([72 / 25.4 * each for each in size], abs=0.01)


def test_overlap_and_pieces_agree(cut: Run, folder: Path) -> None:
    """On a sheet of 110 mm every strip has two pieces, in the table, in the drawing and in the pattern."""
    result = cut("--sheet", "110x90", "--overlap", "10", "--formats", "svg,csv,pattern")
    text = (folder.with_name("cut") / "cutlist.csv").read_text(encoding="utf-8")
    rows = list(csv.DictReader(io.StringIO(text.split("\n\n")[0])))
    assert len(rows) == result["pieces"] == 24
    assert {row["piece"] for row in rows} == {"1/2", "2/2"}
    sums: dict[str, float] = {}
    for row in rows:
        sums[row["strip"]] = sums.get(row["strip"], 0.0) + float(row["cut_mm"])
    strips = {row["strip"]: float(row["length_mm"]) for row in rows}
    assert sums == pytest.approx({strip: length + 10 for strip, length in strips.items()}, abs=0.02)
    names = sorted(folder.with_name("cut").glob("pattern-*.svg"))
    assert sum(len(paths(root(folder, each.name), "outline")) for each in names) == 24
    assert json.loads((folder.with_name("cut") / "pattern.json").read_text())["making"]["overlap"] == 10


def test_index_cut_list_pages_and_guide_agree(cut: Run, folder: Path) -> None:
    """Each piece stands by name on the page that the cut list and the guide say, and on no other."""
    import pypdfium2 as pdfium

    cut("--sheet", "110x90", "--paper", "a4", "--formats", "svg,csv,pdf,guide")
    made = folder.with_name("cut")
    document = pdfium.PdfDocument(made / "pattern-a4.pdf")
    pages = [document[k].get_textpage().get_text_range() for k in range(len(document))]
    page = (made / "guide.html").read_text(encoding="utf-8")
    found = re.search(r'<script id="content" type="application/json">(.*?)</script>', page, re.DOTALL)
    assert found is not None
    content = json.loads(found[1].replace("<\\/", "</"))
    said = dict(zip((each[0] for each in content["strips"]), content["found"], strict=True))
    text = (made / "cutlist.csv").read_text(encoding="utf-8")
    rows = list(csv.DictReader(io.StringIO(text.split("\n\n")[0])))
    assert len(rows) == 24
    for row in rows:
        name = f"{row['strip']} {row['piece']}"
        assert [k for k, each in enumerate(pages, 1) if f"{name} >" in each] == [int(row["a4_page"])]
        assert f"{name}: page {row['a4_page']}, row {row['a4_row']}" in pages[0]
        assert f"{row['piece']} A4 page {row['a4_page']}, row {row['a4_row']}" in said[row["strip"]]
        sheet = root(folder, f"pattern-{int(row['sheet_page']):02d}.svg")
        assert f"cut-{name.replace(' ', '-').split('/')[0]}" in {each.get("id") for each in sheet.iter()}


def test_end_and_extra(cut: Run, folder: Path) -> None:
    ends = {}
    for end in ("4", "12"):
        cut("--end", end, "--formats", "pattern")
        document = json.loads((folder.with_name("cut") / "pattern.json").read_text())
        strip = document["strips"][0]
        ends[end] = strip["crossings"][0]["at"], strip["length"]
    assert ends["4"][0] == pytest.approx(4)
    assert ends["12"][0] == pytest.approx(12)
    assert 8 < ends["12"][1] - ends["4"][1] <= 16
    cut("--end", "4", "--extra", "7", "--formats", "svg")
    widths = [box(each)[2] - box(each)[0] for each in paths(root(folder), "outline")]
    assert max(abs(wide - ends["4"][1] - 14) for wide in widths) >= 0
    assert min(abs(wide - ends["4"][1] - 14) for wide in widths) < 1e-3


def test_stock_length(cut: Run, folder: Path) -> None:
    cut("--stock-length", "310", "--formats", "csv")
    text = (folder.with_name("cut") / "cutlist.csv").read_text(encoding="utf-8")
    assert "stock_length_m,0.310" in text
    assert "pieces_per_stock_length,2 2 2 2 2 2" in text


def test_thickness_counts_in_the_weight(cut: Run) -> None:
    one, two = (cut("--thickness", each, "--formats", "csv")["bill"]["grams"] for each in ("0.5", "1.5"))
    assert two == pytest.approx(3 * one)


def test_mirror_turns_the_angles_and_not_the_letters(cut: Run, folder: Path) -> None:
    found = []
    for options in ((), ("--mirror",)):
        cut("--formats", "svg,pattern", *options)
        tree = root(folder)
        (outline,) = (each for each in tree.iter(f"{SVG}g") if each.get("id") == "cut-A1")
        left, top, _, bottom = box(outline[0])
        lines = {}
        for each in paths(tree, "under"):
            start = path_lines(each.get("d", ""))[0]
            if top <= start[0, 1] <= bottom and left <= start[0, 0] <= left + 150:
                way = start[1] - start[0]
                lines[each.get("data-crossing")] = float(np.degrees(np.arctan2(-way[1], way[0])) % 180)
        found.append(lines)
        assert (
            json.loads((folder.with_name("cut") / "pattern.json").read_text())["strips"][0]["label"] == "A1"
        )
    plain, mirrored = found
    assert plain
    for crossing, angle in plain.items():
        assert abs((angle + mirrored[crossing] + 90) % 180 - 90) < 0.1


def test_holes_are_at_both_strips_of_a_crossing(cut: Run, folder: Path) -> None:
    cut("--holes", "2.5", "--kerf", "0.1", "--formats", "svg,pattern")
    document = json.loads((folder.with_name("cut") / "pattern.json").read_text())
    tree = root(folder)
    seen = 0
    for strip in document["strips"]:
        (outline,) = (e[0] for e in tree.iter(f"{SVG}g") if e.get("id") == f"cut-{strip['label']}")
        left, top, _, bottom = box(outline)
        (group,) = (e for e in tree.iter(f"{SVG}g") if e.get("id") == f"hole-{strip['label']}")
        holes = sorted((float(e.get("cx", "")), float(e.get("cy", "")), float(e.get("r", ""))) for e in group)
        wanted = sorted(each["at"] for each in strip["crossings"])
        assert len(holes) == len(wanted)
        for (x, y, radius), at in zip(holes, wanted, strict=True):
            assert abs(x - (left + 0.05) - at) < 0.1
            assert y == pytest.approx(0.5 * (top + bottom), abs=1e-3)
            assert radius == pytest.approx(1.2, abs=1e-3)
            seen += 1
    assert seen == 2 * len(document["crossings"])


def test_score(cut: Run, folder: Path) -> None:
    cut("--score", "--formats", "svg,pattern")
    crossings = len(json.loads((folder.with_name("cut") / "pattern.json").read_text())["crossings"])
    nicks = paths(root(folder), "nick")
    assert len(nicks) == 2 * crossings
    assert all(each.get("d", "").upper().count("M") == 2 for each in nicks)


def test_colours(cut: Run, folder: Path) -> None:
    cut("--formats", "svg")
    laser = (folder.with_name("cut") / "pattern.svg").read_text()
    assert "#ff0000" in laser
    cut("--formats", "svg", "--colours", "#112233,#445566,#778899")
    own = (folder.with_name("cut") / "pattern.svg").read_text()
    assert "#ff0000" not in own
    assert 'id="colour"' in own
    assert "exclude" not in cut("--formats", "svg", "--colours", "#1122", status=2)["error"]


def test_labels(cut: Run, folder: Path) -> None:
    texts = {}
    for labels in ("engraved", "printed", "none"):
        result = cut("--labels", labels, "--formats", "svg")
        tree = root(folder)
        texts[labels] = sorted(each.text or "" for each in tree.iter(f"{SVG}text"))
        strokes = [each.get("data-text") for each in tree.iter(f"{SVG}path") if each.get("data-text")]
        if labels == "engraved":
            assert "A1 >" in strokes
        else:
            assert not strokes
            assert (result["smallest_text_mm"] is None) == (labels == "none")
    assert "A1 >" in texts["printed"]
    assert not texts["none"]
    assert not texts["engraved"]


def test_hoops(cut: Run, tmp_path: Path) -> None:
    """A closed strip round the rim, and the same mark on it and on the ribbon that meets it."""
    write_weave(cone(), tmp_path / "cone")
    result = cut("--hoops", "9", "--formats", "svg,csv,pattern", of=tmp_path / "cone")
    assert result["strips"] == len(cone().ribbons) + 1
    lengths, marks = read_svg(tmp_path / "cut" / "pattern.svg")
    rim = cone().document()["surface"]["openings"][0]["points"]
    length = float(np.linalg.norm(np.diff([*rim, rim[0]], axis=0), axis=1).sum())
    assert lengths["H1"] == pytest.approx(length + 15, abs=1e-2)  # with its tab
    on_hoop = {(each.crossing, each.outline): each.role for each in marks if each.strip == "H1"}
    others = {(e.crossing, e.outline): e.role for e in marks if e.strip != "H1" and e.crossing >= 0}
    assert len(on_hoop) > 6
    for key, role in on_hoop.items():
        assert {role, others[key]} == {"hollow", "solid"}
    text = (tmp_path / "cut" / "cutlist.csv").read_text(encoding="utf-8")
    assert [row["strip"] for row in csv.DictReader(io.StringIO(text.split("\n\n")[0]))][-1] == "H1"
    error = cut("--hoops", "1", of=tmp_path / "cone", status=2)["error"]
    assert "give --hoops" in error
    assert error.count("\n") == 1


def test_layers_come_in_working_order(cut: Run, folder: Path) -> None:
    cut("--holes", "2", "--score", "--formats", "svg")
    layers = [each.get("id") for each in root(folder).findall(f"{SVG}g")]
    assert layers == ["guide", "label", "score", "hole", "cut"]


def test_presets_give_their_numbers_and_options_come_before_them(cut: Run, folder: Path) -> None:
    result = cut("--preset", "veneer-laser", "--formats", "svg,csv")
    assert result["sheet_size"] == [600.0, 400.0]
    assert result["thickness"] == 0.6
    wide = {round(box(each)[3] - box(each)[1], 3) for each in paths(root(folder), "outline")}
    assert wide == {8.15}
    cut("--preset", "veneer-laser", "--kerf", "0.3", "--formats", "svg")
    wide = {round(box(each)[3] - box(each)[1], 3) for each in paths(root(folder), "outline")}
    assert wide == {8.3}


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (("--holes", "7.6"), "holes of 7 mm or less"),
        (("--sheet", "300x12"), "take a sheet of 18 mm or more"),
        (("--sheet", "roll:30x100"), "take a roll of 160 mm or more"),
        (("--sheet", "600"), "WIDTHxHEIGHT"),
        (("--paper", "b5"), "the papers are a4, letter, a3, tabloid"),
        (("--preset", "granite"), "the presets are edge-banding"),
        (("--labels", "golden"), "engraved, printed, none"),
        (("--overlap", "0.5"), "1 mm or more"),
        (("--sheet", "40x40"), "a sheet that holds 30 mm"),
        (("--width", "0.3"), "cannot be 0.5 mm thick"),
        (("--formats", "stl"), "no format 'stl'"),
        (("--colours", "red"), "#rrggbb"),
        (("--kerf", "nan"), "kerf"),
    ],
)
def test_what_cannot_be_is_refused_with_what_would_work(
    cut: Run, folder: Path, options: tuple[str, ...], words: str
) -> None:
    error = cut(*options, status=2)["error"]
    assert words in error
    assert error.count("\n") == 1
    assert not folder.with_name("cut").exists()


def test_a_folder_without_a_weave_in_mm_is_refused(cut: Run, tmp_path: Path) -> None:
    (tmp_path / "empty").mkdir()
    assert "holds no weave.json" in cut(of=tmp_path / "empty", status=2)["error"]
    (tmp_path / "empty" / "weave.json").write_text(json.dumps(flat() | {"units": "mesh"}))
    assert "is not in mm" in cut(of=tmp_path / "empty", status=2)["error"]


def test_the_same_files_as_weave_writes(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    """What weave writes is what cut writes of the same folder, byte by byte."""
    from geoweave.fabrication.bench import Bench
    from geoweave.fabrication.maker_files import jobs_of
    from geoweave.pipeline.cut_request import CutRequest
    from geoweave.pipeline.strips import strips_of

    formats = ("pattern", "csv", "svg", "pdf")
    strips = strips_of(cone(), None)
    bench: Bench = CutRequest().bench("woven")
    write_weave(cone(), tmp_path / "woven", more=jobs_of(strips.pattern, formats, bench=bench, weave=cone()))
    before = {path.name: path.read_bytes() for path in (tmp_path / "woven").iterdir()}
    assert main.main(["cut", str(tmp_path / "woven")]) == 0
    out = capfd.readouterr().out
    after = {path.name: path.read_bytes() for path in (tmp_path / "woven").iterdir()}
    assert set(after) == set(before)
    assert {name for name in after if after[name] != before[name]} == {"report.json"}
    for word in ("smallest text", "fasten", "work", "about"):
        assert word in out


def test_in_place_what_is_no_longer_written_goes_and_the_weave_stays(tmp_path: Path) -> None:
    write_weave(cone(), tmp_path / "woven")
    here = tmp_path / "woven"
    weave = (here / "weave.json").read_bytes()
    assert main.main(["cut", str(here), "--formats", "svg,csv"]) == 0
    assert main.main(["cut", str(here), "--formats", "svg", "--sheet", "a4"]) == 0
    names = {path.name for path in here.iterdir()}
    assert "cutlist.csv" not in names
    assert (here / "weave.json").read_bytes() == weave
    report = json.loads((here / "report.json").read_text())
    assert set(report["files"]) == names - {"report.json"}
    assert report["cut"]["request"]["sheet"] == "a4"


def test_a_closed_strip_has_its_holes_on_the_tab_too(
    tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "ball").mkdir()
    (tmp_path / "ball" / "weave.json").write_text(json.dumps(circles()))
    assert main.main(["cut", str(tmp_path / "ball"), "--holes", "2", "--formats", "svg"]) == 0
    tree = ElementTree.parse(tmp_path / "ball" / "pattern.svg").getroot()
    (group,) = (e for e in tree.iter(f"{SVG}g") if e.get("id") == "hole-A1")
    (outline,) = (e[0] for e in tree.iter(f"{SVG}g") if e.get("id") == "cut-A1")
    at = sorted(float(e.get("cx", "")) - box(outline)[0] for e in group)
    once = 2 * np.pi * 60
    assert at[-1] - at[0] == pytest.approx(at[-1], abs=1e-6) or any(
        abs(b - a - once) < 0.1 for a in at for b in at
    )
    capfd.readouterr()
