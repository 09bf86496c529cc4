import hashlib
import re
import shutil
import socket
import threading
from collections.abc import Iterator
from dataclasses import replace
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path

import numpy as np
import pytest

from geoweave.errors import DataError
from geoweave.models import datasets

EMBEDDED = [name for name in datasets.names() if datasets.dataset(name).embedded]
FETCHED = [name for name in datasets.names() if not datasets.dataset(name).embedded]
TRIANGLE = b"OFF\n4 4 0\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 2 1\n3 0 1 3\n3 1 2 3\n3 2 0 3\n"


@pytest.fixture
def cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """An empty cache, and no folder of local copies."""
    monkeypatch.setattr("pooch.os_cache", lambda name: tmp_path / "cache")
    monkeypatch.delenv(datasets.VARIABLE, raising=False)
    return tmp_path / "cache"


@pytest.fixture
def served() -> Iterator[dict[str, bytes]]:
    """A server on this machine; the yielded table holds its files, and its address under ''."""
    files: dict[str, bytes] = {}

    class Answer(BaseHTTPRequestHandler):
        def do_GET(self) -> None:
            body = files.get(self.path.strip("/"))
            self.send_response(404 if body is None else 200)
            self.send_header("Content-Length", str(len(body or b"")))
            self.end_headers()
            self.wfile.write(body or b"")

        def log_message(self, *_: object) -> None:
            pass

    server = ThreadingHTTPServer(("127.0.0.1", 0), Answer)
    thread = threading.Thread(target=server.serve_forever, args=(0.02,))
    thread.start()
    files[""] = f"http://127.0.0.1:{server.server_port}".encode()
    yield files
    server.shutdown()
    thread.join()
    server.server_close()


def register(monkeypatch: pytest.MonkeyPatch, url: str) -> None:
    """Put a tetrahedron into the registry under the name of the cow."""
    entry = replace(
        datasets.dataset("cow"), file="cow.off", url=url, sha256=hashlib.sha256(TRIANGLE).hexdigest()
    )
    monkeypatch.setitem(datasets.REGISTRY, "cow", entry)


@pytest.fixture
def dead_server() -> Iterator[str]:
    """An address that refuses every connection, for as long as the test runs: bound, and not listening."""
    with socket.socket() as held:
        held.bind(("127.0.0.1", 0))
        yield f"http://127.0.0.1:{held.getsockname()[1]}"


def test_the_registry_is_complete() -> None:
    assert set(EMBEDDED) == {"armadillo", "bunny", "camel", "spot"}
    assert set(FETCHED) == {"rocker-arm", "fertility", "cow"}
    for name in datasets.names():
        entry = datasets.dataset(name)
        assert entry.name == name
        assert re.fullmatch("[0-9a-f]{64}", entry.sha256)
        assert all([entry.title, entry.source, entry.licence, entry.credit])
        assert entry.up in ("x", "y", "z")
        assert np.linalg.norm(entry.front) > 0
        # a pinned commit, so that what is fetched cannot change
        assert entry.url is None or re.search(
            r"^https://.*/[0-9a-f]{40}/.*" + re.escape(entry.file), entry.url
        )


def test_every_embedded_file_is_registered_small_and_described() -> None:
    files = {path.name for path in datasets.EMBEDDED.glob("*.npz")}
    assert files == {datasets.dataset(name).file for name in EMBEDDED}
    sizes = [(datasets.EMBEDDED / file).stat().st_size for file in files]
    assert max(sizes) < 400_000
    assert sum(sizes) < 1_500_000
    readme = (datasets.EMBEDDED / "README.md").read_text(encoding="utf-8")
    for name in EMBEDDED:
        entry = datasets.dataset(name)
        assert entry.file in readme
        assert entry.credit in readme


@pytest.mark.parametrize("name", EMBEDDED)
def test_embedded_scans_are_closed_and_clean(name: str, cache: Path) -> None:
    assert datasets.available(name)
    mesh = datasets.load(name)
    assert 5_000 <= mesh.n_faces <= 10_000
    assert (mesh.n_components, mesh.genus, len(mesh.boundary_loops)) == (1, 0, 0)
    assert np.degrees(mesh.corner_angles).min() > 20
    assert np.einsum("fx,fx->", mesh.barycenters, mesh.face_normals * mesh.face_areas[:, None]) > 0
    assert not cache.exists()


