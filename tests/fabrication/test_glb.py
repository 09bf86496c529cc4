"""The GLB, read back by trimesh: a node per ribbon, its size, and the upper ribbon above the lower one."""

from __future__ import annotations

import io
from functools import cache

import numpy as np
import pytest
import trimesh
from laidflat import UP, bow_tie, circles, cone, crossing, document, flat, ribbon

from geoweave.errors import FieldError
from geoweave.fabrication.colours import FAMILIES
from geoweave.fabrication.glb import glb_bytes, ribbon_bodies, solid_ribbons
from geoweave.rods.weave_at_rest import relaxed_weave
from geoweave.weave.body import CLEAR


@cache
def scene(name: str) -> trimesh.Scene:
    weave = {"flat": flat, "circles": circles, "bow tie": bow_tie, "cone": cone}[name]()
    return trimesh.load(io.BytesIO(glb_bytes(weave)), file_type="glb", process=False)


@pytest.mark.parametrize("name", ["flat", "circles", "bow tie", "cone"])
def test_every_ribbon_is_a_node_and_a_closed_solid(name: str) -> None:
    weave = {"flat": flat, "circles": circles, "bow tie": bow_tie, "cone": cone}[name]()
    content = weave if isinstance(weave, dict) else weave.document()
    found = scene(name)
    labels = [each["label"] for each in content["ribbons"]]
    assert sorted(found.graph.nodes_geometry) == sorted(labels)
    drawn = zip(content["ribbons"], ribbon_bodies(content), solid_ribbons(content), strict=True)
    for each, body, made in drawn:
        assert made.label == each["label"]
        solid = trimesh.Trimesh(made.vertices, made.triangles, process=False)
        solid.merge_vertices(merge_norm=True)
        assert solid.is_winding_consistent
        assert solid.is_watertight
        # a rectangle swept along a line; at the corners of the bow tie it is mitred
        volume = each["length"] * content["width"] * content["thickness"]
        volume *= np.trapezoid(body.share, body.at) / body.at[-1]
        assert solid.volume == pytest.approx(volume, rel=0.1 if name == "bow tie" else 0.02)


@pytest.mark.parametrize("name", ["flat", "circles"])
def test_normals_point_outwards(name: str) -> None:
    for made in solid_ribbons({"flat": flat, "circles": circles}[name]()):
        corners = made.vertices[made.triangles]
        across = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        toward = made.normals[made.triangles].sum(axis=1)
        assert ((across * toward).sum(axis=1) > 0).all()
        np.testing.assert_allclose(np.linalg.norm(made.normals, axis=1), 1.0, atol=1e-9)


def test_metres_and_y_up() -> None:
    low, high = scene("flat").bounds
    # the plane z = 0 of the document is the plane y = 0 of the file
    assert high[1] - low[1] < 0.003
    assert 0.1 < high[0] - low[0] < 0.25
    assert 0.1 < high[2] - low[2] < 0.25


def test_the_upper_ribbon_lies_above_the_lower_one_without_touching() -> None:
    content = flat()
    made = solid_ribbons(content)
    for each in content["crossings"]:
        heights = []
        for side in (0, 1):
            line = np.array(content["ribbons"][each["ribbons"][side]]["points"])
            way = (line[1] - line[0]) / np.linalg.norm(line[1] - line[0])
            middle = line[0] + each["arclength"][side] * way
            vertices = made[each["ribbons"][side]].vertices
            along = np.abs((vertices - middle) @ way)
            near = vertices[along < along.min() + 1e-6]
            heights.append((near[:, 2].min(), near[:, 2].max()))
        above, below = heights[each["over_index"]], heights[1 - each["over_index"]]
        assert above[0] > below[1]
        assert above[1] - above[0] == pytest.approx(0.5)


def middles(name: str, found: trimesh.Scene, closed: bool) -> np.ndarray:
    """The middles of the cross sections of a ribbon of a GLB, in the order in which they are written."""
    vertices = np.asarray(found.geometry[name].vertices)
    blocks = (vertices if closed else vertices[:-8]).reshape(8, -1, 3)
    return blocks[[0, 1, 3, 5]].mean(axis=0)


