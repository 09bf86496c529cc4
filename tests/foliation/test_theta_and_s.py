"""The steps of Eq. 8: models against finite differences, matrices against sums, factors reused."""

from __future__ import annotations

import numpy as np
import pytest
from surfaces import surface

import geoweave as gw
from geoweave.arrays import Scalars
from geoweave.foliation.foliation import punctured
from geoweave.foliation.integrability import vertices_and_faces
from geoweave.foliation.theta_and_s import FLOOR, Alternation
from geoweave.models import shapes
from geoweave.sparse import factorization

NAMES = ("jagged sphere", "genus 5", "two pieces")


def problem(name: str) -> tuple[Alternation, Scalars, Scalars]:
    """Eq. 8 on a surface, with an uneven s and any theta."""
    field, part = punctured(gw.smoothest_field(surface(name)))
    rng = np.random.default_rng(0)
    s = 5.0 * rng.uniform(0.5, 1.5, part.mesh.n_faces)
    return Alternation(field, s, s, 1e-3), rng.uniform(-3.0, 3.0, part.mesh.n_vertices), s


@pytest.mark.parametrize("name", NAMES)
def test_downhill_is_minus_the_gradient(name: str) -> None:
    steps, theta, s = problem(name)
    _, in_theta, in_share = steps._model(theta, s)
    rng, width = np.random.default_rng(1), 1e-6
    along_theta, along_share = rng.normal(size=len(theta)), rng.normal(size=len(s))
    for downhill, way in (
        (in_theta @ along_theta, (along_theta, 0.0)),
        (in_share @ along_share, (0.0, along_share * steps.unit)),
    ):
        ahead, back = (steps.energy(theta + h * way[0], s + h * way[1]) for h in (width, -width))
        assert -(ahead - back) / (2 * width) == pytest.approx(downhill, rel=1e-6)


@pytest.mark.parametrize("name", NAMES)
def test_the_theta_matrix_is_the_sum_it_says(name: str) -> None:
    steps, theta, s = problem(name)
    z, matrix = np.exp(1j * theta), steps.turned(s)
    # |z_b - exp(i s w-perp . e) z_a|^2 = 2 (1 - cos(residual)) at unit length
    smooth = 0.5 * steps.smoothness * (s / steps.unit) @ (steps.laplacian @ (s / steps.unit))
    assert (z.conj() @ (matrix @ z)).real == pytest.approx(2 * (steps.energy(theta, s) - smooth), rel=1e-5)
    np.testing.assert_allclose((matrix - matrix.conj().T).data, 0.0, atol=1e-12)


@pytest.mark.parametrize("name", NAMES)
def test_every_step_lowers_the_energy_and_s_keeps_above_its_floor(name: str) -> None:
    steps, theta, s = problem(name)
    least, energies = FLOOR * s, [steps.energy(theta, s)]
    for _ in range(3):
        theta = steps.improve_theta(theta, s)
        energies.append(steps.energy(theta, s))
        theta, s = steps.improve_both(theta, s)
        energies.append(steps.energy(theta, s))
        s = steps.improve_s(theta, s)
        energies.append(steps.energy(theta, s))
    assert (np.diff(energies) <= 0).all()
    assert (s >= least * (1 - 1e-12)).all()


def test_small_and_large_factorisations_take_the_same_steps(monkeypatch: pytest.MonkeyPatch) -> None:
    """What SuperLU finds without an analysis our Cholesky finds with one, kept from step to step."""
    found = []
    for large in (10**9, 1):
        monkeypatch.setattr(factorization, "LARGE", large)
        steps, theta, s = problem("genus 5")
        for _ in range(3):
            theta, s = steps.improve_both(theta, s)
            s = steps.improve_s(theta, s)
        found.append((theta, s))
    for one, other in zip(*found, strict=True):
        np.testing.assert_allclose(one, other, rtol=1e-6, atol=1e-6)


def test_one_ordering_is_handed_on() -> None:
    steps, _, _ = problem("two pieces")
    mesh = steps.mesh
    ordering = vertices_and_faces(mesh)
    assert ordering.order is not None
    for part, count in ((steps.vertex_ordering, mesh.n_vertices), (steps.face_ordering, mesh.n_faces)):
        assert part.order is not None
        np.testing.assert_array_equal(np.sort(part.order), np.arange(count))
    # vertices come in the order in which they come among all
    among = ordering.order[ordering.order < mesh.n_vertices]
    np.testing.assert_array_equal(among, steps.vertex_ordering.order)


def test_where_no_loop_has_a_period_the_mean_of_s_is_held() -> None:
    """On a disk theta and s could shrink together; where punctures have periods s is free."""
    held, bettis = [], []
    for mesh in (shapes.saddle(faces=600), surface("jagged sphere")):
        field, part = punctured(gw.smoothest_field(mesh))
        mesh = part.mesh
        s = np.full(mesh.n_faces, 20.0)
        steps = Alternation(field, s, s, 1e-3)
        _, theta = steps.eigenvector(steps.start(0), None, s)
        for _ in range(3):
            theta, s = steps.improve_both(theta, s)
            s = steps.improve_s(theta, s)
        bettis.append(mesh.bundle.betti_numbers.tolist())
        held.append(np.average(s / steps.unit, weights=mesh.face_areas))
    assert bettis[0] == [0]
    assert bettis[1][0] > 0
    assert held[0] == pytest.approx(1.0, abs=1e-9)
    assert abs(held[1] - 1.0) > 1e-6
