"""What Section 4.2 says of its integration against others (Figs. 13 and 15), on fields of Algorithm 1.

All methods draw the same length of level sets on the same punctured surface (`comparisons`).
"""

from __future__ import annotations

from functools import cache

import pytest

from geoweave.comparisons.integration_methods import PAPER, Method, geodesic_from, integrated
from geoweave.fields.face_field import FaceField
from geoweave.foliation.foliation import foliate
from geoweave.foliation.level_set_alignment import Alignment
from geoweave.models import shapes

SURFACES = ("torus", "genus 4")


@cache
def field(name: str) -> FaceField:
    mesh = shapes.torus(faces=6000) if name == "torus" else shapes.genus_g(4, faces=6000)
    return geodesic_from(mesh.normalized()[0], "random" if name == "torus" else "smoothest")


@cache
def measured(name: str, method: Method) -> Alignment:
    return integrated(field(name), method, 36.0).alignment


@pytest.mark.parametrize("name", SURFACES)
def test_ours_follows_the_field_best(name: str) -> None:
    """Fig. 15: "integral curves well-aligned to the vector fields", "robust to singularities"."""
    others = [measured(name, method).mean for method in PAPER if method != "ours"]
    # Measured 1.8 against 2.7 degrees on the torus, 3.6 against 4.8 on genus 4: a fifth is what we hold.
    assert measured(name, "ours").mean < 0.8 * min(others)


@pytest.mark.parametrize("name", SURFACES)
def test_ours_breaks_fewest_level_sets_of_the_periodic_methods(name: str) -> None:
    """Fig. 15: "robust to singularities", at the same length of level sets."""
    ours = measured(name, "ours").dislocations
    # Measured 12 against 48 and 39 on the torus, 0 against 16 and 0 on genus 4.
    assert ours < measured(name, "periodic").dislocations
    assert ours <= measured(name, "curl-corrected").dislocations


@pytest.mark.parametrize("name", SURFACES)
def test_mixed_integer_does_not_align_as_well(name: str) -> None:
    """Section 4.2.4: "the method yields isolines that do not align as well to the input field"."""
    integer = measured(name, "mixed-integer")
    assert integer.median > 1.5 * measured(name, "ours").median
    assert integer.dislocations == 0


@pytest.mark.parametrize("name", SURFACES)
def test_anisotropy_aligns_at_the_cost_of_spacing(name: str) -> None:
    """Section 4.2.4: an anisotropic metric "comes at the cost of very poorly-spaced integral curves"."""
    isotropic, anisotropic = measured(name, "mixed-integer"), measured(name, "anisotropic")
    assert anisotropic.median < isotropic.median
    # Measured 0.2 -> 1.9 and 0.3 -> 0.8; ours has 0.6 and 0.4.
    assert anisotropic.spacing_spread > 2.0 * isotropic.spacing_spread
    assert anisotropic.spacing_spread > 1.5 * measured(name, "ours").spacing_spread


@pytest.mark.parametrize("name", SURFACES)
def test_local_curl_correction_does_not_help(name: str) -> None:
    """Section 4.2.3: minimising local curl "suffers from the same pitfall" near singularities."""
    corrected = measured(name, "curl-corrected")
    assert corrected.mean > 1.2 * measured(name, "ours").mean
    # On genus 4 it comes out level with no correction at all, on the torus twice as bad.
    assert corrected.mean > 0.9 * measured(name, "periodic").mean


@pytest.mark.parametrize("name", SURFACES)
def test_at_half_a_turn_per_edge_ours_breaks_fewest_level_sets(name: str) -> None:
    """Footnote 4: where s is scaled until the steepest edge holds half a turn, ours has few dislocations.

    A factor that varies then has fewer level sets, too; Fig. 15 compares at equal frequency.
    """
    ours = foliate(field(name), quantile=1.0)
    plain = foliate(field(name), quantile=1.0, rescaling=None, weighting="uniform")
    # Measured 0 against 60 on the torus, 2 against 76 on genus 4.
    assert ours.alignment.dislocations <= 5
    assert plain.alignment.dislocations > 20
