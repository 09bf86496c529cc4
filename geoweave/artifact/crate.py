"""The checkout as a research object: ``ro-crate-metadata.json`` (RO-Crate 1.1).

For every notebook and profile there is one action. The notebook is its instrument, the surfaces are its
objects, and the pictures, tables and records under ``figures/`` are its results. All of it is read from the
checkout, so the file says the same on every machine.
"""

from __future__ import annotations

import json
import re
import tomllib
from pathlib import Path
from typing import Any

from geoweave.artifact import notebooks
from geoweave.models import datasets
from geoweave.wording import counted

FILE = "ro-crate-metadata.json"
CONTEXT = "https://w3id.org/ro/crate/1.1/context"
PAPER = "https://doi.org/10.1145/3306346.3323043"
AUTHORS = ("Josh Vekhter", "Jiacheng Zhuo", "Luisa F. Gil Fandino", "Qixing Huang", "Etienne Vouga")
"""Of the paper."""

LICENCES = {"MIT": "https://spdx.org/licenses/MIT", "CC-BY-4.0": "https://spdx.org/licenses/CC-BY-4.0"}
KINDS = {"png": "image/png", "csv": "text/csv", "json": "application/json"}
"""What a figure consists of, by ending, as media types."""

__all__ = ["FILE", "crate", "text"]

Entity = dict[str, Any]


