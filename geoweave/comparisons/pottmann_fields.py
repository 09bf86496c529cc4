"""Piecewise geodesic fields of Pottmann et al. 2010, with which Section 4.1 compares ours (Figs. 3 and 7)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import sparse

from geoweave.arrays import Complexes, Scalars
from geoweave.comparisons.fitted_derivatives import Derivatives
from geoweave.errors import FieldError
from geoweave.fields import (
    FaceField,
    as_complex,
    as_real,
    dual_weights,
    field_mass,
    spectral_shift,
    transport_differences,
)
from geoweave.sparse import (
    Ordering,
    factorized,
    nested_dissection,
    one_blas_thread,
)
from geoweave.surface import TriMesh

SPECTRAL_FIELDS = 40
"""Eigenfields that span the nearly geodesic fields of `spectral_field`."""

SPECTRAL_ROUGHNESS = 0.01
"""Weight of the Dirichlet energy beside the squared curl in the energy of those eigenfields."""

CURL_SCALE = 0.3
"""Curl from which sharpening takes a face for part of a singular line, times bounding radius."""

TURN_SCALE = 0.25
"""Jump across an edge (about its angle in radians) from which sharpening takes it for a singular line."""

SMOOTHING = 0.1
"""Weight of the jumps beside the curl while sharpening, in mean edges over the bounding radius."""

SHARPENING_STEPS = 40
"""Gauss-Newton steps of `sharpened_field`, half of them while the scale of the curl falls."""

EIGENFIELD_TOLERANCE = 1e-8
"""Relative error of the eigenvalues of the spectral basis."""

FIRST_QUANTILE = 0.95
"""Sharpening begins with a scale of the curl that so many of the faces stay below."""

FIRST_DAMPING, LEAST_DAMPING = 1e-3, 1e-6
"""Damping of a Gauss-Newton step at the start and at least, as a share of the mean of the form's diagonal."""

EASED, STIFFENED = 4.0, 8.0
"""The damping is divided by the first after a step that lowered the energy, multiplied by the second else."""

TRIES = 10
"""Dampings that are tried before the field stays as it is."""


def fitted_curl(mesh: TriMesh) -> sparse.csr_array:
    """Curl from the Jacobian fitted to the neighbourhood of each face, (F, 2F) (Pottmann et al. 2010).

    The neighbours across the edges are unfolded into the plane of the face; the linear map J that fits
    ``J (c_g - c_f) = T_{f<-g} u_g - u_f`` best, c the centres, has the curl ``J_21 - J_12``, its failure to
    be symmetric. Exact on linear fields in the plane; zero on faces with one neighbour only,
    which do not determine J. Unlike `curl` it sees noise, not curl, next to a singularity.

    Returns
    -------
    (F, 2F) sparse, acting on ``as_real(field)``; unit: field / length
    """
    p = Derivatives.fitted(mesh).p.tocoo()
    # 2 Im (p u) = 2 (Im p Re u + Re p Im u)
    return sparse.csr_array(
        (
            2.0 * np.stack([p.data.imag, p.data.real], axis=1).ravel(),
            (np.repeat(p.row, 2), (2 * p.col[:, None] + np.arange(2)).ravel()),
        ),
        shape=(mesh.n_faces, 2 * mesh.n_faces),
    )


@one_blas_thread()
def spectral_field(
    initial: FaceField, *, count: int = SPECTRAL_FIELDS, roughness: float = SPECTRAL_ROUGHNESS
) -> FaceField:
    """Project a field onto a small basis of nearly geodesic fields (Pottmann et al. 2010), not yet unit.

    The basis holds the first eigenfields of ``|fitted curl|^2 + roughness * Dirichlet energy``; the
    projection is the orthogonal one in ``integral <u, v>``. For unit fields geodesic means curl-free, but
    the eigenfields are not unit: that is what the sharpening afterwards is for.

    Parameters
    ----------
    initial : the field to start from
    count : eigenfields in the basis
    roughness : weight of the Dirichlet energy, a number; without it every gradient would have no energy

    Raises
    ------
    FieldError
        If the count or the weight is not positive, or there are not so many fields.
    """
    from scipy.sparse.linalg import LinearOperator, eigsh

    mesh = initial.mesh
    if not (0 < count < mesh.n_faces and 0 < roughness < np.inf):
        raise FieldError(
            f"a spectral basis needs a positive weight and between 1 and {mesh.n_faces - 1} fields, "
            f"not {roughness} and {count}"
        )
    energy = _geodesic_form(mesh, roughness)
    mass = field_mass(mesh).diagonal()
    # Flat surfaces have fields without energy.
    shift = spectral_shift(mesh.face_areas)
    factors = factorized(
        sparse.csr_array(energy + sparse.diags_array(shift * mass)), nested_dissection(energy)
    )
    root = np.sqrt(mass)
    inverse = LinearOperator(
        energy.shape, matvec=lambda u: root * factors.solve(root * u.ravel()), dtype=np.float64
    )
    start = np.random.default_rng(0).normal(size=len(mass))
    _, vectors = eigsh(inverse, k=count, which="LM", v0=start, tol=EIGENFIELD_TOLERANCE, rng=0)
    return FaceField(mesh, as_complex(vectors @ (vectors.T @ (root * as_real(initial.values))) / root))


