"""What a field winds is counted on the cover: as the RoSy before Algorithm 1, and what differs after it."""

from __future__ import annotations

import numpy as np
import pytest

from geoweave.fields.face_field import FaceField
from geoweave.fields.rosy import smoothest_rosy
from geoweave.fields.trivial_connection import prescribed_rosy
from geoweave.models import shapes
from geoweave.weave.as_asked import displaced, lifted_vectors
from geoweave.weave.cover import branched_cover
from geoweave.weave.design import weave_field


@pytest.mark.parametrize("degree", [3, 4, 5, 6])
@pytest.mark.parametrize(
    "mesh", [shapes.sphere(faces=720), shapes.torus(faces=900), shapes.genus_g(2, faces=1500)]
)
def test_the_lifted_rosy_has_the_singularities_of_the_rosy(mesh, degree):
    cover = branched_cover(smoothest_rosy(mesh, degree))
    assert displaced(cover, cover.quotient.field) == ()


def test_punctures_that_touch_are_counted_as_one():
    ball = shapes.sphere(faces=720)
    numerators = np.zeros(ball.n_vertices, dtype=np.int64)
    # Two neighbours share a puncture; the others are far.
    first = int(ball.vertices[:, 2].argmax())
    edge = ball.edges[(ball.edges == first).any(axis=1)][0]
    numerators[edge] = 2, 1
    far = np.argsort(ball.vertices[:, 2])[[0, 40, 120]]
    numerators[far] = 3
    cover = branched_cover(prescribed_rosy(ball, 6, numerators))
    assert displaced(cover, cover.quotient.field) == ()


def test_a_vortex_that_is_added_on_the_sheets_is_found():
    cover = weave_field(shapes.torus(faces=900), geodesic=False).cover
    quotient, mesh = cover.quotient, cover.mesh
    inside = np.flatnonzero(~mesh.boundary_vertices)
    at = int(inside[np.bincount(mesh.faces.ravel())[inside] == 6][0])
    # Turn the fan of one vertex round once: a face field can hold that.
    fan = np.flatnonzero((mesh.faces == at).any(axis=1))
    whirl = np.zeros((mesh.n_faces, 3))
    whirl[fan] = np.cross(mesh.face_normals[fan], mesh.barycenters[fan] - mesh.vertices[at])
    values = quotient.field.values.copy()
    values[quotient.faces[fan]] = quotient.signs[fan] * mesh.planar(whirl)[fan]
    found = displaced(cover, FaceField(quotient.mesh, values / np.abs(values)))
    # It turns once on a sheet and on the opposite one.
    index = {each.vertex: each for each in found}[int(cover.vertices[at])]
    assert (index.numerator, index.found) == (0, 2)
    # What was added there is taken from its neighbours: the sum stays.
    assert sum(each.found - each.numerator for each in found) == 0


def test_algorithm_1_keeps_what_the_smoothest_rosy_has():
    for mesh in (shapes.sphere(faces=720), shapes.genus_g(2, faces=1500)):
        field = weave_field(mesh)
        assert displaced(field.cover, field.field) == ()


def test_algorithm_1_tears_a_large_index_and_that_is_said():
    from geoweave.weave.steering import Singularity, Steering

    asked = Steering((Singularity((0, 0, 1), 5), Singularity((0, 0, -1), 7)))
    field = weave_field(shapes.sphere(faces=1280), steering=asked)
    assert field.met.displaced
    assert {each.numerator for each in field.met.displaced} >= {5, 7}
    assert sum(each.found - each.numerator for each in field.met.displaced) == 0


def between_families(phase):
    from geoweave.weave.steering import Steering

    field = weave_field(shapes.torus(faces=900), phase=phase, steering=Steering(singularities=()))
    assert field.met.displaced == ()
    _, vectors = lifted_vectors(field.cover, field.field)
    return np.degrees(np.abs(np.angle(vectors[:, 1:3] ** 2 / vectors[:, :1] ** 2)) / 2)


def test_without_branch_points_the_families_of_a_torus_fall_together():
    # Nothing in Eq. 5 holds the sheets apart: each becomes the same geodesic field, up to its sign.
    assert between_families("free").max() < 1.0


def test_a_sum_that_is_to_be_zero_keeps_them_apart():
    # Not at 60 degrees: circles round the tube cost Eq. 5 nothing, so each family still leans towards them.
    assert between_families("regular").min() > 15.0
