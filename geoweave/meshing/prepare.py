"""From a mesh file, or loose arrays, to the surface of Section 4: mend what can be mended, refuse the rest.

Each repair is counted in a report. A refusal names the file, the place and the remedy. No tolerance depends
on the unit of the model or on where it lies.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from os import PathLike
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from geoweave.arrays import Flags, Indices, Triangles, Vectors
from geoweave.errors import MeshError
from geoweave.meshing import repairs
from geoweave.meshing.faults import faults
from geoweave.meshing.read import read_arrays, shown
from geoweave.meshing.report import RepairReport, place
from geoweave.surface import TriMesh
from geoweave.wording import counted

Components = Literal["keep", "largest"]

LARGEST_COORDINATE = 1e60
"""Coordinates above this, or a model smaller than its reciprocal, take squares of areas out of range."""

MOST_ROUNDS = 50
"""Rounds of welding and flipping; each shortens every chain of faces without area."""


@dataclass(frozen=True, eq=False)
class Prepared:
    """A surface and the report of what was done to get it."""

    mesh: TriMesh
    report: RepairReport


def read_mesh(
    path: str | PathLike[str], *, components: Components = "keep", cut: bool = False, faces: int | None = None
) -> Prepared:
    """Read a mesh file (OBJ, OFF, PLY, STL, or a format that trimesh reads) and mend it into a surface.

    Parameters
    ----------
    path : the file; its extension names the format
    components : "keep" all connected components, or take the "largest" by area
    cut : cut the surface apart along edges shared by more than two faces, instead of refusing it
    faces : remesh isotropically to about this number of triangles

    Raises
    ------
    MeshError
        If the file cannot be read or mended: one line that names the file, the place and the remedy.

    Examples
    --------
    >>> gw.read_mesh("cup.obj")
    Traceback (most recent call last):
    geoweave.errors.MeshError: cup.obj: there is no such file; check the path

    See Also
    --------
    prepare_arrays : the same for arrays
    """
    name = shown(path)
    if faces is not None:
        _check_face_count(faces, name)
    raw = read_arrays(path)
    prepared = prepare_arrays(raw.vertices, raw.faces, components=components, cut=cut, name=name)
    if raw.notes:
        report = replace(prepared.report, notes=(*raw.notes, *prepared.report.notes))
        prepared = replace(prepared, report=report)
    return prepared if faces is None else remeshed(prepared, faces, name=name)


def _check_face_count(faces: int, name: str) -> None:
    """Refuse a number of faces before any work, with the name in front."""
    from geoweave.meshing.remesh import check_face_count

    try:
        check_face_count(faces)
    except MeshError as error:
        raise MeshError(f"{name}: {error}") from None


def remeshed(prepared: Prepared, faces: int, *, name: str = "mesh") -> Prepared:
    """Remesh isotropically to about the given number of triangles (Section 5.2), and say so in the report.

    Raises
    ------
    MeshError
        As `isotropic_remesh`, with the name in front.

    Examples
    --------
    >>> torus = gw.shapes.torus(faces=400)
    >>> rough = gw.meshing.prepare_arrays(torus.vertices, torus.faces)
    >>> gw.meshing.remeshed(rough, 200).report.sentences()
    ['remeshed, from 420 faces']
    """
    from geoweave.meshing.remesh import isotropic_remesh

    try:
        mesh = isotropic_remesh(prepared.mesh, faces)
    except MeshError as error:
        raise MeshError(f"{name}: {error}") from None
    return Prepared(mesh, replace(prepared.report, remeshed_from=prepared.mesh.n_faces))


def prepare_arrays(
    vertices: ArrayLike,
    faces: ArrayLike,
    *,
    components: Components = "keep",
    cut: bool = False,
    name: str = "mesh",
) -> Prepared:
    """Mend (V, 3) points and (F, 3) triangles into a surface; arguments and errors as in `read_mesh`.

    The steps, in order: drop unused vertices, weld, drop degenerate and duplicate faces, choose components,
    orient, turn closed components outwards, and split vertices in which separate fans of faces meet.

    Examples
    --------
    >>> square = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]
    >>> gw.meshing.prepare_arrays(square, [[0, 1, 2], [0, 3, 2]]).report.sentences()
    ['turned 1 face over']
    """
    if components not in ("keep", "largest"):
        raise ValueError(f"components is 'keep' or 'largest', not {components!r}")
    points, triangles = _checked(np.asarray(vertices), np.asarray(faces), name)
    count: dict[str, int] = {}

    origin, triangles = repairs.used_vertices(triangles, len(points))
    count["unreferenced_vertices"] = len(points) - len(origin)
    points = points[origin]
    _check_size(points, origin, name)

    triangles = _welded_and_cleaned(points, triangles, count, name)
    edges = repairs.Edges.of(triangles)
    _check_soup(edges.face_components, name)
    if components == "largest":
        area = np.bincount(edges.face_components, repairs.shapes_of(points, triangles)[1])
        count["dropped_components"] = len(area) - 1
        triangles = triangles[edges.face_components == int(area.argmax())]
        edges = repairs.Edges.of(triangles)

    count["cut_edges"] = int((edges.counts > 2).sum()) if cut else 0
    added = 0
    if count["cut_edges"]:
        points, triangles, origin, added = _separated(points, triangles, edges, origin)
        edges = repairs.Edges.of(triangles)
    _check_edges(points, edges, origin, name)
    turned, one_sided = repairs.orientation(triangles, edges)
    if len(one_sided):
        raise MeshError(
            f"{name}: {len(one_sided)} faces form a one-sided surface like a Moebius strip (first: face at "
            f"{place(points[triangles[one_sided[0]]])}); cut it open across the strip in a mesh editor"
        )
    turned ^= repairs.inside_out(points, _turned(triangles, turned), edges)
    count["turned_faces"] = int(turned.sum())
    points, triangles, _, split = _separated(points, triangles, edges, origin)
    count["split_vertices"] = added + split
    try:
        mesh = TriMesh(points, _turned(triangles, turned))
    except MeshError as error:
        raise MeshError(f"{name}: {error}; mend it in a mesh editor") from None
    return Prepared(mesh, RepairReport(**count, notes=faults(mesh)))


def _separated(
    points: Vectors, triangles: Triangles, edges: repairs.Edges, origin: Indices
) -> tuple[Vectors, Triangles, Indices, int]:
    """Give each fan its own vertex, drop vertices that no face uses; return also how many were added."""
    triangles, copies = repairs.separated_fans(triangles, edges)
    source = np.concatenate([np.arange(int(triangles.max()) + 1 - len(copies)), copies])
    kept, triangles = repairs.used_vertices(triangles, len(source))
    return points[source[kept]], triangles, origin[source[kept]], len(copies)


def _turned(triangles: Triangles, which: Flags) -> Triangles:
    return np.where(which[:, None], triangles[:, [0, 2, 1]], triangles)


def _check_edges(points: Vectors, edges: repairs.Edges, origin: Indices, name: str) -> None:
    """Refuse edges shared by more than two faces."""
    shared = edges.ends[edges.counts > 2]
    if len(shared):
        a, b = shared[0]
        raise MeshError(
            f"{name}: {counted(len(shared), 'edge')} {'is' if len(shared) == 1 else 'are'} shared by more "
            f"than two faces (first: vertices {origin[a]}, {origin[b]} at {place(points[[a, b]])}); "
            "split them in a mesh editor, or cut the surface apart there with --repair"
        )


def _welded_and_cleaned(points: Vectors, triangles: Triangles, count: dict[str, int], name: str) -> Triangles:
    """Weld, flip and drop until nothing changes, and add to the counts."""
    count.update(welded_vertices=0, degenerate_faces=0, flipped_edges=0, duplicate_faces=0)
    for _ in range(MOST_ROUNDS):
        repeated = repairs.repeated(triangles)
        count["degenerate_faces"] += int(repeated.sum())
        triangles = triangles[~repeated]
        alike = repairs.duplicates(triangles)
        count["duplicate_faces"] += int(alike.sum())
        triangles = triangles[~alike]
        flat = repairs.flat(points, triangles)
        if flat.all():
            raise MeshError(f"{name}: no face has any area; export the mesh again")
        edges = repairs.Edges.of(triangles)
        target = _weld_targets(points, triangles, edges, flat)
        used, _ = repairs.used_vertices(triangles, len(points))
        welded = int((target[used] != used).sum())
        if welded:
            count["welded_vertices"] += welded
            triangles = target[triangles]
            continue
        if not flat.any():
            return triangles
        triangles, flips = repairs.flip_caps(points, triangles, edges, flat)
        count["flipped_edges"] += flips
        if not flips:
            break
    flat = repairs.repeated(triangles) | repairs.flat(points, triangles)
    count["degenerate_faces"] += int(flat.sum())
    return triangles[~flat]


def _weld_targets(points: Vectors, triangles: Triangles, edges: repairs.Edges, flat: Flags) -> Indices:
    """(V,) vertex that each one is welded to: itself, unless welding closes an open edge or removes a face.

    Sheets that touch along an edge, each with vertices of its own, are a surface as they are: they are not
    welded where that would give an edge three faces. The triangles of a soup, such as any STL file, share no
    vertices at all: there they are welded, and an edge of three faces is refused later.
    """
    target = repairs.coincident(points, triangles, edges, flat)
    numbers = np.arange(len(target))
    if (target == numbers).all():
        return target
    welded = target[triangles]
    gone = repairs.repeated(welded) | repairs.duplicates(welded)
    after = repairs.Edges.of(welded[~gone])
    was_open = (edges.counts[edges.of_halfedge] == 1).reshape(-1, 3)[~gone].ravel()
    closed = after.of_halfedge[was_open & (after.counts[after.of_halfedge] > 1)]
    useful = np.zeros(len(target), dtype=bool)
    useful[after.ends[closed]] = True
    useful[welded[gone]] = True
    soup = len(repairs.used_vertices(triangles, len(points))[0]) == triangles.size
    if not soup and (edges.counts <= 2).all():
        useful[after.ends[after.counts > 2]] = False
    return np.where(useful[target], target, numbers)


def _checked(points: np.ndarray, triangles: np.ndarray, name: str) -> tuple[Vectors, Triangles]:
    """Refuse arrays that are no points and triangles, and indices that are out of range."""
    if points.ndim != 2 or points.shape[1] != 3 or points.dtype.kind not in "iuf":
        raise MeshError(f"{name}: vertices must be numbers of shape (V, 3), not {points.shape}")
    if not triangles.size:
        cloud = f"{counted(len(points), 'point')} and no faces (a point cloud)"
        raise MeshError(
            f"{name}: holds {cloud if len(points) else 'no faces'}; build a surface from it first"
        )
    if triangles.ndim != 2 or triangles.shape[1] != 3 or triangles.dtype.kind not in "iu":
        raise MeshError(f"{name}: faces must be whole numbers of shape (F, 3), not {triangles.shape}")
    outside = (triangles < 0) | (triangles >= len(points))
    if outside.any():
        face = int(np.flatnonzero(outside.any(axis=1))[0])
        vertex = triangles[face][outside[face]][0]
        raise MeshError(
            f"{name}: face {face} names vertex {vertex}, but it has only {counted(len(points), 'vertex')} "
            f"(0..{len(points) - 1}); export the mesh again"
        )
    return points.astype(np.float64), triangles.astype(np.int64)


def _check_size(points: Vectors, origin: Indices, name: str) -> None:
    """Refuse coordinates that are not finite or whose squares overflow, and a model without extent."""
    bad = ~np.isfinite(points).all(axis=1)
    if bad.any():
        raise MeshError(
            f"{name}: vertex {origin[np.flatnonzero(bad)[0]]} has a coordinate that is not a finite number "
            f"({int(bad.sum())} such in all); correct or remove them"
        )
    if np.abs(points).max() > LARGEST_COORDINATE:
        raise MeshError(f"{name}: its coordinates reach {np.abs(points).max():.3g}; scale it down first")
    extent = float(np.ptp(points, axis=0).max())
    if extent == 0.0:
        raise MeshError(f"{name}: all vertices lie in one place; export the mesh again")
    if extent < 1.0 / LARGEST_COORDINATE:
        raise MeshError(f"{name}: it is only {extent:.3g} long; scale it up first")


def _check_soup(component: Indices, name: str) -> None:
    """Refuse a file most of whose triangles touch no other."""
    size = np.bincount(component)
    single = int((size == 1).sum())
    if len(component) > 1 and 2 * single > len(component):
        raise MeshError(
            f"{name}: {single:,} of its {len(component):,} triangles touch no other (a soup of unconnected "
            "triangles); merge its vertices by distance in a mesh editor"
        )
