"""Sentences of Sections 2, 4 and 6 and of Appendix C that small examples settle."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy import linalg

import geoweave as gw
from geoweave.curves.tracing import streamlines
from geoweave.fields import operators
from geoweave.fields.face_field import FaceField, random_field, total_curl
from geoweave.fields.geodesic import geodesic_field
from geoweave.foliation.integrability import perpendicular
from geoweave.foliation.level_sets import isolines
from geoweave.meshing.remesh import isotropic_remesh
from geoweave.models import datasets, shapes
from geoweave.surface.mesh import TriMesh

Matrix = NDArray[np.float64]


def windings(mesh: TriMesh, slope: float) -> FaceField:
    """A field on a torus about the z axis that winds round both ways."""
    x, y, _ = mesh.barycenters.T
    along = np.stack([-y, x, 0 * x], axis=1) / np.hypot(x, y)[:, None]
    return FaceField.from_ambient(mesh, along + slope * np.cross(along, mesh.face_normals)).normalized()


def test_isolines_reconnect_round_a_hole_where_streamlines_do_not() -> None:
    """Section 2: tracing "cannot ensure that streamlines reconnect properly after circulating around holes";
    "parameterization is global, and yields closed loops even around complex topological features"."""
    field = windings(shapes.torus(1.0, 0.4, faces=3000), 0.618)
    leaves = isolines(gw.foliate(field, scale=0.5))
    assert len(leaves) > 0
    assert leaves.closed.all()
    traced = streamlines(field, separation=0.3)
    assert len(traced) > 0
    assert not traced.closed.any()


def shaken(mesh: TriMesh) -> TriMesh:
    """The mesh with its vertices moved by about a tenth of its radius."""
    return TriMesh(
        mesh.vertices + 0.1 * np.random.default_rng(0).normal(size=mesh.vertices.shape), mesh.faces
    )


def least_residual(mesh: TriMesh) -> float:
    """Mean square of delta of the best of some solutions of Eq. 4, from the smoothest field and at random."""
    mesh = mesh.normalized()[0]
    starts = [gw.smoothest_field(mesh), *(random_field(mesh, seed) for seed in range(12))]
    found = [geodesic_field(start, smoothness=[0.0], iterations=1000) for start in starts]
    return min(float(mesh.face_areas @ each.delta.norms**2 / mesh.face_areas.sum()) for each in found)


def test_most_curved_meshes_have_no_field_that_is_unit_and_curl_free() -> None:
    """Section 4.1: "most non-flat triangle meshes admit no vector fields that are both curl-free and unit".

    Flat ones do, and so does the regular icosahedron, up to where the iteration ends; not if it is shaken.
    """
    flat, regular = shapes.disk(faces=80), shapes.icosahedron(faces=20)
    assert least_residual(flat) < 1e-6
    assert least_residual(regular) < 1e-6
    for curved in (shaken(regular), shapes.sphere(faces=80), shaken(shapes.sphere(faces=80))):
        assert least_residual(curved) > 2e-4


@pytest.mark.parametrize("name", ["bunny", "spot"])
def test_fields_are_resilient_to_the_tessellation(name: str) -> None:
    """Section 6: solutions are "invariant to the scale of T and resilient to its tessellation", without a
    guarantee. From 3,000 to 9,000 faces the total curl of either field stays within 15 % of its mean."""
    curls = []
    for faces in (3000, 4500, 9000):
        mesh = isotropic_remesh(datasets.load(name), faces).normalized()[0]
        start = gw.smoothest_field(mesh)
        curls.append([total_curl(start), total_curl(geodesic_field(start).field)])
    found = np.array(curls)
    assert np.abs(found / found.mean(axis=0) - 1).max() < 0.15
    assert (found[:, 1] < 0.5 * found[:, 0]).all()


def problem(field: FaceField, mu: float = 1e-4) -> tuple[Matrix, Matrix, Matrix]:
    """A1, A2 and an orthonormal basis of the nullspace of B of Appendix C, in the unknowns (delta, s)."""
    mesh = field.mesh
    mass, areas = (each.toarray() for each in (operators.field_mass(mesh), operators.face_mass(mesh)))
    first = linalg.block_diag(mass, mu * operators.face_laplacian(mesh).toarray())
    turned = perpendicular(field)
    columns = np.zeros((2 * mesh.n_faces, mesh.n_faces))
    columns[2 * np.arange(mesh.n_faces), np.arange(mesh.n_faces)] = turned.real
    columns[2 * np.arange(mesh.n_faces) + 1, np.arange(mesh.n_faces)] = turned.imag
    curl = operators.curl(mesh).toarray()
    kernel = linalg.null_space(np.hstack([curl, curl @ columns]))
    return first, linalg.block_diag(mass, areas), kernel


@cache
def small() -> FaceField:
    field, _ = gw.foliation.punctured(gw.smoothest_field(shapes.sphere(faces=80)))
    return field


def test_adding_the_second_matrix_shifts_the_spectrum_and_nothing_else() -> None:
    """Appendix C: A1 is semidefinite and A2 definite; adding A2 "shifts the spectrum of A1 without affecting
    its eigenvectors, while ensuring that A1 + A2 is invertible"."""
    first, second, kernel = problem(small())
    assert linalg.eigvalsh(first).min() > -1e-12
    assert abs(linalg.eigvalsh(first)).min() < 1e-12  # a constant s costs nothing
    assert linalg.eigvalsh(second).min() > 0
    one, two = (kernel.T @ each @ kernel for each in (first, second))
    values, vectors = linalg.eigh(one, two)
    shifted, others = linalg.eigh(one + two, two)
    np.testing.assert_allclose(shifted, values + 1, atol=1e-9)
    assert values[1] - values[0] > 1e-6
    assert abs(vectors[:, 0] @ two @ others[:, 0]) == pytest.approx(1.0)


def test_solved_together_all_components_but_one_get_nothing() -> None:
    """Appendix C: each component is solved apart, "as otherwise the solution will set s = 0 on all but one of
    the components"."""
    part = small().mesh
    # Another shape, so that the two do not share an eigenvalue.
    longer = part.vertices * [1.0, 1.0, 1.4] + [5.0, 0.0, 0.0]
    both = TriMesh(
        np.concatenate([part.vertices, longer]), np.concatenate([part.faces, part.faces + part.n_vertices])
    )
    upward = np.broadcast_to([0.3, 0.2, 1.0], (both.n_faces, 3))
    field = FaceField.from_ambient(both, upward).normalized()
    first, second, kernel = problem(field)
    _, vectors = linalg.eigh(kernel.T @ first @ kernel, kernel.T @ second @ kernel)
    s = np.abs((kernel @ vectors[:, 0])[2 * both.n_faces :])
    sizes = np.sort([s[both.face_components == k].max() for k in (0, 1)])
    assert sizes[0] < 1e-6 * sizes[1]
