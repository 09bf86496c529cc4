"""Second derivatives of joints and contacts, and their sum in the matrix, in compiled loops.

The formulas are those that `geoweave.rods.elastic_energies` and `contact_energies` state. There each is a
derivative by the two edges of a joint, or by a segment. Here a loop writes it by vertices and angles at once:
with edges ``e = p1 - p0`` and ``e' = p2 - p1`` and second derivatives A by e, B by e' and C by both, the
blocks by vertices are ``A, C - A, -C; A - C - C' + B, C - B; B``.
"""

from __future__ import annotations

from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from geoweave.arrays import Indices, Scalars, Vectors
from geoweave.compiled import compiled

__all__ = ["add_stencils", "bending_blocks", "director_blocks", "local_gradient", "twist_blocks"]

Block: TypeAlias = NDArray[Any]
"""A table of stencils, or a row of one."""


@compiled
def _cross(one: Block, two: Block, out: Block) -> None:
    """Write the cross product of two vectors."""
    out[0] = one[1] * two[2] - one[2] * two[1]
    out[1] = one[2] * two[0] - one[0] * two[2]
    out[2] = one[0] * two[1] - one[1] * two[0]


@compiled
def _dot(one: Block, two: Block) -> float:
    """Dot product of two vectors."""
    return one[0] * two[0] + one[1] * two[1] + one[2] * two[2]


@compiled
def _by_vertices(aa: Block, bb: Block, ab: Block, size: float, out: Block) -> None:
    """Write the blocks of three vertices from those of two edges."""
    for x in range(3):
        for y in range(3):
            a, b, c, d = size * aa[x, y], size * bb[x, y], size * ab[x, y], size * ab[y, x]
            out[x, y] = a
            out[x, 3 + y] = c - a
            out[3 + y, x] = c - a
            out[x, 6 + y] = -c
            out[6 + y, x] = -c
            out[3 + x, 3 + y] = a - c - d + b
            out[3 + x, 6 + y] = c - b
            out[6 + y, 3 + x] = c - b
            out[6 + x, 6 + y] = b


@compiled
def bending_blocks(
    joints: Indices,
    tangents: Vectors,
    lengths: Scalars,
    binormals: Vectors,
    openness: Scalars,
    frame: Vectors,
    turned: Vectors,
    size: Scalars,
) -> Block:
    """(J, 11, 11) second derivatives of ``size kb . (f + f') / 2`` by the vertices and angles of joints.

    Parameters
    ----------
    frame : (S, 3) the material direction f of each segment
    turned : (S, 3) its derivative by the angle of the segment
    size : (J,) factors
    """
    out = np.zeros((len(joints), 11, 11))
    aa, bb, ab = np.empty((3, 3)), np.empty((3, 3)), np.empty((3, 3))
    middle, mean, left, right, one = np.empty(3), np.empty(3), np.empty(3), np.empty(3), np.empty(3)
    for j in range(len(joints)):
        a, b = joints[j, 0], joints[j, 1]
        ta, tb, kb, chi = tangents[a], tangents[b], binormals[j], openness[j]
        fa, fb, la, lb, factor = frame[a], frame[b], lengths[a], lengths[b], size[j]
        bent = 0.0
        for x in range(3):
            middle[x] = (fa[x] + fb[x]) / chi
            mean[x] = (ta[x] + tb[x]) / chi
            bent += 0.5 * kb[x] * (fa[x] + fb[x])
        _cross(tb, middle, left)
        _cross(ta, middle, right)
        flat = bent / chi
        for x in range(3):
            for y in range(3):
                eye = 1.0 if x == y else 0.0
                both = 2.0 * bent * mean[x] * mean[y]
                aa[x, y] = (
                    both - (left[x] * mean[y] + mean[x] * left[y]) - flat * (eye - ta[x] * ta[y])
                    + 0.25 * (kb[x] * fa[y] + fa[x] * kb[y])
                ) / (la * la)  # fmt: skip
                bb[x, y] = (
                    both + (right[x] * mean[y] + mean[x] * right[y]) - flat * (eye - tb[x] * tb[y])
                    + 0.25 * (kb[x] * fb[y] + fb[x] * kb[y])
                ) / (lb * lb)  # fmt: skip
                ab[x, y] = both - flat * (eye + ta[x] * tb[y]) - left[x] * mean[y] + mean[x] * right[y]
        for x in range(3):  # less the matrix of the cross product with `middle`
            y, z = (x + 1) % 3, (x + 2) % 3
            ab[z, y] -= middle[x]
            ab[y, z] += middle[x]
        ab /= la * lb
        own = out[j]
        _by_vertices(aa, bb, ab, factor, own)
        for k in range(2):
            s = a if k == 0 else b
            spin = turned[s]
            half = 0.5 * _dot(kb, spin)
            _cross(tb, spin, one)
            along = _dot(one, ta) - half * _dot(tb, ta)
            for x in range(3):
                value = factor * (one[x] - half * tb[x] - along * ta[x]) / (chi * la)
                own[x, 9 + k] -= value
                own[3 + x, 9 + k] += value
            _cross(spin, ta, one)
            along = _dot(one, tb) - half * _dot(ta, tb)
            for x in range(3):
                value = factor * (one[x] - half * ta[x] - along * tb[x]) / (chi * lb)
                own[3 + x, 9 + k] -= value
                own[6 + x, 9 + k] += value
            for x in range(9):
                own[9 + k, x] = own[x, 9 + k]
            own[9 + k, 9 + k] = -0.5 * factor * _dot(kb, frame[s])
    return out


