"""A font for the mathematics of the pages: browsers display MathML well only in a font made for it.

STIX Two Math (SIL Open Font License 1.1) is installed with ziamath (MIT). The pages embed only the characters
that they use, some fifty kilobytes. This repository does not contain the font.
"""

from __future__ import annotations

import html
import importlib.util
import io
import re
import unicodedata
from collections.abc import Iterable
from pathlib import Path

from fontTools import subset
from fontTools.ttLib import TTFont

from geoweave.files import OutputError

__all__ = ["NOTICE", "characters", "math_font"]

NOTICE = "STIX Two Math, (c) 2001-2020 The STIX Fonts Project Authors, SIL Open Font License 1.1"

ITALIC = {
    unicodedata.normalize("NFKC", chr(code)): chr(code)
    for code in range(0x1D400, 0x1D800)
    if re.match("MATHEMATICAL ITALIC (SMALL|CAPITAL)", unicodedata.name(chr(code), ""))
} | {"h": "\u210e"}
"""What a browser makes of a letter that stands for a quantity."""


def characters(pages: Iterable[str]) -> str:
    """All characters that the equations in pieces of HTML use, each once, in order."""
    found: set[str] = set()
    for page in pages:
        for equation in re.findall(r"<math.*?</math>", page, re.S):
            found |= set(html.unescape(re.sub(r"<[^>]*>", "", equation)))
    found |= {ITALIC[each] for each in found if each in ITALIC}
    return "".join(sorted(each for each in found if not each.isspace()))


def math_font(text: str, source: Path | None = None) -> bytes:
    """The font reduced to these characters and the parts of their large forms, as WOFF.

    Parameters
    ----------
    text : the characters
    source : the font as TrueType or OpenType; by default the one in the installed ziamath

    Raises
    ------
    OutputError
        If the font is missing, is no font for mathematics, or lacks some of the characters.
    """
    place = source or _installed()
    try:
        font = TTFont(place, recalcTimestamp=False)
    except Exception as error:  # fontTools raises many kinds of error on a damaged file
        raise OutputError(f"{place}: cannot be read as a font ({error}); {_REMEDY}") from error
    missing = sorted(each for each in text if ord(each) not in (font.getBestCmap() or {}))
    if "MATH" not in font or missing:
        raise OutputError(f"{place}: has no {' '.join(missing) or 'table for mathematics'}; {_REMEDY}")
    options = subset.Options(layout_features=["*"], hinting=False, notdef_outline=True)
    cut = subset.Subsetter(options)
    cut.populate(text=text)
    cut.subset(font)
    font.flavor = "woff"
    file = io.BytesIO()
    font.save(file)
    return file.getvalue()


def _installed() -> Path:
    found = importlib.util.find_spec("ziamath")
    if found is None or not found.submodule_search_locations:
        raise OutputError(f"ziamath, whose font sets the mathematics, is not installed; {_REMEDY}")
    return Path(found.submodule_search_locations[0]) / "fonts" / "STIXTwoMath-Regular.ttf"


_REMEDY = "install the extra 'notebooks' anew: pip install geoweave[notebooks]"
