"""Stretches are exact, also past the first point of a closed curve."""

from __future__ import annotations

from itertools import chain

import numpy as np

import geoweave as gw
from geoweave.curves.curves import Curves
from geoweave.curves.straightest_geodesics import straightest
from geoweave.curves.stretch import stretches
from geoweave.foliation.level_sets import isolines
from geoweave.models import shapes
from geoweave.surface.mesh import TriMesh


def circle_and_ray() -> Curves:
    """A closed polyline of 40 points round a disk and a straight line, on one mesh."""
    mesh = shapes.disk(faces=500)
    turned = isolines_of_radius(mesh)
    line = straightest(mesh, [0], [[1.0, 0.2, 0.0]], 0.5)
    return Curves.concatenate(mesh, chain(turned, line))


def isolines_of_radius(mesh: TriMesh) -> Curves:
    radius = np.linalg.norm(mesh.vertices, axis=1)
    tail, head = mesh.edges.T
    return isolines(gw.CircleFunction(mesh, radius, radius[head] - radius[tail]), [0.6])


def test_stretches_have_the_lengths_asked_for() -> None:
    curves = circle_and_ray()
    assert curves.closed.tolist() == [True, False]
    round_ = curves.lengths[0]
    which = np.array([0, 0, 1, 1, 0])
    start = np.array([0.1, 0.9 * round_, 0.0, 0.2, 0.0])
    end = np.array([0.3, 1.2 * round_, 0.5, 0.21, round_])
    found = stretches(curves, which, start, end)
    np.testing.assert_allclose(found.lengths, end - start, rtol=1e-9)
    assert found.closed.tolist() == [False, False, False, False, True]
    # All points of the closed curve lie between the level's circle and the chord of a facet.
    radius = np.linalg.norm(found[1].points, axis=1)
    assert 0.55 < radius.min() <= radius.max() < 0.601
