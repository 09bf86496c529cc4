"""Functions are compiled when they are called, give what the interpreted ones give, and call each other."""

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from geoweave.compiled import compiled


def running_maximum(values: np.ndarray) -> np.ndarray:
    result = values.copy()
    for k in range(1, len(result)):
        result[k] = max(result[k - 1], result[k])
    return result


@compiled
def larger(a: float, b: float) -> float:
    """Return the larger of two numbers."""
    return max(a, b)


@compiled
def largest(values: np.ndarray) -> float:
    result = values[0]
    for value in values:
        result = larger(result, value)
    return result


def test_compiled_is_the_same_function() -> None:
    values = np.random.default_rng(0).normal(size=50)
    fast = compiled(running_maximum)
    np.testing.assert_array_equal(fast(values), running_maximum(values))
    np.testing.assert_array_equal(fast(values), np.maximum.accumulate(values))
    assert fast.__name__ == "running_maximum"


def test_compiled_functions_call_each_other() -> None:
    values = np.random.default_rng(1).normal(size=50)
    assert largest(values) == values.max()
    assert largest(values=values) == values.max()
    assert larger(1.0, 2.0) == 2.0
    assert (larger.__name__, larger.__doc__) == ("larger", "Return the larger of two numbers.")


def test_numba_is_imported_by_the_first_call_and_keeps_the_code_on_disk(tmp_path: Path) -> None:
    (tmp_path / "loops.py").write_text(
        "from geoweave.compiled import compiled\n\n\n"
        "@compiled\ndef twice(x):\n    return 2 * x\n\n\n"
        "@compiled\ndef fourfold(x):\n    return twice(twice(x))\n"
    )
    script = (
        "import sys\n"
        f"sys.path.insert(0, {str(tmp_path)!r})\n"
        "import loops\n"
        "before = 'numba' in sys.modules\n"
        "found = loops.fourfold(3)\n"
        "stats = loops.fourfold._dispatcher.stats\n"
        "print(before, found, len(stats.cache_hits), len(stats.cache_misses))\n"
    )
    for hits, misses in ((0, 1), (1, 0)):
        out = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
        assert out.stdout.split() == ["False", "12", str(hits), str(misses)]
    assert list((tmp_path / "__pycache__").glob("loops.fourfold-*.nbc"))


ROOMS_WITH_LOOPS = (
    "curves.tracing",
    "curves.curves",
    "foliation.level_sets",
    "weave.design",
    "weave.inspection",
)


@pytest.mark.parametrize("module", ROOMS_WITH_LOOPS)
def test_importing_a_module_with_loops_imports_no_heavy_library(module: str) -> None:
    heavy = {"numba", "scipy.spatial", "scipy.optimize", "trimesh", "pooch"}
    code = f"import sys, geoweave.{module}; print(sorted({heavy!r} & set(sys.modules)))"
    out = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert out.stdout.strip() == "[]"
