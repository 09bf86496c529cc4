"""Pictures of sheets: colours, cuts and vectors are those of the cover, and something is drawn."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

from geoweave import viz
from geoweave.errors import RenderError
from geoweave.fields.rosy import smoothest_rosy
from geoweave.foliation.foliation import foliate
from geoweave.foliation.level_sets import isolines
from geoweave.models import shapes
from geoweave.viz import sheets
from geoweave.weave.cover import Cover, branched_cover

FIVE_SIXTHS = float(np.degrees(np.arcsin(5 / 6)))
"""Half angle of the cone whose sides, unrolled, leave out a sixth of a turn: a corner of the icosahedron."""


@cache
def corner() -> Cover:
    return branched_cover(smoothest_rosy(shapes.cone(FIVE_SIXTHS, faces=125)))


def test_opposite_sheets_share_a_hue() -> None:
    assert len(set(viz.sheet_colours(6))) == 6
    assert viz.sheet_colours(6)[:3] == viz.style.FAMILIES[:3]
    assert viz.sheet_names(6) == ("A", "B", "C", "−A", "−B", "−C")
    assert viz.sheet_colours(5) == viz.style.FAMILIES
    assert viz.sheet_names(5) == ("A", "B", "C", "D", "E")


def test_across_the_cut_each_sheet_leads_to_the_next() -> None:
    cover = corner()
    edges, sheet = viz.cut_edges(cover)
    assert len(edges) % 6 == 0
    # all on the same side of the cut, so that once round is one step
    faces = cover.mesh.edge_faces[edges]
    x, y = (cover.mesh.barycenters[faces] @ axis for axis in np.eye(3)[:2])
    forward = x[:, 0] * y[:, 1] - y[:, 0] * x[:, 1] > 0
    step = (sheet[:, 1] - sheet[:, 0]) % 6
    assert len(set(np.where(forward, step, -step % 6).tolist())) == 1
    assert set(step.tolist()) <= {1, 5}


def test_arrows_and_lines_are_of_their_sheet() -> None:
    cover = corner()
    arrows = viz.sheet_arrows(cover, length=0.1)
    assert [len(each.points) for each in arrows] == [len(cover.part.faces)] * 6
    np.testing.assert_allclose(np.linalg.norm(arrows[2].vectors, axis=1), 0.1)
    found = cover.quotient.lifted(foliate(cover.quotient.field, alternations=2))
    leaves = isolines(found)
    lines = viz.family_lines(cover, leaves)
    pieces = [np.asarray(each.what) for each in lines]
    total = sum(np.linalg.norm(each[:, 1] - each[:, 0], axis=1).sum() for each in pieces)
    assert total == pytest.approx(leaves.lengths.sum())
    with pytest.raises(RenderError, match="another mesh"):
        viz.family_lines(cover, cover.project(leaves))


def test_rosettes_keep_their_distance() -> None:
    mesh = shapes.sphere(1280)
    chosen = mesh.barycenters[sheets.spread(mesh, 0.3)]
    apart = np.linalg.norm(chosen[:, None] - chosen, axis=2) + 9 * np.eye(len(chosen))
    assert apart.min() > 0.3
    # and leave no room for another
    assert np.linalg.norm(mesh.barycenters[:, None] - chosen, axis=2).min(axis=1).max() <= 0.3


def test_scenes_draw() -> None:
    cover = corner()
    found = cover.quotient.lifted(foliate(cover.quotient.field, alternations=2))
    view = viz.View(azimuth=20, elevation=40)
    stack = viz.stacked_sheets(cover, view, rise=0.4, flatten=0.2)
    scenes = [viz.rosy_scene(cover.rosy, view), viz.theta_scene(cover, found, view), stack]
    picture = viz.gallery(scenes, [("a", ""), ("b", ""), ("c", "")], width=600, accents=viz.sheet_colours(6))
    assert np.ptp(picture.pixels.reshape(-1, 3), axis=0).min() > 100
    for scene in scenes:
        pixels = scene.draw(120)
        assert 0.1 < (pixels < 250).any(axis=2).mean() < 1.0
    with pytest.raises(RenderError, match="lift it"):
        viz.theta_scene(cover, foliate(cover.quotient.field, alternations=1), view)
