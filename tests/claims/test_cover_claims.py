"""What Section 5.1, Figs. 16, 17 and 21 and Appendix D say of RoSys and covers, on models of the figures."""

from __future__ import annotations

import numpy as np
import pytest

from geoweave.curves.curve_crossings import crossings
from geoweave.fields.face_field import total_curl
from geoweave.fields.geodesic import INTEGRABLE_END, geodesic_field, sharpening_schedule
from geoweave.fields.operators import connection_laplacian
from geoweave.fields.rosy import smoothest_eigenfield, smoothest_rosy
from geoweave.fields.singularities import rotation_across
from geoweave.foliation.foliation import foliate
from geoweave.foliation.level_sets import isolines
from geoweave.models import catalogue, shapes
from geoweave.weave.cover import Cover, branched_cover

SHIPPED = ("bunny", "spot", "torus", "camel", "schwarz-p")


def cover_of(name: str) -> Cover:
    return branched_cover(smoothest_rosy(catalogue.load(name), 6))


@pytest.mark.parametrize(("degree", "count"), [(4, 8), (5, 10), (6, 12)])
def test_sphere_of_figure_21_has_the_fewest_singularities(degree, count):
    """Fig. 21: RoSys of degree 4, 5 and 6 on a sphere; each singularity has index 1 / k and they sum to 2."""
    sphere = catalogue.load("sphere")
    for seed in range(3):
        rosy = smoothest_rosy(sphere, degree, seed)
        assert len(rosy.branch_points) == count
        assert rosy.index_numerators.sum() == 2 * degree


@pytest.mark.parametrize("faces", [320, 2_880])
def test_icosahedron_branches_at_its_corners_and_starts_without_curl(faces):
    """Fig. 19: the weave of the icosahedron has its 12 dislocations at the vertices; its RoSy is parallel."""
    mesh = shapes.icosahedron(faces).normalized()[0]
    rosy = smoothest_rosy(mesh, 6)
    corners = np.flatnonzero(mesh.angle_defects > 1.0)
    np.testing.assert_array_equal(rosy.branch_points, corners)
    assert len(corners) == 12
    # 6 sheets and some 40,000 edges at rounding each; the prototype had 5e-13
    assert total_curl(branched_cover(rosy).field) < 1e-11


def test_circulating_a_singularity_permutes_the_families():
    """Fig. 16: once round moves each family to the next, (A, B, C, -A, -B, -C); six times round is once."""
    cover = branched_cover(smoothest_rosy(shapes.icosahedron(720), 6))
    mesh = cover.mesh
    assert len(mesh.boundary_loops) == 12
    for loop in mesh.boundary_loops:
        edges = np.flatnonzero(np.isin(mesh.edges[mesh.boundary_edges, 0], loop))
        vectors = cover.field.ambient[mesh.edge_faces[mesh.boundary_edges[edges], 0]]
        below = cover.faces[mesh.edge_faces[mesh.boundary_edges[edges], 0]]
        # the loop passes every face beside the puncture six times, with another of the six vectors each time
        faces, counts = np.unique(below, return_counts=True)
        assert (counts == 6).all()
        one = vectors[below == faces[0]]
        cosines = np.sort(one @ one[0])
        np.testing.assert_allclose(cosines, [-1.0, -0.5, -0.5, 0.5, 0.5, 1.0], atol=1e-9)


@pytest.mark.parametrize("name", SHIPPED)
def test_rosy_lifts_to_a_plain_field_on_a_manifold(name):
    """Section 5.1: the cover is a manifold with boundary, perhaps in pieces; Section 5.2: w^0 lives on it."""
    cover = cover_of(name)
    # that it is a manifold is what TriMesh checks; no branch point is left in it
    assert cover.mesh.euler_characteristic == 6 * cover.part.mesh.euler_characteristic
    inside = ~cover.mesh.boundary_vertices
    assert not np.intersect1d(cover.vertices[inside], cover.rosy.branch_points).size
    np.testing.assert_allclose(cover.field.norms, 1.0)
    assert np.abs(rotation_across(cover.field)).max() <= np.pi / 6 + 1e-9


@pytest.mark.parametrize("name", SHIPPED)
def test_globally_optimal_rosy_has_the_least_energy(name):
    """Appendix D: argmin |grad w|^2 subject to |w|^2 = 1, against 20 random and 20 nearby fields."""
    mesh = catalogue.load(name)
    (mu,), field = smoothest_eigenfield(mesh, 0, 6)
    laplacian, rng = connection_laplacian(mesh, 6), np.random.default_rng(0)
    for k in range(40):
        noise = rng.normal(size=(2, mesh.n_faces))
        other = noise[0] + 1j * noise[1] if k % 2 else field.values + 0.01 * (noise[0] + 1j * noise[1])
        quotient = (other.conj() @ (laplacian @ other)).real / (mesh.face_areas @ np.abs(other) ** 2)
        assert quotient > mu
    residual = laplacian @ field.values - mu * mesh.face_areas * field.values
    assert np.linalg.norm(residual) < 1e-7 * mu


@pytest.mark.parametrize("name", ["bunny", "torus", "schwarz-p"])
def test_part_1_runs_on_the_cover(name):
    """Section 5: "the pipeline from Part 1 can be applied directly to C to find a geodesic foliation"."""
    cover = cover_of(name)
    schedule = sharpening_schedule(cover.mesh, finest=INTEGRABLE_END)
    field = geodesic_field(cover.quotient.field, smoothness=schedule).field
    assert total_curl(field) < 0.9 * total_curl(cover.quotient.field)
    found = cover.quotient.lifted(foliate(field))
    # the authors' code: median 2.1 and 95th percentile 12.6 degrees on a bunny of about as many faces
    assert found.alignment.median < 1.5
    assert found.alignment.p95 < 6.0
    lines = cover.project(isolines(found))
    assert lines.mesh is cover.rosy.mesh
    # three families, "crossing at roughly sixty degrees to each other"
    angle = np.degrees(np.abs(crossings(lines).angle))
    angle = np.minimum(angle, 180.0 - angle)
    assert np.median(angle) == pytest.approx(60.0, abs=6.0)
    assert np.mean(np.abs(angle - 60.0) < 20.0) > 0.9


def test_paired_sheets_differ_by_half_a_period():
    """Section 5.2: theta on paired faces differs "by exactly half of a phase shift"; no rounding here."""
    cover = cover_of("spot")
    schedule = sharpening_schedule(cover.mesh, finest=INTEGRABLE_END)
    field = geodesic_field(cover.quotient.field, smoothness=schedule).field
    found = cover.quotient.lifted(foliate(field, alternations=3))
    antipode, _ = cover.antipodes
    place = np.full(cover.mesh.n_faces, -1)
    place[found.part.faces] = np.arange(len(found.part.faces))
    seen = found.circle.theta[found.part.mesh.faces]
    opposite = seen[place[antipode[found.part.faces]]]
    # leaves lie at pi / 2; theta is opposite on the paired sheet, so its leaves lie at 3 pi / 2 on this one
    np.testing.assert_allclose(np.exp(1j * (seen + opposite)), 1.0, atol=1e-9)
