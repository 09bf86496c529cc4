"""The energies of contacts between rods, as sums of squares (Appendix E.2).

A crossing holds its two rods a thickness apart and their thickness directions parallel. Both energies are
`geoweave.rods.elastic_energies.Term` values.
"""

from __future__ import annotations

import numpy as np

from geoweave.arrays import Indices, Scalars, Vectors, cross, frozen
from geoweave.rods.compiled_stencils import director_blocks
from geoweave.rods.elastic_energies import Table, Term, hat, point_unknowns
from geoweave.rods.rods import Rods

__all__ = ["ORIENTATION", "SIDE", "contact_orientation", "contact_position", "contact_side"]

ORIENTATION = "contact orientation"
"""The name of the energy that makes crossing ribbons lie flush."""

SIDE = "contact side"
"""The name of the barrier that keeps the sign of crossing angles."""

KEPT = 0.25
"""The barrier acts where the sine of a crossing angle falls below this share of what it was."""


def _contact_unknowns(rods: Rods) -> Indices:
    """(C, 14) the ends of both segments and their angles."""
    pair = rods.contacts.segments
    vertices = rods.layout.ends[pair].reshape(-1, 4)
    return frozen(np.concatenate([point_unknowns(vertices), 3 * rods.layout.vertices + pair], axis=1))


def _director_derivative(rods: Rods, segments: Indices) -> Table:
    """(C, 3, 7) derivative of tau by the start, the end and the angle of its segment."""
    tangent, director = rods.tangents[segments], rods.directors[segments]
    tilt = -tangent[:, :, None] * director[:, None, :] / rods.lengths[segments][:, None, None]
    return np.concatenate([-tilt, tilt, rods.across[segments][:, :, None]], axis=2)


def _add_director_curvature(
    rods: Rods, segments: Indices, vectors: Vectors, own: Indices, out: Table
) -> None:
    """Add the second derivative of ``v . tau`` by the start, the end and the angle of its segment."""
    director_blocks(segments, rods.tangents, rods.directors, rods.across, rods.lengths, vectors, own, out)


OWN = (np.array([0, 1, 2, 3, 4, 5, 12]), np.array([6, 7, 8, 9, 10, 11, 13]))
"""Columns of a contact's unknowns that belong to its first and to its second segment."""


def contact_position(rods: Rods, stiffness: float, apart: float | None = None) -> Term:
    """Return the energy that holds crossing centrelines a thickness apart (E.2), with g = ``stiffness``.

    ``g (|c_a + e h tau_a - c_b|^2 + |c_b - e h tau_b - c_a|^2)``, with e = 1 where b lies above a and -1
    where it lies below. ``apart`` takes the place of the thickness h.
    """
    pair, places = rods.contacts.segments, rods.contacts.places
    side = np.where(rods.contacts.over == 1, 1.0, -1.0) * (
        rods.material.thickness if apart is None else apart
    )
    # On a one-sided weave some contacts have tau_b opposite to tau_a.
    side = np.stack([side, side * _agreement(rods)], axis=1)
    weight = np.sqrt(2.0 * stiffness)

    def gap(rods: Rods) -> Vectors:
        """(C, 3) ``c_a - c_b``; differences of edges keep digits that differences of points lose."""
        start = rods.layout.ends[pair, 0]
        along = places[..., None] * rods.edges[pair]
        return (rods.points[start[:, 0]] - rods.points[start[:, 1]]) + (along[:, 0] - along[:, 1])

    def residual(rods: Rods) -> Table:
        apart, tau = gap(rods), side[..., None] * rods.directors[pair]
        return weight * np.concatenate([apart + tau[:, 0], -apart - tau[:, 1]], axis=1)

    def derivative(rods: Rods) -> Table:
        out = np.zeros((len(pair), 6, 14))
        eye = np.eye(3)
        for k, sign in enumerate((1.0, -1.0)):
            start, end = (1.0 - places[:, k])[:, None, None] * eye, places[:, k][:, None, None] * eye
            first = 6 * k
            out[:, :3, first : first + 3], out[:, :3, first + 3 : first + 6] = sign * start, sign * end
        out[:, 3:] = -out[:, :3]
        for k, sign in enumerate((1.0, -1.0)):
            tilt = sign * side[:, k][:, None, None] * _director_derivative(rods, pair[:, k])
            out[:, 3 * k : 3 * k + 3, OWN[k]] += tilt
        return weight * out

    def curvature(rods: Rods, weights: Table) -> Table:
        out = np.zeros((len(pair), 14, 14))
        for k, sign in enumerate((1.0, -1.0)):
            pull = weight * sign * side[:, k][:, None] * weights[:, 3 * k : 3 * k + 3]
            _add_director_curvature(rods, pair[:, k], pull, OWN[k], out)
        return out

    return Term("contact position", _contact_unknowns(rods), residual, derivative, curvature)


