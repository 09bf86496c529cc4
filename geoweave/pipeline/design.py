"""From a mesh file to a folder of woven files, in one call: what ``geoweave weave`` does."""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from geoweave.errors import FieldError
from geoweave.files import checked_folder, printable
from geoweave.pipeline.source import (
    MeshSource,
    Say,
    about,
    prepared_surface,
    silent,
    source_of,
    timed,
)
from geoweave.pipeline.strips import CutStrips, strips_of
from geoweave.pipeline.weave_folder import check_formats, write_weave

if TYPE_CHECKING:
    from geoweave.fabrication import Pattern
    from geoweave.files import Job
    from geoweave.meshing import Prepared
    from geoweave.rods import Relaxed, Step
    from geoweave.weave import Inspection, Weave

__all__ = ["WeaveRequest", "WovenFiles", "formats_of", "weave_file"]


BOUNDS = {"symmetry": 24, "ribbons": 100_000, "scale": 1e4, "size": 1e6, "width": 1e6, "thickness": 1e6}
"""The largest numbers that can be asked for: far beyond what is woven, and short of what ends in overflow."""


@dataclass(frozen=True)
class WeaveRequest:
    """What a weave is to be like, and which files are to be written of it.

    Raises
    ------
    FieldError
        If ``ribbons`` and ``scale`` are both given, or a number is not positive or out of reach.

    Examples
    --------
    >>> gw.WeaveRequest(ribbons=40, size=300.0).symmetry
    6
    >>> gw.WeaveRequest(ribbons=40, scale=2.0)
    Traceback (most recent call last):
    geoweave.errors.FieldError: ribbons and scale exclude each other; give one of them
    """

    symmetry: int = 6
    """Vectors of the RoSy per face: 6 gives a triaxial weave."""
    ribbons: int | None = None
    """How many ribbons; the nearest number that a search meets."""
    scale: float | None = None
    """Factor on the number of level sets, in place of ``ribbons``; 1 if neither is given."""
    size: float | None = None
    """Longest side of the bounding box in mm; None keeps the unit of the mesh."""
    width: float | None = None
    """Width of a ribbon, in mm with a size, else in the unit of the mesh."""
    thickness: float | None = None
    """Thickness of a ribbon, in the same unit; a twentieth of the width if not given."""
    formats: tuple[str, ...] | None = None
    """What to write. None: json; with a size also the guide, if the weave allows one."""
    relax: bool = True
    """Whether the weave is relaxed to the shape that it takes (Appendix E)."""

    def __post_init__(self) -> None:
        """Refuse what contradicts itself."""
        if self.ribbons is not None and self.scale is not None:
            raise FieldError("ribbons and scale exclude each other; give one of them")
        for name, most in BOUNDS.items():
            value = getattr(self, name)
            if value is None:
                continue
            if not (math.isfinite(value) and value > 0):
                raise FieldError(f"{name} is {value}; give a positive number")
            if value > most:
                raise FieldError(f"{name} is {value:g}; give at most {most:g}")
        if self.width is not None and self.thickness is not None and self.thickness > self.width:
            raise FieldError(
                f"a ribbon {self.width:g} wide cannot be {self.thickness:g} thick; make it thinner than wide"
            )
        if self.size is not None:
            self.check_widths(self.size)

    def check_widths(self, longest: float) -> None:
        """Refuse ribbons that are wider or thicker than the object is long.

        Parameters
        ----------
        longest : longest side of its bounding box, in the unit of the width
        """
        for name in ("width", "thickness"):
            value = getattr(self, name)
            if value is not None and value >= longest:
                raise FieldError(
                    f"the {name} of a ribbon is {value:g}, and the object {longest:g} long; give less"
                )

    @property
    def formats_wanted(self) -> tuple[str, ...]:
        """Names of the formats to be written, also where none were asked for."""
        if self.formats is not None:
            return self.formats
        return ("json",) if self.size is None else ("json", "guide")


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
        mesh, weave, request = self.prepared.mesh, self.weave, self.request
        return {
            "mesh": self.source.name,
            "faces": mesh.n_faces,
            "genus": mesh.genus,
            "boundary_loops": len(mesh.boundary_loops),
            "symmetry": request.symmetry,
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
            "places": self.inspection.counts,
            "relax": None if self.relaxed is None else self.relaxed.metrics(),
            "strips_of": self.strips_of,
            "slipped": self.slipped,
            "strips": None if self.cut is None else self.cut.document(),
            "violations": len(self.inspection.violations),
            "seconds": {key: round(value, 4) for key, value in self.seconds.items()},
            "repairs": self.prepared.report.as_dict(),
            "output": str(self.files["weave.json"]),
            "files": [str(path) for path in self.files.values()],
            "left_out": self.left_out,
        }


