"""One line a notebook where there is no terminal; bars that do not run backwards where there is one."""

import io

from rich.console import Console

from geoweave.artifact.progress import Progress


def test_one_line_a_notebook_without_a_terminal() -> None:
    written = io.StringIO()
    with Progress(2, Console(file=written, force_terminal=False, width=60)) as progress:
        progress.start("fig08_gallery", 5)
        progress.advance("fig08_gallery", 3)
        progress.finish("fig08_gallery", "done in 3 s")
        progress.finish("table1", "failed: cell In[3]: AssertionError: [a] claim " + "x" * 60, failed=True)
    lines = written.getvalue().splitlines()
    assert lines[0] == "[1/2] fig08_gallery: done in 3 s"
    assert lines[1].startswith("[2/2] table1: failed: cell In[3]: AssertionError: [a] claim xxx")
    assert len(lines) == 2


def test_bars_on_a_terminal() -> None:
    written = io.StringIO()
    with Progress(1, Console(file=written, force_terminal=True, width=100)) as progress:
        progress.start("fig08_gallery", 5)
        progress.advance("fig08_gallery", 3)
        progress.advance("fig08_gallery", 0)
        progress._bars.refresh()
        assert "3/5 cells" in written.getvalue()
        progress.finish("fig08_gallery", "done in 3 s")
    assert "fig08_gallery: done in 3 s" in written.getvalue()
