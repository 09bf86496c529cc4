"""Eq. 8 on surfaces of several kinds, for the tests of its energy, its systems and its steps."""

from __future__ import annotations

import numpy as np
from surfaces import surface

import geoweave as gw
from geoweave.arrays import Scalars
from geoweave.fields import FaceField
from geoweave.fields.triples import Triples
from geoweave.foliation.foliation import punctured
from geoweave.foliation.regular_steps import RegularSteps
from geoweave.foliation.theta_and_s import Alternation

NAMES = ("jagged sphere", "genus 5", "two pieces")


def problem(name: str) -> tuple[Alternation, Scalars, Scalars]:
    """Eq. 8 on a surface, with an uneven s and any theta."""
    field, part = punctured(gw.smoothest_field(surface(name)))
    rng = np.random.default_rng(0)
    s = 5.0 * rng.uniform(0.5, 1.5, part.mesh.n_faces)
    return Alternation(field, s, s, 1e-3), rng.uniform(-3.0, 3.0, part.mesh.n_vertices), s


def three_sheets(faces: int = 300, bent: float = 0.0) -> tuple[FaceField, Triples]:
    """Three copies of a disk with directions 120 degrees apart, or somewhat more and less where bent."""
    disk = gw.shapes.disk(faces=faces)
    n, f = disk.n_vertices, disk.n_faces
    places = np.tile(disk.vertices, (3, 1))
    mesh = gw.TriMesh(places, np.concatenate([disk.faces + k * n for k in range(3)]))
    frames = mesh.frames[:, :, :2]
    x, y = mesh.vertices[mesh.faces].mean(axis=1).T[:2]
    angle = (
        np.repeat(2.0 * np.pi / 3.0 * np.arange(3), f) + 0.3 + bent * np.repeat([1.0, -1.0, 0.5], f) * x * y
    )
    vector = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    values = (frames[:, 0] * vector).sum(axis=1) + 1j * (frames[:, 1] * vector).sum(axis=1)
    over = np.arange(f)[:, None] + f * np.arange(3)
    return FaceField(mesh, values), Triples(mesh, over, np.ones((f, 3)), 2)


def coupled(faces: int = 300, bent: float = 0.3) -> tuple[RegularSteps, Scalars, Scalars]:
    """Eq. 8 and the energy of the phase on three sheets, with any theta and s."""
    field, triples = three_sheets(faces, bent)
    rng = np.random.default_rng(1)
    s = 8.0 * rng.uniform(0.8, 1.25, field.mesh.n_faces)
    steps = RegularSteps(field, s, s, 1e-3, None, triples)
    steps.phase.kappa, steps.phase.eta = 0.3, 2.0
    return steps, rng.uniform(-3.0, 3.0, field.mesh.n_vertices), s * rng.uniform(0.9, 1.1, len(s))
