import json
import os
import pty
import signal
import subprocess
import sys
import time

import numpy as np
import pytest
from meshfiles import hostile, moebius_strip, octahedron, sheet, sphere, write

from geoweave.checkout import PACKAGE, package_version
from geoweave.cli import main
from geoweave.fields.face_field import FaceField, edge_curl, total_curl
from geoweave.rods.rod_file import read_rods
from geoweave.surface.mesh import TriMesh


@pytest.fixture
def run(capfd):
    """Run the command in this process: exit status, stdout, stderr."""

    def command(*arguments):
        status = main.main([str(argument) for argument in arguments])
        out, err = capfd.readouterr()
        return status, out, err

    return command


def refused(result, *words):
    """Assert exit status 2, nothing on stdout, and one line without a traceback on stderr."""
    status, out, err = result
    assert (status, out) == (2, "")
    assert err.startswith("geoweave: ")
    assert err.count("\n") == 1, err
    assert err.endswith("\n")
    for word in words:
        assert str(word) in err
    return True


@pytest.fixture
def ball(tmp_path):
    return write(tmp_path, "ball", "off", *sphere(3))


def process(*arguments, **options):
    command = [sys.executable, "-m", "geoweave", *map(str, arguments)]
    return subprocess.run(command, capture_output=True, text=True, check=False, **options)


# -- info ---------------------------------------------------------------------------------------------------


def test_info_as_json(run, tmp_path):
    points, faces = octahedron()
    path = write(
        tmp_path, "part", "obj", np.concatenate([points, [[9, 9, 9]]]), np.concatenate([faces, faces[:1]])
    )
    status, out, err = run("info", path, "--json")
    assert (status, err) == (0, "")
    result = json.loads(out)
    assert result["mesh"] == str(path)
    wanted = {"vertices": 6, "faces": 8, "components": 1, "genus": 0, "boundary_loops": 0}
    assert {key: result[key] for key in wanted} == wanted
    assert result["repairs"]["unreferenced_vertices"] == 1
    assert result["repairs"]["duplicate_faces"] == 1
    assert sum(result["repairs"].values()) == 2
    assert result["bounding_box"] == [[-1, -1, -1], [1, 1, 1]]


def test_info_for_people(run, ball):
    status, out, err = run("info", ball)
    assert (status, err) == (0, "")
    lines = out.splitlines()
    assert lines[0] == str(ball)
    assert "  vertices              258" in lines
    assert "  repairs               none needed" in lines


def test_info_repairs_and_writes_a_mesh_that_needs_no_repair(run, tmp_path):
    points, faces = sheet(4)
    # a second sheet stands on the row of edges in the middle of the first
    wall = np.where(np.isin(np.arange(25), np.arange(10, 15)), np.arange(25), np.arange(25) + 25)
    both = (
        np.concatenate([points, points[:, [0, 2, 1]] + np.array([0.0, 7.0, 0.0])]),
        np.concatenate([faces, wall[faces[faces.min(axis=1) >= 10]]]),
    )
    path = write(tmp_path, "wall", "ply", *both)
    assert refused(run("info", path), path, "4 edges are shared by more than two faces", "--repair")
    mended = tmp_path / "mended.obj"
    status, out, _ = run("info", path, "--repair", "-o", mended, "--json")
    cut = json.loads(out)
    assert (status, cut["repairs"]["cut_edges"], cut["components"]) == (0, 4, 3)
    status, out, _ = run("info", mended, "--json")
    again = json.loads(out)
    assert status == 0
    assert {key: again[key] for key in ("vertices", "components", "boundary_loops")} == {
        key: cut[key] for key in ("vertices", "components", "boundary_loops")
    }
    assert not any(again["repairs"].values())


def test_info_chooses_components_and_remeshes(run, tmp_path):
    points, faces = sphere(3)
    path = write(
        tmp_path,
        "two",
        "off",
        np.concatenate([points, 0.1 * points + 3]),
        np.concatenate([faces, faces + 258]),
    )
    status, out, _ = run("info", path, "--components", "largest", "--faces", 200, "--json")
    result = json.loads(out)
    assert (status, result["components"], result["repairs"]["remeshed_from"]) == (0, 1, 512)
    assert abs(result["faces"] - 200) <= 20


