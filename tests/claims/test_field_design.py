"""What Section 4.1 and Appendices A and B say of Eqs. 3 to 5 and Algorithm 1; the fields of scans: see
test_section_4_1. Bounding radius 1 throughout, and lambda = 0 where Eq. 4 is meant."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
from scipy import sparse
from scipy.sparse.linalg import eigsh, lsqr

from geoweave.comparisons.domains import ordered_domains
from geoweave.curves.tracing import streamlines
from geoweave.fields.closed_projection import ClosedProjection, ordering_of
from geoweave.fields.face_field import (
    FaceField,
    Handles,
    edge_curl,
    integrated_curl,
    random_field,
    total_curl,
)
from geoweave.fields.geodesic import GeodesicSolve, geodesic_field
from geoweave.fields.operators import ClosedFields, as_real, curl, dirichlet_energy
from geoweave.fields.rosy import smoothest_eigenfield, smoothest_field
from geoweave.fields.singularities import rotation_across, singular_vertices
from geoweave.models import catalogue, shapes
from geoweave.surface.mesh import TriMesh

# -- 4.1: why curl ----------------------------------------------------------------------------------------


@cache
def scan() -> TriMesh:
    return catalogue.load("spot")


def test_no_field_is_parallel_along_all_edges_of_a_curved_mesh():
    """Eq. 2 is "impossible since around any interior vertex with nonzero angle deficit, the Ts do not
    compose to the identity"."""
    mesh = scan()
    tail, head = mesh.edges[mesh.interior_edges].T
    defect = mesh.angle_defects
    least = np.abs(np.angle(np.exp(1j * defect)))
    assert (least > 1e-6).mean() > 0.99  # a scan is flat nowhere
    for seed in range(3):
        turn = rotation_across(random_field(mesh, seed))
        around = np.bincount(head, turn, mesh.n_vertices) - np.bincount(tail, turn, mesh.n_vertices)
        # Whatever the field, its turns round a vertex add up to minus the defect, up to full turns.
        np.testing.assert_allclose(np.exp(1j * around), np.exp(-1j * defect), atol=1e-10)


def test_the_curl_condition_with_unit_vectors_leaves_two_choices_on_a_neighbour():
    """Section 4.1: "a unit vector on one face eliminates all but two choices of unit vector on each
    neighbouring face"."""
    mesh = scan()
    i, j = mesh.edge_faces[mesh.interior_edges].T
    # Row ij of C is the condition. The vector on face i is given, that on face j turns once round.
    operator, w = curl(mesh), random_field(mesh, 0).values
    count = np.arange(len(i))
    on_i, on_j = (operator[count[:, None], 2 * face[:, None] + [0, 1]].toarray() for face in (i, j))
    there = (on_i * np.stack([w[i].real, w[i].imag], axis=1)).sum(axis=1)
    steps = np.linspace(0, 2 * np.pi, 721)
    misses = there[:, None] + on_j @ np.stack([np.cos(steps), np.sin(steps)])
    choices = (misses[:, :-1] * misses[:, 1:] < 0).sum(axis=1)
    # Where the edge takes nearly the whole vector, the two lie within one step of the scan.
    clear = np.abs(there) < 0.99 * mesh.edge_lengths[mesh.interior_edges]
    assert clear.mean() > 0.85
    np.testing.assert_array_equal(choices[clear], 2)


@pytest.mark.parametrize("name", ["spot", "schwarz-p", "rocker-arm-like"])
def test_unit_and_curl_free_has_more_conditions_than_unknowns(name):
    """Section 4.1: "the vector on each face is parameterized by an angle, but constrained across each
    edge"."""
    mesh = catalogue.load(name)
    w = random_field(mesh, 0)
    # How each condition changes with each angle: turning w_i by an angle adds i w_i times it.
    rows, faces = np.arange(2 * mesh.n_faces), np.repeat(np.arange(mesh.n_faces), 2)
    turned = sparse.csr_array((as_real(1j * w.values), (rows, faces)), shape=(2 * mesh.n_faces, mesh.n_faces))
    change = (curl(mesh) @ turned).tocsc()
    # Every angle is already fixed by the conditions, to first order: no combination leaves them unchanged...
    least = np.sqrt(eigsh((change.T @ change).tocsc(), k=1, sigma=0, return_eigenvectors=False)[0])
    assert least > 1e-6 * abs(change).max()
    # ... and half as many conditions again are left over, which no choice of angles meets.
    angles, conditions = mesh.n_faces, len(mesh.interior_edges)
    left = edge_curl(w) + change @ lsqr(change, -edge_curl(w), atol=1e-10, btol=1e-10)[0]
    assert conditions > 1.45 * angles
    assert np.linalg.norm(left) > 0.1 * np.linalg.norm(edge_curl(w))
    # And no start finds a field that meets them all: some delta is always left.
    for start in (smoothest_field(mesh), random_field(mesh, 0)):
        solve = geodesic_field(start, smoothness=[0.0], iterations=20)
        assert np.abs(edge_curl(solve.field)).max() > 1e-3


