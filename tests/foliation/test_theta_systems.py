"""The systems of Eq. 8: matrices against sums, factors and orderings reused."""

from __future__ import annotations

import numpy as np
import pytest
from eq8 import NAMES, problem

from geoweave.foliation.integrability import vertices_and_faces
from geoweave.sparse import factorization


@pytest.mark.parametrize("name", NAMES)
def test_the_theta_matrix_is_the_sum_it_says(name: str) -> None:
    steps, theta, s = problem(name)
    z, matrix = np.exp(1j * theta), steps.systems.turned(s)
    # |z_b - exp(i s w-perp . e) z_a|^2 = 2 (1 - cos(residual)) at unit length
    smooth = 0.5 * steps.energy.smoothness * (s / steps.unit) @ (steps.energy.laplacian @ (s / steps.unit))
    assert (z.conj() @ (matrix @ z)).real == pytest.approx(2 * (steps.energy(theta, s) - smooth), rel=1e-5)
    np.testing.assert_allclose((matrix - matrix.conj().T).data, 0.0, atol=1e-12)


def test_small_and_large_factorisations_take_the_same_steps(monkeypatch: pytest.MonkeyPatch) -> None:
    """What SuperLU finds without an analysis our Cholesky finds with one, kept from step to step.

    Joint steps are solved for to a tenth, and ours begin with factors in single precision, so they agree
    to a part of their length. A constant theta has no energy and is left to them.
    """
    found = []
    for large in (10**9, 1):
        monkeypatch.setattr(factorization, "LARGE", large)
        steps, theta, s = problem("genus 5")
        for _ in range(3):
            theta, s = steps.improve_both(theta, s)
            s = steps.improve_s(theta, s)
        found.append((theta, s, steps.energy(theta, s)))
    (theta, s, energy), (other_theta, other_s, other_energy) = found
    assert steps.theta_change(theta, other_theta) < 5e-3
    np.testing.assert_allclose(s, other_s, rtol=5e-3)
    assert energy == pytest.approx(other_energy, rel=1e-4)


def test_one_ordering_is_handed_on() -> None:
    steps, _, _ = problem("two pieces")
    mesh = steps.mesh
    ordering = vertices_and_faces(mesh)
    assert ordering.order is not None
    for part, count in (
        (steps.systems.vertex_ordering, mesh.n_vertices),
        (steps.systems.face_ordering, mesh.n_faces),
    ):
        assert part.order is not None
        np.testing.assert_array_equal(np.sort(part.order), np.arange(count))
    # vertices come in the order in which they come among all
    among = ordering.order[ordering.order < mesh.n_vertices]
    np.testing.assert_array_equal(among, steps.systems.vertex_ordering.order)
