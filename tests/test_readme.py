"""README and docs say what the figures' files say, name nothing that is not there, and their lines run."""

from __future__ import annotations

import re
from pathlib import Path

import pandas as pd
import pytest

from geoweave import viz
from geoweave.meshing.write import write_mesh
from geoweave.models import datasets, shapes

ROOT = Path(__file__).resolve().parents[1]
README = (ROOT / "README.md").read_text(encoding="utf-8")
DOCS = {page.stem: page.read_text(encoding="utf-8") for page in sorted((ROOT / "docs").glob("*.md"))}
RESULTS = DOCS["results"]
TABLE = pd.read_csv(ROOT / "figures" / "paper" / "table1.csv")


@pytest.mark.parametrize("row", TABLE.to_dict("records"), ids=TABLE["model"])
def test_table_1_of_the_results_is_the_published_one(row):
    line = next(line for line in RESULTS.splitlines() if line.startswith(f"| {row['model']}"))
    cells = [cell.strip() for cell in line.strip("|").split("|")]
    assert cells[1:] == [
        f"{row['faces']:,}",
        f"{row['paper before']:.2f} → {row['paper after']:.2f}",
        f"{100 * row['paper drop']:.0f} %",
        f"{row['before']:.2f} → {row['after']:.2f}",
        f"{100 * row['drop']:.0f} %",
    ]


PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md")), ROOT / "figures" / "INDEX.md"]


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_links_lead_somewhere(page):
    """Every file exists, and so does every heading that a link names in a file of text."""
    targets = re.findall(r"\]\(([^)\s]+)\)", page.read_text(encoding="utf-8"))
    assert targets or page.parent.name == "docs"
    for target in targets:
        if target.startswith("https://"):
            continue
        file, _, heading = target.partition("#")
        path = page.parent / file if file else page
        assert path.exists(), target
        if heading:
            titles = re.findall(r"^#+ (.+)$", path.read_text(encoding="utf-8"), re.MULTILINE)
            assert heading in [re.sub(r"[^\w -]", "", each.lower()).replace(" ", "-") for each in titles], (
                target
            )


def test_the_readme_is_a_front_page():
    """What a reader needs first, in 400 words at most and with pictures."""
    assert len(README.split()) <= 400
    assert len(re.findall(r"^!\[", README, re.MULTILINE)) >= 2
    for page in DOCS:
        assert f"docs/{page}.md" in README


def test_embedded_scans_are_named():
    for name in datasets.names():
        if datasets.REGISTRY[name].embedded:
            assert f"`{name}`" in DOCS["commands"]


def test_second_table_and_vorticity_are_the_published_ones():
    gallery = pd.read_csv(ROOT / "figures" / "paper" / "fig08_gallery.csv").set_index("model")
    for name, model in (("rocker-arm.obj", "Rocker Arm"), ("cow.off", "Cow")):
        line = next(line for line in RESULTS.splitlines() if line.startswith(f"| {name}"))
        row = gallery.loc[model]
        assert line.endswith(f"| {row['curl after']:.2f}, {row['singularities']:.0f} |")
    before, after = (gallery[f"vorticity {when}"].max() for when in ("before", "after"))
    stated = re.search(r"falls from up to (\S+) in the smoothest field to (\S+) or less", RESULTS)
    assert stated is not None
    assert float(stated[1]) == pytest.approx(before, abs=0.005)
    assert after <= float(stated[2])


def test_the_table_of_integration_is_the_published_one():
    published = pd.read_csv(ROOT / "figures" / "paper" / "fig15_integration.csv")
    rows = published[published["model"] == "fertility"]
    for row in rows.to_dict("records")[:5]:
        line = f"| {row['method']} | {row['mean']:.1f}° | {row['median']:.1f}° | {row['dislocations']} |"
        assert line in RESULTS


def test_the_python_of_the_docs_runs_as_written(tmp_path, monkeypatch):
    """On coarser and fewer things than it says: what is tested is that every name and argument holds."""
    first, second = re.findall(r"```python\n(.*?)```", DOCS["python"], re.DOTALL)
    shown = []
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(viz.Picture, "show", lambda picture: shown.append(picture))
    write_mesh(shapes.cone(faces=400), "my-shape.obj")
    names: dict = {}
    exec(compile(first, "python.md", "exec"), names)
    assert (tmp_path / "torus.svg").stat().st_size > 10_000
    assert [picture.pixels.std() > 10 for picture in shown] == [True, True]
    assert names["relaxed"].converged
    exec(
        compile(
            second.replace("ribbons=80", "ribbons=8").replace("ribbons=30", "ribbons=12"), "python.md", "exec"
        ),
        names,
    )
    assert names["made"].files["weave.json"].is_file()
