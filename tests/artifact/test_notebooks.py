"""The rules of notebooks, first on small examples, then on every notebook of the checkout."""

import ast
import base64
import contextlib
import importlib
import io
import re
import tomllib
from pathlib import Path
from types import ModuleType
from typing import Any

import nbformat
import pytest
from nbformat.v4 import new_code_cell, new_markdown_cell, new_notebook, new_output, new_raw_cell

import geoweave
from geoweave.artifact import notebooks
from geoweave.artifact.notebooks import NotebookError

ROOT = Path(__file__).resolve().parents[2]
NAMES = notebooks.names(ROOT)
MOST_LINES = 80
MOST_YOURS = 10
LAST = ("turn", "yours")  # cells that are not part of the figure: its view, and the reader's own mesh
MOST_BYTES = 1_500_000
SHOWN = {"text/plain", "text/html", "text/markdown", "text/latex", "image/png"}
DEFINITIONS = (ast.FunctionDef, ast.AsyncFunctionDef, ast.ClassDef)
# What differs between machines or between runs: home and temporary folders, addresses, dates with a time.
FOREIGN = re.compile(
    r"/home/|/root/|/Users/|/tmp/|/work/|[A-Z]:\\\\|0x[0-9a-f]{8,}|\d{4}-\d\d-\d\d[ T]\d\d:\d\d", re.ASCII
)


def example(*cells: Any, parameters: str = 'faces = 10\nprofile = "default"') -> Any:
    first = new_code_cell(parameters, id="p", metadata={"tags": ["parameters"]})
    return new_notebook(cells=[new_markdown_cell("# Fig. 0 | a *title*\n\ntext", id="m"), first, *cells])


def code_of(name: str) -> list[str]:
    return [
        cell.source for cell in notebooks.code_cells(notebooks.read(ROOT / "notebooks" / f"{name}.ipynb"))
    ]


def texts(value: Any) -> list[str]:
    """Every piece of text in an output, pictures left out."""
    if isinstance(value, str):
        return [value]
    if isinstance(value, list):
        return [text for each in value for text in texts(each)]
    if isinstance(value, dict):
        return [text for key, each in value.items() if key != "image/png" for text in texts(each)]
    return []


def missing(sources: list[str]) -> list[str]:
    """Names of this package that a notebook asks for and that do not exist, in order of the alphabet."""
    known: dict[str, str] = {}
    for source in sources:
        for node in ast.walk(ast.parse(source)):
            if isinstance(node, ast.Import):
                known |= {
                    each.asname or each.name: each.name for each in node.names if each.name == "geoweave"
                }
            elif isinstance(node, ast.ImportFrom) and node.module == "geoweave":
                known |= {each.asname or each.name: f"geoweave.{each.name}" for each in node.names}
    wanted = set(known.values())
    for source in sources:
        for node in ast.walk(ast.parse(source)):
            if isinstance(node, ast.Attribute):
                head, _, rest = ast.unparse(node).partition(".")
                if head in known and all(part.isidentifier() for part in rest.split(".")):
                    wanted.add(f"{known[head]}.{rest}")
    found = []
    for name in wanted:
        value: Any = geoweave
        for part in name.split(".")[1:]:
            # only names of modules are looked up: what a value has is seen when the notebook runs
            if not isinstance(value, ModuleType):
                break
            try:
                value = getattr(value, part)
            except AttributeError:  # a module that nothing has imported so far
                try:
                    value = importlib.import_module(f"{value.__name__}.{part}")
                except ModuleNotFoundError:
                    found.append(name)
                    break
    return sorted(found)


