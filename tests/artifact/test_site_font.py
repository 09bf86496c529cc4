"""The font of the mathematics: what is used of it, and nothing else."""

from __future__ import annotations

import importlib.util
import io
from pathlib import Path

import pytest
from fontTools.ttLib import TTFont

from geoweave.artifact.site_font import NOTICE, characters, math_font
from geoweave.artifact.site_text import equation
from geoweave.files import OutputError


def test_characters_of_the_equations_and_their_slanted_forms() -> None:
    found = characters([f"<p>text</p>{equation('h + 2 = ' + chr(92) + 'theta')}", "<p>more</p>"])
    assert set(found) == set("h+2=θ𝜃ℎ")
    assert list(found) == sorted(found)
    assert characters(["<p>no mathematics</p>"]) == ""


def test_the_font_has_them_and_the_table_for_mathematics() -> None:
    text = "h+2=θ𝜃ℎ√‖(⟂∑"
    data = math_font(text)
    font = TTFont(io.BytesIO(data))
    assert font.flavor == "woff"
    # And what mirrors them.
    assert {chr(code) for code in font.getBestCmap()} == {*text, ")"}
    constants = font["MATH"].table.MathConstants
    assert constants.SuperscriptShiftUp.Value > 0
    # Roots and norms grow: their larger forms are there as well.
    assert font["maxp"].numGlyphs > len(text) + 10
    assert len(data) < 40_000
    assert data == math_font(text)
    assert "Open Font License" in NOTICE


def test_a_font_that_does_not_do_is_refused(tmp_path: Path) -> None:
    with pytest.raises(OutputError, match=r"cannot be read as a font .* install the extra"):
        math_font("x", tmp_path / "none.ttf")
    found = importlib.util.find_spec("matplotlib")
    other = Path(found.submodule_search_locations[0]) / "mpl-data" / "fonts" / "ttf" / "STIXGeneral.ttf"
    with pytest.raises(OutputError, match="has no table for mathematics"):
        math_font("x", other)
    with pytest.raises(OutputError, match="has no 漢"):
        math_font("x漢")
