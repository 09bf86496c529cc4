"""Where the package and its checkout lie, which version this is, and where figures are written.

The environment variable ``GEOWEAVE_FIGURES`` names the folder for figures. ``geoweave figures`` sets it for
the notebooks that it executes; ``make test`` names a folder under ``build/``, so that no committed file
changes. A notebook that is run by hand has no such variable and writes to ``figures/`` of its checkout.
"""

import os
from pathlib import Path

from geoweave.errors import GeoweaveError

FIGURES_VARIABLE = "GEOWEAVE_FIGURES"

PACKAGE = Path(__file__).resolve().parent
"""The folder of this package, with its data."""

__all__ = ["FIGURES_VARIABLE", "PACKAGE", "figures_folder", "package_version", "repository"]


def repository() -> Path:
    """The checkout (pyproject.toml and the package) around the working directory, else around this package.

    Raises
    ------
    GeoweaveError
        If neither the working directory nor the package lies inside a checkout of geoweave.
    """
    here = Path.cwd().resolve()
    for folder in (here, *here.parents, PACKAGE.parent):
        if (folder / "pyproject.toml").is_file() and (folder / "geoweave" / "__init__.py").is_file():
            return folder
    raise GeoweaveError(
        f"{here} is not inside a checkout of geoweave: run the command there, or name the folder for "
        f"figures in the environment variable {FIGURES_VARIABLE}"
    )


def package_version() -> str:
    """Version of the installed package, or of the checkout that runs without being installed."""
    # Both are slow to import and few callers ask.
    import tomllib
    from importlib import metadata

    try:
        return metadata.version("geoweave")
    except metadata.PackageNotFoundError:
        with (repository() / "pyproject.toml").open("rb") as file:
            return str(tomllib.load(file)["project"]["version"])


def figures_folder(profile: str = "default") -> Path:
    """The folder that figures of ``profile`` go to: ``figures/`` for default, ``figures/<profile>/`` else.

    The base folder is ``$GEOWEAVE_FIGURES`` where that is set, ``figures/`` of the checkout otherwise. The
    folder is not created here.

    Raises
    ------
    GeoweaveError
        If the profile's name is no plain word, or no base folder can be found.

    Examples
    --------
    >>> from geoweave.checkout import figures_folder
    >>> figures_folder("paper") == figures_folder() / "paper"
    True
    >>> figures_folder("../outside")
    Traceback (most recent call last):
    geoweave.errors.GeoweaveError: '../outside' is no name of a profile: use default or paper
    """
    if not profile.isidentifier():
        raise GeoweaveError(f"'{profile}' is no name of a profile: use default or paper")
    named = os.environ.get(FIGURES_VARIABLE, "")
    base = Path(named) if named else repository() / "figures"
    return base if profile == "default" else base / profile
