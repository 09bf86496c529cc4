"""The numbers of a layout: sheets, pages, how full they are, the smallest text, what it takes to make it."""

from __future__ import annotations

import math
from typing import Any

from geoweave.fabrication.nesting import used_share
from geoweave.fabrication.pdf import FOOT, MARGIN
from geoweave.fabrication.strip_layout import StripLayout

__all__ = ["layout_numbers"]


def layout_numbers(laid: StripLayout) -> dict[str, Any]:
    """What a report says of strips on sheets and pages; lengths in mm.

    Returns
    -------
    dict
        ``sheets`` and ``sheet_size`` where there are sheets, ``pages`` by paper, ``used_share`` of both by
        name (the last one counted down to its lowest strip), ``strips``, ``pieces``, ``smallest_text_mm``
        (None where nothing is written), ``in_key`` (crossings that only the key names), ``unmarked`` (those
        without even a mark), ``fasten``, and the ``bill`` (`Bill`).

    Examples
    --------
    >>> weave = gw.weave_pattern(gw.shapes.cone(faces=400), ribbons=6).sized(size=100.0)
    >>> numbers = gw.fabrication.layout_numbers(gw.fabrication.layout(weave))
    >>> numbers["sheets"], numbers["smallest_text_mm"] >= 1.8
    (1, True)
    """
    pattern, bench = laid.pattern, laid.bench
    bill = laid.bill
    smallest = min((each.smallest for each in laid.drawings), default=math.inf)
    shares: dict[str, float] = {}
    sheets = laid.sheets if "sheet" in laid.media else ()
    if sheets:
        shares["sheet"] = used_share(sheets)
    pages = {name: laid.pages(name) for name in laid.media if name in bench.papers}
    for name, found in pages.items():
        shares[name] = used_share(found, (2 * MARGIN, 2 * MARGIN + FOOT))
    return {
        "sheets": len(sheets),
        "sheet_size": [round(sheets[0].width, 4), round(sheets[0].height, 4)] if sheets else None,
        "pages": {name: len(found) for name, found in pages.items()},
        "used_share": {name: round(share, 4) for name, share in shares.items()},
        "strips": len(pattern.strips),
        "pieces": len(laid.drawings),
        "width": pattern.width,
        "thickness": pattern.thickness,
        "smallest_text_mm": None if math.isinf(smallest) else round(smallest, 4),
        "in_key": sum(len(each.key) for each in laid.drawings),
        "unmarked": sum(not line.marked for each in laid.drawings for line in each.key),
        "fasten": bill.fasten,
        "bill": bill.document(),
    }
