"""Imports point one way, renderers stay in one room, nothing is pickled, rooms are small and tested."""

import ast
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parent.parent
PACKAGE = ROOT / "geoweave"

# A module imports from layers above its own, or from its own layer as long as that makes no circle.
LAYERS = (
    ("words", {"arrays", "compiled", "errors", "places"}),
    ("matrices", {"cholesky", "elimination", "linalg"}),
    ("the surface", {"mesh", "twist"}),
    (
        "meshes from files and formulas",
        {
            "closest",
            "datasets",
            "edits",
            "formats",
            "implicit",
            "mending",
            "output",
            "patch",
            "ply",
            "prepare",
            "reading",
            "remesh",
            "shapes",
            "writing",
        },
    ),
    ("operators and fields", {"circle", "fields", "operators", "part"}),
    (
        "geodesic fields",
        {
            "baselines",
            "domains",
            "geodesic",
            "great_circles",
            "reference",
            "rosy",
            "singular_lines",
            "singularities",
        },
    ),
    (
        "integration",
        {
            "alignment",
            "alternation",
            "compared",
            "curl_correction",
            "integration",
            "mixed_integer",
            "rescaling",
        },
    ),
    ("curves on the surface", {"curves", "facewalk", "isolines", "separation", "straightest", "tracing"}),
    ("covers", {"cover"}),
    ("weaves", {"interlacing", "parity", "ribbons", "rodfiles", "scales", "validity"}),
    (
        "rods",
        {
            "contact_energies",
            "departure",
            "equilibrium",
            "relaxation",
            "ribbon_rods",
            "rod_energies",
            "rod_matrix",
            "rod_steps",
            "rods",
        },
    ),
    ("the pipeline", {"fitting", "inspection", "outputs", "relaxed", "weave", "weavefiles", "woven"}),
    (
        "fabrication",
        {
            "assembly",
            "clipping",
            "cutlist",
            "drawing_dxf",
            "drawing_pdf",
            "drawing_svg",
            "fabrication",
            "flatdrawing",
            "guide",
            "guide_data",
            "guide_library",
            "inks",
            "lettering",
            "marks",
            "nesting",
            "pattern",
            "pieces",
            "solid",
        },
    ),
    ("twins of woven objects", {"twin", "twin_rods", "twin_start", "twin_surface"}),
    ("models of the figures", {"models"}),
    (
        "the artifact",
        {
            "claims",
            "doctor",
            "execution",
            "notebooks",
            "pools",
            "progress",
            "runner",
            "site",
            "site_font",
            "site_text",
        },
    ),
    (
        "the command",
        {
            "__main__",
            "cli",
            "design",
            "relaxing",
            "sweep",
            "sweeping",
            "terminal",
            "twinning",
            "weaving",
        },
    ),
)
LEVEL = {name: level for level, (_, modules) in enumerate(LAYERS) for name in modules}
ARTIFACT = next(level for level, (title, _) in enumerate(LAYERS) if title == "the artifact")
DRAWING = {"pyvista", "vtk", "vtkmodules", "matplotlib", "cmcrameri", "cmocean"}
LONGEST = 450
PROCESSES = {"joblib.externals.loky.ProcessPoolExecutor"}
"""What joblib is there for: processes, in one module. Its files of pickles stay out."""
NO_TEST_OF_ITS_OWN = {"__init__", "__main__"}

MODULES = sorted(PACKAGE.rglob("*.py"))
FLAT = [path for path in MODULES if path.parent == PACKAGE and path.stem != "__init__"]
VIZ = [path for path in MODULES if path.parent.name == "viz"]


def label(path: Path) -> str:
    return path.relative_to(PACKAGE).with_suffix("").as_posix()


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


def siblings(path: Path) -> set[str]:
    """Modules of the flat package (or "viz") that a file imports."""
    found = set()
    for name in imported(ast.parse(path.read_text(encoding="utf-8"))):
        head, _, rest = name.partition(".")
        if head == "geoweave":
            found.add(rest.split(".")[0])
    return found


