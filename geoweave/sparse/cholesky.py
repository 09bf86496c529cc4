"""A sparse Cholesky factorisation for matrices of surfaces: supernodal, multifrontal, in dense blocks.

SuperLU, which is used elsewhere, ignores symmetry and works column by column. Here columns of similar pattern
are gathered into supernodes. Each is eliminated by dense matrix products (Duff and Reid 1983, Liu 1992).
The module works on matrices and never on meshes.
"""

from __future__ import annotations

from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from geoweave.arrays import Indices, Scalars
from geoweave.compiled import compiled
from geoweave.errors import GeoweaveError
from geoweave.sparse.symbolic import Matrix, Symbolic, analysed, upper_triangle

__all__ = ["NotDefiniteError", "Symbolic", "analysed", "factor", "solve"]

PANEL = 48
"""Rows that dense products take at a time; narrower blocks are worked through entry by entry."""

NARROW = 8
"""Columns up to which a supernode is worked through entry by entry: a dense product costs more to call."""


Entries: TypeAlias = NDArray[Any]
"""Numbers of a factor, of double or single precision."""


class NotDefiniteError(GeoweaveError):
    """The matrix is not positive definite to working precision."""


@compiled
def _factor(
    first: Indices,
    rows: Indices,
    row_start: Indices,
    parent: Indices,
    block_start: Indices,
    start: Indices,
    index: Indices,
    value: Entries,
    entries: Entries,
    largest: int,
) -> int:
    """Eliminate supernode by supernode. Returns -1, or the column at which the matrix was not definite.

    A block holds the inverse of the diagonal block's Cholesky factor (w x w), then the rows below (m x w).
    """
    count = len(first) - 1
    place = np.empty(first[count], dtype=np.int64)
    # Updates are kept on a stack. In postorder the top ones are those of the children.
    stack = np.empty(4 * largest * largest, dtype=entries.dtype)
    room = np.empty(largest * largest, dtype=entries.dtype)
    top = 0
    waiting = np.empty(count, dtype=np.int64)
    waiting_count = 0
    for s in range(count):
        low, high = first[s], first[s + 1]
        width = high - low
        begin, end = row_start[s], row_start[s + 1]
        size = end - begin
        for p in range(begin, end):
            place[rows[p]] = p - begin
        for k in range(size * size):
            room[k] = 0.0
        for j in range(low, high):
            for p in range(start[j], start[j + 1]):
                room[place[index[p]] * size + j - low] += value[p]
        while waiting_count > 0 and parent[waiting[waiting_count - 1]] == s:
            waiting_count -= 1
            child = waiting[waiting_count]
            begin_c = row_start[child] + first[child + 1] - first[child]
            m = row_start[child + 1] - begin_c
            top -= m * m
            for a in range(m):
                line = place[rows[begin_c + a]] * size
                for b in range(a + 1):
                    room[line + place[rows[begin_c + b]]] += stack[top + a * m + b]
        m = size - width
        if m > 0 and top + m * m > len(stack):
            more = np.empty(2 * (top + m * m), dtype=entries.dtype)
            more[:top] = stack[:top]
            stack = more
        front = room[: size * size].reshape((size, size))
        block = entries[block_start[s] : block_start[s] + width * size].reshape((size, width))
        bad = _eliminate(front, block, stack[top : top + m * m])
        if bad >= 0:
            return low + bad
        if m > 0:
            top += m * m
            waiting[waiting_count] = s
            waiting_count += 1
    return -1


@compiled
def _eliminate(front: Entries, block: Entries, left: Entries) -> int:
    """Eliminate the first columns of a front: fills their block of the factor and the (m m) update left.

    Returns the first column at which the front was not definite, or -1. Only lower triangles are used.
    """
    size, width = block.shape
    m = size - width
    diagonal = np.empty((width, width), dtype=block.dtype)
    for b in range(width):
        for a in range(b, width):
            diagonal[a, b] = front[a, b]
            diagonal[b, a] = front[a, b]
    inverse = np.empty((width, width), dtype=block.dtype)
    bad = _inverse_factor(diagonal, inverse)
    if bad >= 0:
        return bad
    block[:width] = inverse
    if width <= NARROW:
        column = np.empty(m, dtype=block.dtype)
        for a in range(m):
            for b in range(a + 1):
                left[a * m + b] = front[width + a, width + b]
        for k in range(width):
            for a in range(m):
                total = block.dtype.type(0.0)
                for j in range(k + 1):
                    total += front[width + a, j] * inverse[k, j]
                column[a] = total
                block[width + a, k] = total
            for a in range(m):
                share = column[a]
                for b in range(a + 1):
                    left[a * m + b] -= share * column[b]
    elif m > 0:
        solved = np.dot(np.ascontiguousarray(front[width:, :width]), np.ascontiguousarray(inverse.T))
        block[width:] = solved
        # Only the lower triangle is needed: each row panel is multiplied by the rows up to its end.
        for panel in range(0, m, PANEL):
            stop = min(m, panel + PANEL)
            update = np.dot(solved[panel:stop], solved[:stop].T)
            for a in range(panel, stop):
                for b in range(a + 1):
                    left[a * m + b] = front[width + a, width + b] - update[a - panel, b]
    return -1


