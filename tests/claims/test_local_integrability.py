"""What Section 4.2.1 says of integrating factors in the smooth setting."""

from __future__ import annotations

import numpy as np
from scipy.integrate import solve_ivp


def covector(y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The field w-perp that the paper takes from Boyling 1968; it does not depend on x."""
    return y**3 * (1 - y) ** 2, y**3 - 2 * (1 - y**2)


def leaf_through(x: float, y: float) -> float:
    """Where the integral curve of w through a point, a dx + b dy = 0, meets the line x = 0."""

    def slope(_: float, height: np.ndarray) -> np.ndarray:
        a, b = covector(height)
        return -a / b

    return float(solve_ivp(slope, (x, 0.0), [y], rtol=1e-11, atol=1e-13, max_step=0.01).y[0, -1])


def test_the_counterexample_is_integrable_near_the_line():
    """4.2.1 says that w-perp = (y^3 (1 - y)^2, y^3 - 2 (1 - y^2)) "is not integrable on any neighborhood of a
    point on the line y = 1". Near y = 1 it does not vanish, so it is: theta numbers the leaves by where
    they meet x = 0, and s = |grad theta| / |w-perp| stays near 1 (DEVIATIONS.md, integrating-factors).
    """
    step = 1e-4
    for x in (-0.3, -0.1, 0.1, 0.3):
        for y in (0.95, 0.99, 0.999, 1.0, 1.001, 1.01, 1.05):
            rise = (leaf_through(x, y + step) - leaf_through(x, y - step)) / (2 * step)
            run = (leaf_through(x + step, y) - leaf_through(x - step, y)) / (2 * step)
            a, b = covector(np.array(y))
            s = (run * a + rise * b) / (a**2 + b**2)
            # parallel to w-perp, up to the central differences
            assert abs(run * b - rise * a) < 1e-6
            assert 0.6 < s < 1.7
    # On the line itself, where s is said to diverge, the leaf is the line and s is 1.
    assert leaf_through(0.3, 1.0) == 1.0
