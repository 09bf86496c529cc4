"""Faults that stay are named with their places, and sound surfaces are said nothing about."""

import numpy as np
import pytest

from geoweave.meshing.faults import faults
from geoweave.meshing.prepare import prepare_arrays
from geoweave.models import datasets, shapes
from geoweave.surface import TriMesh

FLAT = np.array([[0, 0, 0], [2, 0, 0], [2, 2, 0], [0, 2, 0.0]])


def halves(gap: float, *, middle: bool) -> tuple[np.ndarray, np.ndarray]:
    """Two squares side by side; the right one has, or lacks, a corner in the middle of the seam."""
    right = FLAT + [2 + gap, 0, 0]
    points = np.concatenate([FLAT, right, [[2 + gap, 1, 0]]] if middle else [FLAT, right])
    left = [[0, 1, 2], [0, 2, 3]]
    return points, np.array(
        [*left, [4, 5, 8], [8, 5, 6], [8, 6, 7]] if middle else [*left, [4, 5, 6], [4, 6, 7]]
    )


@pytest.mark.parametrize("scale", [1e-6, 1.0, 1e6])
@pytest.mark.parametrize("gap", [0.0, 1e-9, 1e-6, 1e-5])
def test_a_crack_narrow_beside_its_edges_is_welded(gap, scale):
    points, faces = halves(gap, middle=False)
    prepared = prepare_arrays(scale * points, faces)
    assert prepared.mesh.n_components == 1
    assert prepared.report.welded_vertices == 2
    assert prepared.report.notes == ()


def test_a_wider_gap_is_a_gap():
    prepared = prepare_arrays(*halves(1e-3, middle=False))
    assert prepared.mesh.n_components == 2
    assert prepared.report.notes == ()


def test_fine_open_edges_are_not_welded_to_each_other():
    """A strip as narrow as a crack, with edges as short as it is wide, keeps its shape."""
    n = 200
    x = 1e-5 * np.arange(n)
    fine = np.concatenate([[[x_, y, 0] for x_ in x] for y in (0.0, 1e-5)])
    i = np.arange(n - 1)
    strip = np.concatenate([np.stack([i, i + 1, i + n], 1), np.stack([i + 1, i + n + 1, i + n], 1)])
    points = np.concatenate([fine, FLAT + [5, 5, 5]])
    prepared = prepare_arrays(points, np.concatenate([strip, np.array([[0, 1, 2], [0, 2, 3]]) + 2 * n]))
    assert prepared.report.welded_vertices == 0
    assert prepared.mesh.n_vertices == len(points)


def test_a_corner_on_the_side_of_an_edge_is_named_with_its_place():
    (note,) = prepare_arrays(*halves(0.0, middle=True)).report.notes
    assert "1 corner of open edges lies on the side of another open edge" in note
    assert "first at (2, 1, 0)" in note


def test_sheets_that_meet_in_corners_only_have_no_fault():
    points = np.concatenate([FLAT, FLAT + [2, 2, 0]])
    assert prepare_arrays(points, np.array([[0, 1, 2], [0, 2, 3], [4, 5, 6], [4, 6, 7]])).report.notes == ()


def test_dust_is_counted_and_placed():
    ball = shapes.icosahedron(80)
    grains = 0.001 * ball.vertices + np.arange(200, 500)[:, None, None] * [0.01, 0, 0]
    points = np.concatenate([ball.vertices, grains.reshape(-1, 3)])
    faces = ball.faces + ball.n_vertices * np.arange(301)[:, None, None]
    (note,) = prepare_arrays(points, faces.reshape(-1, 3)).report.notes
    assert "300 of 301 components are smaller than a hundredth" in note
    assert "first at (2, " in note
    report = prepare_arrays(points, faces.reshape(-1, 3), components="largest").report
    assert (report.dropped_components, report.notes) == (300, ())


@pytest.mark.parametrize("name", datasets.names()[:4])
def test_scans_have_no_faults(name: str) -> None:
    assert faults(datasets.load(name)) == ()


@pytest.mark.parametrize(
    "surface",
    [shapes.schwarz_p(faces=2_000), shapes.annulus(), shapes.cone(), shapes.square(), shapes.saddle()],
)
def test_open_surfaces_have_no_faults(surface: TriMesh) -> None:
    assert faults(surface) == ()
