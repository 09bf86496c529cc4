"""The research object names every notebook and figure there is, and where each came from."""

from __future__ import annotations

import json
from pathlib import Path

from geoweave.artifact import crate, notebooks

ROOT = Path(__file__).resolve().parents[2]
GRAPH = {entity["@id"]: entity for entity in crate.crate(ROOT)["@graph"]}


def references(value: object) -> list[str]:
    """Every {"@id": ...} within a value that holds nothing else."""
    if isinstance(value, dict):
        if set(value) == {"@id"}:
            return [value["@id"]]
        return [each for part in value.values() for each in references(part)]
    if isinstance(value, list):
        return [each for part in value for each in references(part)]
    return []


def test_the_file_is_up_to_date() -> None:
    assert (ROOT / crate.FILE).read_text(encoding="utf-8") == crate.text(ROOT), "run: make figures"


def test_every_figure_is_the_result_of_one_action() -> None:
    actions = [entity for entity in GRAPH.values() if entity["@type"] == "CreateAction"]
    made = [each["@id"] for action in actions for each in action["result"]]
    there = [
        path.relative_to(ROOT).as_posix()
        for path in (ROOT / "figures").rglob("*")
        if path.suffix[1:] in crate.KINDS
    ]
    assert sorted(made) == sorted(there)
    for action in actions:
        assert action["instrument"]["@id"] in GRAPH
        assert {"@id": "geoweave/"} in action["object"]


def test_every_file_exists_and_every_reference_leads_somewhere() -> None:
    for entity in GRAPH.values():
        for target in references({key: value for key, value in entity.items() if key != "@id"}):
            assert target in GRAPH or target.startswith("https://w3id.org/ro/crate/"), target
        if "File" in entity["@type"]:
            assert (ROOT / entity["@id"]).is_file(), entity["@id"]


def test_it_has_what_the_specification_asks_of_a_crate() -> None:
    """RO-Crate 1.1, sections "Root Data Entity" and "Metadata File Descriptor"."""
    document = json.loads(crate.text(ROOT))
    assert document["@context"] == crate.CONTEXT
    assert len(document["@graph"]) == len(GRAPH)
    descriptor, whole = GRAPH[crate.FILE], GRAPH["./"]
    assert descriptor["about"] == {"@id": "./"}
    assert descriptor["conformsTo"] == {"@id": "https://w3id.org/ro/crate/1.1"}
    for key in ("name", "description", "datePublished", "license"):
        assert whole[key], key
    parts = references(whole["hasPart"])
    assert {f"notebooks/{name}.ipynb" for name in notebooks.names(ROOT)} <= set(parts)
    files = {key for key, entity in GRAPH.items() if "File" in entity["@type"]}
    assert files <= set(parts)
