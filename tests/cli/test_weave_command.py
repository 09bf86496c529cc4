"""The command that weaves is tested as a user runs it, in test_cli.py; here, its place and its table."""

import dataclasses
import json
from functools import cache

import click
import pytest
from meshfiles import sphere, write

from geoweave.cli import main, weave_command
from geoweave.fabrication.pattern import Pattern
from geoweave.models import shapes
from geoweave.pipeline.verdict import DO_NOT, MAKE, Verdict
from geoweave.twin.contradictions import contradictions_of
from geoweave.twin.pattern_surface import surface_of
from geoweave.weave.design import weave_pattern
from geoweave.weave.inspection import Inspection, inspected
from geoweave.weave.places import KINDS, Place


@cache
def report() -> Inspection:
    return inspected(weave_pattern(shapes.torus(faces=1500), scale=0.6).sized(200.0))


def test_the_command_line_offers_the_command() -> None:
    assert main.commands.get_command(click.Context(main.commands), "weave") is weave_command.weave


def test_each_kind_of_place_has_its_words() -> None:
    for kind in KINDS:
        place = Place(kind, (1.0, 2.5, -3.0), ("A1", "B2"), 4.25)
        one = dataclasses.replace(report(), places=(place, place._replace(value=9.0)))
        text = weave_command._worst(kind, one)
        assert text.startswith("2 ")
        assert "the worst, 4.25, at (1, 2.5, -3), A1 B2" in text


def test_the_table_says_when_a_bound_is_not_proven() -> None:
    sides = report().weave.interlacing
    better = dataclasses.replace(sides, bound=max(int(sides.broken.sum()) - 1, 0))
    for found, words in (
        (sides, ()),
        (better, ("not proven", "effort was used up")),
    ):
        turns = dataclasses.replace(report().weave, interlacing=found).metrics()["alternation"]
        text = weave_command._alternation(turns)
        assert f"{turns['fraction']:.1%} of neighbours; at most {turns['optimal_fraction_bound']:.1%}" in text
        assert all(word in text for word in words)
        assert ("not proven" in text) is not turns["proven"]


def test_a_surface_of_few_triangles_is_remeshed_first(tmp_path, capfd: pytest.CaptureFixture[str]) -> None:
    ball = write(tmp_path, "ball", "off", *sphere(3))
    assert main.main(["weave", str(ball), "--no-relax", "--json", "-o", str(tmp_path / "woven")]) == 0
    result = json.loads(capfd.readouterr().out)
    assert result["repairs"]["remeshed_from"] == 512
    assert abs(result["faces"] - 4000) <= 2
    assert result["ribbons"] > 50
    assert (result["violations"], result["loose_ends"]) == (0, 0)


def test_a_mesh_is_woven_on_as_it_is_if_that_is_asked_for(
    tmp_path, capfd: pytest.CaptureFixture[str]
) -> None:
    ball = write(tmp_path, "ball", "off", *sphere(3))
    command = ["weave", str(ball), "--faces", "given", "--scale", "0.3", "--no-relax", "--json"]
    assert main.main([*command, "-o", str(tmp_path / "woven")]) == 0
    result = json.loads(capfd.readouterr().out)
    assert (result["faces"], result["repairs"]["remeshed_from"]) == (512, 0)


@pytest.mark.parametrize("scale", ["0.7", "1"])
def test_strips_that_would_not_go_together_are_cut_as_designed(
    tmp_path, capfd: pytest.CaptureFixture[str], scale: str
) -> None:
    command = ["weave", "spot", "--faces", "1500", "--scale", scale, "--size", "300", "-o", str(tmp_path)]
    assert main.main([*command, "--formats", "pattern", "--json"]) == 0
    result = json.loads(capfd.readouterr().out)
    assert result["strips_of"] == ("weave.json" if result["slipped"] else "relaxed.json")
    assert json.loads((tmp_path / "report.json").read_text())["strips"] == result["strips"]
    assert result["strips"]["of"] == result["strips_of"]
    pattern = Pattern.from_document(json.loads((tmp_path / "pattern.json").read_text()))
    assert not [each for each in contradictions_of(surface_of(pattern)) if each.plain]
    lengths = [each["length"] for each in json.loads((tmp_path / result["strips_of"]).read_text())["ribbons"]]
    assert [strip.length for strip in pattern.strips] == pytest.approx(lengths, abs=1e-3)
    assert main.main(["twin", str(tmp_path), "--json"]) == 0


@pytest.mark.parametrize("word", ["make it", "make it, but", "do not cut this"])
def test_the_verdict_comes_last_and_decides_the_status_if_strict(
    tmp_path, capfd: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, word: str
) -> None:
    from geoweave.pipeline import attempt, design

    found = Verdict(word, () if word == MAKE else ("of this",), "")
    monkeypatch.setattr(attempt, "_judged", lambda *_: found)
    monkeypatch.setattr(
        design, "with_remedy", lambda verdict, *_: dataclasses.replace(verdict, remedy="Try that")
    )
    ball = write(tmp_path, "ball", "off", *sphere(3))
    command = ["weave", str(ball), "--faces", "500", "--scale", "0.3", "--size", "200", "--no-relax"]
    command += ["--formats", "pattern", "-o", str(tmp_path / "woven")]
    assert main.main(command) == 0
    said = found.sentence + (". Try that" if word == DO_NOT else "")
    assert capfd.readouterr().out.splitlines()[-1] == said
    assert main.main([*command, "--strict", "--json"]) == (1 if word == DO_NOT else 0)
    result = json.loads(capfd.readouterr().out)
    assert result["verdict"]["word"] == word
    assert json.loads((tmp_path / "woven" / "report.json").read_text())["verdict"] == result["verdict"]
    assert main.main(["weave", str(ball), "--faces", "500", "--scale", "0.3", "--no-relax", "--json",
                      "-o", str(tmp_path / "plain")]) == 0  # fmt: skip
    assert json.loads(capfd.readouterr().out)["verdict"] is None
