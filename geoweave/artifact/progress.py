"""Progress of a run of notebooks: live bars on a terminal, elsewhere a line at least every ten seconds."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from types import TracebackType

from rich.console import Console
from rich.progress import BarColumn, Progress as Bars, Task, TaskID, TextColumn, TimeElapsedColumn

SILENCE = 9.0
"""Seconds without a word after which, where no bars are shown, a line says what is running."""

__all__ = ["Progress"]


class Progress:
    """Reports notebooks as they start, advance and end; safe to call from several threads.

    Parameters
    ----------
    total : number of notebooks
    console : where to write; standard error if not given
    clock : tells seconds
    """

    def __init__(
        self, total: int, console: Console | None = None, clock: Callable[[], float] = time.monotonic
    ) -> None:
        self._console = Console(stderr=True) if console is None else console
        self._total = total
        self._ended = 0
        self._tasks: dict[str, TaskID] = {}
        self._clock = clock
        self._began: dict[str, float] = {}
        self._spoke = clock()
        self._lock = threading.Lock()
        self._bars = Bars(
            TextColumn("  {task.description}"),
            BarColumn(bar_width=24),
            TextColumn("{task.completed}/{task.total} cells"),
            TimeElapsedColumn(),
            console=self._console,
            transient=True,
            disable=not self._console.is_terminal,
        )

    def __enter__(self) -> Progress:
        self._bars.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._bars.stop()

    def say(self, line: str, style: str | None = None) -> None:
        """Write a line."""
        self._console.print(line, style=style, markup=False, highlight=False, soft_wrap=True)
        self._spoke = self._clock()

    def start(self, name: str, cells: int) -> None:
        """Report that a notebook with ``cells`` code cells starts."""
        with self._lock:
            self._tasks[name] = self._bars.add_task(name, total=cells)
            self._began[name] = self._clock()

    def advance(self, name: str, cells: int) -> None:
        """Report the number of finished cells. A smaller number than before is ignored."""
        with self._lock:
            if cells > self._task(name).completed:
                self._bars.update(self._tasks[name], completed=cells)
            if not self._console.is_terminal and self._clock() - self._spoke > SILENCE:
                self.say("  running: " + ", ".join(map(self._running, self._tasks)))

    def _task(self, name: str) -> Task:
        return self._bars.tasks[self._bars.task_ids.index(self._tasks[name])]

    def _running(self, name: str) -> str:
        task = self._task(name)
        seconds = self._clock() - self._began[name]
        return f"{name} ({task.completed:.0f} of {task.total:.0f} cells, {seconds:.0f} s)"

    def finish(self, name: str, sentence: str, failed: bool = False) -> None:
        """Report that a notebook has ended, and write its final line."""
        with self._lock:
            self._ended += 1
            if name in self._tasks:
                self._bars.remove_task(self._tasks.pop(name))
            count = f"[{self._ended}/{self._total}]"
            self.say(f"{count} {name}: {sentence}", style="red" if failed else None)
