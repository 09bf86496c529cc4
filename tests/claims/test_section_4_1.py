"""What Section 4.1 says of its fields, on real scans and on the sphere; bounding radius 1 throughout.

The scans that may not be shipped are tested where they are at hand (``geoweave fetch``, or a folder named by
GEOWEAVE_DATA_DIR, or one beside the checkout) and reported as skipped where not.
"""

from __future__ import annotations

from functools import cache
from pathlib import Path

import numpy as np
import pytest
from _pytest.mark import ParameterSet

from geoweave.fields.face_field import total_curl
from geoweave.fields.geodesic import GeodesicSolve, geodesic_field
from geoweave.fields.rosy import diffused_field, smoothest_field
from geoweave.fields.singularities import circulation, index_sum, singular_vertices
from geoweave.models import catalogue, datasets, shapes

NEARBY = Path(__file__).resolve().parents[3] / "shared" / "meshes"
SHIPPED = ("armadillo", "spot", "bunny", "camel", "rocker-arm-like", "schwarz-p")


def _at_hand(name: str) -> bool:
    with pytest.MonkeyPatch.context() as patch:
        _look_nearby(patch)
        return datasets.available(name)


def _look_nearby(patch: pytest.MonkeyPatch) -> None:
    if NEARBY.is_dir():
        patch.setenv(datasets.VARIABLE, str(NEARBY))


FETCHED = ("rocker-arm", "cow", "fertility")


def cases(*names: str) -> list[ParameterSet]:
    return [
        pytest.param(name, marks=pytest.mark.skipif(not _at_hand(name), reason=f"run: geoweave fetch {name}"))
        if name in FETCHED
        else pytest.param(name)
        for name in names
    ]


def solved(name: str, patch: pytest.MonkeyPatch) -> GeodesicSolve:
    _look_nearby(patch)
    return _solved(name)


@cache
def _solved(name: str) -> GeodesicSolve:
    """The field of a model, which several tests look at."""
    return geodesic_field(smoothest_field(catalogue.load(name)), phases=4)


@pytest.mark.parametrize("name", cases(*SHIPPED, *FETCHED))
def test_table_1_total_curl_drops_by_a_third(name, monkeypatch):
    """Table 1: "our algorithm significantly reduced the total curl", from Eq. 5 without the constraint."""
    _look_nearby(monkeypatch)
    start = diffused_field(catalogue.load(name))
    solve = geodesic_field(start)
    # Other meshes than the authors': that it drops is the claim, a third is the issue's measure of it.
    assert total_curl(solve.field) < 2 / 3 * total_curl(start)


# The authors' code ends at 10.05, 9.05 and 7.92 with 34, 28 and 44 singularities on the same files.
LIMITS = {"rocker-arm": (9.0, 20), "fertility": (7.6, 22), "cow": (7.1, 32), "schwarz-p": (13.0, 20)}


@pytest.mark.parametrize("name", cases(*LIMITS))
def test_final_curl_is_below_that_of_the_authors_code(name, monkeypatch):
    solve = solved(name, monkeypatch)
    curl, singularities = LIMITS[name]
    assert total_curl(solve.field) <= curl
    assert len(singular_vertices(solve.field)) <= singularities
    assert index_sum(solve.field) == solve.field.mesh.euler_characteristic


@pytest.mark.parametrize("name", cases(*SHIPPED, *FETCHED))
def test_no_vorticity_near_singularities(name, monkeypatch):
    """Section 4.1.2: "integral curves are locally geodesics, with no vorticity near singularities"."""
    solve = solved(name, monkeypatch)
    around = np.abs(circulation(solve.field, singular_vertices(solve.field)))
    # Measured 0.055 at most, against up to 0.9 for the smoothest fields.
    assert around.max() < 0.08


def test_sphere_of_figure_7():
    """Fig. 7: great circles through two singularities without vorticity, total curl near zero."""
    sphere = shapes.sphere(subdivisions=5).normalized()[0]
    for phase in ("least-curl", "seeded"):
        solve = geodesic_field(smoothest_field(sphere, phase=phase), phases=4)
        assert total_curl(solve.field) < 0.75
        ends = singular_vertices(solve.field)
        assert len(ends) == 2
        assert np.abs(circulation(solve.field, ends)).max() < 0.01
