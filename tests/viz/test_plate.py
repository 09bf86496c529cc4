"""Plates as values: values with a scale, projections that lie on the edges they compare."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

from geoweave import viz
from geoweave.errors import RenderError
from geoweave.fields.face_field import FaceField, random_field
from geoweave.fields.operators import ClosedFields, as_complex
from geoweave.models import shapes
from geoweave.surface.mesh import TriMesh


@cache
def square() -> TriMesh:
    return shapes.square(faces=200)


def test_projections_are_equally_long_where_the_curl_vanishes() -> None:
    ball = shapes.sphere(faces=500)
    fields = ClosedFields(ball)
    rng = np.random.default_rng(0)
    closed = FaceField(ball, as_complex(fields.basis @ rng.normal(size=fields.basis.shape[1])))
    vertex = int(ball.faces[0, 0])
    for field, equal in ((closed, True), (random_field(ball, 0), False)):
        plate = viz.projections(field, vertex)
        vectors, left, right = plate.arrows
        assert len(vectors.points) == (ball.faces == vertex).sum()
        assert len(left.points) == len(right.points) == len(vectors.points)
        assert (np.abs(left.vectors - right.vectors).max() < 1e-12) == equal
        # Each lies on its own side of the edge, and dashes lead from tail and tip square to the edge.
        tail_foot = plate.lines[0].what[: len(left.points)]
        drop = tail_foot[:, 1] - tail_foot[:, 0]
        assert np.abs(np.einsum("ex,ex->e", drop, left.vectors)).max() < 1e-12
        side = np.einsum("ex,ex->e", left.points - tail_foot[:, 1], drop)
        assert (side < 0).all()
        viz.plates([plate], width=300)


def test_values_need_a_scale_and_one_for_each_face() -> None:
    scale = viz.heat_scale(np.ones(3), "x")
    values = np.ones(square().n_faces)
    with pytest.raises(RenderError, match="go together"):
        viz.Plate(square(), values=values)
    with pytest.raises(RenderError, match="values of faces"):
        viz.Plate(square(), values=values[1:], scale=scale)
