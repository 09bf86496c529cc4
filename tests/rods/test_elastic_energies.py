from dataclasses import replace

import numpy as np
import pytest
from rodded import MATERIAL, any_rotation, bar, crumpled, helix, ring, turned

from geoweave.rods.contact_energies import contact_orientation, contact_position
from geoweave.rods.elastic_energies import (
    Term,
    edgewise_bending,
    elastic_terms,
    energy_density,
    flatwise_bending,
    sliding,
    stretching,
    twisting,
)
from geoweave.rods.rods import DERIVED, Rods


def all_terms(rods):
    rng = np.random.default_rng(5)
    normals = rng.normal(size=rods.points.shape)
    normals /= np.linalg.norm(normals, axis=1)[:, None]
    return {
        term.name: term
        for term in (
            *elastic_terms(rods.layout),
            contact_position(rods, 10.0),
            contact_orientation(rods, 20.0),
            sliding(rods.layout, rods.points + 0.1, normals, 3.0, 0.5),
        )
    }


NAMES = tuple(all_terms(crumpled()))


@pytest.mark.parametrize("name", NAMES)
def test_jacobian_is_the_derivative_of_the_residual(name):
    rods = crumpled()
    term = all_terms(rods)[name]
    exact = term.jacobian(rods).toarray()
    small = 1e-6
    for unknown in range(rods.size):
        step = np.zeros(rods.size)
        step[unknown] = small
        ahead, behind = rods.stepped(step), rods.stepped(-step)
        difference = (term.residual(ahead) - term.residual(behind)).ravel() / (2 * small)
        np.testing.assert_allclose(exact[:, unknown], difference, atol=2e-9 * abs(exact).max())


@pytest.mark.parametrize("name", NAMES)
def test_gradient_is_the_derivative_of_the_energy_along_any_step(name):
    rods = crumpled(4)
    term = all_terms(rods)[name]
    step = 1e-5 * np.random.default_rng(0).normal(size=rods.size)
    change = term.energy(rods.stepped(step)) - term.energy(rods.stepped(-step))
    assert change == pytest.approx(2 * term.gradient(rods) @ step, rel=1e-6)


def flush(rods):
    """The same rods with both directors of each contact along the common normal."""
    directors = rods.directors.copy()
    for a, b in rods.contacts.segments:
        normal = np.cross(rods.tangents[a], rods.tangents[b])
        normal /= np.linalg.norm(normal)
        directors[a], directors[b] = normal, -normal
    return replace(rods, directors=directors, twists=DERIVED)


@pytest.mark.parametrize("name", [name for name in NAMES if name != "sliding"])
def test_curvature_is_the_second_derivative_of_the_residual(name):
    rods = crumpled()
    if name == "contact orientation":  # it is exact where ribbons lie flush
        rods = flush(rods)
    term = all_terms(rods)[name]
    rng = np.random.default_rng(3)
    weights = rng.normal(size=term.residual(rods).shape)
    blocks = term.curvature(rods, weights)
    np.testing.assert_allclose(blocks, blocks.transpose(0, 2, 1), atol=1e-12 * abs(blocks).max())
    small = 1e-4
    for _ in range(5):
        step = rng.normal(size=rods.size)
        states = [rods.stepped(x * step) for x in (small, 0.0, -small)]
        ahead, here, behind = ((weights * term.residual(each)).sum() for each in states)
        local = step[term.unknowns]
        exact = np.einsum("ni,nij,nj->", local, blocks, local)
        size = np.einsum("ni,nij,nj->n", local, blocks, local)
        assert (ahead - 2 * here + behind) / small**2 == pytest.approx(exact, abs=1e-5 * abs(size).sum())


@pytest.mark.parametrize("name", [name for name in NAMES if name != "sliding"])
def test_rigid_motions_cost_nothing(name):
    rods = crumpled(2)
    moved = turned(rods, any_rotation(), np.array([3.0, -1.0, 2.0]))
    term = all_terms(rods)[name]
    assert term.energy(moved) == pytest.approx(term.energy(rods), rel=1e-11)
    gradient = term.gradient(rods)
    forces = gradient[: 3 * rods.layout.vertices].reshape(-1, 3)
    torques = gradient[3 * rods.layout.vertices :, None] * rods.tangents
    size = abs(forces).max()
    np.testing.assert_allclose(forces.sum(axis=0), 0, atol=1e-12 * size)
    np.testing.assert_allclose(
        np.cross(rods.points, forces).sum(axis=0) + torques.sum(axis=0), 0, atol=1e-11 * size
    )


@pytest.mark.parametrize("name", [name for name in NAMES if "contact" not in name and name != "sliding"])
def test_turning_a_strip_over_changes_nothing(name):
    rods = crumpled()
    over = replace(rods, directors=-rods.directors, natural=-rods.natural, twists=DERIVED)
    term = all_terms(rods)[name]
    assert term.energy(over) == pytest.approx(term.energy(rods), rel=1e-13)


def test_a_straight_flat_rod_is_at_rest():
    rods = bar(10)
    for term in elastic_terms(rods.layout):
        assert term.energy(rods) == 0
        assert not term.gradient(rods).any()


