"""The methods of Fig. 15: same surface and frequency for all, each one what it says."""

import numpy as np
import pytest
from surfaces import surface

from geoweave.comparisons.integration_methods import TITLES, Method, geodesic_from, integrated, steepness
from geoweave.comparisons.mixed_integer import mixed_integer_parameterization
from geoweave.errors import FieldError
from geoweave.fields.face_field import FaceField
from geoweave.fields.singularities import singular_vertices
from geoweave.foliation.circle_function import TURN
from geoweave.foliation.foliation import punctured
from geoweave.foliation.level_set_alignment import alignment
from geoweave.foliation.level_sets import isolines
from geoweave.models import catalogue

SPHERE = geodesic_from(surface("sphere"), "smoothest")


@pytest.mark.parametrize("method", TITLES)
def test_one_surface_and_one_frequency_for_all(method: Method) -> None:
    # Fifteen turns round the equator: the integer next to it is at most 4 % away, about what is asked for.
    found = integrated(SPHERE, method, 15.0)
    field, part = punctured(SPHERE)
    np.testing.assert_array_equal(found.part.faces, part.faces)
    np.testing.assert_array_equal(found.field.values, field.values)
    assert found.circle.mesh is found.part.mesh
    assert found.frequency == pytest.approx(15.0, rel=0.06)
    fit = alignment(found.field, found.circle)
    assert found.alignment == fit
    assert found.row["mean"] == fit.mean
    assert found.row["method"] == TITLES[method]
    if method in ("mixed-integer", "anisotropic"):
        assert found.alignment.dislocations == 0


def test_frequency_is_the_length_of_level_sets_per_area() -> None:
    field, _ = punctured(SPHERE)
    circle = mixed_integer_parameterization(field, 12.0)
    # The coarea formula: the mean length of a level is the integral of |grad theta| over 2 pi.
    levels = TURN * np.arange(8) / 8.0
    length = isolines(circle, levels).lengths.sum() / len(levels)
    assert TURN * length / circle.mesh.face_areas.sum() == pytest.approx(steepness(circle), rel=0.01)


def test_a_torus_has_singularities_from_a_random_start_only() -> None:
    ring = catalogue.load("torus")
    assert not len(singular_vertices(geodesic_from(ring, "smoothest")))
    assert len(singular_vertices(geodesic_from(ring, "random")))


def test_bad_input_is_refused() -> None:
    with pytest.raises(FieldError, match="no method 'best'"):
        integrated(SPHERE, "best", 3.0)  # type: ignore[arg-type]
    with pytest.raises(FieldError, match="no start 'cold'"):
        geodesic_from(SPHERE.mesh, "cold")  # type: ignore[arg-type]
    with pytest.raises(FieldError, match="positive and finite, not 0"):
        integrated(FaceField(SPHERE.mesh, SPHERE.values), "ours", 0.0)
