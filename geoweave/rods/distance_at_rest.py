"""How far rods at rest are from a surface as one number, with its exact derivative.

Rods that nothing holds are first put on their design by the best rigid motion, as in `departure`: what is
made small is what is reported.
"""

from __future__ import annotations

import numpy as np

from geoweave.arrays import Scalars, Vectors, cross
from geoweave.rods.departure import fitted, rigid_fit, vertex_weights
from geoweave.rods.rods import Rods
from geoweave.surface import TriMesh, closest_points, triangle_tree

__all__ = ["DistanceAtRest", "Miss"]

ON_SURFACE = 1e-9
"""A vertex nearer than this share of the diagonal lies on the surface; the normal there is its direction."""


class Miss:
    """Residuals ``sqrt(w) n . (y - p)`` of the vertices y of rods at one state.

    y is a vertex after the rigid fit, p its closest point on the surface, n the unit direction from p to y,
    and w the share of the rods' length that belongs to it. The sum of squares is the mean squared distance.
    Its derivative takes the fit into account: with ``yc`` and ``qc`` the vertices of the rods and of the
    design less their means, the fit turns by omega with ``A omega = sum w u x qc`` when y moves by u, where
    ``A = sum w (yc . qc I - yc qc')``.

    Attributes
    ----------
    residuals : (V,) in diagonals of the surface
    """

    def __init__(self, rods: Rods, design: Rods, goal: DistanceAtRest) -> None:
        self.weights, self.placed = goal.weights, goal.placed
        points = fitted(rods, design, placed=goal.placed)
        self.rotation = np.eye(3) if goal.placed else rigid_fit(rods.points, design.points, goal.weights)[0]
        nearest, faces = closest_points(goal.tree, points)
        away = points - nearest
        distance = np.linalg.norm(away, axis=1)
        far = distance > ON_SURFACE * goal.diagonal
        # Frozen as it is, the direction gives the exact derivative of the distance.
        self.directions = np.where(
            far[:, None], away / np.maximum(distance, 1e-300)[:, None], goal.surface.face_normals[faces]
        )
        self.scale = np.sqrt(self.weights) / goal.diagonal
        self.residuals: Scalars = self.scale * (away * self.directions).sum(axis=1)
        mean = self.weights @ points
        self.yc, self.qc = points - mean, design.points - self.weights @ design.points
        mixed = (self.yc * self.weights[:, None]).T @ self.qc
        self.turning = np.linalg.pinv(np.trace(mixed) * np.eye(3) - mixed)

    @property
    def value(self) -> float:
        """Half the mean of the squared distance, in squared diagonals."""
        return 0.5 * float(self.residuals @ self.residuals)

    def forward(self, moved: Vectors) -> Scalars:
        """(V,) change of the residuals as the rods' vertices move by (V, 3)."""
        u = moved @ self.rotation.T
        if not self.placed:
            omega = self.turning @ (self.weights @ cross(u, self.qc))
            u = u - self.weights @ u + cross(np.broadcast_to(omega, u.shape), self.yc)
        return np.asarray(self.scale * (self.directions * u).sum(axis=1))

    def backward(self, slope: Scalars) -> Vectors:
        """(V, 3) derivative by the rods' vertices of what has this derivative (V,) by the residuals."""
        g = (self.scale * slope)[:, None] * self.directions
        if not self.placed:
            z = self.turning.T @ cross(self.yc, g).sum(axis=0)
            spin = cross(self.qc, np.broadcast_to(z, g.shape))
            g = g + self.weights[:, None] * (spin - g.sum(axis=0))
        return np.asarray(g @ self.rotation)


class DistanceAtRest:
    """The target: a surface, and the design that says where on it every vertex belongs.

    Parameters
    ----------
    surface : the target
    design : the rods as designed, on the surface
    placed : whether something holds the rods in space, so that no fit is made
    """

    def __init__(self, surface: TriMesh, design: Rods, *, placed: bool = False) -> None:
        self.surface, self.design, self.placed = surface, design, placed
        self.tree = triangle_tree(surface.vertices[surface.faces])
        self.diagonal = float(np.linalg.norm(np.ptp(surface.vertices, axis=0)))
        weights = vertex_weights(design)
        self.weights = weights / weights.sum()

    def miss(self, rods: Rods) -> Miss:
        """Measure rods."""
        return Miss(rods, self.design, self)
