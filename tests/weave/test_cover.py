"""Covers: what topology says of them, their symmetries, and what lies on them seen from below."""

from __future__ import annotations

import time

import numpy as np
import pytest
from surfaces import ALL, surface

from geoweave.arrays import Complexes, Scalars
from geoweave.curves.curves import geodesic_curvature
from geoweave.curves.tracing import streamlines
from geoweave.errors import FieldError, MeshError
from geoweave.fields.face_field import FaceField, total_curl
from geoweave.fields.geodesic import INTEGRABLE_END, geodesic_field, sharpening_schedule
from geoweave.fields.operators import as_complex
from geoweave.fields.rosy import RoSyField, smoothest_rosy
from geoweave.fields.singularities import rotation_across, vertex_indices
from geoweave.foliation.circle_function import wrapped
from geoweave.foliation.foliation import foliate, global_scale
from geoweave.foliation.integrability import integrating_factor
from geoweave.foliation.level_sets import isolines
from geoweave.foliation.theta_and_s import Alternation
from geoweave.models import shapes
from geoweave.sparse.factorization import LARGE
from geoweave.surface.twisted_mesh import TwistedMesh
from geoweave.weave.cover import Cover, Quotient, branched_cover


def cover_of(name: str, degree: int = 6) -> Cover:
    return branched_cover(smoothest_rosy(surface(name), degree))


@pytest.mark.parametrize("degree", [1, 2, 3, 4, 5, 6])
@pytest.mark.parametrize("name", ALL)
def test_riemann_and_hurwitz(name: str, degree: int) -> None:
    """chi(C) = N chi of the punctured surface; each puncture is covered by the cycles of its shift."""
    cover = cover_of(name, degree)
    assert cover.mesh.euler_characteristic == degree * cover.part.mesh.euler_characteristic
    assert cover.mesh.n_faces == degree * cover.part.mesh.n_faces
    assert cover.mesh.n_edges == degree * cover.part.mesh.n_edges


@pytest.mark.parametrize("name", ALL)
def test_faces_lie_on_the_faces_below(name: str) -> None:
    cover = cover_of(name)
    below = cover.rosy.mesh
    np.testing.assert_array_equal(cover.vertices[cover.mesh.faces], below.faces[cover.faces])
    np.testing.assert_array_equal(cover.mesh.vertices, below.vertices[cover.vertices])
    np.testing.assert_array_equal(cover.mesh.frames, below.frames[cover.faces])
    ambient = below.frames[cover.faces]
    vector = cover.field.values
    np.testing.assert_array_equal(
        cover.field.ambient, vector.real[:, None] * ambient[:, 0] + vector.imag[:, None] * ambient[:, 1]
    )
    np.testing.assert_allclose(vector**6, cover.rosy.values[cover.faces], atol=1e-12)


@pytest.mark.parametrize("name", ALL)
def test_away_from_its_rim_the_cover_looks_like_the_surface(name: str) -> None:
    """Every interior vertex above has the same faces round it, in number and in angle, as the one below."""
    cover = cover_of(name)
    inside = ~cover.mesh.boundary_vertices
    np.testing.assert_allclose(
        cover.mesh.angle_defects[inside], cover.rosy.mesh.angle_defects[cover.vertices[inside]], atol=1e-12
    )
    assert not np.intersect1d(cover.vertices[inside], cover.rosy.branch_points).size


@pytest.mark.parametrize("degree", [3, 6])
@pytest.mark.parametrize("name", ["jagged sphere", "genus 5", "two pieces"])
def test_glued_vectors_are_matched_vectors(name: str, degree: int) -> None:
    """Across every edge of the cover the field turns by at most half the angle between two vectors."""
    field = cover_of(name, degree).field
    assert np.abs(rotation_across(field)).max() <= np.pi / degree + 1e-9


@pytest.mark.parametrize("name", ALL)
def test_antipodes(name: str) -> None:
    """An involution without fixed points that keeps orientation and what lies below; the field is odd."""
    cover = cover_of(name)
    faces, vertices = cover.antipodes
    for permutation in (faces, vertices):
        everyone = np.arange(len(permutation))
        assert (permutation != everyone).all()
        np.testing.assert_array_equal(permutation[permutation], everyone)
    np.testing.assert_array_equal(cover.mesh.faces[faces], vertices[cover.mesh.faces])
    np.testing.assert_array_equal(cover.faces[faces], cover.faces)
    np.testing.assert_array_equal(cover.vertices[vertices], cover.vertices)
    np.testing.assert_allclose(cover.field.values[faces], -cover.field.values, atol=1e-15)


