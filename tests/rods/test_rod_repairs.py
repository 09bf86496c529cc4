"""Files that RibbonSim reads are read: leaning directors, short rods and trailing numbers are put right."""

import numpy as np
import pytest

from geoweave.errors import RodError
from geoweave.rods.rod_file import Rod, read_rods
from geoweave.rods.rod_repairs import squared

BAR = "2 0  0 0 0  1 0 0  0 0 1  0.1"


def test_leaning_directors_are_made_square():
    points = np.array([[0.0, 0, 0], [1, 0, 0], [2, 0, 0]])
    leaning = np.array([[0.3, 0, 2.0], [0, 0, 1.0]])
    found, changed = squared(points, leaning, closed=False)
    np.testing.assert_allclose(found, [[0, 0, 1], [0, 0, 1]], atol=1e-12)
    assert changed == 1
    # along the segment, or without length: nothing to make of it
    along, changed = squared(points, np.array([[1.0, 0, 0], [0, 0, 0]]), closed=False)
    assert changed == 0
    assert along.tolist() == [[1, 0, 0], [0, 0, 0]]
    with pytest.raises(RodError, match="director 0"):
        Rod(points, along, np.ones(2))


def test_a_leaning_file_is_read_with_a_sentence(tmp_path):
    path = tmp_path / "leaning.rod"
    lean = BAR.replace("0 0 1  0.1", "0.4 0.3 2  0.1")
    path.write_text(f"2 1 0.01 1e6 1\n{lean}\n{BAR}\n0 1 0 0 0.5 0.5 1\n7 7 7\n")
    content = read_rods(path)
    assert content.repairs == (
        "directors made unit vectors square to their segments: 1",
        "numbers after the last crossing, left out: 3",
    )
    np.testing.assert_allclose(content.rods[0].directors, [[0, 0.3, 2.0]] / np.hypot(0.3, 2.0))
    path.write_text(f"2 1 0.01 1e6 1\n{BAR}\n{BAR}\n0 1 0 0 0.5 0.5 1\n")
    assert read_rods(path).repairs == ()


def test_a_rod_of_one_vertex_is_left_out_with_its_crossings(tmp_path):
    path = tmp_path / "short.rod"
    path.write_text(f"3 2 0.01 1e6 1\n{BAR}\n1 0  0 0 0\n{BAR}\n0 1 0 0 0.5 0.5 1\n0 2 0 0 0.5 0.5 1\n")
    content = read_rods(path)
    assert len(content.rods) == 2
    assert [each.rods for each in content.crossings] == [(0, 1)]
    assert content.repairs == ("rods with too few vertices, left out: 1, with 1 of the crossings",)
