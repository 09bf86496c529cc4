"""How strips are cut, in few numbers: curvature and length are linear between knots along each rod."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy import sparse
from scipy.sparse import linalg

from geoweave.arrays import Flags, Indices, Scalars
from geoweave.rods.rods import Rods

__all__ = ["APART", "Knots"]

APART = 2
"""Segments from one knot to the next."""

STRAIN = 0.25
"""A change of length by this share counts as much as a change of curvature x width by 1."""


@dataclass(frozen=True, eq=False)
class Knots:
    """The unknowns z of strips: at each knot curvature x width, then at each knot a change of length.

    Attributes
    ----------
    rods : whose rest lengths are those that z = 0 gives
    bends : (J, K) from curvature x width at the knots to natural curvatures over joints
    lengths : (S, L) from changes of length at the knots to those of the rest lengths of segments
    second : (M, K + L) second differences of neighbouring knots
    """

    rods: Rods
    bends: sparse.csr_array
    lengths: sparse.csr_array
    second: sparse.csr_array

    @property
    def curved(self) -> int:
        """Number of knots of the curvature, K; they come first."""
        return int(self.bends.shape[1])

    @property
    def number(self) -> int:
        """Number of unknowns, K + L."""
        return self.curved + int(self.lengths.shape[1])

    @classmethod
    def of(cls, rods: Rods, apart: int = APART) -> Knots:
        """Place knots at equal distances along every rod."""
        layout = rods.layout
        joints = np.bincount(layout.rod_of_segment[layout.joints[:, 0]], minlength=len(rods))
        bends, one = _hats(joints, layout.closed, apart)
        lengths, two = _hats(np.diff(layout.segment_offsets), layout.closed, apart)
        turning = sparse.diags_array(rods.spans / rods.joint_widths)
        stretch = sparse.diags_array(STRAIN * rods.rest)
        return cls(
            rods,
            sparse.csr_array(turning @ bends),
            sparse.csr_array(stretch @ lengths),
            sparse.csr_array(sparse.block_diag([one, two], format="csr")),
        )

    def cut(self, z: Scalars, shape: Rods | None = None) -> Rods:
        """Rods of strips that are cut so, in a shape; that of the first rods if not given."""
        k = self.curved
        rest = self.rods.rest + self.lengths @ z[k:]
        return replace(shape or self.rods, natural=self.bends @ z[:k], rest=rest)

    def change(self, z: Scalars) -> tuple[Scalars, Scalars]:
        """Changes of natural curvatures (J,) and rest lengths (S,) from those of the unknowns."""
        return self.bends @ z[: self.curved], self.lengths @ z[self.curved :]

    def slope(self, natural: Scalars, rest: Scalars) -> Scalars:
        """(K + L,) derivative by the unknowns, from those by natural curvatures and rest lengths."""
        return np.concatenate([self.bends.T @ natural, self.lengths.T @ rest])

    def start(self) -> Scalars:
        """(K + L,) unknowns of strips whose natural curvature is nearest to that of the first rods."""
        square = sparse.csc_array(self.bends.T @ self.bends)
        z = np.zeros(self.number)
        if self.curved:
            z[: self.curved] = linalg.spsolve(square, self.bends.T @ self.rods.natural)
        return z


def _hats(counts: Indices, closed: Flags, apart: int) -> tuple[sparse.csr_array, sparse.csr_array]:
    """Hat functions on rods of so many places, and second differences of neighbouring knots."""
    hats: list[sparse.csr_array] = [sparse.csr_array((0, 0))]
    second: list[sparse.csr_array] = [sparse.csr_array((0, 0))]
    for count, loop in zip(counts.tolist(), closed.tolist(), strict=True):
        if not count:
            continue
        number = max(round(count / apart), 3) if loop else round((count - 1) / apart) + 1
        number = min(number, count)
        last = number if loop else number - 1
        at = np.arange(count) * (last / max(count if loop else count - 1, 1))
        low = np.minimum(at.astype(np.int64), max(last - 1, 0))
        row, share = np.arange(count), at - low
        values = np.zeros((count, number))
        np.add.at(values, (row, low), 1.0 - share)
        np.add.at(values, (row, (low + 1) % number), share)
        inner = np.arange(number) if loop else np.arange(1, number - 1)
        difference = np.zeros((len(inner), number))
        for side, factor in ((-1, 1.0), (0, -2.0), (1, 1.0)):
            np.add.at(difference, (np.arange(len(inner)), (inner + side) % number), factor)
        hats.append(sparse.csr_array(values))
        second.append(sparse.csr_array(difference))
    return (
        sparse.csr_array(sparse.block_diag(hats, format="csr")),
        sparse.csr_array(sparse.block_diag(second, format="csr")),
    )
