"""The energies of elastic rods, as sums of squares (Appendix E); those of contacts are in `contact_energies`.

Each term is ``1/2 sum r^2`` of residuals r that belong to small stencils: a segment, a joint, a contact.
Jacobians are those of the current rods. A change of a vertex parallel-transports the directors, and a change
of an angle turns one of them. So Jacobians are exact however far the rods have moved.
Unknown 3 v + x is coordinate x of vertex v, unknown 3 V + s the angle of segment s.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from geoweave.arrays import Indices, Scalars, Vectors, cross, frozen
from geoweave.rods.compiled_stencils import bending_blocks, twist_blocks
from geoweave.rods.rods import Layout, Rods

__all__ = [
    "GEODESIC",
    "JOINTS",
    "Table",
    "Term",
    "edgewise_bending",
    "elastic_terms",
    "energy_density",
    "flatwise_bending",
    "hat",
    "point_unknowns",
    "sliding",
    "stretching",
    "twisting",
]

GEODESIC = "geodesic curvature"
"""The name of the energy of edgewise bending."""

STRETCHING = "stretching"
"""The name of the one elastic energy that belongs to segments; all others belong to joints."""

JOINTS = ("normal curvature", GEODESIC, "twist")
"""The names of those of joints. Each is inversely proportional to the rest length of its joint."""

Table = NDArray[np.float64]
"""(n, r) residuals of n stencils, or (n, r, k) their derivatives by k unknowns."""


@dataclass(frozen=True, eq=False)
class Term:
    """One energy, ``1/2 sum r^2``.

    Attributes
    ----------
    name : what it is called in tables
    unknowns : (n, k) unknowns of each stencil
    residual : rods to (n, r) residuals, each the root of an energy
    derivative : rods to (n, r, k) derivatives of the residuals by the stencil's unknowns
    curvature : rods and (n, r) weights q to (n, k, k), the symmetric ``sum q r''``: with q = r what
        Gauss-Newton leaves out of the second derivative; None if it is zero
    """

    name: str
    unknowns: Indices
    residual: Callable[[Rods], Table]
    derivative: Callable[[Rods], Table]
    curvature: Callable[[Rods, Table], Table] | None = None

    def energy(self, rods: Rods) -> float:
        """Energy, force x length."""
        return 0.5 * float((self.residual(rods) ** 2).sum())

    def gradient(self, rods: Rods) -> Scalars:
        """(3 V + S,) derivative of the energy by all unknowns."""
        local = np.einsum("nr,nrk->nk", self.residual(rods), self.derivative(rods))
        return np.bincount(self.unknowns.ravel(), local.ravel(), minlength=rods.size).astype(np.float64)

    def jacobian(self, rods: Rods) -> sparse.csr_array:
        """(n r, 3 V + S) derivative of all residuals by all unknowns."""
        local = self.derivative(rods)
        n, r, k = local.shape
        columns = np.broadcast_to(self.unknowns[:, None, :], (n, r, k)).ravel()
        rows = np.repeat(np.arange(n * r), k)
        return sparse.csr_array((local.ravel(), (rows, columns)), shape=(n * r, rods.size))


def elastic_terms(layout: Layout) -> tuple[Term, ...]:
    """Return the internal energies of rods: stretching, bending flatwise and edgewise, twisting."""
    joint = _joint_unknowns(layout)
    return (stretching(layout), flatwise_bending(layout, joint), edgewise_bending(layout, joint),
            twisting(layout, joint))  # fmt: skip


def point_unknowns(vertices: Indices) -> Indices:
    """(n, 3 m) unknowns of the vertices (n, m)."""
    return (3 * vertices[..., None] + np.arange(3)).reshape(len(vertices), 3 * vertices.shape[1])


def _joint_unknowns(layout: Layout) -> Indices:
    """(J, 11) the three vertices about each joint and the angles of the two segments."""
    a, b = layout.joints.T
    vertices = np.column_stack([layout.ends[a], layout.ends[b, 1]])
    return frozen(np.concatenate([point_unknowns(vertices), 3 * layout.vertices + layout.joints], axis=1))


def _square_part(vectors: Vectors, tangents: Vectors) -> Vectors:
    """Part of vectors square to tangents."""
    return vectors - (vectors * tangents).sum(axis=-1, keepdims=True) * tangents


# -- the energies within rods ---------------------------------------------------------------------------


def stretching(layout: Layout) -> Term:
    """Return the energy of stretching, ``1/2 sum Y w h l (|e| / l - 1)^2`` over segments.

    |e| is the length of a segment, l its rest length.
    """

    def weight(rods: Rods) -> Scalars:
        return np.sqrt(rods.material.stretching(rods.widths) * rods.rest)

    def residual(rods: Rods) -> Table:
        return (weight(rods) * (rods.lengths / rods.rest - 1.0))[:, None]

    def derivative(rods: Rods) -> Table:
        pull = (weight(rods) / rods.rest)[:, None] * rods.tangents
        return np.concatenate([-pull, pull], axis=1)[:, None, :]

    def curvature(rods: Rods, weights: Table) -> Table:
        size = weights * (weight(rods) / rods.rest / rods.lengths)[:, None]
        side = np.eye(3) - rods.tangents[:, :, None] * rods.tangents[:, None, :]
        side *= size[:, :, None]
        return np.block([[side, -side], [-side, side]])

    return Term(STRETCHING, frozen(point_unknowns(layout.ends)), residual, derivative, curvature)


def flatwise_bending(layout: Layout, unknowns: Indices | None = None) -> Term:
    """Return the energy of normal curvature, ``1/2 sum B k^2 / l``, ``k = kb . (t x tau)``, over joints.

    B = Y w h^3 / 12, kb is the curvature binormal, l the rest length of the joint, and ``t x tau`` the mean
    of both segments (Bergou et al. 2010). The earlier form (2008) takes the mean of the squares instead: on a
    twisted strip that counts flatwise bending as edgewise, which is (w / h)^2 times as stiff.
    """
    return _bending("normal curvature", layout, unknowns, flatwise=True)


def edgewise_bending(layout: Layout, unknowns: Indices | None = None) -> Term:
    """Return the energy of geodesic curvature, ``1/2 sum B (k - k0)^2 / l``, ``k = -kb . tau``.

    As `flatwise_bending`, with B = Y h w^3 / 12: (w / h)^2 times as stiff. The natural curvature k0 is that
    of the strip as it is cut (`Rods.natural`), zero for the paper's straight strips.
    """
    return _bending(GEODESIC, layout, unknowns, flatwise=False)


def _bending(name: str, layout: Layout, unknowns: Indices | None, *, flatwise: bool) -> Term:
    a, b = layout.joints.T

    def axis(rods: Rods) -> Vectors:
        """(J, 3) material direction about which the curvature is measured, the mean of both segments."""
        frame = rods.across if flatwise else -rods.directors
        return 0.5 * (frame[a] + frame[b])

    def weight(rods: Rods) -> Scalars:
        stiffness = rods.material.bending if flatwise else rods.material.edgewise
        return np.sqrt(stiffness(rods.joint_widths) / rods.spans)

    def residual(rods: Rods) -> Table:
        bent = (rods.binormals * axis(rods)).sum(axis=1)
        return (weight(rods) * (bent if flatwise else bent - rods.natural))[:, None]

    def derivative(rods: Rods) -> Table:
        middle, kb, chi = axis(rods), rods.binormals, rods.openness[:, None]
        ta, tb = rods.tangents[a], rods.tangents[b]
        curvature = (kb * middle).sum(axis=1, keepdims=True)
        # Transport changes a section's directions only along its segment, and kb is square to that.
        by_a = (2.0 * cross(tb, middle) - curvature * tb) / chi
        by_b = (2.0 * cross(middle, ta) - curvature * ta) / chi
        by_a = _square_part(by_a, ta) / rods.lengths[a][:, None]
        by_b = _square_part(by_b, tb) / rods.lengths[b][:, None]
        turned = -0.5 * (rods.directors if flatwise else rods.across)
        spin_a = (kb * turned[a]).sum(axis=1, keepdims=True)
        spin_b = (kb * turned[b]).sum(axis=1, keepdims=True)
        out = np.concatenate([-by_a, by_a - by_b, by_b, spin_a, spin_b], axis=1)
        return (weight(rods)[:, None] * out)[:, None, :]

    def curvature(rods: Rods, weights: Table) -> Table:
        frame, turned = (rods.across, -rods.directors) if flatwise else (-rods.directors, -rods.across)
        size = weights[:, 0] * weight(rods)
        return bending_blocks(
            layout.joints, rods.tangents, rods.lengths, rods.binormals, rods.openness, frame, turned, size
        )

    return Term(
        name, _joint_unknowns(layout) if unknowns is None else unknowns, residual, derivative, curvature
    )


def twisting(layout: Layout, unknowns: Indices | None = None) -> Term:
    """Return the energy of twist, ``1/2 sum G J m^2 / l`` over joints, m the angle of twist, radians."""
    a, b = layout.joints.T

    def weight(rods: Rods) -> Scalars:
        return np.sqrt(rods.material.twisting(rods.joint_widths) / rods.spans)

    def residual(rods: Rods) -> Table:
        return (weight(rods) * rods.twists)[:, None]

    def derivative(rods: Rods) -> Table:
        by_a = rods.binormals / (2.0 * rods.lengths[a][:, None])
        by_b = rods.binormals / (2.0 * rods.lengths[b][:, None])
        one = np.ones((len(a), 1))
        out = np.concatenate([-by_a, by_a - by_b, by_b, -one, one], axis=1)
        return (weight(rods)[:, None] * out)[:, None, :]

    def curvature(rods: Rods, weights: Table) -> Table:
        size = weights[:, 0] * weight(rods)
        return twist_blocks(layout.joints, rods.tangents, rods.lengths, rods.binormals, rods.openness, size)

    return Term(
        "twist", _joint_unknowns(layout) if unknowns is None else unknowns, residual, derivative, curvature
    )


def hat(vectors: Vectors) -> Table:
    """(n, 3, 3) matrices of the cross product ``v x``."""
    out = np.zeros((len(vectors), 3, 3))
    for x in range(3):
        y, z = (x + 1) % 3, (x + 2) % 3
        out[:, z, y], out[:, y, z] = vectors[:, x], -vectors[:, x]
    return out


# -- sliding --------------------------------------------------------------------------------------------


def sliding(layout: Layout, anchors: Vectors, normals: Vectors, normal: float, tangential: float) -> Term:
    """Return the energy that keeps vertices near anchors on a surface (E.1).

    ``k_n / 2 (n . (p - a))^2 + k_t / 2 |(I - n n') (p - a)|^2`` over vertices p with anchors a and unit
    normals n, both (V, 3); the stiffnesses are forces per length.
    """
    along = normals[:, :, None] * normals[:, None, :]
    root = np.sqrt(normal) * along + np.sqrt(tangential) * (np.eye(3) - along)

    def residual(rods: Rods) -> Table:
        return np.einsum("nxy,ny->nx", root, rods.points - anchors)

    unknowns = point_unknowns(np.arange(layout.vertices)[:, None])
    return Term("sliding", frozen(unknowns), residual, lambda rods: root)


# -- where the energy is --------------------------------------------------------------------------------


def energy_density(rods: Rods) -> dict[str, Scalars]:
    """Elastic energy per length of each segment, by its cause (Fig. 23).

    The energy of a joint is shared by its two segments.

    Returns
    -------
    For "stretching", "normal curvature", "geodesic curvature" and "twist", (S,) force.

    Examples
    --------
    >>> rods = gw.elastic_rods(gw.weave_pattern(gw.shapes.cone(faces=400), ribbons=8)).rods
    >>> density = gw.rods.energy_density(rods)
    >>> bool(density["geodesic curvature"].mean() > density["normal curvature"].mean())
    True
    """
    a, b = rods.layout.joints.T
    found = {}
    for term in elastic_terms(rods.layout):
        energy = (0.5 * term.residual(rods) ** 2).sum(axis=1)
        if term.name != STRETCHING:
            shared = np.zeros(rods.layout.segments)
            np.add.at(shared, a, 0.5 * energy)
            np.add.at(shared, b, 0.5 * energy)
            energy = shared
        found[term.name] = frozen(energy / rods.rest)
    return found
