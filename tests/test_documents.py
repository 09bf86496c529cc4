"""Documents are refused whole, with the place and the remedy, whatever stands in them."""

from __future__ import annotations

import copy
import json
import random
from pathlib import Path
from typing import Any

import laidflat
import pytest

from geoweave.documents import each, entries, flag, number, points, read_json, text, whole
from geoweave.errors import FieldError, GeoweaveError
from geoweave.fabrication import Pattern, pattern_of
from geoweave.models import shapes
from geoweave.rods.weave_file import read_weave, rods_of_document
from geoweave.weave.design import weave_pattern

STRANGE = (None, True, -1, 0, 10**6, 10**300, 1e-300, 1e300, *map(float, ("nan", "inf")), "x", [], {}, [[]])


def test_the_whole_file_is_json_of_finite_numbers(tmp_path: Path) -> None:
    path = tmp_path / "a.json"
    for words, problem in (
        ("{", "is not JSON"),
        ("[1]", "is no JSON object"),
        ('{"a": NaN}', "the number NaN is not finite"),
        ('{"a": -Infinity}', "the number -Infinity is not finite"),
        ('{"a": 1e999}', "the number 1e999 is not finite"),
        ('{"a": ' + "1" * 5000 + "}", "the number 11111111111111111... is not finite or too large"),
        ('{"a": ' + "[" * 100_000 + "]" * 100_000 + "}", "nested too deeply"),
        ('{"a": "\xff"}', r"is not text \(byte 7\)"),
    ):
        path.write_bytes(words.encode("latin-1"))
        with pytest.raises(FieldError, match=problem) as caught:
            read_json(path, FieldError, "write it again")
        assert str(caught.value).startswith("a.json: ")
        assert str(caught.value).endswith("write it again")
    path.write_text('\ufeff{"a": [1, 2.5]}', encoding="utf-8")
    assert read_json(path, FieldError, "") == {"a": [1, 2.5]}


def test_shapes_name_the_place() -> None:
    shape = entries(
        name=text("a", "b"), closed=flag(), lines=each(entries(size=number(above=0), line=points(2)))
    )
    good: dict[str, Any] = {
        "name": "a",
        "closed": True,
        "lines": [{"size": 1, "line": [[0, 0, 0], [1, 0, 0]]}],
    }
    shape(good, "")
    for change, words in (
        ({"name": "c"}, 'name is "c", not one of a, b'),
        ({"closed": 1}, "closed is 1, not true or false"),
        ({"lines": {}}, "lines is an object of 0, not a list"),
        ({"lines": [{"size": 0}]}, r"lines\[0\].size is 0, not a finite number above 0"),
        ({"lines": [{"size": 1}]}, r"lines\[0\].line is missing"),
        ({"lines": [{"size": 1, "line": [[0, 0]]}]}, r"lines\[0\].line is not a list of 2 or more points"),
    ):
        with pytest.raises(ValueError, match=words):
            shape(good | change, "")
    for value in (-1, 3, 1.0, True, "1"):
        with pytest.raises(ValueError, match="not a whole number from 0 to 2"):
            whole(most=2)(value, "x")


def places(value: Any, at: tuple[Any, ...] = ()) -> list[tuple[Any, ...]]:
    """Every place in a document, from its root."""
    inside = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    return [at, *(place for key, each in inside for place in places(each, (*at, key)))]


def mutated(document: dict[str, Any], rng: random.Random, among: list[tuple[Any, ...]]) -> Any:
    """A document with one entry gone or replaced by something strange."""
    new = copy.deepcopy(document)
    *way, last = rng.choice(among[1:])
    holder: Any = new
    for key in way:
        holder = holder[key]
    if rng.random() < 0.2:
        del holder[last]
    else:
        holder[last] = rng.choice(STRANGE)
    return new


@pytest.mark.parametrize("kind", ["weave", "pattern"])
def test_mutated_documents_are_read_or_refused_in_one_sentence(kind: str, tmp_path: Path) -> None:
    """A seeded fuzz: nothing but a sentence that begins with the file's name may come out."""
    if kind == "weave":
        document = weave_pattern(shapes.cone(faces=400), ribbons=8).sized(100.0).document()
    else:
        document = pattern_of(laidflat.flat()).document()
    rng, path = random.Random(13), tmp_path / f"{kind}.json"
    among = [place for place in places(document) if not {"points", "normals"} & {*place[:-1]}]
    refusals = [refusal(kind, path, mutated(document, rng, among)) for _ in range(150)]
    refused = [words for words in refusals if words]
    assert len(refused) > 50
    for words in refused:
        assert words.startswith(path.name)
        assert "\n" not in words


def refusal(kind: str, path: Path, document: Any) -> str:
    """What is said of a document; nothing if it can be read."""
    path.write_text(json.dumps(document))
    try:
        if kind == "weave":
            rods_of_document(read_weave(path), path.name)
        else:
            Pattern.from_document(read_json(path, FieldError, "write it again"), path.name)
    except GeoweaveError as error:
        return str(error)
    return ""
