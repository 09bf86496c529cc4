"""Global integration with integer variables: mixed-integer quadrangulation for one direction (Section 4.2.4).

Bommes, Zimmer and Kobbelt 2009, reduced from a pair of directions to one. The paper compares its theta with
this one (Fig. 15).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike
from scipy import sparse

from geoweave.arrays import Indices, Scalars
from geoweave.errors import FieldError
from geoweave.fields import ClosedFields, FaceField, as_real, differences
from geoweave.foliation import TURN, CircleFunction
from geoweave.sparse import factorized, nested_dissection, one_blas_thread


class Rounding(NamedTuple):
    """What `greedy_rounding` returns.

    ``values`` (n,) int64 the integers; ``relaxed`` (n,) the minimiser without the condition; ``rise`` >= 0
    what the condition costs, ``q(values) - q(relaxed)``.
    """

    values: Indices
    relaxed: Scalars
    rise: float


@one_blas_thread()
def mixed_integer_parameterization(
    field: FaceField, scale: ArrayLike, *, anisotropy: float = 1.0
) -> CircleFunction:
    """Find the theta without dislocations whose gradient is nearest to ``s w-perp`` (Bommes et al. 2009).

    Minimises ``sum_i A_i |grad theta - s w-perp|^2_{g_i}`` with w-perp = -1j w in the metric
    ``g = w w' + alpha w-perp w-perp'`` of Section 4.2.4, over functions whose change along every closed curve
    is a whole number of turns. ``grad theta = B x`` runs over the closed fields (`ClosedFields`); the
    coordinates on the generators are periods and become multiples of 2 pi by `greedy_rounding`. Generators
    include one for every boundary loop but one, as for the holes that Bommes et al. cut at singularities.

    The vertex values are eliminated first: one factorisation, and the rounding works on a dense matrix of the
    size of the first Betti number.

    Parameters
    ----------
    field : unit field w on the surface, without singularities
    scale : (F,) or one number, s: radians per length
    anisotropy : alpha. 1 weighs all of the gradient; small values free its length and keep its direction

    Raises
    ------
    FieldError
        If the scale does not fit or is not finite, or alpha is not in (0, 1].
    """
    mesh = field.mesh
    wanted = np.asarray(scale, dtype=np.float64)
    if wanted.shape not in ((), (mesh.n_faces,)) or not np.isfinite(wanted).all():
        raise FieldError(f"a scale is one finite number or ({mesh.n_faces},) of them, not {wanted.shape}")
    if not 0 < anisotropy <= 1:
        raise FieldError(f"the anisotropy must be above 0 and at most 1, not {anisotropy}")
    closed = ClosedFields(mesh)
    metric = _metric(field, anisotropy)
    matrix = sparse.csr_array(closed.basis_transposed @ metric @ closed.basis)
    right = closed.basis_transposed @ (metric @ as_real(-1j * wanted * field.values))

    free = len(closed.free_vertices)
    inner = sparse.csr_array(matrix[:free, :free])
    factors = factorized(inner, nested_dissection(inner))
    coupling = matrix[:free, free:].toarray()
    response = factors.solve(coupling)
    schur = matrix[free:, free:].toarray() - coupling.T @ response
    periods = greedy_rounding(TURN**2 * schur, TURN * (right[free:] - response.T @ right[:free])).values

    theta = np.zeros(mesh.n_vertices)
    theta[closed.free_vertices] = factors.solve(right[:free] - TURN * (coupling @ periods))
    return CircleFunction(mesh, theta, differences(mesh) @ theta + TURN * (closed.generators @ periods))


def greedy_rounding(matrix: Scalars, right: Scalars) -> Rounding:
    """Minimise ``q(k) = k' S k / 2 - b' k`` over integers, one variable after the other (Bommes et al. 2009).

    Solves without the condition, fixes the variable nearest to an integer there, solves for the rest, and so
    on. Each fixing is a rank-one update of the inverse. A step with distance d raises q by
    ``d^2 / (2 C_kk) <= S_kk / 8``, C the inverse for the variables still free, so that the result is at most
    ``trace(S) / 8`` above the relaxed minimum; it need not be the best.

    Parameters
    ----------
    matrix : S, (n, n) symmetric positive definite
    right : b, (n,)
    """
    count = len(right)
    if not count:
        return Rounding(np.zeros(0, dtype=np.int64), np.zeros(0), 0.0)
    inverse = np.linalg.inv(matrix)
    relaxed = inverse @ right
    current, values, rise = relaxed.copy(), np.zeros(count, dtype=np.int64), 0.0
    free = np.ones(count, dtype=bool)
    for _ in range(count):
        distance = np.where(free, np.abs(current - np.rint(current)), np.inf)
        k = int(np.argmin(distance))
        values[k] = int(np.rint(current[k]))
        step, column = values[k] - current[k], inverse[:, k] / inverse[k, k]
        rise += 0.5 * step**2 / inverse[k, k]
        # The others follow along the column; what is fixed stays, since its row and column are zero.
        current = current + step * column
        inverse = inverse - np.outer(column, inverse[k])
        free[k] = False
        inverse[k], inverse[:, k], inverse[k, k] = 0.0, 0.0, 1.0
    return Rounding(values, relaxed, float(rise))


def _metric(field: FaceField, anisotropy: float) -> sparse.csr_array:
    """Areas times the metric ``w w' + alpha w-perp w-perp'`` on each face, (2F, 2F) block diagonal."""
    mesh = field.mesh
    areas, x, y = mesh.face_areas, field.values.real, field.values.imag
    cross = areas * (1.0 - anisotropy) * x * y
    blocks = np.stack(
        [areas * (x * x + anisotropy * y * y), cross, cross, areas * (y * y + anisotropy * x * x)], axis=1
    )
    base = 2 * np.arange(mesh.n_faces)[:, None]
    rows, columns = base + [0, 0, 1, 1], base + [0, 1, 0, 1]
    return sparse.csr_array(
        (blocks.ravel(), (rows.ravel(), columns.ravel())), shape=(2 * mesh.n_faces, 2 * mesh.n_faces)
    )
