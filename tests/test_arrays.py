"""A frozen array refuses to be written to, and is the array itself."""

import numpy as np
import pytest

from geoweave.arrays import frozen


def test_frozen_is_the_same_array_made_read_only() -> None:
    array = np.arange(3.0)
    assert frozen(array) is array
    with pytest.raises(ValueError, match="read-only"):
        array[0] = 1.0
