"""The notebooks as files: parameters, profiles, what they publish, their committed form, the index.

Rules that `geoweave.artifact.figures` and the tests hold every notebook to:

- The first code cell is tagged ``parameters`` and assigns literals only; these are the default profile. It
  holds ``profile = "default"``. Another profile's values stand in ``notebooks/profiles.toml``, one table a
  notebook (``[paper.fig26_convergence]``); papermill puts them, with ``profile`` itself, after that cell.
- A figure is published by ``viz.publish("name", ...)`` with a literal name, into
  ``checkout.figures_folder(profile)``. `geoweave.artifact.execution` points ``GEOWEAVE_FIGURES`` to a folder
  of its own for each notebook. `geoweave.artifact.figures` copies what it finds there to ``figures/`` once
  the notebook has come to its end. ``make test`` points the variable to a folder under ``build/``.
- Of this package a notebook imports `geoweave` and what `geoweave` itself hands out, such as
  ``from geoweave import comparisons, fabrication, viz``, and no module below.
- Committed notebooks are executed 1..n and hold nothing that changes from one execution to the next.
"""

from __future__ import annotations

import ast
import html
import json
import re
import tomllib
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import nbformat

from geoweave.errors import GeoweaveError

PROFILES = ("default", "paper")

__all__ = [
    "PROFILES",
    "NotebookError",
    "code_cells",
    "deep_imports",
    "figures_index",
    "heading",
    "in_turn",
    "names",
    "parameters",
    "path_of",
    "profile_values",
    "published",
    "read",
    "settled",
    "times",
]


class NotebookError(GeoweaveError):
    """A notebook that breaks a rule of this module, or that does not exist."""


def names(root: Path) -> list[str]:
    """Names of the notebooks of a checkout, in reading order: what goes beyond the paper comes last."""
    found = (path.stem for path in (root / "notebooks").glob("*.ipynb"))
    return sorted(found, key=lambda name: (name.startswith("beyond"), name))


def path_of(root: Path, name: str) -> Path:
    """The file of one notebook.

    Raises
    ------
    NotebookError
        if there is none of that name; the message lists those there are.
    """
    path = root / "notebooks" / f"{name}.ipynb"
    if not path.is_file():
        raise NotebookError(f"there is no notebook '{name}'; there are: {', '.join(names(root)) or 'none'}")
    return path


def read(path: Path) -> Any:
    """A notebook as nbformat's mapping.

    Raises
    ------
    NotebookError
        if the file is no notebook of format 4.5, the first whose cells have identifiers.
    """
    try:
        notebook = nbformat.read(path, as_version=nbformat.NO_CONVERT)
        version = (notebook.nbformat, notebook.nbformat_minor)
    except (ValueError, KeyError, AttributeError, nbformat.ValidationError) as error:
        raise NotebookError(f"{path.name} is no Jupyter notebook ({error}); restore it from git") from error
    if version < (4, 5):
        raise NotebookError(f"{path.name} has notebook format {version[0]}.{version[1]}: save it as 4.5")
    return notebook


def code_cells(notebook: Any) -> list[Any]:
    """The code cells, in order."""
    return [cell for cell in notebook.cells if cell.cell_type == "code"]


def parameters(notebook: Any) -> dict[str, Any]:
    """Names and literal values of the default profile, from the cell tagged ``parameters``.

    Raises
    ------
    NotebookError
        if the first code cell is not that cell, or if it holds anything but ``name = literal``.
    """
    cells = code_cells(notebook)
    if not cells or "parameters" not in cells[0].metadata.get("tags", []):
        raise NotebookError("the first code cell must be tagged 'parameters'")
    values: dict[str, Any] = {}
    for statement in ast.parse(cells[0].source).body:
        if (
            not isinstance(statement, ast.Assign)
            or len(statement.targets) != 1
            or not isinstance(statement.targets[0], ast.Name)
        ):
            raise NotebookError(
                f"the parameters cell may only hold 'name = literal' (line {statement.lineno})"
            )
        try:
            values[statement.targets[0].id] = ast.literal_eval(statement.value)
        except ValueError as error:
            raise NotebookError(f"a parameter must be a literal (line {statement.lineno})") from error
    return values