@compiled
def _inverse_factor(matrix: Entries, inverse: Entries) -> int:
    """Invert the Cholesky factor of a dense block. Returns the first row at which that fails, or -1.

    Wide blocks are cut in two, [A, B'; B, C]: the factor's inverse is [P, 0; -Q B P' P, Q], with P for A and
    Q for the Schur complement C - B P' P B'.
    """
    n = len(matrix)
    if n > PANEL:
        half = n // 2
        first = np.empty((half, half), dtype=matrix.dtype)
        bad = _inverse_factor(np.ascontiguousarray(matrix[:half, :half]), first)
        if bad >= 0:
            return bad
        reduced = np.dot(np.ascontiguousarray(matrix[half:, :half]), first.T)
        rest = matrix[half:, half:] - np.dot(reduced, reduced.T)
        second = np.empty((n - half, n - half), dtype=matrix.dtype)
        bad = _inverse_factor(rest, second)
        if bad >= 0:
            return half + bad
        inverse[:half, :half] = first
        inverse[:half, half:] = 0.0
        inverse[half:, :half] = -np.dot(second, np.dot(reduced, first))
        inverse[half:, half:] = second
        return -1
    lower = np.zeros((n, n), dtype=matrix.dtype)
    for j in range(n):
        for i in range(j, n):
            total = matrix[i, j]
            for k in range(j):
                total -= lower[i, k] * lower[j, k]
            if i == j:
                if not total > 0.0:
                    return j
                lower[j, j] = np.sqrt(total)
            else:
                lower[i, j] = total / lower[j, j]
    inverse[:] = 0.0
    for i in range(n):
        for k in range(i):
            share = lower[i, k]
            for j in range(k + 1):
                inverse[i, j] -= share * inverse[k, j]
        for j in range(i):
            inverse[i, j] /= lower[i, i]
        inverse[i, i] = 1.0 / lower[i, i]
    return -1


@compiled
def _solve(
    first: Indices,
    rows: Indices,
    row_start: Indices,
    block_start: Indices,
    entries: Entries,
    x: Entries,
) -> None:
    """Solve L L' x = b in place, supernode by supernode; narrow supernodes entry by entry."""
    count = len(first) - 1
    part = np.empty(NARROW, dtype=x.dtype)
    for s in range(count):
        low, width = first[s], first[s + 1] - first[s]
        begin, size = row_start[s], row_start[s + 1] - row_start[s]
        out = block_start[s]
        if width <= NARROW:
            for a in range(width):
                total = x.dtype.type(0.0)
                for b in range(a + 1):
                    total += entries[out + a * width + b] * x[low + b]
                part[a] = total
            for a in range(width):
                x[low + a] = part[a]
            for a in range(width, size):
                total = x.dtype.type(0.0)
                for b in range(width):
                    total += entries[out + a * width + b] * part[b]
                x[rows[begin + a]] -= total
            continue
        block = entries[out : out + width * size].reshape((size, width))
        own = np.dot(block[:width], x[low : low + width])
        x[low : low + width] = own
        if size > width:
            below = np.dot(block[width:], own)
            for a in range(size - width):
                x[rows[begin + width + a]] -= below[a]
    for s in range(count - 1, -1, -1):
        low, width = first[s], first[s + 1] - first[s]
        begin, size = row_start[s], row_start[s + 1] - row_start[s]
        out = block_start[s]
        if width <= NARROW:
            for b in range(width):
                part[b] = x[low + b]
            for a in range(width, size):
                share = x[rows[begin + a]]
                for b in range(width):
                    part[b] -= share * entries[out + a * width + b]
            for b in range(width):
                total = x.dtype.type(0.0)
                for a in range(b, width):
                    total += entries[out + a * width + b] * part[a]
                x[low + b] = total
            continue
        block = entries[out : out + width * size].reshape((size, width))
        own = x[low : low + width].copy()
        if size > width:
            below = np.empty(size - width, dtype=x.dtype)
            for a in range(size - width):
                below[a] = x[rows[begin + width + a]]
            own -= np.dot(below, block[width:])
        x[low : low + width] = np.dot(own, block[:width])


def factor(matrix: Matrix, symbolic: Symbolic, single: bool = False) -> Entries:
    """Entries of the Cholesky factor of a positive definite matrix with an analysed pattern.

    In single precision they take half the room and half the time.

    Raises
    ------
    NotDefiniteError
        If a pivot is not positive.
    """
    csr = sparse.csr_array(matrix)
    start, rows = symbolic.lower_start, symbolic.lower_rows
    if symbolic.fits(csr):
        values = csr.data[symbolic.place]
    else:
        # The pattern differs, since some entries are missing: it is computed again from this matrix.
        upper, place = upper_triangle(csr, symbolic.order)
        lower = sparse.csc_array(sparse.csc_array((csr.data[place], upper.indices, upper.indptr)).T)
        start, rows, values = lower.indptr.astype(np.int64), lower.indices.astype(np.int64), lower.data
    entries = np.empty(symbolic.fill, dtype=np.float32 if single else np.float64)
    bad = _factor(
        symbolic.first, symbolic.rows, symbolic.row_start, symbolic.parent, symbolic.block_start,
        start, rows, np.asarray(values, dtype=entries.dtype), entries, symbolic.workspace,
    )  # fmt: skip
    if bad >= 0:
        raise NotDefiniteError(f"row {int(symbolic.order[bad])} makes the matrix indefinite")
    return entries


def solve(symbolic: Symbolic, entries: Entries, right: Scalars) -> Scalars:
    """Solve with the factor for one right-hand side (n,), in the precision of its entries."""
    x = right[symbolic.order].astype(entries.dtype)
    _solve(symbolic.first, symbolic.rows, symbolic.row_start, symbolic.block_start, entries, x)
    solution = np.empty_like(right)
    solution[symbolic.order] = x
    return solution
