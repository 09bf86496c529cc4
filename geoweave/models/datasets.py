"""Scanned meshes by name: a few come with the package, the others are fetched once.

An embedded mesh lies in the package. Any other is looked for in the folder that the environment variable
``GEOWEAVE_DATA_DIR`` names, then in the cache, then at its address. The file must have the sha256 of the
registry; no other mesh ever takes its place.
"""

from __future__ import annotations

import hashlib
import os
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from geoweave.checkout import PACKAGE
from geoweave.errors import DataError
from geoweave.surface import TriMesh

VARIABLE = "GEOWEAVE_DATA_DIR"
"""The environment variable that names a folder of local copies."""

TIMEOUT = 30.0
"""Seconds without an answer after which a server counts as unreachable."""

EMBEDDED = PACKAGE / "data"
"""The folder of the meshes that come with the package."""

_CGAL = "Debian package libcgal-demo 5.5.1-2, data.tar.gz, "
_COMMON = "https://raw.githubusercontent.com/alecjacobson/common-3d-test-models/"
_LIBIGL = "https://raw.githubusercontent.com/libigl/libigl-tutorial-data/"
_STANFORD = "Stanford Computer Graphics Laboratory, The Stanford 3D Scanning Repository"


@dataclass(frozen=True)
class Dataset:
    """One named mesh: where it comes from, what may be done with it, and how it stands upright."""

    name: str
    title: str
    file: str
    sha256: str
    source: str
    licence: str
    credit: str
    url: str | None = None
    """Where it is fetched from; None for a mesh that comes with the package."""
    up: str = "y"
    """The axis that points up."""
    front: tuple[float, float, float] = (0.0, 0.0, 1.0)
    """The direction from the middle of the mesh to a camera in front of it."""

    @property
    def embedded(self) -> bool:
        """Whether the mesh comes with the package."""
        return self.url is None


REGISTRY = {
    dataset.name: dataset
    for dataset in (
        Dataset(
            name="armadillo",
            title="Armadillo",
            file="armadillo.npz",
            sha256="38fd7080b85cf6109f659e860f6dfd8a370e932441c4ce2dd42240973127f8f8",
            source=_CGAL + "data/meshes/armadillo.off; remeshed to 9,000 faces",
            licence="CC0-1.0, as CGAL distributes it",
            credit=_STANFORD,
            front=(-0.45, 0.2, -1.0),
        ),
        Dataset(
            name="bunny",
            title="Stanford bunny",
            file="bunny.npz",
            sha256="c7aa47bdff803a7c8258a85c4fb7270cecdfe7be3839b35563264018e1c4d7ca",
            source=_CGAL + "data/meshes/bunny00.off; remeshed to 6,000 faces",
            licence="CC0-1.0, as CGAL distributes it",
            credit=_STANFORD,
            front=(0.1, 0.2, 1.0),
        ),
        Dataset(
            name="camel",
            title="Camel",
            file="camel.npz",
            sha256="08fccefbc2ec1f32c8a6acc0cf34b8b23e87fcf5620776f51087d675204490ee",
            source=_CGAL + "data/meshes/camel.off; remeshed to 8,000 faces",
            licence="CC0-1.0, as CGAL distributes it",
            credit="the CGAL project",
            front=(1.0, 0.2, 0.7),
        ),
        Dataset(
            name="spot",
            title="Spot the cow",
            file="spot.npz",
            sha256="54163210adc1cb5ee3f9f1ea78f1fc90bdba7049d8ac6205fab7281d03112701",
            source="PyPI source distribution potpourri3d 1.4.0, deps/geometry-central/test/assets/spot.ply; "
            "remeshed to 6,000 faces",
            licence="public domain (CC0-1.0)",
            credit="Keenan Crane",
            front=(0.8, 0.3, -1.0),
        ),
        Dataset(
            name="rocker-arm",
            title="Rocker Arm",
            file="rocker-arm.obj",
            sha256="590257e6d01e689354821d807854306c3bfbb02d9cca73404d5a4924f105c287",
            source="common-3d-test-models; origin the AIM@SHAPE repository, INRIA",
            licence="none stated at the source; fetched, never redistributed here",
            credit="AIM@SHAPE, INRIA",
            url=_COMMON + "8a4f8642acaf43f9cd7b67858a1502e1055ef202/data/rocker-arm.obj",
            front=(1.0, 0.35, 0.5),
        ),
        Dataset(
            name="fertility",
            title="Fertility",
            file="fertility.off",
            sha256="145fdfb007c8d5d09ba60943f14f4ddc9edd4327c7956fe379c624adeb59dc5b",
            source="libigl-tutorial-data; origin the AIM@SHAPE repository",
            licence="none stated at the source; fetched, never redistributed here",
            credit="AIM@SHAPE",
            url=_LIBIGL + "c1f9ede366d02e3531ecbaec5e3769312f31cccd/fertility.off",
        ),
        Dataset(
            name="cow",
            title="Viewpoint cow",
            file="cow.off",
            sha256="8834713b505f9bf78c7f7c8b719d51d885d7d059952698da006813d292d84e95",
            source="libigl-tutorial-data; origin Viewpoint Animation Engineering",
            licence="none stated at the source; fetched, never redistributed here",
            credit="Viewpoint Animation Engineering",
            url=_LIBIGL + "c1f9ede366d02e3531ecbaec5e3769312f31cccd/cow.off",
            front=(0.5, 0.15, 1.0),
        ),
    )
}


