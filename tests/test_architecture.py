"""Imports point one way, renderers stay in one room, nothing is pickled, rooms are small and tested."""

import ast
import re
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parent.parent
PACKAGE = ROOT / "geoweave"

# The rooms from the ground up: a room imports from rooms above it in this table, and no other way round.
ROOMS = (
    "sparse",
    "surface",
    "meshing",
    "models",
    "fields",
    "curves",
    "foliation",
    "comparisons",
    "weave",
    "fabrication",
    "rods",
    "twin",
    "pipeline",
    "viz",
    "artifact",
    "cli",
)
WORDS = ("arrays", "compiled", "errors", "wording", "documents", "files", "checkout")
"""Modules of the package itself, which every room may import; in their own order."""

NEVER = {
    "sparse": {"surface"},
    "meshing": {"sparse"},
    "models": {"sparse"},
    "fabrication": {"sparse", "surface", "meshing", "models", "fields", "curves", "foliation", "comparisons"},
    "rods": {"meshing", "models", "fields", "curves", "foliation", "comparisons", "fabrication"},
    "twin": {"meshing", "models", "fields", "curves", "foliation", "comparisons"},
    "pipeline": {"comparisons", "viz"},
    "viz": {"pipeline", "twin"},
    "artifact": {"viz", "pipeline", "twin", "rods", "weave", "fabrication"},
    "cli": {"comparisons", "viz", "sparse"},
}
"""What a room does not know although the table would let it: the matrices no mesh, the rods no field."""

DRAWING = {"pyvista", "vtk", "vtkmodules", "matplotlib", "cmcrameri", "cmocean"}
PROCESSES = {"joblib.externals.loky.ProcessPoolExecutor"}
"""What joblib is there for: processes, in one module. Its files of pickles stay out."""
RESULTS = set(ROOMS[: ROOMS.index("pipeline")])
"""Rooms whose results depend on nothing but their arguments."""
CLOCKS = {"time", "monotonic", "perf_counter", "process_time", "thread_time"}
NO_TEST_OF_ITS_OWN = {"__init__", "__main__"}

MODULES = sorted(PACKAGE.rglob("*.py"))
FACES = [PACKAGE / "__init__.py", *(PACKAGE / room / "__init__.py" for room in ROOMS)]
OWN = [path for path in PACKAGE.glob("*.py") if path not in FACES]
LONGEST = 400
LONGEST_FUNCTION = 80


def label(path: Path) -> str:
    return path.relative_to(PACKAGE).with_suffix("").as_posix()


def room_of(path: Path) -> str:
    return path.relative_to(PACKAGE).parts[0] if path.parent != PACKAGE else ""


def imported(tree: ast.AST) -> set[str]:
    """Full names of everything a piece of source imports, ``from a import b`` giving ``a.b``."""
    names = set()
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            names |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"line {node.lineno}: a relative import hides its direction"
            names |= {f"{node.module}.{alias.name}" for alias in node.names}
    return names


def ours(path: Path) -> set[tuple[str, ...]]:
    """What a file imports of this package: ("surface", "TriMesh"), ("errors", "MeshError") and so on."""
    names = (name.split(".") for name in imported(ast.parse(path.read_text(encoding="utf-8"))))
    return {tuple(rest) for head, *rest in names if head == "geoweave" and rest}


def rooms_used(path: Path) -> set[str]:
    return {name[0] for name in ours(path)} - {room_of(path), *WORDS}


def offered(face: Path) -> dict[str, str]:
    """Names that a face hands out, and the module of the room that each comes from ("" for modules)."""
    found = {}
    for node in ast.parse(face.with_suffix(".pyi").read_text(encoding="utf-8")).body:
        assert isinstance(node, ast.ImportFrom)
        assert node.level == 1
        for alias in node.names:
            assert alias.name == alias.asname, "a face hands names on as they are"
            assert alias.name not in found
            found[alias.name] = node.module or ""
    return found


def test_the_table_lists_the_rooms() -> None:
    folders = {path.parent.name for path in PACKAGE.glob("*/*.py")}
    assert folders == set(ROOMS)
    assert {path.stem for path in OWN} == {*WORDS, "__main__"}
    assert len(list(PACKAGE.glob("*.py"))) <= 9