# -- field --------------------------------------------------------------------------------------------------


def test_field_as_json_and_as_arrays(run, ball, tmp_path):
    out_file = tmp_path / "field.npz"
    status, out, err = run("field", ball, "--json", "-o", out_file)
    assert (status, err) == (0, "")
    result = json.loads(out)
    assert (result["faces"], result["genus"], result["boundary_loops"]) == (512, 0, 0)
    assert result["total_curl"]["after"] < result["total_curl"]["before"]
    points = result["singularities"]
    assert points["index_sum"] == points["euler_characteristic"] == 2
    assert points["before"] >= 2
    assert result["iterations"] > 0
    assert set(result["seconds"]) >= {"read", "smoothest", "geodesic", "total"}

    with np.load(out_file, allow_pickle=False) as arrays:
        saved = {name: arrays[name] for name in arrays.files}
    assert set(saved) == {"vertices", "faces", "field_initial", "field", "delta"}
    mesh = TriMesh(saved["vertices"], saved["faces"])
    assert np.linalg.norm(mesh.vertices, axis=1).max() == pytest.approx(1.0)
    for name in ("field_initial", "field", "delta"):
        assert saved[name].shape == (512, 3)
        np.testing.assert_allclose(np.einsum("fx,fx->f", saved[name], mesh.face_normals), 0, atol=1e-12)
    field = FaceField.from_ambient(mesh, saved["field"])
    np.testing.assert_allclose(field.norms, 1.0)
    assert total_curl(field) == pytest.approx(result["total_curl"]["after"])
    initial = FaceField.from_ambient(mesh, saved["field_initial"])
    assert total_curl(initial) == pytest.approx(result["total_curl"]["before"])
    # Eq. 4: the perturbed field has no curl
    closed = field + FaceField.from_ambient(mesh, saved["delta"])
    assert np.abs(edge_curl(closed)).max() < 1e-10


def test_field_for_people(run, ball):
    status, out, err = run("field", ball, "--faces", 300)
    assert (status, err) == (0, "")
    assert "total curl" in out
    assert "index sum       2 (Euler characteristic 2)" in out
    assert "remeshed, from 512 faces" in out


def test_the_same_seed_gives_the_same_file(run, ball, tmp_path):
    for name in ("a.npz", "b.npz"):
        assert run("field", ball, "--seed", 3, "-o", tmp_path / name)[0] == 0
    assert (tmp_path / "a.npz").read_bytes() == (tmp_path / "b.npz").read_bytes()


@pytest.mark.parametrize(("scale", "shift"), [(1e-9, 0.0), (1e9, 0.0), (1.0, 1e6)])
def test_a_scaled_or_moved_mesh_gives_the_same_field(run, tmp_path, scale, shift):
    points, faces = sphere(3)
    points = points * [1.0, 0.8, 0.6] + 0.05 * np.sin(5 * points[:, [1, 2, 0]])
    found = []
    for name, vertices in (("here", points), ("there", scale * points + shift)):
        path = write(tmp_path, name, "obj", vertices, faces)
        status, out, _ = run("field", path, "--json", "-o", tmp_path / f"{name}.npz")
        assert status == 0
        result = json.loads(out)
        with np.load(tmp_path / f"{name}.npz") as arrays:
            found.append(
                (result["total_curl"], result["singularities"], {key: arrays[key] for key in arrays.files})
            )
    (curl, points_here, here), (curl_there, points_there, there) = found
    # 1e6 leaves 10 digits of the coordinates; a step of Algorithm 1 multiplies what is lost
    tolerance = 1e-5 if shift else 1e-9
    assert curl_there == pytest.approx(curl, rel=tolerance)
    assert points_there == points_here
    np.testing.assert_array_equal(there["faces"], here["faces"])
    np.testing.assert_allclose(there["vertices"], here["vertices"], atol=1e-9)
    for name in ("field_initial", "field"):
        # w and -w are the same minimiser
        sign = np.sign(np.einsum("fx,fx->", there[name], here[name]))
        np.testing.assert_allclose(sign * there[name], here[name], atol=1e3 * tolerance)


