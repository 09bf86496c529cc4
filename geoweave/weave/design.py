"""From a surface to a weave: cover, foliation, ribbons, crossings, over and under (Sections 5.1 and 5.2)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from geoweave.arrays import Indices, Scalars, frozen
from geoweave.errors import FieldError
from geoweave.fields import INTEGRABLE_END, FaceField, geodesic_field, sharpening_schedule
from geoweave.foliation import (
    LEAST_FIRST,
    Foliation,
    foliate,
    global_scale,
    integrating_factor,
    isolines,
    punctured,
    vertices_and_faces,
)
from geoweave.sparse import Ordering
from geoweave.surface import Similarity, TriMesh
from geoweave.weave import interlacing
from geoweave.weave.as_asked import Met
from geoweave.weave.cover import Cover, Leaves, branched_cover, family_count
from geoweave.weave.matched_ends import with_matched_ends
from geoweave.weave.phase import Phase, phase_of
from geoweave.weave.ribbon_count import TRIES, check_asked, nearest_scale
from geoweave.weave.ribbons import Cutting, Ribbons, expected_number, ribbons
from geoweave.weave.stages import Callback, Stages
from geoweave.weave.steering import Steering, steered_rosy, steering_for, steering_met
from geoweave.weave.weave import THINNESS, Design, Weave, default_width
from geoweave.weave.weave_types import WeaveType, weave_type_of

__all__ = ["MOST_CROSSINGS", "WeaveField", "weave_curves", "weave_field", "weave_pattern"]

MOST_CROSSINGS = 200_000
"""A weave that would have more is refused: it is a slip of the scale, and its proof would not end."""

LEVEL = 0.5 * np.pi + 1e-4
"""Level set on every sheet, beside pi / 2 (DEVIATIONS.md, level); theta is odd on antipodal sheets."""

EVENNESS = 1e-3
"""Smoothness mu of s in squared bounding radii, ten times that of a single foliation.