@pytest.mark.parametrize("path", [path for path in MODULES if path not in FACES], ids=label)
def test_imports_point_one_way(path: Path) -> None:
    room, known = room_of(path), rooms_used(path)
    if path.stem == "__main__":
        assert known == {"cli"}
        return
    if not room:
        assert not known, f"{path.name} is for every room and may import none"
        words = {name[0] for name in ours(path)} - {path.stem}
        assert words <= set(WORDS)
        return
    above = set(ROOMS[ROOMS.index(room) + 1 :])
    allowed = {"viz"} if path == PACKAGE / "cli" / "main.py" else set()
    wrong = known & ((above | NEVER.get(room, set())) - allowed)
    assert not wrong, f"{label(path)} may not import {sorted(wrong)}"


@pytest.mark.parametrize("room", ["", *ROOMS])
def test_no_circle_in_a_room(room: str) -> None:
    files = {path.stem: path for path in (PACKAGE / room).glob("*.py") if path.stem != "__init__"}
    needs = {
        stem: {name[1 if room else 0] for name in ours(path) if not room or (name[0] == room and name[1:])}
        for stem, path in files.items()
    }
    while needs:
        free = [stem for stem, uses in needs.items() if not uses & needs.keys() - {stem}]
        assert free, f"these import each other in a circle: {sorted(needs)}"
        for stem in free:
            del needs[stem]


@pytest.mark.parametrize("path", [path for path in MODULES if path not in FACES], ids=label)
def test_other_rooms_are_entered_by_their_face(path: Path) -> None:
    for room, *rest in ours(path):
        if room not in ROOMS or room in {room_of(path), "cli"}:
            continue
        assert rest, f"{label(path)}: import what you need of {room} by name"
        assert rest[0] in offered(PACKAGE / room / "__init__.py"), f"{room} does not hand out {rest}"
        assert len(rest) == 1, f"{label(path)}: {'.'.join(rest)} is private to {room}; its face is for others"


@pytest.mark.parametrize("face", [face for face in FACES if face.with_suffix(".pyi").is_file()], ids=label)
def test_no_name_is_both_a_module_and_something_else(face: Path) -> None:
    """Reading ``geoweave.x`` gives one thing, whatever was imported before."""
    modules = {path.stem for path in face.parent.glob("*.py")} | {
        path.parent.name for path in face.parent.glob("*/*.py")
    }
    both = {name for name, module in offered(face).items() if module and name in modules}
    assert not both, f"{sorted(both)} are modules too"


@pytest.mark.parametrize("face", FACES, ids=label)
def test_a_face_says_what_lives_there_and_loads_nothing(face: Path) -> None:
    tree = ast.parse(face.read_text(encoding="utf-8"))
    assert ast.get_docstring(tree)
    assert imported(tree) <= {"lazy_loader", "os", "sys"}
    if face.with_suffix(".pyi").is_file():
        for name, module in offered(face).items():
            first = module.split(".")[0]
            assert not first or (face.parent / first).is_dir() or (face.parent / f"{first}.py").is_file(), (
                name
            )


@pytest.mark.parametrize("room", ROOMS)
def test_a_face_names_what_is_there(room: str) -> None:
    text = ast.get_docstring(ast.parse((PACKAGE / room / "__init__.py").read_text(encoding="utf-8"))) or ""
    face = (PACKAGE / room / "__init__.pyi").is_file()
    names = set(re.findall(r"(?<!`)`([A-Za-z_]+)`(?!`)", text))
    assert names <= (set(offered(PACKAGE / room / "__init__.py")) if face else set())


@pytest.mark.parametrize("path", [path for path in MODULES if room_of(path) != "viz"], ids=label)
def test_nothing_imports_viz_but_the_command_at_its_last_moment(path: Path) -> None:
    tree = ast.parse(path.read_text(encoding="utf-8"))
    if path == PACKAGE / "cli" / "main.py":  # inside a function it may
        tree.body = [node for node in tree.body if not isinstance(node, ast.FunctionDef)]
    assert not {name for name in imported(tree) if name.startswith("geoweave.viz")}


@pytest.mark.parametrize("path", [path for path in MODULES if room_of(path) != "viz"], ids=label)
def test_renderers_live_in_viz(path: Path) -> None:
    tops = {name.split(".")[0] for name in imported(ast.parse(path.read_text(encoding="utf-8")))}
    assert not tops & DRAWING