class TestTheReaders:
    def test_parameters(self) -> None:
        cell = 'faces = 6_000\nweights = [1e-3, -2.0]\nmodels = ("cow", None)\nprofile = "default"'
        found = notebooks.parameters(example(parameters=cell))
        assert found == {
            "faces": 6000,
            "weights": [1e-3, -2.0],
            "models": ("cow", None),
            "profile": "default",
        }

    @pytest.mark.parametrize("line", ["import os", "a = b = 1", "faces = 2 * 3", "a, b = 1, 2", "print(1)"])
    def test_parameters_are_literals(self, line: str) -> None:
        with pytest.raises(NotebookError, match=r"line 1"):
            notebooks.parameters(example(parameters=line))

    def test_parameters_come_first(self) -> None:
        with pytest.raises(NotebookError, match="tagged 'parameters'"):
            notebooks.parameters(new_notebook(cells=[new_code_cell("faces = 1")]))

    def test_profiles(self, tmp_path: Path) -> None:
        (tmp_path / "notebooks").mkdir()
        nbformat.write(example(), tmp_path / "notebooks" / "fig00.ipynb")
        table = tmp_path / "notebooks" / "profiles.toml"
        assert notebooks.profile_values(tmp_path, "fig00", "default") == {}
        assert notebooks.profile_values(tmp_path, "fig00", "paper") == {"profile": "paper"}
        table.write_text("[paper.fig00]\nfaces = 99\n")
        assert notebooks.profile_values(tmp_path, "fig00", "paper") == {"faces": 99, "profile": "paper"}
        table.write_text("[paper.fig00]\nfacets = 99\n")
        with pytest.raises(NotebookError, match="sets facets"):
            notebooks.profile_values(tmp_path, "fig00", "paper")
        with pytest.raises(NotebookError, match="no profile 'best'"):
            notebooks.profile_values(tmp_path, "fig00", "best")
        nbformat.write(example(parameters="faces = 1"), tmp_path / "notebooks" / "fig00.ipynb")
        with pytest.raises(NotebookError, match='must hold profile = "default"'):
            notebooks.profile_values(tmp_path, "fig00", "default")

    def test_what_is_no_notebook(self, tmp_path: Path) -> None:
        file = tmp_path / "broken.ipynb"
        file.write_text("{}")
        with pytest.raises(NotebookError, match=r"broken\.ipynb is no Jupyter notebook"):
            notebooks.read(file)
        old = new_notebook(cells=[])
        old.nbformat_minor = 4
        nbformat.write(old, file)
        with pytest.raises(NotebookError, match=r"save it as 4\.5"):
            notebooks.read(file)

    def test_published_names_are_literal(self) -> None:
        cells = [new_code_cell('_ = viz.publish("fig08", scene)\npublish("fig09", x)'), new_code_cell("1")]
        assert notebooks.published(example(*cells)) == ["fig08", "fig09"]
        with pytest.raises(NotebookError, match="as a literal"):
            notebooks.published(example(new_code_cell("viz.publish(name, scene)")))

    def test_imports_go_through_the_faces(self) -> None:
        allowed = (
            "import geoweave as gw\nfrom geoweave import comparisons, viz\nfrom geoweave.viz import Panel"
        )
        assert not notebooks.deep_imports(example(new_code_cell(allowed)))
        wrong = "import geoweave.fields.rosy\nif 1:\n    from geoweave.weave import Weave"
        assert notebooks.deep_imports(example(new_code_cell(wrong))) == [
            "geoweave.fields.rosy",
            "geoweave.weave",
        ]

    def test_names_that_are_not_there_are_found(self) -> None:
        source = (
            "import geoweave as gw\nfrom geoweave import viz, nothing\ngw.fields.solve(viz.Panel, viz.panel)"
        )
        assert missing([source]) == ["geoweave.fields.solve", "geoweave.nothing", "geoweave.viz.panel"]

    def test_settled_keeps_the_results_and_drops_the_run(self) -> None:
        source = example(new_code_cell("print(1)\n2", id="c", metadata={"tags": ["t"], "collapsed": True}))
        source.cells.append(new_raw_cell("raw", id="r"))
        ran = example(
            new_code_cell("injected = 1", id="injected"),
            new_code_cell(
                "print(1)\n2",
                id="c",
                execution_count=2,
                metadata={"papermill": {"duration": 1.0}, "execution": {"iopub.status.busy": "now"}},
                outputs=[
                    new_output("stream", name="stdout", text="1"),
                    new_output("stream", name="stdout", text="\n"),
                    new_output("execute_result", data={"text/plain": "2"}, execution_count=2),
                ],
            ),
        )
        ran.metadata = {"papermill": {"start_time": "now"}, "language_info": {"version": "3.11.7"}}
        kept = notebooks.settled(source, ran)
        nbformat.validate(kept)
        assert [cell.id for cell in kept.cells] == ["m", "p", "c", "r"]
        cell = kept.cells[2]
        assert cell.metadata == {"tags": ["t"]}
        assert cell.execution_count == 2
        assert [output.output_type for output in cell.outputs] == ["stream", "execute_result"]
        assert cell.outputs[0].text == "1\n"
        assert "version" not in str(kept.metadata)

    def test_index(self, tmp_path: Path) -> None:
        (tmp_path / "notebooks").mkdir()
        (tmp_path / "figures" / "paper").mkdir(parents=True)
        cells = [new_code_cell('publish("fig00", s)\npublish("missing", s)')]
        nbformat.write(example(*cells), tmp_path / "notebooks" / "fig00_slug.ipynb")
        for name in ("fig00.png", "fig00.csv", "paper/fig00.csv"):
            (tmp_path / "figures" / name).write_text("")
        (tmp_path / "figures" / "fig00.json").write_text('{"alt": "a \\"cow\\" | here"}')
        words = '[surfaces]\nfig00_slug = "a cow"\n[not_computed]\n"Fig. 9" = "a photograph"\n'
        (tmp_path / "notebooks" / "index.toml").write_text(words)
        (tmp_path / "REPRODUCING.md").write_text("| fig00_slug | paper | 12 | 345 |\n")
        rows = notebooks.figures_index(tmp_path).splitlines()[8:]
        alt = "a &quot;cow&quot; &#124; here"
        picture = f'<img src="fig00.png" alt="{alt}" width="320">'
        numbers = "[csv](fig00.csv), [json](fig00.json)"
        title = "[Fig. 0 \\| a *title*](../notebooks/fig00_slug.ipynb)<br>`fig00`<br>a cow"
        assert rows == [
            f"| {title} | {picture}<br>{numbers} | [csv](paper/fig00.csv) |",
            "",
            "Not computed:",
            "",
            "- Fig. 9: a photograph.",
        ]


