"""What Section 3 says of geodesic foliations and almost-foliations: examples known in closed form."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import ArrayLike

from geoweave.comparisons.great_circles import meridian_field
from geoweave.comparisons.singular_curves import singular_lines
from geoweave.curves.curves import geodesic_curvature
from geoweave.curves.tracing import streamlines
from geoweave.fields.face_field import FaceField, edge_curl
from geoweave.fields.singularities import rotation_across, singular_vertices
from geoweave.foliation.foliation import foliate
from geoweave.foliation.level_sets import isolines
from geoweave.models import shapes
from geoweave.surface.mesh import TriMesh


def winding(tube: TriMesh, alpha: ArrayLike, beta: ArrayLike) -> FaceField:
    """alpha d/dphi + beta d/dz on a cylinder about the z axis, numbers or one for each face."""
    x, y, _ = tube.barycenters.T
    around = np.stack([-y, x, 0 * x], axis=1) / np.hypot(x, y)[:, None]
    return FaceField.from_ambient(
        tube, np.multiply.outer(alpha, np.ones(3)) * around + np.multiply.outer(beta, [0.0, 0.0, 1.0])
    )


@pytest.mark.parametrize(("alpha", "beta"), [(0.0, 1.0), (1.0, 0.0), (1.0, 0.5), (-0.3, 1.0)])
def test_windings_of_the_cylinder_are_geodesic(alpha, beta):
    """3: examples are "vector fields alpha d/dtheta + beta d/dz on the cylinder, for constants"."""
    tube = shapes.cylinder(1.0, 2.0, faces=2000)
    field = winding(tube, alpha, beta)
    # A cylinder of flat strips unfolds to a plane, where these are constant fields: straight to rounding.
    assert np.abs(edge_curl(field)).max() < 1e-12
    assert np.abs(rotation_across(field)).max() < 1e-9
    assert np.abs(geodesic_curvature(streamlines(field, share=0.15))).max() < 1e-6


def test_constant_fields_of_the_plane_are_geodesic():
    """3: "examples include any constant vector field on the plane"."""
    disk = shapes.disk(faces=1000)
    for angle in (0.0, 0.4, 2.0):
        field = FaceField.from_ambient(
            disk, np.broadcast_to([np.cos(angle), np.sin(angle), 0], (disk.n_faces, 3))
        )
        assert np.abs(edge_curl(field)).max() < 1e-12
        assert np.abs(geodesic_curvature(streamlines(field, share=0.15))).max() < 1e-9


@pytest.mark.parametrize(("alpha", "beta"), [(0.3, 1.0), (1.0, 0.7)])
def test_level_sets_and_integral_curves_are_the_same_foliation(alpha, beta):
    """3: "the two representations are related by w = (grad theta)-perp"; both give geodesics."""
    tube = shapes.cylinder(1.0, 2.0, faces=2000)
    field = winding(tube, alpha, beta).normalized()
    found = foliate(field)
    turned = found.circle.gradient * field.values.conj()
    # A quarter turn from the field to the gradient, the same way on every face, up to the last alternation.
    angle = np.degrees(np.angle(turned))
    assert np.ptp(angle) < 1
    assert abs(abs(np.median(angle)) - 90) < 1
    lines = isolines(found.circle)
    assert len(lines) > 3
    assert np.abs(geodesic_curvature(lines)).max() < 0.01


def test_minimising_geodesics_to_a_point_foliate_all_but_its_cut_locus():
    """3: "one can take S to be the cut locus of p, with minimizing geodesics to p partitioning the rest"."""
    tube = shapes.cylinder(1.0, 2.0, faces=8000)
    x, y, z = tube.barycenters.T
    # Unrolled, the geodesics to the point (1, 0, 0) are straight; on the line opposite they come both ways.
    field = winding(tube, -np.arctan2(y, x), -z).normalized()
    found = singular_lines(field, angle=20.0)
    ends = tube.vertices[np.unique(tube.edges[found.edges])]
    at_point = np.linalg.norm(ends - [1, 0, 0], axis=1) < 4 * tube.mean_edge
    opposite = np.linalg.norm(ends[:, :2] - [-1, 0], axis=1) < 2 * tube.mean_edge
    # A star round the point, a line opposite from rim to rim, and nothing else.
    assert (at_point | opposite).all()
    assert np.ptp(ends[opposite, 2]) == pytest.approx(np.ptp(tube.vertices[:, 2]))
    lines = streamlines(field, share=0.1)
    # The vectors are those of the barycentres, so a line turns at every edge by a part of what they differ.
    assert np.average(np.abs(geodesic_curvature(lines)), weights=lines.segment_lengths) < 0.02


def test_on_the_sphere_the_cut_locus_is_the_opposite_point():
    """3: a geodesic almost-foliation with two points as its measure-zero set of singularities."""
    ball = shapes.sphere(faces=8000)
    field = meridian_field(FaceField(ball, np.ones(ball.n_faces)), [0.6, 0.0, 0.8])
    poles = ball.vertices[singular_vertices(field)]
    assert len(poles) == 2
    assert np.linalg.norm(poles.sum(axis=0)) < 2 * ball.mean_edge
    assert not len(singular_lines(field))
    lines = streamlines(field, share=0.1)
    assert np.average(np.abs(geodesic_curvature(lines)), weights=lines.segment_lengths) < 0.03
