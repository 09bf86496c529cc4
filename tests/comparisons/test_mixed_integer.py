"""Mixed-integer integration: known periods, no dislocations, rounding against brute force."""

import itertools

import numpy as np
import pytest
from surfaces import ALL, surface, two_pieces

from geoweave.comparisons.mixed_integer import greedy_rounding, mixed_integer_parameterization
from geoweave.errors import FieldError
from geoweave.fields.face_field import FaceField, random_field
from geoweave.fields.operators import ClosedFields, as_real, field_mass
from geoweave.foliation.circle_function import TURN, CircleFunction
from geoweave.foliation.level_set_alignment import alignment
from geoweave.models import shapes
from geoweave.surface.mesh import TriMesh
from geoweave.surface.submesh import part_of


def levels_of(circle: CircleFunction) -> tuple[FaceField, np.ndarray]:
    """The unit field along the level sets of theta, and the scale that makes it exact."""
    scale = np.abs(circle.gradient)
    return FaceField(circle.mesh, 1j * circle.gradient / scale), scale


def angles(mesh: TriMesh) -> np.ndarray:
    return np.arctan2(mesh.vertices[:, 1], mesh.vertices[:, 0])


def wound(mesh: TriMesh, around: int, through: int = 0) -> CircleFunction:
    """An angle that turns so often round the z axis, and (on a torus of radii 1 and 0.4) round its tube."""
    theta = around * angles(mesh)
    if through:
        ring = np.linalg.norm(mesh.vertices[:, :2], axis=1)
        theta = theta + through * np.arctan2(mesh.vertices[:, 2], ring - ring.mean())
    return CircleFunction.nearest(mesh, theta, np.zeros(mesh.n_edges))


@pytest.mark.parametrize("anisotropy", [1.0, 0.001])
@pytest.mark.parametrize("name", ["annulus", "cylinder"])
def test_known_periods(name: str, anisotropy: float) -> None:
    mesh = surface(name)
    exact = wound(mesh, 7)
    field, scale = levels_of(exact)
    found = mixed_integer_parameterization(field, scale, anisotropy=anisotropy)
    np.testing.assert_allclose(found.jumps, exact.jumps, atol=1e-8)
    # 3 % more frequency asks for 7.2 turns, and gets 7.
    found = mixed_integer_parameterization(field, 1.03 * scale, anisotropy=anisotropy)
    turns = [found.periods(loop) for loop in mesh.boundary_loops]
    np.testing.assert_allclose(np.sort(turns), [-7.0, 7.0], atol=1e-9)


def test_helices_on_a_cylinder() -> None:
    mesh = surface("cylinder")
    values = 6.0 * mesh.vertices[:, 2]
    theta = wound(mesh, 5).theta + values
    tail, head = mesh.edges.T
    exact = CircleFunction.nearest(mesh, theta, values[head] - values[tail])
    found = mixed_integer_parameterization(*levels_of(exact))
    np.testing.assert_allclose(found.jumps, exact.jumps, atol=1e-8)


def test_two_periods_of_a_torus() -> None:
    mesh = shapes.torus(1.0, 0.4, faces=1500)
    exact = wound(mesh, 9, -4)
    field, scale = levels_of(exact)
    found = mixed_integer_parameterization(field, scale)
    np.testing.assert_allclose(found.jumps, exact.jumps, atol=1e-8)
    assert not exact.dislocated.any()
    assert alignment(field, found).mean < 1e-5


@pytest.mark.parametrize("name", ALL)
def test_seamless_on_every_surface(name: str) -> None:
    mesh = surface(name)
    found = mixed_integer_parameterization(random_field(mesh), 20.0, anisotropy=0.1)
    # No dislocation: exactly closed on every face, and whole turns along every closed path.
    np.testing.assert_allclose(found.corner_jumps.sum(axis=1), 0.0, atol=1e-9)
    tail, head = mesh.edges.T
    turns = (found.jumps - found.theta[head] + found.theta[tail]) / TURN
    np.testing.assert_allclose(turns, np.rint(turns), atol=1e-9)