Ribbons are further apart than leaves, and a maker wants them even (DEVIATIONS.md, evenness).
"""


class _Made(NamedTuple):
    """What one scale gives, before over and under."""

    scale: float
    foliation: Foliation
    ribbons: Ribbons
    families: Indices
    leaves: Leaves


@dataclass(frozen=True, eq=False)
class WeaveField:
    """The geodesic field on the branched cover that the weaves of a surface share, whatever their scale.

    Attributes
    ----------
    mesh : the surface, at bounding radius 1
    placement : how it got there from the position and size it was given in
    symmetry : N of the RoSy
    phase : "regular" or "free"
    seed : of the RoSy and of the first eigenvector
    branch_points : vertices of the surface at which families are permuted
    cover : the N sheets
    field : the geodesic field, on half of the cover for even N
    factor : the first integrating factor on what puncturing leaves of that, area mean 1
    frequency : how fast theta will turn at scale 1, area mean, radians / length
    ordering : of the systems that `foliate` solves, the same at every scale
    seconds : wall-clock seconds of each stage
    met : how far the field is what the steering asked for
    """

    mesh: TriMesh
    placement: Similarity
    symmetry: int
    phase: Phase
    seed: int
    branch_points: Indices
    cover: Cover
    field: FaceField
    factor: Scalars
    frequency: float
    ordering: Ordering
    seconds: dict[str, float]
    met: Met | None = None

    @property
    def families(self) -> int:
        """Families of ribbons."""
        return family_count(self.symmetry)

    def expected_crossings(self, scale: float) -> float:
        """Crossings of evenly spaced families at a scale, ``n (n - 1) / 2 A / d^2``, d the spacing."""
        pairs = 0.5 * self.families * (self.families - 1)
        return float(pairs * self.mesh.face_areas.sum() * (scale * self.frequency / np.pi) ** 2)

    def pattern(
        self,
        *,
        scale: float | None = None,
        ribbons: int | None = None,
        cutting: Cutting | None = None,
        pattern: WeaveType | None = None,
        effort: int = interlacing.EFFORT,
        tries: int = TRIES,
        callback: Callback | None = None,
    ) -> Weave:
        """Design a weave of this field; see `weave_pattern`."""
        check_asked(scale, ribbons)
        meant = weave_type_of(self.symmetry, pattern)[1]
        stages = Stages(callback, self.seconds)
        tried: tuple[tuple[float, int], ...] = ()
        if ribbons is None:
            made = self._made(1.0 if scale is None else scale, cutting, stages)
        else:
            made, tried = self._nearest(ribbons, cutting, tries, stages)
        stages.begin("interlacing")
        design = Design(
            symmetry=self.symmetry,
            branch_points=self.branch_points,
            foliation=made.foliation,
            scale=made.scale,
            tried=tried,
            seconds=stages.seconds,
            met=self.met,
            numerators=self.cover.rosy.index_numerators,
        )
        weave = _interlaced(made.ribbons, made.families, design, self.placement, effort, meant)
        stages.begin("")
        return weave

    def _made(self, scale: float, cutting: Cutting | None, stages: Stages, more: str = "") -> _Made:
        """Go from the field to ribbons and crossings."""
        expected = self.expected_crossings(scale)
        if expected > MOST_CROSSINGS:
            raise FieldError(
                f"the weave would have about {expected:,.0f} crossings, more than {MOST_CROSSINGS:,}; "
                "ask for a smaller scale"
            )
        stages.begin("foliation", more)
        # Every scale starts from the same factor, so that a scale gives the same weave whoever asks for it.
        foliation = foliate(
            self.field,
            scale=scale,
            rescaling=self.factor,
            quantile=1.0,
            smoothness=EVENNESS,
            seed=self.seed,
            ordering=self.ordering,
            triples=self.cover.quotient.triples if self.phase == "regular" else None,
        )
        stages.begin("ribbons", more)
        leaves = self.cover.project(isolines(self.cover.quotient.lifted(foliation), [LEVEL]))
        found = ribbons(leaves, self.families, cutting)
        return _Made(scale, foliation, found, frozen(leaves.families[found.origin]), leaves)

    def _nearest(
        self, wanted: int, cutting: Cutting | None, tries: int, stages: Stages
    ) -> tuple[_Made, tuple[tuple[float, int], ...]]:
        """Search for the scale that gives so many ribbons."""
        numbers = cutting or Cutting()
        best: _Made | None = None

        def count(scale: float) -> int:
            nonlocal best
            expected = self.expected_crossings(scale)
            if expected > MOST_CROSSINGS:
                raise FieldError(
                    f"a weave of {wanted:,} ribbons would have about {expected:,.0f} crossings, more than "
                    f"{MOST_CROSSINGS:,}; ask for fewer ribbons"
                )
            try:
                made = self._made(scale, numbers, stages, f" at scale {scale:g}")
            except FieldError:  # nothing is left: the scale is too small
                return 0
            # Only the nearest is kept, by the rule of the search.
            misses = [(abs(len(each.ribbons) - wanted), len(each.ribbons)) for each in (best, made) if each]
            if len(misses) == 1 or misses[1] < misses[0]:
                best = made
            return len(made.ribbons)

        def expected(scale: float) -> float:
            assert best is not None  # nothing is expected before a try has counted something
            return expected_number(best.leaves, self.families, numbers, scale / best.scale)

        search = nearest_scale(count, wanted, tries=tries, expected=expected)
        assert best is not None  # or the search would have raised
        return best, search.tried


def weave_field(
    mesh: TriMesh,
    *,
    symmetry: int = 6,
    phase: Phase | None = None,
    geodesic: bool = True,
    seed: int = 0,
    steering: Steering | None = None,
    callback: Callback | None = None,
) -> WeaveField:
    """Find the geodesic field that the weaves of a surface share (Section 5.1).

    Smoothest RoSy, branched cover, Algorithm 1 on it, and the first integrating factor.

    Parameters
    ----------
    mesh : the surface, anywhere and of any size
    symmetry : N, 3 or more; 6 for a triaxial weave
    phase : "regular", the default for N = 6, where three families are to form triangles and hexagons, no
        three ribbons near a point; or "free", as in the paper
    geodesic : if false, the smoothest RoSy is left as it is, which Fig. 23 compares with
    seed : of the RoSy and of the first eigenvector
    steering : what is asked of the singularities of the RoSy
    callback : called with the name of each stage as it begins

    Raises
    ------
    FieldError
        If the symmetry is less than 3, 3 does not divide it and the phase is to be regular, or prescribed
        singularities do not fit the surface.

    Examples
    --------
    >>> import geoweave as gw
    >>> field = gw.weave_field(gw.shapes.torus(faces=600))
    >>> field.expected_crossings(1.0) / field.expected_crossings(0.5)
    4.0
    """
    chosen = phase_of(symmetry, phase)
    stages = Stages(callback, {})
    stages.begin("rosy")
    surface, placement = mesh.normalized()
    wanted = steering or Steering()
    rosy = steered_rosy(surface, placement, symmetry, seed, wanted)
    stages.begin("cover")
    cover = branched_cover(rosy)
    quotient = cover.quotient
    stages.begin("field")
    field = quotient.field
    if geodesic:
        schedule = sharpening_schedule(quotient.mesh, finest=INTEGRABLE_END)
        together = quotient.triples if chosen == "regular" else None
        field = geodesic_field(field, smoothness=schedule, triples=together, eta=wanted.eta).field
    stages.begin("foliation", ": first factor")
    w, part = punctured(field)
    places = quotient.triples.on(part).places if chosen == "regular" else None
    ordering = vertices_and_faces(w.mesh, places)
    factor = integrating_factor(w, smoothness=EVENNESS, ordering=ordering).s
    factor = frozen(np.maximum(factor, LEAST_FIRST * float(np.median(factor))))
    turning = global_scale(w, factor) * factor
    stages.begin("")
    return WeaveField(
        surface,
        placement,
        symmetry,
        chosen,
        seed,
        frozen(rosy.branch_points),
        cover,
        field,
        factor,
        float(np.average(turning, weights=w.mesh.face_areas)),
        ordering,
        stages.seconds,
        steering_met(cover, field, placement, wanted),
    )


def weave_pattern(
    mesh: TriMesh,
    *,
    symmetry: int | None = None,
    phase: Phase | None = None,
    scale: float | None = None,
    ribbons: int | None = None,
    seed: int = 0,
    steering: Steering | None = None,
    cutting: Cutting | None = None,
    pattern: WeaveType | None = None,
    effort: int = interlacing.EFFORT,
    tries: int = TRIES,
    callback: Callback | None = None,
) -> Weave:
    """Design a weave of a surface, up to the point where physics begins (Section 5.2).

    Smoothest RoSy, branched cover, geodesic field, s and theta on one of each two antipodal sheets, level
    sets, ribbons, crossings, over and under. The frequency is the paper's, half a turn on the steepest edge
    (footnote 4), times a scale. For several weaves of one surface take `weave_field` once, then its
    `pattern`.

    Parameters
    ----------
    mesh : the surface, anywhere and of any size
    symmetry : N, 3 or more; 6, the default, for a triaxial weave, 4 for two families
    phase : "regular", the default for N = 6, or "free"; see `weave_field`
    scale : factor on the number of ribbons; 1 if nothing is asked for
    ribbons : how many ribbons there should be, in place of a scale: the nearest that `nearest_scale` meets.
        The weave says its scale, and asking for that scale gives the same weave
    seed : of the RoSy and of the first eigenvector
    steering : what is asked of the singularities
    cutting : the numbers of the clean-up of the ribbons
    pattern : "kagome", the default for N = 6; "plain", the default otherwise; "twill" or "basket", of two
        families, so that N is 4 without being given
    effort : counted steps after which the proof ends that no choice of over and under alternates more often,
        see `geoweave.weave.best_labels`; the best found then stays
    tries : how many scales are tried at most for a number of ribbons
    callback : called with the name of each stage as it begins

    Raises
    ------
    FieldError
        If a parameter is out of range, both a scale and a number of ribbons are given, or nothing of the
        level sets is long enough.

    Examples
    --------
    >>> import geoweave as gw
    >>> weave = gw.weave_pattern(gw.shapes.torus(faces=600), scale=0.5)
    >>> weave.interlacing.alternation > 0.8, gw.weave.violations(weave.ribbons)
    (True, [])
    """
    check_asked(scale, ribbons)
    symmetry, pattern = weave_type_of(symmetry, pattern)
    steering = steering_for(mesh, family_count(symmetry), scale, ribbons, steering)
    field = weave_field(mesh, symmetry=symmetry, phase=phase, seed=seed, steering=steering, callback=callback)
    return field.pattern(
        scale=scale, ribbons=ribbons, cutting=cutting, pattern=pattern, effort=effort, tries=tries,
        callback=callback,
    )  # fmt: skip


def weave_curves(
    leaves: Leaves,
    *,
    cutting: Cutting | None = None,
    pattern: WeaveType | None = None,
    effort: int = interlacing.EFFORT,
) -> Weave:
    """Weave level sets that were projected from a branched cover: ribbons, crossings, over and under.

    This is the end of Section 5.2: `weave_pattern` does the same with the level sets that it finds.

    Parameters
    ----------
    leaves : what `Cover.project` returns
    cutting : the numbers of the clean-up of the ribbons
    pattern, effort : as for `weave_pattern`

    Raises
    ------
    FieldError
        If no level set is long enough.

    Examples
    --------
    >>> import geoweave as gw
    >>> cover = gw.branched_cover(gw.smoothest_rosy(gw.shapes.torus(faces=600), degree=6))
    >>> half = cover.quotient                                # one of each two opposite sheets
    >>> foliation = gw.foliate(gw.geodesic_field(half.field).field, scale=0.5)
    >>> leaves = cover.project(gw.isolines(half.lifted(foliation)))
    >>> weave = gw.weave_curves(leaves)
    >>> sorted(set(weave.families.tolist())), weave.ribbons.loose.any()
    ([0, 1, 2], np.False_)
    """
    rosy = leaves.cover.rosy
    meant = weave_type_of(rosy.degree, pattern)[1]
    found = ribbons(leaves, family_count(rosy.degree), cutting)
    design = Design(
        symmetry=rosy.degree, branch_points=frozen(rosy.branch_points), numerators=rosy.index_numerators
    )
    where = Similarity(np.zeros(3), 1.0)
    return _interlaced(found, frozen(leaves.families[found.origin]), design, where, effort, meant)


def _interlaced(
    found: Ribbons, families: Indices, design: Design, placement: Similarity, effort: int, meant: WeaveType
) -> Weave:
    """Choose over and under, and the width that is usual at this spacing."""
    width = default_width(found.spacing, design.symmetry)
    found, turns = with_matched_ends(found, effort, meant)
    return Weave(
        ribbons=found,
        families=families,
        interlacing=turns,
        width=width,
        thickness=width / THINNESS,
        design=design,
        placement=placement,
    )