def test_the_radial_field_is_geodesic_but_not_of_least_dirichlet_energy():
    """4.1.4: "w(x, y) = (x, y) is geodesic on any neighbourhood of the punctured plane, but has non-vanishing
    Dirichlet energy"."""
    inner, curls, energies, missing = 0.4, [], [], []
    for faces in (1600, 6400):
        mesh = shapes.annulus(inner, 1.0, faces=faces)
        radial = FaceField.from_ambient(mesh, mesh.barycenters)
        # The gradient of |x|^2 / 2 has the identity as its Jacobian: energy twice the area.
        missing.append(1 - dirichlet_energy(mesh, radial.values) / (2 * mesh.face_areas.sum()))
        unit = radial.normalized()
        energies.append(dirichlet_energy(mesh, unit.values))
        curls.append(np.abs(edge_curl(unit)).max() / mesh.mean_edge)
        # Eq. 5 without smoothness leaves it; smoothness would rather have a constant field.
        solve = geodesic_field(unit, smoothness=[0.0])
        turned = np.degrees(np.abs(np.angle(solve.field.values * unit.values.conj())))
        assert turned.max() < 3
        assert dirichlet_energy(mesh, smoothest_field(mesh).values) < 1e-3 * energies[-1]
    # Its curl is an error of discretisation, its energy is not: the integral of 1 / r^2.
    assert curls[1] < 0.6 * curls[0]
    # Boundary edges carry no energy, which leaves out half a row of faces there.
    assert energies[1] == pytest.approx(2 * np.pi * np.log(1 / inner), rel=0.03)
    assert 0 < missing[1] < 0.6 * missing[0] < 0.03


def test_quadratic_energies_do_not_see_vorticity_at_singularities():
    """4.1.4: "near singularities, the vector field vanishes, and so does the energy density, regardless of
    the vorticity of the field"."""
    mesh = shapes.sphere(subdivisions=4)
    mu, field = smoothest_eigenfield(mesh)
    near = np.isin(mesh.faces, singular_vertices(field)).any(axis=1)
    assert field.norms[near].max() < 0.1 * np.median(field.norms)
    swirl = FaceField(mesh, 1j * field.values)
    assert dirichlet_energy(mesh, swirl.values) == pytest.approx(dirichlet_energy(mesh, field.values))
    assert dirichlet_energy(mesh, field.values) == pytest.approx(mu[0], rel=1e-6)


# -- 4.1.1: discrete geodesic fields ----------------------------------------------------------------------


@cache
def converged() -> GeodesicSolve:
    """Eq. 4 on an ellipsoid, to the last digit."""
    ball = shapes.sphere(faces=1280)
    mesh = TriMesh(ball.vertices * [1.0, 0.8, 0.6], ball.faces).normalized()[0]
    return geodesic_field(smoothest_field(mesh), smoothness=[0.0], iterations=5000, tolerance=1e-11)


def test_at_a_critical_point_field_and_residual_are_parallel():
    """4.1.1: "at critical points of Equation (4), the field and the residual must be everywhere parallel"."""
    solve = converged()
    assert solve.converged
    assert solve.delta.norms.max() > 1e-3  # there is a residual to speak of
    across = np.abs((solve.delta.values * solve.field.values.conj()).imag)
    # The last step moved w by 1e-11; the alternation converges slowly, so that w is less near than that.
    assert across.max() < 1e-6


def test_the_residual_is_orthogonal_to_all_curl_free_fields():
    """Appendix A, third fact: "for any curl-free vector field v, the integral of <v, delta> is 0"."""
    solve = converged()
    mesh = solve.field.mesh
    fields = ClosedFields(mesh)
    weighted = np.repeat(mesh.face_areas, 2) * solve.delta.values.view(np.float64)
    scale = np.abs(fields.basis_transposed) @ np.abs(weighted)
    assert (np.abs(fields.basis_transposed @ weighted) < 1e-9 * scale.max()).all()


