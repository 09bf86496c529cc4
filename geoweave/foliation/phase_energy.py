"""The energy of the phase between three families, beside Eq. 8 and in its unit (DEVIATIONS.md, phase).

Ribbons that form a kagome, of triangles and hexagons, never meet three in a point.
"""

from __future__ import annotations

from functools import cached_property
from typing import NamedTuple

import numpy as np
from scipy import sparse

from geoweave.arrays import Complexes, Indices, Scalars
from geoweave.fields import FaceField, Triples
from geoweave.foliation.circle_function import wrapped

LEAST_COSINE = 0.1
"""The quadratic model of ``1 - cos`` stays at least so convex."""


class PhaseModel(NamedTuple):
    """A convex quadratic model of the energy of the phase at one theta and s."""

    weights: Scalars
    """(R,) curvature in each phase."""
    in_theta: Scalars
    """(V,) minus the gradient in theta."""
    in_share: Scalars
    """(F,) minus the gradient in ``s / shat``."""


class PhaseEnergy:
    """What the phase of three families costs, and their frequencies where they do not fit together.

    On a face of three sheets 120 degrees apart let ``phi = theta_0 + theta_2 + theta_4``. Where the gradients
    sum to zero it is constant. Ribbons lie at ``theta = pi/2``, m of them in one turn. Three meet in a point
    where ``m (phi - 3 pi/2)`` is a multiple of 2 pi. Half way between, for m = 2 at ``phi = 0 (mod pi)``,
    they form a perfect kagome. The energy is

        kappa/m^2 sum A (1 + cos m (phi - 3 pi/2)) + eta/2 sum A |sum_k s_k w_k|^2 / shat^2

    over places and over faces that are kept on all three sheets. The next three sheets, one further, carry
    -phi, and ``phi = 0 (mod pi)`` says the same of both: it holds across every branch cut.

    Parameters
    ----------
    field : the unit field w
    unit : (F,) shat, the unit in which Eq. 8 measures s
    triples : on the surface of the field

    Attributes
    ----------
    kappa, eta : weights of the two parts, 0 at first
    emphasis : (R,) factor on kappa at each place, 1 at first
    """

    def __init__(self, field: FaceField, unit: Scalars, triples: Triples) -> None:
        self.mesh, self.triples = field.mesh, triples
        self.kappa, self.eta = 0.0, 0.0
        self.vertices, self.signs, self.mass = triples.corners
        self.emphasis = np.ones(len(self.mass))
        row = np.repeat(np.arange(len(self.mass)), 3)
        shape = len(self.mass), self.mesh.n_vertices
        self.sum = sparse.csr_array((self.signs.ravel(), (row, self.vertices.ravel())), shape=shape)
        self.closing = self._closing(triples.signs * (unit * field.normalized().values)[triples.faces], unit)

    def _closing(self, asked: Complexes, unit: Scalars) -> sparse.csr_array:
        """(F, F) matrix of the part of eta, from the three frequencies (T, 3) that shares of 1 ask for."""
        faces, count = self.triples.faces, len(asked)
        mean = np.sqrt((unit[faces] ** 2).mean(axis=1))
        asked = asked * (np.sqrt(self.mesh.face_areas[faces[:, 0]]) / mean)[:, None]
        row = np.repeat(np.arange(count), 3)
        total = sparse.csr_array(
            (
                np.concatenate([asked.real.ravel(), asked.imag.ravel()]),
                (np.concatenate([row, count + row]), np.tile(faces.ravel(), 2)),
            ),
            shape=(2 * count, self.mesh.n_faces),
        )
        return sparse.csr_array(total.T @ total)

    def phase(self, theta: Scalars) -> Scalars:
        """(R,) how far phi is from that of a kagome at each place, radians, within ``pi / m`` of zero."""
        m = self.triples.ribbons
        return wrapped(m * (np.asarray(self.sum @ theta) - 1.5 * np.pi) + np.pi) / m

    def order(self, theta: Scalars) -> float:
        """Mean of ``cos m phi`` over the area: 1 where all is a kagome, 0 where phases are random."""
        return float(np.average(np.cos(self.triples.ribbons * self.phase(theta)), weights=self.mass))

    def __call__(self, theta: Scalars, share: Scalars) -> float:
        """The energy at a theta and ``s / shat``."""
        m = self.triples.ribbons
        off = (self.emphasis * self.mass) @ (1.0 - np.cos(m * self.phase(theta))) / m**2
        return float(self.kappa * off + 0.5 * self.eta * share @ (self.closing @ share))

    def model(self, theta: Scalars, share: Scalars) -> PhaseModel:
        """The model near a theta and an s."""
        m, turned = self.triples.ribbons, self.triples.ribbons * self.phase(theta)
        stiffness = self.kappa * self.emphasis * self.mass
        weights = stiffness * np.maximum(np.cos(turned), LEAST_COSINE)
        in_theta = -np.asarray(self.sum.T @ (stiffness * np.sin(turned) / m))
        return PhaseModel(weights, in_theta, -self.eta * np.asarray(self.closing @ share))

    @cached_property
    def places(self) -> tuple[Indices, Indices]:
        """Rows and columns of `entries`, in a matrix of theta and s together."""
        n, closing = self.mesh.n_vertices, self.closing
        face = np.repeat(np.arange(self.mesh.n_faces), np.diff(closing.indptr))
        rows = np.concatenate([np.repeat(self.vertices, 3, axis=1).ravel(), n + face])
        columns = np.concatenate([np.tile(self.vertices, (1, 3)).ravel(), n + np.asarray(closing.indices)])
        return rows, columns

    def entries(self, weights: Scalars, free: Scalars) -> list[Scalars]:
        """Entries of the model in theta and ``s / shat``; a face with ``free = 0`` keeps its s."""
        blocks = weights[:, None, None] * self.signs[:, :, None] * self.signs[:, None, :]
        rows, columns = (each[blocks.size :] - self.mesh.n_vertices for each in self.places)
        return [blocks.ravel(), self.eta * self.closing.data * free[rows] * free[columns]]

    def aligned(self, theta: Scalars) -> Scalars:
        """Turn theta by a constant on each component on which that is free, to the best phase of all.

        Eq. 8 does not change by it. On a component that is its own antipode there is no such constant.
        Components that share their places share the turn too, so that their numbers decide nothing.
        """
        m, component = self.triples.ribbons, self.mesh.vertex_components
        free = np.flatnonzero(~self.mesh.bundle.twisted_components)
        slopes = np.zeros((len(self.mass), len(free)))
        for place, c in enumerate(free):
            slopes[:, place] = (self.signs * (component[self.vertices] == c)).sum(axis=1)
        constants = np.zeros(self.mesh.n_components)
        for group in np.unique(self.triples.groups[free]):
            own = self.triples.groups[free] == group
            kinds, kind = np.unique(slopes[:, own], axis=0, return_inverse=True)
            phase = self.mass * np.exp(1j * m * self.phase(theta))
            total = np.bincount(kind.ravel(), phase.real) + 1j * np.bincount(kind.ravel(), phase.imag)
            # The smallest turns that bring the mean phase of each kind of place to zero.
            weight = np.sqrt(np.abs(total))
            turn = np.linalg.lstsq(weight[:, None] * kinds, -weight * np.angle(total) / m)[0]
            constants[free[own]] = turn
        return np.asarray(theta + constants[component])
