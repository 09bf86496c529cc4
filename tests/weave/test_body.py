"""Ribbons in space: as wide and thick as asked, flat where they cross, closed, clear of each other."""

from __future__ import annotations

import base64

import numpy as np
import pytest
from laidflat import cone

from geoweave.errors import FieldError
from geoweave.fabrication.glb import ribbon_bodies as fabrication_bodies, solid_ribbons
from geoweave.fabrication.guide_payload import shape
from geoweave.viz.solids import ribbon_bodies as picture_bodies
from geoweave.weave.body import CLEAR, Body, Centreline, bodies

WIDTH, THICK = 4.0, 0.5


def line(points: list[tuple[float, float, float]], closed: bool = False) -> Centreline:
    return Centreline(np.array(points, dtype=float), np.tile([0.0, 0.0, 1.0], (len(points), 1)), closed)


def cross(apart: float = 0.0, over: int = 0) -> tuple[Body, ...]:
    """Two straight ribbons at a right angle, the first one higher by ``apart``."""
    one = line([(-50, 0, apart / 2), (50, 0, apart / 2)])
    two = line([(0, -50, -apart / 2), (0, 50, -apart / 2)])
    met = np.array([[0, 1]]), np.array([[50.0, 50.0]]), np.array([over])
    return bodies([one, two], *met, width=WIDTH, thickness=THICK)


def grid() -> tuple[Body, ...]:
    """A ribbon along x under and over three that cross it, 12 apart."""
    lines = [line([(-20, 0, 0), (20, 0, 0)]), *(line([(x, -20, 0), (x, 20, 0)]) for x in (-12, 0, 12))]
    places = np.array([[20.0 + x, 20.0] for x in (-12, 0, 12)])
    met = np.array([[0, 1], [0, 2], [0, 3]]), places, np.array([0, 1, 0])
    return bodies(lines, *met, width=WIDTH, thickness=THICK)


def ring(count: int = 90, radius: float = 30.0) -> tuple[Body, ...]:
    angle = 2 * np.pi * np.arange(count) / count
    points = radius * np.stack([np.cos(angle), np.sin(angle), 0 * angle], axis=1)
    middle = angle + np.pi / count
    normals = np.stack([np.cos(middle), np.sin(middle), 0 * angle], axis=1)
    none = np.zeros((0, 2), dtype=np.int64), np.zeros((0, 2)), np.zeros(0, dtype=np.int64)
    return bodies([Centreline(points, normals, True)], *none, width=WIDTH, thickness=THICK)


@pytest.mark.parametrize("made", [cross(), grid(), ring()], ids=["cross", "grid", "ring"])
def test_every_body_is_a_closed_surface_with_its_width_and_thickness(made: tuple[Body, ...]) -> None:
    for body in made:
        corners = body.corners
        np.testing.assert_allclose(np.linalg.norm(corners[:, 1] - corners[:, 0], axis=1), WIDTH)
        np.testing.assert_allclose(np.linalg.norm(corners[:, 3] - corners[:, 0], axis=1), THICK)
        vertices, quads = body.solid()
        edges = np.concatenate([quads[:, [k, (k + 1) % 4]] for k in range(4)])
        forward = {tuple(edge) for edge in edges.tolist()}
        assert len(forward) == len(edges)  # no edge twice the same way
        assert all((b, a) in forward for a, b in forward)  # and every one back
        # The volume is positive, so faces look outwards; it is that of a rectangle swept along the line.
        parts = [vertices[quads[:, [0, k, k + 1]]] for k in (1, 2)]
        volume = sum(float(np.linalg.det(part).sum()) / 6 for part in parts)
        assert volume == pytest.approx(body.at[-1] * WIDTH * THICK, rel=0.02)


