"""Rods of known shapes, for the tests of the physics."""

from dataclasses import replace

import numpy as np

from geoweave.arrays import parallel_transport
from geoweave.rods.rods import Contacts, Layout, Material, Rods

NONE = Contacts(np.zeros((0, 2)), np.zeros((0, 2)), np.zeros(0))
MATERIAL = Material(thickness=0.01, young=1e6)
THIN = Material(thickness=0.002, young=1e8)


def rods_of(lines, normals, *, closed=False, width=0.1, contacts=NONE, material=MATERIAL):
    """Rods through points, with directors as near as can be to normals, at rest as they are but for bends."""
    offsets = np.concatenate([[0], np.cumsum([len(line) for line in lines])])
    layout = Layout(offsets, np.broadcast_to(closed, len(lines)))
    points = np.concatenate(lines).astype(float)
    edges = points[layout.ends[:, 1]] - points[layout.ends[:, 0]]
    lengths = np.linalg.norm(edges, axis=1)
    tangents = edges / lengths[:, None]
    normals = np.broadcast_to(normals, tangents.shape)
    square = normals - (normals * tangents).sum(axis=1)[:, None] * tangents
    square = square / np.linalg.norm(square, axis=1)[:, None]
    widths = np.full(layout.segments, width)
    return Rods(layout, points, square, widths, lengths, contacts, material)


def bar(count, length=1.0, *, normal=(0.0, 0.0, 1.0), **options):
    """A straight rod along x of so many segments."""
    line = np.column_stack([np.linspace(0, length, count + 1), np.zeros(count + 1), np.zeros(count + 1)])
    return rods_of([line], np.array(normal), **options)


def circle(count, radius=1.0):
    angle = 2 * np.pi * np.arange(count) / count
    return radius * np.column_stack([np.cos(angle), np.sin(angle), np.zeros(count)])


def ring(count, radius=1.0, *, upright=True, **options):
    """A closed ring; upright like the hoop of a barrel, or flat like a washer."""
    points = circle(count, radius)
    out = 0.5 * (points + np.roll(points, -1, axis=0))
    return rods_of([points], out if upright else np.array([0.0, 0.0, 1.0]), closed=True, **options)


def helix(count, radius, pitch, turns=1.0, **options):
    """An open helix about z, its directors pointing outwards."""
    angle = np.linspace(0, 2 * np.pi * turns, count + 1)
    points = np.column_stack([radius * np.cos(angle), radius * np.sin(angle), pitch * angle / (2 * np.pi)])
    middle = 0.5 * (angle[1:] + angle[:-1])
    out = np.column_stack([np.cos(middle), np.sin(middle), np.zeros(count)])
    return rods_of([points], out, **options)


def crumpled(seed=0):
    """An open and a closed rod, far from rest, with three contacts, one between opposite sides."""
    rng = np.random.default_rng(seed)
    line = np.column_stack([np.linspace(-1.5, 1.5, 7), np.zeros(7), np.zeros(7)])
    rods = rods_of([line, circle(8)], np.array([0, 0, 1.0]), closed=[False, True])
    points = rods.points + 0.15 * rng.normal(size=rods.points.shape)
    edges = points[rods.layout.ends[:, 1]] - points[rods.layout.ends[:, 0]]
    lengths = np.linalg.norm(edges, axis=1)
    tangents = edges / lengths[:, None]
    directors = parallel_transport(rods.tangents, tangents, rods.directors) + 0.3 * rng.normal(
        size=tangents.shape
    )
    directors[2] *= -1
    directors -= (directors * tangents).sum(axis=1)[:, None] * tangents
    directors /= np.linalg.norm(directors, axis=1)[:, None]
    contacts = Contacts([[0, 9], [5, 13], [2, 7]], [[0.3, 0.6], [0.1, 0.9], [0.5, 0.5]], [0, 1, 1])
    widths = np.linspace(0.2, 0.3, len(edges))
    material = Material(0.05, young=100.0)
    natural = 0.3 * rng.normal(size=len(rods.layout.joints))
    return Rods(rods.layout, points, directors, widths, 1.1 * lengths, contacts, material, natural=natural)


def turned(rods, rotation, shift):
    """The same rods somewhere else."""
    return Rods(
        rods.layout,
        rods.points @ rotation.T + shift,
        rods.directors @ rotation.T,
        rods.widths,
        rods.rest,
        rods.contacts,
        rods.material,
        None,
        rods.twists,
        rods.natural,
    )


def any_rotation(seed=1):
    q, _ = np.linalg.qr(np.random.default_rng(seed).normal(size=(3, 3)))
    return q * np.sign(np.linalg.det(q))


def grid(count=3):
    """Straight bars that cross at right angles, one unit apart, the first family below."""
    line = np.linspace(-1.0, float(count), 10 * (count + 1) + 1)
    flat = np.zeros_like(line)
    bars = [np.column_stack([line, flat + k, flat]) for k in range(count)]
    bars += [np.column_stack([flat + k, line, flat]) for k in range(count)]
    each = len(line) - 1
    pairs, places = [], []
    for one in range(count):
        for other in range(count):
            pairs.append([each * one + 10 * (other + 1), each * (count + other) + 10 * (one + 1)])
            places.append([0.0, 0.0])
    return rods_of(bars, np.array([0.0, 0.0, 1.0]), contacts=Contacts(pairs, places, np.ones(len(pairs))))


def three_great_circles(count=48, *, tilt=0.0, seed=0):
    """Three rings about a ball, each over one and under the other where they cross: six contacts."""
    flat = circle(count)
    frames = [np.eye(3), np.eye(3)[[1, 2, 0]], np.eye(3)[[2, 0, 1]]]
    lines = [flat @ frame for frame in frames]
    if tilt:
        rng = np.random.default_rng(seed)
        lines = [line + tilt * rng.normal(size=line.shape) for line in lines]
        lines = [line / np.linalg.norm(line, axis=1)[:, None] for line in lines]
    normals = np.concatenate([0.5 * (line + np.roll(line, -1, axis=0)) for line in lines])
    free = rods_of(lines, normals, closed=True, width=0.04, material=THIN)
    quarter = count // 4
    # ring 0 passes x, y, -x, -y; ring 1 passes y, z, ...; ring 2 passes z, x, ...
    pairs, over = [], []
    for a, b, at, bt in ((0, 1, 1, 0), (0, 1, 3, 2), (1, 2, 1, 0), (1, 2, 3, 2), (2, 0, 1, 0), (2, 0, 3, 2)):
        pairs.append([a * count + at * quarter, b * count + bt * quarter])
        over.append(1)
    return replace(free, contacts=Contacts(pairs, np.zeros((6, 2)), over))