def test_what_goes_beyond_the_paper_comes_last(tmp_path: Path) -> None:
    (tmp_path / "notebooks").mkdir()
    for name in ("table1", "beyond2_b", "fig01_a", "beyond1_a", "00_overview"):
        (tmp_path / "notebooks" / f"{name}.ipynb").write_text("{}")
    assert notebooks.names(tmp_path) == ["00_overview", "fig01_a", "table1", "beyond1_a", "beyond2_b"]


def test_the_notebooks_of_part_one_are_there() -> None:
    assert {"00_overview", "table1", "fig08_gallery", "fig26_convergence"} <= set(NAMES)


@pytest.mark.parametrize("name", NAMES)
class TestEveryNotebook:
    def test_is_executed_in_order_without_an_error(self, name: str) -> None:
        cells = notebooks.code_cells(notebooks.read(ROOT / "notebooks" / f"{name}.ipynb"))
        assert [cell.execution_count for cell in cells] == list(range(1, len(cells) + 1))
        for cell in cells:
            for output in cell.outputs:
                assert output.output_type != "error"
                assert output.get("name") != "stderr", output.text

    def test_is_stored_in_its_settled_form(self, name: str) -> None:
        path = ROOT / "notebooks" / f"{name}.ipynb"
        notebook = notebooks.read(path)
        assert (
            path.read_text(encoding="utf-8") == nbformat.writes(notebooks.settled(notebook, notebook)) + "\n"
        )

    def test_has_parameters_for_every_profile(self, name: str) -> None:
        for profile in notebooks.PROFILES:
            notebooks.profile_values(ROOT, name, profile)

    def test_calls_and_does_not_define(self, name: str) -> None:
        for source in code_of(name):
            for node in ast.walk(ast.parse(source)):
                assert not isinstance(node, DEFINITIONS)
                if isinstance(node, (ast.Assign, ast.AnnAssign, ast.NamedExpr)):
                    assert not isinstance(node.value, ast.Lambda)

    def test_imports_the_package_by_its_faces(self, name: str) -> None:
        assert not notebooks.deep_imports(notebooks.read(ROOT / "notebooks" / f"{name}.ipynb"))

    def test_asks_for_nothing_that_is_not_there(self, name: str) -> None:
        assert not missing(code_of(name))

    def test_is_short(self, name: str) -> None:
        cells = notebooks.code_cells(notebooks.read(ROOT / "notebooks" / f"{name}.ipynb"))
        lines = [line for cell in cells if cell.id not in LAST for line in cell.source.splitlines()]
        assert len(next(cell for cell in cells if cell.id == "yours").source.splitlines()) <= MOST_YOURS
        assert sum(bool(line.strip()) and not line.strip().startswith("#") for line in lines) <= MOST_LINES
        assert (ROOT / "notebooks" / f"{name}.ipynb").stat().st_size < MOST_BYTES

    def test_has_a_heading_and_prose(self, name: str) -> None:
        notebook = notebooks.read(ROOT / "notebooks" / f"{name}.ipynb")
        assert notebook.cells[0].cell_type == "markdown"
        assert notebooks.heading(notebook)

    def test_has_a_checked_output(self, name: str) -> None:
        checked = [
            cell
            for cell in notebooks.code_cells(notebooks.read(ROOT / "notebooks" / f"{name}.ipynb"))
            if "nbval-check-output" in cell.metadata.get("tags", [])
        ]
        assert checked, "nbval compares only what a cell tagged nbval-check-output shows"
        for cell in checked:
            assert any(
                text.strip()
                for output in cell.outputs
                for text in texts(output.get("data", output.get("text")))
            )

    def test_ends_with_its_claims(self, name: str) -> None:
        assert any(isinstance(node, ast.Assert) for node in ast.walk(ast.parse(code_of(name)[-2])))

    def test_has_one_view_to_be_turned(self, name: str) -> None:
        cells = notebooks.code_cells(notebooks.read(ROOT / "notebooks" / f"{name}.ipynb"))
        (cell,) = [cell for cell in cells if cell.id == "turn"]
        call = ast.parse(cell.source).body[-1].value
        assert ast.unparse(call.func) == "viz.turn", "the view is what the cell shows"
        for output in cell.outputs:
            assert "<iframe srcdoc=" in output.data["text/html"]
            assert output.data["text/plain"].startswith("Turned(")

    def test_ends_with_a_cell_for_a_mesh_of_ones_own(
        self, name: str, tmp_path: Path, monkeypatch: Any
    ) -> None:
        """By default it does nothing; with a path it runs, on what the notebook imports and sets."""
        *others, cell = notebooks.code_cells(notebooks.read(ROOT / "notebooks" / f"{name}.ipynb"))
        assert cell.id == "yours"
        assert cell.outputs == []
        first = cell.source.splitlines()[0]
        assert first.startswith('mine = ""')
        nodes = [node for each in others for node in ast.walk(ast.parse(each.source))]
        imports = [ast.unparse(node) for node in nodes if isinstance(node, (ast.Import, ast.ImportFrom))]
        shown: list[Any] = []
        space: dict[str, Any] = {"display": shown.append}
        exec("\n".join([*imports, others[0].source]), space)
        monkeypatch.setattr(geoweave.viz.Picture, "show", lambda picture: shown.append(picture))
        monkeypatch.chdir(tmp_path)
        exec(cell.source, space)
        assert not shown
        geoweave.meshing.write_mesh(geoweave.shapes.cone(faces=400), "mine.obj")
        said = io.StringIO()
        with contextlib.redirect_stdout(said):
            exec(cell.source.replace(first, 'mine = "mine.obj"'), space)
        assert shown or said.getvalue()
        assert all(
            len(each._repr_mimebundle_()["text/html"]) > 5000 for each in shown if hasattr(each, "page")
        )

    def test_shows_nothing_of_the_machine(self, name: str) -> None:
        for cell in notebooks.code_cells(notebooks.read(ROOT / "notebooks" / f"{name}.ipynb")):
            for output in cell.outputs:
                for text in texts(dict(output)):
                    assert not FOREIGN.search(text), FOREIGN.search(text)

    def test_pictures_are_png(self, name: str) -> None:
        for cell in notebooks.code_cells(notebooks.read(ROOT / "notebooks" / f"{name}.ipynb")):
            for output in cell.outputs:
                data = output.get("data", {})
                assert set(data) <= SHOWN
                if "image/png" in data:
                    assert base64.b64decode(data["image/png"]).startswith(b"\x89PNG")

    def test_its_figures_are_committed(self, name: str) -> None:
        notebook = notebooks.read(ROOT / "notebooks" / f"{name}.ipynb")
        for figure in notebooks.published(notebook):
            for end in ("png", "json"):
                assert (ROOT / "figures" / f"{figure}.{end}").is_file()