def formats_of(names: Iterable[str], size: float | None) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Part names of formats into those of a pattern and those of a weave.

    Parameters
    ----------
    names : such as "json", "rod", "svg"
    size : of the object in mm, which a pattern needs

    Returns
    -------
    The formats of the pattern (`geoweave.fabrication.FORMATS`), and those of the weave (``json``, ``rod``).

    Raises
    ------
    OutputError
        If there is no such format.
    FieldError
        If one of a pattern is asked for without a size.
    """
    from geoweave.fabrication import FORMATS, check_formats as check_pattern_formats

    asked = tuple(names)
    cut = check_pattern_formats(name for name in asked if name in FORMATS)
    rest = check_formats((name for name in asked if name not in cut), FORMATS)
    if cut and size is None:
        raise FieldError(f"a pattern ({', '.join(cut)}) is in mm; give the object a size")
    return cut, rest


def weave_file(
    mesh: str | os.PathLike[str] | MeshSource,
    folder: str | os.PathLike[str],
    request: WeaveRequest | None = None,
    *,
    callback: Say | None = None,
) -> WovenFiles:
    """Read a mesh, weave it, relax the weave, and write files to make it by, as ``geoweave weave`` does.

    Parameters
    ----------
    mesh : path of a file, or name of a data set; `MeshSource` says more
    folder : for the files; it is made if it is not there, in a folder that is
    request : what the weave is to be like and what is written; all as by default if not given
    callback : called with one line of progress at a time

    Returns
    -------
    WovenFiles
        The weave, what was found of it, and the paths of the files. ``weave.json`` and ``report.json`` are
        always among them.

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
        weave, inspection = _designed(prepared, source.seed, request, seconds, say)
        relaxed = _relaxed(weave, seconds, say) if request.relax else None
        with timed(seconds, "write"):
            # Strips are laid out before anything is written.
            strips = strips_of(weave, relaxed) if cut else None
            jobs, left_out = _pattern_jobs(source, request, weave, strips, cut)
            said = {} if strips is None else {"strips": strips.document()}
            files = write_weave(weave, target, wanted, inspection, relaxed, jobs, said)
    seconds["total"] = sum(seconds.values())
    return WovenFiles(
        source=source,
        request=request,
        prepared=prepared,
        weave=weave,
        inspection=inspection,
        relaxed=relaxed,
        cut=strips,
        files=files,
        left_out=left_out,
        seconds=seconds,
    )


def _even_surface(source: MeshSource, request: WeaveRequest, seconds: dict[str, float], say: Say) -> Prepared:
    """Read a mesh; if nothing is said of its triangles, it is remeshed for the weave that is asked for."""
    import numpy as np

    from geoweave.meshing import evened

    prepared = prepared_surface(source, seconds, say)
    request.check_widths(request.size or float(np.ptp(prepared.mesh.vertices, axis=0).max()))
    if source.faces is None:
        with timed(seconds, "remesh"):
            prepared = evened(prepared, ribbons=request.ribbons, name=source.name)
    return prepared


def _designed(
    prepared: Prepared, seed: int, request: WeaveRequest, seconds: dict[str, float], say: Say
) -> tuple[Weave, Inspection]:
    """Design a weave on a surface, give it its size, and look for what is hard to make."""
    from geoweave.weave import inspected, weave_pattern

    weave = weave_pattern(
        prepared.mesh,
        symmetry=request.symmetry,
        scale=request.scale,
        ribbons=request.ribbons,
        seed=seed,
        callback=lambda stage: say(f"weaving: {stage}"),
    )
    seconds |= weave.design.seconds
    weave = weave.sized(request.size, request.width, request.thickness)
    with timed(seconds, "inspection"):
        return weave, inspected(weave)


def _relaxed(weave: Weave, seconds: dict[str, float], say: Say) -> Relaxed:
    from geoweave.rods import relaxed_weave

    rest = relaxed_weave(weave, callback=_telling(say))
    seconds |= rest.seconds
    return rest


def _telling(say: Say) -> Callable[[str, Step], None]:
    """What tells the progress of sliding and relaxing."""
    doing = {"slide": "sliding", "relax": "relaxing"}
    return lambda stage, step: say(
        f"{doing[stage]}: step {step.number}, forces balance to {step.gradient:.1g}"
    )


def _pattern_jobs(
    source: MeshSource,
    request: WeaveRequest,
    weave: Weave,
    strips: CutStrips | None,
    cut: tuple[str, ...],
) -> tuple[dict[str, Job], dict[str, str]]:
    """What writes the files of the strips; and formats that are left out, each with the reason."""
    from geoweave.fabrication import Bench, jobs_of

    if strips is None:
        return {}, {}
    bench = Bench(title=printable(Path(source.name).stem))
    try:
        return jobs_of(strips.pattern, cut, bench=bench, weave=weave, rest=strips.space), {}
    except FieldError as error:
        if request.formats is not None:
            raise
        return {}, dict.fromkeys(cut, str(error))
