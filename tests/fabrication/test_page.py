"""A page is put together from its parts, and from nothing else."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from geoweave.errors import FieldError
from geoweave.fabrication import page


def test_what_is_put_in_is_not_looked_through_for_the_next_place() -> None:
    text = page.page_of(
        "a @STYLE@ & b", "viewer.html", "viewer.css", ("space.js",), {"said": "</script>@LIBRARY@"}
    )
    assert "<title>a @STYLE@ &amp; b: the weave</title>" in text
    assert '{"said":"<\\/script>@LIBRARY@"}' in text
    assert text.count("class WeaveInSpace") == 1


def test_a_template_that_lacks_a_place_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "fabrication").mkdir()
    for name in ("bare.html", "bare.css"):
        (tmp_path / "fabrication" / name).write_text("<title>@TITLE@</title>", encoding="utf-8")
    monkeypatch.setattr(page, "PACKAGE", tmp_path)
    with pytest.raises(FieldError, match=r"bare.html: .* no place for LICENCE; install geoweave anew"):
        page.page_of("x", "bare.html", "bare.css", (), {})


def test_every_script_is_of_a_page() -> None:
    """No file of a page lies about that no page uses."""
    from geoweave.fabrication import guide_page, viewer_page

    used = {*guide_page.SCRIPTS, *viewer_page.SCRIPTS}
    assert used == {each.name for each in (page.PACKAGE / "fabrication").glob("*.js")}
    for name in used:
        text = (page.PACKAGE / "fabrication" / name).read_text(encoding="utf-8")
        assert '"use strict";' in text
        assert not re.search(r"https?://(?!www\.w3\.org/)", text)
