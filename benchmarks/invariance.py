"""Does the shape alone decide a weave? Embedded scans as they are, turned, renumbered, mirrored and remeshed.

    python -m benchmarks.invariance [NAME]...

Every scan is woven without a parameter. Then it is turned in space by a random rotation; its vertices, its
faces and the corners of each face are numbered anew; it is mirrored in a plane. The last rows make a mesh of
6,000 triangles first, as ``weave`` does on an uneven one: from the scan as it is, turned, renumbered, and
with its vertices moved by a millionth of its size, as a file of seven digits would. That last row is shown
and not held to the limit: another rounding is another surface. The table says by how much the number of
ribbons and crossings, the total curl and the mean curvature of ribbons change, and is written to
build/bench/invariance.md. A run over all scans keeps the numbers in invariance.csv beside this file.

A second table says, of scans that have a mirror plane, how much of the weave lies on its own mirror image: as
it comes, with a RoSy that is its own image, and on one half of the scan and the image of that half, which is
what ``weave --symmetric`` does.
"""

from __future__ import annotations

import argparse
import csv
from collections.abc import Iterator
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

from geoweave.curves import geodesic_curvature, nearest_curves
from geoweave.errors import MeshError
from geoweave.fields import total_curl
from geoweave.meshing import isotropic_remesh, mirrored_half, ordered_by_place
from geoweave.models import datasets
from geoweave.surface import TriMesh, mirror_plane
from geoweave.weave import Steering, Weave, inspected
from geoweave.weave.design import weave_field

TABLE = Path("build/bench/invariance.md")

KEPT = Path(__file__).with_name("invariance.csv")
"""The first table of a run over all scans."""

SCANS = ("bunny", "spot", "camel", "armadillo")

MEASURES = ("ribbons", "crossings", "curl", "mean curvature")

ALLOWED = 0.02
"""Largest share by which a measure may change."""

REMESHED = 6_000
"""Triangles of the meshes of their own."""

SEVEN_DIGITS = 1e-6
"""How far vertices are moved, in bounding radii."""

ON_IMAGE, LEAST_ON_IMAGE = 0.01, 0.9
"""Spacings within which a ribbon lies on the image of one, and the share of their length that must."""

ROUNDED = "rounded, remeshed"
"""The row that is not held to the limit."""


def turned(mesh: TriMesh, seed: int = 0) -> TriMesh:
    """The surface after a random rotation."""
    return TriMesh(Rotation.random(rng=seed).apply(np.array(mesh.vertices)), mesh.faces)


def renumbered(mesh: TriMesh, seed: int = 0) -> TriMesh:
    """The same triangles with other numbers of vertices, faces and corners."""
    rng = np.random.default_rng(seed)
    place = rng.permutation(mesh.n_vertices)
    faces = np.argsort(place)[mesh.faces][rng.permutation(mesh.n_faces)]
    first = rng.integers(3, size=mesh.n_faces)
    faces = faces[np.arange(mesh.n_faces)[:, None], (first[:, None] + np.arange(3)) % 3]
    return TriMesh(mesh.vertices[place], faces)


def mirrored(mesh: TriMesh) -> TriMesh:
    """The mirror image, with normals outwards again."""
    return TriMesh(mesh.vertices * [-1.0, 1.0, 1.0], mesh.faces[:, ::-1])


def moved(mesh: TriMesh, seed: int = 0) -> TriMesh:
    """The surface with its vertices moved by a millionth of its size."""
    noise = np.random.default_rng(seed).normal(size=mesh.vertices.shape)
    return TriMesh(mesh.vertices + SEVEN_DIGITS * mesh.bounding_radius * noise, mesh.faces)


def remeshed(mesh: TriMesh) -> TriMesh:
    """A mesh of its own, made as `geoweave.meshing.evened` makes one."""
    return isotropic_remesh(ordered_by_place(mesh), REMESHED)


def variants(mesh: TriMesh) -> Iterator[tuple[str, TriMesh]]:
    """The surface, and what should be woven in the same way; the second group starts with "remeshed"."""
    yield "as it is", mesh
    yield "turned", turned(mesh)
    yield "renumbered", renumbered(mesh)
    yield "mirrored", mirrored(mesh)
    yield "remeshed", remeshed(mesh)
    yield "turned, remeshed", remeshed(turned(mesh))
    yield "renumbered, remeshed", remeshed(renumbered(mesh))
    yield ROUNDED, remeshed(moved(mesh))


