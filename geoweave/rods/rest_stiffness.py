"""How stiff a weave is at rest: its softest motions, and how far loads move it (Section 6).

A small load f moves a weave at rest by u with ``K u = f``. K is the second derivative of the energy (Eq. 10)
there, with the forces that are in the weave. Angles of sections follow without load.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy import linalg
from scipy.sparse.linalg import LinearOperator, eigsh

from geoweave.arrays import Flags, Indices, Scalars, Vectors, cross
from geoweave.errors import RodError
from geoweave.rods import hessian
from geoweave.rods.departure import vertex_weights
from geoweave.rods.rods import Rods
from geoweave.rods.slide_and_relax import Springs, relaxing_terms
from geoweave.rods.steps import Problem, free_parts

__all__ = ["RestStiffness", "SoftMotions", "on_the_floor"]

FOOT = 0.02
"""A weave stands on what lies within this share of its height above its lowest point."""

SPREAD = 0.05
"""Its feet must spread to all sides by this share of its height; otherwise more of it is taken for feet."""

HIGHEST = 0.2
"""Share of the height up to which that goes."""


SHIFTS = (0.0, 1e-13, 1e-12)
"""Dampings that are tried, far below any stiffness: rounding may make a mechanism's zero negative."""


class SoftMotions(NamedTuple):
    """The motions that a weave resists least, rigid ones left out."""

    stiffness: Scalars
    """(k,) resisting force per displacement and length of ribbon, ascending."""
    motions: Vectors
    """(k, V, 3) displacements of the vertices; their square has the mean 1 over the length of the ribbons."""


