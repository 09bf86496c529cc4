"""The stages of the design of a weave: who is told of each as it begins, and the seconds of each."""

from __future__ import annotations

import time
from collections.abc import Callable

__all__ = ["Callback", "Stages"]

Callback = Callable[[str], None]
"""Told the name of each stage as it begins."""


class Stages:
    """The seconds of each stage, summed over the times it was entered."""

    def __init__(self, callback: Callback | None, before: dict[str, float]) -> None:
        self.callback, self.seconds = callback, dict(before)
        self.name, self.clock = "", time.perf_counter()

    def begin(self, name: str, more: str = "") -> None:
        """End the stage under way and begin one by this name; "" begins none."""
        now = time.perf_counter()
        if self.name:
            self.seconds[self.name] = self.seconds.get(self.name, 0.0) + now - self.clock
        self.name, self.clock = name, now
        if self.callback is not None and name:
            self.callback(name + more)
