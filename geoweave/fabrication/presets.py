"""Materials and machines by name, with the numbers that go with them and where the numbers come from.

They are where to start; a maker cuts one strip, measures it, and gives the option that is off.
"""

from __future__ import annotations

from typing import Literal, NamedTuple

from geoweave.errors import FieldError

__all__ = ["LABELS", "PRESETS", "Labels", "Preset", "preset_of"]

Labels = Literal["engraved", "printed", "none"]
"""How names stand on strips: as lines of a tool, as letters of a printer, or not at all."""

LABELS: tuple[Labels, ...] = ("engraved", "printed", "none")


class Preset(NamedTuple):
    """A material and the machine that cuts it; lengths in mm."""

    says: str
    """What it is, for people."""
    thickness: float
    density: float
    """In g/cm3."""
    sheet: str | None
    """What SVG and DXF are laid out on (`stock_of`); None for one long sheet."""
    papers: tuple[str, ...]
    margin: float
    gap: float
    kerf: float
    overlap: float
    stock_length: float
    labels: Labels
    source: str
    """Where the numbers come from."""


PRESETS = {
    "edge-banding": Preset(
        "birch edge banding from a roll, cut by hand along a transfer print",
        0.5,
        0.65,
        "roll:22x50000",
        ("a4",),
        0.0,
        0.0,
        0.0,
        20.0,
        50_000.0,
        "engraved",
        "Section 5.4: the paper's bunny, 180 m of it, printed on transfer paper; sold 22 mm wide in rolls of "
        "50 m, 0.5 mm thick; birch 0.65 g/cm3",
    ),
    "bristol-a4": Preset(
        "Bristol board of 250 g/m2 on A4, printed and cut with a knife",
        0.3,
        0.83,
        "a4",
        ("a4",),
        12.0,
        1.5,
        0.0,
        12.0,
        273.0,
        "printed",
        "Section 5.4: the paper's icosahedron, box and torus are Bristol vellum, printed; 250 g/m2 at 0.3 mm",
    ),
    "veneer-laser": Preset(
        "wood veneer of 0.6 mm on sheets of 600 x 400 mm, laser",
        0.6,
        0.65,
        "600x400",
        ("a4",),
        5.0,
        1.0,
        0.15,
        15.0,
        590.0,
        "engraved",
        "kerf of birch plywood of 1/16 in: 0.006 in (laser504.com/kerfs-and-laser-thickness); lines 0.5 mm "
        "or more apart (cutlasercut.com, what is laser kerf); birch 0.65 g/cm3",
    ),
    "polypropylene-laser": Preset(
        "polypropylene of 0.6 mm on sheets of 600 x 400 mm, laser",
        0.6,
        0.905,
        "600x400",
        ("a4",),
        5.0,
        1.5,
        0.25,
        15.0,
        590.0,
        "engraved",
        "0.6 mm sheet, a kerf wider than in acrylic, and edges that melt together where lines are near "
        "(thelaserco.com, polypropylene; kerfs 0.08 to 0.45 mm: cutlasercut.com); 0.90 to 0.91 g/cm3",
    ),
    "cutting-mat": Preset(
        "card of 0.25 mm on the 12 x 12 inch mat of a hobby cutter",
        0.25,
        0.8,
        "12x12in",
        ("letter",),
        6.4,
        1.0,
        0.0,
        10.0,
        292.0,
        "engraved",
        "mats are 12 x 12 and 12 x 24 in, and machines cut 11.5 in of them: 0.25 in is left at each edge",
    ),
    "plotter-roll": Preset(
        "film of 0.3 mm from a roll 610 mm wide, drag knife",
        0.3,
        0.91,
        "roll:610x25000",
        ("a4",),
        15.0,
        1.0,
        0.0,
        15.0,
        25_000.0,
        "engraved",
        "24 in rolls of 25 m; the rollers of a plotter need 15 mm at each edge",
    ),
}
"""Materials and machines by name."""


def preset_of(name: str) -> Preset:
    """The preset of a name.

    Raises
    ------
    FieldError
        If there is none.

    Examples
    --------
    >>> gw.fabrication.preset_of("veneer-laser").kerf  # mm
    0.15
    >>> gw.fabrication.preset_of("granite")
    Traceback (most recent call last):
    geoweave.errors.FieldError: there is no preset 'granite'; the presets are edge-banding, bristol-a4, ...
    """
    if name not in PRESETS:
        raise FieldError(f"there is no preset '{name}'; the presets are {', '.join(PRESETS)}")
    return PRESETS[name]
