"""From a field to a circle-valued function whose level sets follow it (Section 4.2)."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal, TypeAlias

import numpy as np
from scipy import sparse

from geoweave.alignment import Alignment, alignment
from geoweave.arrays import Complexes, Scalars, frozen
from geoweave.circle import CircleFunction, wrapped
from geoweave.errors import FieldError, MeshError
from geoweave.fields import FaceField
from geoweave.linalg import Ordering, bounded_minimum, factorized, nested_dissection, one_blas_thread
from geoweave.mesh import TriMesh
from geoweave.operators import as_complex, as_real, face_laplacian
from geoweave.part import Part, part_of
from geoweave.rescaling import Method, component_means, integrating_factor, perpendicular
from geoweave.singularities import vertex_indices

Weighting: TypeAlias = Literal["relative", "uniform"]
"""Whether Eq. 8 is measured in units of the first s, or as the paper prints it (DEVIATIONS.md, weighting)."""

SMOOTHNESS = 1e-4
"""mu of Eq. 8 for a surface of bounding radius 1."""

QUANTILE = 0.95
"""Share of the edges on which theta turns by no more than half a turn at scale 1; the paper's is 1."""

EIGENVALUE_TOLERANCE = 1e-4
"""Relative change of the smallest eigenvalue at which inverse iteration ends."""

LEAST_COTANGENT = 0.02
"""Floor of the cotangent weights: half the cotangent of an angle of 88 degrees."""

LEAST_COSINE = 0.1
"""The quadratic model of ``1 - cos`` stays at least so convex."""

FLOOR = 0.2
"""s stays above this share of its first value."""

LEAST_FREQUENCY = 0.2
"""theta that changes by less than this share of what s asks for is no foliation."""

LEAST_FIRST = 0.02
"""A first s from Eq. 7 is raised to this share of its median where it is smaller or negative."""


@dataclass(frozen=True, eq=False)
class Foliation:
    """A geodesic almost-foliation: the field, its integrating factor and the function theta (Section 4.2.5).

    Attributes
    ----------
    field : the unit field w on the surface without its singular vertices
    part : that surface as a part of the one given
    s : (F',) integrating factor, positive, radians / length: ``grad theta ~ s w-perp``
    circle : theta on the vertices of the part, and its change along each edge
    energies : Eq. 8 at the start and after each alternation, in the unit that `foliate` says
    theta_changes, s_changes : change in each alternation, root mean square over the area: radians, and as a
        share of s
    """

    field: FaceField
    part: Part
    s: Scalars
    circle: CircleFunction
    energies: tuple[float, ...]
    theta_changes: tuple[float, ...]
    s_changes: tuple[float, ...]

    @property
    def alignment(self) -> Alignment:
        """How far level sets and field disagree, how evenly they are spaced, and the dislocations."""
        return alignment(self.field, self.circle)

    @property
    def s_min(self) -> float:
        """Smallest s as a share of its area mean."""
        areas = self.part.mesh.face_areas
        return float(self.s.min() / np.average(self.s, weights=areas))


def punctured(field: FaceField) -> tuple[FaceField, Part]:
    """Remove every singular vertex of a field together with the faces round it (Section 4.2.2).

    Returns
    -------
    field, part : the unit field on what is left, and what is left as a part of the surface

    Raises
    ------
    MeshError
        If every face touches a singular vertex.
    """
    mesh = field.mesh
    singular = vertex_indices(field) != 0
    kept = ~singular[mesh.faces].any(axis=1)
    if not kept.any():
        raise MeshError(
            f"all {mesh.n_faces} faces touch a singular vertex of the field and nothing is left; "
            "ask for more triangles (--faces N)"
        )
    part = part_of(mesh, kept)
    return FaceField(part.mesh, field.normalized().values[part.faces]), part


def global_scale(field: FaceField, s: Scalars, quantile: float = 1.0) -> float:
    """Find the factor pi / rho that keeps theta from turning too fast for the mesh (footnote 4).

    The paper's ``rho = max over edges |s_i w-perp_i . e_ij|`` allows half a turn on any edge. Here rho is a
    quantile of the same numbers: a change along an edge is stored with its full turns and cannot alias, and
    one edge near a singularity need not coarsen the whole surface (DEVIATIONS.md, global-scale).

    Parameters
    ----------
    field : the field w
    s : (F,) factors, of any scale
    quantile : share of edges with at most half a turn, in (0, 1]; 1 is the paper's maximum

    Raises
    ------
    FieldError
        If the quantile is out of range.
    """
    if not 0 < quantile <= 1:
        raise FieldError(f"the quantile of the global scale must be a share in (0, 1], not {quantile}")
    turn = np.abs(s[:, None] * _along(field))
    return float(np.pi / np.quantile(turn, quantile))


