"""Every error a user can put right is a GeoweaveError, so that the command can tell it from a defect."""

import importlib
import inspect
from pathlib import Path

import geoweave
from geoweave.errors import GeoweaveError

PACKAGE = Path(geoweave.__file__).parent


def test_errors_of_the_package_descend_from_one() -> None:
    paths = [path.relative_to(PACKAGE.parent).with_suffix("") for path in PACKAGE.rglob("*.py")]
    modules = [".".join(path.parts) for path in paths if not path.stem.startswith("__")]
    own = {
        kind
        for module in modules
        for _, kind in inspect.getmembers(importlib.import_module(module), inspect.isclass)
        if issubclass(kind, Exception) and kind.__module__.startswith("geoweave")
    }
    names = {kind.__name__ for kind in own}
    assert {"MeshError", "FieldError", "DataError", "RenderError", "OutputError", "PoolError"} <= names
    assert all(issubclass(kind, GeoweaveError) and kind.__doc__ for kind in own)
