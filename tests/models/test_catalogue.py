from __future__ import annotations

import numpy as np
import pytest

from geoweave import models, shapes
from geoweave.curves import geodesic_curvature
from geoweave.datasets import names
from geoweave.errors import DataError
from geoweave.fields import FaceField
from geoweave.tracing import streamlines
from geoweave.viz import VIEWS


def test_every_model_is_a_shape_or_a_dataset_and_has_a_view():
    for name, model in models.MODELS.items():
        assert (model.build is not None) != (name in names()), name
        assert model.view in VIEWS


def test_models_are_normalised():
    for name in ("sphere", "rocker-arm-like", "spot"):
        mesh = models.load(name)
        np.testing.assert_allclose(mesh.vertices.mean(axis=0), 0, atol=1e-12)
        assert np.linalg.norm(mesh.vertices, axis=1).max() == pytest.approx(1)


def test_an_unknown_model_is_refused_with_the_list():
    with pytest.raises(DataError, match="there is no model 'giraffe'; there are: armadillo, bunny"):
        models.load("giraffe")


@pytest.mark.parametrize("size", [1.0, 50.0])
def test_bending_is_a_number_without_unit(size):
    """Circles of radius r turn 1 / r per length: on a disk of radius R the mean of R / r over the lines."""
    disk = shapes.disk(3000)
    mesh = type(disk)(disk.vertices * size, disk.faces)
    x, y, _ = mesh.barycenters.T
    straight = FaceField.from_ambient(mesh, np.stack([0 * x + 1, 0 * x, 0 * x], axis=1))
    assert models.bending(streamlines(straight, separation=0.1 * size)) < 1e-6
    round_ = FaceField.from_ambient(mesh, np.stack([-y, x, 0 * x], axis=1)).normalized()
    curves = streamlines(round_, separation=0.1 * size)
    mean = np.average(np.abs(geodesic_curvature(curves)), weights=curves.segment_lengths)
    assert models.bending(curves) == pytest.approx(mean * size, rel=0.02)
    assert 1.0 < models.bending(curves) < 4.0