def test_every_module_has_a_place_in_the_table() -> None:
    assert {path.stem for path in FLAT} <= set(LEVEL)


@pytest.mark.parametrize("path", FLAT, ids=label)
def test_imports_point_one_way(path: Path) -> None:
    upward = {name for name in siblings(path) - {"viz"} if LEVEL[name] > LEVEL[path.stem]}
    assert not upward, f"{path.name} may not import {sorted(upward)}"


def test_no_circle() -> None:
    remaining = {path.stem: siblings(path) - {"viz"} for path in FLAT}
    while remaining:
        free = [name for name, needs in remaining.items() if not needs & remaining.keys()]
        assert free, f"these import each other in a circle: {sorted(remaining)}"
        for name in free:
            del remaining[name]


@pytest.mark.parametrize("path", FLAT, ids=label)
def test_nothing_imports_viz_but_the_command_at_its_last_moment(path: Path) -> None:
    tree = ast.parse(path.read_text(encoding="utf-8"))
    if path.stem == "cli":  # inside a function it may
        tree.body = [node for node in tree.body if not isinstance(node, ast.FunctionDef)]
    assert not {name for name in imported(tree) if name.startswith("geoweave.viz")}


@pytest.mark.parametrize("path", [*FLAT, PACKAGE / "__init__.py"], ids=label)
def test_renderers_live_in_viz(path: Path) -> None:
    tops = {name.split(".")[0] for name in imported(ast.parse(path.read_text(encoding="utf-8")))}
    assert not tops & DRAWING


@pytest.mark.parametrize("path", VIZ, ids=label)
def test_viz_knows_no_runner_and_no_command(path: Path) -> None:
    assert not {name for name in siblings(path) if LEVEL.get(name, 0) >= ARTIFACT}


@pytest.mark.parametrize("path", FLAT, ids=label)
def test_fabrication_knows_a_weave_and_nothing_else(path: Path) -> None:
    layer = dict(LAYERS)["fabrication"]
    if path.stem in layer:
        assert siblings(path) <= layer | {"arrays", "errors", "output", "places", "woven"}


def test_matrices_know_no_mesh() -> None:
    assert siblings(PACKAGE / "linalg.py") <= {"arrays", "cholesky", "errors"}
    assert siblings(PACKAGE / "cholesky.py") <= {"arrays", "compiled", "elimination", "errors"}
    assert siblings(PACKAGE / "elimination.py") <= {"arrays", "compiled"}


@pytest.mark.parametrize("module", ["geoweave", "geoweave.cli", "geoweave.runner"])
def test_importing_draws_in_no_renderer(module: str) -> None:
    code = f"import sys, {module}; print(sorted({DRAWING!r} & set(sys.modules)))"
    out = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout
    assert out.strip() == "[]"


@pytest.mark.parametrize("path", MODULES, ids=label)
def test_nothing_is_pickled(path: Path) -> None:
    tree = ast.parse(path.read_text(encoding="utf-8"))
    picklers = {"pickle", "cPickle", "cloudpickle", "dill", "joblib", "shelve", "marshal"}
    found = imported(tree) - (PROCESSES if path.stem == "pools" else set())
    assert not {name.split(".")[0] for name in found} & picklers
    for node in ast.walk(tree):
        if isinstance(node, ast.keyword) and node.arg == "allow_pickle":
            assert isinstance(node.value, ast.Constant)
            assert node.value.value is False


@pytest.mark.parametrize("path", MODULES, ids=label)
def test_rooms_are_small(path: Path) -> None:
    assert len(path.read_text(encoding="utf-8").splitlines()) < LONGEST


@pytest.mark.parametrize("path", MODULES, ids=label)
def test_every_module_has_its_test(path: Path) -> None:
    if path.stem in NO_TEST_OF_ITS_OWN:
        return
    own = [path.stem] if path.parent == PACKAGE else [path.stem, path.parent.name]
    assert any((ROOT / "tests" / f"test_{name}.py").is_file() for name in own)


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
    file.write_text("def f():\n    from geoweave.geodesic import solve\n    import geoweave.cli\n")
    assert siblings(file) == {"geodesic", "cli"}
