"""Mirror images of vectors on a surface, and RoSys that are made their own."""

from __future__ import annotations

import numpy as np
import pytest

from geoweave.errors import FieldError
from geoweave.fields.mirror_images import MirrorImages, symmetrized
from geoweave.fields.rosy import RoSyField, smoothest_rosy
from geoweave.models import datasets, shapes
from geoweave.surface.mirror_symmetry import mirror_plane


def test_a_vector_goes_to_its_image_in_space() -> None:
    """A field of vectors in space, drawn on a torus that a plane mirrors."""
    torus = shapes.torus(faces=2_000)
    plane = mirror_plane(torus, "z")
    images = MirrorImages.of(torus, plane)

    def drawn(points: np.ndarray) -> np.ndarray:
        return np.stack([points[:, 1], points[:, 2] + 0.3, points[:, 0] - 0.2], axis=1)

    given = torus.planar(drawn(torus.barycenters))
    image = torus.planar(plane.image_of_vectors(drawn(plane.image(torus.barycenters))))
    np.testing.assert_allclose(images.turns * (given / abs(given))[images.sources].conj(), image / abs(image))


@pytest.mark.parametrize("degree", [1, 4, 6])
def test_the_image_of_the_image_is_the_rosy_itself(degree: int) -> None:
    torus = shapes.torus(faces=2_000)
    images = MirrorImages.of(torus, mirror_plane(torus, "z"))
    angle = np.random.default_rng(1).uniform(-np.pi, np.pi, torus.n_faces)
    rosy = RoSyField(torus, degree, np.exp(1j * angle))
    np.testing.assert_allclose(images.of_rosy(images.of_rosy(rosy)).values, rosy.values, atol=1e-9)


def test_what_is_its_own_image_departs_by_nothing_and_a_turn_by_twice_itself() -> None:
    torus = shapes.torus(faces=2_000)
    images, faces = MirrorImages.of(torus, mirror_plane(torus, "z")), np.arange(torus.n_faces)
    around = torus.planar(np.cross([0.0, 0.0, 1.0], torus.barycenters))
    own = RoSyField(torus, 6, (around / abs(around)) ** 6)
    assert images.departure(faces, own.vectors) == pytest.approx(0.0, abs=1e-6)
    turned = RoSyField(torus, 6, np.exp(6j * np.radians(4.0)) * own.values)
    assert images.departure(faces, turned.vectors) == pytest.approx(8.0)
    assert images.departure(faces[::2], turned.vectors[::2]) == pytest.approx(8.0)


def test_a_rosy_becomes_its_own_image_and_its_indices_still_sum_to_what_they_must() -> None:
    spot = datasets.load("spot")
    images, faces = MirrorImages.of(spot, mirror_plane(spot)), np.arange(spot.n_faces)
    rosy = smoothest_rosy(spot, degree=6)
    found = symmetrized(rosy, images)
    assert images.departure(faces, found.vectors) < 0.3 * images.departure(faces, rosy.vectors)
    assert found.index_numerators.sum() == 6 * spot.euler_characteristic
    # branch points stand opposite each other, but for the triangles that do not
    points = spot.vertices[found.branch_points]
    across = points * [-1.0, 1.0, 1.0]
    apart = np.linalg.norm(points[:, None] - across, axis=2).min(axis=0)
    assert np.quantile(apart, 0.9) < 2.0 * spot.triangle_size


def test_what_is_its_own_image_already_stays() -> None:
    torus = shapes.torus(faces=600)
    images = MirrorImages.of(torus, mirror_plane(torus, "z"))
    around = torus.planar(np.cross([0.0, 0.0, 1.0], torus.barycenters))
    own = RoSyField(torus, 6, (around / abs(around)) ** 6)
    assert symmetrized(own, images) is own


def test_a_rosy_on_another_surface_is_refused() -> None:
    torus = shapes.torus(faces=600)
    images = MirrorImages.of(torus, mirror_plane(torus, "z"))
    other = shapes.sphere(faces=320)
    with pytest.raises(FieldError, match="not one on the surface"):
        images.of_rosy(RoSyField(other, 6, np.ones(other.n_faces)))
