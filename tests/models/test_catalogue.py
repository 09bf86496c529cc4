from __future__ import annotations

import numpy as np
import pytest

from geoweave.errors import DataError
from geoweave.models import catalogue
from geoweave.models.datasets import names
from geoweave.viz import VIEWS


def test_every_model_is_a_shape_or_a_dataset_and_has_a_view():
    for name, model in catalogue.MODELS.items():
        assert (model.build is not None) != (name in names()), name
        assert model.view in VIEWS


def test_models_are_normalised():
    for name in ("sphere", "rocker-arm-like", "spot"):
        mesh = catalogue.load(name)
        np.testing.assert_allclose(mesh.vertices.mean(axis=0), 0, atol=1e-12)
        assert np.linalg.norm(mesh.vertices, axis=1).max() == pytest.approx(1)


def test_an_unknown_model_is_refused_with_the_list():
    with pytest.raises(DataError, match="there is no model 'giraffe'; there are: armadillo, bunny"):
        catalogue.load("giraffe")
