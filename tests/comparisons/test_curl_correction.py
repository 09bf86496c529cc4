"""Local curl correction: its curl is exact where it can be, it is lowered, and s fails near singularities."""

import numpy as np
import pytest
from surfaces import surface, two_pieces

from geoweave.comparisons.curl_correction import Measure, curl_corrected_scale, local_curl
from geoweave.errors import FieldError
from geoweave.fields.face_field import FaceField
from geoweave.models import shapes
from geoweave.surface.mesh import TriMesh
from geoweave.surface.submesh import part_of

MEASURES: tuple[Measure, ...] = ("relative", "absolute")


def error(scale: np.ndarray, truth: np.ndarray, mesh: TriMesh) -> float:
    """Relative L2 distance after the best multiple."""
    areas = mesh.face_areas
    factor = (areas @ (scale * truth)) / (areas @ scale**2)
    return float(np.sqrt((areas @ (factor * scale - truth) ** 2) / (areas @ truth**2)))


def radial(mesh: TriMesh) -> FaceField:
    return FaceField.from_ambient(mesh, mesh.barycenters).normalized()


def meridians(mesh: TriMesh) -> FaceField:
    """The great circles through both poles of a sphere, from one to the other."""
    return FaceField.from_ambient(mesh, np.broadcast_to([0.0, 0, 1], (mesh.n_faces, 3))).normalized()


def test_curl_of_a_linear_field_in_the_plane() -> None:
    mesh = shapes.square(faces=800)
    field = FaceField.from_ambient(mesh, np.broadcast_to([0.6, 0.8, 0.0], (mesh.n_faces, 3)))
    # w-perp = (0.8, -0.6): curl (s w-perp) = d_x s (-0.6) - d_y s 0.8, exactly, for a linear s.
    curl = local_curl(field) @ (2.0 + mesh.vertices @ [3.0, -5.0, 0.0])
    np.testing.assert_allclose(curl, 3.0 * -0.6 + 5.0 * 0.8, atol=1e-11)


def test_curl_of_circles_converges() -> None:
    errors = []
    for faces in (1000, 4000):
        mesh = shapes.annulus(0.4, 1.0, faces=faces)
        # w-perp of the radial field runs clockwise round the centre; its curl is -1 / r.
        curl = local_curl(radial(mesh)) @ np.ones(mesh.n_vertices)
        exact = -1.0 / np.linalg.norm(mesh.barycenters, axis=1)
        errors.append(np.sqrt(np.average((curl - exact) ** 2, weights=mesh.face_areas)))
    # The corners of a coarser row differ: at least first order.
    assert errors[1] < 0.6 * errors[0]


@pytest.mark.parametrize("measure", MEASURES)
def test_known_scale_of_an_annulus(measure: Measure) -> None:
    mesh = shapes.annulus(0.4, 1.0, faces=4000).normalized()[0]
    scale = curl_corrected_scale(radial(mesh), measure=measure)
    # Away from the singularity s = 1 / r is smooth, and the local correction finds it: 0.001 measured.
    assert error(scale, 1.0 / np.linalg.norm(mesh.barycenters, axis=1), mesh) < 0.003


def tube_circles(mesh: TriMesh) -> FaceField:
    """The circles round the tube of a torus about the z axis."""
    hoop = np.cross([0.0, 0, 1], mesh.barycenters)
    return FaceField.from_ambient(mesh, np.cross(hoop, mesh.face_normals)).normalized()


def banded_sphere(hole: float) -> TriMesh:
    """A sphere without what lies nearer to its axis than the hole's radius."""
    ball = shapes.sphere(faces=5120)
    return part_of(ball, np.linalg.norm(ball.barycenters[:, :2], axis=1) > hole).mesh


@pytest.mark.parametrize("measure", MEASURES)
@pytest.mark.parametrize(
    "field",
    [radial(surface("annulus")), tube_circles(surface("torus")), meridians(banded_sphere(0.3))],
    ids=["annulus", "torus", "sphere"],
)
def test_it_lowers_the_local_curl(field: FaceField, measure: Measure) -> None:
    mesh, curl = field.mesh, local_curl(field)
    scale = curl_corrected_scale(field, measure=measure)
    assert (scale > 0).all()
    assert mesh.face_areas @ scale == pytest.approx(mesh.face_areas.sum())
    # Back to the vertices as an average, which at the boundary is one-sided.
    inner = ~mesh.boundary_vertices[mesh.faces].any(axis=1)
    corners = mesh.faces.ravel()
    at_vertices = np.bincount(corners, np.repeat(scale, 3)) / np.bincount(corners)
    after, before = curl @ at_vertices, curl @ np.ones(mesh.n_vertices)
    if measure == "relative":
        after /= scale
    norms = [np.sqrt(mesh.face_areas[inner] @ each[inner] ** 2) for each in (after, before)]
    # All of these can be freed of curl; what is left, up to 0.17, comes from averaging there and back.
    assert norms[0] < 0.25 * norms[1]


def test_near_singularities_it_fails() -> None:
    """Section 4.2.3: there "it is equally efficient to reduce curl by scaling", so s is made small."""
    mesh = banded_sphere(0.06)
    distance = np.linalg.norm(mesh.barycenters[:, :2], axis=1)
    scale = curl_corrected_scale(meridians(mesh))
    # The truth is 1 / distance to the axis; close to it the corrected scale stays less than half of that.
    assert np.median((scale * distance)[distance < 0.3]) < 0.5 * np.median((scale * distance)[distance > 0.6])


def test_components_do_not_see_each_other() -> None:
    pieces = two_pieces().normalized()[0]
    field = FaceField.from_ambient(pieces, np.broadcast_to([1.0, 0.3, 0.2], (pieces.n_faces, 3))).normalized()
    scale = curl_corrected_scale(field)
    for part in range(2):
        own = part_of(pieces, pieces.face_components == part)
        alone = curl_corrected_scale(FaceField(own.mesh, field.values[own.faces]))
        # 1e-6: the weight that keeps constants definite differs.
        np.testing.assert_allclose(scale[own.faces], alone, rtol=1e-6)


def test_a_constant_field_needs_no_correction() -> None:
    mesh = shapes.square(faces=800)
    field = FaceField.from_ambient(mesh, np.broadcast_to([1.0, 0, 0], (mesh.n_faces, 3)))
    for measure in MEASURES:
        np.testing.assert_allclose(curl_corrected_scale(field, measure=measure), 1.0, rtol=1e-6)


def test_bad_choices_are_refused() -> None:
    field = radial(surface("annulus"))
    with pytest.raises(FieldError, match="no measure 'least'"):
        curl_corrected_scale(field, measure="least")  # type: ignore[arg-type]
    with pytest.raises(FieldError, match="positive and finite, not -1"):
        curl_corrected_scale(field, smoothness=-1.0)