@pytest.mark.parametrize("faces", [900, 3600])
def test_a_swirl_on_an_annulus_is_critical_but_not_geodesic(faces):
    """Appendix A says that critical points have delta = 0. They need not: its second fact, that s integrates
    to zero, does not follow from rescaling, which gives ``int s = -int s^2`` (DEVIATIONS.md, appendix-a).

    On an annulus the circles are a stationary point, with v = c / r times their tangent; every perturbation
    leads away from it, to a geodesic field.
    """
    inner = 0.4
    mesh = shapes.annulus(inner, 1.0, faces=faces)
    x, y, _ = mesh.barycenters.T
    swirl = FaceField.from_ambient(mesh, np.stack([-y, x, 0 * x], axis=1)).normalized()
    solve = geodesic_field(swirl, smoothness=[0.0], iterations=500, tolerance=1e-9)
    assert solve.converged
    assert np.abs(solve.field.values - swirl.values).max() < 1e-9
    s = (solve.delta.values * solve.field.values.conj()).real
    assert np.abs((solve.delta.values * solve.field.values.conj()).imag).max() < 1e-9
    # The smooth solution: s = c / r - 1 with c = (1 - inner) / ln(1 / inner).
    exact = (1 - inner) / np.log(1 / inner) / np.hypot(x, y) - 1
    assert np.sqrt(mesh.face_areas @ (s - exact) ** 2 / mesh.face_areas.sum()) < 0.12
    assert mesh.face_areas @ s == pytest.approx(-(mesh.face_areas @ s**2), rel=1e-6)
    assert mesh.face_areas @ s**2 > 0.05 * mesh.face_areas.sum()
    rng = np.random.default_rng(0)
    nudged = FaceField(mesh, swirl.values * np.exp(1e-3j * rng.normal(size=mesh.n_faces)))
    away = geodesic_field(nudged, smoothness=[0.0], iterations=500)
    assert away.energies[-1] < 0.05 * solve.energies[-1]


def test_the_residual_vanishes_under_refinement():
    """Appendix A: "in the smooth setting ... delta = 0": half the edge, about half the residual."""
    sizes = []
    for subdivisions in (2, 3, 4):
        mesh = shapes.sphere(subdivisions=subdivisions)
        axis = np.broadcast_to([0.3, 0.2, 1.0], (mesh.n_faces, 3))
        meridians = FaceField.from_ambient(mesh, axis).normalized()
        solve = geodesic_field(meridians, smoothness=[0.0])
        sizes.append(np.sqrt(mesh.face_areas @ solve.delta.norms**2 / mesh.face_areas.sum()))
    assert sizes[1] < 0.65 * sizes[0]
    assert sizes[2] < 0.65 * sizes[1]


def test_an_arbitrary_start_gives_a_glass():
    """4.1.1: "choosing w0 arbitrarily can yield geodesic fields that are glassy with an undesirably large
    number of singularities"."""
    mesh = scan()
    glass = geodesic_field(random_field(mesh, 0), smoothness=[0.0])
    smooth = geodesic_field(smoothest_field(mesh), phases=4)
    assert total_curl(glass.field) < 0.3 * total_curl(random_field(mesh, 0))
    assert len(singular_vertices(glass.field)) > 20 * len(singular_vertices(smooth.field))


# -- 4.1.2 and 4.1.4: smoothness and handles --------------------------------------------------------------


def test_large_lambda_penalises_singularities():
    """4.1.2: "as lambda grows large, Equation (5) prioritizes smoothness over straightness of the field, and
    penalizes singularities"."""
    mesh = scan()
    found = [
        geodesic_field(random_field(mesh, 0), smoothness=[ratio * mesh.mean_edge**2])
        for ratio in (0.0, 0.05, 1.0, 100.0)
    ]
    counts = [len(singular_vertices(solve.field)) for solve in found]
    assert counts == sorted(counts, reverse=True)
    assert counts[0] > 20 * counts[-1]
    energies = [dirichlet_energy(mesh, (solve.field + solve.delta).values) for solve in found]
    assert energies == sorted(energies, reverse=True)
    residuals = [float(mesh.face_areas @ solve.delta.norms**2) for solve in found]
    assert residuals[-1] == max(residuals)  # smoothness has its price