# -- foliate ------------------------------------------------------------------------------------------------


def test_foliate_as_json_and_as_arrays(run, ball, tmp_path):
    out_file = tmp_path / "leaves.npz"
    status, out, err = run("foliate", ball, "--faces", 2000, "--json", "-o", out_file)
    assert (status, err) == (0, "")
    result = json.loads(out)
    assert result["s_min"] > 0
    assert 0 < result["deviation_deg"]["median"] < result["deviation_deg"]["p95"]
    assert set(result["seconds"]) >= {"read", "remesh", "smoothest", "geodesic", "foliate", "total"}

    with np.load(out_file, allow_pickle=False) as arrays:
        saved = {name: arrays[name] for name in arrays.files}
    assert set(saved) == {
        "vertices", "faces", "field_initial", "field", "delta", "theta_jump", "s", "kept"
    }  # fmt: skip
    kept = saved["kept"]
    assert (~kept).sum() == result["punctured_faces"] > 0
    assert np.isnan(saved["s"][~kept]).all()
    assert np.isnan(saved["theta_jump"][~kept]).all()
    assert (saved["s"][kept] > 0).all()
    turns = saved["theta_jump"][kept].sum(axis=1) / (2 * np.pi)
    np.testing.assert_allclose(turns, np.rint(turns), atol=1e-9)
    assert (np.rint(turns) != 0).sum() == result["dislocations"]


def test_foliate_for_people_and_at_another_scale(run, ball):
    status, out, _ = run("foliate", ball)
    assert status == 0
    for word in ("deviation", "dislocations", "smallest s"):
        assert word in out
    rough, fine = (
        json.loads(run("foliate", ball, "--json", "--scale", scale)[1])["deviation_deg"]["mean"]
        for scale in (0.2, 3)
    )
    assert np.isfinite([rough, fine]).all()
    chosen = json.loads(run("foliate", ball, "--json")[1])
    assert [each["scale"] for each in chosen["scales_tried"]] == [1.0]
    assert chosen["scale"] == 1.0
    assert refused(run("foliate", ball, "--scale", 0), "--scale")
    assert refused(run("foliate", ball, "--scale", 0.001), f"{ball}: ", "larger scale")


# -- weave --------------------------------------------------------------------------------------------------


def test_weave_as_json_and_as_a_file(run, ball, tmp_path):
    folder = tmp_path / "woven"
    status, out, err = run("weave", ball, "--faces", 2000, "--no-relax", "--json", "-o", folder)
    assert (status, err) == (0, "")
    result = json.loads(out)
    assert result["ribbons"] > 5
    assert result["loose_ends"] == 0
    assert 54 < result["crossing_angle_deg"]["median"] < 66
    turns = result["alternation"]
    assert 0.9 < turns["fraction"] <= turns["optimal_fraction_bound"] <= 1
    assert set(result["seconds"]) >= {
        "rosy",
        "cover",
        "field",
        "foliation",
        "ribbons",
        "interlacing",
        "total",
    }
    weave = json.loads((folder / "weave.json").read_text())
    assert (weave["format"], weave["version"], weave["symmetry"]) == ("geoweave-weave", 1, 6)
    assert len(weave["ribbons"]) == result["ribbons"]
    assert len(weave["crossings"]) == result["crossings"]
    assert sorted(path.name for path in folder.iterdir()) == ["report.json", "weave.json"]
    assert sorted(result["files"]) == sorted(str(path) for path in folder.iterdir())
    report = json.loads((folder / "report.json").read_text())
    assert (report["format"], report["version"], report["units"]) == ("geoweave-report", 1, "mesh")
    assert report["counts"] == result["places"]
    assert result["violations"] == len(report["violations"]) == 0


