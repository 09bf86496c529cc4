"""From a mesh file to a folder of woven files, in one call: what ``geoweave weave`` does."""

from __future__ import annotations

import os
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from geoweave.errors import FieldError
from geoweave.files import checked_folder, printable
from geoweave.pipeline.attempt import Attempt, attempted, with_remedy
from geoweave.pipeline.cut_request import CutRequest
from geoweave.pipeline.made_from import made_from
from geoweave.pipeline.request import WeaveRequest, formats_of
from geoweave.pipeline.source import (
    MeshSource,
    Say,
    about,
    prepared_surface,
    silent,
    source_of,
    timed,
)
from geoweave.pipeline.strips import CutStrips
from geoweave.pipeline.up_in_report import found_up
from geoweave.pipeline.verdict import DO_NOT, Verdict
from geoweave.pipeline.weave_folder import write_weave

if TYPE_CHECKING:
    from geoweave.fabrication import Pattern
    from geoweave.files import Job
    from geoweave.meshing import Prepared
    from geoweave.rods import Relaxed
    from geoweave.surface import MirrorAxis
    from geoweave.weave import Inspection, Weave

__all__ = ["WovenFiles", "weave_file"]


@dataclass(frozen=True, eq=False)
class WovenFiles:
    """A weave that was designed, relaxed and written, and the files that it was written to."""

    source: MeshSource
    request: WeaveRequest
    prepared: Prepared
    """The mesh that was woven on, and what was mended."""
    weave: Weave
    """As designed, on the surface."""
    inspection: Inspection
    """What is hard to make of the weave."""
    relaxed: Relaxed | None
    """The weave at rest; None if it was not relaxed."""
    cut: CutStrips | None
    """The strips that are cut, and what is measured on them; None without a format of a pattern."""
    verdict: Verdict | None
    """Whether to cut the strips; None without strips."""
    files: dict[str, Path]
    """Path of each file by its name."""
    left_out: dict[str, str]
    """Formats that nobody asked for by name and the weave does not allow, each with the reason."""
    seconds: dict[str, float]
    """Wall-clock time of each stage, and in total."""

    @property
    def strips(self) -> Pattern | None:
        """The strips that are cut; None without a format of a pattern."""
        return None if self.cut is None else self.cut.pattern

    @property
    def strips_of(self) -> str | None:
        """Whose lengths the strips have: "relaxed.json", or "weave.json" if they are those of the design."""
        return None if self.cut is None else self.cut.source

    @property
    def slipped(self) -> int:
        """At how many places ribbons slid past each other, so that the strips are those of the design."""
        return 0 if self.cut is None else self.cut.slipped

    def document(self) -> dict[str, Any]:
        """All numbers of the run, as ``geoweave weave --json`` prints them."""
        from geoweave.weave import phase_of

        mesh, weave, request = self.prepared.mesh, self.weave, self.request
        return {
            "mesh": self.source.name,
            "faces": mesh.n_faces,
            "genus": mesh.genus,
            "boundary_loops": len(mesh.boundary_loops),
            "symmetry": request.symmetry,
            "phase": phase_of(request.symmetry, request.phase),
            "scale": weave.scale,
            "ribbons_asked": request.ribbons,
            "scales_tried": len(weave.design.tried) or 1,
            "seed": self.source.seed,
            "branch_points": len(weave.branch_points),
            "units": weave.units,
            **weave.metrics(),
            "width": weave.width * weave.placement.scale,
            "thickness": weave.thickness * weave.placement.scale,
            "suggested_width": self.inspection.suggested_width,
            "regularity": self.inspection.regularity.document(),
            "places": self.inspection.counts,
            "relax": None if self.relaxed is None else self.relaxed.metrics(),
            "strips_of": self.strips_of,
            "slipped": self.slipped,
            "strips": None if self.cut is None else self.cut.document(),
            "verdict": None if self.verdict is None else self.verdict.document(),
            "violations": len(self.inspection.violations),
            "seconds": {key: round(value, 4) for key, value in self.seconds.items()},
            "repairs": self.prepared.report.as_dict(),
            "output": str(self.files["weave.json"]),
            "files": [str(path) for path in self.files.values()],
            "left_out": self.left_out,
        }


