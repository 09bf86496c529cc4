"""Three directions that are to sum to zero: what it costs, the step that keeps them so, Algorithm 1."""

from __future__ import annotations

import numpy as np
import pytest
from eq8 import three_sheets

import geoweave as gw
from geoweave.errors import FieldError
from geoweave.fields import geodesic_field
from geoweave.fields.face_field import FaceField, Handles, unit
from geoweave.fields.zero_sum import ZeroSum, falling_weights


def opening(field: FaceField, sheets: np.ndarray, signs: np.ndarray) -> np.ndarray:
    """(T, 3) degrees between the directions of successive sheets over each place."""
    w = signs * field.values[sheets]
    return np.degrees(np.abs(np.angle(w / np.roll(w, 1, axis=1))))


def test_directions_120_degrees_apart_cost_nothing() -> None:
    field, triples = three_sheets()
    sums = ZeroSum(triples)
    assert sums.energy(field.values) == pytest.approx(0.0, abs=1e-20)
    # All three the same: |3|^2 on every place.
    same = np.tile(field.values[: len(triples.faces)], 3)
    area = field.mesh.face_areas.sum() / 3
    assert sums.energy(same) == pytest.approx(4.5 * sums.weight * area)


@pytest.mark.parametrize("weight", [0.0, 0.3, 3.0])
def test_the_step_never_raises_what_it_lowers(weight: float) -> None:
    field, triples = three_sheets()
    areas, rng = field.mesh.face_areas, np.random.default_rng(0)
    v, w = rng.normal(size=(2, field.mesh.n_faces)) + 1j * rng.normal(size=(2, field.mesh.n_faces))
    sums, w = ZeroSum(triples, weight), unit(w)

    def cost(w: np.ndarray) -> float:
        return 0.5 * float(areas @ np.abs(v - w) ** 2) + sums.energy(w)

    for _ in range(5):
        found = sums.nearest(v, w)
        np.testing.assert_allclose(np.abs(found), 1.0, atol=1e-12)
        assert cost(found) <= cost(w) + 1e-12
        w = found
    if weight == 0.0:
        np.testing.assert_allclose(w, unit(v), atol=1e-12)


def test_signs_are_those_of_the_triples() -> None:
    field, triples = three_sheets()
    turned = np.where(np.arange(field.mesh.n_faces) % 3 == 0, -1.0, 1.0)
    other = type(triples)(triples.mesh, triples.faces, triples.signs * turned[triples.faces], 2)
    v = np.random.default_rng(1).normal(size=(field.mesh.n_faces, 2)) @ [1.0, 1.0j]
    found = ZeroSum(triples).nearest(v, field.values)
    np.testing.assert_allclose(ZeroSum(other).nearest(turned * v, turned * field.values), turned * found)


def test_the_term_keeps_families_nearer_to_60_degrees_and_never_lets_the_energy_rise() -> None:
    torus = gw.shapes.torus(faces=600)
    quotient = gw.weave_field(torus).cover.quotient
    free = geodesic_field(quotient.field).field
    held = geodesic_field(quotient.field, triples=quotient.triples)
    off = [
        np.abs(opening(each, quotient.triples.faces, quotient.triples.signs) - 120.0).mean()
        for each in (free, held.field)
    ]
    assert off[1] < 0.5 * off[0]
    for smoothness in {step.smoothness for step in held.steps}:
        energies = [step.energy for step in held.steps if step.smoothness == smoothness]
        assert (np.diff(energies) <= 1e-9).all()


def test_the_weight_falls_with_lambda_and_a_single_lambda_has_the_last() -> None:
    weights = falling_weights(4)
    assert (np.diff(weights) < 0).all()
    assert falling_weights(1) == (weights[-1],)
    quotient = gw.weave_field(gw.shapes.torus(faces=600)).cover.quotient
    energies: dict[float, list[float]] = {}
    solve = geodesic_field(quotient.field, triples=quotient.triples, smoothness=(1e-2, 1e-3), iterations=3)
    for step in solve.steps:
        energies.setdefault(step.smoothness, []).append(step.energy)
    # The last field is measured with the last weight: its energy is that of Eq. 5 and the term together.
    rest = 0.5 * (solve.delta.mesh.face_areas @ np.abs(solve.delta.values) ** 2)
    term = ZeroSum(quotient.triples, falling_weights(2)[-1]).energy(solve.field.values)
    assert rest + term < energies[1e-3][-1]
    assert ZeroSum(quotient.triples, falling_weights(2)[0]).energy(solve.field.values) == pytest.approx(
        10.0 * term
    )


def test_refuses_handles_beside_triples() -> None:
    field, triples = three_sheets()
    handles = Handles(np.array([0]), np.array([1.0 + 0.0j]))
    with pytest.raises(FieldError, match="leave out the handles or the triples"):
        geodesic_field(field, handles=handles, triples=triples)


@pytest.mark.parametrize("weight", [0.1, 1.0])
def test_the_numbers_of_the_sheets_decide_nothing_and_one_step_finds_the_minimum(weight: float) -> None:
    field, triples = three_sheets()
    rng = np.random.default_rng(3)
    v = field.values + rng.normal(scale=0.1, size=(field.mesh.n_faces, 2)) @ [1.0, 1.0j]
    found = ZeroSum(triples, weight).nearest(v, field.values)
    for order in ([1, 2, 0], [2, 1, 0]):
        other = type(triples)(triples.mesh, triples.faces[:, order], triples.signs[:, order], triples.ribbons)
        np.testing.assert_allclose(ZeroSum(other, weight).nearest(v, field.values), found, atol=1e-13)
    # Each is along v_k - eta (w_l + w_m): none can be better beside the other two, and a second step stays.
    near, unit_ = triples.signs * v[triples.faces], triples.signs * found[triples.faces]
    best = near - weight * (unit_.sum(axis=1, keepdims=True) - unit_)
    np.testing.assert_allclose(best / np.abs(best), unit_, atol=1e-9)
    np.testing.assert_allclose(ZeroSum(triples, weight).nearest(v, found), found, atol=1e-9)
