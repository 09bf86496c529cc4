"""Errors that the caller can put right: each text is a sentence that names the place and the remedy.

The command prints it and ends with exit status 2. Any other exception is a fault of geoweave.
"""

from __future__ import annotations


class GeoweaveError(Exception):
    """Something the caller can put right; its text names the place and the remedy.

    Examples
    --------
    >>> gw.read_mesh("nothing.obj")
    Traceback (most recent call last):
    geoweave.errors.MeshError: nothing.obj: ...
    >>> issubclass(gw.MeshError, gw.GeoweaveError)
    True
    """


class MeshError(GeoweaveError):
    """A mesh that no method of the paper is defined on, and what to do about it."""


class FieldError(GeoweaveError):
    """A vector field, or a request about one, that cannot be honoured."""


class DataError(GeoweaveError):
    """A named data set that is missing, unreachable or not what its checksum says."""


class RodError(GeoweaveError):
    """Elastic rods, or a file of them, that cannot be simulated, and what to do about it."""


class WeaveFileError(GeoweaveError):
    """A ``weave.json`` that is no weave, or one with a slip in it, and what to do about it."""


class RenderError(GeoweaveError):
    """Pictures cannot be drawn on this machine, and what to install."""
