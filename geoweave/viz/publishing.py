"""A figure's three files: the picture, the numbers behind it, and what it was made from."""

from __future__ import annotations

import hashlib
import importlib.metadata
import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from geoweave.checkout import figures_folder, package_version
from geoweave.errors import RenderError
from geoweave.files import replacing
from geoweave.surface import TriMesh
from geoweave.viz.picture import Picture

LARGEST = 1_500_000
"""Bytes that a published picture may take."""

LIBRARIES = ("numpy", "scipy", "numba", "matplotlib", "pyvista", "vtk")


def publish(
    name: str,
    picture: Picture,
    *,
    table: pd.DataFrame | None = None,
    params: Mapping[str, Any] | None = None,
    inputs: Mapping[str, TriMesh] | None = None,
    profile: str = "default",
) -> Picture:
    """Write ``<name>.png``, ``<name>.csv`` and ``<name>.json`` into the figures folder of a profile.

    The same arguments on the same machine give the same bytes: the JSON holds parameters, hashes of the
    meshes and versions, no times and no paths. Each file appears whole or not at all.

    Parameters
    ----------
    name : name of the figure, a plain word
    picture : what to write; it is returned, so that a notebook cell ending in this call shows it
    table : the numbers behind the picture, written with six significant digits
    params : the parameters of the notebook, values that JSON can hold
    inputs : the meshes it was made from, by name
    profile : "default", or the name of another profile

    Raises
    ------
    RenderError
        If the name is not a plain word.
    OutputError
        If a file cannot be written.

    Examples
    --------
    >>> import tempfile
    >>> from unittest import mock
    >>> chart = viz.drop_chart([viz.Drop("Cow", 20.0, 7.0)])
    >>> with tempfile.TemporaryDirectory() as folder, mock.patch.dict(os.environ, GEOWEAVE_FIGURES=folder):
    ...     _ = viz.publish("cow", chart)
    ...     sorted(os.listdir(folder))
    ...
    ['cow.json', 'cow.png']
    """
    if not name.isidentifier():
        raise RenderError(f"'{name}' cannot name a figure: use letters, digits and underscores")
    folder = figures_folder(profile)
    folder.mkdir(parents=True, exist_ok=True)
    encoded = picture.png_within(LARGEST)
    with replacing(folder / f"{name}.png") as path:
        path.write_bytes(encoded)
    if table is not None:
        with replacing(folder / f"{name}.csv") as path:
            _write_text(path, table.to_csv(index=False, float_format="%.6g", lineterminator="\n"))
    record = provenance(name, params or {}, inputs or {}, profile)
    record["alt"] = picture.alt
    with replacing(folder / f"{name}.json") as path:
        _write_text(path, json.dumps(record, indent=2, sort_keys=True, ensure_ascii=False) + "\n")
    return picture


def provenance(
    name: str, params: Mapping[str, Any], inputs: Mapping[str, TriMesh], profile: str
) -> dict[str, Any]:
    """What a figure was made from, as values for JSON.

    Examples
    --------
    >>> record = viz.provenance("fig07", {"share": np.float64(0.1)}, {}, "default")
    >>> record["parameters"], record["profile"]
    ({'share': 0.1}, 'default')
    """
    return {
        "figure": name,
        "profile": profile,
        "parameters": {key: _plain(value) for key, value in params.items()},
        "inputs": {
            label: {"vertices": mesh.n_vertices, "faces": mesh.n_faces, "sha256": mesh_digest(mesh)}
            for label, mesh in inputs.items()
        },
        "versions": {"geoweave": package_version()}
        | {library: importlib.metadata.version(library) for library in LIBRARIES},
    }


def mesh_digest(mesh: TriMesh) -> str:
    """SHA-256 of the vertex coordinates and the faces, little-endian.

    Examples
    --------
    >>> sphere = gw.shapes.sphere(faces=80)
    >>> moved = gw.TriMesh(sphere.vertices + 1e-9, sphere.faces)
    >>> len(viz.mesh_digest(sphere)), viz.mesh_digest(sphere) == viz.mesh_digest(moved)
    (64, False)
    """
    digest = hashlib.sha256()
    digest.update(np.ascontiguousarray(mesh.vertices, dtype="<f8").tobytes())
    digest.update(np.ascontiguousarray(mesh.faces, dtype="<i8").tobytes())
    return digest.hexdigest()


def _plain(value: Any) -> Any:
    """Turn numpy scalars and arrays, tuples and paths' names into what JSON holds."""
    if isinstance(value, np.generic):
        return value.item()
    if isinstance(value, np.ndarray):
        return value.tolist()
    if isinstance(value, (list, tuple)):
        return [_plain(each) for each in value]
    if isinstance(value, Mapping):
        return {str(key): _plain(each) for key, each in value.items()}
    return value


def _write_text(path: Path, text: str) -> None:
    path.write_text(text, encoding="utf-8", newline="\n")