@compiled
def twist_blocks(
    joints: Indices,
    tangents: Vectors,
    lengths: Scalars,
    binormals: Vectors,
    openness: Scalars,
    size: Scalars,
) -> Block:
    """(J, 11, 11) second derivatives of ``size m``, m the angle of twist, as of `bending_blocks`."""
    out = np.zeros((len(joints), 11, 11))
    aa, bb, ab, mean = np.empty((3, 3)), np.empty((3, 3)), np.empty((3, 3)), np.empty(3)
    for j in range(len(joints)):
        a, b = joints[j, 0], joints[j, 1]
        ta, tb, kb, chi = tangents[a], tangents[b], binormals[j], openness[j]
        la, lb = lengths[a], lengths[b]
        for x in range(3):
            mean[x] = (ta[x] + tb[x]) / chi
        for x in range(3):
            for y in range(3):
                aa[x, y] = -0.25 * (kb[x] * (ta[y] + mean[y]) + (ta[x] + mean[x]) * kb[y]) / (la * la)
                bb[x, y] = -0.25 * (kb[x] * (tb[y] + mean[y]) + (tb[x] + mean[x]) * kb[y]) / (lb * lb)
                ab[x, y] = -0.5 * kb[x] * mean[y]
        for x in range(3):
            y, z = (x + 1) % 3, (x + 2) % 3
            ab[z, y] += ta[x] / chi
            ab[y, z] -= ta[x] / chi
        ab /= la * lb
        _by_vertices(aa, bb, ab, size[j], out[j])
    return out


@compiled
def director_blocks(
    segments: Indices,
    tangents: Vectors,
    directors: Vectors,
    across: Vectors,
    lengths: Scalars,
    vectors: Vectors,
    place: Indices,
    out: Block,
) -> None:
    """Add second derivatives of ``v . tau`` to (C, 14, 14) blocks, at the columns ``place`` (7,) of each.

    The columns are those of the start, the end and the angle of each contact's segment.
    """
    for c in range(len(segments)):
        s = segments[c]
        t, tau, side, length, v, own = tangents[s], directors[s], across[s], lengths[s], vectors[c], out[c]
        by_t, by_tau, by_side = _dot(v, t), _dot(v, tau), _dot(v, side)
        for x in range(3):
            for y in range(3):
                edge = (
                    by_t * (tau[x] * t[y] + t[x] * tau[y]) - by_tau * tau[x] * tau[y]
                    - 0.5 * by_side * (tau[x] * side[y] + side[x] * tau[y])
                ) / (length * length)  # fmt: skip
                own[place[x], place[y]] += edge
                own[place[3 + x], place[3 + y]] += edge
                own[place[x], place[3 + y]] -= edge
                own[place[3 + x], place[y]] -= edge
            spin = by_t * side[x] / length
            own[place[x], place[6]] += spin
            own[place[6], place[x]] += spin
            own[place[3 + x], place[6]] -= spin
            own[place[6], place[3 + x]] -= spin
        own[place[6], place[6]] -= by_tau


@compiled
def add_stencils(data: Scalars, slots: Block, jacobian: Block, extra: Block) -> None:
    """Add ``J' J``, and symmetric blocks, of each stencil to the entries of a matrix.

    Parameters
    ----------
    data : entries
    slots : (n, k, k) place of each local entry, -1 where it has none
    jacobian : (n, r, k)
    extra : (n, k, k) what is added to ``J' J``; (0, k, k) for nothing
    """
    n, r, k = jacobian.shape
    for i in range(n):
        for x in range(k):
            for y in range(x + 1):
                slot = slots[i, x, y]
                if slot >= 0:
                    total = extra[i, x, y] if len(extra) else 0.0
                    for row in range(r):
                        total += jacobian[i, row, x] * jacobian[i, row, y]
                    data[slot] += total
                    if x != y:
                        data[slots[i, y, x]] += total


@compiled
def local_gradient(unknowns: Indices, jacobian: Block, residual: Block, size: int) -> Scalars:
    """(size,) sum of ``J' r`` of all stencils."""
    out = np.zeros(size)
    n, r, k = jacobian.shape
    for i in range(n):
        for row in range(r):
            weight = residual[i, row]
            if weight != 0.0:
                for x in range(k):
                    out[unknowns[i, x]] += weight * jacobian[i, row, x]
    return out