def weave_file(
    mesh: str | os.PathLike[str] | MeshSource,
    folder: str | os.PathLike[str],
    request: WeaveRequest | None = None,
    *,
    design: Weave | None = None,
    callback: Say | None = None,
) -> WovenFiles:
    """Read a mesh, weave it, relax the weave, and write files to make it by, as ``geoweave weave`` does.

    Parameters
    ----------
    mesh : path of a file, or name of a data set; `MeshSource` says more
    folder : for the files; it is made if it is not there, in a folder that is
    request : what the weave is to be like and what is written; all as by default if not given
    design : the weave itself, if it was designed before on this mesh; then only what follows is done
    callback : called with one line of progress at a time

    Returns
    -------
    WovenFiles
        The weave and the paths of the files, with ``weave.json`` and ``report.json`` always among them.

    Raises
    ------
    MeshError, FieldError
        If the surface or the request does not allow it; the text begins with the name of the mesh.
    OutputError
        If a file cannot be written, or there is no such format.

    See Also
    --------
    weave_pattern : the design alone, from a mesh to a value.

    Examples
    --------
    >>> import tempfile
    >>> from geoweave.meshing import write_mesh
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     write_mesh(gw.shapes.cone(faces=300), f"{folder}/cone.obj")
    ...     request = gw.WeaveRequest(scale=0.5, relax=False)
    ...     woven = gw.weave_file(gw.MeshSource(f"{folder}/cone.obj", faces=300), f"{folder}/woven", request)
    ...     sorted(path.name for path in woven.files.values() if path.is_file())
    ['report.json', 'weave.json']
    >>> len(woven.weave.ribbons) > 2
    True
    """
    source, request, say = source_of(mesh), request or WeaveRequest(), callback or silent
    target = checked_folder(folder)
    cut, wanted = formats_of(request.formats_wanted, request.size)
    seconds: dict[str, float] = {}
    with about(source.name):
        prepared = _even_surface(source, request, seconds, say)
        _check_surface(prepared, design)
        made = attempted(prepared, source.seed, request, bool(cut), seconds, say, design)
        if (verdict := made.verdict) is not None and verdict.word == DO_NOT:
            with timed(seconds, "remedies"):
                verdict = with_remedy(verdict, made, prepared, source, request, say)
        with timed(seconds, "write"):
            up = found_up(prepared.mesh, source.name, request.up)
            jobs, left_out, order = _pattern_jobs(source, up["axis"], request, made, cut)
            said = _said(source, request, made.cut, verdict) | {"up": up, **order}
            files = write_weave(made.weave, target, wanted, made.inspection, made.relaxed, jobs, said)
    seconds["total"] = sum(seconds.values())
    return WovenFiles(
        source=source,
        request=request,
        prepared=prepared,
        weave=made.weave,
        inspection=made.inspection,
        relaxed=made.relaxed,
        cut=made.cut,
        verdict=verdict,
        files=files,
        left_out=left_out,
        seconds=seconds,
    )


def _said(
    source: MeshSource, request: WeaveRequest, cut: CutStrips | None, verdict: Verdict | None
) -> dict[str, Any]:
    """What the report says beside the inspection."""
    said: dict[str, Any] = {} if cut is None else {"strips": cut.document()}
    said |= {} if verdict is None else {"verdict": verdict.document()}
    return said | {"made_from": made_from(source, request)}


def _check_surface(prepared: Prepared, design: Weave | None) -> None:
    """Refuse a design on another mesh."""
    import numpy as np

    if design is None:
        return
    # A weave is designed on the normalised surface, of bounding radius 1.
    here, there = prepared.mesh.normalized()[0], design.mesh
    if not (
        np.array_equal(here.faces, there.faces)
        and np.allclose(here.vertices, there.vertices, rtol=0.0, atol=1e-9)
    ):
        raise FieldError("the mesh is not the one that the weave was designed on; weave it anew")


def _even_surface(source: MeshSource, request: WeaveRequest, seconds: dict[str, float], say: Say) -> Prepared:
    """Read a mesh; if nothing is said of its triangles, it is remeshed for the weave that is asked for."""
    import numpy as np

    from geoweave.meshing import evened

    prepared = prepared_surface(source, seconds, say)
    request.check_widths(request.size or float(np.ptp(prepared.mesh.vertices, axis=0).max()))
    if source.faces is None:
        with timed(seconds, "remesh"):
            prepared = evened(prepared, ribbons=request.ribbons, name=source.name)
    return prepared if request.symmetric == "off" else _symmetric(prepared, request.symmetric)


def _symmetric(prepared: Prepared, axis: MirrorAxis) -> Prepared:
    """Put the image of one half of a surface in place of the other, and say so in its report."""
    from geoweave.meshing import mirrored_half
    from geoweave.surface import mirror_plane

    plane = mirror_plane(prepared.mesh, axis)
    normal = ", ".join(f"{x:.2f}" for x in plane.normal)
    note = (
        f"one half is the image of the other across ({normal}); the surface was {plane.residual:.2%} of its "
        "size from its image"
    )
    report = replace(prepared.report, notes=(*prepared.report.notes, note))
    return replace(prepared, mesh=mirrored_half(prepared.mesh, plane), report=report)


def _pattern_jobs(
    source: MeshSource,
    up: str,
    request: WeaveRequest,
    made: Attempt,
    cut: tuple[str, ...],
) -> tuple[dict[str, Job], dict[str, str], dict[str, Any]]:
    """What writes the files of the strips; formats that are left out, each with the reason; and the order."""
    from geoweave.fabrication import files_of, layout_for

    if (strips := made.cut) is None:
        return {}, {}, {}
    bench = CutRequest().bench(printable(Path(source.name).stem), up)
    try:
        laid = layout_for(strips.pattern, cut, bench=bench, weave=made.weave, rest=strips.space)
        return files_of(laid, cut), {}, {"assembly": laid.assembly}
    except FieldError as error:
        if request.formats is not None:
            raise
        return {}, dict.fromkeys(cut, str(error)), {}
