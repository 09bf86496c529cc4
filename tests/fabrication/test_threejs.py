"""three.js as trimesh has it, and clear words where it does not."""

from __future__ import annotations

import zipfile
from pathlib import Path

import pytest

from geoweave.fabrication.threejs import three_js
from geoweave.files import OutputError

HEAD = "/**\n * @license\n * Copyright 2010-2022 Three.js Authors\n */"


def archive(folder: Path, page: str, name: str = "viewer.html.template") -> Path:
    place = folder / "viewer.zip"
    with zipfile.ZipFile(place, "w") as file:
        file.writestr(name, page)
    return place


def test_the_library_is_whole_and_nothing_else() -> None:
    library = three_js()
    assert library.release >= 140
    assert library.source.startswith("/**\n * @license\n * Copyright 2010-")
    assert 500_000 < len(library.source) < 800_000
    assert "</script" not in library.source
    # What follows it in trimesh's page is not taken along.
    assert "TrackballControls" not in library.source
    assert "B64GLTF" not in library.source
    assert library.licence.startswith("The MIT License\n\nCopyright (c) 2010-")
    assert "--" not in library.licence  # it stands in a comment
    assert max(map(len, library.licence.splitlines())) < 100


@pytest.mark.parametrize(
    "page",
    [
        "",
        "<script>var THREE = {}</script>",
        f'{HEAD}const e="115";Object.defineProperty(t,"__esModule",{{value:!0}})}}));',
        f'{HEAD}const e="140";',
    ],
)
def test_another_page_is_refused(tmp_path: Path, page: str) -> None:
    with pytest.raises(OutputError, match=r"viewer.zip: holds no three.js .* install trimesh"):
        three_js(archive(tmp_path, page))


def test_no_page_is_refused(tmp_path: Path) -> None:
    with pytest.raises(OutputError, match="holds no viewer"):
        three_js(tmp_path / "none.zip")
    with pytest.raises(OutputError, match="holds no viewer"):
        three_js(archive(tmp_path, "", "other"))
    (tmp_path / "viewer.zip").write_bytes(b"no archive")
    with pytest.raises(OutputError, match="holds no viewer"):
        three_js(tmp_path / "viewer.zip")
