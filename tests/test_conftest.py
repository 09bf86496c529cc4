"""Long notebooks come first, so that no process of make test is left alone with one at the end."""

from __future__ import annotations

from types import SimpleNamespace

from conftest import ROOT, pytest_collection_modifyitems

from geoweave.artifact import notebooks


def test_notebooks_come_first_the_longest_at_the_head() -> None:
    names = notebooks.names(ROOT)
    found = [
        "tests/a.py::test_1",
        *(f"notebooks/{name}.ipynb::Cell 0" for name in names),
        "tests/b.py::test_1",
    ]
    items = [SimpleNamespace(nodeid=nodeid) for nodeid in found]
    pytest_collection_modifyitems(items)
    order = [item.nodeid for item in items]
    assert sorted(order) == sorted(found)
    assert order[-2:] == ["tests/a.py::test_1", "tests/b.py::test_1"]
    taken = notebooks.times(ROOT)
    known = [nodeid[10:].split(".")[0] for nodeid in order[:-2]]
    seconds = [float(taken[name, "default"][0]) for name in known if (name, "default") in taken]
    assert len(seconds) > 20
    assert seconds == sorted(seconds, reverse=True)
