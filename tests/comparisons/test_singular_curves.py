from __future__ import annotations

import numpy as np
import pytest
from surfaces import surface

from geoweave.comparisons.singular_curves import singular_lines
from geoweave.errors import FieldError
from geoweave.fields.face_field import FaceField
from geoweave.models import shapes


def square_field(left, right) -> FaceField:
    """One vector left of the middle of a square, another right of it; the rows of the mesh run along x."""
    mesh = shapes.square(faces=1600)
    middle = mesh.barycenters[:, 1] < mesh.vertices[:, 1].mean()
    return FaceField.from_ambient(mesh, np.where(middle[:, None], left, right))


def test_a_wall_is_found_with_its_length_and_its_curl():
    field = square_field([1.0, 0.0, 0.0], [0.0, 1.0, 0.0])
    width = np.ptp(field.mesh.vertices[:, 0])
    lines = singular_lines(field)
    assert len(lines) == 1
    # The wall between the rows may step along a row of triangles; the projection jumps by 1 on its length.
    assert width <= lines.length < 2.1 * width
    assert lines.curl == pytest.approx(width, rel=0.05)
    assert (lines.line_of_edge == 0).all()


def test_a_ridge_carries_no_curl():
    """Vectors that meet the wall at equal angles: their projections on it agree, as at a ridge of a roof."""
    field = square_field([1.0, 1.0, 0.0], [1.0, -1.0, 0.0])
    lines = singular_lines(field)
    assert lines.length > 0
    assert lines.curl < 0.05 * lines.length


def test_smooth_fields_have_none_and_points_do_not_count():
    disk = surface("disk")
    constant = FaceField.from_ambient(disk, np.broadcast_to([1.0, 0, 0], (disk.n_faces, 3)))
    assert len(singular_lines(constant)) == 0
    radial = FaceField.from_ambient(disk, disk.barycenters).normalized()
    assert len(singular_lines(radial)) == 0
    assert len(singular_lines(radial, shortest=0.0)) == 1


def test_two_walls_are_two_lines():
    mesh = shapes.square(faces=1600)
    third = np.floor(3 * (mesh.barycenters[:, 1] - mesh.vertices[:, 1].min()) / np.ptp(mesh.vertices[:, 1]))
    field = FaceField.from_ambient(mesh, np.where((third == 1)[:, None], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]))
    lines = singular_lines(field)
    assert len(lines) == 2
    np.testing.assert_allclose(lines.lengths.sum(), lines.length)
    assert set(lines.line_of_edge.tolist()) == {0, 1}
    assert len(singular_lines(field, angle=95.0)) == 0


def test_refusals():
    field = square_field([1.0, 0, 0], [1.0, 0, 0])
    for angle, shortest in ((0.0, 4.0), (200.0, 4.0), (45.0, -1.0)):
        with pytest.raises(FieldError, match="singular lines need"):
            singular_lines(field, angle, shortest)
