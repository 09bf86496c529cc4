"""Work on many things at a time: in processes of this machine (joblib's loky), or on a Dask cluster.

A process may die, for want of memory or of a fault in compiled code. Then only what it was working on fails.
"""

from __future__ import annotations

import asyncio
import os
import time
from collections.abc import Callable, Generator, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, BrokenExecutor, Future, wait
from contextlib import contextmanager
from typing import Any, NamedTuple, TypeVar

from geoweave.errors import GeoweaveError

__all__ = ["Ended", "PoolError", "check_dask", "on_cluster", "on_this_machine"]

CONNECTING, WORKERS = 20.0, 60.0
"""Seconds in which a scheduler must answer, and in which it must have a worker."""

STARTING, BETWEEN = 10.0, 0.002
"""Seconds that work may take to reach a process before the pool is shut down, and between two looks at it."""

DIED = "its process died, perhaps for want of memory"

THREADS = tuple(f"{name}_NUM_THREADS" for name in ("MKL", "NUMBA", "OMP", "OPENBLAS"))
"""Set to 1: the processes share the cores, and one thread adds in the same order every time."""

Item = TypeVar("Item")


class PoolError(GeoweaveError):
    """A cluster that cannot be worked on, and what to do about it."""


class Ended(NamedTuple):
    """What became of one piece of work."""

    item: int
    """Which one."""
    result: Any
    """What it returned, None if it did not."""
    problem: str
    """Why it did not return, "" if it did."""


def on_this_machine(work: Callable[[Item], Any], items: Sequence[Item], jobs: int) -> Generator[Ended]:
    """Do a piece of work for each item in processes of this machine; yields each as it ends.

    Parameters
    ----------
    work : a function of a module, which processes import; what it raises ends everything
    items : what it is given
    jobs : processes at the same time
    """
    left = list(range(len(items)))
    if jobs > 1:
        with _processes(jobs) as start:
            waiting, under_way, broken = list(left), dict[Future[Any], int](), False
            while (waiting and not broken) or under_way:
                # No more than there are processes: of what waits here, nothing is lost with them.
                while waiting and not broken and len(under_way) < jobs:
                    index = waiting.pop(0)
                    under_way[start(work, items[index])] = index
                for future in wait(under_way, return_when=FIRST_COMPLETED).done:
                    index = under_way.pop(future)
                    if isinstance(future.exception(), BrokenExecutor):
                        broken = True
                    else:
                        left.remove(index)
                        yield Ended(index, future.result(), "")
    # One at a time from here: where a process dies this tells which item it died of.
    while left:
        with _processes(1) as start:
            while left:
                index = left.pop(0)
                try:
                    yield Ended(index, start(work, items[index]).result(), "")
                except BrokenExecutor:
                    yield Ended(index, None, DIED)
                    break


@contextmanager
def _processes(count: int) -> Iterator[Callable[[Callable[[Item], Any], Item], Future[Any]]]:
    """Give what starts a piece of work in one of so many processes of one thread each.

    They end with the block, whatever they are doing.
    """
    from joblib.externals.loky import ProcessPoolExecutor

    pool = ProcessPoolExecutor(count, env=dict.fromkeys(THREADS, "1"))
    started: list[Future[Any]] = []

    def start(work: Callable[[Item], Any], item: Item) -> Future[Any]:
        started.append(pool.submit(work, item))
        return started[-1]

    try:
        yield start
    finally:
        # The pool stumbles over work that is on its way to a process when it is shut down.
        until = time.monotonic() + STARTING
        while time.monotonic() < until and not all(f.running() or f.done() for f in started[-count:]):
            time.sleep(BETWEEN)
        pool.shutdown(wait=True, kill_workers=True)


def check_dask(address: str) -> None:
    """Refuse a cluster where Dask is not installed.

    Raises
    ------
    PoolError
        If it is not.
    """
    try:
        import distributed  # noqa: F401
    except ImportError:
        raise PoolError(
            f"{address}: a Dask cluster needs the package distributed; run: pip install 'geoweave[dask]'"
        ) from None


def on_cluster(work: Callable[[Item], Any], items: Sequence[Item], address: str) -> Generator[Ended]:
    """Do a piece of work for each item on a Dask cluster; yields each as it ends.

    Parameters
    ----------
    work : a function of a module, which workers import
    items : what it is given
    address : of the scheduler, such as ``tcp://host:8786``

    Raises
    ------
    PoolError
        If Dask is missing, nobody answers at the address, or the cluster has no workers.
    """
    check_dask(address)
    import distributed

    # A client that fails to connect leaves a thread behind, which complains when the program ends.
    try:
        asyncio.run(_asked(address))
    except (OSError, ValueError, TypeError, RuntimeError) as error:
        raise PoolError(
            f"{address}: no Dask scheduler answers there ({_brief(error)}); start one with 'dask scheduler', "
            "or work on this machine with --jobs"
        ) from None
    client = distributed.Client(
        address, timeout=CONNECTING, set_as_default=False, name=f"geoweave-{os.getpid()}"
    )
    with client, client.as_current():
        try:
            client.wait_for_workers(1, timeout=WORKERS)
        except TimeoutError:
            raise PoolError(
                f"{address}: the cluster has no workers; start one with 'dask worker {address}'"
            ) from None
        # pure=False: what a file holds may have changed since somebody asked for the same.
        futures = [client.submit(work, item, pure=False) for item in items]
        index_of = {future.key: index for index, future in enumerate(futures)}
        suspects = []
        try:
            for future in distributed.as_completed(futures):
                ended = _ended(index_of[future.key], future)
                if ended.problem == DIED:
                    suspects.append(ended.item)
                else:
                    yield ended
            # Dask blames all that waited on a worker that died, so each of them gets a worker of its own.
            for index in suspects:
                futures.append(client.submit(work, items[index], pure=False))
                yield _ended(index, futures[-1])
        except BaseException:
            client.cancel(futures, force=True)
            raise


async def _asked(address: str) -> None:
    """Shake hands with a scheduler."""
    from distributed import Security
    from distributed.comm import connect

    arguments = Security().get_connection_args("client")
    comm = await connect(address, timeout=CONNECTING, **arguments)
    await comm.close()


def _ended(index: int, future: Any) -> Ended:
    """What a future of Dask holds."""
    from distributed.scheduler import KilledWorker

    try:
        return Ended(index, future.result(), "")
    except KilledWorker:
        return Ended(index, None, DIED)
    except Exception as error:  # whatever the worker or the way to it failed of
        return Ended(index, None, f"its worker failed ({_brief(error)})")


def _brief(error: BaseException) -> str:
    """The kind and the first line of an error."""
    lines = str(error).strip().splitlines()
    return f"{type(error).__name__}: {lines[0]}" if lines else type(error).__name__