def profile_values(root: Path, name: str, profile: str) -> dict[str, Any]:
    """What to put in place of the literals of the parameters cell: nothing for the default profile.

    Raises
    ------
    NotebookError
        if there is no such profile, or if it names a parameter that the notebook does not have.
    """
    if profile not in PROFILES:
        raise NotebookError(f"there is no profile '{profile}'; there are: {', '.join(PROFILES)}")
    known = parameters(read(path_of(root, name)))
    if known.get("profile") != "default":
        raise NotebookError(f'notebooks/{name}.ipynb: the parameters cell must hold profile = "default"')
    if profile == "default":
        return {}
    file = root / "notebooks" / "profiles.toml"
    tables = tomllib.loads(file.read_text(encoding="utf-8")) if file.is_file() else {}
    values: dict[str, Any] = tables.get(profile, {}).get(name, {})
    unknown = sorted(set(values) - set(known))
    if unknown:
        raise NotebookError(
            f"notebooks/profiles.toml: [{profile}.{name}] sets {', '.join(unknown)}, which its notebook's "
            f"parameters cell does not have"
        )
    return {**values, "profile": profile}


def heading(notebook: Any) -> str:
    """The text of the first heading, "" without one."""
    for cell in notebook.cells:
        if cell.cell_type == "markdown":
            for line in cell.source.splitlines():
                if line.startswith("#"):
                    return str(line.lstrip("#").strip())
    return ""


def published(notebook: Any) -> list[str]:
    """Names of the published figures, in order: the literal first argument of every ``publish(...)``.

    Raises
    ------
    NotebookError
        if such an argument is no literal string.
    """
    found = []
    for cell in code_cells(notebook):
        for node in ast.walk(ast.parse(cell.source)):
            if not isinstance(node, ast.Call):
                continue
            function = node.func
            called = function.attr if isinstance(function, ast.Attribute) else getattr(function, "id", "")
            if called != "publish":
                continue
            first = node.args[0] if node.args else None
            if not isinstance(first, ast.Constant) or not isinstance(first.value, str):
                raise NotebookError(f"publish needs the figure's name as a literal: {ast.unparse(node)}")
            found.append(first.value)
    return found


def deep_imports(notebook: Any) -> list[str]:
    """What a notebook imports of this package from below its face and `geoweave.viz`: nothing, by rule."""
    found = []
    for cell in code_cells(notebook):
        for node in ast.walk(ast.parse(cell.source)):
            modules: list[str] = []
            if isinstance(node, ast.Import):
                modules = [alias.name for alias in node.names if alias.name != "geoweave.viz"]
            elif isinstance(node, ast.ImportFrom) and node.module != "geoweave.viz":
                modules = [node.module or ""]
            found += [name for name in modules if name.startswith("geoweave.")]
    return found


def _joined_streams(outputs: list[Any]) -> list[Any]:
    """Join neighbouring pieces of one stream: where a stream is cut depends on timing alone."""
    joined: list[Any] = []
    for output in outputs:
        last = joined[-1] if joined else None
        if (
            last is not None
            and output.output_type == last.output_type == "stream"
            and output.name == last.name
        ):
            last.text += output.text
        else:
            joined.append(output)
    return joined


def settled(source: Any, executed: Any) -> Any:
    """The source notebook with the outputs of its execution, free of all that changes between executions.

    Kept: cells, their identifiers and tags, outputs, execution counts. Dropped: times, durations, papermill's
    and the editor's metadata, the version of Python.

    Parameters
    ----------
    source : the notebook as it stands in ``notebooks/``
    executed : the same cells, executed; cells that papermill added are passed over
    """
    outputs = {cell.id: cell for cell in code_cells(executed)}
    result = nbformat.v4.new_notebook(
        metadata={
            "kernelspec": {"display_name": "Python 3", "language": "python", "name": "python3"},
            "language_info": {"name": "python"},
        }
    )
    result.nbformat_minor = 5
    for cell in source.cells:
        tags = cell.metadata.get("tags", [])
        metadata = {"tags": list(tags)} if tags else {}
        if cell.cell_type == "code":
            ran = outputs[cell.id]
            kept = nbformat.v4.new_code_cell(
                cell.source, id=cell.id, metadata=metadata, execution_count=ran.execution_count
            )
            kept.outputs = _joined_streams(ran.outputs)
        elif cell.cell_type == "markdown":
            kept = nbformat.v4.new_markdown_cell(cell.source, id=cell.id, metadata=metadata)
        else:
            kept = nbformat.v4.new_raw_cell(cell.source, id=cell.id, metadata=metadata)
        result.cells.append(kept)
    return result


