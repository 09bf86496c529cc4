"""Parts of a weave that one crossing alone joins to the rest: their place in space is not certain.

Nothing but the stiffness of one strip, and the friction at one crossing, keeps such a part where it is. In
the net of a pattern it is what falls off when a single crossing is taken away.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy import sparse
from scipy.sparse import csgraph

from geoweave.twin.pattern_surface import PatternSurface

__all__ = ["HangingPart", "hanging_parts"]


class HangingPart(NamedTuple):
    """Crossings that fall off with one."""

    at: int
    """The crossing that joins them to the rest."""
    crossings: frozenset[int]
    """Those that it joins, without itself."""


def hanging_parts(surface: PatternSurface) -> tuple[HangingPart, ...]:
    """Parts of a pattern in one piece that a single crossing joins to the largest part, the largest first.

    Parts of a hanging part are not listed again. A single crossing beyond another is the end of two strips,
    and no part.

    >>> weave = gw.weave_pattern(gw.shapes.sphere(600), ribbons=8).sized(200.0)
    >>> gw.twin.hanging_parts(gw.twin.surface_of(gw.fabrication.pattern_of(weave)))
    ()
    """
    count = len(surface.pattern.ribbons)
    pairs = surface.edges // 4
    links = sparse.csr_array((np.ones(len(pairs)), (pairs[:, 0], pairs[:, 1])), shape=(count, count))
    links = sparse.csr_array(links + links.T)
    found: list[HangingPart] = []
    for x in _joints(links):
        kept = np.delete(np.arange(count), x)
        label = csgraph.connected_components(links[kept][:, kept], directed=False)[1]
        sizes = np.bincount(label)
        for piece in np.delete(np.arange(len(sizes)), sizes.argmax()).tolist():
            if sizes[piece] > 1:
                found.append(HangingPart(x, frozenset(kept[label == piece].tolist())))
    found.sort(key=lambda part: (-len(part.crossings), part.at))
    outer: list[HangingPart] = []
    for part in found:
        if not any(part.crossings <= other.crossings for other in outer):
            outer.append(part)
    return tuple(outer)


def _joints(links: sparse.csr_array) -> list[int]:
    """Crossings without which the others fall into more pieces (Hopcroft and Tarjan 1973).

    A search into depth gives every crossing a rank. One is a joint if what is searched beyond it does not
    come back to a lower rank.
    """
    after = [
        [there for there in row.tolist() if there != here]
        for here, row in enumerate(np.split(links.indices, links.indptr[1:-1]))
    ]
    rank = np.full(links.shape[0], -1, dtype=np.int64)
    lowest, joints, ranked = rank.copy(), set[int](), 0
    for root in range(links.shape[0]):
        if rank[root] >= 0:
            continue
        branches, path = 0, [(root, -1, iter(after[root]))]
        rank[root] = lowest[root] = ranked
        ranked += 1
        while path:
            here, parent, rest = path[-1]
            there = next(rest, None)
            if there is None:
                path.pop()
                if parent >= 0:
                    lowest[parent] = min(lowest[parent], lowest[here])
                    if parent == root:
                        branches += 1
                    elif lowest[here] >= rank[parent]:
                        joints.add(parent)
            elif rank[there] < 0:
                rank[there] = lowest[there] = ranked
                ranked += 1
                path.append((there, here, iter(after[there])))
            elif there != parent:
                lowest[here] = min(lowest[here], rank[there])
        if branches > 1:
            joints.add(root)
    return sorted(joints)
