"""three.js for ``guide.html``, from the viewer that comes with trimesh; nothing of it is kept here.

DEVIATIONS.md compares it with plotly, k3d and others. trimesh 4.9 was the first with release 140.
"""

from __future__ import annotations

import importlib.util
import re
import zipfile
from pathlib import Path
from typing import NamedTuple

from geoweave.files import OutputError

__all__ = ["Library", "three_js"]

OLDEST = 140
"""Release of three.js that the page is written for."""


class Library(NamedTuple):
    """The source of three.js."""

    release: int
    source: str
    licence: str
    """Its text, MIT."""


def three_js(archive: Path | None = None) -> Library:
    """Read three.js from the page of trimesh's viewer.

    Parameters
    ----------
    archive : the zip file with that page; by default that of the trimesh that is installed

    Raises
    ------
    OutputError
        If it is not there, or not as expected.
    """
    place = archive or _archive()
    try:
        with zipfile.ZipFile(place) as file:
            page = file.read("viewer.html.template").decode("utf-8")
    except (OSError, KeyError, ValueError, zipfile.BadZipFile) as error:
        raise OutputError(f"{place}: holds no viewer ({error}); {_REMEDY}") from error
    start = page.find("/**\n * @license\n")
    found = re.compile(r'Object\.defineProperty\(\w+,"__esModule",\{value:!0\}\)\}\)\)?\);?').search(
        page, start
    )
    source = page[start : found.end()] if start >= 0 and found else ""
    release = re.search(r'const e="(\d+)"', source)
    holders = re.search(r"Copyright (.+)", source)
    if release is None or holders is None or "</script" in source or int(release[1]) < OLDEST:
        raise OutputError(f"{place}: holds no three.js of release {OLDEST} or newer; {_REMEDY}")
    return Library(int(release[1]), source, f"The MIT License\n\nCopyright (c) {holders[1]}\n\n{_MIT}")


def _archive() -> Path:
    found = importlib.util.find_spec("trimesh")
    if found is None or not found.submodule_search_locations:
        raise OutputError(f"trimesh is not installed; {_REMEDY}")
    return Path(found.submodule_search_locations[0]) / "resources" / "templates" / "viewer.zip"


_REMEDY = "install trimesh 5.2 ('pip install trimesh==5.2.0') or leave the format 'guide' out"

_MIT = """\
Permission is hereby granted, free of charge, to any person obtaining a copy of this software and
associated documentation files (the "Software"), to deal in the Software without restriction,
including without limitation the rights to use, copy, modify, merge, publish, distribute,
sublicense, and/or sell copies of the Software, and to permit persons to whom the Software is
furnished to do so, subject to the following conditions:

The above copyright notice and this permission notice shall be included in all copies or
substantial portions of the Software.

THE SOFTWARE IS PROVIDED "AS IS", WITHOUT WARRANTY OF ANY KIND, EXPRESS OR IMPLIED, INCLUDING BUT
NOT LIMITED TO THE WARRANTIES OF MERCHANTABILITY, FITNESS FOR A PARTICULAR PURPOSE AND
NONINFRINGEMENT. IN NO EVENT SHALL THE AUTHORS OR COPYRIGHT HOLDERS BE LIABLE FOR ANY CLAIM,
DAMAGES OR OTHER LIABILITY, WHETHER IN AN ACTION OF CONTRACT, TORT OR OTHERWISE, ARISING FROM, OUT
OF OR IN CONNECTION WITH THE SOFTWARE OR THE USE OR OTHER DEALINGS IN THE SOFTWARE.
"""
