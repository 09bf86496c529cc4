"""One attempt at a weave, from a surface to strips and the verdict on them; and what helps where it fails."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from geoweave.errors import FieldError, GeoweaveError
from geoweave.pipeline.pattern_twin import put_together
from geoweave.pipeline.request import WeaveRequest
from geoweave.pipeline.source import MeshSource, Say, silent, timed
from geoweave.pipeline.strips import CutStrips, strips_of
from geoweave.pipeline.verdict import (
    BUT,
    DO_NOT,
    Verdict,
    other_shape,
    rebuilt_reasons,
    surface_reasons,
    verdict_of,
)

if TYPE_CHECKING:
    from geoweave.fabrication import Pattern
    from geoweave.meshing import Prepared
    from geoweave.rods import CurvedStep, Relaxed, Step, StripKind
    from geoweave.weave import Edits, Inspection, Weave

__all__ = ["Attempt", "attempted", "with_remedy"]

FEWER = 0.7
"""The share of the ribbons that is tried where a weave fails."""

FINER = 2
"""So many times the triangles are tried where a weave fails."""


@dataclass(frozen=True, eq=False)
class Attempt:
    """A weave that was designed and relaxed, its strips, and the verdict on them."""

    weave: Weave
    inspection: Inspection
    relaxed: Relaxed | None
    cut: CutStrips | None
    """The strips that are cut, if any are."""
    verdict: Verdict | None
    """None without strips."""


def attempted(
    prepared: Prepared,
    seed: int,
    request: WeaveRequest,
    cut: bool,
    seconds: dict[str, float],
    say: Say,
    design: Weave | None = None,
    *,
    trial: bool = False,
) -> Attempt:
    """Design a weave on a surface, relax it, and judge its strips.

    Parameters
    ----------
    prepared : the surface
    seed : of the random numbers
    request : what the weave is to be like
    cut : whether strips are to be cut
    seconds : the time of each stage is entered here
    say : called with one line of progress at a time
    design : the weave before it has its size, if there is one; else it is designed
    trial : whether only the verdict is wanted, so that a design that fails on paper is not relaxed
    """
    from geoweave.weave import inspected

    if design is None:
        design = _designed(prepared, seed, request, seconds, say)
    weave = design.sized(request.size, request.width, request.thickness)
    with timed(seconds, "inspection"):
        inspection = inspected(weave)
    if cut and trial and (flat := _flat_reasons(weave, strips_of(weave, None).pattern, inspection)):
        return Attempt(weave, inspection, None, None, Verdict(DO_NOT, flat, ""))
    relaxed = _relaxed(weave, request.strips, seconds, say) if request.relax else None
    if not cut:
        return Attempt(weave, inspection, relaxed, None, None)
    with timed(seconds, "strips"):
        strips = strips_of(weave, relaxed)
    with timed(seconds, "twin"):
        verdict = _judged(weave, inspection, relaxed, strips, say)
    return Attempt(weave, inspection, relaxed, strips, verdict)


def _judged(
    weave: Weave,
    inspection: Inspection,
    relaxed: Relaxed | None,
    strips: CutStrips,
    say: Say,
) -> Verdict:
    """Put the strips together in simulation, exactly as they are written, and judge what comes of them."""
    from geoweave.fabrication import Pattern
    from geoweave.twin import openings_of

    written = Pattern.from_document(json.loads(json.dumps(strips.pattern.document())))
    if flat := _flat_reasons(weave, written, inspection):
        return Verdict(DO_NOT, flat, "")
    parts = weave.mesh.n_components
    if parts > 1:
        found = verdict_of(inspection, strips, relaxed, ())
        why = f"the object is in {parts} parts, which were not put together in simulation"
        return found if found.word == DO_NOT else Verdict(BUT, (why, *found.reasons), found.remedy)
    space = strips.space
    beside = {"designed": weave.document()} if space is None else {"woven": space}
    try:
        twin, likeness = put_together(written, beside, {}, say)
    except GeoweaveError as error:
        # Without what the message advises for a file: a verdict names what was tried here.
        return verdict_of(inspection, strips, relaxed, (str(error).partition("; ")[0],))
    target = next(iter(likeness.values()))
    openings = openings_of(strips.designed)
    broken = rebuilt_reasons(twin, target, weave.mesh.genus, openings)
    found = verdict_of(inspection, strips, relaxed, broken)
    if found.word != DO_NOT and (why := other_shape(twin)):
        return Verdict(BUT, (why, *found.reasons), found.remedy)
    return found


def _flat_reasons(weave: Weave, pattern: Pattern, inspection: Inspection) -> tuple[str, ...]:
    """Why nobody can make an object of strips, as far as it shows before they are put together."""
    from geoweave.twin import check_sound, openings_of, surface_of

    parts = weave.mesh.n_components
    try:
        surface = surface_of(pattern)
        if parts == 1 or len(surface.pieces) != parts:
            check_sound(surface)
    except FieldError as error:
        # Without what the message advises for a file: a verdict names what was tried here.
        return (str(error).partition("; ")[0], *inspection.violations)
    wrong = surface_reasons(surface, weave.mesh.genus, openings_of(pattern)) if parts == 1 else ()
    return (*wrong, *inspection.violations)


def with_remedy(
    verdict: Verdict,
    first: Attempt,
    prepared: Prepared,
    source: MeshSource,
    request: WeaveRequest,
    say: Say,
) -> Verdict:
    """Try what may help where strips are not to be cut, the nearest first, and say what did.

    A trial ends as soon as its strips fail, which most do before anything is relaxed: where a design closes
    into a wrong surface, so do its strips at another width, or as not relaxed.
    """
    tried = []
    for option, what, other, design, surface in _remedies(first, prepared, request, source.name):
        say(f"trying {what}")
        tried.append(what)
        try:
            found = attempted(surface(), source.seed, other, True, {}, silent, design, trial=True).verdict
        except GeoweaveError:
            continue
        if found is not None and found.word != DO_NOT:
            return replace(verdict, remedy=f"{option} helps ({what}): then the verdict is '{found.word}'")
    vain = f"Tried in vain: {', '.join(tried)}; try" if tried else "Try"
    return replace(verdict, remedy=f"{vain} another --size, --scale or mesh")


def _remedies(
    first: Attempt, prepared: Prepared, request: WeaveRequest, name: str
) -> Iterator[tuple[str, str, WeaveRequest, Weave | None, Callable[[], Prepared]]]:
    """Options that may help, in words, as requests; the design where it is the same one, and the surface.

    A finer mesh draws the same ribbons more exactly. That mends a design that is wrong, and no strips that
    are right and do not hold their shape, so it is tried for the first alone.
    """
    from geoweave.meshing import remeshed

    weave, narrow = first.weave, first.inspection.suggested_width
    if first.cut is not None and first.cut.space is not None:
        other = replace(request, relax=False, strips="straight")
        yield "--no-relax", "strips of the design, not as at rest", other, weave, lambda: prepared
    if narrow is not None and narrow < weave.width * weave.placement.scale:
        thin = None if request.thickness is None else min(request.thickness, narrow)
        other = replace(request, width=narrow, thickness=thin)
        yield f"--width {narrow:.3g}", "narrower strips", other, weave, lambda: prepared
    ribbons = len(weave.ribbons)
    fewer = round(FEWER * ribbons)
    if 0 < fewer < ribbons:
        other = replace(request, ribbons=fewer, scale=None)
        yield f"--ribbons {fewer}", "fewer ribbons", other, None, lambda: prepared
    if first.cut is not None and not _flat_reasons(weave, first.cut.designed, first.inspection):
        return
    faces = FINER * prepared.mesh.n_faces
    other = replace(request, ribbons=ribbons, scale=None)
    finer = f"--faces {faces} --ribbons {ribbons}"
    yield finer, "a finer mesh", other, None, lambda: remeshed(prepared, faces, name=name)


def _designed(
    prepared: Prepared, seed: int, request: WeaveRequest, seconds: dict[str, float], say: Say
) -> Weave:
    """Design a weave on a surface."""
    from geoweave.weave import Steering, edited, weave_pattern

    steering = Steering(request.singularities, request.merge, request.align, symmetric=request.symmetric)
    for each in request.edits:
        if each.steers:
            steering = each.steering(steering, _unit(each, prepared, request))
    changes = _changes(request)
    weave = weave_pattern(
        prepared.mesh,
        symmetry=request.symmetry,
        phase=request.phase,
        pattern=request.pattern,
        scale=request.scale,
        ribbons=request.ribbons,
        seed=seed,
        steering=steering,
        callback=lambda stage: say(f"weaving: {stage}"),
    )
    for each in changes:
        weave = edited(weave, each)
    seconds |= weave.design.seconds
    return weave


def _changes(request: WeaveRequest) -> tuple[Edits, ...]:
    """The edits that change ribbons or crossings; those that ask for another design have to come first."""
    steering = [k for k, each in enumerate(request.edits) if each.steers]
    first = steering[-1] + 1 if steering else 0
    if any(each.changes for each in request.edits[:first]):
        raise FieldError(
            "ribbons were dropped or crossings flipped before, and another design has other ribbons; "
            "edit the weave as it was before that"
        )
    return request.edits[first:]


def _unit(edits: Edits, prepared: Prepared, request: WeaveRequest) -> float:
    """Length of the unit of the edits' points in that of the mesh."""
    import numpy as np

    if edits.units == "mesh":
        return 1.0
    if request.size is None:
        raise FieldError("the edits are of a weave in mm; give the object the same size, with --size MM")
    return float(np.ptp(prepared.mesh.vertices, axis=0).max()) / request.size


def _relaxed(weave: Weave, strips: StripKind, seconds: dict[str, float], say: Say) -> Relaxed:
    from geoweave.rods import relaxed_weave

    rest = relaxed_weave(weave, strips=strips, callback=_telling(say))
    seconds |= rest.seconds
    return rest


def _telling(say: Say) -> Callable[[str, Step | CurvedStep], None]:
    """What tells the progress of sliding, of curving strips and of relaxing."""
    doing = {"slide": "sliding", "relax": "relaxing"}

    from geoweave.rods import CurvedStep

    def told(stage: str, step: Step | CurvedStep) -> None:
        if isinstance(step, CurvedStep):
            say(f"curving strips: trial {step.number}, {step.mean:.2%} of the diagonal from the surface")
        else:
            say(f"{doing[stage]}: step {step.number}, forces balance to {step.gradient:.1g}")

    return told