def test_weave_of_a_size_with_rods_for_a_number_of_ribbons(run, ball, tmp_path):
    asked = ("--ribbons", 20, "--size", 150, "--width", 4, "--formats", "rod,json", "--no-relax", "--json")
    folder = tmp_path / "woven"
    status, out, err = run("weave", ball, *asked, "-o", folder)
    assert (status, err) == (0, "")
    result = json.loads(out)
    assert (result["ribbons_asked"], result["units"], result["width"]) == (20, "mm", pytest.approx(4.0))
    assert abs(result["ribbons"] - 20) <= 5
    assert result["metres"] == pytest.approx(result["total_length"] / 1000)
    weave = json.loads((folder / "weave.json").read_text())
    points = np.concatenate([ribbon["points"] for ribbon in weave["ribbons"]])
    assert 140 < np.ptp(points, axis=0).max() <= 150 * (1 + 1e-9)
    assert weave["scale"] == result["scale"]
    rods = read_rods(folder / "weave.rod")
    assert len(rods.rods) == result["ribbons"]
    # the scale that it says gives the same weave
    again = ("--scale", result["scale"], "--size", 150, "--width", 4, "--no-relax", "-o", tmp_path / "again")
    assert run("weave", ball, *again)[0] == 0
    assert (tmp_path / "again" / "weave.json").read_bytes() == (folder / "weave.json").read_bytes()
    first, second = (json.loads((tmp_path / name / "report.json").read_text()) for name in ("woven", "again"))
    assert first.pop("files").keys() - second.pop("files").keys() == {"weave.rod"}
    # the guide comes with the size, and it has strips and a verdict on them
    assert second.pop("verdict")["word"]
    assert second.pop("strips")["ribbons"] == result["ribbons"]
    assert second.pop("assembly")["zones"] >= 1
    # how each was asked for
    made = [report.pop("made_from") for report in (first, second)]
    assert made[0] != made[1]
    assert first == second


def test_weave_of_a_size_comes_with_a_guide(run, ball, tmp_path):
    ask = ("weave", ball, "--ribbons", 12, "--faces", 1500)
    folder = tmp_path / "woven"
    status, out, _ = run(*ask, "--size", 200, "--json", "-o", folder)
    assert status == 0
    assert json.loads(out)["left_out"] == {}
    assert sorted(each.name for each in folder.iterdir()) == [
        "guide.html",
        "relaxed.json",
        "report.json",
        "weave.json",
    ]
    page = (folder / "guide.html").read_text(encoding="utf-8")
    assert f"<title>{ball.stem}: how to weave it</title>" in page
    # It shows the weave at rest, whose lengths the strips have.
    rest = json.loads((folder / "relaxed.json").read_text())
    held = json.loads(page.split('<script id="content" type="application/json">')[1].split("</script>")[0])
    lengths = [ribbon["length"] for ribbon in rest["ribbons"]]
    np.testing.assert_allclose(held["shape"]["lengths"], lengths, atol=0.1)  # mm
    np.testing.assert_allclose([strip[3] for strip in held["strips"]], lengths, atol=1e-3)
    # Strips too small for letters: it says why there is no guide; one that is asked for is refused.
    tiny = (*ask, "--no-relax", "--size", 3)
    status, out, _ = run(*tiny, "-o", tmp_path / "tiny")
    assert (status, "no guide" in out) == (0, True)
    assert sorted(each.name for each in (tmp_path / "tiny").iterdir()) == ["report.json", "weave.json"]
    assert refused(run(*tiny, "--formats", "guide", "-o", tmp_path / "none"), "ribbons")


def test_weave_relaxes_unless_told_not_to(run, ball, tmp_path):
    ask = ("weave", ball, "--faces", 1500, "--ribbons", 15, "--phase", "free")
    status, out, _ = run(*ask, "-o", tmp_path / "woven")
    assert status == 0
    assert "it holds its shape" in out
    relaxed, report = (
        json.loads((tmp_path / "woven" / name).read_text()) for name in ("relaxed.json", "report.json")
    )
    assert report["relax"]["converged"]
    assert relaxed["metrics"]["relax"] == report["relax"]
    # what needs a fastener is said in the table, in the report and of the crossings themselves
    forces = report["relax"]["forces"]
    assert len(report["fasten"]) == forces["fasten"]
    marked = [each["id"] for each in relaxed["crossings"] if each["fasten"]]
    assert sorted(each["crossing"] for each in report["fasten"]) == marked
    assert f"{forces['contacts'] - forces['fasten']} of {forces['contacts']} crossings" in out
    # a later run into the same folder leaves nothing there that is not of it, and what is not geoweave's
    (tmp_path / "woven" / "photo.jpg").write_text("mine")
    status, out, _ = run(*ask, "--no-relax", "--json", "-o", tmp_path / "woven")
    assert status == 0
    assert json.loads(out)["relax"] is None
    assert sorted(path.name for path in (tmp_path / "woven").iterdir()) == [
        "photo.jpg",
        "report.json",
        "weave.json",
    ]


