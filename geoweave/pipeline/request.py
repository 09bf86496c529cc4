"""What a weave is to be like, and which files are to be written of it."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal, cast

from geoweave.errors import FieldError
from geoweave.pipeline.weave_folder import check_formats

if TYPE_CHECKING:
    from geoweave.rods import StripKind
    from geoweave.surface import MirrorAxis
    from geoweave.weave import Edits, Phase, Singularity, WeaveType

__all__ = ["BOUNDS", "WeaveRequest", "formats_of"]

BOUNDS = {"symmetry": 24, "ribbons": 100_000, "scale": 1e4, "size": 1e6, "width": 1e6, "thickness": 1e6}
"""The largest numbers that can be asked for: far beyond what is woven, and short of what ends in overflow."""


@dataclass(frozen=True)
class WeaveRequest:
    """What a weave is to be like, and which files are to be written of it.

    Raises
    ------
    FieldError
        If ``ribbons`` and ``scale`` are both given, a number is not positive or out of reach, or there is no
        such phase or pattern for the symmetry.

    Examples
    --------
    >>> gw.WeaveRequest(ribbons=40, size=300.0).symmetry
    6
    >>> gw.WeaveRequest(pattern="twill").symmetry
    4
    >>> gw.WeaveRequest(ribbons=40, scale=2.0)
    Traceback (most recent call last):
    geoweave.errors.FieldError: ribbons and scale exclude each other; give one of them
    """

    symmetry: int = cast("int", None)
    """Vectors of the RoSy per face: 6 gives a triaxial weave, 4 two families. If not given, 4 with a pattern
    of two families, else 6."""
    pattern: WeaveType | None = None
    """"kagome", the default with symmetry 6; "plain", the default otherwise; "twill" or "basket"."""
    phase: Phase | None = None
    """"regular" for triangles and hexagons, no three ribbons near a point, the default for symmetry 6; "free"
    for families that lie as they happen to."""
    ribbons: int | None = None
    """How many ribbons; the nearest number that a search meets."""
    scale: float | None = None
    """Factor on the number of level sets, in place of ``ribbons``; 1 if neither is given."""
    size: float | None = None
    """Longest side of the bounding box in mm; None keeps the unit of the mesh."""
    width: float | None = None
    """Width of a ribbon, in mm with a size, else in the unit of the mesh."""
    thickness: float | None = None
    """Thickness of a ribbon, in the same unit; a twentieth of the width if not given."""
    formats: tuple[str, ...] | None = None
    """What to write. None: json; with a size also the guide, if the weave allows one."""
    relax: bool = True
    """Whether the weave is relaxed to the shape that it takes (Appendix E)."""
    strips: StripKind = "straight"
    """How strips are cut: "straight" as in the paper, or one of the other `geoweave.rods.STRIPS`."""
    singularities: tuple[Singularity, ...] | None = None
    """All singularities, as `geoweave.weave.read_singularities` reads them; None leaves them free."""
    align: tuple[tuple[float, float, float], ...] | None = None
    """A direction, or points of a curve, that one family follows softly (`geoweave.weave.read_guide`)."""
    merge: float = 0.0
    """Pairs of singularities of opposite index no farther apart than so many spacings are merged."""
    edits: tuple[Edits, ...] = ()
    """What a person changed, one after the other (`geoweave.weave.read_edits`)."""
    symmetric: MirrorAxis | Literal["off"] = "off"
    """"auto" makes the field its own image in the mirror plane of the surface, "x", "y" or "z" in one across
    that axis."""
    up: str | None = None
    """The axis that is up: x, y, z, -x, -y or -z; found (`geoweave.pipeline.up_in_report`) if not given."""

    def __post_init__(self) -> None:
        """Refuse what contradicts itself."""
        if self.ribbons is not None and self.scale is not None:
            raise FieldError("ribbons and scale exclude each other; give one of them")
        from geoweave.rods import STRIPS
        from geoweave.weave import weave_type_of

        object.__setattr__(self, "symmetry", weave_type_of(self.symmetry, self.pattern)[0])
        if self.strips not in STRIPS:
            raise FieldError(f"there are no '{self.strips}' strips; cut them {', '.join(STRIPS)}")
        if self.strips != "straight" and not self.relax:
            raise FieldError(
                f"{self.strips} strips are those of a weave at rest; leave out --no-relax, or cut straight"
            )
        for name, most in BOUNDS.items():
            value = getattr(self, name)
            if value is None:
                continue
            if not (math.isfinite(value) and value > 0):
                raise FieldError(f"{name} is {value}; give a positive number")
            if value > most:
                raise FieldError(f"{name} is {value:g}; give at most {most:g}")
        if not 0 <= self.merge <= BOUNDS["scale"]:
            raise FieldError(
                f"merge is {self.merge:g}; give a number of spacings from 0 to {BOUNDS['scale']:g}"
            )
        if self.symmetric != "off":
            from geoweave.weave import Steering

            Steering(self.singularities, symmetric=self.symmetric)
        if self.up is not None:
            from geoweave.fabrication import check_axis

            check_axis(self.up)
        if self.phase is not None:
            from geoweave.weave import phase_of

            phase_of(self.symmetry, self.phase)
        if self.width is not None and self.thickness is not None and self.thickness > self.width:
            raise FieldError(
                f"a ribbon {self.width:g} wide cannot be {self.thickness:g} thick; make it thinner than wide"
            )
        if self.size is not None:
            self.check_widths(self.size)

    def check_widths(self, longest: float) -> None:
        """Refuse ribbons that are wider or thicker than the object is long.

        Parameters
        ----------
        longest : longest side of its bounding box, in the unit of the width
        """
        for name in ("width", "thickness"):
            value = getattr(self, name)
            if value is not None and value >= longest:
                raise FieldError(
                    f"the {name} of a ribbon is {value:g}, and the object {longest:g} long; give less"
                )

    @property
    def formats_wanted(self) -> tuple[str, ...]:
        """Names of the formats to be written, also where none were asked for."""
        if self.formats is not None:
            return self.formats
        return ("json",) if self.size is None else ("json", "guide")


def formats_of(names: Iterable[str], size: float | None) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Part names of formats into those of a pattern and those of a weave.

    Parameters
    ----------
    names : such as "json", "rod", "svg"
    size : of the object in mm, which a pattern needs

    Returns
    -------
    The formats of the pattern (`geoweave.fabrication.FORMATS`), and those of the weave (``json``, ``rod``).

    Raises
    ------
    OutputError
        If there is no such format.
    FieldError
        If one of a pattern is asked for without a size.
    """
    from geoweave.fabrication import FORMATS, check_formats as check_pattern_formats

    asked = tuple(names)
    cut = check_pattern_formats(name for name in asked if name in FORMATS)
    rest = check_formats((name for name in asked if name not in cut), FORMATS)
    if cut and size is None:
        raise FieldError(f"a pattern ({', '.join(cut)}) is in mm; give the object a size")
    return cut, rest