@pytest.mark.parametrize("anisotropy", [1.0, 0.01])
def test_no_other_vertex_values_are_better(anisotropy: float) -> None:
    mesh = surface("Schwarz-P")
    field, scale = random_field(mesh, 1), 12.0
    found = mixed_integer_parameterization(field, scale, anisotropy=anisotropy)
    closed = ClosedFields(mesh)

    def energy(gradient: np.ndarray) -> float:
        off = gradient - -1j * scale * field.values
        along, across = (off * field.values.conj()).real, (off * field.values.conj()).imag
        return float(mesh.face_areas @ (along**2 + anisotropy * across**2))

    changes = closed.basis[:, : len(closed.free_vertices) : 37].toarray().T.copy().view(np.complex128)
    best = energy(found.gradient)
    for change in changes:
        assert min(energy(found.gradient + 1e-3 * change), energy(found.gradient - 1e-3 * change)) > best


def test_greedy_rounding_against_brute_force() -> None:
    rng = np.random.default_rng(5)
    best_found = 0
    for _ in range(60):
        root = rng.normal(size=(6, 3))
        matrix, right = root.T @ root, rng.normal(size=3) * 8.0
        values, relaxed, rise = greedy_rounding(matrix, right)
        costs = [
            0.5 * (k - relaxed) @ matrix @ (k - relaxed)
            for k in np.rint(relaxed) + np.array(list(itertools.product(range(-4, 5), repeat=3)))
        ]
        own = 0.5 * (values - relaxed) @ matrix @ (values - relaxed)
        assert own == pytest.approx(rise, rel=1e-9)
        assert min(costs) <= own * (1 + 1e-9)
        assert own <= np.trace(matrix) / 8.0
        best_found += own <= min(costs) * (1 + 1e-9)
    # Greedy has no guarantee to be best, but should be most of the time.
    assert best_found >= 45


def test_rounding_of_independent_variables_is_best() -> None:
    values, relaxed, rise = greedy_rounding(np.diag([1.0, 4.0, 9.0]), np.array([0.4, 6.0, -11.0]))
    assert values.tolist() == [0, 2, -1]
    np.testing.assert_allclose(relaxed, [0.4, 1.5, -11 / 9])
    assert rise == pytest.approx(0.5 * (0.16 + 4 * 0.25 + 9 * (2 / 9) ** 2))


def test_without_generators_it_is_a_poisson_problem() -> None:
    mesh = surface("disk")
    field = random_field(mesh)
    found = mixed_integer_parameterization(field, 3.0)
    rest = field_mass(mesh) @ as_real(found.gradient - -3j * field.values)
    np.testing.assert_allclose(ClosedFields(mesh).basis_transposed @ rest, 0.0, atol=1e-9)
    assert greedy_rounding(np.zeros((0, 0)), np.zeros(0)).values.shape == (0,)


def test_components_do_not_see_each_other() -> None:
    mesh = two_pieces().normalized()[0]
    field = random_field(mesh)
    found = mixed_integer_parameterization(field, 9.0)
    for number in range(mesh.n_components):
        alone = part_of(mesh, mesh.face_components == number)
        own = mixed_integer_parameterization(FaceField(alone.mesh, field.values[alone.faces]), 9.0)
        np.testing.assert_allclose(found.gradient[alone.faces], own.gradient, atol=1e-8)


def test_bad_input_is_refused() -> None:
    field = random_field(surface("disk"))
    with pytest.raises(FieldError, match="a scale is one finite number"):
        mixed_integer_parameterization(field, np.ones(3))
    with pytest.raises(FieldError, match="above 0 and at most 1, not 0"):
        mixed_integer_parameterization(field, 1.0, anisotropy=0.0)
