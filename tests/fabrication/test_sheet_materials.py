from __future__ import annotations

import pytest

from geoweave.errors import FieldError
from geoweave.fabrication.presets import PRESETS
from geoweave.fabrication.sheet_materials import MATERIALS, material_of


def test_materials_are_in_the_order_that_hands_know() -> None:
    """Veneer along the grain is stiffer than paper, and paper than polypropylene; wood is lightest."""
    stiff = sorted(MATERIALS, key=lambda name: -MATERIALS[name].young)
    assert stiff == ["birch veneer", "vellum", "polypropylene"]
    assert min(MATERIALS, key=lambda name: MATERIALS[name].density) == "birch veneer"


@pytest.mark.parametrize("name", MATERIALS)
def test_numbers_are_those_of_sheets_that_are_sold(name: str) -> None:
    sheet = MATERIALS[name]
    assert sheet.thickness in {preset.thickness for preset in PRESETS.values()}
    assert sheet.density in {preset.density for preset in PRESETS.values()}
    assert 1000 < sheet.young < 20_000  # N/mm2: no sheet that a hand can weave is rubber or steel
    assert 0.2 <= sheet.friction <= 0.6
    assert len(sheet.source) > 40


def test_an_unknown_material_is_refused_with_those_there_are() -> None:
    with pytest.raises(FieldError, match="no material 'granite'; there are vellum"):
        material_of("granite")
