"""The small surfaces that the tests of the operators run on, one of every kind."""

from __future__ import annotations

from functools import cache

import numpy as np

from geoweave.curves.curves import Curves
from geoweave.curves.straightest_geodesics import straightest
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


@cache
def uneven_square() -> TriMesh:
    """A flat square of uneven triangles."""
    flat = shapes.square(faces=800)
    inner = ~flat.boundary_vertices[:, None]
    shake = np.random.default_rng(2).uniform(-0.03, 0.03, flat.vertices.shape) * [1, 1, 0]
    return TriMesh(flat.vertices + inner * shake, flat.faces)


def scattered(mesh: TriMesh, count: int, length: float, seed: int = 0, behind: float = 0.0) -> Curves:
    """Straightest geodesics from random faces in random directions."""
    rng = np.random.default_rng(seed)
    faces, directions = rng.integers(mesh.n_faces, size=count), rng.normal(size=(count, 3))
    return straightest(mesh, faces, directions, length, behind=behind)


def lines_on_square(*ends: tuple[float, float, float, float], mesh: TriMesh | None = None) -> Curves:
    """Straight lines on the square [-1, 1]^2, from one end to the other."""
    mesh = shapes.square(faces=1000) if mesh is None else mesh
    begin, stop = np.array(ends)[:, :2], np.array(ends)[:, 2:]
    planar = mesh.vertices[mesh.faces][..., :2]
    sides = np.roll(planar, -1, axis=1) - planar
    inward = np.stack([-sides[..., 1], sides[..., 0]], axis=-1)
    inside = [int(np.argmax(((b - planar) * inward).sum(axis=-1).min(axis=1))) for b in begin]
    flat = np.zeros((len(ends), 1))
    return straightest(
        mesh,
        inside,
        np.hstack([stop - begin, flat]),
        np.linalg.norm(stop - begin, axis=1),
        points=np.hstack([begin, flat + mesh.vertices[0, 2]]),
    )


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