def foliate(
    field: FaceField,
    *,
    scale: float = 1.0,
    rescaling: Method | Scalars | None = "logarithm",
    weighting: Weighting = "relative",
    quantile: float = QUANTILE,
    alternations: int = 10,
    tolerance: float = 1e-4,
    hold_s: bool = False,
    smoothness: float = SMOOTHNESS,
    seed: int = 0,
    callback: Callable[[int, float], None] | None = None,
) -> Foliation:
    """Integrate a field to a circle-valued function whose level sets follow it (steps 2 to 5 of 4.2.5).

    Puncture, find a first s, scale it, then alternate: theta from the smallest eigenvector of a Hermitian
    matrix, where that lowers the energy; a Gauss-Newton step in theta and s together; one in s alone, which
    keeps it positive (DEVIATIONS.md, joint-step). They minimise

        sum_i sum_ab  c_ab / shat_i^2 (1 - cos(theta_b - theta_a - s_i w-perp_i . e_ab))
                      + mu/2 |grad(s / shat)|^2

    over the faces i and their edges ab, c half the cotangent of the corner opposite.

    With ``weighting="uniform"`` shat is the mean of the first s on each component: Eq. 8 of the paper, but
    for a constant. With "relative" it is the first s itself, so that a disagreement counts by its angle, as
    much where level sets lie far apart as where they are dense (DEVIATIONS.md, weighting).

    Parameters
    ----------
    field : the field w; the lengths of its vectors do not matter. One that was sharpened no further than
        ``sharpening_schedule(mesh, finest=INTEGRABLE_END)`` has no domain walls and integrates best
    scale : the user's factor on the frequency of theta, after the automatic one
    rescaling : how the first s is found (`integrating_factor`); a positive factor per face of the punctured
        surface (F',) or of the whole one (F,); None for s = 1
    weighting, quantile : see above and `global_scale`
    alternations : how often theta and s are updated at most
    tolerance : an alternation that lowers the energy by no more than this share of it is the last
    hold_s : keep the first s and find theta alone
    smoothness : mu of Eq. 8, in squared bounding radii
    seed : start of the first eigenvector iteration
    callback : called with the number of each alternation and its energy

    Raises
    ------
    FieldError
        If a parameter is out of range.
    MeshError
        If every face touches a singular vertex.
    """
    if not (np.isfinite(scale) and scale > 0):
        raise FieldError(f"the scale of a foliation must be a positive number, not {scale}")
    if alternations < 1:
        raise FieldError(f"a foliation needs one alternation or more, not {alternations}")
    if weighting not in ("relative", "uniform"):
        raise FieldError(f"there is no weighting '{weighting}': relative or uniform")
    w, part = punctured(field)
    first = _first_factor(w, part, rescaling)
    s = scale * global_scale(w, first, quantile) * first
    unit = s if weighting == "relative" else component_means(w.mesh, s)[w.mesh.face_components]
    with one_blas_thread():
        problem = _Alternation(w, s, unit, smoothness * field.mesh.bounding_radius**2)
        z, theta = problem.eigenvector(problem.start(seed), None, s)
        energies = [problem.energy(theta, s)]
        searching = True
        theta_changes: list[float] = []
        s_changes: list[float] = []
        for number in range(1, alternations + 1):
            old_theta, old_s = theta, s
            if number > 1 and searching:
                z, theta = problem.eigenvector(z, theta, s)
                # Where it did not help once, theta has settled, and it does not help later either.
                searching = theta is not old_theta
            if hold_s:
                theta = problem.improve_theta(theta, s)
            else:
                theta, s = problem.improve_both(theta, s)
                s = problem.improve_s(theta, s)
            energies.append(problem.energy(theta, s))
            theta_changes.append(problem.theta_change(old_theta, theta))
            s_changes.append(float(np.sqrt(np.average((s / old_s - 1.0) ** 2, weights=w.mesh.face_areas))))
            if callback is not None:
                callback(number, energies[-1])
            if energies[-2] - energies[-1] <= tolerance * energies[-1]:
                break
    circle = CircleFunction.nearest(w.mesh, theta, edge_prediction(w, s))
    wanted, got = (np.average(each, weights=w.mesh.face_areas) for each in (s, np.abs(circle.gradient)))
    if got < LEAST_FREQUENCY * wanted:
        raise FieldError(
            "the level sets would lie farther apart than the surface is wide, so theta is nearly constant; "
            "ask for a larger scale"
        )
    return Foliation(w, part, frozen(s), circle, tuple(energies), tuple(theta_changes), tuple(s_changes))


