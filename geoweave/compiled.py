"""Loops that vectors cannot express, compiled by numba and kept on disk between runs.

Numba takes about half a second to import. It is imported when the first compiled function is called, so
that importing a module which holds such functions costs nothing.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cached_property, update_wrapper
from typing import Any, Generic, ParamSpec, TypeVar, cast

_Arguments = ParamSpec("_Arguments")
_Result = TypeVar("_Result")


class _CompiledWhenCalled(Generic[_Arguments, _Result]):
    """A function that numba compiles at its first call, for the types of the arguments."""

    def __init__(self, function: Callable[_Arguments, _Result]) -> None:
        update_wrapper(self, function)
        self._function = function

    @cached_property
    def _dispatcher(self) -> Any:
        from numba import njit

        return njit(cache=True, nogil=True)(self._function)

    @property
    def _numba_type_(self) -> Any:
        """The type that numba asks for where another compiled function calls this one."""
        from numba import types

        return types.Dispatcher(self._dispatcher)

    def __call__(self, *args: _Arguments.args, **kwargs: _Arguments.kwargs) -> _Result:
        return cast(_Result, self._dispatcher(*args, **kwargs))


def compiled(function: Callable[_Arguments, _Result]) -> Callable[_Arguments, _Result]:
    """Compile a function at its first call, for the types it is called with; keep its checked signature.

    The machine code is kept on disk beside the module and is loaded by the next process. Functions that are
    compiled may call each other. Other names of the module are read when it is compiled, and stay.

    >>> from geoweave.compiled import compiled
    >>> @compiled
    ... def total(values):
    ...     return values.sum()
    >>> total.__name__
    'total'
    """
    return _CompiledWhenCalled(function)
