import numpy as np
import pytest
from rodded import crumpled

from geoweave.rods.compiled_stencils import add_stencils, local_gradient
from geoweave.rods.elastic_energies import edgewise_bending, flatwise_bending, twisting


@pytest.mark.parametrize("make", [flatwise_bending, edgewise_bending, twisting])
def test_blocks_are_symmetric_and_a_translation_costs_nothing(make):
    rods = crumpled()
    term = make(rods.layout)
    blocks = term.curvature(rods, np.ones((len(rods.layout.joints), 1)))
    size = abs(blocks).max()
    assert size > 0
    np.testing.assert_allclose(blocks, blocks.transpose(0, 2, 1), atol=1e-12 * size)
    moved = blocks[:, :, :9].reshape(len(blocks), 11, 3, 3).sum(axis=2)
    np.testing.assert_allclose(moved, 0, atol=1e-12 * size)


@pytest.mark.parametrize("more", [False, True])
def test_stencils_are_summed_where_they_have_a_place(more):
    rng = np.random.default_rng(0)
    jacobian, extra = rng.normal(size=(5, 2, 3)), rng.normal(size=(5 if more else 0, 3, 3))
    extra = extra + extra.transpose(0, 2, 1)
    unknowns = np.array([[0, 1, 2], [1, 2, 3], [2, 3, 4], [4, 0, 2], [3, 1, 0]])
    slots = (5 * unknowns[:, :, None] + unknowns[:, None, :]).astype(np.int32)
    held = (unknowns == 3)[:, :, None] | (unknowns == 3)[:, None, :]
    slots[held] = -1
    data, dense = np.zeros(25), np.zeros((5, 5))
    add_stencils(data, slots, jacobian, extra)
    for i, own in enumerate(unknowns):
        dense[np.ix_(own, own)] += jacobian[i].T @ jacobian[i] + (extra[i] if more else 0)
    dense[3] = dense[:, 3] = 0
    np.testing.assert_allclose(data.reshape(5, 5), dense, atol=1e-12)


def test_a_gradient_is_the_sum_of_local_ones():
    rods = crumpled()
    term = twisting(rods.layout)
    jacobian, residual = term.derivative(rods), term.residual(rods)
    plain = term.jacobian(rods).T @ residual.ravel()
    found = local_gradient(term.unknowns, jacobian, residual, rods.size)
    np.testing.assert_allclose(found, plain, atol=1e-12 * abs(plain).max())
