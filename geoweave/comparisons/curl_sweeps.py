"""How much curl Algorithm 1 removes on other meshes, and with another end of the sharpening (Table 1)."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from geoweave.fields import (
    FaceField,
    diffused_field,
    geodesic_field,
    sharpening_schedule,
    singular_vertices,
    total_curl,
)
from geoweave.meshing import isotropic_remesh
from geoweave.surface import TriMesh


class CurlDrop(NamedTuple):
    """What Algorithm 1 did from one start."""

    value: float
    """What was varied: triangles, or the last lambda in squared mean edges."""
    before: float
    """Total curl of the start, as a length."""
    after: float
    """Total curl of the result."""
    singularities: int
    """Singular vertices of the result."""

    @property
    def drop(self) -> float:
        """Share of the total curl that is gone, ``1 - after / before``."""
        return 1.0 - self.after / self.before


def curl_by_resolution(
    mesh: TriMesh, faces: Sequence[int], *, smoothness: float = 1.0, seed: int = 0
) -> list[CurlDrop]:
    """Remesh a shape and let Algorithm 1 run on each mesh, from the paper's start (Sections 4.1.3, Table 1).

    Parameters
    ----------
    mesh : the shape
    faces : about how many triangles each mesh gets
    smoothness : lambda of the start, unit length^2
    seed : of the start

    Examples
    --------
    >>> from geoweave import comparisons
    >>> rows = comparisons.curl_by_resolution(gw.shapes.genus_g(2, faces=900), [400, 800])
    >>> [bool(row.drop > 0.3) for row in rows]
    [True, True]
    """
    found = []
    for count in faces:
        start = diffused_field(isotropic_remesh(mesh, count), smoothness, seed)
        found.append(_dropped(count, start))
    return found


def curl_by_last_smoothness(start: FaceField, ends: Sequence[float]) -> list[CurlDrop]:
    """Let Algorithm 1 run from one start with other ends of the sharpening (Section 4.1.2).

    Parameters
    ----------
    start : the field before
    ends : the last lambda, in squared mean edges

    Examples
    --------
    >>> from geoweave import comparisons
    >>> start = gw.smoothest_field(gw.shapes.genus_g(2, faces=900))
    >>> coarse, fine = comparisons.curl_by_last_smoothness(start, [0.5, 0.005])
    >>> coarse.drop < fine.drop
    True
    """
    found = []
    for end in ends:
        found.append(_dropped(end, start, sharpening_schedule(start.mesh, finest=end)))
    return found


def _dropped(value: float, start: FaceField, schedule: Sequence[float] | None = None) -> CurlDrop:
    result = geodesic_field(start, smoothness=schedule).field
    return CurlDrop(value, total_curl(start), total_curl(result), len(singular_vertices(result)))
