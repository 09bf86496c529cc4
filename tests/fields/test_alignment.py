"""A guide is followed where it is, given way to where it costs, and leaves given singularities in place."""

from __future__ import annotations

import numpy as np
import pytest
from surfaces import surface

from geoweave.errors import FieldError
from geoweave.fields.alignment import aligned_connection, aligned_rosy, along_curve, along_direction
from geoweave.fields.rosy import smoothest_rosy
from geoweave.fields.trivial_connection import prescribed_rosy


def mean_deviation(guide, rosy):
    return float(np.average(guide.deviation(rosy.vectors), weights=guide.weights))


@pytest.mark.parametrize("angle", [0.0, 0.4, 2.0])
def test_on_a_plane_the_direction_is_met(angle):
    disk = surface("disk")
    guide = along_direction(disk, 6, [np.cos(angle), np.sin(angle), 0.0])
    rosy = aligned_rosy(guide)
    assert guide.deviation(rosy.vectors).max() < 1e-6
    turned = disk.planar(np.tile([np.cos(angle), np.sin(angle), 0.0], (disk.n_faces, 1)))
    assert np.abs(np.angle(rosy.values * turned.conj() ** 6)).max() < 1e-6
    assert guide.weights.sum() == pytest.approx(disk.face_areas.sum())


@pytest.mark.parametrize("name", ["sphere", "torus", "cylinder"])
def test_a_direction_is_followed_better_than_by_chance(name):
    mesh = surface(name)
    guide = along_direction(mesh, 6, [0.3, 0.1, 1.0])
    # Thirty degrees are the farthest from one of six; fifteen are what chance gives.
    assert mean_deviation(guide, aligned_rosy(guide)) < 6.0
    assert mean_deviation(guide, aligned_rosy(guide)) < mean_deviation(guide, smoothest_rosy(mesh, 6)) + 1e-9


def test_a_curve_counts_by_its_length_and_is_followed():
    disk = surface("disk")
    corners = np.array([[-0.6, -0.1, 0.0], [0.1, 0.0, 0.0], [0.5, 0.4, 0.0]]) + [0, 0, disk.vertices[0, 2]]
    guide = along_curve(disk, 4, corners)
    length = np.linalg.norm(np.diff(corners, axis=0), axis=1).sum()
    assert guide.weights.sum() == pytest.approx(0.1 * disk.bounding_radius * length)
    rosy = aligned_rosy(guide)
    # The corner turns by 37 degrees; a field of four bends round it softly.
    assert mean_deviation(guide, rosy) < 8.0
    assert not rosy.index_numerators.any()


def test_a_connection_is_turned_without_moving_its_singularities():
    mesh = surface("torus")
    rosy = smoothest_rosy(mesh, 6)
    guide = along_direction(mesh, 6, [1.0, 0.0, 0.0])
    turned = aligned_connection(rosy, guide)
    assert (turned.index_numerators == rosy.index_numerators).all()
    assert mean_deviation(guide, turned) < mean_deviation(guide, rosy)
    # On a plane nothing holds it back.
    disk = surface("disk")
    flat = prescribed_rosy(disk, 6, np.zeros(disk.n_vertices, dtype=int))
    along = along_direction(disk, 6, [0.2, 0.9, 0.0])
    assert along.deviation(aligned_connection(flat, along).vectors).max() < 1e-3


def test_what_has_no_direction_is_refused():
    disk = surface("disk")
    with pytest.raises(FieldError, match="must not be zero"):
        along_direction(disk, 6, [0.0, 0.0, 0.0])
    with pytest.raises(FieldError, match="two points that are apart"):
        along_curve(disk, 6, [[0.1, 0.0, 0.0]] * 2)
    with pytest.raises(FieldError, match="not one for this RoSy"):
        aligned_connection(smoothest_rosy(disk, 4), along_direction(disk, 6, [1.0, 0.0, 0.0]))
