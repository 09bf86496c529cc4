"""Pages that need nothing but themselves: a template, its style, three.js, scripts and what they show.

The guide and the viewer are put together here. The files lie beside this module.
"""

from __future__ import annotations

import html
import json
from collections.abc import Mapping, Sequence
from typing import Any

from geoweave.checkout import PACKAGE
from geoweave.errors import FieldError
from geoweave.fabrication.threejs import three_js

__all__ = ["page_of"]


def page_of(title: str, template: str, style: str, scripts: Sequence[str], content: Mapping[str, Any]) -> str:
    """The text of a page; same content, same text.

    Parameters
    ----------
    title : of the page
    template, style, scripts : names of the files that it is put together from
    content : what the scripts find in the element ``content``

    Raises
    ------
    OutputError
        If three.js is not to be had.
    FieldError
        If the template has no place for a part.
    """
    library = three_js()
    page = _read(template)
    # "</" would end the element that holds it.
    data = json.dumps(content, separators=(",", ":"), allow_nan=False).replace("</", "<\\/")
    parts = {
        "TITLE": html.escape(title),
        "LICENCE": f"three.js r{library.release}\n\n{library.licence}",
        "STYLE": _read(style),
        "CONTENT": data,
        "LIBRARY": library.source,
        "SCRIPT": "\n".join(_read(each) for each in scripts),
    }
    text = ""
    for name, value in parts.items():
        # What has been put in is not looked through for the next place.
        before, mark, page = page.partition(f"@{name}@")
        if not mark:
            raise FieldError(f"{template}: this template has no place for {name}; install geoweave anew")
        text += before + value
    return text + page


def _read(name: str) -> str:
    return (PACKAGE / "fabrication" / name).read_text(encoding="utf-8")
