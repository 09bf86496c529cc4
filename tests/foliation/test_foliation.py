"""From fields to functions on the circle: known foliations, falling energies, positive factors."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from surfaces import surface

import geoweave as gw
from geoweave.errors import FieldError, MeshError
from geoweave.fields.face_field import FaceField
from geoweave.fields.geodesic import INTEGRABLE_END, sharpening_schedule
from geoweave.fields.singularities import vertex_indices
from geoweave.foliation.foliation import edge_prediction, foliate, global_scale, punctured
from geoweave.foliation.integrability import perpendicular
from geoweave.models import shapes
from geoweave.surface.mesh import TriMesh

NAMES = ("jagged sphere", "genus 5", "Schwarz-P", "two pieces", "disk")


def designed(name: str) -> FaceField:
    mesh = surface(name)
    schedule = sharpening_schedule(mesh, finest=INTEGRABLE_END)
    return gw.geodesic_field(gw.smoothest_field(mesh), smoothness=schedule).field


def test_straight_lines_in_the_plane() -> None:
    mesh = surface("disk")
    field = FaceField.from_ambient(mesh, np.tile([0.6, 0.8, 0.0], (mesh.n_faces, 1)))
    found = foliate(field)
    assert found.part.mesh.n_faces == mesh.n_faces
    np.testing.assert_allclose(found.circle.gradient, found.s * perpendicular(field), rtol=1e-6)
    np.testing.assert_allclose(found.s, found.s.mean(), rtol=1e-6)
    assert found.alignment.dislocations == 0
    assert found.energies[-1] < 1e-9


@pytest.mark.parametrize("turns", [3, 8])
def test_rays_of_an_annulus_come_round(turns: int) -> None:
    """grad theta = turns / r: at the right scale all level sets are rays, as many as asked for."""
    mesh = shapes.annulus(0.4, 1.0, faces=3000)
    field = FaceField.from_ambient(mesh, mesh.barycenters).normalized()
    s = 1.0 / np.linalg.norm(mesh.barycenters, axis=1)
    found = foliate(field, rescaling=s, scale=turns / global_scale(field, s), quantile=1.0)
    periods = [found.circle.periods(loop) for loop in found.part.mesh.boundary_loops]
    np.testing.assert_allclose(np.abs(periods), turns, atol=1e-9)
    assert found.alignment.p95 < 1.0  # the faces are flat, the circles are not: half a degree here
    # theta is linear on faces, 1 / r is not
    np.testing.assert_allclose(found.s * np.linalg.norm(mesh.barycenters, axis=1), turns, rtol=0.05)


def test_a_scale_between_two_integers_goes_to_the_nearer() -> None:
    mesh = shapes.annulus(0.4, 1.0, faces=3000)
    field = FaceField.from_ambient(mesh, mesh.barycenters).normalized()
    s = 1.0 / np.linalg.norm(mesh.barycenters, axis=1)
    for wanted, turns in ((6.3, 6), (6.7, 7)):
        found = foliate(field, rescaling=s, scale=wanted / global_scale(field, s), quantile=1.0)
        assert abs(found.circle.periods(found.part.mesh.boundary_loops[0])) == pytest.approx(turns)


@pytest.mark.parametrize("name", NAMES)
def test_a_foliation_is_positive_aligned_and_lower(name: str) -> None:
    field = designed(name)
    found = foliate(field)
    assert found.s.min() > 0
    assert (np.diff(found.energies) <= 1e-12 * found.energies[0]).all()
    assert len(found.energies) == len(found.theta_changes) + 1 == len(found.s_changes) + 1 <= 11
    # coarse meshes and few faces: what matters is that level sets follow the field at all
    assert found.alignment.median < 8.0
    singular = vertex_indices(field) != 0
    assert set(found.part.vertices) == set(np.flatnonzero(~singular)) & set(
        field.mesh.faces[found.part.kept].ravel()
    )


@pytest.mark.parametrize("name", ["jagged sphere", "genus 5"])
def test_the_papers_own_variant_runs_too(name: str) -> None:
    found = foliate(designed(name), rescaling="eigenvector", weighting="uniform", quantile=1.0)
    assert found.s.min() > 0
    assert (np.diff(found.energies) <= 1e-12 * found.energies[0]).all()
    turn = np.abs(edge_prediction(found.field, found.s))
    assert turn.max() < 2 * np.pi  # half a turn before the alternations


def test_the_factor_and_the_relative_weights_pay() -> None:
    """Without an s, at the same frequency, level sets leave the field by more (Section 4.2.5)."""
    field = designed("genus 5")
    ours, bare = foliate(field), foliate(field, rescaling=None, steps="theta")
    per_length = [np.average(np.abs(f.circle.gradient), weights=f.part.mesh.face_areas) for f in (ours, bare)]
    bare = foliate(field, rescaling=None, steps="theta", scale=per_length[0] / per_length[1])
    assert ours.alignment.mean < 0.8 * bare.alignment.mean


def test_turned_scaled_and_repeated() -> None:
    field = designed("genus 5")
    found = foliate(field)
    again = foliate(FaceField(field.mesh, 4.0 * field.values))
    np.testing.assert_array_equal(again.circle.theta, found.circle.theta)
    np.testing.assert_array_equal(again.s, found.s)
    large = TriMesh(100.0 * field.mesh.vertices, field.mesh.faces)
    scaled = foliate(FaceField(large, field.values))
    np.testing.assert_allclose(scaled.s, found.s / 100.0, rtol=1e-4)
    assert scaled.alignment.dislocations == found.alignment.dislocations


def test_finer_frequencies_by_scale() -> None:
    field = designed("genus 5")
    mean = [foliate(field, scale=scale).s.mean() for scale in (1.0, 2.0)]
    assert mean[1] == pytest.approx(2.0 * mean[0], rel=0.1)


def test_half_a_turn_on_the_longest_edge() -> None:
    """Footnote 4: rho is the largest change along an edge of a face, and s goes to pi / rho times itself."""
    field, _ = punctured(designed("genus 5"))
    s = np.linspace(1.0, 2.0, field.mesh.n_faces)
    along = (perpendicular(field).conj()[:, None] * field.mesh.halfedge_vectors).real
    factor = global_scale(field, s)
    assert np.abs(factor * s[:, None] * along).max() == pytest.approx(np.pi)
    assert global_scale(field, s, 0.95) > factor


def test_what_is_out_of_range_is_refused() -> None:
    field = designed("disk")
    for arguments, word in (
        ({"scale": 0.0}, "scale"),
        ({"scale": np.nan}, "scale"),
        ({"alternations": 0}, "alternation"),
        ({"weighting": "odd"}, "weighting"),
        ({"steps": "odd"}, "steps"),
        ({"quantile": 0.0}, "quantile"),
        ({"rescaling": np.zeros(field.mesh.n_faces)}, "positive"),
        ({"rescaling": np.ones(3)}, "positive"),
    ):
        with pytest.raises(FieldError, match=word):
            foliate(field, **arguments)  # type: ignore[arg-type]


def test_a_surface_that_is_all_singular_is_refused() -> None:
    ball = shapes.icosahedron()
    # alternate directions leave a singularity at every vertex
    rng = np.random.default_rng(0)
    for _ in range(200):
        field = FaceField(ball, np.exp(2j * np.pi * rng.random(20)))
        if (vertex_indices(field) != 0)[ball.faces].any(axis=1).all():
            break
    else:
        pytest.fail("no such field among 200")
    with pytest.raises(MeshError, match="all 20 faces touch"):
        punctured(field)


def test_a_scale_too_small_for_the_surface_is_refused() -> None:
    with pytest.raises(FieldError, match="larger scale"):
        foliate(designed("jagged sphere"), scale=0.001)


def test_in_turns_goes_on_where_both_together_have_settled() -> None:
    """The paper's own alternation: no step in both. It lowers the energy too, but more slowly at first."""
    field = gw.geodesic_field(gw.smoothest_field(gw.shapes.sphere(faces=320)), phases=4).field
    asked: dict[str, Any] = {"alternations": 12, "tolerance": -1.0}
    together, turns = gw.foliate(field, **asked), gw.foliate(field, steps="turns", **asked)
    for found in (together, turns):
        assert len(found.theta_changes) == 12, "a negative tolerance ends nothing"
        assert (np.diff(found.energies) <= 1e-12 * found.energies[0]).all()
    assert turns.energies[2] > together.energies[2]
    held = gw.foliate(field, steps="theta", alternations=3)
    assert (held.s == gw.foliate(field, steps="theta", alternations=1).s).all()
    assert (turns.s != held.s).any()
