"""A request that contradicts itself, or is out of reach, is refused when it is made."""

import pytest

from geoweave.errors import FieldError
from geoweave.files import OutputError
from geoweave.pipeline.request import BOUNDS, WeaveRequest, formats_of


def test_a_request_that_contradicts_itself_is_refused() -> None:
    with pytest.raises(FieldError, match="exclude each other"):
        WeaveRequest(ribbons=9, scale=2.0)
    for name in ("scale", "size", "width", "thickness"):
        for bad in (0.0, -1.0, float("nan"), float("inf")):
            with pytest.raises(FieldError, match=f"{name} is {bad}; give a positive number"):
                WeaveRequest(**{name: bad})
    with pytest.raises(FieldError, match=r"a pattern .svg. is in mm"):
        formats_of(["svg"], None)
    with pytest.raises(OutputError, match="no format 'dwg'"):
        formats_of(["dwg"], 100.0)
    assert formats_of(["svg", "json", "rod", "csv"], 100.0) == (("csv", "svg"), ("json", "rod"))


def test_numbers_have_bounds_and_ribbons_fit_the_object() -> None:
    for name, most in BOUNDS.items():
        with pytest.raises(FieldError, match=f"{name} is .*; give at most"):
            WeaveRequest(**{name: 2 * most})
    WeaveRequest(width=3.0, thickness=3.0)
    with pytest.raises(FieldError, match="thinner than wide"):
        WeaveRequest(width=3.0, thickness=3.1)
    with pytest.raises(FieldError, match="the thickness of a ribbon is 100, and the object 100 long"):
        WeaveRequest(size=100.0, thickness=100.0)


def test_curved_strips_are_those_of_a_weave_at_rest() -> None:
    assert WeaveRequest(strips="designed").relax
    with pytest.raises(FieldError, match="leave out --no-relax"):
        WeaveRequest(strips="optimal", relax=False)
    with pytest.raises(FieldError, match="straight, designed, optimal"):
        WeaveRequest(strips="bent")


def test_formats_that_nobody_named() -> None:
    assert WeaveRequest().formats_wanted == ("json",)
    assert WeaveRequest(size=100.0).formats_wanted == ("json", "guide")
    assert WeaveRequest(size=100.0, formats=("svg",)).formats_wanted == ("svg",)
