"""Work comes back from processes and from a real Dask cluster, and what dies takes nothing else with it."""

from __future__ import annotations

import os
import sys
import threading
from collections.abc import Iterator
from pathlib import Path

import pytest
from clusters import cluster

from geoweave.pipeline import workers
from geoweave.pipeline.workers import DIED, Ended, PoolError, on_cluster, on_this_machine


def doubled(number: int) -> tuple[int, int]:
    """Twice a number, and the process that found it; 13 is the end of the process."""
    if number == 13:
        os._exit(3)
    return 2 * number, os.getpid()


@pytest.fixture(scope="module")
def address(tmp_path_factory: pytest.TempPathFactory) -> Iterator[str]:
    with cluster(tmp_path_factory.mktemp("cluster")) as found:
        yield found


def numbers(ended: list[Ended]) -> dict[int, int]:
    assert sorted(each.item for each in ended) == list(range(len(ended)))
    return {each.item: each.result[0] for each in ended if each.result is not None}


@pytest.mark.parametrize("jobs", [1, 2])
def test_each_item_comes_back_from_another_process(jobs: int) -> None:
    ended = list(on_this_machine(doubled, range(5), jobs))
    assert numbers(ended) == {k: 2 * k for k in range(5)}
    assert os.getpid() not in {each.result[1] for each in ended}
    assert not any(each.problem for each in ended)


@pytest.mark.parametrize("jobs", [1, 2])
def test_a_process_that_dies_takes_nothing_else_with_it(jobs: int) -> None:
    ended = list(on_this_machine(doubled, [1, 13, 2, 3], jobs))
    assert numbers(ended) == {0: 2, 2: 4, 3: 6}
    assert {each.item: each.problem for each in ended if each.problem} == {1: DIED}


def test_a_cluster_does_the_same(address: str) -> None:
    ended = list(on_cluster(doubled, [1, 13, 2, 3], address))
    assert numbers(ended) == {0: 2, 2: 4, 3: 6}
    assert {each.item: each.problem for each in ended if each.problem} == {1: DIED}
    assert os.getpid() not in {each.result[1] for each in ended if each.result is not None}


def test_what_a_worker_raises_is_said(address: str) -> None:
    (ended,) = on_cluster(len, [3], address)
    assert ended.problem.startswith("its worker failed (TypeError: ")


def test_clusters_that_are_not_there(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(workers, "CONNECTING", 1.0)
    monkeypatch.setattr(workers, "WORKERS", 1.0)
    before = threading.active_count()
    for wrong in ("tcp://127.0.0.1:9", "no-such-place", "nowhere://x"):
        with pytest.raises(PoolError, match="no Dask scheduler answers there"):
            list(on_cluster(doubled, [1], wrong))
    assert threading.active_count() == before
    with cluster(tmp_path, workers=0) as empty, pytest.raises(PoolError, match="has no workers; start one"):
        list(on_cluster(doubled, [1], empty))


def test_dask_that_is_not_installed(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "distributed", None)
    with pytest.raises(PoolError, match=r"pip install 'geoweave\[dask\]'"):
        list(on_cluster(doubled, [1], "tcp://127.0.0.1:8786"))
