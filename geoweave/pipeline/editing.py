"""A folder of woven files with changes that a person made on its page: ``geoweave edit``."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from geoweave.errors import FieldError
from geoweave.pipeline.design import WovenFiles, weave_file
from geoweave.pipeline.design_file import read_design
from geoweave.pipeline.made_from import read_made_from
from geoweave.pipeline.source import Say
from geoweave.pipeline.weave_folder import DESIGN_FILE, earlier_report

if TYPE_CHECKING:
    from geoweave.weave import Edits

__all__ = ["EditedFiles", "differences", "edit_folder"]

WEAVE = "weave.json"

COMPARED = (
    "ribbons",
    "crossings",
    "total_length",
    "spacing",
    "alternation.fraction",
    "pattern.fraction",
    "crossing_angle_deg.smallest",
    "regularity.piled",
    "regularity.phase_order",
    "regularity.bare",
    "regularity.near_ideal",
    "regularity.few_crossings",
    "regularity.parts",
    "aligned_deg",
    "relax.mean",
    "relax.hausdorff",
    "verdict.word",
)
"""What of two reports is set beside each other."""


@dataclass(frozen=True, eq=False)
class EditedFiles:
    """A weave that was changed, and what became of it."""

    folder: Path
    """Of the weave before."""
    edits: Edits
    made: WovenFiles
    before: Mapping[str, Any]
    """The report before."""
    after: Mapping[str, Any]
    """The report now."""

    @property
    def differs(self) -> dict[str, tuple[Any, Any]]:
        """Numbers of the reports that are not the same, by their names: before and after."""
        return differences(self.before, self.after)

    def document(self) -> dict[str, Any]:
        """All of it, as ``geoweave edit --json`` prints it."""
        return {
            "folder": str(self.folder),
            "dropped": len(self.edits.drop),
            "flipped": len(self.edits.flip),
            "designed_anew": self.edits.steers,
            "differs": {name: {"before": a, "after": b} for name, (a, b) in self.differs.items()},
            "verdict": None if self.made.verdict is None else self.made.verdict.document(),
            "seconds": {key: round(value, 4) for key, value in self.made.seconds.items()},
            "files": [str(path) for path in self.made.files.values()],
        }


def edit_folder(
    folder: str | os.PathLike[str],
    edits: str | os.PathLike[str] | Edits,
    output: str | os.PathLike[str] | None = None,
    *,
    mesh: str | None = None,
    callback: Say | None = None,
) -> EditedFiles:
    """Make a weave again with changes, as ``geoweave edit`` does.

    Only what depends on the changes is done: where ribbons are dropped or crossings flipped and the folder
    holds ``design.npz``, the field and its level sets stay as they are.

    Parameters
    ----------
    folder : that `weave_file` wrote
    edits : the changes, or path of the ``edits.json`` that the page of the folder saved
    output : where to; the same folder if not given
    mesh : path of the mesh, if it lies elsewhere now
    callback : called with one line of progress at a time

    Raises
    ------
    FieldError
        If the edits are of another weave, or the folder does not say what it was made from.
    MeshError, OutputError
        As of `weave_file`.

    Examples
    --------
    >>> gw.edit_folder("no such folder", "edits.json")
    Traceback (most recent call last):
    geoweave.errors.FieldError: no such folder: holds no weave.json; ...
    """
    from geoweave.rods import read_weave
    from geoweave.weave import Edits, design_key, edited, read_edits

    source = Path(folder)
    if not (source / WEAVE).is_file():
        raise FieldError(f"{source}: holds no {WEAVE}; make one with 'geoweave weave MESH -o DIR'")
    changes = edits if isinstance(edits, Edits) else read_edits(edits)
    before = earlier_report(source)
    if design_key(read_weave(source / WEAVE)) != changes.key:
        raise FieldError(
            f"the edits are of another weave than that in {source}; open its page with 'geoweave show "
            f"{source}' and edit there"
        )
    surface, request = read_made_from(before, str(source), mesh)
    # The design is kept, so that the next change needs none.
    formats = tuple(dict.fromkeys((*request.formats_wanted, "design")))
    request = replace(request, formats=formats, edits=(*request.edits, changes))
    design = None
    if not changes.steers and (source / DESIGN_FILE).is_file():
        design = edited(read_design(source / DESIGN_FILE), changes)
    target = source if output is None else output
    made = weave_file(surface, target, request, design=design, callback=callback)
    after = earlier_report(made.files["report.json"].parent)
    return EditedFiles(source, changes, made, before, after)


def differences(before: Mapping[str, Any], after: Mapping[str, Any]) -> dict[str, tuple[Any, Any]]:
    """Numbers of two reports that are not the same, by their names.

    What only one of them says stands beside None.
    """
    pairs = {name: (_entry(before, name), _entry(after, name)) for name in COMPARED}
    return {name: pair for name, pair in pairs.items() if pair[0] != pair[1]}


def _entry(report: Mapping[str, Any], name: str) -> Any:
    found: Any = report
    for key in name.split("."):
        found = found.get(key) if isinstance(found, Mapping) else None
    return found
