"""The plane in which a surface is its own mirror image, as nearly as it is one."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, TypeAlias

import numpy as np

from geoweave.arrays import Scalars, Vectors, frozen
from geoweave.errors import MeshError
from geoweave.surface.closest_point import closest_points, triangle_tree
from geoweave.surface.mesh import TriMesh

MirrorAxis: TypeAlias = Literal["auto", "x", "y", "z"]
"""Any plane, or one across an axis of the coordinates."""

MIRROR_AXES: tuple[MirrorAxis, ...] = ("auto", "x", "y", "z")
"""All of them."""

TOLERANCE = 0.01
"""Root mean square distance between a surface and its mirror image, in bounding radii, that is still one."""

FITS = 10
"""Times that the plane is fitted to the points and their images."""


@dataclass(frozen=True, eq=False)
class MirrorPlane:
    """A plane ``normal . x = offset`` and how nearly a surface is its own image in it.

    Attributes
    ----------
    normal : (3,) of length 1
    offset : of the plane along it, a length
    residual : root mean square distance from the images of the faces' centres to the surface, weighted by
        area, in bounding radii
    """

    normal: Scalars
    offset: float
    residual: float

    def image(self, points: Vectors) -> Vectors:
        """(n, 3) mirror images of points."""
        away = points @ self.normal - self.offset
        return np.asarray(points - 2.0 * away[:, None] * self.normal)

    def image_of_vectors(self, vectors: Vectors) -> Vectors:
        """(n, 3) mirror images of vectors."""
        return np.asarray(vectors - 2.0 * (vectors @ self.normal)[:, None] * self.normal)


def mirror_plane(mesh: TriMesh, axis: MirrorAxis = "auto") -> MirrorPlane:
    """Find the plane in which a surface is most nearly its own mirror image.

    A mirror plane goes through the centre of the surface and across one of its principal axes of inertia.
    These are tried, and if none serves the axes of the coordinates. The best one is fitted: of points p and
    the points q of the surface nearest to their images, ``n`` is the eigenvector of the smallest eigenvalue
    of ``sum A (p q' + q p')``, both taken from their centres, for which ``sum A |image(p) - q|^2`` is least.

    Parameters
    ----------
    mesh : the surface
    axis : that the plane is across, "auto" for any plane

    Raises
    ------
    MeshError
        If the surface is farther from its mirror image than 1 % of its bounding radius, or there is no such
        axis.

    Examples
    --------
    >>> from geoweave.surface import mirror_plane
    >>> plane = mirror_plane(gw.shapes.torus(faces=400), "z")
    >>> plane.normal.tolist(), plane.residual < 1e-9
    ([0.0, 0.0, 1.0], True)
    """
    if axis not in MIRROR_AXES:
        raise MeshError(f"there is no mirror axis '{axis}': {', '.join(MIRROR_AXES)}")
    faces = _Faces(mesh)
    if axis == "auto":
        best = faces.best_of(faces.principal_axes)
        if best.residual > TOLERANCE:  # a body of revolution has no principal axes of its own
            best = min(best, faces.best_of(np.eye(3)), key=lambda each: each.residual)
    else:
        best = faces.plane(np.eye(3)["xyz".index(axis)])
    for _ in range(FITS):
        fitted = faces.fitted(best, turning=axis == "auto")
        if fitted.residual >= best.residual:
            break
        best = fitted
    if best.residual > TOLERANCE:
        said = "({:.2f}, {:.2f}, {:.2f})".format(*best.normal)
        raise MeshError(
            f"the surface has no mirror plane{'' if axis == 'auto' else f' across {axis}'}: it is "
            f"{best.residual:.1%} of its size off its image across {said}, and {TOLERANCE:.0%} are allowed"
            "; leave out --symmetric"
        )
    return best


class _Faces:
    """The centres and areas of the faces, and the surface near their images."""

    def __init__(self, mesh: TriMesh) -> None:
        self.mesh, self.points = mesh, np.asarray(mesh.barycenters)
        self.share = mesh.face_areas / mesh.face_areas.sum()
        self.tree = triangle_tree(mesh.vertices[mesh.faces])
        self.center = self.share @ self.points

    @property
    def principal_axes(self) -> Vectors:
        """(3, 3) axes of inertia, one a row."""
        away = self.points - self.center
        return np.asarray(np.linalg.eigh((self.share[:, None] * away).T @ away)[1].T)

    def best_of(self, normals: Vectors) -> MirrorPlane:
        """The plane through the centre with the least residual, of those across some normals."""
        return min((self.plane(normal) for normal in normals), key=lambda each: each.residual)

    def plane(self, normal: Scalars, offset: float | None = None) -> MirrorPlane:
        """The plane across a normal, through the centre if no offset is given, with its residual."""
        at = float(self.center @ normal) if offset is None else offset
        plane = MirrorPlane(frozen(np.asarray(normal, dtype=np.float64)), at, 0.0)
        there = plane.image(self.points)
        nearest, _ = closest_points(self.tree, there)
        off = np.sqrt(self.share @ ((nearest - there) ** 2).sum(axis=1)) / self.mesh.bounding_radius
        return MirrorPlane(plane.normal, at, float(off))

    def fitted(self, plane: MirrorPlane, *, turning: bool) -> MirrorPlane:
        """The plane that takes the points nearest to where they come now; it turns only if it may."""
        nearest, _ = closest_points(self.tree, plane.image(self.points))
        other, normal = self.share @ nearest, plane.normal
        if turning:
            both = (self.share[:, None] * (self.points - self.center)).T @ (nearest - other)
            normal = np.linalg.eigh(both + both.T)[1][:, 0]
            normal = normal * np.copysign(1.0, normal[np.abs(normal).argmax()])
        return self.plane(normal, float(0.5 * normal @ (self.center + other)))
