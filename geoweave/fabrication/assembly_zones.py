"""Where each step of the assembly is worked, and in which zones of the object (Section 5.4)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from geoweave.arrays import Indices, Scalars, Vectors
from geoweave.errors import FieldError
from geoweave.fabrication.assembly_order import Step, assembly
from geoweave.fabrication.pattern import Pattern

__all__ = ["PER_ZONE", "ZONES", "assembly_numbers", "crossing_places", "work_places", "zoned_assembly"]

PER_ZONE, ZONES = 8, 9
"""A zone has about so many strips, and there are at most so many zones."""


def crossing_places(document: Mapping[str, Any]) -> Vectors:
    """(C, 3) where the crossings of a weave are: half way between its two ribbons there.

    Parameters
    ----------
    document : the contents of ``weave.json`` or ``relaxed.json``
    """
    met = document["crossings"]
    if not met:
        return np.zeros((0, 3))
    ribbons = np.array([each["ribbons"] for each in met], dtype=np.int64)
    at = np.array([each["arclength"] for each in met], dtype=np.float64)
    found = np.zeros((len(met), 3))
    for r, ribbon in enumerate(document["ribbons"]):
        line = np.asarray(ribbon["points"], dtype=np.float64)
        if ribbon["closed"]:
            line = np.concatenate([line, line[:1]])
        along = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(line, axis=0), axis=1))])
        # At rest the line is a little longer or shorter than what is cut.
        share = along[-1] / float(ribbon["length"])
        for side in (0, 1):
            there = np.flatnonzero(ribbons[:, side] == r)
            spots = [np.interp(share * at[there, side], along, line[:, axis]) for axis in range(3)]
            found[there] += 0.5 * np.column_stack(spots)
    return found


def zoned_assembly(pattern: Pattern, document: Mapping[str, Any] | None = None) -> tuple[Step, ...]:
    """The order of assembly with the zone of each step; without a place in space all is one zone.

    Zones are runs of steps: of all ways to part the order into so many runs, that in which the places of
    work of a zone lie nearest to their middle (least sum of squares).

    Parameters
    ----------
    pattern : the strips
    document : of the weave that they are of, the contents of ``weave.json`` or ``relaxed.json``

    Raises
    ------
    FieldError
        If the weave is not that of the pattern.
    """
    if document is None:
        return assembly(pattern)
    names = [each["label"] for each in document["ribbons"]]
    if names != [strip.label for strip in pattern.strips]:
        raise FieldError("the weave has other ribbons than the pattern; write both from the same weave")
    if len(document["crossings"]) != len(pattern.at):
        raise FieldError("the weave has other crossings than the pattern; write both from the same weave")
    places = crossing_places(document)
    steps = assembly(pattern, places)
    if not steps:
        return steps
    work = work_places(steps, places)
    count = min(max(round(len(steps) / PER_ZONE), 1), ZONES)
    return tuple(step._replace(zone=zone) for step, zone in zip(steps, _runs(work, count), strict=True))


def work_places(steps: Sequence[Step], places: Vectors) -> Vectors:
    """(S, 3) the mean of the crossings that each step fastens; one that fastens none is where the next is.

    Parameters
    ----------
    steps : in their order
    places : (C, 3) of the crossings
    """
    found = np.zeros((len(steps), 3))
    following = np.zeros(3)
    for k in range(len(steps) - 1, -1, -1):
        if steps[k].crossings:
            following = places[list(steps[k].crossings)].mean(axis=0)
        found[k] = following
    return found


def assembly_numbers(pattern: Pattern, steps: Sequence[Step], document: Mapping[str, Any]) -> dict[str, Any]:
    """What a report says of the order: how far the hands go from step to step, and what is threaded late.

    Returns
    -------
    dict
        ``zones``; ``mean_step`` and ``longest_step``, the distance between the places of work of consecutive
        steps that fasten something, mm; ``closed`` strips, and ``closed_threaded``, how many of them are laid
        when more than three quarters of their crossings are with what is there.
    """
    places = crossing_places(document)
    work = work_places(steps, places)[[bool(step.crossings) for step in steps]]
    far: Scalars = np.linalg.norm(np.diff(work, axis=0), axis=1)
    closed = [
        step for step in steps if pattern.strips[step.strip].closed and not pattern.strips[step.strip].hoop
    ]
    late = [step for step in closed if len(step.crossings) > 0.75 * len(pattern.passages[step.strip])]
    return {
        "zones": len({step.zone for step in steps}),
        "mean_step": round(float(far.mean()), 2) if len(far) else 0.0,
        "longest_step": round(float(far.max()), 2) if len(far) else 0.0,
        "closed": len(closed),
        "closed_threaded": len(late),
    }


def _runs(points: Vectors, count: int) -> list[int]:
    """Part points in their order into runs of least sum of squares; the run of each, from 0."""
    total = np.concatenate([np.zeros((1, 3)), np.cumsum(points, axis=0)])
    square = np.concatenate([[0.0], np.cumsum((points**2).sum(axis=1))])
    size = len(points)

    def cost(first: Any, end: int) -> Any:
        """Sum of squares of points first to end about their mean."""
        there = total[end] - total[first]
        return square[end] - square[first] - (there**2).sum(axis=-1) / (end - first)

    best = np.array([0.0] + [cost(0, end) for end in range(1, size + 1)])
    cuts: list[Indices] = []
    for _ in range(1, count):
        found, cut = np.full(size + 1, np.inf), np.zeros(size + 1, dtype=np.int64)
        for end in range(2, size + 1):
            firsts = np.arange(1, end)
            costs = best[1:end] + cost(firsts, end)
            k = int(np.argmin(costs))
            found[end], cut[end] = costs[k], firsts[k]
        best, cuts = found, [*cuts, cut]
    zones, end = [0] * size, size
    for number in range(len(cuts), 0, -1):
        first = int(cuts[number - 1][end])
        zones[first:end] = [number] * (end - first)
        end = first
    return zones