def test_weave_for_people_and_what_it_refuses(run, ball, tmp_path):
    status, out, _ = run("weave", ball, "--faces", 1500, "--no-relax", "-o", tmp_path / "woven")
    assert status == 0
    for word in ("ribbons", "crossings", "alternation", "loose ends", "in the mesh's unit", "hard places"):
        assert word in out
    assert refused(run("weave", ball, "--no-relax", "-o", ball), "is a file")
    assert refused(run("weave", ball, "--no-relax", "-o", tmp_path / "no" / "where"), "no")
    weave = ("weave", ball, "--no-relax", "-o", tmp_path / "x")
    assert refused(run(*weave, "--symmetry", 2), "--symmetry")
    assert refused(run(*weave, "--phase", "odd"), "--phase")
    assert refused(run(*weave, "--symmetry", 4, "--phase", "regular"), "--phase")
    assert refused(run(*weave, "--symmetry", 6, "--pattern", "twill"), "--pattern")
    assert refused(run(*weave, "--symmetry", 4, "--pattern", "kagome"), "--pattern")
    assert refused(run(*weave, "--pattern", "hex"), "--pattern")
    assert refused(run(*weave, "--ribbons", 0), "--ribbons")
    assert refused(run(*weave, "--ribbons", 9, "--scale", 2), "exclude each other")
    assert refused(run(*weave, "--formats", "json,dwg"), "'dwg'", "json, rod")
    for option in ("--size", "--width", "--thickness", "--scale"):
        for bad in (0, -1, "nan", "inf"):
            assert refused(run(*weave, option, bad), option)
    assert refused(run(*weave, "--scale", 0.001), ball, "larger scale")
    assert refused(run(*weave, "--scale", 999), ball, "smaller scale")
    assert not (tmp_path / "x").exists()
    assert not (tmp_path / "other").exists()


# -- data sets, figures, doctor -----------------------------------------------------------------------------