def measure(mesh: TriMesh) -> np.ndarray:
    """Ribbons, crossings, total curl and mean absolute geodesic curvature of a weave without a parameter."""
    found = weave_field(mesh)
    weave = found.pattern()
    curves = weave.ribbons.curves
    bent = np.average(np.abs(geodesic_curvature(curves)), weights=curves.segment_lengths)
    return np.array([len(weave.ribbons), len(weave.ribbons.crossings), total_curl(found.field), bent])


def table(names: list[str] | None = None) -> float:
    """Print the table, keep it, and return the largest change."""
    lines = ["| scan | variant | " + " | ".join(MEASURES) + " |", "|---|---|" + "---:|" * len(MEASURES)]
    print("\nThe shape alone decides a weave: changes against the first row of each group.\n")
    print("\n".join(lines), flush=True)
    worst, first = 0.0, np.empty(0)
    kept: list[list[object]] = [["scan", "variant", *MEASURES]]
    for name in names or SCANS:
        for variant, mesh in variants(datasets.load(name)):
            numbers = measure(mesh)
            kept.append(
                [name, variant, *(int(x) for x in numbers[:2]), *(round(float(x), 6) for x in numbers[2:])]
            )
            if variant in ("as it is", "remeshed"):
                first = numbers
                cells = [f"{numbers[0]:,.0f}", f"{numbers[1]:,.0f}", *(f"{x:.3f}" for x in numbers[2:])]
            else:
                change = numbers / first - 1.0
                worst = worst if variant == ROUNDED else max(worst, float(np.abs(change).max()))
                cells = [f"{x:+.2%}" for x in change]
            lines.append(f"| {name} | {variant} | " + " | ".join(cells) + " |")
            print(lines[-1], flush=True)
    lines += ["", f"Largest change: {worst:.2%}; {ALLOWED:.0%} are allowed."]
    print("\n".join(lines[-2:]))
    TABLE.parent.mkdir(parents=True, exist_ok=True)
    TABLE.write_text("\n".join(lines) + "\n", encoding="utf-8")
    if names is None:
        with KEPT.open("w", encoding="utf-8", newline="") as file:
            csv.writer(file, lineterminator="\n").writerows(kept)
    return worst


def on_its_image(weave: Weave) -> float:
    """Share of the length of ribbons that lies within a hundredth of a spacing of a ribbon's mirror image."""
    plane, spacing = mirror_plane(weave.mesh), weave.ribbons.spacing
    places = weave.ribbons.curves.sampled(0.2 * spacing)
    image = plane.image(places.points), plane.image_of_vectors(places.normals)
    away, _ = nearest_curves(weave.ribbons.curves, *image)
    return float(np.mean(away < ON_IMAGE * spacing))


def symmetric_table(names: list[str] | None = None) -> float:
    """Print the second table, add it to the first one's file, and return the least share with one half."""
    heads = ("on its image", "curl", "ribbons", "crossings", "piled", "mean curvature")
    lines = ["", "| scan | made symmetric | " + " | ".join(heads) + " |", "|---|---|" + "---:|" * len(heads)]
    print("\n".join(lines), flush=True)
    least = 1.0
    for name in names or SCANS:
        mesh = datasets.load(name)
        try:
            half = mirrored_half(mesh, mirror_plane(mesh))
        except MeshError as error:
            lines.append(f"| {name} | {error} |" + " |" * len(heads))
            print(lines[-1], flush=True)
            continue
        own = Steering(symmetric="auto")
        for what, surface, steering in (("nothing", mesh, None), ("RoSy", mesh, own), ("surface", half, own)):
            found = weave_field(surface, steering=steering)
            weave = found.pattern()
            share, curves = on_its_image(weave), weave.ribbons.curves
            bent = np.average(np.abs(geodesic_curvature(curves)), weights=curves.segment_lengths)
            piled = inspected(weave).regularity.piled
            cells = [f"{share:.1%}", f"{total_curl(found.field):.3f}", f"{len(weave.ribbons)}"]
            cells += [f"{len(weave.ribbons.crossings):,}", f"{piled:.1%}", f"{bent:.3f}"]
            lines.append(f"| {name} | {what} | " + " | ".join(cells) + " |")
            print(lines[-1], flush=True)
        least = min(least, share)
    with TABLE.open("a", encoding="utf-8") as file:
        file.write("\n".join(lines) + "\n")
    return least


def main() -> int:
    parser = argparse.ArgumentParser(prog="python -m benchmarks.invariance")
    parser.add_argument("names", metavar="NAME", nargs="*", help="only these")
    names = parser.parse_args().names or None
    changed = table(names) > ALLOWED
    return int(symmetric_table(names) < LEAST_ON_IMAGE or changed)


if __name__ == "__main__":
    raise SystemExit(main())
