"""Files that say what singularities a RoSy has and what a family follows."""

from __future__ import annotations

import pytest

from geoweave.errors import FieldError
from geoweave.weave.steering import Singularity
from geoweave.weave.steering_files import read_guide, read_singularities


def test_a_file_is_read_with_blanks_commas_comments_and_names(tmp_path):
    file = tmp_path / "points.csv"
    file.write_text(
        "\ufeffx,y,z,index\n# the poles\n0, 0, 1, 6\n\n0\t0 -1e0 6.0  # south\n", encoding="utf-8"
    )
    assert read_singularities(file) == (Singularity((0, 0, 1), 6), Singularity((0, 0, -1), 6))


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("0 0 1\n", "line 1 has 3 numbers, not the four of a singularity: x y z index"),
        ("0 0 1 6\n\n0 0 one 6\n", "line 3: 'one' is not a finite number"),
        ("0 0 nan 6\n", "line 1: 'nan' is not a finite number"),
        ("0 0 1 0.5\n", "line 1: the index is 0.5; give a whole number"),
        ("# nothing\n", "holds no singularity"),
        ("0 0 1 6\nx y z index\n", "line 2: 'x' is not a finite number"),
    ],
)
def test_a_bad_file_is_refused_with_its_name_and_line(tmp_path, text, said):
    file = tmp_path / "points.txt"
    file.write_text(text)
    with pytest.raises(FieldError, match=r"points\.txt") as refusal:
        read_singularities(file)
    assert said in str(refusal.value)


def test_what_is_no_file_of_text_is_refused(tmp_path):
    with pytest.raises(FieldError, match=r"none.txt cannot be read: No such file"):
        read_singularities(tmp_path / "none.txt")
    (tmp_path / "photo.jpg").write_bytes(b"\xff\xd8\xff\xe0\x00\x10")
    with pytest.raises(FieldError, match=r"photo.jpg is no file of text"):
        read_singularities(tmp_path / "photo.jpg")


def test_a_direction_and_a_curve_are_read_or_refused(tmp_path):
    file = tmp_path / "guide.txt"
    file.write_text("x,y,z\n0,0,2 # up\n")
    assert read_guide(file) == ((0, 0, 2),)
    file.write_text("0 0 1\n\n1 0 1\n1 1 1\n")
    assert read_guide(file) == ((0, 0, 1), (1, 0, 1), (1, 1, 1))
    for text, said in (
        ("0 0 1 6\n", "line 1 has 4 numbers, not the three of a point"),
        ("0 0 1\n0 up 1\n", "line 2: 'up' is not a finite number"),
        ("", "holds no point"),
        ("0 0 0\n", "has no length"),
        ("1 2 3\n1 2 3\n", "has no length"),
    ):
        file.write_text(text)
        with pytest.raises(FieldError, match=r"guide\.txt") as refusal:
            read_guide(file)
        assert said in str(refusal.value)
