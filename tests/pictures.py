"""What the tests of pictures draw, and what they look for in the pixels."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache

import numpy as np
from PIL import ImageColor

from geoweave.curves.curves import Curves
from geoweave.curves.tracing import streamlines
from geoweave.fields.face_field import FaceField
from geoweave.models import shapes
from geoweave.rods.rods import Contacts, Layout, Material, Rods
from geoweave.surface.mesh import TriMesh


@cache
def ball() -> TriMesh:
    """The unit sphere, 1,280 faces."""
    return shapes.sphere(faces=1280)


def along(mesh: TriMesh, vector: object) -> FaceField:
    """The tangential part of one vector on every face."""
    return FaceField.from_ambient(mesh, np.tile(np.asarray(vector, dtype=float), (mesh.n_faces, 1)))


def about_the_axis() -> FaceField:
    """The field of rotations of the ball about its z axis."""
    return FaceField.from_ambient(ball(), np.cross([0.0, 0.0, 1.0], ball().barycenters))


@cache
def circles() -> Curves:
    """Circles of latitude on the ball."""
    return streamlines(about_the_axis(), share=0.1)


@cache
def meridians() -> Curves:
    """Great circles from pole to pole."""
    return streamlines(along(ball(), [0.0, 0.0, 1.0]), share=0.1)


def north() -> np.ndarray:
    """(V,) 1 at the vertex of the ball that lies farthest up, else 0."""
    indices = np.zeros(ball().n_vertices, dtype=np.int64)
    indices[np.argmax(ball().vertices[:, 2])] = 1
    return indices


def lightness(pixels: np.ndarray) -> np.ndarray:
    """(H, W) how light each pixel is, 0 to 255."""
    return pixels.astype(float) @ [0.2126, 0.7152, 0.0722]


def near(pixels: np.ndarray, colour: str | Sequence[float], reach: float = 30.0) -> np.ndarray:
    """Which pixels have a colour, up to a distance in red, green and blue (each 0 to 255)."""
    wanted = ImageColor.getrgb(colour) if isinstance(colour, str) else 255.0 * np.array(colour)
    return np.linalg.norm(pixels.astype(float) - np.array(wanted), axis=-1) < reach


def blank_frame(pixels: np.ndarray, width: int) -> bool:
    """Whether a frame of this many pixels is the ground on all four sides."""
    inside = np.zeros(pixels.shape[:2], dtype=bool)
    inside[width:-width, width:-width] = True
    return bool((pixels[~inside] == 255).all())


def ring(n: int = 24, width: float = 0.2, thickness: float = 0.05) -> Rods:
    """A closed rod round the unit circle, thickness outwards, and a straight one across it on top."""
    turn = 2 * np.pi * np.arange(n) / n
    circle = np.column_stack([np.cos(turn), np.sin(turn), 0 * turn])
    middle = turn + np.pi / n
    outwards = np.column_stack([np.cos(middle), np.sin(middle), 0 * turn])
    bar = np.column_stack([np.full(5, np.cos(np.pi / n)), np.full(5, np.sin(np.pi / n)), [-2, -1, 0.0, 1, 2]])
    points = np.concatenate([circle, bar])
    layout = Layout(np.array([0, n, n + 5]), np.array([True, False]))
    lengths = np.linalg.norm(points[layout.ends[:, 1]] - points[layout.ends[:, 0]], axis=1)
    directors = np.concatenate([outwards, np.tile(outwards[0], (4, 1))])
    contacts = Contacts(np.array([[0, n + 2]]), np.array([[0.5, 0.0]]), np.array([1]))
    widths = np.full(layout.segments, width)
    return Rods(layout, points, directors, widths, lengths, contacts, Material(thickness))
