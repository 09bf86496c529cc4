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
from geoweave.rods.curved_weave import STRIPS
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
        turns = dataclasses.replace(report().weave, interlacing=found).metrics()["pattern"]
        name, text = weave_command._alternation(turns)
        assert name == "alternation"
        assert f"{turns['fraction']:.1%} of neighbours; at most {turns['optimal_fraction_bound']:.1%}" in text
        assert all(word in text for word in words)
        assert ("not proven" in text) is not turns["proven"]


def test_a_surface_of_few_triangles_is_remeshed_first(tmp_path, capfd: pytest.CaptureFixture[str]) -> None:
    ball = write(tmp_path, "ball", "off", *sphere(3))
    assert main.main(["weave", str(ball), "--no-relax", "--json", "-o", str(tmp_path / "woven")]) == 0
    result = json.loads(capfd.readouterr().out)
    assert result["repairs"]["remeshed_from"] == 512
    assert abs(result["faces"] - 4000) <= 2
    assert result["ribbons"] > 40
    assert (result["violations"], result["loose_ends"]) == (0, 0)


def test_a_mesh_is_woven_on_as_it_is_if_that_is_asked_for(
    tmp_path, capfd: pytest.CaptureFixture[str]
) -> None:
    ball = write(tmp_path, "ball", "off", *sphere(3))
    command = ["weave", str(ball), "--faces", "given", "--scale", "0.3", "--no-relax", "--json"]
    assert main.main([*command, "-o", str(tmp_path / "woven")]) == 0
    result = json.loads(capfd.readouterr().out)
    assert (result["faces"], result["repairs"]["remeshed_from"]) == (512, 0)


@pytest.mark.parametrize("scale", ["0.9", "1"])
def test_strips_that_would_not_go_together_are_cut_as_designed(
    tmp_path, capfd: pytest.CaptureFixture[str], scale: str
) -> None:
    command = ["weave", "spot", "--faces", "1500", "--scale", scale, "--size", "300", "-o", str(tmp_path)]
    command += ["--phase", "free"]
    assert main.main([*command, "--formats", "pattern", "--json"]) == 0
    result = json.loads(capfd.readouterr().out)
    assert result["strips_of"] == ("weave.json" if result["slipped"] else "relaxed.json")
    assert json.loads((tmp_path / "report.json").read_text())["strips"] == result["strips"]
    assert result["strips"]["of"] == result["strips_of"]
    pattern = Pattern.from_document(json.loads((tmp_path / "pattern.json").read_text()))
    assert not [each for each in contradictions_of(surface_of(pattern)) if each.plain]
    lengths = [each["length"] for each in json.loads((tmp_path / result["strips_of"]).read_text())["ribbons"]]
    assert [strip.length for strip in pattern.strips] == pytest.approx(lengths, abs=1e-3)
    # Put together, strips may make another shape; the verdict of the weave has said so.
    assert main.main(["twin", str(tmp_path), "--json"]) == int(result["verdict"]["word"] == DO_NOT)


def test_strips_are_cut_curved_if_that_is_asked_for(tmp_path, capfd: pytest.CaptureFixture[str]) -> None:
    ball = write(tmp_path, "ball", "off", *sphere(3))
    command = ["weave", str(ball), "--faces", "given", "--scale", "0.3", "--size", "200", "-o", str(tmp_path)]
    assert main.main([*command, "--formats", "pattern,svg", "--strips", "designed", "--json"]) == 0
    result = json.loads(capfd.readouterr().out)
    assert result["relax"]["curved_strips"]["kind"] == "designed"
    assert any("curvature" in each for each in json.loads((tmp_path / "relaxed.json").read_text())["ribbons"])
    pattern = Pattern.from_document(json.loads((tmp_path / "pattern.json").read_text()))
    assert all(strip.curve is not None for strip in pattern.strips)
    assert main.main([*command, "--strips", "optimal", "--no-relax"]) == 2
    assert "leave out --no-relax" in capfd.readouterr().err
    option = next(each for each in weave_command.weave.params if each.name == "strips")
    assert tuple(option.type.choices) == STRIPS


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
    command = ["weave", str(ball), "--faces", "500", "--scale", "0.5", "--size", "200", "--no-relax"]
    command += ["--formats", "pattern", "-o", str(tmp_path / "woven")]
    assert main.main(command) == 0
    said = found.sentence + (". Try that" if word == DO_NOT else "")
    assert capfd.readouterr().out.splitlines()[-1] == said
    assert main.main([*command, "--strict", "--json"]) == (1 if word == DO_NOT else 0)
    result = json.loads(capfd.readouterr().out)
    assert result["verdict"]["word"] == word
    assert json.loads((tmp_path / "woven" / "report.json").read_text())["verdict"] == result["verdict"]
    assert main.main(["weave", str(ball), "--faces", "500", "--scale", "0.5", "--no-relax", "--json",
                      "-o", str(tmp_path / "plain")]) == 0  # fmt: skip
    assert json.loads(capfd.readouterr().out)["verdict"] is None


