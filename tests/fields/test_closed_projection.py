"""The delta step of Algorithm 1: it minimises, and the energy falls when the alternation is written out."""

from __future__ import annotations

import numpy as np
import pytest
from surfaces import surface

from geoweave.fields.closed_projection import ClosedProjection, ordering_of
from geoweave.fields.face_field import random_field
from geoweave.fields.operators import ClosedFields, dirichlet_energy


def eq5_energy(mesh, w, v, smoothness):
    return 0.5 * mesh.face_areas @ np.abs(v - w) ** 2 + 0.5 * smoothness * dirichlet_energy(mesh, v)


@pytest.mark.parametrize("name", ["jagged sphere", "genus 5", "Schwarz-P"])
def test_the_energy_falls_when_the_alternation_is_written_out(name):
    """Appendix B: both half steps lower Eq. 9, computed here from its definition after each."""
    mesh = surface(name)
    fields = ClosedFields(mesh)
    project = ClosedProjection(fields, 1e-3, ordering_of(fields))
    w = random_field(mesh, 0).values
    v, _ = project(w)
    energy = eq5_energy(mesh, w, v, 1e-3)
    for _ in range(15):
        w = v / np.abs(v)
        middle = eq5_energy(mesh, w, v, 1e-3)
        v, reported = project(w)
        after = eq5_energy(mesh, w, v, 1e-3)
        assert energy > middle > after
        assert reported == pytest.approx(after, rel=1e-9)
        energy = after


@pytest.mark.parametrize("name", ["jagged sphere", "genus 5", "Schwarz-P"])
def test_the_projection_minimises(name):
    mesh = surface(name)
    fields = ClosedFields(mesh)
    w = random_field(mesh, 1).values
    project = ClosedProjection(fields, 0.01, ordering_of(fields))
    v, energy = project(w)
    assert energy == pytest.approx(eq5_energy(mesh, w, v, 0.01), rel=1e-10)
    rng = np.random.default_rng(0)
    for _ in range(5):
        other = fields.basis @ rng.normal(size=fields.basis.shape[1])
        nudge = 1e-3 * other.view(complex) / np.abs(other).max()
        up = eq5_energy(mesh, w, v + nudge, 0.01) - energy
        down = eq5_energy(mesh, w, v - nudge, 0.01) - energy
        assert up > 0
        assert up == pytest.approx(down, rel=1e-4)
