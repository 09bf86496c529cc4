"""Theta in colours: the same from both sides of every edge, without a seam where it wraps."""

from __future__ import annotations

import numpy as np
import pytest
from surfaces import surface

from geoweave import viz
from geoweave.errors import RenderError
from geoweave.fields.operators import differences
from geoweave.foliation.circle_function import TURN, CircleFunction, wrapped
from geoweave.foliation.level_sets import isolines
from geoweave.models import shapes
from geoweave.surface.submesh import part_of
from geoweave.viz import style
from geoweave.viz.periodic import corner_angles

FROM_ABOVE = viz.View(azimuth=-90.0, elevation=90.0, up="z")


def random_circle(mesh, seed: int = 0) -> CircleFunction:
    rng = np.random.default_rng(seed)
    theta, change = rng.uniform(0, TURN, mesh.n_vertices), rng.normal(0, 3.0, mesh.n_edges)
    return CircleFunction.nearest(mesh, theta, change)


@pytest.mark.parametrize("name", ["jagged sphere", "disk", "two pieces"])
def test_both_faces_of_an_edge_see_the_same_angles_along_it(name):
    circle = random_circle(surface(name))
    assert circle.dislocated.any()
    mesh, angles = corner_angles(circle)
    assert mesh.n_faces == circle.mesh.n_faces + 2 * circle.dislocated.sum()
    tails, heads = angles[:, [1, 2, 0]].ravel(), angles[:, [2, 0, 1]].ravel()
    # only the spokes of cut faces jump: they lead to the vertices that were added
    outer = mesh.edges[mesh.interior_edges].max(axis=1) < circle.mesh.n_vertices
    along, against = mesh.edge_halfedges[mesh.interior_edges][outer].T
    np.testing.assert_allclose(
        heads[along] - tails[along], tails[against] - heads[against], atol=1e-12
    )  # the same change along the edge
    np.testing.assert_allclose(wrapped(tails[along] - heads[against]), 0, atol=1e-9)  # from the same angle
    at_vertex = mesh.faces < circle.mesh.n_vertices
    np.testing.assert_allclose(wrapped(angles[at_vertex] - circle.theta[mesh.faces[at_vertex]]), 0, atol=1e-9)


def test_what_lies_outside_the_part_has_no_angle():
    whole = surface("sphere")
    part = part_of(whole, whole.barycenters[:, 2] < 0.3)
    circle = random_circle(part.mesh)
    mesh, angles = corner_angles(circle, part)
    assert mesh.face_areas.sum() == pytest.approx(whole.face_areas.sum())
    plain = np.isnan(angles).all(axis=1)
    assert mesh.face_areas[plain].sum() == pytest.approx(whole.face_areas[~part.kept].sum())
    assert np.isfinite(angles[~plain]).all()
    with pytest.raises(RenderError, match="give the part it is on"):
        corner_angles(random_circle(whole), part)


def test_colours_are_those_of_the_wheel_and_show_no_seam():
    mesh = shapes.square(faces=32)  # far coarser than the wrapping of theta
    values = TURN * (2.1 * mesh.vertices[:, 0] + 0.7 * mesh.vertices[:, 1])
    circle = CircleFunction.nearest(mesh, wrapped(values), differences(mesh) @ values)
    scene = viz.Scene(FROM_ABOVE)
    viz.add_theta(scene, circle)
    pixels = scene.draw(320).astype(float)
    inside = (pixels < 255).any(axis=2)
    rows, columns = np.flatnonzero(inside.any(axis=1)), np.flatnonzero(inside.any(axis=0))
    picture = pixels[rows[4] : rows[-4], columns[4] : columns[-4]]
    # where the square's pixels lie in it
    y = 1 - 2 * (np.arange(rows[4], rows[-4]) + 0.5 - rows[0]) / (rows[-1] + 1 - rows[0])
    x = 2 * (np.arange(columns[4], columns[-4]) + 0.5 - columns[0]) / (columns[-1] + 1 - columns[0]) - 1
    turns = (2.1 * x[None] + 0.7 * y[:, None]) % 1.0
    wanted = 255 * style.cyclic()(turns)[..., :3]
    # a flat square is lit evenly, but for the light of the lens's opening: one gain for all
    gain = (picture * wanted).sum() / (wanted**2).sum()
    error = np.abs(picture - gain * wanted).max(axis=2)
    assert 0.7 < gain < 1.1
    assert np.quantile(error, 0.99) < 10


def test_a_gallery_shows_every_panel_and_its_words():
    mesh = shapes.annulus(0.4, 1.0, faces=600)
    angle = np.arctan2(mesh.vertices[:, 1], mesh.vertices[:, 0])
    circle = CircleFunction.nearest(mesh, 3 * angle, np.zeros(mesh.n_edges))
    panels = [
        viz.Periodic(circle, "theta", "three turns", view=FROM_ABOVE),
        viz.Periodic(circle, "level sets", coloured=False, curves=isolines(circle), view=FROM_ABOVE),
        viz.Periodic(circle, "mesh", edges=True, dots=True, coloured=False, view=FROM_ABOVE),
    ]
    picture = viz.periodic_gallery(panels, width=900)
    assert [text.get_text() for text in picture.figure.texts] == [
        "theta", "three turns", "level sets", "", "mesh", "",
    ]  # fmt: skip
    thirds = np.array_split(picture.pixels[: picture.pixels.shape[0] // 2], 3, axis=1)
    colours = [len(np.unique(each.reshape(-1, 3) // 32, axis=0)) for each in thirds]
    assert min(colours) > 5
    # all the colours of the wheel beside ink on one pale colour
    assert colours[0] > 2 * colours[1]
    narrow = viz.periodic_gallery(panels[:1], width=300)
    assert narrow.pixels.shape[1] == 300


def test_dislocations_are_marked():
    mesh = shapes.disk(faces=800)
    x, y = (mesh.vertices - mesh.barycenters[5]).T[:2]
    circle = CircleFunction.nearest(mesh, np.arctan2(y, x), np.zeros(mesh.n_edges))
    assert circle.dislocated.sum() == 1

    def amber(marked: bool) -> int:
        panel = viz.Periodic(circle, dislocations=marked, coloured=False, view=FROM_ABOVE)
        pixels = panel.scene().draw(400).astype(int)
        return int(((pixels[..., 0] > 150) & (pixels[..., 2] < 100)).sum())

    assert amber(False) == 0
    assert amber(True) > 10


def test_what_cannot_be_drawn_is_refused():
    with pytest.raises(RenderError, match="at least one panel"):
        viz.periodic_gallery([])
    with pytest.raises(RenderError, match="no view is kept"):
        viz.Periodic(random_circle(surface("disk")), view="giraffe")