CORNERS = ((1, 1, 1), (1, -1, -1), (-1, 1, -1), (-1, -1, 1))


def test_singularities_are_prescribed_by_a_file(tmp_path, capfd: pytest.CaptureFixture[str]) -> None:
    ball = write(tmp_path, "ball", "off", *sphere(4))
    file = tmp_path / "corners.txt"
    file.write_text("".join(f"{x * 0.577} {y * 0.577} {z * 0.577} 3\n" for x, y, z in CORNERS))
    command = ["weave", str(ball), "--faces", "given", "--no-relax", "-o", str(tmp_path / "woven")]
    command += ["--singularities", str(file)]
    assert main.main([*command, "--json"]) == 0
    result = json.loads(capfd.readouterr().out)
    assert result["branch_points"] == 4
    assert result["prescribed_singularities"] == {"kept": True, "displaced": []}
    report = json.loads((tmp_path / "woven" / "report.json").read_text())
    assert report["prescribed_singularities"] == {"kept": True, "displaced": []}
    assert main.main(command) == 0
    assert "all kept by the finished field, and no other" in capfd.readouterr().out


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (None, "points.txt cannot be read: No such file or directory"),
        ("0 0 1\n", "points.txt: line 1 has 3 numbers"),
        ("0 0 1 3\n", "ball.off: the indices of the singularities sum to 3/6"),
        ("0 0 1 3\n", "+9/6 is missing"),
        ("0 0 9 12\n", "ball.off: the singularity at (0, 0, 9) is"),
    ],
)
def test_a_bad_file_of_singularities_is_one_sentence_and_exit_2(
    tmp_path, capfd: pytest.CaptureFixture[str], text: str | None, said: str
) -> None:
    ball = write(tmp_path, "ball", "off", *sphere(3))
    file = tmp_path / "points.txt"
    if text is not None:
        file.write_text(text)
    command = ["weave", str(ball), "--faces", "given", "--no-relax", "-o", str(tmp_path / "woven")]
    assert main.main([*command, "--singularities", str(file)]) == 2
    out, err = capfd.readouterr()
    assert out == ""
    assert said in err
    assert err.count("\n") == 1
    assert not (tmp_path / "woven").exists()


def test_branch_points_are_merged_within_so_many_spacings(
    tmp_path, capfd: pytest.CaptureFixture[str]
) -> None:
    found = []
    for merge in ("0", "1.5"):
        command = ["weave", "spot", "--faces", "1500", "--no-relax", "-o", str(tmp_path), "--merge", merge]
        assert main.main([*command, "--json"]) == 0
        found.append(json.loads(capfd.readouterr().out)["branch_points"])
    assert found[1] < found[0]
    for bad in ("-1", "nan", "1e9", "x"):
        command = ["weave", "spot", "--no-relax", "-o", str(tmp_path), "--merge", bad]
        assert main.main(command) == 2
        assert capfd.readouterr().err.count("\n") == 1


def test_a_symmetric_surface_is_woven_as_its_own_image_and_another_is_refused(
    tmp_path, capfd: pytest.CaptureFixture[str]
) -> None:
    command = ["weave", "spot", "--faces", "1500", "--no-relax", "-o", str(tmp_path), "--symmetric", "auto"]
    assert main.main([*command, "--json"]) == 0
    mirror = json.loads(capfd.readouterr().out)["mirror"]
    assert mirror["normal"][0] == pytest.approx(1.0, abs=0.01)
    assert mirror["field_deg"] < 0.1  # chance gives 15
    assert json.loads((tmp_path / "report.json").read_text())["mirror"] == mirror
    assert main.main(["weave", "bunny", "--no-relax", "-o", str(tmp_path / "b"), "--symmetric", "auto"]) == 2
    err = capfd.readouterr().err
    assert "no mirror plane" in err
    assert err.count("\n") == 1


def test_a_family_follows_what_a_file_says(tmp_path, capfd: pytest.CaptureFixture[str]) -> None:
    ball = write(tmp_path, "ball", "off", *sphere(4))
    file = tmp_path / "up.txt"
    file.write_text("0 0 1\n")
    command = ["weave", str(ball), "--faces", "given", "--no-relax", "--align", str(file)]
    command += ["-o", str(tmp_path / "woven")]
    assert main.main([*command, "--json"]) == 0
    assert json.loads(capfd.readouterr().out)["aligned_deg"] < 15
    assert main.main(command) == 0
    assert "degrees from the nearest family in the mean" in capfd.readouterr().out
    for text, said in (
        ("0 0\n", "up.txt: line 1 has 2 numbers"),
        ("0 0 1\n0 0 9\n", "ball.off: the point (0, 0, 9)"),
    ):
        file.write_text(text)
        assert main.main(command) == 2
        out, err = capfd.readouterr()
        assert (out, err.count("\n")) == ("", 1)
        assert said in err
