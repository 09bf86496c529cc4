"""Files of singularities are read or refused by line, positions go to vertices, and the weave has them."""

from __future__ import annotations

import numpy as np
import pytest

from geoweave.errors import FieldError, MeshError
from geoweave.models import datasets, shapes
from geoweave.weave.design import weave_field, weave_pattern
from geoweave.weave.steering import (
    Singularity,
    Steering,
    expected_spacing,
    snapped,
    steering_for,
)

TETRAHEDRON = tuple(
    Singularity((x / 3**0.5, y / 3**0.5, z / 3**0.5), 3)
    for x, y, z in ((1, 1, 1), (1, -1, -1), (-1, 1, -1), (-1, -1, 1))
)


def test_positions_go_to_the_nearest_vertex_inside():
    disk, placement = shapes.disk(faces=400).normalized()
    middle, rim = Singularity((0.01, 0, 0), 2), Singularity((0.99, 0, 0), -1)
    numerators = snapped(disk, placement, (middle, rim))
    at = np.flatnonzero(numerators)
    assert sorted(numerators[at].tolist()) == [-1, 2]
    assert not disk.boundary_vertices[at].any()
    with pytest.raises(FieldError, match=r"at \(0, 0, 7\) is 7.* from the nearest vertex"):
        snapped(disk, placement, (Singularity((0, 0, 7), 1),))
    with pytest.raises(FieldError, match="have the same nearest vertex"):
        snapped(disk, placement, (middle, Singularity((-0.01, 0, 0), 1)))


def test_prescribed_branch_points_are_those_of_the_weave_wherever_the_surface_lies():
    from geoweave.surface.mesh import TriMesh

    ball = shapes.sphere(faces=1280)
    far = TriMesh(5.0 * ball.vertices + [10.0, 0.0, -3.0], ball.faces)
    there = tuple(
        Singularity(tuple(5.0 * np.array(p) + [10.0, 0.0, -3.0]), index) for p, index in TETRAHEDRON
    )
    for mesh, asked in ((ball, TETRAHEDRON), (far, there)):
        field = weave_field(mesh, steering=Steering(asked))
        at = field.placement.undo(field.mesh.vertices[field.branch_points])
        wanted = np.array([each.position for each in asked])
        apart = np.linalg.norm(at[:, None] - wanted, axis=2)
        assert apart.shape == (4, 4)
        assert apart.min(axis=0).max() < 0.65 * mesh.mean_edge  # 0.58 is the middle of a triangle
        assert field.cover.rosy.index_numerators[field.branch_points].tolist() == [3] * 4
        # Algorithm 1 keeps them, and adds none.
        assert field.met.displaced == ()


def test_the_weave_says_whether_the_prescribed_singularities_were_kept():
    ball = shapes.sphere(faces=1280)
    kept = weave_pattern(ball, scale=0.8, steering=Steering(TETRAHEDRON)).metrics()
    assert kept["prescribed_singularities"] == {"kept": True, "displaced": []}
    assert "prescribed_singularities" not in weave_pattern(ball, scale=0.8).metrics()


def test_merging_leaves_fewer_branch_points_and_the_same_sum():
    mesh = shapes.genus_g(2, faces=1500)
    plain, merged = weave_field(mesh), weave_field(mesh, steering=Steering(merge=4.0))
    assert len(merged.branch_points) < len(plain.branch_points)
    total = plain.cover.rosy.index_numerators.sum()
    assert merged.cover.rosy.index_numerators.sum() == total == 6 * mesh.euler_characteristic
    assert merged.met.displaced is None


def test_the_spacing_that_is_expected_is_about_that_of_the_weave():
    mesh = shapes.genus_g(2, faces=1500)
    for asked in ({"scale": 0.7}, {"ribbons": 30}):
        weave = weave_pattern(mesh, **asked, effort=1000)
        expected = expected_spacing(mesh, 3, asked.get("scale"), asked.get("ribbons"))
        # Two constants stand for all surfaces: within a half is what they can do.
        assert 0.5 < expected / weave.ribbons.spacing < 2.0
    steering = steering_for(mesh, 3, 0.5, None, Steering(merge=1.0))
    assert steering.spacing == pytest.approx(2 * expected_spacing(mesh, 3, 1.0, None))
    assert steering_for(mesh, 3, 0.5, None, None) == Steering()


def test_a_symmetric_surface_gets_a_field_that_is_its_own_image():
    spot = datasets.load("spot")
    field = weave_field(spot, steering=Steering(symmetric="x"))
    mirrored = field.met.mirrored
    assert mirrored.normal == (1.0, 0.0, 0.0)
    assert 0 < mirrored.surface < 2e-3
    assert mirrored.field < 5.0  # degrees; chance gives 15, and as it comes the field is at 13.6
    assert weave_field(spot).met.mirrored is None


def test_symmetry_is_refused_where_there_is_none_or_it_cannot_be_had():
    with pytest.raises(MeshError, match="no mirror plane"):
        weave_field(datasets.load("bunny"), steering=Steering(symmetric="auto"))
    with pytest.raises(FieldError, match="no mirror symmetry 'w': off, auto, x, y, z"):
        Steering(symmetric="w")
    with pytest.raises(FieldError, match="mirror pairs, or leave out the symmetry"):
        Steering(TETRAHEDRON, symmetric="z")


def test_numbers_out_of_range_are_refused():
    for bad in (-1.0, np.inf, np.nan):
        with pytest.raises(FieldError, match="0 spacings or more"):
            Steering(merge=bad)


def test_what_has_no_length_cannot_be_followed():
    for nothing in (((0.0, 0.0, 0.0),), ((1.0, 2.0, 3.0),) * 2):
        with pytest.raises(FieldError, match="has no length"):
            Steering(align=nothing)


def test_a_family_of_the_finished_field_follows_the_curve():
    mesh = shapes.genus_g(2, faces=1500)
    side = mesh.vertices[:, 2].max()
    curve = tuple((x, 0.0, side) for x in np.linspace(-0.2, 0.2, 5) * np.ptp(mesh.vertices[:, 0]))
    middle = mesh.vertices.mean(axis=0)
    near = [tuple(mesh.vertices[np.linalg.norm(mesh.vertices - p, axis=1).argmin()]) for p in curve + middle]
    met = weave_field(mesh, steering=Steering(align=tuple(near))).met
    assert met is not None
    assert met.displaced is None
    # 15 degrees are what a family is off by chance.
    assert met.aligned < 8.0
    with pytest.raises(FieldError, match=r"of the curve to follow is .* from the surface"):
        weave_field(mesh, steering=Steering(align=((0.0, 0.0, 90.0), *near)))


def test_prescribed_singularities_stay_where_a_direction_is_followed_too():
    ball = shapes.sphere(faces=1280)
    free = weave_field(ball, steering=Steering(TETRAHEDRON))
    both = weave_field(ball, steering=Steering(TETRAHEDRON, align=((0.0, 0.0, 1.0),)))
    assert (both.cover.rosy.index_numerators == free.cover.rosy.index_numerators).all()
    assert both.met.displaced == ()
    assert both.met.aligned < 15.0
    weave = both.pattern(scale=0.8, effort=1000)
    assert weave.metrics()["aligned_deg"] == both.met.aligned