def clearances(document: dict) -> np.ndarray:
    """Distance of the middles of the ribbons at each crossing of the GLB, upper less lower, thicknesses."""
    found = trimesh.load(io.BytesIO(glb_bytes(document)), file_type="glb", process=False)
    apart = []
    for each in document["crossings"]:
        places, ups = [], []
        for side in (0, 1):
            ribbon = document["ribbons"][each["ribbons"][side]]
            points, normals = np.array(ribbon["points"]), np.array(ribbon["normals"])
            ring = np.concatenate([points, points[:1]]) if ribbon["closed"] else points
            at = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(ring, axis=0), axis=1))])
            s = each["arclength"][side]
            here = np.array([np.interp(s, at, ring[:, axis]) for axis in range(3)])
            up = normals[min(np.searchsorted(at, s, side="right") - 1, len(points) - 1)]
            line = middles(ribbon["label"], found, ribbon["closed"]) - here
            across = line - np.outer(line @ up, up)
            places.append(here + line[np.argmin((across**2).sum(axis=1))])
            ups.append(up)
        up = sum(ups) / np.linalg.norm(sum(ups))
        apart.append((places[each["over_index"]] - places[1 - each["over_index"]]) @ up)
    return np.array(apart) / document["thickness"]


def test_ribbons_lie_as_far_apart_at_rest_as_on_the_surface() -> None:
    designed = cone()
    relaxed = relaxed_weave(designed).document()
    # where the surface bends under the ribbons, their middles are farther apart than their edges
    apart = clearances(designed.document())
    assert apart.min() > CLEAR - 0.05
    assert apart.max() < CLEAR + 0.7
    # at rest the rods lie a thickness apart, which must not be added to the lift of the surface; near the tip
    # wide strips lean against each other
    apart = clearances(relaxed)
    assert apart.min() > CLEAR - 0.15
    assert apart.max() < 5.0


@pytest.mark.parametrize(("there", "wanted"), [(0.0, CLEAR), (1.0, CLEAR), (-0.5, CLEAR), (3.0, 3.0)])
def test_what_lies_over_already_is_not_lifted_again(there: float, wanted: float) -> None:
    content = document(
        [
            ribbon("A1", 0, [(-50, 0, there / 4), (50, 0, there / 4)], UP),
            ribbon("B1", 1, [(0, -50, -there / 4), (0, 50, -there / 4)], UP),
        ],
        [crossing(0, 1, (50.0, 50.0), 0)],
    )
    assert content["thickness"] == 0.5
    np.testing.assert_allclose(clearances(content), wanted, rtol=1e-6)


def test_a_material_per_family() -> None:
    found = scene("flat")
    colours = {}
    for label, mesh in found.geometry.items():
        colours.setdefault(label[0], set()).add(tuple(mesh.visual.material.baseColorFactor[:3]))
    assert all(len(each) == 1 for each in colours.values())
    assert len(set.union(*colours.values())) == 3
    assert len(FAMILIES) >= 3


def test_the_same_weave_gives_the_same_bytes() -> None:
    assert glb_bytes(circles()) == glb_bytes(circles())


def test_refusals() -> None:
    with pytest.raises(FieldError, match="is not a geoweave-weave"):
        solid_ribbons({"format": "geoweave-pattern"})


def test_bodies_go_over_and_under_and_closed_ones_come_back() -> None:
    document = circles()
    half = 0.5 * CLEAR * document["thickness"]
    for r, body in enumerate(ribbon_bodies(document)):
        assert body.closed
        np.testing.assert_allclose(body.centre[0], body.centre[-1], atol=1e-9)
        for each in document["crossings"]:
            for side in (0, 1):
                if each["ribbons"][side] == r:
                    k = int(np.argmin(np.abs(body.at - each["arclength"][side])))
                    way = 1 if each["over_index"] == side else -1
                    lift = way * (np.linalg.norm(body.centre[k]) - 60.0)
                    assert half - 0.03 < lift < 2 * half


@pytest.mark.parametrize("content", [flat(), circles()], ids=["flat", "circles"])
def test_the_solids_are_those_of_the_bodies(content: dict) -> None:
    for body, made in zip(ribbon_bodies(content), solid_ribbons(content), strict=True):
        corners = {tuple(each) for each in np.round(body.corners.reshape(-1, 3), 9) + 0.0}
        assert {tuple(each) for each in np.round(made.vertices, 9) + 0.0} == corners
