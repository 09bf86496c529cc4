"""The second derivative of the energy: its pattern is analysed once, its entries are summed at every step."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from scipy.sparse import csgraph

from geoweave.arrays import Flags, Indices, Scalars
from geoweave.rods.compiled_stencils import add_stencils
from geoweave.rods.elastic_energies import Table, Term
from geoweave.sparse import cholesky, nested_dissection

__all__ = ["Pattern", "analysed"]


Slots: TypeAlias = NDArray[np.int32]
"""Places among the entries of a matrix."""


@dataclass(frozen=True, eq=False)
class Pattern:
    """Where the entries of the matrix go; the same for all steps.

    Attributes
    ----------
    size : number of unknowns
    free : (n,) unknowns that may change, in elimination order
    symbolic : analysis of the Cholesky factor
    groups : terms that share their unknowns, and the (n, k, k) place in the matrix of each of their local
        entries, -1 for those that are not between free unknowns
    diagonal : (n,) place of each diagonal entry
    indices, starts : columns and row starts of the matrix (CSR)
    """

    size: int
    free: Indices
    symbolic: cholesky.Symbolic
    groups: tuple[tuple[tuple[int, ...], Slots], ...]
    diagonal: Slots
    indices: Indices
    starts: Indices

    def matrix(self, jacobians: Sequence[Table], curvatures: Sequence[Table | None]) -> sparse.csr_array:
        """Sum ``J' J`` and curvatures of all terms, on the free unknowns in elimination order."""
        data = np.zeros(len(self.indices))
        for members, slots in self.groups:
            local = np.concatenate([jacobians[m] for m in members], axis=1)
            given = [extra for m in members if (extra := curvatures[m]) is not None]
            total = sum(given[1:], given[0]) if given else np.zeros((0, *slots.shape[1:]))
            add_stencils(data, slots, local, total)
        return sparse.csr_array((data, self.indices, self.starts), shape=(len(self.free),) * 2)

    def shifted(self, matrix: sparse.csr_array, shift: Scalars) -> sparse.csr_array:
        """Add a diagonal (size,) to a matrix of this pattern."""
        data = matrix.data.copy()
        data[self.diagonal] += shift[self.free]
        return sparse.csr_array((data, self.indices, self.starts), shape=matrix.shape)


def analysed(size: int, terms: Sequence[Term], fixed: Flags) -> Pattern:
    """Analyse the pattern of the terms' matrix once: nested dissection, and a slot for each local entry."""
    groups: list[tuple[Indices, list[int]]] = []
    for number, term in enumerate(terms):
        same = [members for unknowns, members in groups if np.array_equal(unknowns, term.unknowns)]
        if same:
            same[0].append(number)
        else:
            groups.append((term.unknowns, [number]))
    rows = [np.repeat(u, u.shape[1], axis=1).ravel() for u, _ in groups] + [np.arange(size)]
    columns = [np.tile(u, u.shape[1]).ravel() for u, _ in groups] + [np.arange(size)]
    row, column = np.concatenate(rows), np.concatenate(columns)
    free = np.flatnonzero(~fixed)
    place = np.full(size, -1, dtype=np.int64)
    place[free] = np.arange(len(free))
    kept = (place[row] >= 0) & (place[column] >= 0)
    row, column = place[row[kept]], place[column[kept]]
    n = len(free)
    graph = sparse.csr_array((np.ones(len(row), dtype=np.int8), (row, column)), shape=(n, n))
    order = nested_dissection(graph).order
    if order is None:  # no METIS
        order = np.asarray(csgraph.reverse_cuthill_mckee(graph, symmetric_mode=True), dtype=np.int64)
    position = np.empty(n, dtype=np.int64)
    position[order] = np.arange(n)
    key, slots = np.unique(position[column] * n + position[row], return_inverse=True)
    starts = np.searchsorted(key, np.arange(n + 1) * n)
    indices, starts = (key % n).astype(np.int32), starts.astype(np.int32)
    every = np.full(len(kept), -1, dtype=np.int32)
    every[kept] = slots.ravel()
    placed: list[tuple[tuple[int, ...], Slots]] = []
    begin = 0
    for unknowns, members in groups:
        n_local, k = unknowns.shape
        end = begin + n_local * k * k
        placed.append((tuple(members), every[begin:end].reshape(n_local, k, k)))
        begin = end
    pattern = sparse.csr_array((np.ones(len(key)), indices, starts), shape=(n, n))
    return Pattern(
        size,
        free[order],
        cholesky.analysed(pattern, np.arange(n)),
        tuple(placed),
        every[begin:][free[order]],
        indices,
        starts,
    )