def _alt(record: Path) -> str:
    """What the picture shows, in the words its provenance file has for those who cannot see it."""
    alt = json.loads(record.read_text(encoding="utf-8")).get("alt", "")
    return html.escape(str(alt)).replace("|", "&#124;")


def times(root: Path) -> dict[tuple[str, str], tuple[str, str]]:
    """Seconds and peak memory by notebook and profile, as the table of REPRODUCING.md has them."""
    page = root / "REPRODUCING.md"
    text = page.read_text(encoding="utf-8") if page.is_file() else ""
    rows = re.findall(r"^\| (\w+) \| (\w+) \| (\d+) \| (\d+) \|$", text, re.MULTILINE)
    return {(name, profile): (seconds, memory) for name, profile, seconds, memory in rows}


def in_turn(
    chosen: Sequence[str], times: Mapping[tuple[str, str], tuple[str, str]], profile: str, jobs: int
) -> list[str]:
    """In which order to execute: one quick notebook a job, to show a picture soon, then the longest first.

    The longest first lets all jobs end at about the same time. A notebook of which no time is known counts
    as long.
    """
    seconds = {name: float(times.get((name, profile), ("inf", ""))[0]) for name in chosen}
    first = sorted(chosen, key=lambda name: seconds[name])[: max(1, jobs)]
    rest = [name for name in chosen if name not in first]
    return first + sorted(rest, key=lambda name: -seconds[name])


def _words(root: Path) -> dict[str, dict[str, str]]:
    """Which surfaces the notebooks show, and what none of them computes: ``notebooks/index.toml``."""
    path = root / "notebooks" / "index.toml"
    return tomllib.loads(path.read_text(encoding="utf-8")) if path.is_file() else {}


def figures_index(root: Path) -> str:
    """Markdown of ``figures/INDEX.md``: every figure there is, a row each, both profiles side by side."""
    words = _words(root)
    lines = [
        "# Figures",
        "",
        "Written by `make figures` from the notebooks; not edited by hand. The default profile needs no",
        "network. The paper profile shows the paper's own surfaces at full quality. Where a surface stands",
        "in for one of the paper's, the first column says so. Times: [REPRODUCING.md](../REPRODUCING.md).",
        "",
        "| figure | default profile | paper profile |",
        "|---|---|---|",
    ]
    for name in names(root):
        notebook = read(path_of(root, name))
        title = heading(notebook).replace("|", "\\|")
        surface = words.get("surfaces", {}).get(name, "")
        figures = published(notebook)
        for figure in figures:
            cells = _profiles_side_by_side(root / "figures", figure)
            if not any(cells):
                continue
            caption = f"[{title}](../notebooks/{name}.ipynb)"
            if len(figures) > 1:
                caption += f"<br>`{figure}`"
            caption += f"<br>{surface}" if surface else ""
            lines.append(f"| {caption} | {' | '.join(cells)} |")
    if missing := words.get("not_computed", {}):
        lines += ["", "Not computed:", ""]
        lines += [f"- {what}: {why}." for what, why in missing.items()]
    return "\n".join(lines) + "\n"


def _profiles_side_by_side(folder: Path, figure: str) -> list[str]:
    """What there is of a figure in each profile: the picture with links to its numbers, or nothing."""
    cells: list[str] = []
    first = b""
    for profile in PROFILES:
        base = figure if profile == "default" else f"{profile}/{figure}"
        files = {end: folder / f"{base}.{end}" for end in ("png", "csv", "json")}
        numbers = ", ".join(f"[{end}]({base}.{end})" for end in ("csv", "json") if files[end].is_file())
        cell = ""
        if files["png"].is_file():
            picture = files["png"].read_bytes()
            alt = _alt(files["json"]) if files["json"].is_file() else ""
            cell = f'<img src="{base}.png" alt="{alt or figure}" width="320">'
            if picture and picture == first:
                cell = "the same picture"
            first = first or picture
        cells.append("<br>".join(part for part in (cell, numbers) if part))
    return cells