def test_a_data_set_is_a_mesh_by_name(run, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    status, out, err = run("info", "spot", "--json")
    result = json.loads(out)
    assert (status, err) == (0, "")
    assert (result["mesh"], result["genus"], result["components"]) == ("spot", 0, 1)
    assert not any(result["repairs"].values())
    # a file of that name comes first
    (tmp_path / "spot").write_bytes(b"OFF")
    assert refused(run("info", "spot"), "spot: ", "save it as OBJ")


def test_fetch_says_where_the_files_are(run, monkeypatch, tmp_path):
    status, out, err = run("fetch", "spot", "bunny", "--json")
    assert (status, err) == (0, "")
    assert {name: os.path.isfile(path) for name, path in json.loads(out).items()} == {
        "spot": True,
        "bunny": True,
    }
    status, out, err = run("fetch", "spot")
    assert (status, err) == (0, "")
    assert out.split()[0] == "spot"
    # a copy that is not what the registry says is refused, never used
    (tmp_path / "cow.off").write_bytes(b"OFF\n")
    monkeypatch.setenv("GEOWEAVE_DATA_DIR", str(tmp_path))
    for command in ("fetch", "info"):
        assert refused(run(command, "cow"), tmp_path / "cow.off", "sha256")


def test_unknown_names_are_refused(run, monkeypatch, tmp_path):
    monkeypatch.chdir(tmp_path)
    assert refused(run("info", "rabbit"), "rabbit: ", "bunny")
    assert refused(run("fetch", "rabbit"), "'rabbit'", "bunny")


def test_doctor(run, monkeypatch):
    from geoweave.artifact import doctor

    for works, expected in ((True, 0), (False, 1)):
        found = doctor.Rendering(
            works, problem="" if works else "no EGL", remedy="" if works else "install it"
        )
        monkeypatch.setattr(doctor, "try_rendering", lambda timeout=1.0, found=found: found)
        status, out, err = run("doctor", "--json")
        assert (status, err) == (expected, "")
        assert json.loads(out)["rendering"]["works"] is works
        status, out, err = run("doctor")
        assert (status, err) == (expected, "")
        assert ("no EGL" in out) is not works


def test_figures_without_the_extra_say_which_one_to_install(tmp_path):
    """As after the installation of a wheel alone: nothing that executes notebooks can be imported."""
    lines = [
        "import importlib.metadata, sys",
        "gone = ('ipykernel', 'nbformat', 'nbclient', 'papermill')",
        "sys.modules.update(dict.fromkeys(gone))",
        "known = importlib.metadata.distribution",
        "def distribution(name):",
        "    if name in gone:",
        "        raise importlib.metadata.PackageNotFoundError(name)",
        "    return known(name)",
        "importlib.metadata.distribution = distribution",
        "from geoweave.cli.main import main",
        "sys.exit(main(['figures', 'fig26']))",
    ]
    done = subprocess.run(
        [sys.executable, "-c", "\n".join(lines)], capture_output=True, text=True, check=False
    )
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr == (
        "geoweave: figures are made by notebooks, and what executes them is not installed (ipykernel, "
        "nbformat, papermill); run: pip install 'geoweave[notebooks]'\n"
    )


def test_figures(run, monkeypatch):
    from geoweave.artifact import doctor, figures
    from geoweave.errors import RenderError

    def broken():
        raise RenderError("rendering would crash; run: apt-get install it")

    monkeypatch.setattr(doctor, "require_rendering", broken)
    line = "geoweave: rendering would crash; run: apt-get install it\n"
    assert run("figures") == (1, "", line)

    asked = []

    def executed(names, profile, jobs, *, force):
        asked.append((names, profile, jobs, force))
        return [figures.Result("fig26", profile, "done", 1.0, 2.0, ("fig26.png",), "")]

    monkeypatch.setattr(doctor, "require_rendering", lambda: None)
    monkeypatch.setattr(figures, "run", executed)
    status, out, err = run("figures", "fig26", "--profile", "paper", "--jobs", 2, "--json")
    assert (status, err) == (0, "")
    assert json.loads(out)["fig26"]["state"] == "done"
    assert asked == [(("fig26",), "paper", 2, False)]


# -- what is refused ----------------------------------------------------------------------------------------


def test_hostile_files_give_one_line_and_exit_2(run, tmp_path):
    (tmp_path / "in").mkdir()
    (tmp_path / "out").mkdir()
    for command in (["info"], ["info", "--json"], ["field", "-o", tmp_path / "out" / "f.npz", "--json"]):
        for path, word in hostile_files(tmp_path / "in").values():
            assert refused(run(*command, path), path, word)
    assert not list((tmp_path / "out").iterdir())


def hostile_files(folder):
    for path in folder.iterdir():
        path.rmdir() if path.is_dir() else path.unlink()
    return hostile(folder)


def test_an_output_that_cannot_be_written_is_refused_before_the_work(run, ball, tmp_path):
    (tmp_path / "folder.npz").mkdir()
    before = ball.read_bytes()
    assert refused(run("field", ball, "-o", tmp_path / "none" / "f.npz"), "there is no folder")
    assert refused(run("field", ball, "-o", tmp_path / "folder.npz"), "is a folder")
    assert refused(run("field", ball, "-o", ball), "is the input")
    assert refused(run("info", ball, "-o", tmp_path / "x.stl"), "a mesh is written as")
    assert refused(run("info", ball, "-o", ball), "is the input")
    assert ball.read_bytes() == before
    assert sorted(os.listdir(tmp_path)) == ["ball.off", "folder.npz"]


@pytest.mark.parametrize(
    ("arguments", "word"),
    [
        ((), "Missing command; see 'geoweave --help'"),
        (("inof",), "No such command 'inof'"),
        (("info",), "Missing argument 'MESH'; see 'geoweave info --help'"),
        (("info", "a", "b"), "unexpected extra argument"),
        (("info", "a", "--jsn"), "No such option"),
        (("info", "a", "--faces", "3"), "3 is not in the range"),
        (("info", "a", "--faces", "1000000000"), "a: cannot remesh to 1,000,000,000 faces"),
        (("field", "a", "--faces", "given"), "'given' is not a valid integer"),
        (("weave", "a", "-o", "b", "--faces", "3"), "3 is not in the range"),
        (("weave", "a", "-o", "b", "--faces", "even"), "'even' is not a valid integer"),
        (("weave", "a", "-o", "b", "--width", "1e9"), "width is 1e+09; give at most"),
        (("weave", "a", "-o", "b", "--width", "300", "--size", "200"), "300, and the object 200 long"),
        (("weave", "a", "-o", "b", "--width", "3", "--thickness", "4"), "thinner than wide"),
        (("weave", "spot", "-o", "b", "--width", "3"), "is 3, and the object"),
        (("weave", "a", "-o", "b", "--ribbons", "1000000000"), "ribbons is 1e+09"),
        (("weave", "a", "-o", "b", "--symmetry", "1000"), "symmetry is 1000"),
        (("weave", "a", "-o", "b", "--size", "1e300"), "size is 1e+300"),
        (("weave", "a", "-o", "b", "--scale", "1e300"), "scale is 1e+300"),
        (("weave", "spot", "-o", ""), "the folder for results has no name"),
        (("sweep", "spot", "-o", ""), "the folder for results has no name"),
        (("field", "spot", "-o", ""), "the output has no name"),
        (("field", "spot", "-o", "x" * 300), "File name too long"),
        (("info", "a", "--components", "some"), "'some' is not one of"),
        (("field", "a", "--seed", "x"), "'x' is not a valid integer"),
        (("field", "a", "--seed", "-1"), "-1 is not in the range"),
        (("figures", "--profile", "best"), "'best' is not one of"),
    ],
)
def test_bad_usage_is_one_line_and_exit_2(run, arguments, word):
    assert refused(run(*arguments), word)


def test_help_and_version(run):
    status, out, err = run("--version")
    assert (status, err) == (0, "")
    assert out == f"geoweave {package_version()}\n"
    for arguments in (["--help"], ["-h"], *([name, "--help"] for name in main.COMMANDS)):
        status, out, err = run(*arguments)
        assert (status, err) == (0, "")
        assert out.startswith("Usage: geoweave")


def test_a_fault_of_ours_is_exit_1_with_a_traceback(run, ball, monkeypatch):
    from geoweave import meshing

    def broken(*_, **__):
        raise ZeroDivisionError("a fault")

    monkeypatch.setattr(meshing, "read_mesh", broken)
    status, out, err = run("info", ball)
    assert (status, out) == (1, "")
    assert "ZeroDivisionError: a fault" in err
    assert err.splitlines()[-1].startswith("geoweave: this is a fault of geoweave")

    def exhausted(*_, **__):
        raise MemoryError

    monkeypatch.setattr(meshing, "read_mesh", exhausted)
    assert run("info", ball) == (1, "", "geoweave: not enough memory; ask for fewer triangles with --faces\n")


# -- as a process -------------------------------------------------------------------------------------------


def test_python_m_geoweave(ball, tmp_path):
    done = process("info", ball, "--json")
    assert (done.returncode, done.stderr) == (0, "")
    assert json.loads(done.stdout)["faces"] == 512
    missing = process("info", tmp_path / "missing.obj")
    assert refused((missing.returncode, missing.stdout, missing.stderr), "missing.obj", "no such file")
    strip = write(tmp_path, "Möbius strip", "stl", *moebius_strip())
    odd = process("field", strip, env={**os.environ, "LC_ALL": "C", "PYTHONUTF8": "0"})
    assert odd.returncode == 2
    assert odd.stderr.count("\n") == 1


@pytest.mark.skipif(
    not str(PACKAGE).isascii(), reason="installed in a path with an umlaut, Python needs its UTF-8 mode"
)
@pytest.mark.parametrize("name", ["Möbius", os.fsdecode(b"M\xf6bius")], ids=["utf8", "latin1"])
def test_a_name_with_an_umlaut_in_the_c_locale(tmp_path, name):
    folder = tmp_path / name
    folder.mkdir()
    cone = write(folder, name, "off", *sphere(3))
    environment = {**os.environ, "LC_ALL": "C", "PYTHONUTF8": "0"}
    command = (sys.executable, "-m", "geoweave", "weave", os.fsencode(cone), "--no-relax", "--size", "200")
    more = (
        "--ribbons",
        "8",
        "--faces",
        "800",
        "--formats",
        "svg,guide",
        "--json",
        "-o",
        os.fsencode(folder / "out"),
    )
    done = subprocess.run(
        [*command, *more],
        capture_output=True,
        text=True,
        check=False,
        env=environment,
        cwd=folder,
    )
    assert (done.returncode, done.stderr) == (0, "")
    assert json.loads(done.stdout)["ribbons"] > 0
    page = (folder / "out" / "guide.html").read_text(encoding="utf-8")
    title = "Möbius" if name == "Möbius" else "M\ufffdbius"
    assert f"<title>{title}: how to weave it</title>" in page


def test_control_c_while_it_starts_is_no_traceback(monkeypatch):
    from geoweave import __main__

    def interrupted(*_):
        raise KeyboardInterrupt

    monkeypatch.setattr(main, "main", interrupted)
    assert __main__.run() == 130


def test_info_imports_no_renderer(ball):
    program = (
        "import sys; from geoweave.cli.main import main; status = main(['info', sys.argv[1]]); "
        "heavy = {'vtk', 'vtkmodules', 'pyvista', 'matplotlib', 'papermill'} & set(sys.modules); "
        "sys.exit(f'imported {heavy}' if heavy else status)"
    )
    done = subprocess.run(
        [sys.executable, "-c", program, str(ball)], capture_output=True, text=True, check=False
    )
    assert (done.returncode, done.stderr) == (0, "")


def test_a_reader_that_goes_away_makes_no_noise(ball):
    read_end, write_end = os.pipe()
    os.close(read_end)
    try:
        command = [sys.executable, "-m", "geoweave", "info", str(ball)]
        done = subprocess.run(command, stdout=write_end, stderr=subprocess.PIPE, text=True, check=False)
    finally:
        os.close(write_end)
    assert (done.returncode, done.stderr) == (1, "")


@pytest.mark.parametrize("stage", ["smoothest_field", "geodesic_field", "savez"])
def test_control_c_leaves_nothing_and_says_one_line(run, ball, tmp_path, monkeypatch, request, stage):
    from geoweave import fields

    def interrupted(*arguments, **_):
        if stage == "savez":
            arguments[0].write(b"half")
        os.kill(os.getpid(), signal.SIGINT)
        time.sleep(10)

    # A shell that starts jobs in the background has them ignore the signal.
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    request.addfinalizer(lambda: signal.signal(signal.SIGINT, before))
    place = {
        "smoothest_field": fields,
        "geodesic_field": fields,
        "savez": np,
    }[stage]
    monkeypatch.setattr(place, stage, interrupted)
    status, out, err = run("field", ball, "-o", tmp_path / "f.npz")
    assert (status, out, err) == (130, "", "geoweave: interrupted; no file was left half-written\n")
    assert os.listdir(tmp_path) == ["ball.off"]


def test_progress_is_shown_on_a_terminal_only(ball):
    terminal, stderr = pty.openpty()
    command = [sys.executable, "-m", "geoweave", "field", str(ball), "--json"]
    environment = {**os.environ, "TERM": "xterm"}
    child = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=stderr, env=environment)
    os.close(stderr)
    shown = b""
    while True:
        try:
            part = os.read(terminal, 4096)
        except OSError:  # how Linux tells that the other end is closed
            break
        if not part:
            break
        shown += part
    out, _ = child.communicate()
    os.close(terminal)
    assert child.returncode == 0
    assert json.loads(out)["faces"] == 512
    assert b"Algorithm 1: step" in shown
