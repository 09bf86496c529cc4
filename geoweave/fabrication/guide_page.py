"""``guide.html``: how to weave the object, strip by strip and crossing by crossing (Section 5.4).

One page that needs nothing but itself. It shows the weave in space, the strip in hand as it was cut, and one
thing to do at a time, in the order of `assembly_order`; it remembers where the maker was.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from typing import Any

from geoweave.fabrication.assembly_order import Step
from geoweave.fabrication.assembly_zones import zoned_assembly
from geoweave.fabrication.colours import Colours
from geoweave.fabrication.flattening import WeaveLike, weave_document
from geoweave.fabrication.guide_payload import drawings, shape
from geoweave.fabrication.marks import MARKS, outline
from geoweave.fabrication.page import page_of
from geoweave.fabrication.pattern import Pattern
from geoweave.fabrication.pieces import Making
from geoweave.fabrication.up_axes import AXES, up_axis

__all__ = ["guide_content", "guide_html"]

SCRIPTS = ("guide_steps.js", "space.js", "guide_strip.js", "guide_map.js", "guide_space.js", "guide.js")
"""What drives the page."""

SPOKEN = {"half": "half disc"}
"""Marks whose names say too little in a sentence."""


def guide_html(
    pattern: Pattern,
    weave: WeaveLike,
    making: Making | None = None,
    title: str = "weave",
    colours: Colours | None = None,
    order: tuple[Step, ...] | None = None,
    found: tuple[str, ...] = (),
    up: str | None = None,
) -> str:
    """The text of the page; same pattern and weave, same text.

    Parameters
    ----------
    pattern : the strips
    weave : the weave that the pattern is of, as it will stand, or the contents of its ``weave.json`` or
        ``relaxed.json``
    making : what is added to the strips
    title : of the page
    colours : of the families
    order : of assembly
    found : for each strip where its pieces are, in words
    up : the axis of the weave that is up; found if not given (`up_axis`)

    Raises
    ------
    FieldError
        If the weave is not that of the pattern.
    OutputError
        If three.js is not to be had.
    """
    document = weave_document(weave)
    content = guide_content(
        pattern,
        document,
        making or Making(),
        title,
        colours or Colours("paper"),
        order or zoned_assembly(pattern, document),
        found,
        up_axis(document, up),
    )
    return page_of(title, "guide.html", "guide.css", SCRIPTS, content)


def guide_content(
    pattern: Pattern,
    document: Mapping[str, Any],
    making: Making,
    title: str,
    colours: Colours,
    order: tuple[Step, ...],
    found: tuple[str, ...] = (),
    up: str = AXES[0],
) -> dict[str, Any]:
    """What the page knows of the weave, without text and looks."""
    bodies = shape(document, [each.label for each in pattern.strips])
    plain = {"pattern": pattern.document(), "making": vars(making), "order": order}
    key = hashlib.sha256(json.dumps(plain, separators=(",", ":"), allow_nan=False).encode()).hexdigest()
    return {
        "title": title,
        "key": key[:16],
        "up": AXES.index(up),
        "width": round(float(document["width"]), 4),
        "thickness": round(float(document["thickness"]), 4),
        "overlap": making.overlap,
        "families": list(colours.families),
        "marks": [
            {"name": SPOKEN.get(name, name), "outline": outline(k).round(3).tolist()}
            for k, name in enumerate(MARKS)
        ],
        "strips": [[each.label, each.family, each.closed, round(each.length, 3)] for each in pattern.strips],
        # For each crossing: strips, places on them, angle, which is over, mark, round.
        "crossings": [
            [
                *pattern.ribbons[x].tolist(),
                *(round(each, 3) for each in pattern.at[x].tolist()),
                round(float(pattern.angle[x]), 2),
                int(pattern.over[x]),
                int(pattern.mark[x]),
                int(pattern.round[x]),
            ]
            for x in range(len(pattern.ribbons))
        ],
        # Crossings that friction does not hold, as far as the forces at rest are known.
        "fasten": [x for x, each in enumerate(document["crossings"]) if each.get("fasten")],
        "order": [[step.strip, int(step.backbone), list(step.crossings), step.zone] for step in order],
        "drawings": drawings(pattern, making, colours),
        "shape": bodies,
        "found": list(found),
    }
