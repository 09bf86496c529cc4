"""The phase between three families: one condition on every sheet, and kagomes where they can be perfect."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
from scipy.spatial import cKDTree
from surfaces import surface

from geoweave.errors import FieldError
from geoweave.fields.rosy import smoothest_rosy
from geoweave.foliation.foliation import punctured
from geoweave.foliation.phase_energy import PhaseEnergy
from geoweave.models import shapes
from geoweave.surface.mesh import TriMesh
from geoweave.weave.cover import branched_cover
from geoweave.weave.design import WeaveField, weave_field
from geoweave.weave.phase import phase_of
from geoweave.weave.regularity import Cells, Regularity
from geoweave.weave.weave import Weave

PERFECT = {
    "disk": lambda: shapes.disk(faces=1500),
    "cone": lambda: shapes.cone(half_angle=60.0, faces=1500),
    "icosahedron": lambda: shapes.icosahedron(faces=2000),
}


@cache
def field_of(name: str) -> WeaveField:
    return weave_field(PERFECT[name]())


@cache
def woven(name: str) -> Weave:
    return field_of(name).pattern()


def piled(weave: Weave) -> float:
    """Share of the crossings that have another within 0.3 spacings."""
    points = weave.ribbons.crossings.points
    nearest = cKDTree(points).query(points, k=2)[0][:, 1]
    return float((nearest < 0.3 * weave.ribbons.spacing).mean())


@pytest.mark.parametrize("name", PERFECT)
def test_a_perfect_surface_gets_a_perfect_kagome(name: str) -> None:
    field, weave = field_of(name), woven(name)
    found = weave.design.foliation
    assert found is not None
    triples = field.cover.quotient.triples.on(found.part)
    energy = PhaseEnergy(found.field, found.s, triples)
    assert np.quantile(np.abs(energy.phase(found.circle.theta)), 0.99) < 0.05
    made = Regularity.of(weave)
    assert made.piled == 0
    # five ribbons close the cell at the apex of the cone, and those at the corners of the icosahedron
    corners = {"disk": 0, "cone": 1, "icosahedron": 12}[name]
    cells = Cells.of(weave.ribbons.curves, weave.ribbons.crossings).corners
    assert (~np.isin(cells, (3, 6))).sum() == corners
    assert weave.interlacing.alternation == 1.0


@pytest.mark.parametrize("name", ["sphere", "torus", "jagged sphere"])
def test_the_phase_is_one_condition_on_every_sheet(name: str) -> None:
    """The turn by one sheet takes theta to a theta with -phi, so phi = 0 (mod pi) says the same of both."""
    cover = branched_cover(smoothest_rosy(surface(name), 6))
    quotient = cover.quotient
    w, part = punctured(quotient.field)
    assert len(part.faces) == quotient.mesh.n_faces
    energy = PhaseEnergy(w, np.ones(part.mesh.n_faces), quotient.triples.on(part))
    theta = np.random.default_rng(0).uniform(-3.0, 3.0, part.mesh.n_vertices)
    # theta on every corner of the cover, odd on antipodal sheets
    seen = (theta[part.mesh.faces] * part.mesh.bundle.corners)[quotient.faces] * quotient.signs[:, None]
    by_sheet = seen.reshape(6, -1, 3)
    even, odd = by_sheet[[0, 2, 4]].sum(axis=0), by_sheet[[1, 3, 5]].sum(axis=0)
    np.testing.assert_allclose(even, -odd, atol=1e-12)
    # across every edge, cut or not, the phase at a corner is the same up to its sign
    below, corners = cover.part.mesh, {}
    for vertex in range(below.n_vertices):
        corners[vertex] = np.abs(even[below.faces == vertex])
    assert max(float(np.ptp(each)) for each in corners.values()) < 1e-9
    # and the energy sees each place once
    assert len(energy.mass) == below.n_vertices
    again = np.sort(np.abs(energy.sum @ theta))
    np.testing.assert_allclose(again, np.sort([each[0] for each in corners.values()]), atol=1e-9)


def test_frequencies_of_a_rosy_fit_together() -> None:
    quotient = branched_cover(smoothest_rosy(surface("torus"), 6)).quotient
    ones = np.ones(quotient.mesh.n_faces)
    energy = PhaseEnergy(quotient.field, ones, quotient.triples)
    assert ones @ (energy.closing @ ones) == pytest.approx(0.0, abs=1e-12)


@pytest.mark.parametrize(("degree", "ribbons"), [(3, 1), (6, 2), (9, 1), (12, 2)])
def test_triples_of_other_symmetries(degree: int, ribbons: int) -> None:
    cover = branched_cover(smoothest_rosy(surface("sphere"), degree))
    triples = cover.quotient.triples
    w = cover.quotient.field.values[triples.faces] * triples.signs
    np.testing.assert_allclose(w.sum(axis=1), 0.0, atol=1e-12)
    assert triples.ribbons == ribbons
    # every face of the quotient is in one triple
    assert np.bincount(triples.faces.ravel()).tolist() == [1] * cover.quotient.mesh.n_faces


def test_regular_is_for_symmetries_that_three_divides() -> None:
    assert [phase_of(n, None) for n in (3, 4, 5, 6)] == ["free", "free", "free", "regular"]
    assert phase_of(3, "regular") == "regular"
    assert phase_of(6, "free") == "free"
    with pytest.raises(FieldError, match="3 divides, as 6, not 4"):
        phase_of(4, "regular")
    with pytest.raises(FieldError, match="no phase 'odd'"):
        phase_of(6, "odd")  # type: ignore[arg-type]
    for degree in (4, 5):
        with pytest.raises(FieldError, match="3 divides"):
            branched_cover(smoothest_rosy(surface("sphere"), degree)).quotient.triples  # noqa: B018


def test_the_phase_lowers_the_share_of_piled_crossings() -> None:
    mesh: TriMesh = shapes.torus(faces=2500)
    regular, free = (weave_field(mesh, phase=each).pattern() for each in ("regular", "free"))
    assert piled(regular) < 0.3 * piled(free)  # 0.12 and 0.70; half is what chance gives
