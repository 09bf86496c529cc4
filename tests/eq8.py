"""Eq. 8 on surfaces of several kinds, for the tests of its energy, its systems and its steps."""

from __future__ import annotations

import numpy as np
from surfaces import surface

import geoweave as gw
from geoweave.arrays import Scalars
from geoweave.foliation.foliation import punctured
from geoweave.foliation.theta_and_s import Alternation

NAMES = ("jagged sphere", "genus 5", "two pieces")


def problem(name: str) -> tuple[Alternation, Scalars, Scalars]:
    """Eq. 8 on a surface, with an uneven s and any theta."""
    field, part = punctured(gw.smoothest_field(surface(name)))
    rng = np.random.default_rng(0)
    s = 5.0 * rng.uniform(0.5, 1.5, part.mesh.n_faces)
    return Alternation(field, s, s, 1e-3), rng.uniform(-3.0, 3.0, part.mesh.n_vertices), s
