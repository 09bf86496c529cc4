"""Plain weave, kagome, 2/2 twill and basket: where a ribbon stays on its side, and where it changes.

In a plain weave and in a kagome a ribbon changes sides between any two crossings that follow each other. In a
2/2 twill and in a basket of two by two it stays at every second one. They differ in how neighbouring ribbons
go: on opposite sides of a cell of four ribbons both stay or both change in a basket, one stays and the other
changes in a twill. So the rules speak of a label y on every link between two crossings, 1 where the ribbon
stays: ``y_e ^ y_f = 1`` for links that follow each other, ``y_e ^ y_f = 1`` (twill) or ``0`` (basket) for
opposite ones. Of a cell both pairs of opposite links are met or neither is, so it counts as one rule.
Nothing here needs a direction on the surface. On a plane grid the rules leave the textbook's weaves alone:
crossings (i, j) where ``(i + j) mod 4 < 2``, or its mirror image, and blocks of two by two.
"""

from __future__ import annotations

from typing import Literal, NamedTuple, TypeAlias, get_args

import numpy as np

from geoweave.arrays import Flags, Indices, frozen
from geoweave.errors import FieldError
from geoweave.weave.passages import Passages

__all__ = ["EFFORT", "FLOATING", "WEAVE_TYPES", "Rules", "WeaveType", "Wishes", "rules_of", "weave_type_of"]

WeaveType: TypeAlias = Literal["kagome", "plain", "twill", "basket"]
"""Strict alternation in three families or in two; over two and under two, shifted by one or by none."""

WEAVE_TYPES: tuple[WeaveType, ...] = get_args(WeaveType)
"""All of them."""

FLOATING = ("twill", "basket")
"""Types in which a ribbon passes over two others in a row."""

EFFORT = 50_000
"""Searches for odd cycles, and rows of programs solved, that a proof may take: seconds for 4,000 edges."""

BIAXIAL, TRIAXIAL = 4, 6
"""Symmetries of two and of three families of ribbons."""


def weave_type_of(symmetry: int | None, pattern: WeaveType | None) -> tuple[int, WeaveType]:
    """The symmetry and the type of weave that are meant; refuses two that do not go together.

    Examples
    --------
    >>> gw.weave.weave_type_of(None, "twill"), gw.weave.weave_type_of(None, None)
    ((4, 'twill'), (6, 'kagome'))

    Raises
    ------
    FieldError
        If there is no such type, or the symmetry has not the families that it needs.
    """
    if pattern not in (None, *WEAVE_TYPES):
        raise FieldError(f"there is no pattern '{pattern}': {', '.join(WEAVE_TYPES)}")
    if pattern is None:
        symmetry = TRIAXIAL if symmetry is None else symmetry
        return symmetry, "kagome" if symmetry == TRIAXIAL else "plain"
    needed = TRIAXIAL if pattern == "kagome" else BIAXIAL
    if symmetry is None:
        return needed, pattern
    if pattern == "plain" and symmetry != TRIAXIAL:
        return symmetry, pattern
    if symmetry != needed:
        families = "three" if pattern == "kagome" else "two"
        raise FieldError(f"a {pattern} weave has {families} families: a symmetry of {needed}, not {symmetry}")
    return symmetry, pattern


class Wishes(NamedTuple):
    """Labels of two things each: ``x[first] ^ x[second] == parity``."""

    first: Indices
    """(W,) one of the two."""
    second: Indices
    """(W,) the other one."""
    parity: Indices
    """(W,) 1 where the labels are to differ."""
    rule: Indices
    """(W,) the rule that wants it."""


class Rules(NamedTuple):
    """What a twill or a basket asks of the links of a weave; links are rows of `Passages.relations`."""

    passages: Passages
    """Of the weave."""
    row: Indices
    """(K, 2) links that follow each other on a ribbon: it stays at one of them alone."""
    cell: Indices
    """(Q, 4) links round each cell of four ribbons; the first and the third are opposite."""
    shifted: bool
    """Whether of two opposite links a ribbon stays at one alone (twill), or at both or none (basket)."""

    def __len__(self) -> int:
        return len(self.row) + len(self.cell)

    @property
    def crossings(self) -> Indices:
        """(K + Q,) where each rule is: the crossing between two links of a row, the first one of a cell."""
        links = self.passages.relations
        ends = np.stack([links.first, links.second], axis=1)[self.cell]
        shared = (ends[:, 0, :, None] == ends[:, 3, None, :]).any(axis=2)
        corner = np.where(shared[:, 0], ends[:, 0, 0], ends[:, 0, 1])
        return np.concatenate([links.second[self.row[:, 0]], corner])

    @property
    def of_sides(self) -> Wishes:
        """What the rules of rows want of the sides at crossings two apart."""
        links, (e, f) = self.passages.relations, self.row.T
        parity = 1 ^ links.parity[e] ^ links.parity[f]
        return Wishes(links.first[e], links.second[f], parity, np.arange(len(self.row)))

    @property
    def of_links(self) -> Wishes:
        """What all rules want of the labels y of links; each cell wants it of both its pairs."""
        rows, cells = len(self.row), len(self.cell)
        return Wishes(
            np.concatenate([self.row[:, 0], self.cell[:, :2].ravel()]),
            np.concatenate([self.row[:, 1], self.cell[:, 2:].ravel()]),
            np.repeat(np.array([1, self.shifted], dtype=np.int64), [rows, 2 * cells]),
            np.concatenate([np.arange(rows), rows + np.repeat(np.arange(cells), 2)]),
        )

    def broken(self, over: Indices) -> Flags:
        """(K + Q,) rules that sides break, those of rows first."""
        links = self.passages.relations
        stays = (over[links.first] ^ over[links.second]) != links.parity
        row, cell = stays[self.row], stays[self.cell]
        return np.concatenate([row[:, 0] == row[:, 1], cell[:, 0] ^ cell[:, 2] != self.shifted])


def rules_of(passages: Passages, pattern: WeaveType) -> Rules:
    """What a twill or a basket asks of the links of a weave.

    Examples
    --------
    >>> from geoweave.weave.weave_types import rules_of
    >>> i, j = np.indices((4, 4)).reshape(2, -1)             # rows and columns on a torus
    >>> grid = gw.weave.Passages(np.c_[i, 4 + j], np.c_[j, i], np.ones(8, dtype=bool))
    >>> twill, basket = (i + j) % 4 // 2, i // 2 ^ j // 2
    >>> [int(rules_of(grid, "twill").broken(over).sum()) for over in (twill, basket)]
    [0, 16]
    """
    here = passages.order[passages.following[passages.order] >= 0]
    link = np.full(2 * len(passages), -1, dtype=np.int64)
    link[here] = np.arange(len(here))
    after = link[passages.following[here]]
    row = np.flatnonzero((after >= 0) & (after != np.arange(len(here))))
    return Rules(passages, frozen(np.column_stack([row, after[row]])), passages.rings(4), pattern == "twill")