def test_the_turn_by_one_sheet_has_order_n() -> None:
    cover = cover_of("jagged sphere", 5)
    faces, vertices = cover.turned()
    np.testing.assert_array_equal(cover.mesh.faces[faces], vertices[cover.mesh.faces])
    np.testing.assert_allclose(
        cover.field.values[faces], cover.field.values * np.exp(2j * np.pi / 5), atol=1e-12
    )
    image = np.arange(cover.mesh.n_faces)
    for _ in range(5):
        image = faces[image]
    np.testing.assert_array_equal(image, np.arange(cover.mesh.n_faces))


def test_combed_sheets_are_components_where_nothing_branches() -> None:
    cover = cover_of("disk")
    for component in range(6):
        assert len(np.unique(cover.combed[cover.mesh.face_components == component])) == 1


@pytest.mark.parametrize(("name", "degree"), [("icosahedron", 6), ("jagged sphere", 5), ("torus", 4)])
def test_combed_sheets_change_across_cuts_only(name: str, degree: int) -> None:
    """Copies of a face get different numbers, copies of an edge jump alike, and cuts reach every puncture."""
    cover = (
        branched_cover(smoothest_rosy(shapes.icosahedron(2000), 6))
        if name == "icosahedron"
        else cover_of(name, degree)
    )
    count = len(cover.part.faces)
    np.testing.assert_array_equal(
        np.sort(cover.combed.reshape(degree, count), axis=0),
        np.repeat(np.arange(degree), count).reshape(degree, count),
    )
    i, j = cover.mesh.edge_faces[cover.mesh.interior_edges].T
    jump = (cover.combed[j] - cover.combed[i]) % degree
    # the turn by one sheet commutes with gluing, so all copies of an edge jump alike
    edge = np.sort(np.stack([i % count, j % count]), axis=0)
    keys, inverse = np.unique(edge, axis=1, return_inverse=True)
    forward = np.where(i % count < j % count, jump, -jump % degree)
    first = np.zeros(keys.shape[1], dtype=np.int64)
    first[inverse.ravel()] = forward
    np.testing.assert_array_equal(first[inverse.ravel()], forward)
    # a matching counts from arbitrary frames and jumps nearly everywhere; cuts are curves on the surface
    assert np.mean(jump != 0) < (0.15 if name == "icosahedron" else 0.5)
    if name == "icosahedron":
        # a cut leaves every puncture
        below = cover.part.mesh
        torn = np.zeros(below.n_vertices, dtype=bool)
        cuts = keys[:, first != 0]
        for a, b in cuts.T:
            torn[np.intersect1d(below.faces[a], below.faces[b])] = True
        assert all(torn[loop].any() for loop in below.boundary_loops)


def test_an_odd_cover_has_no_antipodes() -> None:
    with pytest.raises(FieldError, match="5 sheets has no antipodes"):
        _ = cover_of("disk", 5).antipodes


def test_without_branch_points_the_sheets_fall_apart() -> None:
    cover = cover_of("disk")
    assert cover.mesh.n_components == 6
    for component in range(6):
        # numbers of sheets are a matter of frames, so one component may take a face from each
        mine = cover.faces[cover.mesh.face_components == component]
        np.testing.assert_array_equal(np.sort(mine), np.arange(surface("disk").n_faces))


def test_components_below_stay_apart_above() -> None:
    cover = cover_of("two pieces")
    below = cover.rosy.mesh.face_components[cover.faces]
    above = cover.mesh.face_components
    assert all(len(np.unique(below[above == c])) == 1 for c in range(cover.mesh.n_components))
    # six copies of the flat disk, and at least one component above the torus
    assert cover.mesh.n_components >= 7


def test_the_icosahedron_of_figure_17() -> None:
    """Twelve branch points of index 1/6, each under one loop; the lifted field is curl-free to rounding."""
    cover = branched_cover(smoothest_rosy(shapes.icosahedron(720), 6))
    assert len(cover.rosy.branch_points) == 12
    assert len(cover.mesh.boundary_loops) == 12
    assert len(cover.part.mesh.boundary_loops) == 12
    # a loop above goes six times round its branch point
    below = len(cover.part.mesh.boundary_loops[0])
    assert all(len(loop) == 6 * below for loop in cover.mesh.boundary_loops)
    assert total_curl(cover.field) < 1e-11


