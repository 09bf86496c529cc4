"""Progress of a run of notebooks: live bars on a terminal, elsewhere one line for each notebook."""

from __future__ import annotations

import threading
from types import TracebackType

from rich.console import Console
from rich.progress import BarColumn, Progress as Bars, TaskID, TextColumn, TimeElapsedColumn

__all__ = ["Progress"]


class Progress:
    """Reports notebooks as they start, advance and end; safe to call from several threads.

    Parameters
    ----------
    total : number of notebooks
    console : where to write; standard error if not given
    """

    def __init__(self, total: int, console: Console | None = None) -> None:
        self._console = Console(stderr=True) if console is None else console
        self._total = total
        self._ended = 0
        self._tasks: dict[str, TaskID] = {}
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

    def start(self, name: str, cells: int) -> None:
        """Report that a notebook with ``cells`` code cells starts."""
        with self._lock:
            self._tasks[name] = self._bars.add_task(name, total=cells)

    def advance(self, name: str, cells: int) -> None:
        """Report the number of finished cells. A smaller number than before is ignored."""
        with self._lock:
            task = self._tasks[name]
            if cells > self._bars.tasks[self._bars.task_ids.index(task)].completed:
                self._bars.update(task, completed=cells)

    def finish(self, name: str, sentence: str, failed: bool = False) -> None:
        """Report that a notebook has ended, and write its final line."""
        with self._lock:
            self._ended += 1
            if name in self._tasks:
                self._bars.remove_task(self._tasks.pop(name))
            count = f"[{self._ended}/{self._total}]"
            style = "red" if failed else None
            line = f"{count} {name}: {sentence}"
            self._console.print(line, style=style, markup=False, highlight=False, soft_wrap=True)
