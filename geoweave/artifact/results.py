"""What became of the notebooks of a run, one by one and in all."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

__all__ = ["Result", "summary"]


@dataclass(frozen=True)
class Result:
    """What became of one notebook.

    Attributes
    ----------
    name, profile : the notebook and its profile
    state : "fresh" (nothing to do), "done" (executed now) or "failed"
    seconds : wall time of the execution that gave the result
    peak_mb : peak resident memory of the kernel in MB (10^6 bytes), 0 where the platform does not report it
    figures : published files, relative to the figures folder, in order
    problem : for a failure, the cell, the error's last line, and where the failed notebook is kept
    """

    name: str
    profile: str
    state: str
    seconds: float = 0.0
    peak_mb: float = 0.0
    figures: tuple[str, ...] = ()
    problem: str = ""

    def sentence(self) -> str:
        """What the progress display says about the result."""
        if self.state == "failed":
            return f"failed: {self.problem}"
        if self.state == "fresh":
            return "up to date"
        pictures = sum(figure.endswith(".png") for figure in self.figures)
        return f"done in {self.seconds:.0f} s, {self.peak_mb:.0f} MB, {pictures} picture(s)"


def summary(results: Sequence[Result], profile: str, seconds: float) -> str:
    """What a run came to, for the end of its messages: counts, place, and the failures once more."""
    states = Counter(result.state for result in results)
    made = Counter(Path(figure).suffix for result in results for figure in result.figures)
    folder = "figures/" if profile == "default" else f"figures/{profile}/"
    took = f"{int(seconds) // 60}:{int(seconds) % 60:02} min"
    count = {state: states[state] for state in ("done", "fresh", "failed")}
    ran = f"{count['done']} executed, {count['fresh']} up to date, {count['failed']} failed"
    made_here = f"{made['.png']} pictures and {made['.csv']} tables"
    failed = [f"failed: {result.name}: {result.problem}" for result in results if result.state == "failed"]
    lines = [
        f"{len(results)} notebooks in {took}: {ran}",
        f"{made_here} lie in {folder} (all: figures/INDEX.md)",
    ]
    return "\n".join(lines + failed)
