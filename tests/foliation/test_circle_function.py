"""Circle-valued functions: full turns are counted, gradients are exact, dislocations are seen."""

import numpy as np
import pytest
from surfaces import ALL, surface

from geoweave.errors import FieldError
from geoweave.fields.operators import as_complex, differences, gradient
from geoweave.foliation.circle_function import CircleFunction, wrapped
from geoweave.models import shapes


def test_wrapping() -> None:
    np.testing.assert_allclose(
        wrapped(np.array([0.0, 4.0, -4.0, 7.0])), [0, 4 - 2 * np.pi, 2 * np.pi - 4, 7 - 2 * np.pi]
    )


@pytest.mark.parametrize("name", ALL)
def test_a_function_with_real_values(name: str) -> None:
    mesh = surface(name)
    values = 20.0 * mesh.vertices @ [0.3, -0.5, 0.8]
    circle = CircleFunction.nearest(mesh, wrapped(values), differences(mesh) @ values + 1.0)
    np.testing.assert_allclose(circle.jumps, differences(mesh) @ values, atol=1e-12)
    np.testing.assert_allclose(circle.gradient, as_complex(gradient(mesh) @ values), atol=1e-10)
    assert not circle.dislocated.any()


def test_full_turns_round_a_cylinder() -> None:
    mesh = shapes.cylinder(1.0, 2.0, faces=1200)
    angle = 5.0 * np.arctan2(mesh.vertices[:, 1], mesh.vertices[:, 0])
    # Five turns over some sixty edges: the shortest change along an edge is the right one.
    circle = CircleFunction.nearest(mesh, angle, np.zeros(mesh.n_edges))
    turns = [circle.periods(loop) for loop in mesh.boundary_loops]
    np.testing.assert_allclose(np.abs(turns), 5.0, atol=1e-12)
    assert sum(turns) == pytest.approx(0.0, abs=1e-12)
    assert not circle.dislocated.any()
    walk = mesh.boundary_loops[0][:3]
    open_turns = circle.periods(walk, closed=False)
    assert open_turns == pytest.approx(2 * turns[0] / len(mesh.boundary_loops[0]), rel=1e-9)


def test_a_vortex_dislocates_the_face_it_sits_in() -> None:
    mesh = shapes.disk(faces=800)
    inside = int(np.argmin(np.linalg.norm(mesh.barycenters, axis=1)))
    x, y = (mesh.vertices - mesh.barycenters[inside]).T[:2]
    circle = CircleFunction.nearest(mesh, np.arctan2(y, x), np.zeros(mesh.n_edges))
    assert np.flatnonzero(circle.dislocated).tolist() == [inside]
    assert circle.dislocations[inside] == 1


def test_what_does_not_fit_is_refused() -> None:
    mesh = surface("disk")
    theta, jumps = np.zeros(mesh.n_vertices), np.zeros(mesh.n_edges)
    with pytest.raises(FieldError, match="one number per vertex"):
        CircleFunction(mesh, theta[1:], jumps)
    with pytest.raises(FieldError, match="not finite"):
        CircleFunction(mesh, theta, np.full(mesh.n_edges, np.nan))
    with pytest.raises(FieldError, match="off what its ends say"):
        CircleFunction(mesh, theta, jumps + 0.5)
    with pytest.raises(FieldError, match="not joined"):
        CircleFunction(mesh, theta, jumps).periods(np.array([0, mesh.n_vertices - 1]))
