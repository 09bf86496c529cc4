"""A compiled function gives what the interpreted one gives, and keeps its name."""

import numpy as np

from geoweave.compiled import compiled


def running_maximum(values: np.ndarray) -> np.ndarray:
    result = values.copy()
    for k in range(1, len(result)):
        result[k] = max(result[k - 1], result[k])
    return result


def test_compiled_is_the_same_function() -> None:
    values = np.random.default_rng(0).normal(size=50)
    fast = compiled(running_maximum)
    np.testing.assert_array_equal(fast(values), running_maximum(values))
    np.testing.assert_array_equal(fast(values), np.maximum.accumulate(values))
    assert fast.__name__ == "running_maximum"
