"""The order of the tests: what takes long comes first, so that processes side by side end together."""

from __future__ import annotations

from pathlib import Path

import pytest

from geoweave.artifact import notebooks

ROOT = Path(__file__).resolve().parents[1]


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Notebooks first, the longest of them at the head; then modules as they were collected."""
    taken = notebooks.times(ROOT)

    def seconds(item: pytest.Item) -> float:
        file = Path(item.nodeid.split("::")[0])
        if file.suffix != ".ipynb":
            return 0.0
        return float(taken.get((file.stem, "default"), ("inf", ""))[0])

    items.sort(key=seconds, reverse=True)
