"""What ``guide.html`` holds, small: strips and ribbons as whole numbers, written as base64 (Section 5.4).

Drawings are those of the cut strips, point by point: differences of points in steps of `GRAIN`, in seven bits
a byte. Ribbons in space are their cross sections; the page gives them width and thickness again.
"""

from __future__ import annotations

import base64
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from geoweave.arrays import Indices
from geoweave.errors import FieldError
from geoweave.fabrication.colours import Colours, Ink, ink
from geoweave.fabrication.flattening import WeaveLike, weave_document
from geoweave.fabrication.glb import ribbon_bodies
from geoweave.fabrication.pattern import Pattern
from geoweave.fabrication.pieces import Making, pieces_of
from geoweave.fabrication.strip_drawing import drawn
from geoweave.fabrication.strip_figures import Drawn

__all__ = ["GRAIN", "drawings", "shape", "varints"]

GRAIN = 0.02
"""Of the drawings, mm."""


def drawings(pattern: Pattern, making: Making, colours: Colours) -> dict[str, Any]:
    """The drawings of all strips, each in one piece, as they are cut; curved ones are drawn straight."""
    inks: dict[Ink, int] = {}
    strips = []
    for piece in pieces_of(pattern, making, whole=True):
        sheet = drawn(pattern, piece, making)
        numbers = _numbers(sheet, colours, inks)
        strips.append(
            {
                "start": round(piece.start, 4),
                "length": round(piece.length, 4),
                "extent": [round(each, 3) for each in sheet.extent],
                "data": _text(varints(numbers)),
            }
        )
    return {"grain": GRAIN, "inks": [list(look) for look in inks], "strips": strips}


def _numbers(sheet: Drawn, colours: Colours, inks: dict[Ink, int]) -> Indices:
    parts: list[NDArray[np.int64]] = []
    last = np.zeros(2, dtype=np.int64)
    for figure in sheet.figures:
        look = ink(figure, colours)
        if look is None:
            continue
        kind = inks.setdefault(look._replace(width=round(look.width, 3)), len(inks))
        parts.append(np.array([kind, figure.crossing + 1, int(figure.closed), len(figure.paths)]))
        for path in figure.paths:
            points = np.rint(path / GRAIN).astype(np.int64)
            steps = np.diff(points, axis=0, prepend=last[None])
            last = points[-1]
            # Small numbers of either sign to small positive ones.
            parts += [np.array([len(points)]), np.where(steps < 0, -2 * steps - 1, 2 * steps).ravel()]
    return np.concatenate(parts)


def varints(numbers: Indices) -> bytes:
    """Whole numbers, seven bits a byte, the lowest first; the eighth bit says that more follow (LEB128).

    Raises
    ------
    FieldError
        If one is negative or does not fit into five bytes.
    """
    if len(numbers) and not 0 <= int(numbers.min()) <= int(numbers.max()) < 1 << 35:
        raise FieldError("only whole numbers from 0 to 2^35 - 1 are written in seven bits a byte")
    bits = numbers[:, None] >> (7 * np.arange(5))
    more = np.concatenate([bits[:, 1:] > 0, np.zeros((len(bits), 1), dtype=bool)], axis=1)
    wanted = np.concatenate([np.ones((len(bits), 1), dtype=bool), bits[:, 1:] > 0], axis=1)
    return ((bits & 127) | (more.astype(np.int64) << 7))[wanted].astype(np.uint8).tobytes()


def shape(weave: WeaveLike, labels: Sequence[str]) -> dict[str, Any]:
    """The ribbons in space: places to 1/65535 of the largest extent, directions to 1/32767.

    The page gives the cross sections of `ribbon_bodies` their width and thickness again; ``shares`` says how
    much of the full width each has, to 1/255.

    Parameters
    ----------
    weave : a weave, or the contents of ``weave.json`` or ``relaxed.json``
    labels : of the strips of the pattern that the document must have

    Raises
    ------
    FieldError
        If the document is no weave, or that of another pattern.
    """
    document = weave_document(weave)
    if [each["label"] for each in document["ribbons"]] != list(labels):
        raise FieldError("the weave has other ribbons than the pattern; write both from the same weave")
    found = ribbon_bodies(document)
    points = np.concatenate([each.centre for each in found])
    low = points.min(axis=0)
    unit = float((points.max(axis=0) - low).max()) / 65535
    places = np.rint((points - low) / unit).astype("<u2")
    ups = np.rint(32767 * np.concatenate([each.up for each in found])).astype("<i2")
    shares = np.floor(255 * np.concatenate([each.share for each in found])).astype("u1")
    along = [np.rint(65535 * each.at / each.at[-1]).astype("<u2") for each in found]
    return {
        "low": [round(float(each), 6) for each in low],
        "unit": unit,
        "counts": [len(each.at) for each in found],
        "lengths": [round(float(each.at[-1]), 4) for each in found],
        "places": _text(places.tobytes()),
        "ups": _text(ups.tobytes()),
        "along": _text(np.concatenate(along).tobytes()),
        "shares": _text(shares.tobytes()),
    }


def _text(data: bytes) -> str:
    return base64.b64encode(data).decode("ascii")
