from __future__ import annotations

import numpy as np
import pytest
from surfaces import surface

from geoweave.comparisons.domains import area_holding, ordered_domains, worst_share
from geoweave.errors import FieldError
from geoweave.fields.face_field import FaceField, random_field
from geoweave.fields.rosy import smoothest_field
from geoweave.models import shapes


def sectors(mesh):
    """The unit field of the function sign(xy) min(|x|, |y|): four sectors with walls on the diagonals."""
    x, y, _ = mesh.barycenters.T
    beside = np.abs(x) > np.abs(y)
    vectors = np.stack([np.where(beside, 0, np.sign(y)), np.where(beside, np.sign(x), 0), 0 * x], axis=1)
    return FaceField.from_ambient(mesh, vectors)


def test_four_sectors_of_a_square():
    # The diagonals of this square are edges of its triangles.
    mesh = shapes.square(faces=800)
    domains = ordered_domains(sectors(mesh))
    np.testing.assert_allclose(domains.areas, [1, 1, 1, 1])
    assert domains.effective_number == pytest.approx(4)
    assert domains.wall_length == pytest.approx(4 * np.sqrt(2))
    middle = mesh.vertices[mesh.edges[mesh.interior_edges[domains.walls]]]
    np.testing.assert_allclose(np.abs(middle[..., 0]), np.abs(middle[..., 1]))


def test_walls_of_another_angle_are_no_walls():
    mesh = shapes.square(faces=800)
    assert ordered_domains(sectors(mesh), 89.0).effective_number == pytest.approx(4)
    domains = ordered_domains(sectors(mesh), 91.0)
    assert domains.effective_number == pytest.approx(1)
    assert domains.wall_length == 0


@pytest.mark.parametrize("name", ["jagged sphere", "two pieces"])
def test_domains_are_cut_by_walls_only(name):
    mesh = surface(name)
    field = random_field(mesh, 0)
    domains = ordered_domains(field)
    i, j = mesh.edge_faces[mesh.interior_edges[~domains.walls]].T
    np.testing.assert_array_equal(domains.of_face[i], domains.of_face[j])
    assert domains.areas.sum() == pytest.approx(mesh.face_areas.sum())
    assert domains.areas.min() > 0
    # Of 180 degrees of turning only 10 join two neighbours: nearly every face stands alone.
    assert domains.effective_number > 0.6 * mesh.n_faces
    assert ordered_domains(smoothest_field(mesh), 30.0).effective_number < 2 + mesh.n_components


def test_shares_of_what_is_even_and_of_what_is_sparse():
    mesh = surface("disk")
    even, sparse = np.ones(mesh.n_faces), np.where(np.arange(mesh.n_faces) < 8, -1.0, 0.0)
    assert worst_share(even, 0.01) == pytest.approx(0.01, abs=1 / mesh.n_faces)
    assert worst_share(sparse, 0.01) == pytest.approx(1.0)
    assert worst_share(sparse, 0.005) == pytest.approx(0.5)
    # One face more or less.
    largest = mesh.face_areas.max() / mesh.face_areas.sum()
    assert area_holding(mesh, even, 0.9) == pytest.approx(0.9, abs=largest)
    assert area_holding(mesh, sparse, 0.9) <= mesh.face_areas[:8].sum() / mesh.face_areas.sum()


def test_nonsense_is_refused():
    with pytest.raises(FieldError, match="between 0 and 180"):
        ordered_domains(random_field(surface("disk"), 0), 0.0)
