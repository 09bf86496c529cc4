"""Directions of three sheets that are to stay 120 degrees apart in Algorithm 1 (DEVIATIONS.md, zero-sum)."""

from __future__ import annotations

import numpy as np

from geoweave.arrays import Complexes, Scalars
from geoweave.fields.triples import Triples

FIRST_ETA = 1.0
"""eta at the first lambda, where the field settles as a whole and families are kept from running together."""

LAST_ETA = 0.1
"""eta at the last lambda, where the field is to be geodesic first."""

PRESCRIBED_ETA = 0.3
"""The same where singularities are prescribed: families may run together (DEVIATIONS.md, prescribed)."""

SHORT = 1e-3
"""Below this length a vector counts as so long where Newton's method divides by it."""

NEWTON_STEPS = 4
"""Steps towards the sum of the three best directions; it is then right to about ten digits."""


def falling_weights(levels: int, last: float = LAST_ETA) -> tuple[float, ...]:
    """Values of eta for so many values of lambda, a geometric sequence from large to small.

    At a coarse lambda a large eta chooses a field whose families are apart. Then a small one keeps them so,
    and a field that is held less bends less (DEVIATIONS.md, zero-sum).

    Parameters
    ----------
    levels : number of weights, 1 or more; a single one is the last
    last : the last one

    Examples
    --------
    >>> from geoweave.fields.zero_sum import falling_weights
    >>> falling_weights(3)[0], round(falling_weights(3)[1], 3), falling_weights(1)
    (1.0, 0.316, (0.1,))
    """
    if levels == 1:
        return (last,)
    return tuple(float(each) for each in np.geomspace(FIRST_ETA, last, levels))


class ZeroSum:
    """What it costs that three unit vectors over one place do not sum to zero.

    Eq. 5 knows nothing of the other sheets: each turns to where it bends least, and two families may come to
    run side by side. Here Eq. 5 is given the term

        eta/2 sum A |w_0 + w_2 + w_4|^2

    over the places. Three unit vectors sum to zero where they are 120 degrees apart, and only there.

    Parameters
    ----------
    triples : the sheets over each place
    weight : eta, beside the ``1/2 |delta|^2`` of Eq. 5

    Examples
    --------
    >>> from geoweave.fields.zero_sum import ZeroSum
    >>> quotient = gw.weave_field(gw.shapes.torus(faces=400)).cover.quotient
    >>> bool(ZeroSum(quotient.triples).energy(quotient.field.values) < 1e-20)  # a RoSy sums to zero
    True
    """

    def __init__(self, triples: Triples, weight: float = LAST_ETA) -> None:
        self.faces, self.signs, self.weight = triples.faces, triples.signs, weight
        self._areas = triples.mesh.face_areas[triples.faces[:, 0]]

    def energy(self, w: Complexes) -> float:
        """The term that Eq. 5 is given, at unit vectors (F,)."""
        total = (self.signs * w[self.faces]).sum(axis=1)
        return 0.5 * self.weight * float(self._areas @ np.abs(total) ** 2)

    def nearest(self, v: Complexes, w: Complexes) -> Complexes:
        """The w step: unit vectors near v that nearly sum to zero, from the last ones.

        The three are found together, so that the numbers of the sheets decide nothing. At the best vectors,
        ``w_k`` points along ``v_k - eta z``, where z is their sum. This z is the minimum of the convex
        ``|z|^2 / 2 + sum_k |v_k - eta z| / eta``. Where the vectors found cost more than the last ones, as
        may be where some ``v_k - eta z`` vanishes, the last ones stay. From there a step on a bound of the
        cost follows, which is alike for all three. So ``1/2 |v - w|^2`` and the term never rise together.
        """
        near, last = self.signs * v[self.faces], self.signs * w[self.faces]
        found = _along(near - self.weight * self._sum(near, last)[:, None], last)
        lower = self._cost(near, found) < self._cost(near, last)
        unit = np.where(lower[:, None], found, last)
        others = unit.sum(axis=1, keepdims=True) - unit
        unit = _along(near + self.weight * (2.0 * unit - others), unit)
        result = w.copy()
        result[self.faces] = self.signs * unit
        return result

    def _cost(self, near: Complexes, unit: Complexes) -> Scalars:
        """(T,) what the three unit vectors over each place cost beside near, (T, 3), without a constant."""
        agreement = (near * unit.conj()).real.sum(axis=1)
        return np.asarray(0.5 * self.weight * np.abs(unit.sum(axis=1)) ** 2 - agreement)

    def _sum(self, near: Complexes, unit: Complexes) -> Complexes:
        """(T,) the sum z of the best unit vectors over each place, by Newton's method from the last ones."""
        z = unit.sum(axis=1)
        for _ in range(NEWTON_STEPS):
            rest = near - self.weight * z[:, None]
            length = np.maximum(np.abs(rest), SHORT)
            along = rest / length
            # The gradient is z - sum of `along`, the Hessian 1 + eta sum (1 - along along') / length.
            curvature = self.weight / length
            mean = 1.0 + 0.5 * curvature.sum(axis=1)
            spread = -0.5 * (curvature * along**2).sum(axis=1)
            gradient = z - along.sum(axis=1)
            step = (mean * gradient - spread * gradient.conj()) / (mean**2 - np.abs(spread) ** 2)
            z = z - step
        return np.asarray(z)


def _along(vectors: Complexes, otherwise: Complexes) -> Complexes:
    """Unit vectors along the given ones; where these vanish, the others."""
    length = np.abs(vectors)
    return np.where(length > 0, vectors / np.where(length > 0, length, 1.0), otherwise)
