"""N-RoSys that say by how much they turn from face to face, and whole turns added to them (Section 5.1)."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy import sparse

from geoweave.arrays import Indices, Scalars, frozen
from geoweave.errors import FieldError
from geoweave.fields.operators import dual_weights, face_laplacian
from geoweave.fields.rosy import RoSyField
from geoweave.sparse import factorized, nested_dissection
from geoweave.surface import TriMesh

TURN = 2.0 * np.pi

FITS = 1e-6
"""How far the number of a face may be from the neighbour's, turned as is said, radians."""


@dataclass(frozen=True, eq=False)
class ConnectedRoSy(RoSyField):
    """An N-RoSy that also says by how much it turns from face to face.

    A RoSy alone is matched by the smallest turn, which is at most pi / N. Round a vertex of k triangles it
    can have no index above k / 2N in this way. Here the turns are given, so any index can be.

    Attributes
    ----------
    turns : (E_int,) turn of the number of the RoSy, its N-th power, over each interior edge from face i to
        face j, radians; N times the turn of the vectors

    Raises
    ------
    FieldError
        If a turn does not lead from the number of one face to that of the next.

    Examples
    --------
    >>> disk = gw.shapes.disk(faces=200)
    >>> index = np.zeros(disk.n_vertices, dtype=int)
    >>> index[np.linalg.norm(disk.vertices, axis=1).argmin()] = 5
    >>> rosy = gw.prescribed_rosy(disk, 6, index)
    >>> bool((rosy.index_numerators == index).all()), bool(abs(rosy.turns).max() > np.pi / 2)
    (True, True)
    """

    turns: Scalars

    def __post_init__(self) -> None:
        super().__post_init__()
        turns = np.array(self.turns, dtype=np.float64)
        count = len(self.mesh.interior_edges)
        if turns.shape != (count,):
            raise FieldError(
                f"a connected N-RoSy needs one turn per interior edge, ({count},), not {turns.shape}"
            )
        wrong = ~(np.abs(np.angle(np.exp(1j * (smallest_turns(self) - turns)))) < FITS)
        if wrong.any():
            edge = int(np.flatnonzero(wrong)[0])
            raise FieldError(f"the turn over interior edge {edge} does not lead from one face to the other")
        object.__setattr__(self, "turns", frozen(turns))

    @cached_property
    def matching(self) -> Indices:
        """(E_int,) shift sigma: vector k of face i is turned to vector ``(k + sigma) mod N`` of face j."""
        i, j = self.mesh.edge_faces[self.mesh.interior_edges].T
        first = self.vectors[:, 0]
        arrives = self.mesh.transport * first[i] * np.exp(1j * self.turns / self.degree)
        ahead = np.angle(arrives * first[j].conj())
        return frozen(np.rint(ahead * self.degree / TURN).astype(np.int64) % self.degree)


def smallest_turns(rosy: RoSyField) -> Scalars:
    """(E_int,) smallest turn of the number of an N-RoSy over each interior edge, in (-pi, pi]."""
    mesh = rosy.mesh
    i, j = mesh.edge_faces[mesh.interior_edges].T
    return np.angle(rosy.values[j] * (mesh.transport**rosy.degree * rosy.values[i]).conj())


def turns_of(rosy: RoSyField) -> Scalars:
    """(E_int,) the turns of an N-RoSy: those that it says, or the smallest."""
    return rosy.turns if isinstance(rosy, ConnectedRoSy) else smallest_turns(rosy)


class DualPotential:
    """Functions on faces whose differences are nearest to given numbers on interior edges.

    ``argmin sum over ij of weight_ij (c_ij - (phi_j - phi_i))^2``, the Poisson problem on the dual graph with
    the weights of the Dirichlet energy; one face of each component is held at zero.

    Parameters
    ----------
    mesh : the surface
    """

    def __init__(self, mesh: TriMesh) -> None:
        i, j = mesh.edge_faces[mesh.interior_edges].T
        count = len(i)
        self._free = np.delete(np.arange(mesh.n_faces), np.unique(mesh.face_components, return_index=True)[1])
        self._steps = sparse.csr_array(
            (np.tile([-1.0, 1.0], count), (np.repeat(np.arange(count), 2), np.stack([i, j], axis=1).ravel())),
            shape=(count, mesh.n_faces),
        )
        self.weights = dual_weights(mesh)
        laplacian = face_laplacian(mesh)[self._free][:, self._free]
        self._factors = factorized(sparse.csr_array(laplacian), nested_dissection(laplacian))

    def of(self, jumps: Scalars) -> Scalars:
        """(F,) the function of (E_int,) numbers, or one in each column."""
        weighted = (self.weights * jumps.T).T
        phi = np.zeros((self._steps.shape[1], *jumps.shape[1:]))
        phi[self._free] = self._factors.solve((self._steps.T @ weighted)[self._free])
        return phi

    def rest(self, jumps: Scalars) -> Scalars:
        """What no function explains of (E_int,) numbers, or of those in each column."""
        return np.asarray(jumps - self._steps @ self.of(jumps))


def rewound(rosy: RoSyField, jumps: Indices) -> ConnectedRoSy:
    """Add whole turns to the edges of an N-RoSy, and spread them as evenly as can be.

    ``phi = argmin sum of weight_ij (2 pi k_ij - (phi_j - phi_i))^2``, then ``u <- u exp(-i phi)``. The index
    changes at each vertex by exactly what the whole turns round it sum to, and nowhere else.

    Parameters
    ----------
    rosy : the N-RoSy
    jumps : (E_int,) whole turns k of its number from face i to face j

    Returns
    -------
    ConnectedRoSy
    """
    mesh = rosy.mesh
    added = TURN * np.asarray(jumps, dtype=np.float64)
    phi = DualPotential(mesh).of(added)
    i, j = mesh.edge_faces[mesh.interior_edges].T
    turns = turns_of(rosy) + added - (phi[j] - phi[i])
    return ConnectedRoSy(mesh, rosy.degree, rosy.values * np.exp(-1j * phi), turns)
