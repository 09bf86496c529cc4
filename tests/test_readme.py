"""The README says what the figures' files say, and names nothing that is not there."""

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
TABLE = pd.read_csv(ROOT / "figures" / "paper" / "table1.csv")


@pytest.mark.parametrize("row", TABLE.to_dict("records"), ids=TABLE["model"])
def test_table_1_in_the_readme_is_the_published_one(row):
    line = next(line for line in README.splitlines() if line.startswith(f"| {row['model']}"))
    cells = [cell.strip() for cell in line.strip("|").split("|")]
    assert cells[1:] == [
        f"{row['faces']:,}",
        f"{row['paper before']:.2f} → {row['paper after']:.2f}",
        f"{100 * row['paper drop']:.0f} %",
        f"{row['before']:.2f} → {row['after']:.2f}",
        f"{100 * row['drop']:.0f} %",
    ]


def test_links_lead_somewhere():
    targets = re.findall(r"\]\(([^)#]+)\)", README)
    assert len(targets) > 15
    for target in targets:
        if not target.startswith("https://"):
            assert (ROOT / target).exists(), target


def test_embedded_scans_are_named():
    for name in datasets.names():
        if datasets.REGISTRY[name].embedded:
            assert f"`{name}`" in README


def test_second_table_and_vorticity_are_the_published_ones():
    gallery = pd.read_csv(ROOT / "figures" / "paper" / "fig08_gallery.csv").set_index("model")
    for name, model in (("rocker-arm.obj", "Rocker Arm"), ("cow.off", "Cow")):
        line = next(line for line in README.splitlines() if line.startswith(f"| {name}"))
        row = gallery.loc[model]
        assert line.endswith(f"| {row['curl after']:.2f}, {row['singularities']:.0f} |")
    before, after = (gallery[f"vorticity {when}"].max() for when in ("before", "after"))
    stated = re.search(r"falls from up to (\S+) in the smoothest field to (\S+) or less", README)
    assert stated is not None
    assert float(stated[1]) == pytest.approx(before, abs=0.005)
    assert after <= float(stated[2])


def test_the_table_of_integration_is_the_published_one():
    published = pd.read_csv(ROOT / "figures" / "paper" / "fig15_integration.csv")
    rows = published[published["model"] == "fertility"]
    for row in rows.to_dict("records")[:5]:
        line = f"| {row['method']} | {row['mean']:.1f}° | {row['median']:.1f}° | {row['dislocations']} |"
        assert line in README


def test_the_python_of_the_readme_runs_as_written(tmp_path, monkeypatch):
    """On coarser and fewer things than it says: what is tested is that every name and argument holds."""
    first, second = re.findall(r"```python\n(.*?)```", README, re.DOTALL)
    shown = []
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(viz.Picture, "show", lambda picture: shown.append(picture))
    write_mesh(shapes.cone(faces=400), "my-shape.obj")
    names: dict = {}
    exec(compile(first, "README.md", "exec"), names)
    assert (tmp_path / "torus.svg").stat().st_size > 10_000
    assert [picture.pixels.std() > 10 for picture in shown] == [True, True]
    assert names["relaxed"].converged
    exec(
        compile(
            second.replace("ribbons=80", "ribbons=8").replace("ribbons=30", "ribbons=12"), "README.md", "exec"
        ),
        names,
    )
    assert names["made"].files["weave.json"].is_file()
