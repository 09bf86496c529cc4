"""Colours, fonts and sizes that every picture shares."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from functools import cache
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.colors import LinearSegmentedColormap, to_hex, to_rgb
from numpy.typing import NDArray

DPI = 200
"""Pixels per inch of a published figure."""

WIDTH = 2200
"""Pixels across a published figure."""

GROUND = "#ffffff"
SURFACE = "#f1ebe0"
"""Warm off-white."""
INK = "#22262b"
FAINT = "#6e747b"
LINE = "#d5d2cb"
BLUE = "#3b6ea5"
RED = "#b8402f"
GREEN = "#3f8f4f"
SOURCE = "#b8402f"
"""Singularities of positive index."""
SADDLE = "#2f6690"
"""Singularities of negative index."""
FIELD_LINES, LEVEL_LINES = "#4aa3f0", "#c86bfa"
"""Streamlines of a field and level sets of theta, bright enough for dark and light ground (Fig. 15)."""
SUPERSCRIPTS = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")
FAMILIES = ("#3f7d8c", "#d9a441", "#a8516a", "#5b6a99", "#8aa05a")
"""Teal, ochre, mallow: three calm hues for the three families of a weave; slate and sage for two more."""

RC: Any = {
    "figure.dpi": DPI,
    "savefig.dpi": DPI,
    "figure.facecolor": GROUND,
    "savefig.facecolor": GROUND,
    "font.family": "DejaVu Sans",
    "font.size": 9.0,
    "mathtext.fontset": "dejavusans",
    "text.color": INK,
    "axes.edgecolor": FAINT,
    "axes.labelcolor": INK,
    "axes.linewidth": 0.7,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "xtick.color": FAINT,
    "ytick.color": FAINT,
    "xtick.labelcolor": INK,
    "ytick.labelcolor": INK,
    "xtick.major.width": 0.7,
    "ytick.major.width": 0.7,
    "lines.linewidth": 1.6,
    "lines.solid_capstyle": "round",
    "legend.frameon": False,
    "text.usetex": False,
    "svg.hashsalt": "geoweave",
}


@contextmanager
def applied() -> Iterator[None]:
    """Draw in the style of the package whatever the user's own settings are, and leave those as they were."""
    with mpl.rc_context():
        mpl.rcdefaults()
        mpl.rcParams.update(RC)
        yield


@cache
def sequential() -> LinearSegmentedColormap:
    """Map of magnitudes, dark slate (0) over brick to warm amber (1).

    Lightness rises steadily and equal steps look equal: the stops are joined in Oklab and spaced by their
    distance there.
    """
    return _uniform("geoweave-heat", ["#26394d", "#5b4561", "#a8433f", "#e0672c", "#f7b04a"])


@cache
def diverging() -> LinearSegmentedColormap:
    """Map of signed values, blue (negative) over the colour of the surface (zero) to brick (positive)."""
    below = _uniform("below", ["#1f4e79", "#7ba0bf", SURFACE])(np.linspace(0, 1, 128))
    above = _uniform("above", [SURFACE, "#d98b6a", "#8f2a20"])(np.linspace(0, 1, 128))
    return LinearSegmentedColormap.from_list("geoweave-signed", np.vstack([below, above[1:]]), N=255)


@cache
def heat() -> LinearSegmentedColormap:
    """Map of magnitudes that should stand out from a pale surface: its colour (0) over sand to rust (1)."""
    return _uniform("geoweave-pale-heat", [SURFACE, "#efcb95", "#df8f4c", "#b2432a"])


@cache
def shade() -> LinearSegmentedColormap:
    """Map of deviations from what is wanted: near black (0) over slate and sand to almost white (1)."""
    return _uniform("geoweave-shade", ["#1b1e24", "#4c515b", "#b7ab97", "#fbf6ea"])


@cache
def cyclic() -> LinearSegmentedColormap:
    """Map of angles that ends where it starts: sand (0), teal, slate (half a turn), mallow and back."""
    return _uniform("geoweave-wheel", ["#f3ead8", "#5fa3a3", "#2c4460", "#a4597c", "#f3ead8"])


def darker(colour: str, share: float = 0.45) -> str:
    """Mix a colour with so much black, in Oklab."""
    lab = _to_oklab(np.array(to_rgb(colour))[None])
    return str(to_hex(np.clip(_from_oklab(lab * (1.0 - share)), 0.0, 1.0)[0]))


def scientific(value: float) -> str:
    """Write a number for a caption: 1e-8 as 10⁻⁸, 2.5e-6 as 2.5 · 10⁻⁶; 0.01 to 99,999 plainly."""
    if value == 0 or 0.01 <= abs(value) < 1e5:
        return f"{value:,g}"
    digits, power = f"{value:.2e}".split("e")
    raised = "10" + str(int(power)).translate(SUPERSCRIPTS)
    return raised if float(digits) == 1 else f"{float(digits):g} · {raised}"


def _uniform(name: str, stops: Sequence[str]) -> LinearSegmentedColormap:
    """Join colours by straight lines in Oklab, at constant speed there."""
    corners = _to_oklab(np.array([to_rgb(stop) for stop in stops]))
    along = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(corners, axis=0), axis=1))])
    at = np.linspace(0.0, along[-1], 256)
    path = np.stack([np.interp(at, along, corners[:, k]) for k in range(3)], axis=1)
    return LinearSegmentedColormap.from_list(name, np.clip(_from_oklab(path), 0.0, 1.0), N=256)


# Björn Ottosson's Oklab (2020): linear sRGB -> cone response -> cube root -> lightness and two hues.
_CONES = np.array(
    [
        [0.4122214708, 0.5363325363, 0.0514459929],
        [0.2119034982, 0.6806995451, 0.1073969566],
        [0.0883024619, 0.2817188376, 0.6299787005],
    ]
)
_LAB = np.array(
    [
        [0.2104542553, 0.7936177850, -0.0040720468],
        [1.9779984951, -2.4285922050, 0.4505937099],
        [0.0259040371, 0.7827717662, -0.8086757660],
    ]
)


def _to_oklab(rgb: NDArray[np.float64]) -> NDArray[np.float64]:
    linear = np.where(rgb <= 0.04045, rgb / 12.92, ((rgb + 0.055) / 1.055) ** 2.4)
    return np.asarray(np.cbrt(linear @ _CONES.T) @ _LAB.T)


def _from_oklab(lab: NDArray[np.float64]) -> NDArray[np.float64]:
    linear = (lab @ np.linalg.inv(_LAB).T) ** 3 @ np.linalg.inv(_CONES).T
    linear = np.clip(linear, 0.0, None)
    return np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055)
