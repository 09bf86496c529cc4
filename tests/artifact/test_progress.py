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


def test_no_silence_is_longer_than_ten_seconds() -> None:
    now = [0.0]
    written = io.StringIO()
    console = Console(file=written, force_terminal=False, width=60)
    with Progress(2, console, clock=lambda: now[0]) as progress:
        progress.start("fig08_gallery", 5)
        now[0] = 4.0
        progress.start("table1", 7)
        for second in range(5, 31):
            now[0] = float(second)
            progress.advance("fig08_gallery", min(second // 6, 4))
            progress.advance("table1", 0)
    lines = written.getvalue().splitlines()
    assert lines == [
        "  running: fig08_gallery (1 of 5 cells, 10 s), table1 (0 of 7 cells, 6 s)",
        "  running: fig08_gallery (3 of 5 cells, 20 s), table1 (0 of 7 cells, 16 s)",
        "  running: fig08_gallery (4 of 5 cells, 30 s), table1 (0 of 7 cells, 26 s)",
    ]


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
