"""Mutated files end with exit 0, or 2 and one sentence; the long run is ``python -m benchmarks.fuzz``."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from benchmarks.fuzz import KINDS, Kind, fault_of, fuzzed, mutated


@pytest.mark.parametrize("name", [*KINDS])
def test_sound_files_are_read(name: str, tmp_path: Path) -> None:
    """So that what is mutated reaches every reader. The first run, which may compile, is not timed."""
    sound = KINDS[name].sound()
    for number, (ending, data) in enumerate([sound[0], *sound]):
        path = tmp_path / f"{number}.{ending}"
        path.write_bytes(data)
        status, says = fault_of(KINDS[name], path, tmp_path / f"out{number}")
        assert (status, says) == (0, "") or number == 0


@pytest.mark.parametrize("name", [*KINDS])
@pytest.mark.parametrize("seed", [1, 2])
def test_mutated_files_end_in_a_result_or_in_one_sentence(name: str, seed: int) -> None:
    statuses, faults = fuzzed(KINDS[name], 75, seed)
    assert [fault.says for fault in faults] == []
    assert min(statuses[0], statuses[2]) >= 3


def test_the_same_seed_makes_the_same_files() -> None:
    data = b"v 1 2 3\nv 4 5 6\n" * 20
    made = [mutated(data, np.random.default_rng(seed)) for seed in (4, 4, 5)]
    assert made[0] == made[1] != made[2]


def test_a_broken_rule_is_seen(tmp_path: Path) -> None:
    path = tmp_path / "file.obj"
    path.write_bytes(b"v 1 2 3")
    _, says = fault_of(Kind(list, lambda path, folder: ["info", "elsewhere.obj"]), path, tmp_path)
    assert "names the file" in says
