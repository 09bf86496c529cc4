"""``viewer.html``: the weave to be turned and looked at, as designed and at rest, and to be changed.

One page that needs nothing but itself. It names ribbons and crossings, colours them by what matters to a
maker, lists the hard places, and writes the changes that a person makes to ``edits.json``.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from geoweave.errors import FieldError
from geoweave.fabrication.colours import Colours
from geoweave.fabrication.flattening import WeaveLike, weave_document
from geoweave.fabrication.page import page_of
from geoweave.fabrication.up_axes import up_axis
from geoweave.fabrication.viewer_payload import viewer_content

__all__ = ["viewer_html"]

SCRIPTS = ("space.js", "viewer_edits.js", "viewer_space.js", "viewer.js")
"""What drives the page."""


def viewer_html(
    weave: WeaveLike,
    rest: WeaveLike | None = None,
    report: Mapping[str, Any] | None = None,
    title: str = "weave",
    colours: Colours | None = None,
    up: str | None = None,
) -> str:
    """The text of the page; same weave, same text.

    Parameters
    ----------
    weave : as designed, or the contents of its ``weave.json``
    rest : the same weave at rest, or the contents of its ``relaxed.json``
    report : the contents of ``report.json``, for the hard places and the verdict
    title : of the page
    colours : of the families
    up : the axis of the weave that is up; found if not given (`up_axis`)

    Raises
    ------
    FieldError
        If the weave at rest has other ribbons than the weave.
    OutputError
        If three.js is not to be had.

    Examples
    --------
    >>> weave = gw.weave_pattern(gw.shapes.cone(faces=400), ribbons=6)
    >>> page = gw.fabrication.viewer_html(weave, title="a cone")
    >>> "<title>a cone: the weave</title>" in page, "http-equiv=\\"Content-Security-Policy\\"" in page
    (True, True)
    """
    design = weave_document(weave)
    lies = None if rest is None else weave_document(rest, "relaxed.json")
    if lies is not None and [r["label"] for r in lies["ribbons"]] != [r["label"] for r in design["ribbons"]]:
        raise FieldError(
            "relaxed.json has other ribbons than weave.json; weave it again with 'geoweave weave'"
        )
    stands = up_axis(design, up)
    content = viewer_content(design, lies, report or {}, title, colours or Colours("paper"), stands)
    return page_of(title, "viewer.html", "viewer.css", SCRIPTS, content)
