"""Whole tables under a figure, for reading; what a test compares is printed apart."""

from __future__ import annotations

from html import escape
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    import pandas as pd


class Table:
    """A table that a notebook shows as HTML, every column and row of it."""

    def __init__(self, head: list[str], rows: list[list[str]]) -> None:
        self.head = head
        self.rows = rows

    def _repr_html_(self) -> str:
        def line(cells: list[str], tag: str) -> str:
            return "<tr>" + "".join(f"<{tag}>{escape(cell)}</{tag}>" for cell in cells) + "</tr>"

        body = "\n".join(line(row, "td") for row in self.rows)
        return f"<table>\n<thead>{line(self.head, 'th')}</thead>\n<tbody>\n{body}\n</tbody>\n</table>"

    def __repr__(self) -> str:
        return "\n".join("  ".join(row) for row in [self.head, *self.rows])


def whole(table: pd.DataFrame, digits: int = 3) -> Table:
    """Show every column and row of a table, numbers with a few significant digits.

    Parameters
    ----------
    table : what to show; its index is left out unless it has a name
    digits : significant digits of numbers that are not whole; a missing value is an empty cell

    Examples
    --------
    >>> import pandas as pd
    >>> viz.whole(pd.DataFrame({"model": ["cone"], "distance": [0.123456], "paper": [np.nan]}))
    model  distance  paper
    cone  0.123
    """
    flat = table.reset_index() if any(table.index.names) else table
    rows = [[_words(value, digits) for value in row] for row in flat.itertuples(index=False, name=None)]
    return Table([str(name) for name in flat.columns], rows)


def _words(value: Any, digits: int) -> str:
    if isinstance(value, (bool, np.bool_)):
        return "yes" if value else "no"
    if isinstance(value, (float, np.floating)):
        if np.isnan(value):
            return ""
        if value == round(value) or abs(value) >= 10**digits:
            return f"{value:,.0f}"
        return f"{value:.{digits}g}"
    if isinstance(value, (int, np.integer)):
        return f"{value:,}"
    return str(value)
