"""The bytes of a mesh file as the readers want them: unpacked, and text without marks of its encoding."""

from __future__ import annotations

import bz2
import gzip
import lzma
import zipfile
from collections.abc import Callable
from io import BufferedIOBase
from pathlib import Path, PurePosixPath
from typing import IO

from geoweave.errors import MeshError

MOST_BYTES = 4 * 1024**3
"""A packed file may unpack to this many bytes; a small file that holds more is meant to do harm."""

PACKED = ("gz", "bz2", "xz", "zip")
"""Endings of packed files that are read."""

UNREAD = ("zst", "7z", "tar", "tgz", "rar")
"""Endings of packed files that are refused by name."""

_OPENERS: dict[str, Callable[[Path], BufferedIOBase]] = {
    "gz": gzip.GzipFile,
    "bz2": bz2.BZ2File,
    "xz": lzma.LZMAFile,
}

_MARKS = (
    (b"\xef\xbb\xbf", "utf-8"),
    (b"\xff\xfe\x00\x00", "utf-32-le"),
    (b"\x00\x00\xfe\xff", "utf-32-be"),
    (b"\xff\xfe", "utf-16-le"),
    (b"\xfe\xff", "utf-16-be"),
)
"""Byte order marks, the longer before those they begin with, and the encodings that they announce."""

_SAMPLE = 400
"""Bytes at the start of a file by which UTF-16 without a mark is recognised."""


def kind_of(path: Path) -> str:
    """The ending of a file's name, in small letters and without its dot."""
    return path.suffix.lower().removeprefix(".")


def unpacked(file: Path, is_mesh: Callable[[str], bool]) -> tuple[bytes, str]:
    """Return the bytes of the mesh file inside a packed one, and its ending.

    Parameters
    ----------
    file : the packed file
    is_mesh : tells from an ending whether a file inside is one to read

    Raises
    ------
    MeshError
        If there is no mesh file in it, or more than one, or more than `MOST_BYTES`; or if it is damaged.
    OSError
        If the file cannot be read.
    """
    kind = kind_of(file)
    try:
        if kind == "zip":
            return _zipped(file, is_mesh)
        with _OPENERS[kind](file) as stream:
            return _all_of(stream), kind_of(Path(file.stem))
    except (EOFError, lzma.LZMAError, zipfile.BadZipFile, gzip.BadGzipFile) as error:
        raise MeshError("it is damaged or cut short, and cannot be unpacked") from error
    except (NotImplementedError, RuntimeError) as error:  # an unknown method, or a password
        raise MeshError(f"it cannot be unpacked ({error})") from error


def _zipped(file: Path, is_mesh: Callable[[str], bool]) -> tuple[bytes, str]:
    with zipfile.ZipFile(file) as archive:
        inside = [
            name
            for name in archive.namelist()
            if is_mesh(kind_of(Path(name))) and not PurePosixPath(name).name.startswith(".")
        ]
        if not inside:
            raise MeshError("it holds no mesh file")
        if len(inside) > 1:
            raise MeshError(
                f"it holds {len(inside)} mesh files ({', '.join(inside[:3])}); unpack the one you want"
            )
        with archive.open(inside[0]) as stream:
            return _all_of(stream), kind_of(Path(inside[0]))


def _all_of(stream: IO[bytes] | BufferedIOBase) -> bytes:
    data = stream.read(MOST_BYTES + 1)
    if len(data) > MOST_BYTES:
        raise MeshError(f"it unpacks to more than {MOST_BYTES / 1024**3:.0f} GB")
    return data


def plain_text(data: bytes, first_word: str = "") -> bytes:
    """Return text as UTF-8 without a byte order mark; bytes that are not such text come back as they are.

    Parameters
    ----------
    data : the file
    first_word : the word that a text file of this format begins with, in small letters; a file that begins
        otherwise once it is decoded is taken for a binary one

    Examples
    --------
    >>> from geoweave.meshing.contents import plain_text
    >>> plain_text("v 1 2 3".encode("utf-16"))
    b'v 1 2 3'
    """
    encoding = next((name for mark, name in _MARKS if data.startswith(mark)), None)
    if encoding is None:
        sample = data[: _SAMPLE // 2 * 2]
        for name, low, high in (
            ("utf-16-le", sample[::2], sample[1::2]),
            ("utf-16-be", sample[1::2], sample[::2]),
        ):
            if high and not any(high) and all(low):
                encoding = name
    if encoding is None:
        return data
    try:
        text = data.decode(encoding)
    except UnicodeDecodeError:
        return data
    text = text.removeprefix("\ufeff")
    return text.encode() if text.lstrip().lower().startswith(first_word) else data
