"""Turns from face to face are what they are said to be, and whole turns are spread evenly."""

from __future__ import annotations

import numpy as np
import pytest
from surfaces import surface

from geoweave.errors import FieldError
from geoweave.fields.connected_rosy import ConnectedRoSy, DualPotential, rewound, smallest_turns
from geoweave.fields.operators import face_laplacian
from geoweave.fields.rosy import smoothest_rosy


def test_a_potential_explains_differences_and_leaves_what_is_none():
    mesh = surface("torus")
    i, j = mesh.edge_faces[mesh.interior_edges].T
    rng = np.random.default_rng(0)
    function = rng.normal(size=mesh.n_faces)
    potential = DualPotential(mesh)
    steps = function[j] - function[i]
    assert np.abs(potential.rest(steps)).max() < 1e-9
    found = potential.of(steps)
    assert np.allclose(found - found[0], function - function[0])
    noise = potential.rest(rng.normal(size=len(i)))
    weighted = potential.weights * noise
    assert (
        np.abs(np.bincount(j, weighted, mesh.n_faces) - np.bincount(i, weighted, mesh.n_faces)).max() < 1e-8
    )
    assert np.allclose(face_laplacian(mesh) @ np.ones(mesh.n_faces), 0)


def test_whole_turns_that_cancel_change_nothing():
    mesh = surface("torus")
    rosy = smoothest_rosy(mesh, 6)
    same = rewound(rosy, np.zeros(len(mesh.interior_edges), dtype=int))
    assert np.allclose(same.values, rosy.values)
    assert (same.matching == rosy.matching).all()


def test_turns_that_do_not_fit_are_refused():
    rosy = smoothest_rosy(surface("torus"), 6)
    turns = smallest_turns(rosy)
    with pytest.raises(FieldError, match="edge 5 does not lead"):
        ConnectedRoSy(rosy.mesh, 6, rosy.values, turns + 0.1 * (np.arange(len(turns)) == 5))
    with pytest.raises(FieldError, match="one turn per interior edge"):
        ConnectedRoSy(rosy.mesh, 6, rosy.values, turns[1:])