def test_an_unknown_name_is_refused_with_the_known_ones() -> None:
    for ask in (datasets.load, datasets.fetch, datasets.available):
        with pytest.raises(DataError, match=r"no data set 'teapot'.*armadillo.*cow"):
            ask("teapot")


def test_a_damaged_embedded_file_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    shutil.copytree(datasets.EMBEDDED, tmp_path / "data")
    monkeypatch.setattr(datasets, "EMBEDDED", tmp_path / "data")
    (tmp_path / "data" / "spot.npz").write_bytes(b"PK")
    assert not datasets.available("spot")
    with pytest.raises(DataError, match=r"spot\.npz.*sha256 differs.*install geoweave again"):
        datasets.load("spot")
    (tmp_path / "data" / "spot.npz").unlink()
    with pytest.raises(DataError, match=r"spot\.npz: missing from the package"):
        datasets.load("spot")


def test_a_mesh_is_fetched_once_and_then_kept(
    cache: Path, served: dict[str, bytes], monkeypatch: pytest.MonkeyPatch
) -> None:
    served["cow.off"] = TRIANGLE
    register(monkeypatch, f"{served[''].decode()}/cow.off")
    assert not datasets.available("cow")
    assert datasets.fetch("cow") == cache / "cow.off"
    assert datasets.available("cow")
    del served["cow.off"]
    assert datasets.load("cow").n_faces == 4


def test_what_comes_with_a_wrong_sum_is_refused_and_leaves_nothing(
    cache: Path, served: dict[str, bytes], monkeypatch: pytest.MonkeyPatch
) -> None:
    served["cow.off"] = TRIANGLE + b"\n"
    register(monkeypatch, f"{served[''].decode()}/cow.off")
    with pytest.raises(DataError, match=rf"cow\.off: what came is not.*{datasets.VARIABLE}"):
        datasets.load("cow")
    assert not list(cache.glob("*"))


def test_a_missing_page_and_a_dead_server_are_refused_and_leave_nothing(
    cache: Path, served: dict[str, bytes], dead_server: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    for url in (f"{served[''].decode()}/gone.off", f"{dead_server}/cow.off"):
        register(monkeypatch, url)
        with pytest.raises(DataError, match=rf"cannot be fetched.*{datasets.VARIABLE}") as refusal:
            datasets.load("cow")
        assert "\n" not in str(refusal.value)
        assert not list(cache.glob("*"))


def test_local_copies_are_used_and_checked(
    cache: Path, tmp_path: Path, dead_server: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    register(monkeypatch, f"{dead_server}/cow.off")
    (tmp_path / "copies").mkdir()
    copy = tmp_path / "copies" / "cow.off"
    copy.write_bytes(TRIANGLE)
    monkeypatch.setenv(datasets.VARIABLE, str(tmp_path / "copies"))
    assert datasets.available("cow")
    assert datasets.fetch("cow") == copy
    assert datasets.load("cow").genus == 0
    copy.write_bytes(TRIANGLE[:-2])
    assert not datasets.available("cow")
    with pytest.raises(DataError, match=r"cow\.off: not the .*sha256 differs"):
        datasets.load("cow")
    monkeypatch.setenv(datasets.VARIABLE, str(tmp_path / "nowhere"))
    with pytest.raises(DataError, match="which is no folder"):
        datasets.load("cow")


def test_a_damaged_copy_in_the_cache_is_fetched_anew(
    cache: Path, served: dict[str, bytes], monkeypatch: pytest.MonkeyPatch
) -> None:
    served["cow.off"] = TRIANGLE
    register(monkeypatch, f"{served[''].decode()}/cow.off")
    cache.mkdir()
    (cache / "cow.off").write_bytes(b"half a fi")
    assert not datasets.available("cow")
    assert datasets.load("cow").n_faces == 4
