"""The verdict on strips that are to be cut: whether to make the object, judged on its twin."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from geoweave.wording import counted

if TYPE_CHECKING:
    from geoweave.pipeline.strips import CutStrips
    from geoweave.rods import Relaxed
    from geoweave.twin import Likeness, PatternSurface, Twin
    from geoweave.weave import Inspection

__all__ = [
    "BUT",
    "DO_NOT",
    "HOLDS",
    "MAKE",
    "Verdict",
    "other_shape",
    "rebuilt_reasons",
    "surface_reasons",
    "verdict_of",
]

MAKE, BUT, DO_NOT = "make it", "make it, but", "do not cut this"
"""The words of a verdict."""

HOLDS = 0.05
"""A weave that rests nearer to its surface than this share of the bounding diagonal holds its shape."""

WATCH = {
    "near_parallel": (
        "at one crossing two ribbons lie nearly along each other",
        "at {n} crossings two ribbons lie nearly along each other",
    ),
    "alongside": (
        "at one place ribbons lie on each other side by side",
        "at {n} places ribbons lie on each other side by side",
    ),
    "lap": ("two ends lie on each other", "{n} pairs of ends lie on each other"),
    "knot": ("there is a knot of short ribbons", "there are {n} knots of short ribbons"),
    "gap": ("there is a hole wider than the spacing", "there are {n} holes wider than the spacing"),
    "bare_component": ("a piece of the surface has no ribbon", "{n} pieces of the surface have no ribbon"),
    "loose_end": ("one end is loose, fasten it", "{n} ends are loose, fasten them"),
}
"""What a maker is told of places that are hard to weave, of one and of many; crowded ones the width tells."""


@dataclass(frozen=True)
class Verdict:
    """Whether to make an object of its strips.

    Examples
    --------
    >>> from geoweave.pipeline.verdict import BUT, Verdict
    >>> print(Verdict(BUT, ("2 knots of short ribbons",), "").sentence)
    make it, but: 2 knots of short ribbons
    """

    word: str
    """`MAKE`, `BUT` or `DO_NOT`."""
    reasons: tuple[str, ...]
    """In a maker's words, the weightiest first; none for `MAKE`."""
    remedy: str
    """What was tried and helped, or what was tried in vain; "" where nothing needs one."""

    @property
    def sentence(self) -> str:
        """The verdict in one line."""
        said = self.word if not self.reasons else f"{self.word}: {'; '.join(self.reasons)}"
        return f"{said}. {self.remedy}" if self.remedy else said

    def document(self) -> dict[str, Any]:
        """For reports."""
        return {"word": self.word, "reasons": list(self.reasons), "remedy": self.remedy}


def rebuilt_reasons(
    twin: Twin, target: Likeness | None, genus: int | None, openings: int | None
) -> tuple[str, ...]:
    """Why the object does not come back from its strips alone; nothing if it does.

    Parameters
    ----------
    twin : the strips put together in simulation
    target : its comparison with the weave, if there is one
    genus, openings : of the surface that the weave was designed on; None if they are not known
    """
    found = list(surface_reasons(twin.surface, genus, openings))
    if target is not None and not target.comes_back:
        one, other = (twin.pattern.strips[r].label for r in twin.pattern.ribbons[target.worst])
        off = target.crossings.largest
        found.append(
            f"put together, the object has another shape: {one} crosses {other} "
            f"{off * target.diagonal:.3g} mm from its place, {off:.1%} of the diagonal"
            f"{_hanging(twin.surface, target.worst)}"
        )
    return tuple(found)


def other_shape(twin: Twin) -> str:
    """What is to be said of strips that rest in the shape of the weave, and in another one; "" of no such."""
    if twin.alone is None:
        return ""
    one, other = (twin.pattern.strips[r].label for r in twin.pattern.ribbons[twin.alone.worst])
    off = twin.alone.crossings.largest * twin.alone.diagonal
    return (
        f"the strips can also rest in another shape, less easily, where {one} crosses {other} {off:.3g} mm "
        "from its place; press them into the shape of the picture there"
    )


def _hanging(surface: PatternSurface, crossing: int) -> str:
    """What is to be said of a crossing whose place is not certain, since little holds the part it is in."""
    from geoweave.twin import hanging_parts

    for part in hanging_parts(surface):
        if crossing in part.crossings:
            one, other = (surface.pattern.strips[r].label for r in surface.pattern.ribbons[part.at])
            return (
                f"; it is one of {counted(len(part.crossings), 'crossing')} that hang on the rest at one "
                "place, where "
                f"{one} crosses {other}"
            )
    return ""


def surface_reasons(surface: PatternSurface, genus: int | None, openings: int | None) -> tuple[str, ...]:
    """Why the strips close into another surface than the design's; nothing if they do not.

    Parameters
    ----------
    surface : of the strips
    genus, openings : of the surface that the weave was designed on; None if they are not known
    """
    return tuple(
        f"put together, the strips make a surface with {counted(is_there, what)}{where}, not {wanted}"
        for what, where, wanted, is_there in (
            ("hole", " through it", genus, surface.genus),
            ("opening", "", openings, surface.openings),
        )
        if wanted is not None and is_there is not None and is_there != wanted
    )


def verdict_of(
    inspection: Inspection, strips: CutStrips, relaxed: Relaxed | None, broken: tuple[str, ...]
) -> Verdict:
    """Judge a weave whose strips were put together in simulation.

    Parameters
    ----------
    inspection : what is hard to make of the weave as designed
    strips : those that are cut, as measured
    relaxed : the weave at rest, if it was relaxed
    broken : why the object does not come back (`rebuilt_reasons`), or why nobody can put it together
    """
    if broken or inspection.violations:
        return Verdict(DO_NOT, (*broken, *inspection.violations), "")
    reasons, remedy = [], ""
    if strips.measured.as_cut.share_that_fits < inspection.limits.fitting:
        share = f"{strips.measured.as_cut.share_that_fits:.0%} of the neighbouring crossings"
        reasons.append(f"only {share} fit at this width")
        if inspection.suggested_width is not None:
            remedy = f"Narrower strips fit better: --width {inspection.suggested_width:.3g}"
    if relaxed is not None:
        reasons += _at_rest(relaxed.metrics())
    if strips.slipped:
        near = f"ribbons slid past each other {counted(strips.slipped, 'time')}"
        reasons.append(f"{near}, so the strips have the lengths of the design")
    counts = inspection.counts
    there = {kind: counts[kind] for kind in WATCH if counts[kind]}
    reasons += [WATCH[kind][n > 1].format(n=n) for kind, n in there.items()]
    return Verdict(BUT if reasons else MAKE, tuple(reasons), remedy)


def _at_rest(rest: Mapping[str, Any]) -> list[str]:
    """What is to be said of how the whole weave rests, free ends included."""
    if not rest["converged"]:
        return [f"the simulation did not come to rest ({rest['ending']}), so its shape is not certain"]
    if rest["hausdorff"] < HOLDS:
        return []
    return [f"it will not keep its shape: it rests up to {rest['hausdorff']:.1%} of the diagonal away"]
