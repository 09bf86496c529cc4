"""Holes, hanging ends and bare components are told once, with their place."""

from __future__ import annotations

from dataclasses import replace
from itertools import chain

import numpy as np
import pytest
from laidlines import SPACING, laid, of_kind, plate, triaxial

from geoweave.curves.curve_crossings import crossings
from geoweave.curves.curves import Curves
from geoweave.surface.mesh import TriMesh
from geoweave.weave.inspection import Limits, inspected
from geoweave.weave.ribbons import Cutting, Ribbons


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
