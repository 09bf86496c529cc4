"""Loops that vectors cannot express, compiled by numba and kept on disk between runs."""

from __future__ import annotations

from collections.abc import Callable
from typing import ParamSpec, TypeVar

from numba import njit

_Arguments = ParamSpec("_Arguments")
_Result = TypeVar("_Result")


def compiled(function: Callable[_Arguments, _Result]) -> Callable[_Arguments, _Result]:
    """Compile a function on first call for the types it is called with; its checked signature stays."""
    jitted: Callable[_Arguments, _Result] = njit(cache=True, nogil=True)(function)
    return jitted