def test_lines_on_the_cover_are_lines_on_the_surface() -> None:
    cover = cover_of("torus")
    above = streamlines(cover.field, separation=0.3)
    below = cover.project(above)
    assert below.mesh is cover.rosy.mesh
    np.testing.assert_array_equal(below.points, above.points)
    np.testing.assert_array_equal(below.normals, above.normals)
    np.testing.assert_array_equal(geodesic_curvature(below, 0.1), geodesic_curvature(above, 0.1))
    with pytest.raises(FieldError, match="on the mesh of the cover"):
        cover.project(below)


def test_a_surface_of_branch_points_only_is_refused() -> None:
    with pytest.raises(MeshError, match="none of the 20 faces"):
        branched_cover(smoothest_rosy(shapes.icosahedron(), 6))


def test_a_rough_rosy_has_a_cover_too() -> None:
    """Hundreds of branch points side by side: punctures merge, the rest is still a surface."""
    mesh = surface("jagged sphere")
    angle = np.random.default_rng(0).uniform(0.0, 2.0, mesh.n_faces)
    rosy = RoSyField(mesh, 6, np.exp(1j * angle))
    cover = branched_cover(rosy)
    assert len(rosy.branch_points) > 50
    assert cover.mesh.euler_characteristic == 6 * cover.part.mesh.euler_characteristic


def test_a_cover_of_thirty_thousand_faces_is_quick() -> None:
    """Against the field on the same mesh, in the same run, so that a busy processor slows both."""
    mesh = shapes.sphere(faces=30_000)
    begin = time.process_time()
    rosy = smoothest_rosy(mesh, 6)
    between = time.process_time()
    branched_cover(rosy)
    # measured 0.65 times; a loop over faces in Python would take far more
    assert time.process_time() - between < 2.0 * (between - begin)


def designed(field: FaceField) -> FaceField:
    schedule = sharpening_schedule(field.mesh, finest=INTEGRABLE_END)
    return geodesic_field(field, smoothness=schedule, iterations=8).field


@pytest.mark.parametrize("degree", [2, 4, 6])
@pytest.mark.parametrize("name", ALL)
def test_the_quotient_has_half_of_everything(name: str, degree: int) -> None:
    cover = cover_of(name, degree)
    quotient, (antipode, _) = cover.quotient, cover.antipodes
    assert 2 * quotient.mesh.n_faces == cover.mesh.n_faces
    assert 2 * quotient.mesh.n_vertices == cover.mesh.n_vertices
    assert 2 * quotient.mesh.euler_characteristic == cover.mesh.euler_characteristic
    np.testing.assert_array_equal(quotient.faces[antipode], quotient.faces)
    np.testing.assert_array_equal(quotient.signs[antipode], -quotient.signs)
    np.testing.assert_array_equal(quotient.mesh.frames[quotient.faces], cover.mesh.frames)
    # a component that is its own antipode is twisted below; two that are each other's are one plain one
    above = cover.mesh.face_components
    own = np.unique(above[above == above[antipode]])
    assert quotient.mesh.bundle.twisted_components.sum() == len(own)
    assert 2 * quotient.mesh.n_components == cover.mesh.n_components + len(own)
    assert isinstance(quotient.mesh, TwistedMesh) == bool(len(own))


def test_flat_surfaces_have_a_plain_quotient() -> None:
    quotient = cover_of("disk").quotient
    assert quotient.mesh.n_components == 3
    assert not isinstance(quotient.mesh, TwistedMesh)


def test_the_quotient_of_an_odd_cover_is_the_cover() -> None:
    cover = cover_of("jagged sphere", 5)
    assert cover.quotient.mesh is cover.mesh
    np.testing.assert_array_equal(cover.quotient.field.values, cover.field.values)


