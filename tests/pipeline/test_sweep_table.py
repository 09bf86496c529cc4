"""The table of a sweep is the same for the same weaves, and no name breaks it."""

import csv

from geoweave.pipeline.sweep_table import COLUMNS, TABLES, Row, table_texts


def test_tables_hold_no_times_and_break_on_nothing() -> None:
    rows = [Row("a|b.obj", "a|b", "failed", 'a|b.obj: "odd", it\'s | so')]
    texts = table_texts(rows)
    assert tuple(texts) == TABLES
    (line,) = csv.DictReader(texts["table.csv"].splitlines())
    assert line["problem"] == rows[0].problem
    assert list(line) == ["mesh", "folder", *COLUMNS, "problem"]
    assert not any("second" in column for column in line)
    lines = texts["table.md"].splitlines()
    assert len({each.replace("\\|", "").count("|") for each in lines}) == 1