def _geodesic_form(mesh: TriMesh, roughness: float) -> sparse.csr_array:
    """Quadratic form of ``integral curl^2 + roughness |grad u|^2`` on (2F,) coordinates."""
    curl, jumps = fitted_curl(mesh), transport_differences(mesh)
    weights = roughness * np.repeat(dual_weights(mesh), 2)
    square = curl.T @ sparse.diags_array(mesh.face_areas) @ curl
    return sparse.csr_array(square + jumps.T @ sparse.diags_array(weights) @ jumps)


@dataclass(frozen=True)
class SharpeningStep:
    """One Gauss-Newton step of `sharpened_field`.

    Attributes
    ----------
    scale : curl beyond which a face counts as part of a singular line, 1 / length
    before, after : the energy of `sharpened_field` at that scale, a number; ``after <= before``
    """

    scale: float
    before: float
    after: float


@dataclass(frozen=True, eq=False)
class PottmannField:
    """A piecewise geodesic field and how it was made.

    Attributes
    ----------
    initial : the unit field it started from
    spectral : its projection onto nearly geodesic fields, scaled to unit length
    field : the sharpened unit field
    steps : the steps of the sharpening, in order
    """

    initial: FaceField
    spectral: FaceField
    field: FaceField
    steps: tuple[SharpeningStep, ...]