@pytest.mark.parametrize("name", ["jagged sphere", "torus", "Schwarz-P", "two pieces"])
def test_the_field_solved_on_the_quotient_is_that_of_all_sheets(name: str) -> None:
    """Algorithm 1 keeps odd fields odd, so half of the sheets know all."""
    cover = cover_of(name)
    quotient = cover.quotient
    np.testing.assert_allclose(lifted(quotient, quotient.field), cover.field.values, rtol=0, atol=1e-14)
    below, above = designed(quotient.field), designed(cover.field)
    # rounding only, amplified by the steps
    np.testing.assert_allclose(lifted(quotient, below), above.values, atol=1e-7)
    assert 2 * total_curl(below) == pytest.approx(total_curl(above), rel=1e-9)
    np.testing.assert_array_equal(
        np.bincount(np.abs(vertex_indices(below)), minlength=3) * 2,
        np.bincount(np.abs(vertex_indices(above)), minlength=3),
    )


@pytest.mark.parametrize("degree", [4, 6])
@pytest.mark.parametrize("name", ["jagged sphere", "torus", "two pieces"])
def test_the_factor_solved_on_the_quotient_is_that_of_all_sheets(name: str, degree: int) -> None:
    """Without a puncture more; s is even."""
    quotient = cover_of(name, degree).quotient
    # the bounding radius sets the unit of mu, and the vertex means of the two differ
    mu = 2e-4 / quotient.mesh.bounding_radius**2, 2e-4 / quotient.cover.mesh.bounding_radius**2
    below = integrating_factor(quotient.field, smoothness=mu[0])
    above = integrating_factor(quotient.cover.field, smoothness=mu[1])
    np.testing.assert_allclose(below.s[quotient.faces], above.s, rtol=1e-6)


def lifted(quotient: Quotient, field: FaceField) -> np.ndarray:
    """A field of the quotient on the cover: opposite vectors on antipodal faces."""
    return quotient.signs * field.values[quotient.faces]


def eq8(quotient: Quotient) -> tuple[Alternation, Alternation, Scalars, Scalars]:
    """Eq. 8 on the quotient and on all sheets, with a first s on either."""
    s = integrating_factor(quotient.field).s
    s = 0.3 * global_scale(quotient.field, s, 0.95) * s
    below = Alternation(quotient.field, s, s, 1e-4)
    lifted = s[quotient.faces]
    return below, Alternation(quotient.cover.field, lifted, lifted, 1e-4), s, lifted


def lifted_to_vertices(quotient: Quotient, values: Scalars | Complexes) -> Scalars | Complexes:
    """Angles at vertices, or unit complex numbers, taken from the quotient to the cover."""
    seen, sign = values[quotient.mesh.faces], quotient.mesh.bundle.corners
    out = np.empty(quotient.cover.mesh.n_vertices, dtype=values.dtype)
    sign = (quotient.signs[:, None] * sign[quotient.faces]) > 0
    seen = seen[quotient.faces]
    opposite = seen.conj() if np.iscomplexobj(seen) else -seen
    out[quotient.cover.mesh.faces] = np.where(sign, seen, opposite)
    return out


@pytest.mark.parametrize("degree", [2, 4, 6])
def test_theta_on_the_quotient_is_that_of_all_sheets(degree: int) -> None:
    """Conjugation at antipodes commutes with the matrix of the theta step: real below, it has the same
    spectrum, and its smallest eigenvector is the one above, up to the constant that theta leaves free."""
    mesh = shapes.sphere(faces=320)
    quotient = branched_cover(smoothest_rosy(mesh, degree)).quotient
    assert isinstance(quotient.mesh, TwistedMesh)
    assert quotient.cover.mesh.n_components == 1
    below, above, s, lifted = eq8(quotient)
    small, large = below.systems.turned(s), above.systems.turned(lifted)
    assert np.iscomplexobj(large)
    assert not np.iscomplexobj(small)
    # each in the metric of its mass, as in the inverse iteration
    root, lifted_root = 1 / np.sqrt(np.repeat(below.systems.mass, 2)), 1 / np.sqrt(above.systems.mass)
    values, vectors = np.linalg.eigh(root[:, None] * small.toarray() * root)
    others, of_others = np.linalg.eigh(lifted_root[:, None] * large.toarray() * lifted_root)
    np.testing.assert_allclose(values, others, rtol=1e-8, atol=1e-8 * values[-1])
    assert values[1] > 1.001 * values[0]
    z, expected = as_complex(root * vectors[:, 0]), lifted_root * of_others[:, 0]
    gap = np.exp(1j * np.angle(lifted_to_vertices(quotient, z) * expected.conj()))
    np.testing.assert_allclose(gap, gap[0], atol=1e-5)