def crate(root: Path) -> Entity:
    """The research object of a checkout as plain values, ready for json.

    Parameters
    ----------
    root : the checkout; figures that are not there are left out

    Returns
    -------
    A JSON-LD document: ``@context``, and ``@graph`` with the root data set first after its descriptor.
    """
    project = tomllib.loads((root / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    files: list[Entity] = []
    actions: list[Entity] = []
    surfaces: dict[str, Entity] = {}
    for name in notebooks.names(root):
        notebook = notebooks.read(notebooks.path_of(root, name))
        title = notebooks.heading(notebook)
        files.append(_notebook(name, title))
        for profile in notebooks.PROFILES:
            results, records = _figures(root, notebooks.published(notebook), profile)
            if results:
                files += results
                surfaces |= {each["@id"]: each for record in records for each in _surfaces(record)}
                actions.append(_action(name, title, profile, results, records))
    scans = [_scan(name) for name in datasets.names() if datasets.dataset(name).embedded]
    parts = [{"@id": each["@id"]} for each in (*files, *scans)]
    whole = {
        "@id": "./",
        "@type": "Dataset",
        "name": "geoweave: Weaving Geodesic Foliations, reproducible",
        "description": project["description"],
        "datePublished": _published(root),
        "version": project["version"],
        "license": [{"@id": LICENCES["MIT"]}, {"@id": LICENCES["CC-BY-4.0"]}],
        "keywords": ", ".join(project["keywords"]),
        "isBasedOn": {"@id": PAPER},
        "hasPart": [{"@id": "geoweave/"}, *parts],
        "mentions": [{"@id": each["@id"]} for each in actions],
    }
    graph = [_descriptor(), whole, *_fixed(project["version"]), *scans, *files, *surfaces.values(), *actions]
    return {"@context": CONTEXT, "@graph": graph}


def text(root: Path) -> str:
    """The same as the text of the file."""
    return json.dumps(crate(root), indent=1, ensure_ascii=False) + "\n"


def _descriptor() -> Entity:
    return {
        "@id": FILE,
        "@type": "CreativeWork",
        "conformsTo": {"@id": "https://w3id.org/ro/crate/1.1"},
        "about": {"@id": "./"},
    }


def _published(root: Path) -> str:
    """The year of the licence: a crate must have a date, and nothing here changes from day to day."""
    page = root / "LICENSE"
    years = re.findall(r"Copyright \(c\) (\d{4})", page.read_text(encoding="utf-8")) if page.is_file() else []
    return years[0] if years else ""


def _fixed(version: str) -> list[Entity]:
    """What does not depend on the figures: the package, the paper and its authors, the licences."""
    people = [{"@id": f"#{name.replace(' ', '-')}", "@type": "Person", "name": name} for name in AUTHORS]
    names = {"MIT": "MIT License", "CC-BY-4.0": "Creative Commons Attribution 4.0 International"}
    licences = [{"@id": LICENCES[key], "@type": "CreativeWork", "name": name} for key, name in names.items()]
    paper = {
        "@id": PAPER,
        "@type": "ScholarlyArticle",
        "name": "Weaving Geodesic Foliations",
        "author": [{"@id": each["@id"]} for each in people],
        "isPartOf": "ACM Transactions on Graphics 38(4), article 34",
        "datePublished": "2019-07",
    }
    package = {
        "@id": "geoweave/",
        "@type": ["Dataset", "SoftwareSourceCode"],
        "name": "geoweave",
        "version": version,
        "programmingLanguage": "Python",
        "license": {"@id": LICENCES["MIT"]},
    }
    return [package, paper, *people, *licences]


def _notebook(name: str, title: str) -> Entity:
    return {
        "@id": f"notebooks/{name}.ipynb",
        "@type": ["File", "SoftwareSourceCode"],
        "name": title,
        "encodingFormat": "application/x-ipynb+json",
        "programmingLanguage": "Python",
        "license": [{"@id": LICENCES["MIT"]}, {"@id": LICENCES["CC-BY-4.0"]}],
    }


def _figures(root: Path, published: list[str], profile: str) -> tuple[list[Entity], list[Entity]]:
    """The files of the figures of a notebook, and what their records say of how they were made."""
    files, records = [], []
    for figure in published:
        base = f"figures/{figure}" if profile == "default" else f"figures/{profile}/{figure}"
        made: Entity = {}
        if (root / f"{base}.json").is_file():
            made = json.loads((root / f"{base}.json").read_text(encoding="utf-8"))
            records.append(made)
        for ending, kind in KINDS.items():
            if (root / f"{base}.{ending}").is_file():
                entity: Entity = {"@id": f"{base}.{ending}", "@type": "File", "encodingFormat": kind}
                entity["name"] = f"{figure}.{ending}, profile {profile}"
                entity["license"] = {"@id": LICENCES["CC-BY-4.0"]}
                if ending == "png" and made.get("alt"):
                    entity["description"] = made["alt"]
                files.append(entity)
    return files, records


def _surfaces(record: Entity) -> list[Entity]:
    """The surfaces that a figure was made of: no files, but their content is named by its sum."""
    return [
        {
            "@id": f"#surface-{facts['sha256'][:16]}",
            "@type": "CreativeWork",
            "name": f"{name}, {counted(facts['faces'], 'face')}, {counted(facts['vertices'], 'vertex')}",
            "identifier": f"sha256:{facts['sha256']}",
        }
        for name, facts in record.get("inputs", {}).items()
    ]


def _action(name: str, title: str, profile: str, results: list[Entity], records: list[Entity]) -> Entity:
    objects = {each["@id"]: {"@id": each["@id"]} for record in records for each in _surfaces(record)}
    values = {key: value for record in records for key, value in record.get("parameters", {}).items()}
    return {
        "@id": f"#{name}-{profile}",
        "@type": "CreateAction",
        "name": f"{title} (profile {profile})",
        "description": f"make figures PROFILE={profile} NAMES={name}; parameters: {json.dumps(values)}",
        "instrument": {"@id": f"notebooks/{name}.ipynb"},
        "object": [{"@id": "geoweave/"}, *objects.values()],
        "result": [{"@id": each["@id"]} for each in results],
    }


def _scan(name: str) -> Entity:
    entry = datasets.dataset(name)
    return {
        "@id": f"geoweave/data/{entry.file}",
        "@type": "File",
        "name": entry.title,
        "description": f"{entry.source}; licence: {entry.licence}",
        "creditText": entry.credit,
        "identifier": f"sha256:{entry.sha256}",
    }