def test_stretching_is_a_spring():
    rods = bar(8, 2.0)
    long = Rods(
        rods.layout, 1.05 * rods.points, rods.directors, rods.widths, rods.rest, rods.contacts, MATERIAL
    )
    # 1/2 Y w h L strain^2
    expected = 0.5 * 1e6 * 0.1 * 0.01 * 2.0 * 0.05**2
    assert stretching(rods.layout).energy(long) == pytest.approx(expected, rel=1e-12)


@pytest.mark.parametrize(("upright", "kind"), [(True, flatwise_bending), (False, edgewise_bending)])
def test_the_bending_energy_of_a_ring_converges_to_pi_b_over_r(upright, kind):
    stiffness = 1e6 * (0.1 * 0.01**3 if upright else 0.01 * 0.1**3) / 12
    errors = []
    for count in (20, 40, 80):
        rods = ring(count, 2.0, upright=upright)
        errors.append(abs(kind(rods.layout).energy(rods) / (np.pi * stiffness / 2.0) - 1))
        other = edgewise_bending if upright else flatwise_bending
        assert other(rods.layout).energy(rods) < 1e-25
        assert twisting(rods.layout).energy(rods) < 1e-25
    rates = np.log2(np.array(errors[:-1]) / errors[1:])
    assert (rates > 1.9).all()
    assert errors[-1] < 2e-3


@pytest.mark.parametrize("natural", [0.0, 0.3, 1.0])
def test_a_ring_of_a_naturally_curved_strip_has_the_energy_of_what_it_is_unbent_by(natural):
    # A flat ring of radius R, cut with the curvature c: pi B R (1 / R - c)^2. Its flat inner angle
    # turns left seen from tau, which is a negative -kb . tau.
    radius, count = 2.0, 80
    rods = ring(count, radius, upright=False)
    rods = replace(rods, natural=-2 * np.tan(0.5 * natural * rods.spans))
    stiffness = 1e6 * 0.01 * 0.1**3 / 12
    expected = np.pi * stiffness * radius * (1 / radius - natural) ** 2
    assert edgewise_bending(rods.layout).energy(rods) == pytest.approx(expected, rel=1e-2)
    assert flatwise_bending(rods.layout).energy(rods) < 1e-25


def test_a_helix_bends_flatwise_and_twists_by_its_torsion():
    # On a cylinder with its thickness outwards: geodesic, k = r / (r^2 + c^2), twist c / (r^2 + c^2)
    r, c, turns = 1.0, 0.3, 2.0
    rods = helix(400, r, 2 * np.pi * c, turns)
    length = 2 * np.pi * turns * np.hypot(r, c)
    material = rods.material
    width = rods.joint_widths[0]
    bend = 0.5 * material.bending(width) * (r / (r * r + c * c)) ** 2 * length
    twist = 0.5 * material.twisting(width) * (c / (r * r + c * c)) ** 2 * length
    share = 399 / 400  # joints over segments
    assert flatwise_bending(rods.layout).energy(rods) == pytest.approx(share * bend, rel=1e-3)
    assert twisting(rods.layout).energy(rods) == pytest.approx(share * twist, rel=1e-3)
    assert edgewise_bending(rods.layout).energy(rods) < 1e-6 * bend


def test_a_twisted_ring_costs_its_twist():
    flat = ring(60)
    turn = 2 * np.pi * np.arange(60) / 60
    across = np.cross(flat.tangents, flat.directors)
    directors = np.cos(turn)[:, None] * flat.directors + np.sin(turn)[:, None] * across
    rods = Rods(flat.layout, flat.points, directors, flat.widths, flat.rest, flat.contacts, MATERIAL)
    # 1/2 G J (2 pi)^2 / L: once round
    length = flat.rest.sum()
    expected = 0.5 * MATERIAL.twisting(np.array(0.1)) * (2 * np.pi) ** 2 / length
    assert twisting(rods.layout).energy(rods) == pytest.approx(expected, rel=1e-10)


def test_sliding_costs_little_along_the_surface_and_much_off_it():
    rods = bar(1)
    normals = np.tile([0.0, 0, 1], (2, 1))
    for shift, cost in (
        (np.array([0.3, 0.4, 0]), 0.5 * 2.0 * 0.25),
        (np.array([0, 0, 0.1]), 0.5 * 90 * 0.01),
    ):
        term = sliding(rods.layout, rods.points - shift, normals, 90.0, 2.0)
        assert term.energy(rods) == pytest.approx(2 * cost)


def test_energy_density_adds_up_to_the_energy():
    rods = crumpled()
    found = energy_density(rods)
    for term in elastic_terms(rods.layout):
        assert found[term.name] @ rods.rest == pytest.approx(term.energy(rods))


def test_a_jacobian_is_laid_out_by_stencil_and_residual():
    rods = crumpled()
    term = flatwise_bending(rods.layout)
    residual = term.residual(rods)
    assert isinstance(term, Term)
    assert term.jacobian(rods).shape == (residual.size, rods.size)
    np.testing.assert_allclose(term.jacobian(rods).T @ residual.ravel(), term.gradient(rods), atol=1e-12)
