"""Directions of three sheets that are to stay 120 degrees apart in Algorithm 1 (DEVIATIONS.md, zero-sum)."""

from __future__ import annotations

import numpy as np

from geoweave.arrays import Complexes
from geoweave.fields.triples import Triples

FIRST_ETA = 1.0
"""eta at the first lambda, where the field settles as a whole and families are kept from running together."""

LAST_ETA = 0.1
"""eta at the last lambda, where the field is to be geodesic first."""

PRESCRIBED_ETA = 0.3
"""The same where singularities are prescribed: families may run together (DEVIATIONS.md, prescribed)."""

SWEEPS = 2
"""How often each of the three directions is set to its best beside the other two, in one step."""


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

        Beside two others the best direction is that of ``v_k - eta (w_l + w_m)``. The three are set in turn,
        so ``1/2 |v - w|^2`` and the term never rise together.
        """
        near, unit = self.signs * v[self.faces], self.signs * w[self.faces]
        for _ in range(SWEEPS):
            for k in range(3):
                best = near[:, k] - self.weight * (unit[:, k - 1] + unit[:, k - 2])
                length = np.abs(best)
                unit[:, k] = np.where(length > 0, best / np.where(length > 0, length, 1.0), unit[:, k])
        found = w.copy()
        found[self.faces] = self.signs * unit
        return found
