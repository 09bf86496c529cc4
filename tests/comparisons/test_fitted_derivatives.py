"""Derivatives fitted to the neighbours of a face are exact on linear fields of the plane."""

from __future__ import annotations

import numpy as np
from surfaces import surface

from geoweave.comparisons.fitted_derivatives import Derivatives


def test_linear_fields_of_the_plane_have_their_exact_derivatives_and_no_misfit():
    disk = surface("disk")
    frame = disk.frames[:, 0] @ [1, 1j, 0]
    z = disk.barycenters @ [1, 1j, 0]
    p, q, offset = 2.0 - 1.0j, 0.5 + 3.0j, 1.0 + 1.0j
    values = (p * z + q * z.conj() + offset) / frame
    fit = Derivatives.fitted(disk)
    known = (disk.face_neighbors >= 0).sum(axis=1) > 1
    # In the frame of a face, z turns with the frame: p stays, q turns against it twice.
    np.testing.assert_allclose((fit.p @ values)[known], p, atol=1e-9)
    np.testing.assert_allclose((fit.q @ values)[known], (q / frame**2)[known], atol=1e-9)
    np.testing.assert_allclose(fit.misfit @ values, 0, atol=1e-9)


def test_a_face_with_one_neighbour_gets_zeros():
    disk = surface("disk")
    alone = np.flatnonzero((disk.face_neighbors >= 0).sum(axis=1) == 1)
    fit = Derivatives.fitted(disk)
    assert abs(fit.p[alone]).sum() == abs(fit.q[alone]).sum() == 0