@pytest.mark.parametrize("module", ["geoweave", "geoweave.cli.main", "geoweave.artifact.figures"])
def test_importing_draws_in_no_renderer(module: str) -> None:
    code = f"import sys, {module}; print(sorted({DRAWING!r} & set(sys.modules)))"
    out = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout
    assert out.strip() == "[]"


@pytest.mark.parametrize("path", MODULES, ids=label)
def test_nothing_is_pickled(path: Path) -> None:
    tree = ast.parse(path.read_text(encoding="utf-8"))
    picklers = {"pickle", "cPickle", "cloudpickle", "dill", "joblib", "shelve", "marshal"}
    found = imported(tree) - (PROCESSES if label(path) == "pipeline/workers" else set())
    assert not {name.split(".")[0] for name in found} & picklers
    for node in ast.walk(tree):
        if isinstance(node, ast.keyword) and node.arg == "allow_pickle":
            assert isinstance(node.value, ast.Constant)
            assert node.value.value is False


@pytest.mark.parametrize("path", MODULES, ids=label)
def test_modules_and_functions_are_small(path: Path) -> None:
    text = path.read_text(encoding="utf-8")
    assert len(text.splitlines()) <= LONGEST
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef):
            lines = (node.end_lineno or 0) - node.lineno + 1
            assert lines <= LONGEST_FUNCTION, f"{node.name} has {lines} lines"


@pytest.mark.parametrize("path", [path for path in MODULES if path not in FACES], ids=label)
def test_every_module_has_its_test(path: Path) -> None:
    if path.stem not in NO_TEST_OF_ITS_OWN:
        place = Path("tests") / room_of(path) / f"test_{path.stem}.py"
        assert (ROOT / place).is_file(), f"{label(path)} has no {place}"


def test_every_test_has_its_module() -> None:
    """A test file in a room's folder tests the module of that name."""
    for room in ROOMS:
        for path in (ROOT / "tests" / room).glob("test_*.py"):
            assert (PACKAGE / room / f"{path.stem.removeprefix('test_')}.py").is_file(), path


@pytest.mark.parametrize("path", [path for path in MODULES if room_of(path) in RESULTS], ids=label)
def test_no_clock_decides(path: Path) -> None:
    """Clocks are read to tell seconds, never to end a search: a busy machine gives the same bytes."""
    tree = ast.parse(path.read_text(encoding="utf-8"))
    reading = {node.attr for node in ast.walk(tree) if isinstance(node, ast.Attribute)} & CLOCKS
    assert reading <= {"perf_counter"}
    limits = {node.arg for node in ast.walk(tree) if isinstance(node, ast.keyword | ast.arg)}
    limits |= {node.value for node in ast.walk(tree) if isinstance(node, ast.Constant)} & {"time_limit"}
    limits -= {"timeout"} if label(path) == "models/datasets" else set()  # of a download
    assert not limits & {"time_limit", "timeout", "deadline"}
    for node in ast.walk(tree):
        if isinstance(node, ast.Compare | ast.If | ast.While):
            tested = node if isinstance(node, ast.Compare) else node.test
            assert not {each.attr for each in ast.walk(tested) if isinstance(each, ast.Attribute)} & CLOCKS


def test_the_rules_bite(tmp_path: Path) -> None:
    """The readers above see what they are there to see."""
    lines = (
        "import pickle",
        "from geoweave import viz",
        "from geoweave.viz.scene import weave",
        "import vtk.util",
    )
    tree = ast.parse("\n".join(lines))
    assert imported(tree) == {"pickle", "geoweave.viz", "geoweave.viz.scene.weave", "vtk.util"}
    file = tmp_path / "mesh.py"
    file.write_text("def f():\n    from geoweave.fields import solve\n    import geoweave.cli.main\n")
    assert ours(file) == {("fields", "solve"), ("cli", "main")}


def test_contributing_draws_the_house_as_it_is() -> None:
    text = (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8")
    drawing = text.partition("## The house")[2].split("```")[1].strip()
    assert [line.split()[0] for line in drawing.splitlines()] == list(reversed(ROOMS))
