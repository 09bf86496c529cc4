"""The width up to which ribbons lie side by side."""

from __future__ import annotations

import numpy as np

from geoweave.weave.widths import widths_that_fit


def test_the_width_that_fits_is_where_strips_begin_to_overlap() -> None:
    rng = np.random.default_rng(0)
    x, a, b = rng.uniform(0.5, 2, 50), *rng.uniform(0.2, np.pi - 0.2, (2, 50))
    width = widths_that_fit(x, a, b)
    for factor, apart in ((0.999, True), (1.001, False)):
        w = factor * width
        clear = np.ones(50, dtype=bool)
        for y in (-w / 2, w / 2):
            right_of_first = y / np.tan(a) + w / (2 * np.sin(a))
            left_of_second = x + y / np.tan(b) - w / (2 * np.sin(b))
            clear &= right_of_first <= left_of_second
        assert clear.all() if apart else not clear.any()
    np.testing.assert_allclose(widths_that_fit(x, a - np.pi, b), width, rtol=1e-9)
    np.testing.assert_allclose(widths_that_fit(x, a, a), x * np.sin(a), rtol=1e-9)
