"""The small surfaces that the tests of the operators run on, one of every kind."""

from __future__ import annotations

from functools import cache

import numpy as np

from geoweave.models import shapes
from geoweave.surface.mesh import TriMesh


@cache
def surface(name: str) -> TriMesh:
    """Build a named test surface, normalised to bounding radius 1."""
    return BUILDERS[name]().normalized()[0]


def jagged_sphere() -> TriMesh:
    """A sphere of uneven, partly obtuse triangles."""
    ball = shapes.sphere(faces=1280)
    shake = np.random.default_rng(3).normal(scale=0.02, size=ball.vertices.shape)
    return TriMesh((ball.vertices + shake) * [1.0, 0.7, 1.3], ball.faces)


def two_pieces() -> TriMesh:
    """A torus and, apart from it, a disk: two components, one of them with a boundary."""
    ring, disk = shapes.torus(1.0, 0.4, faces=600), shapes.disk(faces=300)
    return TriMesh(
        np.concatenate([ring.vertices, disk.vertices + np.array([4.0, 0.0, 0.0])]),
        np.concatenate([ring.faces, disk.faces + ring.n_vertices]),
    )


BUILDERS = {
    "sphere": lambda: shapes.sphere(faces=1280),
    "jagged sphere": jagged_sphere,
    "torus": lambda: shapes.torus(1.0, 0.4, faces=1500),
    "genus 5": lambda: shapes.genus_g(5, faces=2000),
    "disk": lambda: shapes.disk(faces=800),
    "annulus": lambda: shapes.annulus(0.4, 1.0, faces=900),
    "cylinder": lambda: shapes.cylinder(1.0, 2.0, faces=1200),
    "Schwarz-P": lambda: shapes.schwarz_p(faces=3000),
    "two pieces": two_pieces,
}
ALL = tuple(BUILDERS)
CLOSED = ("sphere", "jagged sphere", "torus", "genus 5")
