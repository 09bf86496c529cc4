"""The report in words: counts in the plural where that is due, and the notes after them."""

import numpy as np

from geoweave.meshing.report import RepairReport, place
from geoweave.wording import counted


def test_counts_become_sentences_and_notes_follow() -> None:
    report = RepairReport(welded_vertices=2, turned_faces=1, notes=("it holds more than it announces",))
    assert report.sentences() == [
        "welded 2 vertices to another at the same place",
        "turned 1 face over",
        "it holds more than it announces",
    ]
    assert report.as_dict()["welded_vertices"] == 2
    assert "notes" not in report.as_dict()


def test_a_clean_report_says_nothing() -> None:
    assert RepairReport().sentences() == []
    assert set(RepairReport().as_dict().values()) == {0}


def test_numbers_and_places_are_written_for_people() -> None:
    assert [counted(1, "vertex"), counted(2, "vertex"), counted(1_200, "edge")] == [
        "1 vertex",
        "2 vertices",
        "1,200 edges",
    ]
    assert place(np.array([[0, 0, 0], [1, 2, 0.5]])) == "(0.5, 1, 0.25)"
