"""Functions with values on a circle, theta: T -> S^1, on the vertices of a mesh (Sections 3 and 4.2)."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from geoweave.arrays import Complexes, Flags, Indices, Scalars, frozen
from geoweave.errors import FieldError
from geoweave.fields import as_complex, sharp
from geoweave.surface import TriMesh

TURN = 2.0 * np.pi


def wrapped(angle: Scalars) -> Scalars:
    """Representative of each angle in [-pi, pi)."""
    return (angle + np.pi) % TURN - np.pi


def _between_ends(mesh: TriMesh, theta: Scalars) -> Scalars:
    """(E,) end less start of each edge, as its first face sees them."""
    start, end = (theta[mesh.edges] * mesh.bundle.ends).T
    return np.asarray(end - start)


@dataclass(frozen=True, eq=False)
class CircleFunction:
    """A circle-valued function: an angle at each vertex, and how far it turns along each edge.

    The change along an edge is part of the function: it agrees with the angles at its ends up to full turns.
    Within a face the function is linear where the three changes cancel; where they do not, the face holds an
    edge dislocation (Section 4.2.1): some level sets end in it.

    Attributes
    ----------
    mesh : the surface
    theta : (V,) angle at each vertex, radians
    jumps : (E,) change along each edge in the edge's direction, radians

    Raises
    ------
    FieldError
        If the shapes do not fit, or the change along an edge differs from that of its ends by more than
        rounding and full turns.

    Examples
    --------
    >>> ring = gw.shapes.annulus(faces=300)
    >>> angle = np.arctan2(ring.vertices[:, 1], ring.vertices[:, 0])
    >>> circle = gw.CircleFunction.nearest(ring, 5 * angle, np.zeros(ring.n_edges))
    >>> [abs(round(circle.periods(loop))) for loop in ring.boundary_loops], int(circle.dislocated.sum())
    ([5, 5], 0)
    """

    mesh: TriMesh
    theta: Scalars
    jumps: Scalars

    def __post_init__(self) -> None:
        theta, jumps = np.array(self.theta, dtype=np.float64), np.array(self.jumps, dtype=np.float64)
        for array, count, place in (
            (theta, self.mesh.n_vertices, "vertex"),
            (jumps, self.mesh.n_edges, "edge"),
        ):
            if array.shape != (count,):
                raise FieldError(
                    f"a circle-valued function needs one number per {place}, ({count},), not {array.shape}"
                )
            if not np.isfinite(array).all():
                bad = int(np.flatnonzero(~np.isfinite(array))[0])
                raise FieldError(f"the circle-valued function is not finite at {place} {bad}")
        off = np.abs(wrapped(_between_ends(self.mesh, theta) - jumps))
        if (off > 1e-6).any():
            bad = int(np.argmax(off))
            raise FieldError(
                f"the change along edge {bad} is {off[bad]:.2g} off what its ends say, full turns apart"
            )
        object.__setattr__(self, "theta", frozen(theta))
        object.__setattr__(self, "jumps", frozen(jumps))

    @classmethod
    def nearest(cls, mesh: TriMesh, theta: Scalars, prediction: Scalars) -> CircleFunction:
        """Take the change along each edge that agrees with its ends and is nearest to a prediction.

        Parameters
        ----------
        mesh, theta : as the attributes
        prediction : (E,) expected change along each edge, radians
        """
        return cls(mesh, theta, prediction + wrapped(_between_ends(mesh, theta) - prediction))

    @cached_property
    def corner_jumps(self) -> Scalars:
        """(F, 3) change along the edge opposite each corner, in the direction of the face's boundary."""
        return frozen(self.jumps[self.mesh.face_edges] * self.mesh.bundle.forms)

    @cached_property
    def dislocations(self) -> Indices:
        """(F,) full turns round the boundary of each face: zero except where an edge dislocation sits."""
        return frozen(np.rint(self.corner_jumps.sum(axis=1) / TURN).astype(np.int64))

    @property
    def dislocated(self) -> Flags:
        """(F,) faces that hold an edge dislocation."""
        return np.asarray(self.dislocations != 0)

    @cached_property
    def gradient(self) -> Complexes:
        """(F,) gradient on each face, 1 / length; in a dislocated face the nearest linear function's."""
        return frozen(as_complex(sharp(self.mesh) @ self.jumps))

    def periods(self, vertices: Indices, *, closed: bool = True) -> float:
        """Full turns along a path of edges, an integer when the path is closed.

        Parameters
        ----------
        vertices : the path, each vertex joined to the next by an edge (and the last to the first if closed)
        closed : whether the path returns to its start

        Raises
        ------
        FieldError
            If two vertices that follow each other are not joined by an edge.
        """
        tail = np.asarray(vertices, dtype=np.int64)
        head = np.roll(tail, -1)
        if not closed:
            tail, head = tail[:-1], head[:-1]
        low, high = np.minimum(tail, head), np.maximum(tail, head)
        ends = np.sort(self.mesh.edges, axis=1)
        size = self.mesh.n_vertices
        keys = ends[:, 0] * size + ends[:, 1]
        order = np.argsort(keys)
        place = np.minimum(np.searchsorted(keys, low * size + high, sorter=order), len(keys) - 1)
        edge = order[place]
        missing = keys[edge] != low * size + high
        if missing.any():
            bad = int(np.flatnonzero(missing)[0])
            raise FieldError(f"vertices {tail[bad]} and {head[bad]} are not joined by an edge")
        sign = np.where(self.mesh.edges[edge, 0] == tail, 1.0, -1.0)
        return float((sign * self.jumps[edge]).sum() / TURN)
