"""One notebook, executed by papermill in a process of its own, with its time and its memory.

The parent process reads the result from ``outcome.json``. If that file is missing, the child has crashed. A
child ends itself when its parent is gone, and so do Jupyter's kernels, so that no process is left running.
"""

from __future__ import annotations

import argparse
import json
import os
import platform
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from types import FrameType

from geoweave.artifact import doctor, notebooks
from geoweave.checkout import FIGURES_VARIABLE

CELL_TIMEOUT = {"default": 900, "paper": 7200}
"""Seconds that one cell may take before its notebook counts as failed."""

__all__ = ["CELL_TIMEOUT", "Children", "Outcome", "execute", "interrupt_once"]


@dataclass(frozen=True)
class Outcome:
    """How an execution ended.

    Attributes
    ----------
    problem : "" for success, else the cell and the last line of its error
    seconds : wall time
    peak_mb : peak resident memory of the kernel in MB (10^6 bytes), 0 where the platform does not report it
    """

    problem: str
    seconds: float = 0.0
    peak_mb: float = 0.0


class Children:
    """The running child processes. An interruption ends them, and with them their kernels."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._alive: set[subprocess.Popen[str]] = set()
        self._stopped = False

    def start(self, command: list[str], environment: dict[str, str], log: Path) -> subprocess.Popen[str]:
        """Start a process that writes to ``log``. After :meth:`stop` no process can be started."""
        with self._lock:
            self.refuse()
            with log.open("w") as out:
                # Ctrl-C does not reach a child in its own session, so that the parent can end it in order.
                child = subprocess.Popen(
                    command, env=environment, stdout=out, stderr=out, text=True, start_new_session=True
                )
            self._alive.add(child)
            return child

    def ended(self, child: subprocess.Popen[str]) -> None:
        """Forget a process that has ended."""
        with self._lock:
            self._alive.discard(child)

    def stop(self) -> None:
        """Ask all to end, kill those left after ten seconds, and let no more start."""
        with self._lock:
            self._stopped = True
            for child in self._alive:
                child.terminate()
            deadline = time.monotonic() + 10.0
            for child in self._alive:
                try:
                    child.wait(timeout=max(0.0, deadline - time.monotonic()))
                except subprocess.TimeoutExpired:
                    child.kill()

    def refuse(self) -> None:
        """Raise KeyboardInterrupt once :meth:`stop` was called."""
        if self._stopped:
            raise KeyboardInterrupt


def execute(
    root: Path,
    name: str,
    profile: str,
    folder: Path,
    children: Children,
    advance: Callable[[int], None],
) -> Outcome:
    """Execute one notebook; ``folder`` gets ``executed.ipynb`` and what it publishes under ``figures/``.

    Parameters
    ----------
    root : the checkout
    name, profile : the notebook, and the profile that gives its parameters
    folder : an empty folder that exists
    children : the running child processes
    advance : called about every second with the number of finished code cells
    """
    (folder / "figures").mkdir()
    executed = folder / "executed.ipynb"
    environment = doctor.rendering_environment()
    search = filter(None, [str(root), environment.get("PYTHONPATH", "")])
    environment |= {
        FIGURES_VARIABLE: str(folder / "figures"),
        "IPYTHONDIR": str(folder / "ipython"),
        "JUPYTER_PREFER_ENV_PATH": "1",
        "PYDEVD_DISABLE_FILE_VALIDATION": "1",
        "PYTHONHASHSEED": "0",
        "PYTHONPATH": os.pathsep.join(search),
    }
    task = [str(root), name, profile, str(executed), str(os.getpid())]
    child = children.start(
        [sys.executable, "-m", "geoweave.artifact.execution", *task], environment, folder / "log.txt"
    )
    try:
        while True:
            try:
                child.wait(timeout=1.0)
                break
            except subprocess.TimeoutExpired:
                advance(_cells_done(executed))
    finally:
        children.ended(child)
    children.refuse()
    outcome = folder / "outcome.json"
    if not outcome.is_file():
        last = _last_line((folder / "log.txt").read_text(errors="replace"))
        return Outcome(f"its process ended with status {child.returncode} ({last})")
    return Outcome(**json.loads(outcome.read_text()))


def interrupt_once() -> None:
    """Let only the first SIGINT or SIGTERM raise KeyboardInterrupt: cleaning up is not interrupted."""

    def handle(number: int, frame: FrameType | None) -> None:
        signal.signal(signal.SIGINT, signal.SIG_IGN)
        signal.signal(signal.SIGTERM, signal.SIG_IGN)
        raise KeyboardInterrupt

    signal.signal(signal.SIGINT, handle)
    signal.signal(signal.SIGTERM, handle)


def _cells_done(executed: Path) -> int:
    """Cells that papermill has finished, read from the file that it updates; 0 if that is half written."""
    try:
        cells = json.loads(executed.read_text())["cells"]
    except (OSError, ValueError):
        return 0
    return sum(
        cell["cell_type"] == "code" and cell["metadata"].get("papermill", {}).get("status") == "completed"
        for cell in cells
    )


def _last_line(text: str) -> str:
    return next((line.strip() for line in reversed(text.splitlines()) if line.strip()), "no message")


def _peak_mb() -> float:
    """Peak resident memory of the largest ended child, in MB; 0 where the platform does not report it."""
    if platform.system() == "Windows":
        return 0.0
    import resource

    peak = resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss
    return round(peak * (1 if platform.system() == "Darwin" else 1024) / 1e6, 1)


def _end_with(parent: int) -> None:
    """End this process by a signal once its parent is gone."""

    def watch() -> None:
        while os.getppid() == parent:
            time.sleep(2.0)
        os.kill(os.getpid(), signal.SIGTERM)

    threading.Thread(target=watch, daemon=True).start()


def main() -> int:
    """Run in the child: execute one notebook and write ``outcome.json`` beside it."""
    import papermill
    from papermill.exceptions import PapermillExecutionError

    parser = argparse.ArgumentParser(prog="python -m geoweave.artifact.execution")
    parser.add_argument("root", type=Path)
    parser.add_argument("name")
    parser.add_argument("profile")
    parser.add_argument("executed", type=Path)
    parser.add_argument("parent", type=int)
    task = parser.parse_args()
    interrupt_once()  # so that nbclient shuts its kernel down
    if platform.system() != "Windows":
        _end_with(task.parent)
    started = time.perf_counter()
    problem = ""
    try:
        papermill.execute_notebook(
            notebooks.path_of(task.root, task.name),
            task.executed,
            parameters=notebooks.profile_values(task.root, task.name, task.profile),
            kernel_name="python3",
            language="python",
            progress_bar=False,
            cwd=task.root / "notebooks",
            start_timeout=300,
            execution_timeout=CELL_TIMEOUT[task.profile],
        )
    except PapermillExecutionError as error:
        problem = f"cell In[{error.exec_count}]: {_last_line(f'{error.ename}: {error.evalue}')}"
    except Exception as error:  # any error is reported with the notebook's name
        problem = f"{type(error).__name__}: {_last_line(str(error))}"
    seconds = round(time.perf_counter() - started, 1)
    outcome = {"problem": problem, "seconds": seconds, "peak_mb": _peak_mb()}
    partial = task.executed.with_name("outcome.json.partial")
    partial.write_text(json.dumps(outcome))
    partial.replace(task.executed.with_name("outcome.json"))
    return 0


if __name__ == "__main__":
    sys.exit(main())