def names() -> tuple[str, ...]:
    """Return the names of all registered meshes, the embedded ones first.

    Examples
    --------
    >>> gw.datasets.names()[:4]
    ('armadillo', 'bunny', 'camel', 'spot')
    """
    return tuple(REGISTRY)


def dataset(name: str) -> Dataset:
    """Return the registry's entry for a name.

    Raises
    ------
    DataError
        If there is none; the message lists all names.

    Examples
    --------
    >>> gw.datasets.dataset("spot").licence
    'public domain (CC0-1.0)'
    """
    if name not in REGISTRY:
        raise DataError(f"there is no data set '{name}'; the data sets are {', '.join(names())}")
    return REGISTRY[name]


def available(name: str) -> bool:
    """Whether a mesh can be loaded without the network.

    Raises
    ------
    DataError
        If no mesh has that name, or ``GEOWEAVE_DATA_DIR`` names no folder.

    Examples
    --------
    >>> gw.datasets.available("bunny")
    True
    """
    entry = dataset(name)
    return any(_intact(place, entry) for place in _places(entry))


def fetch(name: str) -> Path:
    """Return the checked file of a named mesh; download it to the cache if it is not on this machine.

    Raises
    ------
    DataError
        If the name is unknown, a local copy has the wrong sha256, or the download fails or has the wrong
        sha256. A download that fails leaves nothing behind.

    Examples
    --------
    >>> gw.datasets.fetch("camel").name
    'camel.npz'
    """
    entry = dataset(name)
    for place in _places(entry):
        if _intact(place, entry):
            return place
        # A damaged file in the cache is fetched again; any other is the user's to deal with.
        if place.is_file() and (entry.embedded or place.parent != _cache()):
            remedy = "install geoweave again" if entry.embedded else f"remove it, or unset {VARIABLE}"
            raise DataError(f"{place}: not the {entry.title} of the registry (its sha256 differs); {remedy}")
    if entry.url is None:
        raise DataError(f"{EMBEDDED / entry.file}: missing from the package; install geoweave again")
    return _download(entry, entry.url)


def load(name: str) -> TriMesh:
    """Load a named mesh in its own units; what its file needs is mended as by `geoweave.read_mesh`.

    See `geoweave.models.load` for the same at bounding radius 1.

    Raises
    ------
    DataError
        As `fetch`.

    Examples
    --------
    >>> gw.datasets.load("spot").n_faces
    6000
    """
    path = fetch(name)
    if path.suffix == ".npz":
        with np.load(path, allow_pickle=False) as arrays:
            return TriMesh(arrays["vertices"], arrays["faces"])
    from geoweave.meshing import read_mesh

    return read_mesh(path).mesh


def _cache() -> Path:
    """The folder that fetched meshes are kept in."""
    import pooch  # takes a tenth of a second, and embedded meshes do without

    return Path(pooch.os_cache("geoweave"))


def _places(entry: Dataset) -> list[Path]:
    """Where the file may lie on this machine, in the order in which it is looked for."""
    if entry.embedded:
        return [EMBEDDED / entry.file]
    places = [_cache() / entry.file]
    named = os.environ.get(VARIABLE, "")
    if named:
        if not Path(named).is_dir():
            raise DataError(f"{VARIABLE} names '{named}', which is no folder; correct or unset it")
        places.insert(0, Path(named) / entry.file)
    return places


def _intact(path: Path, entry: Dataset) -> bool:
    """Whether there is a file at a path, with the sha256 of the registry."""
    try:
        return hashlib.sha256(path.read_bytes()).hexdigest() == entry.sha256
    except FileNotFoundError:
        return False
    except OSError as error:
        raise DataError(f"{path}: cannot be read ({error.strerror}); allow it, or unset {VARIABLE}") from None


def _download(entry: Dataset, url: str) -> Path:
    """Fetch a mesh into the cache."""
    import pooch

    # Pooch writes to a temporary file, checks it, and only then gives it its name.
    pooch.get_logger().setLevel("WARNING")
    try:
        downloader = pooch.HTTPDownloader(timeout=TIMEOUT)
        path = pooch.retrieve(
            url, f"sha256:{entry.sha256}", fname=entry.file, path=_cache(), downloader=downloader
        )
    except ValueError:
        raise DataError(
            f"{url}: what came is not the {entry.title} of the registry (its sha256 differs); "
            f"nothing was kept; put a copy of {entry.file} into a folder and name that in {VARIABLE}"
        ) from None
    except OSError as error:
        raise DataError(
            f"{url}: cannot be fetched ({type(error).__name__}); connect to the network, or put a copy of "
            f"{entry.file} into a folder and name that folder in {VARIABLE}"
        ) from None
    return Path(path)
