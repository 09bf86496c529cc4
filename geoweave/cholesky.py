"""A sparse Cholesky factorisation for matrices of surfaces: supernodal, multifrontal, in dense blocks.

SuperLU, which serves elsewhere, ignores symmetry and works column by column. Here columns of like pattern are
gathered into supernodes, and each is eliminated by dense matrix products (Duff and Reid 1983, Liu 1992).
The module knows matrices and never meshes.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from geoweave.arrays import Indices, Scalars
from geoweave.compiled import compiled
from geoweave.errors import GeoweaveError

Matrix: TypeAlias = sparse.csr_array | sparse.csc_array | sparse.dia_array

PANEL = 48
"""Rows that dense products take at a time; narrower blocks are worked through entry by entry."""


class NotDefiniteError(GeoweaveError):
    """The matrix is not positive definite to working precision."""


@dataclass(frozen=True, eq=False)
class Symbolic:
    """Where the entries of the factor will be: depends on the pattern and its order alone.

    Attributes
    ----------
    order : (n,) row ``order[k]`` of the matrix is eliminated in step k
    first : (S + 1,) first column of each supernode; its columns are consecutive
    rows, row_start : rows of each supernode's block, its own columns first, ascending; and where they begin
    parent : (S,) supernode that takes what a supernode leaves behind, -1 for a root
    block_start : (S + 1,) where each block begins among the factor's entries
    """

    order: Indices
    first: Indices
    rows: Indices
    row_start: Indices
    parent: Indices
    block_start: Indices
    workspace: int

    @property
    def fill(self) -> int:
        """Entries that the factor stores."""
        return int(self.block_start[-1])


@compiled
def _tree(n: int, start: Indices, index: Indices) -> Indices:
    """Elimination tree of a symmetric pattern given by its upper triangle, column by column (Liu 1986)."""
    parent = np.full(n, -1, dtype=np.int64)
    ancestor = np.full(n, -1, dtype=np.int64)
    for k in range(n):
        for p in range(start[k], start[k + 1]):
            i = index[p]
            while i != -1 and i < k:
                following = ancestor[i]
                ancestor[i] = k
                if following == -1:
                    parent[i] = k
                i = following
    return parent


@compiled
def _postorder(parent: Indices) -> Indices:
    """Nodes of a forest, children before parents, subtrees in one piece."""
    n = len(parent)
    head = np.full(n, -1, dtype=np.int64)
    after = np.full(n, -1, dtype=np.int64)
    for k in range(n - 1, -1, -1):
        if parent[k] != -1:
            after[k] = head[parent[k]]
            head[parent[k]] = k
    order = np.empty(n, dtype=np.int64)
    stack = np.empty(n, dtype=np.int64)
    count = 0
    for root in range(n):
        if parent[root] != -1:
            continue
        top = 0
        stack[0] = root
        while top >= 0:
            node = stack[top]
            child = head[node]
            if child == -1:
                order[count] = node
                count += 1
                top -= 1
            else:
                head[node] = after[child]
                top += 1
                stack[top] = child
    return order


@compiled
def _counts(n: int, start: Indices, index: Indices, parent: Indices) -> Indices:
    """Entries in each column of the factor, the diagonal included: by walking the row subtrees."""
    count = np.ones(n, dtype=np.int64)
    mark = np.full(n, -1, dtype=np.int64)
    for k in range(n):
        mark[k] = k
        for p in range(start[k], start[k + 1]):
            i = index[p]
            while i < k and mark[i] != k:
                mark[i] = k
                count[i] += 1
                i = parent[i]
    return count


@compiled
def _supernodes(parent: Indices, count: Indices, relax: float) -> Indices:
    """First columns of the supernodes: chains of the tree with nested patterns, and small ones merged."""
    n = len(parent)
    first = np.empty(n + 1, dtype=np.int64)
    used = 0
    zeros = 0.0
    for k in range(n):
        joined = False
        if k > 0 and parent[k - 1] == k:
            extra = count[k] + 1 - count[k - 1]
            width = k - first[used - 1]
            # Columns of one chain may differ by a few rows: the zeros stored are cheaper than small blocks.
            waste = zeros + extra * width
            total = 0.5 * (width + 1) * (width + 1) + count[k] * (width + 1.0)
            if extra == 0 or (waste <= relax * total and width < 256):
                joined = True
                zeros = waste
        if not joined:
            first[used] = k
            used += 1
            zeros = 0.0
    first[used] = n
    return first[: used + 1]


@compiled
def _patterns(
    first: Indices, start: Indices, index: Indices, room: int
) -> tuple[Indices, Indices, Indices, int]:
    """Rows of each supernode and the supernode tree, from the lower triangle of the matrix by columns."""
    count = len(first) - 1
    n = first[count]
    owner = np.empty(n, dtype=np.int64)
    for s in range(count):
        owner[first[s] : first[s + 1]] = s
    rows = np.empty(room, dtype=np.int64)
    row_start = np.zeros(count + 1, dtype=np.int64)
    parent = np.full(count, -1, dtype=np.int64)
    head = np.full(count, -1, dtype=np.int64)
    after = np.full(count, -1, dtype=np.int64)
    mark = np.full(n, -1, dtype=np.int64)
    largest = 0
    used = 0
    for s in range(count):
        low, high = first[s], first[s + 1]
        for j in range(low, high):
            mark[j] = s
        begin = used
        used += high - low
        need = used
        for j in range(low, high):
            need += start[j + 1] - start[j]
        child = head[s]
        while child != -1:
            need += row_start[child + 1] - row_start[child]
            child = after[child]
        if need > len(rows):
            more = np.empty(2 * need, dtype=np.int64)
            more[:begin] = rows[:begin]
            rows = more
        for j in range(low, high):
            rows[begin + j - low] = j
        for j in range(low, high):
            for p in range(start[j], start[j + 1]):
                i = index[p]
                if i >= high and mark[i] != s:
                    mark[i] = s
                    rows[used] = i
                    used += 1
        child = head[s]
        while child != -1:
            for p in range(row_start[child], row_start[child + 1]):
                i = rows[p]
                if i >= high and mark[i] != s:
                    mark[i] = s
                    rows[used] = i
                    used += 1
            child = after[child]
        below = begin + high - low
        rows[below:used] = np.sort(rows[below:used])
        row_start[s + 1] = used
        if used > below:
            parent[s] = owner[rows[below]]
            after[s] = head[parent[s]]
            head[parent[s]] = s
        largest = max(largest, used - begin)
    return rows[:used].copy(), row_start, parent, largest


@compiled
def _factor(
    first: Indices,
    rows: Indices,
    row_start: Indices,
    parent: Indices,
    block_start: Indices,
    start: Indices,
    index: Indices,
    value: Scalars,
    entries: Scalars,
    largest: int,
) -> int:
    """Eliminate supernode by supernode. Returns -1, or the column at which the matrix was not definite.

    A block holds the inverse of the diagonal block's Cholesky factor (w x w), then the rows below (m x w).
    """
    count = len(first) - 1
    place = np.empty(first[count], dtype=np.int64)
    # Updates wait on a stack: postorder makes the last ones those of the children.
    stack = np.empty(4 * largest * largest, dtype=np.float64)
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
        front = np.zeros((size, size), dtype=np.float64)
        for j in range(low, high):
            for p in range(start[j], start[j + 1]):
                front[place[index[p]], j - low] += value[p]
        while waiting_count > 0 and parent[waiting[waiting_count - 1]] == s:
            waiting_count -= 1
            child = waiting[waiting_count]
            begin_c = row_start[child] + first[child + 1] - first[child]
            m = row_start[child + 1] - begin_c
            top -= m * m
            for a in range(m):
                line = front[place[rows[begin_c + a]]]
                for b in range(a + 1):
                    line[place[rows[begin_c + b]]] += stack[top + a * m + b]
        diagonal = np.empty((width, width), dtype=np.float64)
        for b in range(width):
            for a in range(b, width):
                diagonal[a, b] = front[a, b]
                diagonal[b, a] = front[a, b]
        inverse = np.empty((width, width), dtype=np.float64)
        bad = _inverse_factor(diagonal, inverse)
        if bad >= 0:
            return low + bad
        out = block_start[s]
        for a in range(width):
            for b in range(width):
                entries[out + a * width + b] = inverse[a, b]
        m = size - width
        if m > 0:
            below = np.ascontiguousarray(front[width:, :width])
            solved = np.dot(below, np.ascontiguousarray(inverse.T))
            entries[out + width * width : out + width * size] = solved.ravel()
            if top + m * m > len(stack):
                more = np.empty(2 * (top + m * m), dtype=np.float64)
                more[:top] = stack[:top]
                stack = more
            # Only the lower triangle is wanted: row panels, each against the rows up to its end.
            for panel in range(0, m, PANEL):
                stop = min(m, panel + PANEL)
                update = np.dot(solved[panel:stop], solved[:stop].T)
                for a in range(panel, stop):
                    for b in range(a + 1):
                        stack[top + a * m + b] = front[width + a, width + b] - update[a - panel, b]
            top += m * m
            waiting[waiting_count] = s
            waiting_count += 1
    return -1


@compiled
def _inverse_factor(matrix: NDArray[np.float64], inverse: NDArray[np.float64]) -> int:
    """Inverse of the Cholesky factor of a dense block; the first row at which that fails, or -1.

    Wide blocks are cut in two, [A, B'; B, C]: the factor's inverse is [P, 0; -Q B P' P, Q], with P for A and
    Q for the Schur complement C - B P' P B'.
    """
    n = len(matrix)
    if n > PANEL:
        half = n // 2
        first = np.empty((half, half), dtype=np.float64)
        bad = _inverse_factor(np.ascontiguousarray(matrix[:half, :half]), first)
        if bad >= 0:
            return bad
        reduced = np.dot(np.ascontiguousarray(matrix[half:, :half]), first.T)
        rest = matrix[half:, half:] - np.dot(reduced, reduced.T)
        second = np.empty((n - half, n - half), dtype=np.float64)
        bad = _inverse_factor(rest, second)
        if bad >= 0:
            return half + bad
        inverse[:half, :half] = first
        inverse[:half, half:] = 0.0
        inverse[half:, :half] = -np.dot(second, np.dot(reduced, first))
        inverse[half:, half:] = second
        return -1
    lower = np.zeros((n, n), dtype=np.float64)
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
    entries: Scalars,
    x: Scalars,
) -> None:
    """Solve L L' x = b in place, supernode by supernode."""
    count = len(first) - 1
    for s in range(count):
        low, width = first[s], first[s + 1] - first[s]
        begin, size = row_start[s], row_start[s + 1] - row_start[s]
        out = block_start[s]
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
        block = entries[out : out + width * size].reshape((size, width))
        own = x[low : low + width].copy()
        if size > width:
            below = np.empty(size - width, dtype=np.float64)
            for a in range(size - width):
                below[a] = x[rows[begin + width + a]]
            own -= np.dot(below, block[width:])
        x[low : low + width] = np.dot(own, block[:width])


def analysed(matrix: Matrix, order: Indices) -> Symbolic:
    """Find the supernodes of a symmetric pattern in a given elimination order."""
    n = matrix.shape[0]
    permuted = _triangle(matrix, order)
    tree = _tree(n, permuted.indptr.astype(np.int64), permuted.indices.astype(np.int64))
    post = _postorder(tree)
    order = order[post]
    upper = _triangle(matrix, order)
    start, index = upper.indptr.astype(np.int64), upper.indices.astype(np.int64)
    tree = _tree(n, start, index)
    counts = _counts(n, start, index, tree)
    first = _supernodes(tree, counts, 0.2)
    lower = upper.T.tocsc()
    lower.sort_indices()
    rows, row_start, parent, largest = _patterns(
        first, lower.indptr.astype(np.int64), lower.indices.astype(np.int64), 4 * n
    )
    block_start = np.concatenate([[0], np.cumsum(np.diff(first) * np.diff(row_start))])
    return Symbolic(order, first, rows, row_start, parent, block_start, int(largest))


def _triangle(matrix: Matrix, order: Indices) -> sparse.csc_array:
    """Upper triangle of the permuted matrix, by columns."""
    permuted = sparse.csc_array(matrix)[order][:, order]
    return sparse.triu(permuted, format="csc")


def factor(matrix: Matrix, symbolic: Symbolic) -> Scalars:
    """Entries of the Cholesky factor of a positive definite matrix whose pattern was analysed.

    Raises
    ------
    NotDefiniteError
        If a pivot is not positive.
    """
    lower = sparse.csc_array(_triangle(matrix, symbolic.order).T)
    entries = np.empty(symbolic.fill)
    bad = _factor(
        symbolic.first, symbolic.rows, symbolic.row_start, symbolic.parent, symbolic.block_start,
        lower.indptr.astype(np.int64), lower.indices.astype(np.int64), lower.data, entries,
        symbolic.workspace,
    )  # fmt: skip
    if bad >= 0:
        raise NotDefiniteError(f"row {int(symbolic.order[bad])} makes the matrix indefinite")
    return entries


def solve(symbolic: Symbolic, entries: Scalars, right: Scalars) -> Scalars:
    """Solve with the factor for one right-hand side (n,)."""
    x = right[symbolic.order]
    _solve(symbolic.first, symbolic.rows, symbolic.row_start, symbolic.block_start, entries, x)
    solution = np.empty_like(x)
    solution[symbolic.order] = x
    return solution
