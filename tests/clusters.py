"""A Dask cluster of real processes: a scheduler and workers, started as a user starts them."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
DASK = [sys.executable, "-m", "dask"]


@contextmanager
def cluster(folder: Path, workers: int = 2) -> Iterator[str]:
    """Start a cluster that keeps its files in a folder; gives its address, and ends it."""
    file = folder / "scheduler.json"
    common = ["--scheduler-file", str(file)]
    environment = {**os.environ, "PYTHONPATH": f"{ROOT}{os.pathsep}{ROOT / 'tests'}", "OMP_NUM_THREADS": "1"}
    started = []

    def start(name: str, *arguments: str) -> None:
        log = (folder / f"{name}.log").open("w")
        command = [*DASK, *arguments]
        started.append(subprocess.Popen(command, stdout=log, stderr=log, cwd=folder, env=environment))
        log.close()

    try:
        start("scheduler", "scheduler", "--host", "127.0.0.1", "--port", "0", "--no-dashboard", *common)
        if workers:
            local = ["--local-directory", str(folder), "--no-dashboard"]
            start("workers", "worker", "--nworkers", str(workers), "--nthreads", "1", *local, *common)
        yield _address(file, started[0])
    finally:
        for process in reversed(started):
            process.terminate()
            process.wait()


def _address(file: Path, scheduler: subprocess.Popen[bytes]) -> str:
    """What the scheduler wrote, however long it took; a scheduler that ended writes nothing any more."""
    while scheduler.poll() is None:
        try:
            return str(json.loads(file.read_text())["address"])
        except (OSError, ValueError, KeyError):
            time.sleep(0.1)
    raise RuntimeError(f"the scheduler ended and did not write {file}")