def _first_factor(w: FaceField, part: Part, rescaling: Method | Scalars | None) -> Scalars:
    if rescaling is None:
        return np.ones(w.mesh.n_faces)
    if isinstance(rescaling, str):
        s = integrating_factor(w, method=rescaling).s
        # Eq. 7 may come out with faces of the wrong sign; theta needs a positive factor everywhere.
        return np.maximum(s, LEAST_FIRST * float(np.median(s)))
    s = np.asarray(rescaling, dtype=np.float64)
    if s.shape == (part.whole.n_faces,):
        s = s[part.faces]
    if s.shape != (w.mesh.n_faces,) or not (np.isfinite(s) & (s > 0)).all():
        raise FieldError(
            f"a first integrating factor needs one positive number for each of the {w.mesh.n_faces} faces "
            "of the punctured surface"
        )
    return s


def edge_prediction(field: FaceField, s: Scalars) -> Scalars:
    """(E,) change of theta expected along each edge, ``s w-perp . e``, the mean of its faces', radians."""
    mesh = field.mesh
    turn = s[:, None] * _along(field) * mesh.form_signs
    total = np.bincount(mesh.face_edges.ravel(), turn.ravel(), mesh.n_edges)
    return np.asarray(total / np.bincount(mesh.face_edges.ravel(), minlength=mesh.n_edges))


def _along(field: FaceField) -> Scalars:
    """(F, 3) ``w-perp . e`` on the half-edge opposite each corner."""
    return np.asarray((perpendicular(field).conj()[:, None] * field.mesh.halfedge_vectors).real)


def _cotangents(mesh: TriMesh) -> Scalars:
    """(F, 3) half the cotangent of each corner, the weight of the half-edge opposite, kept positive."""
    h = mesh.halfedge_vectors
    at_corner = -(h[:, [1, 2, 0]].conj() * h[:, [2, 0, 1]]).real
    return np.maximum(at_corner / (4.0 * mesh.face_areas[:, None]), LEAST_COTANGENT)


