"""The models of the paper's figures by name: scans and surfaces made by formulas.

A notebook names its models in its parameters. Another profile can then name the real model instead of its
stand-in.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from geoweave.errors import DataError
from geoweave.models import datasets, shapes
from geoweave.surface import TriMesh

__all__ = ["MODELS", "Model", "about", "load"]


@dataclass(frozen=True)
class Model:
    """One model of a figure.

    Attributes
    ----------
    title : words for a caption; names the model that it stands in for
    role : the row of Table 1 that it belongs to, "" if none
    view : name of its camera in `geoweave.viz`
    build : makes the surface; None for a scan of that name in `geoweave.models.datasets`
    """

    title: str
    role: str
    view: str
    build: Callable[[], TriMesh] | None = None


MODELS = {
    "armadillo": Model("Armadillo", "armadillo", "armadillo"),
    "bunny": Model("Stanford bunny", "", "bunny"),
    "bumpy-box": Model("Bumpy box", "", "bumpy-box", shapes.bumpy_box),
    "camel": Model("Camel", "", "camel"),
    "cone": Model("Cone", "", "cone", shapes.cone),
    "cow": Model("Cow", "cow", "cow"),
    "crown": Model("Crown (for the splash)", "", "crown", shapes.crown),
    "fertility": Model("Fertility", "", "fertility"),
    "genus-4": Model("Genus 4 (for Fertility)", "", "genus-4", lambda: shapes.genus_g(4, faces=6_000)),
    "icosahedron": Model("Icosahedron", "", "icosahedron", lambda: shapes.icosahedron(5_120)),
    "rocker-arm": Model("Rocker Arm", "rocker arm", "rocker-arm"),
    "rocker-arm-like": Model("Rocker (stand-in)", "rocker arm", "rocker-like", shapes.rocker_arm),
    "saddle": Model("Saddle", "", "saddle", shapes.saddle),
    "schwarz-p": Model("Schwarz-P", "Schwarz-P", "schwarz-p", shapes.schwarz_p),
    "sphere": Model("Sphere", "", "sphere", shapes.sphere),
    "spot": Model("Spot (for the cow)", "cow", "spot"),
    "torus": Model("Torus", "", "torus", shapes.torus),
    "vessel": Model("Vessel (for the aneurysm)", "", "vessel", shapes.vessel),
}


def about(name: str) -> Model:
    """Return what is known of a model.

    Raises
    ------
    DataError
        If there is no model of that name; the message lists all names.

    Examples
    --------
    >>> gw.models.about("spot").title
    'Spot (for the cow)'
    """
    if name not in MODELS:
        raise DataError(f"there is no model '{name}'; there are: {', '.join(MODELS)}")
    return MODELS[name]


def load(name: str) -> TriMesh:
    """Load or build a model, its vertex mean at the origin and its farthest vertex at distance 1.

    Raises
    ------
    DataError
        If there is no such model, or its scan is not on this machine and cannot be fetched.

    Examples
    --------
    >>> torus = gw.models.load("torus")
    >>> torus.genus, round(torus.bounding_radius, 9)
    (1, 1.0)
    """
    build = about(name).build
    mesh = datasets.load(name) if build is None else build()
    return mesh.normalized()[0]
