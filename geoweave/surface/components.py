"""Connected components of a graph, for meshes of any size.

They stand here in plain numpy because scipy's graph routines take longer to load than most meshes take to
read, and are no faster on the graphs of a mesh.
"""

from __future__ import annotations

import numpy as np

from geoweave.arrays import Indices


def connected_components(pairs: Indices, size: int) -> Indices:
    """Return the number of the connected component of each node of an undirected graph.

    Every node begins as a component of its own, labelled by its number. Where a link joins two labels, the
    larger label points to the smaller one, and pointers are followed to their ends; this repeats until no
    link joins two labels (Shiloach and Vishkin, *An O(log n) parallel connectivity algorithm*, 1982).

    Parameters
    ----------
    pairs : (P, 2) nodes that each link joins
    size : number of nodes

    Returns
    -------
    (size,) numbers from 0; components are numbered in the order of their lowest nodes

    Examples
    --------
    >>> gw.surface.connected_components(np.array([[0, 3], [4, 3]]), 5).tolist()
    [0, 1, 2, 0, 0]
    """
    node = np.arange(size)
    label = node.copy()
    start, end = pairs.T
    while True:
        first, second = label[start], label[end]
        apart = first != second
        if not apart.any():
            return np.asarray((np.cumsum(label == node) - 1)[label], dtype=np.int64)
        start, end, first, second = start[apart], end[apart], first[apart], second[apart]
        np.minimum.at(label, np.maximum(first, second), np.minimum(first, second))
        while ((onward := label[label]) != label).any():
            label = onward
