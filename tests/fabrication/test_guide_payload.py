"""What the guide holds, read back number by number."""

from __future__ import annotations

import base64
from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest
from laidflat import NAMES, bow_tie, circles, cone, flat, pairs_often, patterns

from geoweave.errors import FieldError
from geoweave.fabrication.colours import Colours, ink
from geoweave.fabrication.glb import ribbon_bodies
from geoweave.fabrication.guide_payload import GRAIN, drawings, shape, varints
from geoweave.fabrication.pieces import Making, pieces_of
from geoweave.fabrication.strip_drawing import drawn

SOURCES = {
    "flat": flat,
    "circles": circles,
    "bow tie": bow_tie,
    "often": pairs_often,
    "cone": lambda: cone().document(),
}


def numbers(data: bytes) -> Iterator[int]:
    value = shift = 0
    for byte in data:
        value |= (byte & 127) << shift
        shift += 7
        if byte < 128:
            yield value
            value = shift = 0
    assert shift == 0


def test_whole_numbers_come_back() -> None:
    given = np.array([0, 1, 127, 128, 300, 16383, 16384, 2**28, 2**35 - 1])
    data = varints(given)
    assert list(numbers(data)) == given.tolist()
    assert [len(varints(np.array([n]))) for n in (0, 127, 128, 16383, 16384)] == [1, 1, 2, 2, 3]
    assert varints(np.array([], dtype=np.int64)) == b""
    for bad in (-1, 2**35):
        with pytest.raises(FieldError, match="whole numbers from 0"):
            varints(np.array([bad]))


@pytest.mark.parametrize("name", NAMES)
def test_drawings_are_those_of_the_cut_strips(name: str) -> None:
    pattern, making, colours = patterns()[name], Making(overlap=6.0, extra=3.0), Colours("paper")
    packed = drawings(pattern, making, colours)
    for piece, strip in zip(pieces_of(pattern, making), packed["strips"], strict=True):
        assert piece.total == 1
        assert strip["start"] == pytest.approx(piece.start, abs=1e-3)
        assert strip["length"] == pytest.approx(piece.length, abs=1e-3)
        feed = numbers(base64.b64decode(strip["data"]))
        at = np.zeros(2)
        for figure in drawn(pattern, piece, making).figures:
            look = ink(figure, colours)
            assert look is not None
            kind, crossing, closed, count = (next(feed) for _ in range(4))
            stroke, pen, fill = packed["inks"][kind]
            assert (stroke, fill) == (look.stroke, look.fill)
            assert pen == pytest.approx(look.width, abs=1e-3)
            assert (crossing - 1, closed, count) == (figure.crossing, figure.closed, len(figure.paths))
            for path in figure.paths:
                points = []
                for _ in range(next(feed)):
                    steps = [next(feed) for _ in range(2)]
                    at = at + [-(step + 1) // 2 if step % 2 else step // 2 for step in steps]
                    points.append(at * GRAIN)
                np.testing.assert_allclose(points, path, atol=0.5 * GRAIN + 1e-9)
        assert next(feed, None) is None


@pytest.mark.parametrize("name", NAMES)
def test_ribbons_in_space_come_back(name: str) -> None:
    document: dict[str, Any] = SOURCES[name]()
    labels = [each["label"] for each in document["ribbons"]]
    packed = shape(document, labels)

    def read(key: str, kind: str) -> np.ndarray:
        return np.frombuffer(base64.b64decode(packed[key]), dtype=kind).astype(float)

    places = np.array(packed["low"]) + packed["unit"] * read("places", "<u2").reshape(-1, 3)
    ups, along = read("ups", "<i2").reshape(-1, 3) / 32767, read("along", "<u2") / 65535
    extent = np.ptp(places, axis=0).max()
    first = 0
    found = ribbon_bodies(document)
    for body, count, length in zip(found, packed["counts"], packed["lengths"], strict=True):
        own = slice(first, first + count)
        first += count
        # Half a step of sixteen bits on each axis, and the rounding of the corner.
        np.testing.assert_allclose(places[own], body.centre, atol=0.5 * extent / 65535 + 1e-6)
        np.testing.assert_allclose(ups[own], body.up, atol=1e-4)
        np.testing.assert_allclose(along[own] * length, body.at, atol=length / 65535 + 1e-4)
    assert first == len(places)
    with pytest.raises(FieldError, match="other ribbons"):
        shape(document, labels[:-1])
