"""The reduced system against the paper's KKT system: the same minimiser (Appendix B)."""

from __future__ import annotations

import numpy as np
import pytest
from surfaces import surface

from geoweave.comparisons.paper_systems import kkt_closed_field, kkt_system
from geoweave.fields.closed_projection import ClosedProjection, ordering_of
from geoweave.fields.face_field import FaceField, Handles, edge_curl, random_field
from geoweave.fields.operators import ClosedFields

# Genus 0, 1 and 5, with and without boundary, of one piece and of two.
MESHES = ["jagged sphere", "torus", "genus 5", "disk", "annulus", "Schwarz-P", "two pieces"]


def with_handles(mesh, count):
    if not count:
        return random_field(mesh, 0), None
    faces = np.linspace(0.1 * mesh.n_faces, 0.9 * mesh.n_faces, count).astype(int)
    handles = Handles.from_ambient(mesh, faces, np.random.default_rng(1).normal(size=(count, 3)))
    values = random_field(mesh, 0).values.copy()
    values[faces] = handles.values
    return FaceField(mesh, values), handles


@pytest.mark.parametrize("name", MESHES)
@pytest.mark.parametrize("count", [0, 4])
@pytest.mark.parametrize("smoothness", [1.0, 1e-3])
def test_reduced_and_kkt_agree(name, count, smoothness):
    mesh = surface(name)
    field, handles = with_handles(mesh, count)
    fields = ClosedFields(mesh)
    reduced, _ = ClosedProjection(fields, smoothness, ordering_of(fields), handles)(field.values)
    kkt = kkt_closed_field(field, smoothness, handles)
    np.testing.assert_allclose(kkt, reduced, atol=1e-8)
    assert np.abs(edge_curl(FaceField(mesh, kkt))).max() < 1e-9


def test_kkt_system_is_symmetric_and_of_the_size_the_paper_counts():
    mesh = surface("disk")
    matrix, right, free = kkt_system(random_field(mesh, 0), 0.1)
    assert abs(matrix - matrix.T).max() < 1e-12
    assert len(free) == 2 * mesh.n_faces
    assert len(right) == 2 * mesh.n_faces + len(mesh.interior_edges)