def opposite_handles(mesh: TriMesh) -> Handles:
    """Two round patches side by side, one pointing down, the other up (Fig. 10)."""
    x, y, _ = mesh.barycenters.T
    left, right = (np.flatnonzero(np.hypot(x - at, y) < 0.1) for at in (-0.5, 0.5))
    vectors = np.repeat([[0.0, -1.0, 0.0], [0.0, 1.0, 0.0]], [len(left), len(right)], axis=0)
    return Handles.from_ambient(mesh, [*left, *right], vectors)


def test_at_large_lambda_the_problem_is_convex():
    """4.1.4: "in the limit, Equation 5 converges to the convex problem of computing the smoothest-possible
    curl-free field": the start does not matter, and the field is far from unit."""
    mesh = shapes.disk(faces=2000)
    found = []
    for seed in range(3):
        solve = geodesic_field(random_field(mesh, seed), smoothness=[1e6], handles=opposite_handles(mesh))
        found.append((solve.field + solve.delta).values)
    assert np.abs(np.diff(found, axis=0)).max() < 1e-5
    assert np.median(np.abs(found[0])) < 0.7


def test_sharpening_gathers_curl_and_residual_on_walls():
    """4.1.4: "the field becomes geodesic away from sharp domain wall boundaries and delta becomes sparse"."""
    mesh = shapes.disk(faces=4000)
    handles = opposite_handles(mesh)
    levels = np.geomspace(1e3, 0.08 * mesh.mean_edge**2, 12)
    solve = geodesic_field(random_field(mesh, 0), smoothness=levels, handles=handles)
    walls = mesh.interior_edges[ordered_domains(solve.field).walls]
    near = np.isin(mesh.faces, np.unique(mesh.edges[walls])).any(axis=1)
    # The walls are a few edges wide: a fifth of this mesh, less on a finer one.
    assert mesh.face_areas[near].sum() < 0.25 * mesh.face_areas.sum()
    weight = mesh.face_areas * solve.delta.norms**2
    assert weight[near].sum() > 0.85 * weight.sum()
    curl = np.abs(integrated_curl(solve.field))
    assert curl[near].sum() > 0.7 * curl.sum()
    assert np.median(solve.delta.norms[~near]) < 0.03
    np.testing.assert_array_equal(solve.field.values[handles.faces], handles.values)


def test_straight_lines_on_the_disk_and_great_circles_on_the_sphere():
    """4.1.2: "on simple shapes, such as the sphere or disk, our method reproduces fields whose streamlines
    are the expected straight lines and great circles"."""
    disk = shapes.disk(faces=2000)
    field = geodesic_field(random_field(disk, 0)).field
    for line in streamlines(field, share=0.15):
        chord = line.points[-1] - line.points[0]
        length = np.linalg.norm(np.diff(line.points, axis=0), axis=1).sum()
        assert np.linalg.norm(chord) > 0.999 * length
    ball = shapes.sphere(subdivisions=4)
    field = geodesic_field(smoothest_field(ball), phases=4).field
    tilt, lengths = [], []
    for line in streamlines(field, share=0.15):
        # The plane through the centre that fits best: for a great circle nothing is left over.
        left_over = np.linalg.svd(line.points, compute_uv=False)[-1] / np.sqrt(len(line.points))
        tilt.append(left_over)
        lengths.append(len(line.points))
    # In units of the radius: on average a line stays within a hundredth of a great circle.
    assert np.average(tilt, weights=lengths) < 0.01


# -- 4.1.3 and Appendix B: Algorithm 1 --------------------------------------------------------------------


def test_each_half_step_lowers_the_objective_and_keeps_the_constraints():
    """4.1.3: "each step of the alternation is guaranteed to decrease the objective function while maintaining
    all constraints"; B: "u + delta-tilde = u' + delta', while the norm of delta' has decreased"."""
    mesh = scan()
    weight = 1e-3
    fields = ClosedFields(mesh)
    project = ClosedProjection(fields, weight, ordering_of(fields))
    w = random_field(mesh, 0).values
    v, _ = project(w)

    def objective() -> float:
        distance = mesh.face_areas @ np.abs(v - w) ** 2
        return float(0.5 * distance + 0.5 * weight * dirichlet_energy(mesh, v))

    previous = objective()
    for _ in range(10):
        before = np.abs(v - w)
        w = project.unit(v)
        np.testing.assert_allclose(np.abs(w), 1, atol=1e-14)
        assert (np.abs(v - w) <= before + 1e-14).all()  # the best w for this v, face by face
        middle = objective()
        v, _ = project(w)
        assert np.abs(edge_curl(FaceField(mesh, v))).max() < 1e-12
        assert objective() < middle < previous
        previous = objective()
