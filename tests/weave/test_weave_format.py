"""What ``weave.json`` calls itself."""

from __future__ import annotations

import subprocess
import sys

import pytest

import geoweave as gw
from geoweave.errors import FieldError
from geoweave.weave.weave_format import WEAVE_FORMAT, WEAVE_VERSION


def test_the_file_says_it_and_others_are_refused() -> None:
    document = gw.weave_pattern(gw.shapes.cone(faces=400), ribbons=6).document()
    assert (document["format"], document["version"]) == (WEAVE_FORMAT, WEAVE_VERSION)
    for other in ({"format": "geoweave-design"}, {"version": WEAVE_VERSION + 1}):
        with pytest.raises(FieldError, match=f"is not a {WEAVE_FORMAT} of version {WEAVE_VERSION}"):
            gw.fabrication.pattern_of(document | other)


def test_who_reads_strips_needs_no_solver() -> None:
    """Drawing strips anew takes a second or two; loading SciPy would be a good part of it."""
    code = "import sys, geoweave.fabrication.strip_layout, geoweave.pipeline.cutting; print(*sys.modules)"
    loaded = subprocess.run([sys.executable, "-c", code], check=True, capture_output=True, text=True).stdout
    assert not {"scipy", "reportlab", "ezdxf", "numba"} & set(loaded.split())