@one_blas_thread()
def sharpened_field(
    initial: FaceField,
    *,
    scale: float | None = None,
    turn: float = TURN_SCALE,
    smoothing: float | None = None,
    steps: int = SHARPENING_STEPS,
) -> tuple[FaceField, tuple[SharpeningStep, ...]]:
    """Gather the curl of a unit field on lines, and so make it geodesic between (Pottmann et al. 2010).

    Minimises ``integral rho(curl w; scale) + smoothing * sum over edges of W rho(|T w_i - w_j|; turn)`` over
    unit fields, with ``rho(x; c) = x^2 / (1 + x^2 / c^2)`` of Geman and McClure: what is far beyond its scale
    costs no more when it grows, so a few faces and edges take it all. The angles of the field are the
    unknowns of Gauss-Newton steps (reweighted, damped so that none raises the energy) while the scale of the
    curl falls from what the field has to the given value. The text that compares with the method does not
    give a functional or weights (DEVIATIONS.md, sharpening-2010).

    Parameters
    ----------
    initial : the field, scaled to unit length first
    scale : of the curl, 1 / length; 0.3 over the bounding radius if not given
    turn : of the jumps, a number: 0.25 is an angle of 14 degrees across one edge
    smoothing : a number; 0.1 mean edges over the bounding radius if not given: a line costs its length
    steps : how many, half of them while the scale falls

    Raises
    ------
    FieldError
        If a scale, the weight or the number of steps is not positive.
    """
    mesh = initial.mesh
    radius = mesh.bounding_radius
    last = CURL_SCALE / radius if scale is None else float(scale)
    weight = SMOOTHING * mesh.mean_edge / radius if smoothing is None else float(smoothing)
    if min(last, turn, weight) <= 0 or steps < 1:
        raise FieldError(
            f"sharpening needs positive scales, weight and steps, not {last}, {turn}, {weight} and {steps}"
        )
    problem = _Sharpening(mesh, turn, weight)
    w = initial.normalized().values
    first = max(last, float(np.quantile(np.abs(problem.curl @ as_real(w)), FIRST_QUANTILE)))
    falling = np.geomspace(first, last, max(steps // 2, 1))
    record, damping = [], FIRST_DAMPING
    for level in (*falling, *([last] * (steps - len(falling)))):
        before = problem.energy(w, level)
        w, after, damping = problem.step(w, level, before, damping)
        record.append(SharpeningStep(float(level), before, after))
    return FaceField(mesh, w), tuple(record)


class _Sharpening:
    """The energy of `sharpened_field` and its damped Gauss-Newton step in the angles of the field."""

    def __init__(self, mesh: TriMesh, turn: float, smoothing: float) -> None:
        self.mesh, self.turn = mesh, turn
        self.curl = fitted_curl(mesh)
        self.jumps = transport_differences(mesh)
        self.weights = smoothing * dual_weights(mesh)
        self.ordering: Ordering | None = None

    def energy(self, w: Complexes, scale: float) -> float:
        curl, jumps = self._residuals(w)
        bent = self.mesh.face_areas @ (curl**2 / (1.0 + (curl / scale) ** 2))
        rough = np.abs(as_complex(jumps)) ** 2
        return float(bent + self.weights @ (rough / (1.0 + rough / self.turn**2)))

    def _residuals(self, w: Complexes) -> tuple[Scalars, Scalars]:
        return self.curl @ as_real(w), self.jumps @ as_real(w)

    def step(
        self, w: Complexes, scale: float, energy: float, damping: float
    ) -> tuple[Complexes, float, float]:
        """Return the field after one step, its energy, and the damping to go on with."""
        n = self.mesh.n_faces
        curl, jumps = self._residuals(w)
        rough = np.abs(as_complex(jumps)) ** 2
        # rho'(x) / 2x is the weight that makes a square touch rho.
        on_faces = self.mesh.face_areas / (1.0 + (curl / scale) ** 2) ** 2
        on_edges = np.repeat(self.weights / (1.0 + rough / self.turn**2) ** 2, 2)
        # Turning w_f by an angle adds i w_f times it.
        turned = sparse.csr_array(
            (as_real(1j * w), (np.arange(2 * n), np.repeat(np.arange(n), 2))), shape=(2 * n, n)
        )
        by_curl, by_jumps = self.curl @ turned, self.jumps @ turned
        form = sparse.csr_array(
            by_curl.T @ sparse.diags_array(on_faces) @ by_curl
            + by_jumps.T @ sparse.diags_array(on_edges) @ by_jumps
        )
        slope = by_curl.T @ (on_faces * curl) + by_jumps.T @ (on_edges * jumps)
        if self.ordering is None:
            self.ordering = nested_dissection(form)
        share = self.mesh.face_areas * (form.diagonal().mean() / self.mesh.face_areas.mean())
        for _ in range(TRIES):
            factors = factorized(sparse.csr_array(form + sparse.diags_array(damping * share)), self.ordering)
            trial = w * np.exp(-1j * factors.solve(slope))
            reached = self.energy(trial, scale)
            if reached <= energy:
                return trial, reached, max(damping / EASED, LEAST_DAMPING)
            damping *= STIFFENED
        return w, energy, damping


def pottmann_field(
    initial: FaceField,
    *,
    count: int = SPECTRAL_FIELDS,
    roughness: float = SPECTRAL_ROUGHNESS,
    scale: float | None = None,
    turn: float = TURN_SCALE,
    smoothing: float | None = None,
    steps: int = SHARPENING_STEPS,
) -> PottmannField:
    """Design a piecewise geodesic field by the third method of Pottmann et al. 2010, "Geodesic patterns".

    The initial field is projected onto a small basis of nearly geodesic fields (`spectral_field`), scaled to
    unit length, and sharpened (`sharpened_field`): geodesic in patches, and singular on the lines between.
    The method is made for disks; near singularities of the field its curl is not defined.

    Parameters
    ----------
    initial : the field to start from
    count, roughness : of `spectral_field`
    scale, turn, smoothing, steps : of `sharpened_field`
    """
    spectral = spectral_field(initial, count=count, roughness=roughness).normalized()
    field, record = sharpened_field(spectral, scale=scale, turn=turn, smoothing=smoothing, steps=steps)
    return PottmannField(initial.normalized(), spectral, field, record)
