"""Which notebooks ``make test`` has to execute again, and whether the others give what is committed.

``make test`` compares the outputs of cells tagged ``nbval-check-output`` with the committed ones. nbval
executes a notebook for that. Where ``make figures`` has executed it already, with the same cells, package,
versions and Python, its outputs lie in ``build/`` and are compared as they are. The digest of
`geoweave.artifact.figures` tells which these are.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from geoweave.artifact import figures, notebooks
from geoweave.checkout import repository

CHECKED = "nbval-check-output"
"""The tag of cells whose outputs are compared."""

__all__ = ["differences", "main"]


def differences(root: Path, name: str, stored: Path) -> list[str]:
    """Sentences on checked cells of a notebook that gave something else in a stored execution of it.

    Pictures are left out.
    """
    committed = notebooks.read(notebooks.path_of(root, name))
    executed = notebooks.settled(committed, notebooks.read(stored))
    found = []
    for number, (cell, ran) in enumerate(zip(committed.cells, executed.cells, strict=True)):
        if CHECKED in cell.metadata.get("tags", []) and _texts(cell) != _texts(ran):
            found.append(f"{name}: cell {number} printed something else than is committed: {_texts(ran)}")
    return found


def _texts(cell: Any) -> list[tuple[str, Any]]:
    """What a cell put out, in order, as (kind, text); a notebook's pictures are compared by nobody."""
    found: list[tuple[str, Any]] = []
    for output in cell.outputs:
        if output.output_type == "stream":
            found.append((output.name, output.text))
        elif output.output_type == "error":
            found.append(("error", output.evalue))
        else:
            found += [(kind, text) for kind, text in output.data.items() if not kind.startswith("image/")]
    return found


def main(arguments: Sequence[str] | None = None) -> int:
    """Print the paths of the notebooks that nbval has to execute; status 1 if one of the others differs."""
    argparse.ArgumentParser(prog="python -m geoweave.artifact.replay").parse_args(arguments)
    root = repository()
    names = notebooks.names(root)
    stored = figures.stored_notebooks(root, names, "default")
    again = [name for name in names if name not in stored]
    wrong = [sentence for name, path in stored.items() for sentence in differences(root, name, path)]
    if stored:
        print(
            f"{len(stored)} notebooks were executed as they are now; what they gave is compared",
            file=sys.stderr,
        )
    for sentence in wrong:
        print(sentence, file=sys.stderr)
    print(" ".join(f"notebooks/{name}.ipynb" for name in again))
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