class _Alternation:
    """The two steps of Eq. 8 on one surface, with what they share: weights, orderings, the masses."""

    def __init__(self, field: FaceField, first: Scalars, unit: Scalars, smoothness: float) -> None:
        mesh = field.mesh
        self.mesh, self.unit, self.smoothness = mesh, unit, smoothness
        self.least = FLOOR * first / unit
        self.along = _along(field)
        self.slope = unit[:, None] * self.along
        self.weight = _cotangents(mesh) / unit[:, None] ** 2
        self.tail, self.head = mesh.faces[:, [1, 2, 0]].ravel(), mesh.faces[:, [2, 0, 1]].ravel()
        self.tail_sign = mesh.corner_signs[:, [1, 2, 0]].ravel()
        self.head_sign = mesh.corner_signs[:, [2, 0, 1]].ravel()
        self.between = self.tail_sign * self.head_sign
        self.twisted = bool((self.between < 0).any())
        mass = np.repeat(mesh.face_areas / unit**2, 3) / 3.0
        self.mass = np.bincount(mesh.faces.ravel(), mass, mesh.n_vertices)
        self.component = mesh.vertex_components
        self.laplacian = face_laplacian(mesh)
        self.face_ordering = nested_dissection(self.laplacian)
        self.vertex_ordering: Ordering | None = None
        self.joint_ordering: Ordering | None = None

    def start(self, seed: int) -> Complexes:
        noise = np.random.default_rng(seed).normal(size=(2, self.mesh.n_vertices))
        return np.asarray(noise[0] + 1j * noise[1])

    def residual(self, theta: Scalars, s: Scalars) -> Scalars:
        """(F, 3) ``theta_b - theta_a - s_i w-perp_i . e_ab``, radians, any representative."""
        rise = self.head_sign * theta[self.head] - self.tail_sign * theta[self.tail]
        return np.asarray(rise.reshape(-1, 3) - s[:, None] * self.along)

    def energy(self, theta: Scalars, s: Scalars) -> float:
        share = s / self.unit
        smooth = 0.5 * self.smoothness * share @ (self.laplacian @ share)
        return float((self.weight * (1.0 - np.cos(self.residual(theta, s)))).sum() + smooth)

    def theta_change(self, before: Scalars, after: Scalars) -> float:
        """Root mean square change of theta, after the best constant on each component: 0 or pi if twisted."""
        turn = np.exp(1j * (after - before)) * self.mass
        mean = np.bincount(self.component, turn.real) + 1j * np.bincount(self.component, turn.imag)
        mean = np.where(self.mesh.twisted_components, mean.real, mean)
        left = wrapped(after - before - np.angle(mean)[self.component])
        return float(np.sqrt(np.average(left**2, weights=self.mass)))

    def _assembled(self, weight: Scalars, entries: Complexes | Scalars) -> sparse.csr_array:
        """``sum weight |z_b - turn z_a|^2`` as a Hermitian matrix, ``entries = weight turn``."""
        n = self.mesh.n_vertices
        off = sparse.coo_array((-entries, (self.head, self.tail)), shape=(n, n)).tocsr()
        diagonal = np.bincount(self.head, weight, n) + np.bincount(self.tail, weight, n)
        # A constant is in the kernel of the real matrix, and nearly in that of the Hermitian one.
        shift = 1e-7 * float(diagonal.mean()) * self.mass / float(self.mass.mean())
        return sparse.csr_array(off + off.conj().T + sparse.diags_array(diagonal + shift))

    def _turned(self, s: Scalars) -> sparse.csr_array:
        """``sum weight |u_b - exp(i s w-perp . e) u_a|^2``, u = z or its conjugate as the corner's sign says.

        Hermitian in z, (V, V), where all signs agree; otherwise a real matrix (2V, 2V), as it couples z to
        the conjugates of its neighbours too.
        """
        weight = self.weight.ravel()
        turn = weight * np.exp(1j * self.head_sign * (s[:, None] * self.along).ravel())
        if not self.twisted:
            return self._assembled(weight, turn)
        # conj(z_b) c z_a, or conj(z_b) c conj(z_a), in real and imaginary parts.
        blocks = np.stack([turn.real, -self.between * turn.imag, turn.imag, self.between * turn.real], axis=1)
        rows = 2 * self.head[:, None] + [0, 0, 1, 1]
        columns = 2 * self.tail[:, None] + [0, 1, 0, 1]
        size = 2 * self.mesh.n_vertices
        off = sparse.coo_array((-blocks.ravel(), (rows.ravel(), columns.ravel())), shape=(size, size)).tocsr()
        plain = self._assembled(weight, weight).diagonal()
        return sparse.csr_array(off + off.T + sparse.diags_array(np.repeat(plain, 2)))

    def _ordering(self) -> Ordering:
        if self.vertex_ordering is None:
            weight = self.weight.ravel()
            self.vertex_ordering = nested_dissection(self._assembled(weight, weight))
        return self.vertex_ordering

    def eigenvector(self, z: Complexes, theta: Scalars | None, s: Scalars) -> tuple[Complexes, Scalars]:
        """Inverse iteration for the smallest eigenvector at s; its angles replace theta if that pays."""
        matrix, ordering = self._turned(s), self._ordering()
        factors = factorized(matrix, ordering.repeated(2) if self.twisted else ordering)
        quotient = np.inf
        for _ in range(60):
            right = self.mass * z
            z = as_complex(factors.solve(as_real(right))) if self.twisted else factors.solve(right)
            z = z / np.sqrt(np.bincount(self.component, self.mass * np.abs(z) ** 2))[self.component]
            image = np.asarray(as_complex(matrix @ as_real(z)) if self.twisted else matrix @ z)
            last, quotient = quotient, float((z.conj() @ image).real)
            if last - quotient < EIGENVALUE_TOLERANCE * quotient:
                break
        found = np.angle(z)
        better = theta is None or self.energy(found, s) < self.energy(theta, s)
        return z, found if better or theta is None else theta

    def _model(self, theta: Scalars, s: Scalars) -> tuple[Scalars, Scalars, Scalars]:
        """Convex weights (F, 3) of the quadratic model, the way downhill in theta (V,), in s / shat (F,)."""
        residual, n = self.residual(theta, s), self.mesh.n_vertices
        convex = self.weight * np.maximum(np.cos(residual), LEAST_COSINE)
        pull = self.weight * np.sin(residual)
        in_theta = np.bincount(self.tail, self.tail_sign * pull.ravel(), n)
        in_theta -= np.bincount(self.head, self.head_sign * pull.ravel(), n)
        in_share = (pull * self.slope).sum(axis=1) - self.smoothness * (self.laplacian @ (s / self.unit))
        return convex, np.asarray(in_theta, dtype=np.float64), np.asarray(in_share)

    def improve_theta(self, theta: Scalars, s: Scalars) -> Scalars:
        """One Gauss-Newton step of Eq. 8 in theta alone."""
        convex, in_theta, _ = self._model(theta, s)
        matrix = self._assembled(convex.ravel(), self.between * convex.ravel())
        step = factorized(matrix, self._ordering()).solve(in_theta)
        length = _damping(lambda length: self.energy(theta + length * step, s))
        return theta + length * step

    def improve_both(self, theta: Scalars, s: Scalars) -> tuple[Scalars, Scalars]:
        """One Gauss-Newton step of Eq. 8 in theta and s together; s stays above its floor."""
        mesh, share = self.mesh, s / self.unit
        n = mesh.n_vertices
        convex, in_theta, in_share = self._model(theta, s)
        # A face at its floor that would go below it stays where it is.
        free = sparse.diags_array(((share > self.least * (1 + 1e-9)) | (in_share > 0)).astype(np.float64))
        held = sparse.diags_array(1.0 - free.diagonal())
        face = np.tile(np.repeat(np.arange(mesh.n_faces), 3), 2)
        mixed = (-convex * self.slope).ravel()
        cross = sparse.csr_array(
            (
                np.concatenate([self.head_sign * mixed, -self.tail_sign * mixed]),
                (np.concatenate([self.head, self.tail]), face),
            ),
            shape=(n, mesh.n_faces),
        )
        lower = sparse.diags_array((convex * self.slope**2).sum(axis=1)) + self.smoothness * self.laplacian
        upper = self._assembled(convex.ravel(), self.between * convex.ravel())
        cross, lower = cross @ free, free @ lower @ free + held
        matrix = sparse.csr_array(sparse.block_array([[upper, cross], [cross.T, lower]], format="csr"))
        self.joint_ordering = self.joint_ordering or nested_dissection(matrix)
        step = factorized(matrix, self.joint_ordering).solve(np.concatenate([in_theta, free @ in_share]))

        def at(length: float) -> tuple[Scalars, Scalars]:
            return theta + length * step[:n], self.unit * np.maximum(share + length * step[n:], self.least)

        return at(_damping(lambda length: self.energy(*at(length))))

    def improve_s(self, theta: Scalars, s: Scalars) -> Scalars:
        """One Gauss-Newton step of Eq. 8 in s alone, to the best s above its floor."""
        share = s / self.unit
        stiffness = (self.weight * self.slope**2).sum(axis=1)
        matrix = sparse.csr_array(sparse.diags_array(stiffness) + self.smoothness * self.laplacian)
        _, _, in_share = self._model(theta, s)
        # The model 1/2 r' K r - (K share + downhill)' r, minimised over r >= least.
        best = bounded_minimum(matrix, matrix @ share + in_share, self.least, self.face_ordering)
        length = _damping(lambda length: self.energy(theta, self.unit * (share + length * (best - share))))
        return np.asarray(self.unit * (share + length * (best - share)))


def _damping(energy: Callable[[float], float]) -> float:
    """Length of a step, halved from 1 until the energy is no higher than at its start; 0 if it never is."""
    before, length = energy(0.0), 1.0
    while length > 1e-3:
        if energy(length) <= before:
            return length
        length *= 0.5
    return 0.0
