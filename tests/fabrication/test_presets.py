"""Presets hold numbers that go together, and say where they come from."""

from __future__ import annotations

import pytest

from geoweave.errors import FieldError
from geoweave.fabrication.pieces import Making
from geoweave.fabrication.presets import PRESETS, preset_of
from geoweave.fabrication.sheet_sizes import PAPERS, stock_of

NAMES = (
    "edge-banding",
    "bristol-a4",
    "veneer-laser",
    "polypropylene-laser",
    "cutting-mat",
    "plotter-roll",
)


def test_there_are_six() -> None:
    assert tuple(PRESETS) == NAMES


@pytest.mark.parametrize("name", NAMES)
def test_its_numbers_can_be_made(name: str) -> None:
    preset = preset_of(name)
    stock = stock_of(preset.sheet, preset.margin, preset.gap)
    assert stock.room > 3 * preset.overlap
    assert Making(preset.overlap, 0.0, preset.kerf, labels=preset.labels).kerf == preset.kerf
    assert 0.05 < preset.thickness < 2.0
    assert 0.3 < preset.density < 1.5
    assert set(preset.papers) <= set(PAPERS)
    assert preset.stock_length <= stock.room + 1e-9 or stock.roll or preset.sheet is None
    assert len(preset.source) > 30
    # lines of a laser nearer than half a millimetre burn what is between them
    assert preset.kerf == 0 or preset.gap >= 0.5 + preset.kerf


def test_another_name_is_refused() -> None:
    with pytest.raises(FieldError, match=", ".join(NAMES)):
        preset_of("granite")
