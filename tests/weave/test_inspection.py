"""Places that will not weave are found where they were put, and not where there are none."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from itertools import chain

import numpy as np
import pytest

from geoweave.curves.curve_crossings import crossings
from geoweave.curves.curves import Curves
from geoweave.curves.straightest_geodesics import straightest
from geoweave.errors import FieldError
from geoweave.models import shapes
from geoweave.surface.mesh import Similarity, TriMesh
from geoweave.weave.design import weave_pattern
from geoweave.weave.inspection import KINDS, Inspection, Limits, Place, inspected
from geoweave.weave.ribbons import Cutting, Ribbons
from geoweave.weave.weave import Weave

SPACING = 0.2


@cache
def made() -> Weave:
    return weave_pattern(shapes.torus(faces=1500), scale=0.6)


@cache
def plate() -> TriMesh:
    """A flat square of side 2 about the origin."""
    ticks = np.linspace(-1, 1, 21)
    x, y = np.meshgrid(ticks, ticks, indexing="ij")
    corner = (np.arange(20)[:, None] * 21 + np.arange(20)).ravel()
    first = np.stack([corner, corner + 21, corner + 22], axis=1)
    second = np.stack([corner, corner + 22, corner + 1], axis=1)
    return TriMesh(np.stack([x.ravel(), y.ravel(), 0 * x.ravel()], axis=1), np.concatenate([first, second]))


def laid(
    lines: list[tuple[float, float, float]], *, width: float = 0.02, unit: float = 1.0, length: float = 3.0
) -> Weave:
    """A weave of straight lines on the plate: direction in degrees, and a point of each."""
    mesh = plate()
    points = np.array([[x, y, 0.0] for _, x, y in lines])
    angle = np.radians([each[0] for each in lines])
    corners = mesh.vertices[mesh.faces]
    edge = np.roll(corners, -1, axis=1) - corners
    to = points[:, None, None] - corners
    inside = (np.cross(edge, to)[..., 2] >= -1e-12).all(axis=2)
    faces = inside.argmax(axis=1)
    way = np.stack([np.cos(angle), np.sin(angle), 0 * angle], axis=1)
    curves = straightest(mesh, faces, way, length, points=points, behind=length)
    ribbons = Ribbons(curves, crossings(curves), np.arange(len(lines)), SPACING, Cutting())
    return replace(
        made(),
        placement=Similarity(np.zeros(3), unit),
        ribbons=ribbons,
        families=np.zeros(len(lines), dtype=np.int64),
        interlacing=replace(made().interlacing, over=np.zeros(len(ribbons.crossings), dtype=np.int64)),
        width=width,
    )


def of_kind(found: Inspection, kind: str) -> list[Place]:
    return [place for place in found.places if place.kind == kind]


def triaxial(phase: float) -> list[tuple[float, float, float]]:
    """Three families SPACING apart, the third shifted by a phase from where all three meet in points."""
    lines = []
    for turn, shift in ((0.0, 0.013), (60.0, 0.013), (120.0, phase)):
        normal = np.radians(turn + 90)
        for k in range(-6, 7):
            x, y = (k + shift) * SPACING * np.array([np.cos(normal), np.sin(normal)])
            if max(abs(x), abs(y)) < 0.99:
                lines.append((turn, x, y))
    return lines


def test_a_flat_even_weave_has_nothing_to_tell() -> None:
    found = inspected(laid(triaxial(0.5), width=0.9 * SPACING / 3))
    assert found.counts == dict.fromkeys(KINDS, 0)
    assert found.violations == ()
    # triangles of side d / sqrt 3, whose incircle is d / 3 wide
    assert found.suggested_width == pytest.approx(SPACING / 3)
    assert found.share_that_fits == 1.0
    assert all(width == pytest.approx(SPACING / 3) for _, width in found.widths)


def test_where_three_ribbons_cross_in_a_point_each_triangle_is_one_place() -> None:
    shift = 0.1  # triangles whose incircle is a fifth of those above
    found = inspected(laid(triaxial(shift), width=0.3 * SPACING))
    crowded = of_kind(found, "crowded")
    assert len(crowded) == len({(place.ribbons, place.point) for place in crowded}) > 20
    assert all(len(set(place.ribbons)) == 3 for place in crowded)
    assert found.share_that_fits < 1.0
    values = np.array([place.value for place in crowded])
    assert (np.diff(values) >= 0).all()
    smaller = inspected(laid(triaxial(shift), width=0.99 * values[0]))
    assert not of_kind(smaller, "crowded")


def test_a_small_angle_is_told_once_with_its_place_in_the_unit_of_the_output() -> None:
    found = inspected(laid([(0, 0.013, 0.02), (5, 0.013, 0.02), (90, 0.4, 0.1), (90, -0.4, 0.1)], unit=100.0))
    (place,) = of_kind(found, "near_parallel")
    assert place.value == pytest.approx(5.0)
    assert place.point == pytest.approx((1.3, 2.0, 0.0), abs=1e-6)
    assert place.ribbons == ("A1", "A2")
    assert not of_kind(found, "alongside")


def test_ribbons_on_top_of_each_other_are_told_with_the_length_of_the_stretch() -> None:
    lines = [(0, 0.0, 0.02), (0, 0.0, 0.03), (0, 0.0, 0.2), (90, 0.31, 0.0), (90, -0.31, 0.0)]
    found = inspected(laid(lines, width=0.03))
    (place,) = of_kind(found, "alongside")
    assert place.value == pytest.approx(2.0, abs=0.02)
    assert place.ribbons == ("A1", "A2")
    assert place.point[1] == pytest.approx(0.025)
    assert not of_kind(inspected(laid(lines, width=0.009)), "alongside")


def test_ends_that_go_on_in_each_other_are_told_apart() -> None:
    lines = [(0, -0.56, 0.02), (0, 0.56, 0.022), (90, 0.31, 0.0), (90, -0.31, 0.0)]
    found = inspected(laid(lines, width=0.04, length=0.6))
    (place,) = of_kind(found, "lap")
    assert place.value == pytest.approx(0.08, abs=0.03)
    assert place.point == pytest.approx((0.0, 0.021, 0.0), abs=0.05)
    assert place.ribbons == ("A1", "A2")
    assert not of_kind(found, "alongside")


def test_both_sides_of_a_thin_wall_do_not_see_each_other() -> None:
    """Two plates back to back, lines on one of them: the other is a bare component, and nothing overlaps."""
    mesh = plate()
    both = TriMesh(
        np.concatenate([mesh.vertices, mesh.vertices - [0, 0, 0.001]]),
        np.concatenate([mesh.faces, mesh.faces[:, ::-1] + mesh.n_vertices]),
    )
    given = laid([(0, 0.0, 0.02), (90, 0.3, 0.0), (0, 0.0, 0.4)])
    curves = replace(given.ribbons.curves, mesh=both)
    weave = replace(given, ribbons=replace(given.ribbons, curves=curves))
    (bare,) = of_kind(inspected(weave), "bare_component")
    assert bare.value == pytest.approx(4.0)
    assert bare.point[2] == pytest.approx(-0.001)
    twin = replace(curves, points=curves.points - [0, 0, 0.001], faces=curves.faces + mesh.n_faces)
    two = Curves.concatenate(both, chain(curves, twin))
    ribbons = Ribbons(two, crossings(two), np.arange(6), SPACING, Cutting())
    on_both = replace(
        weave,
        ribbons=ribbons,
        families=np.zeros(6, dtype=np.int64),
        interlacing=replace(weave.interlacing, over=np.zeros(4, dtype=np.int64)),
    )
    found = inspected(on_both)
    assert not of_kind(found, "bare_component")
    assert not of_kind(found, "alongside")
    # without a ribbon of its own the far side of a hole would be covered by the other plate's ribbons
    assert len(of_kind(found, "gap")) == 2 * len(of_kind(inspected(given), "gap")) > 0


def test_short_ribbons_that_cross_each_other_are_a_knot() -> None:
    middle = [(0.0, 0.1, 0.5), (60.0, 0.1, 0.5), (120.0, 0.15, 0.45)]
    found = inspected(laid([*middle, (0.0, -0.5, -0.5), (90.0, -0.5, -0.5)], length=0.45))
    (knot,) = [each for each in found.places if each.kind == "knot"]
    assert knot.value == 3  # the two lines below cross each other too, but two are no knot
    assert len(set(knot.ribbons)) == 3
    assert np.linalg.norm(np.array(knot.point) - [0.12, 0.48, 0]) < 0.1
    assert not inspected(laid(middle, length=0.65)).counts["knot"], "1.3 is more than six spacings"


def test_a_hole_is_told_once_at_its_middle() -> None:
    kept = [line for line in triaxial(0.5) if np.hypot(line[1], line[2]) > 2.2 * SPACING]
    found = inspected(laid(kept, unit=10.0), Limits(gap=1.2))
    (hole,) = of_kind(found, "gap")
    distance = min(np.hypot(x, y) for _, x, y in kept)  # a line starts at its point nearest to the origin
    assert hole.value == pytest.approx(10 * distance, rel=0.25)
    assert np.hypot(*hole.point[:2]) < 10 * SPACING
    assert not of_kind(inspected(laid(kept), Limits(gap=4.0)), "gap")


def test_loose_ends_and_broken_rules_are_told() -> None:
    found = inspected(laid([(0, 0.0, 0.02), (90, 0.3, 0.0)], length=0.6))
    ends = of_kind(found, "loose_end")
    assert len(ends) == 4
    assert ends[0].value == pytest.approx(0.9)
    assert any("loose" in sentence for sentence in found.violations)


def test_the_document_counts_its_places() -> None:
    found = inspected(made().sized(200.0, width=8.0))
    document = found.document()
    assert (document["units"], document["width"]) == ("mm", pytest.approx(8.0))
    assert document["metres"] == pytest.approx(document["total_length"] / 1000)
    assert document["alternation"] == made().metrics()["alternation"]
    assert sum(document["counts"].values()) == len(document["places"])
    assert set(document["counts"]) == set(KINDS)
    names = set(made().names)
    assert all(set(place["ribbons"]) <= names for place in document["places"])
    with pytest.raises(FieldError, match="'angle' of an inspection"):
        Limits(angle=-1)