@pytest.mark.parametrize("name", ["jagged sphere", "genus 5", "two pieces"])
def test_steps_of_theta_and_s_on_the_quotient_are_those_of_all_sheets(name: str) -> None:
    """Eq. 8 has half the energy, and each of its steps takes an odd theta and an even s to such again."""
    quotient = cover_of(name).quotient
    below, above, s, lifted_s = eq8(quotient)
    _, theta = below.eigenvector(below.start(0), None, s)
    lifted = lifted_to_vertices(quotient, theta)
    assert 2 * below.energy(theta, s) == pytest.approx(above.energy(lifted, lifted_s), rel=1e-12)
    # From 12,000 unknowns on factors are single, and steps are solved to a share of what they change.
    near = 1e-6 if len(lifted) + len(lifted_s) < LARGE else 1e-3
    # what the small shift of the matrix leaves: a constant on a component that is not twisted
    for _ in range(2):
        theta, s = below.improve_both(theta, s)
        s = below.improve_s(theta, s)
        lifted, lifted_s = above.improve_both(lifted, lifted_s)
        lifted_s = above.improve_s(lifted, lifted_s)
        np.testing.assert_allclose(lifted_s, s[quotient.faces], rtol=near)
        np.testing.assert_allclose(
            np.exp(1j * lifted), np.exp(1j * lifted_to_vertices(quotient, theta)), atol=near
        )
    np.testing.assert_allclose(
        np.exp(1j * above.improve_theta(lifted, lifted_s)),
        np.exp(1j * lifted_to_vertices(quotient, below.improve_theta(theta, s))),
        atol=near,
    )


@pytest.mark.parametrize("degree", [4, 6])
@pytest.mark.parametrize("name", ["jagged sphere", "genus 5", "Schwarz-P", "two pieces"])
def test_antipodal_families_interleave_by_half_a_period(name: str, degree: int) -> None:
    """theta is odd exactly: at level pi/2 the leaves of one sheet halve the gaps of its antipode's."""
    cover = cover_of(name, degree)
    lifted = cover.quotient.lifted(foliate(designed(cover.quotient.field), alternations=2))
    faces, vertices = cover.antipodes
    part = lifted.part
    np.testing.assert_array_equal(part.kept[faces], part.kept)
    place = np.full(cover.mesh.n_faces, -1)
    place[part.faces] = np.arange(len(part.faces))
    across = place[faces[part.faces]]
    seen = lifted.circle.theta[part.mesh.faces]
    np.testing.assert_array_equal(seen[across], -seen)
    np.testing.assert_array_equal(lifted.circle.corner_jumps[across], -lifted.circle.corner_jumps)
    np.testing.assert_array_equal(lifted.s[across], lifted.s)
    assert set(vertices[part.vertices]) == set(part.vertices)
    # a point of a leaf, seen on the antipodal sheet, is half a turn away from the leaves there
    lines = isolines(lifted.circle)
    corner, point = part.mesh.vertices[part.mesh.faces[lines.faces]], lines.points
    basis = np.stack([corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0]], axis=2)
    share = np.linalg.pinv(basis) @ (point - corner[:, 0])[:, :, None]
    jumps = lifted.circle.corner_jumps[across[lines.faces]]
    regular = ~lifted.circle.dislocated[lines.faces]
    opposite = seen[across[lines.faces], 0] + share[:, 0, 0] * jumps[:, 2] - share[:, 1, 0] * jumps[:, 1]
    assert np.abs(wrapped(opposite - 1.5 * np.pi))[regular].max() < 1e-9


def test_a_lifted_foliation_is_a_foliation() -> None:
    cover = cover_of("jagged sphere")
    found = foliate(designed(cover.quotient.field), alternations=3)
    lifted = cover.quotient.lifted(found)
    below, above = found.alignment, lifted.alignment
    assert above.dislocations == 2 * below.dislocations
    assert above.median == pytest.approx(below.median, rel=1e-9)
    lines = cover.project(isolines(lifted))
    assert lines.mesh is cover.rosy.mesh
    assert len(lines) > 20


def test_what_lies_elsewhere_is_not_lifted() -> None:
    cover = cover_of("disk")
    with pytest.raises(FieldError, match="one of the quotient"):
        cover.quotient.lifted(foliate(cover.field, alternations=1))
