"""Pattern of a sparse Cholesky factor: elimination tree, supernodes and their rows.

It depends only on the pattern of the matrix and on the elimination order (Liu 1992). So one analysis serves
every matrix of that pattern. The module works on matrices and never on meshes.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from scipy import sparse

from geoweave.arrays import Indices
from geoweave.compiled import compiled

__all__ = ["Matrix", "Symbolic", "analysed", "upper_triangle"]

Matrix: TypeAlias = sparse.csr_array | sparse.csc_array | sparse.dia_array
"""A square sparse matrix."""


@dataclass(frozen=True, eq=False)
class Symbolic:
    """Pattern of the factor, which depends only on the matrix's pattern and the elimination order.

    Attributes
    ----------
    order : (n,) row ``order[k]`` of the matrix is eliminated in step k
    first : (S + 1,) first column of each supernode; its columns are consecutive
    rows, row_start : rows of each supernode's block, ascending, its own columns first; and where they begin
    parent : (S,) supernode that receives the update matrix of each supernode, -1 for a root
    block_start : (S + 1,) where each block begins among the factor's entries
    starts, columns : the analysed pattern, by rows
    lower_start, lower_rows : lower triangle of the permuted pattern, by columns
    place : positions of that triangle's entries among those of the matrix
    """

    order: Indices
    first: Indices
    rows: Indices
    row_start: Indices
    parent: Indices
    block_start: Indices
    workspace: int
    starts: Indices
    columns: Indices
    lower_start: Indices
    lower_rows: Indices
    place: Indices

    def fits(self, matrix: sparse.csr_array) -> bool:
        """Whether a matrix has the analysed pattern."""
        return np.array_equal(matrix.indptr, self.starts) and np.array_equal(matrix.indices, self.columns)

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
    """Nodes of a forest, children before parents, each subtree contiguous."""
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
    """Count the entries in each column of the factor, diagonal included, by walking the row subtrees."""
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
            # Columns of one chain may differ by a few rows: storing zeros is cheaper than using small blocks.
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


def analysed(matrix: Matrix, order: Indices) -> Symbolic:
    """Find the supernodes of a symmetric pattern in a given elimination order."""
    csr = sparse.csr_array(matrix)
    n = csr.shape[0]
    upper, _ = upper_triangle(csr, order)
    tree = _tree(n, upper.indptr.astype(np.int64), upper.indices.astype(np.int64))
    order = order[_postorder(tree)]
    upper, place = upper_triangle(csr, order)
    start, index = upper.indptr.astype(np.int64), upper.indices.astype(np.int64)
    tree = _tree(n, start, index)
    counts = _counts(n, start, index, tree)
    first = _supernodes(tree, counts, 0.2)
    lower = sparse.csc_array((place, upper.indices, upper.indptr), shape=(n, n)).T.tocsc()
    lower.sort_indices()
    lower_start, lower_rows = lower.indptr.astype(np.int64), lower.indices.astype(np.int64)
    rows, row_start, parent, largest = _patterns(first, lower_start, lower_rows, 4 * n)
    block_start = np.concatenate([[0], np.cumsum(np.diff(first) * np.diff(row_start))])
    return Symbolic(
        order, first, rows, row_start, parent, block_start, int(largest),
        csr.indptr.astype(np.int64), csr.indices.astype(np.int64),
        lower_start, lower_rows, np.asarray(lower.data, dtype=np.int64),
    )  # fmt: skip


def upper_triangle(matrix: sparse.csr_array, order: Indices) -> tuple[sparse.csc_array, Indices]:
    """Upper triangle of the permuted pattern, by columns, and the positions of its entries in the matrix."""
    numbered = sparse.csr_array((np.arange(matrix.nnz), matrix.indices, matrix.indptr), shape=matrix.shape)
    upper = sparse.triu(numbered.tocsc()[order][:, order], format="csc")
    return upper, np.asarray(upper.data, dtype=np.int64)