class RestStiffness:
    """The stiffness of rods at rest, factored once.

    Parameters
    ----------
    rods : at rest under these springs
    springs : stiffnesses that they were relaxed with
    fixed : (V,) vertices that do not move. Parts without one are free in space: they answer loads without
        their rigid motion, and loads on them should be in balance

    Raises
    ------
    RodError
        If a shape is not stable: a motion that is not rigid meets no resistance, or less than none.

    Examples
    --------
    >>> rest = gw.relaxed_weave(gw.weave_pattern(gw.shapes.cone(faces=400), ribbons=8))
    >>> stiff = gw.rods.RestStiffness(rest.left.rods)
    >>> bool(stiff.softest(2).stiffness[0] > 0)
    True
    """

    def __init__(self, rods: Rods, springs: Springs | None = None, fixed: Flags | None = None) -> None:
        layout = rods.layout
        still = np.zeros(layout.vertices, dtype=bool) if fixed is None else np.asarray(fixed, dtype=bool)
        held = np.concatenate([np.repeat(still, 3), still[layout.ends].all(axis=1)])
        self.rods, self.weights = rods, vertex_weights(rods)
        self.rigid: list[Vectors] = []
        pinned = held.copy()
        for vertices, segments in free_parts(rods, held):
            motions = self._rigid_motions(vertices, segments)
            # Six unknowns hold a part without straining it: the best conditioned rows of its motions.
            pinned[linalg.qr(motions.T, mode="economic", pivoting=True)[2][:6]] = True
            self.rigid.append(self._orthonormal(motions[: 3 * layout.vertices]))
        terms = relaxing_terms(rods, springs)
        problem = Problem(rods, terms, pinned, None, True, hessian.analysed(rods.size, terms, pinned))
        now = problem.completed(problem.tried(rods))
        matrix = problem.matrix(now, now.residuals)
        self.solve, self.pinned = problem.stable(matrix, SHIFTS), pinned

    def _rigid_motions(self, vertices: Indices, segments: Indices) -> Vectors:
        """(3 V + S, 6) motions of a part as a rigid whole, turns about its middle by one over its size."""
        rods, own = self.rods, self.weights[vertices]
        arm = rods.points[vertices] - (own / own.sum()) @ rods.points[vertices]
        size = np.sqrt(own @ (arm**2).sum(axis=1) / own.sum())
        moved = np.zeros((len(rods.points), 3, 6))
        turned = np.zeros((rods.layout.segments, 6))
        for axis, unit in enumerate(np.eye(3)):
            moved[vertices, axis, axis] = 1.0
            moved[vertices, :, 3 + axis] = cross(np.broadcast_to(unit, arm.shape), arm) / size
            turned[segments, 3 + axis] = rods.tangents[segments, axis] / size
        return np.concatenate([moved.reshape(-1, 6), turned])

    def _orthonormal(self, motions: Vectors) -> Vectors:
        """(3 V, r) an orthonormal basis, by length of ribbon, of motions of vertices."""
        root = np.sqrt(np.repeat(self.weights, 3))[:, None]
        basis, sizes, _ = linalg.svd(root * motions, full_matrices=False)
        # a straight strip does not move as it turns about itself
        return np.asarray(basis[:, sizes > 1e-9 * sizes[0]] / root)

    def moved(self, load: Vectors) -> Vectors:
        """(V, 3) displacements under forces (V, 3), without the rigid motion of free parts."""
        size = 3 * len(load)
        force = np.zeros(self.rods.size)
        force[:size] = load.ravel()
        for motions in self.rigid:  # forces that would accelerate a part are balanced along its ribbons
            force[:size] -= np.repeat(self.weights, 3) * (motions @ (motions.T @ force[:size]))
        force[self.pinned] = 0.0
        found = self.solve(force)[:size]
        for motions in self.rigid:
            found -= motions @ (motions.T @ (np.repeat(self.weights, 3) * found))
        return np.asarray(found.reshape(-1, 3))

    def softest(self, count: int = 3) -> SoftMotions:
        """The softest motions: smallest eigenvalues k of ``K u = k m u``, m the length of each vertex.

        Parameters
        ----------
        count : how many

        Raises
        ------
        RodError
            If there are not so many.
        """
        root = np.sqrt(np.repeat(self.weights, 3))
        size = len(root)
        if not 0 < count < size - 6 * len(self.rigid) - 1:
            raise RodError(f"these rods do not have {count} motions; ask for fewer")

        def compliance(v: Scalars) -> Scalars:
            return np.asarray(root * self.moved((root * v.ravel()).reshape(-1, 3)).ravel())

        operator = LinearOperator((size, size), matvec=compliance, dtype=np.float64)
        start = np.random.default_rng(0).normal(size=size)
        values, vectors = eigsh(operator, k=count, which="LA", v0=start, tol=1e-8)
        order = np.argsort(-values)
        motions = (vectors / root[:, None]).T[order].reshape(count, -1, 3) * np.sqrt(self.weights.sum())
        return SoftMotions(1.0 / values[order], motions)

    def at_contacts(self, directions: Vectors, which: Indices | None = None) -> Scalars:
        """(n,) displacement of contacts per unit force on them, both along a direction.

        The force is shared by the two ribbons.

        Parameters
        ----------
        directions : (C, 3) unit vectors, one for each contact
        which : (n,) contacts; all if not given
        """
        layout, contacts = self.rods.layout, self.rods.contacts
        ends = layout.ends[contacts.segments].reshape(len(contacts), 4)
        share = 0.5 * np.stack([1.0 - contacts.places, contacts.places], axis=2).reshape(-1, 4)
        wanted = np.arange(len(contacts)) if which is None else which
        found = np.empty(len(wanted))
        for k, c in enumerate(wanted.tolist()):
            direction, load = directions[c], np.zeros((layout.vertices, 3))
            np.add.at(load, ends[c], share[c][:, None] * direction)
            found[k] = share[c] @ (self.moved(load)[ends[c]] @ direction)
        return found


def on_the_floor(points: Vectors, up: Vectors) -> Flags:
    """(V,) vertices that a weave stands on: those within a fiftieth of its height above its lowest point.

    Where these lie on one spot or on one line, more are taken, until they spread to all sides or reach up to
    a fifth of the height.

    Parameters
    ----------
    points : (V, 3) of the rods
    up : (3,) direction against gravity

    Examples
    --------
    >>> square = np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0.5, 0.5, 1]])
    >>> gw.rods.on_the_floor(square, np.array([0.0, 0, 1])).tolist()
    [True, True, True, True, False]
    """
    up = np.asarray(up, dtype=np.float64)
    up = up / np.linalg.norm(up)
    height = points @ up
    above, tall = height - height.min(), float(np.ptp(height))
    flat = points - height[:, None] * up
    share = FOOT
    while True:
        feet = above <= share * tall
        spread = np.linalg.svd(flat[feet] - flat[feet].mean(axis=0), compute_uv=False)
        wide = len(spread) > 1 and spread[1] > SPREAD * tall * np.sqrt(feet.sum())
        if wide or share >= HIGHEST:
            return np.asarray(feet)
        share *= 1.5
