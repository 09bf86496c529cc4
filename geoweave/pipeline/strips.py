"""The strips that are cut of a weave, and what is true of them as they are cut (Section 5.4)."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from geoweave.fabrication import MeasuredStrips, Pattern, WeaveLike

__all__ = ["CutStrips", "strips_of"]


@dataclass(frozen=True, eq=False)
class CutStrips:
    """The strips that are cut of a weave, beside those that its design would give."""

    pattern: Pattern
    """The strips that are cut."""
    designed: Pattern
    """The strips of the design; the same ones where the design is what is cut."""
    space: Mapping[str, Any] | None
    """The weave at rest that the strips are of, as in ``relaxed.json``; None if they are of the design."""
    slipped: int
    """At how many places ribbons slid past each other; if at any, the design is cut instead."""

    @property
    def source(self) -> str:
        """The file that the strips are of."""
        return "weave.json" if self.space is None else "relaxed.json"

    @cached_property
    def measured(self) -> MeasuredStrips:
        """The strips as they are cut, measured."""
        from geoweave.fabrication import measured

        return measured(self.pattern)

    @cached_property
    def differs(self) -> dict[str, tuple[float, float]]:
        """Numbers that are not the same in the design and on the strips, by their names: both of them."""
        from geoweave.fabrication import beside, measured

        return {} if self.pattern is self.designed else beside(measured(self.designed), self.measured)

    def document(self) -> dict[str, Any]:
        """What ``report.json`` says of the strips; all lengths in mm."""
        return {
            "of": self.source,
            "slipped": self.slipped,
            **self.measured.document(),
            "differs": {name: {"design": a, "strips": b} for name, (a, b) in self.differs.items()},
        }


def strips_of(weave: WeaveLike, relaxed: WeaveLike | None, end: float | None = None) -> CutStrips:
    """The strips to be cut of a weave.

    They have the lengths at rest as long as their crossings follow each other as in the design. Where ribbons
    slid past each other the weave at rest is another one, and nobody could put it together as it was
    designed: then the strips have the lengths of the design. Ends that hang are trimmed
    (`geoweave.fabrication.free_end`).

    Parameters
    ----------
    weave : the design, in mm, or the contents of its ``weave.json``
    relaxed : the weave at rest, if it was relaxed, or the contents of its ``relaxed.json``
    end : what an open strip keeps beyond its outermost crossings, mm; four widths if not given

    Raises
    ------
    FieldError
        If the weave is not in mm.
    """
    from geoweave.fabrication import free_end, pattern_of, weave_document
    from geoweave.twin import contradictions_of, surface_of

    end = free_end(weave) if end is None else end
    designed = pattern_of(weave, end=end)
    if relaxed is None:
        return CutStrips(designed, designed, None, 0)
    lies = weave_document(relaxed, "relaxed.json")
    strips = pattern_of(lies, "relaxed.json", end=end)
    slipped = len(strips.reordered) or sum(each.plain for each in contradictions_of(surface_of(strips)))
    if slipped:
        return CutStrips(designed, designed, None, slipped)
    return CutStrips(strips, designed, lies, 0)