def contact_orientation(rods: Rods, stiffness: float) -> Term:
    """Return the energy that makes crossing ribbons lie flush (E.2), ``g angle(tau_a, tau_b)^2``.

    The residual is the rotation vector that takes one direction to the other. Unlike the angle it is smooth
    where the angle is zero. A strip has no upper side: the angle is measured to tau_b or to -tau_b, whichever
    is nearer when the term is made. The stiffness g is force x length per radian squared.
    """
    pair = rods.contacts.segments
    sign = _agreement(rods)[:, None]
    weight = np.sqrt(2.0 * stiffness)

    def parts(rods: Rods) -> tuple[Vectors, Vectors, Vectors, Scalars, Scalars]:
        one, two = rods.directors[pair[:, 0]], sign * rods.directors[pair[:, 1]]
        axis = cross(one, two)
        factor, slope = _arc((one * two).sum(axis=1), np.sqrt((axis**2).sum(axis=1)))
        return one, two, axis, factor, slope

    def residual(rods: Rods) -> Table:
        _, _, axis, factor, _ = parts(rods)
        return weight * factor[:, None] * axis

    def derivative(rods: Rods) -> Table:
        one, two, axis, factor, slope = parts(rods)
        out = np.zeros((len(pair), 3, 14))
        for k, (other, handed, flip) in enumerate(
            ((two, -1.0, np.ones_like(sign)), (one, 1.0, sign)),
        ):
            turn = flip[:, :, None] * _director_derivative(rods, pair[:, k])
            spin = handed * factor[:, None, None] * cross(other[:, None, :], turn.transpose(0, 2, 1))
            cosine = np.einsum("nx,nxk->nk", other, turn)
            out[:, :, OWN[k]] = (
                spin.transpose(0, 2, 1) + (slope[:, None] * axis)[:, :, None] * cosine[:, None]
            )
        return weight * out

    def curvature(rods: Rods, weights: Table) -> Table:
        """Second derivative with the angle taken for its sine; exact where ribbons lie flush."""
        one, two = rods.directors[pair[:, 0]], sign * rods.directors[pair[:, 1]]
        pull = weight * weights
        turn = [_director_derivative(rods, pair[:, k]) for k in (0, 1)]
        turn[1] = sign[:, :, None] * turn[1]
        mixed = -turn[0].transpose(0, 2, 1) @ hat(pull) @ turn[1]
        out = np.zeros((len(pair), 14, 14))
        _add_director_curvature(rods, pair[:, 0], cross(two, pull), OWN[0], out)
        _add_director_curvature(rods, pair[:, 1], sign * cross(pull, one), OWN[1], out)
        out[:, OWN[0][:, None], OWN[1]] = mixed
        out[:, OWN[1][:, None], OWN[0]] = mixed.transpose(0, 2, 1)
        return out

    return Term(ORIENTATION, _contact_unknowns(rods), residual, derivative, curvature)


def contact_side(rods: Rods, stiffness: float) -> Term:
    """Return the barrier that keeps the sign of crossing angles (DEVIATIONS, order).

    ``g / 2 max(m / x - 1, 0)^2``, where x is ``(t_a x t_b) . tau_a`` with the sign it has at the start, and
    the energy is infinite where x is not positive. The barrier acts below ``m = KEPT x``, x at the start, so
    that it is zero for nearly all crossings. The stiffness g is force x length.
    """
    pair = rods.contacts.segments
    one, two = pair.T

    def sine(rods: Rods) -> Scalars:
        normal = cross(rods.tangents[one], rods.tangents[two])
        return np.asarray((normal * rods.directors[one]).sum(axis=1))

    start = sine(rods)
    sign, least = np.where(start < 0, -1.0, 1.0), KEPT * np.abs(start)
    weight = np.sqrt(stiffness)

    def residual(rods: Rods) -> Table:
        x = sign * sine(rods)
        safe = np.where(x > 0, x, 1.0)
        inside = np.where(x > 0, np.maximum(least / safe - 1.0, 0.0), np.inf)
        return weight * np.where(least > 0, inside, 0.0)[:, None]

    def derivative(rods: Rods) -> Table:
        out = np.zeros((len(pair), 1, 14))
        x = sign * sine(rods)
        near = (x > 0) & (x < least)
        a, b = one[near], two[near]
        tau, across = rods.directors[a], rods.across[a]
        ta, tb = rods.tangents[a], rods.tangents[b]
        by_a = cross(tb, tau)
        by_a = (by_a - (by_a * ta).sum(axis=1)[:, None] * ta) / rods.lengths[a][:, None]
        by_b = -(across - (across * tb).sum(axis=1)[:, None] * tb) / rods.lengths[b][:, None]
        spin = (tb * tau).sum(axis=1)[:, None]
        slope = np.concatenate([-by_a, by_a, -by_b, by_b, spin, np.zeros_like(spin)], axis=1)
        out[near, 0] = (-weight * sign * least / np.where(x > 0, x, 1.0) ** 2)[near][:, None] * slope
        return out

    return Term(SIDE, _contact_unknowns(rods), residual, derivative)


def _agreement(rods: Rods) -> Scalars:
    """(C,) 1 where the thickness directions of a contact point to the same side, -1 where they do not."""
    one, two = rods.contacts.segments.T
    return np.where((rods.directors[one] * rods.directors[two]).sum(axis=1) < 0, -1.0, 1.0)


def _arc(cosine: Scalars, sine: Scalars) -> tuple[Scalars, Scalars]:
    """Angle over its sine, and the derivative of this ratio by the cosine; a series near angle zero."""
    small = (sine < 1e-2) & (cosine > 0)
    sine = np.where(small, 1.0, np.maximum(sine, 1e-12))
    factor = np.arctan2(sine, cosine) / sine
    slope = (cosine * factor - 1.0) / sine**2
    x = 1.0 - cosine  # series in x, about angle^2 / 2; the first term left out is below 1e-12
    near = 1.0 + x * (1 / 3 + x * (2 / 15 + x * 2 / 35))
    return np.where(small, near, factor), np.where(small, -(1 / 3 + x * (4 / 15 + x * 6 / 35)), slope)