def test_profiles_name_notebooks_that_exist() -> None:
    tables = tomllib.loads((ROOT / "notebooks" / "profiles.toml").read_text(encoding="utf-8"))
    assert set(tables) <= set(notebooks.PROFILES) - {"default"}
    for table in tables.values():
        assert set(table) <= set(NAMES)


def test_the_index_says_of_every_notebook_which_surfaces_it_shows() -> None:
    words = tomllib.loads((ROOT / "notebooks" / "index.toml").read_text(encoding="utf-8"))
    assert sorted(words["surfaces"]) == sorted(NAMES)
    index = notebooks.figures_index(ROOT)
    assert all(f"<br>{surface} |" in index for surface in words["surfaces"].values())
    assert all(f"- {what}: {why}." in index for what, why in words["not_computed"].items())


def test_the_index_is_up_to_date() -> None:
    index = ROOT / "figures" / "INDEX.md"
    assert index.read_text(encoding="utf-8") == notebooks.figures_index(ROOT)


def test_every_figure_has_its_notebook() -> None:
    published = {
        figure
        for name in NAMES
        for figure in notebooks.published(notebooks.read(ROOT / "notebooks" / f"{name}.ipynb"))
    }
    files = {path for path in (ROOT / "figures").rglob("*") if path.is_file() and path.name != "INDEX.md"}
    assert {path.stem for path in files} <= published


def test_a_quick_notebook_comes_first_and_the_longest_after_it() -> None:
    taken = {"a": "50", "b": "4", "c": "90", "d": "7"}
    times = {(name, "default"): (seconds, "100") for name, seconds in taken.items()}
    assert notebooks.in_turn(list("abcd"), times, "default", 1) == ["b", "c", "a", "d"]
    assert notebooks.in_turn(list("abcd"), times, "default", 2) == ["b", "d", "c", "a"]
    assert notebooks.in_turn([*"abcd", "new"], times, "default", 1) == ["b", "new", "c", "a", "d"]
    assert notebooks.in_turn(list("abcd"), {}, "paper", 2) == list("abcd")
