"""Straight ribbons on a flat plate, and what an inspection finds there."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np

from geoweave.curves.curve_crossings import crossings
from geoweave.curves.straightest_geodesics import straightest
from geoweave.models import shapes
from geoweave.surface.mesh import Similarity, TriMesh
from geoweave.weave.design import weave_pattern
from geoweave.weave.inspection import Inspection
from geoweave.weave.places import Place
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


def kagome(phase: float) -> list[tuple[float, float, float]]:
    """Three families right across the plate, a kagome at 0.5; three lines meet in each point at 0."""
    slide = np.linspace(-1.5, 1.5, 301)
    lines = []
    for turn, shift in ((0.0, 0.013), (60.0, 0.013), (120.0, phase)):
        along = np.array([np.cos(np.radians(turn)), np.sin(np.radians(turn))])
        for k in range(-8, 9):
            foot = (k + shift) * SPACING * np.array([-along[1], along[0]])
            there = foot + slide[:, None] * along
            size = np.abs(there).max(axis=1)
            if size.min() < 0.99:
                lines.append((turn, *there[size.argmin()].tolist()))
    return lines
