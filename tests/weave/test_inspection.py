"""What a maker is told before cutting."""

from __future__ import annotations

import pytest
from laidlines import SPACING, laid, made, triaxial

from geoweave.errors import FieldError
from geoweave.weave.inspection import Limits, inspected
from geoweave.weave.places import KINDS


def test_a_flat_even_weave_has_nothing_to_tell() -> None:
    found = inspected(laid(triaxial(0.5), width=0.9 * SPACING / 3))
    assert found.counts == dict.fromkeys(KINDS, 0)
    assert found.violations == ()
    # triangles of side d / sqrt 3, whose incircle is d / 3 wide
    assert found.suggested_width == pytest.approx(SPACING / 3)
    assert found.share_that_fits == 1.0
    assert all(width == pytest.approx(SPACING / 3) for _, width in found.widths)


def test_the_document_counts_its_places() -> None:
    found = inspected(made().sized(200.0, width=8.0))
    document = found.document()
    assert (document["units"], document["width"]) == ("mm", pytest.approx(8.0))
    assert document["metres"] == pytest.approx(document["total_length"] / 1000)
    assert document["alternation"] == made().metrics()["alternation"]
    assert sum(document["counts"].values()) == len(document["places"])
    assert set(document["counts"]) == set(KINDS)
    names = set(made().names)
    assert all(set(place["ribbons"]) <= names for place in document["places"])
    with pytest.raises(FieldError, match="'angle' of an inspection"):
        Limits(angle=-1)
