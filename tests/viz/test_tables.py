"""Tables as a notebook shows them."""

from __future__ import annotations

import numpy as np
import pandas as pd

from geoweave.viz.tables import whole


def test_every_cell_is_there_in_words() -> None:
    table = pd.DataFrame(
        {"what": ["a <b>", "c"], "count": [1234, 2], "share": [0.123456, np.nan], "fits": [True, False]}
    )
    shown = whole(table)
    assert shown.head == ["what", "count", "share", "fits"]
    assert shown.rows == [["a <b>", "1,234", "0.123", "yes"], ["c", "2", "", "no"]]
    page = shown._repr_html_()
    assert "<td>a &lt;b&gt;</td>" in page
    assert page.count("<tr>") == 3


def test_an_index_with_a_name_is_a_column() -> None:
    table = pd.DataFrame({"x": [1e-6, 12345.6]}, index=pd.Index(["p", "q"], name="model"))
    assert whole(table).head == ["model", "x"]
    assert whole(table).rows == [["p", "1e-06"], ["q", "12,346"]]
