"""What Sections 3 and 4.1 say of geodesic fields beside smooth ones and Pottmann et al. (Figs. 3 and 7)."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

from geoweave.comparisons.anti_holomorphic_fields import anti_holomorphic_field
from geoweave.comparisons.great_circles import meridian_angle, meridian_axis
from geoweave.comparisons.pottmann_fields import fitted_curl, pottmann_field
from geoweave.comparisons.singular_curves import singular_lines
from geoweave.curves.curve_crossings import crossings
from geoweave.curves.curves import Curves, bending
from geoweave.curves.tracing import streamlines
from geoweave.fields.face_field import FaceField, total_curl
from geoweave.fields.geodesic import geodesic_field
from geoweave.fields.operators import as_real, curl, gradient
from geoweave.fields.rosy import smoothest_field
from geoweave.fields.singularities import circulation, singular_vertices
from geoweave.models import catalogue, shapes

SMOOTH = ("Dirichlet", "anti-holomorphic")


@cache
def on_the_sphere(seed: int) -> dict[str, FaceField]:
    """The four fields of Fig. 7 from one random vector, with 8,000 faces."""
    sphere = shapes.sphere(faces=8_000).normalized()[0]
    start = smoothest_field(sphere, seed, phase="seeded")
    return {
        "Dirichlet": start,
        "anti-holomorphic": anti_holomorphic_field(sphere, seed),
        "Pottmann": pottmann_field(start).field,
        "ours": geodesic_field(start).field,
    }


@cache
def on_the_animal(name: str) -> dict[str, FaceField]:
    start = smoothest_field(catalogue.load(name))
    return {
        "Dirichlet": start,
        "Pottmann": pottmann_field(start).field,
        "ours": geodesic_field(start, phases=4).field,
    }


@cache
def lines_on(name: str, method: str) -> Curves:
    return streamlines(on_the_animal(name)[method])


def off_great_circles(field: FaceField) -> float:
    """Mean angle in degrees to the great circles that fit the field best."""
    angle = meridian_angle(field, meridian_axis(field))
    return float(np.degrees(np.average(angle, weights=field.mesh.face_areas)))


def vorticity(field: FaceField) -> float:
    return float(np.abs(circulation(field, singular_vertices(field))).max())


@pytest.mark.parametrize("seed", [0, 5])
def test_only_ours_follows_great_circles(seed):
    """Fig. 7: "only our method yields a field aligned to the expected great circles"."""
    off = {name: off_great_circles(field) for name, field in on_the_sphere(seed).items()}
    # One degree is what flat triangles of this size are off themselves; measured 0.73 to 0.84.
    assert off["ours"] < 1
    # Measured 4.8 to 8.6 for Pottmann et al. and 14 to 35 for the smooth fields, over eight seeds.
    assert off["Pottmann"] > 3 * off["ours"]
    assert min(off[name] for name in SMOOTH) > 10 * off["ours"]


@pytest.mark.parametrize("seed", [0, 5])
def test_only_ours_has_no_vorticity(seed):
    """Fig. 7: "with no vorticity at the two field singularities"; 4.1.2: Pottmann's is not vorticity-free."""
    spin = {name: vorticity(field) for name, field in on_the_sphere(seed).items()}
    assert len(singular_vertices(on_the_sphere(seed)["ours"])) == 2
    assert spin["ours"] < 0.005
    # It depends on the start: 0.14 to 0.94 for the smooth fields, 0.005 to 0.6 for Pottmann's.
    assert min(spin[name] for name in SMOOTH) > 0.1
    assert spin["Pottmann"] > max(0.01, 10 * spin["ours"])


@pytest.mark.parametrize("name", ["camel", "spot"])
def test_smooth_fields_may_have_high_geodesic_curvature(name):
    """Fig. 3: the lines of smooth fields "may have high amounts of geodesic curvature"."""
    bent, straight = (bending(lines_on(name, method)) for method in ("Dirichlet", "ours"))
    assert straight < 0.6 * bent


@pytest.mark.parametrize("name", ["camel", "spot"])
def test_pottmanns_field_is_locally_geodesic(name):
    """Fig. 3: the method "produces a locally-geodesic field": straight between its lines."""
    bent, patched = (bending(lines_on(name, method)) for method in ("Dirichlet", "Pottmann"))
    # 0.3 to 0.65 over the settings in DEVIATIONS.md (sharpening after Pottmann et al.).
    assert patched < 0.75 * bent
    # What it makes small on most faces, there smaller than ours: at most 0.6 of it over those settings.
    measure = fitted_curl(on_the_animal(name)["ours"].mesh)
    theirs, ours = (
        np.median(np.abs(measure @ as_real(on_the_animal(name)[method].values)))
        for method in ("Pottmann", "ours")
    )
    assert theirs < ours


@pytest.mark.parametrize("name", ["camel", "spot"])
def test_pottmanns_field_has_singular_lines_that_hold_curl(name):
    """Fig. 3: "but with a large number of singular lines"; ours meets its own at nearly equal angles."""
    theirs, ours = (singular_lines(on_the_animal(name)[method]) for method in ("Pottmann", "ours"))
    # Over the settings in DEVIATIONS.md they are from shorter than ours to four times as long, with 4.7 times
    # the curl and more on these two models, 2.3 times on the cow.
    assert len(theirs) > 1
    assert theirs.curl > 2 * ours.curl


@pytest.mark.parametrize("name", ["camel", "spot"])
def test_ours_is_globally_nearly_geodesic(name):
    """Fig. 3: "our approach yields globally, nearly geodesic foliations", straight with its lines counted."""
    fields = on_the_animal(name)
    # The total curl of a unit field is the curvature of its lines, and of its walls. That of Pottmann's comes
    # within 4 % of ours at some settings, so it is not compared.
    assert total_curl(fields["ours"]) < 0.5 * total_curl(fields["Dirichlet"])
    assert vorticity(fields["ours"]) < 0.08
    # Three times and more over the settings in DEVIATIONS.md.
    assert vorticity(fields["Pottmann"]) > 2 * vorticity(fields["ours"])
    assert not len(crossings(lines_on(name, "ours")))


def test_only_the_fitted_curl_is_ill_defined_near_singularities():
    """4.1: theirs "is again ill-defined near singularities"; Eq. 3 "is well-defined even near" them."""
    points = np.random.default_rng(0).uniform(-0.5, 0.5, (12, 2))
    seen = []
    for faces in (2000, 8000):
        disk = shapes.disk(faces=faces)
        theirs = fitted_curl(disk)
        # Distances from points that are no vertices: singular there, and curl-free by Eq. 3 all the same.
        slopes = [gradient(disk) @ np.linalg.norm(disk.vertices[:, :2] - point, axis=1) for point in points]
        assert max(np.abs(curl(disk) @ slope).max() for slope in slopes) < 1e-12
        seen.append(np.mean([np.abs(theirs @ slope).max() for slope in slopes]))
    # Refined, theirs grows with 1 / h instead of going to the zero it should measure.
    assert seen[1] > 1.5 * seen[0] > 3
