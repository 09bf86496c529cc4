"""How a pattern is made, and what its files are cut from."""

from __future__ import annotations

import pytest

from geoweave.errors import FieldError
from geoweave.fabrication.bench import Bench, media_of
from geoweave.fabrication.maker_files import FORMATS


def test_files_that_are_cut_have_their_media() -> None:
    assert media_of(["svg", "dxf"], ("a4",)) == ("sheet",)
    assert media_of(["csv", "pdf", "svg"], ("a4", "letter")) == ("stock", "a4", "letter", "sheet")
    assert media_of(["pattern", "guide"], ("a4",)) == ("whole",)
    assert set(media_of(FORMATS, ("a3",))) == {"stock", "sheet", "a3"}


@pytest.mark.parametrize(
    ("numbers", "words"),
    [
        ({"papers": ("b5",)}, "no paper"),
        ({"density": 0.0}, "density"),
        ({"stock_length": -1.0}, "stock length"),
    ],
)
def test_refusals(numbers: dict[str, object], words: str) -> None:
    with pytest.raises(FieldError, match=words):
        Bench(**numbers)  # type: ignore[arg-type]
