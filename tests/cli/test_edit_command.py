"""``geoweave edit``: what is changed on the page is in the strips, from the browser to the pattern."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from browser import browser, opened

from geoweave.cli import main
from geoweave.cli.edit_command import NAMES
from geoweave.meshing.write import write_mesh
from geoweave.models import shapes
from geoweave.pipeline.editing import COMPARED
from geoweave.pipeline.weave_folder import earlier_report
from geoweave.weave import Edits, design_key

STILL = "viewer.still()"


@pytest.fixture(scope="module")
def woven(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("edit")
    write_mesh(shapes.cone(faces=600), folder / "cone.obj")
    options = "--faces given --ribbons 8 --size 120 --no-relax --formats pattern"
    words = ["weave", str(folder / "cone.obj"), *options.split(), "-o", str(folder / "woven")]
    assert main.main(words) == 0
    return folder / "woven"


def document(folder: Path, name: str = "weave.json") -> dict[str, Any]:
    return json.loads((folder / name).read_text(encoding="utf-8"))


def test_from_the_page_to_the_strips(woven: Path, tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    """Dropped and flipped with the mouse, and pinned; each is applied by the command."""
    page = tmp_path / "page.html"
    assert main.main(["show", str(woven), "-o", str(page), "--no-open"]) == 0
    before = document(woven)
    labels = [each["label"] for each in before["ribbons"]]
    x = next(x for x, each in enumerate(before["crossings"]) if 2 not in each["ribbons"])
    tip = before["surface"]["singularities"][0]
    with browser() as chromium, opened(chromium, page) as it:
        it.wait(STILL)

        def saved(name: str) -> str:
            with it.page.expect_download() as coming:
                it.page.click("#save")
            coming.value.save_as(tmp_path / name)
            return str(tmp_path / name)

        it.page.select_option("#ribbon", "2")
        it.page.click("#drop")
        it.do(f"viewer.select({{ kind: 'crossing', crossing: {x} }}, false)")
        it.page.click("#flip")
        changes = saved("changes.json")
        it.page.click("#undo")
        it.page.click("#undo")
        it.page.click("#steer summary")
        it.page.click("#modes [data-key=points]")
        it.page.select_option("#point", "0")
        it.page.click("#pin")
        pins = saved("pins.json")
        it.page.click("#move")
        it.do("viewer.go({ kind: 'ribbon', strip: 3 })")
        it.wait(STILL)
        box, at = (
            it.page.locator("#canvas").bounding_box(),
            it.do("viewer.seen({ kind: 'ribbon', strip: 3 })"),
        )
        it.page.mouse.click(box["x"] + at["x"], box["y"] + at["y"])
        moves = saved("moves.json")
        assert it.errors == []
    capfd.readouterr()
    assert main.main(["edit", str(woven), changes, "-o", str(tmp_path / "changed")]) == 0
    out = capfd.readouterr().out
    assert "1 ribbon dropped, 1 crossing flipped" in out
    assert f"{len(labels)} -> {len(labels) - 1}\n" in out
    strips = document(tmp_path / "changed", "pattern.json")
    assert [each["label"] for each in strips["strips"]] == [n for n in labels if n != labels[2]]
    after, pair = document(tmp_path / "changed"), before["crossings"][x]
    there = next(each for each in after["crossings"] if np.allclose(each["point"], pair["point"]))
    upper = pair["ribbons"][1 - pair["over_index"]]
    assert after["ribbons"][there["over"]]["label"] == labels[upper]
    # Pinned where it is, it is there again; moved, it is where the mouse put it.
    assert main.main(["edit", str(woven), pins, "-o", str(tmp_path / "pinned")]) == 0
    (kept,) = document(tmp_path / "pinned")["surface"]["singularities"]
    assert kept["point"] == pytest.approx(tip["point"], abs=1e-3)
    (goal,) = document(tmp_path, "moves.json")["singularities"]
    assert main.main(["edit", str(woven), moves, "-o", str(tmp_path / "moved")]) == 0
    (moved,) = document(tmp_path / "moved")["surface"]["singularities"]
    cone = shapes.cone(faces=600)
    inside = cone.vertices[~cone.boundary_vertices] * 120.0 / np.ptp(cone.vertices, axis=0).max()
    nearest = inside[np.linalg.norm(inside - goal["point"], axis=1).argmin()]
    assert moved["point"] == pytest.approx(nearest, abs=1e-6)
    assert np.linalg.norm(nearest - tip["point"]) > 5.0


def test_weave_with_edits_is_the_same_as_editing_its_folder(
    woven: Path, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    before = document(woven)
    edits = Edits(design_key(before), "mm", drop=(before["ribbons"][0]["label"],))
    file = tmp_path / "edits.json"
    file.write_text(json.dumps(edits.document()), encoding="utf-8")
    said = earlier_report(woven)["made_from"]
    assert main.main(["edit", str(woven), str(file), "-o", str(tmp_path / "one"), "--json"]) == 0
    found = json.loads(capfd.readouterr().out)
    count = len(before["ribbons"])
    assert found["differs"]["ribbons"] == {"before": count, "after": count - 1}
    assert (found["dropped"], found["flipped"], found["designed_anew"]) == (1, 0, False)
    options = "--faces given --ribbons 8 --size 120 --no-relax --formats pattern"
    words = ["weave", said["mesh"], *options.split(), "-o", str(tmp_path / "other"), "--edits", str(file)]
    assert main.main(words) == 0
    for name in ("weave.json", "pattern.json"):
        assert (tmp_path / "other" / name).read_bytes() == (tmp_path / "one" / name).read_bytes()


def test_what_cannot_be_applied_is_refused(
    woven: Path, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "edits.json"
    file.write_text(json.dumps(Edits("0" * 16, drop=("A1",)).document()), encoding="utf-8")
    assert main.main(["edit", str(woven), str(file)]) == 2
    assert "of another weave" in capfd.readouterr().err
    file.write_text("{}", encoding="utf-8")
    assert main.main(["edit", str(woven), str(file)]) == 2
    said = "edits.json: holds no edits; save it again from the page of 'geoweave show'"
    assert said in capfd.readouterr().err
    assert main.main(["edit", str(woven), str(tmp_path / "none.json")]) == 2


def test_every_number_that_may_differ_has_a_name() -> None:
    assert tuple(NAMES) == COMPARED