@pytest.mark.parametrize(("apart", "wanted"), [(0.0, CLEAR), (THICK, CLEAR), (-0.25, CLEAR), (1.5, 3.0)])
@pytest.mark.parametrize("over", [0, 1])
def test_ribbons_are_moved_apart_by_what_is_missing(apart: float, wanted: float, over: int) -> None:
    one, two = cross(apart if over == 0 else -apart, over)
    heights = [float(body.centre[np.argmin(np.abs(body.at - 50.0)), 2]) for body in (one, two)]
    assert (heights[0] - heights[1]) * (1 if over == 0 else -1) == pytest.approx(wanted * THICK)


def test_a_ribbon_is_flat_across_a_crossing_and_never_steps_back_between_two() -> None:
    body = grid()[0]
    half = 0.5 * CLEAR * THICK
    height = body.centre[:, 2]
    for place, level in ((8.0, half), (20.0, -half), (32.0, half)):
        near = np.abs(body.at - place) <= 0.5 * WIDTH
        assert near.sum() >= 3
        np.testing.assert_allclose(height[near], level, atol=1e-12)
    falling = height[(body.at >= 8.0) & (body.at <= 20.0)]
    assert (np.diff(falling) <= 1e-12).all()
    np.testing.assert_allclose(height[body.at <= 8.0], half)  # level up to its end


def test_a_closed_ribbon_comes_back_to_its_first_section() -> None:
    (body,) = ring()
    np.testing.assert_allclose(body.centre[0], body.centre[-1], atol=1e-12)
    np.testing.assert_allclose(body.up[0], body.up[-1], atol=1e-12)
    # Thickness points away from the middle, width along the axis.
    np.testing.assert_allclose((body.centre * body.up).sum(axis=1), 30.0, rtol=2e-3)
    np.testing.assert_allclose(np.abs(body.side[:, 2]), 1.0, rtol=1e-9)


def test_frames_are_orthonormal() -> None:
    for body in (*grid(), *ring()):
        frame = np.stack([body.ahead, body.side, body.up], axis=1)
        np.testing.assert_allclose(
            frame @ frame.swapaxes(1, 2), np.tile(np.eye(3), (len(frame), 1, 1)), atol=1e-9
        )
        np.testing.assert_allclose(np.linalg.det(frame), 1.0)


@pytest.mark.parametrize("wrong", [{"width": 0.0}, {"thickness": -1.0}, {"step": float("nan")}])
def test_refusals(wrong: dict[str, float]) -> None:
    none = np.zeros((0, 2), dtype=np.int64), np.zeros((0, 2)), np.zeros(0, dtype=np.int64)
    with pytest.raises(FieldError, match=f"the {next(iter(wrong))} of a ribbon in space"):
        bodies([line([(0, 0, 0), (9, 0, 0)])], *none, **{"width": 1.0, "thickness": 0.1, **wrong})


def test_glb_guide_and_pictures_draw_the_same_body() -> None:
    weave = cone()
    glb = fabrication_bodies(weave)
    unit = weave.placement.scale
    # On a faceted surface pictures take smooth normals, so a lift may lean by some degrees of its height.
    near = 0.25 * weave.thickness * unit
    for drawn, body in zip(picture_bodies(weave), glb, strict=True):
        assert drawn.closed == body.closed
        np.testing.assert_allclose(unit * drawn.at, body.at, atol=1e-9 * body.at[-1])
        np.testing.assert_allclose(weave.placement.undo(drawn.centre), body.centre, atol=near)
        assert (unit * drawn.width, unit * drawn.thickness) == pytest.approx((body.width, body.thickness))
    packed = shape(weave, weave.names)
    low, step = np.array(packed["low"]), packed["unit"]
    places = low + step * np.frombuffer(base64.b64decode(packed["places"]), dtype="<u2").reshape(-1, 3)
    centres = np.concatenate([body.centre for body in glb])
    np.testing.assert_allclose(places, centres, atol=0.5 * step + 1e-6)
    for body, solid in zip(glb, solid_ribbons(weave), strict=True):
        corners = {tuple(each) for each in np.round(body.corners.reshape(-1, 3), 9) + 0.0}
        assert {tuple(each) for each in np.round(solid.vertices, 9) + 0.0} == corners
