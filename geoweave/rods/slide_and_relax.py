"""Fine-tuning a weave by sliding, and relaxing it to the shape it will take (Appendices E.1 and E.2)."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
from numpy.typing import ArrayLike

from geoweave.arrays import Flags, Indices, Scalars
from geoweave.errors import RodError
from geoweave.rods import hessian
from geoweave.rods.contact_energies import ORIENTATION, contact_orientation, contact_position, contact_side
from geoweave.rods.contact_order import crossing_sines, gaps_of, positions
from geoweave.rods.contact_places import chosen, outermost, replaced_contacts
from geoweave.rods.elastic_energies import Term, elastic_terms, sliding
from geoweave.rods.equilibrium import Equilibrium, Step, Stepping, minimized
from geoweave.rods.rods import DERIVED, Rods
from geoweave.surface import TriMesh, closest_points, smooth_normals, triangle_tree

__all__ = ["ROUNDS", "Springs", "relax_rods", "relaxing_terms", "slide_rods"]


@dataclass(frozen=True)
class Springs:
    """The stiffnesses of Appendix E; the defaults are the paper's, for models of bounding radius 1.

    Attributes
    ----------
    normal : kappa_n, which holds vertices on the surface while they slide, force / length
    tangential : kappa_t, which limits how far they slide in one round, force / length
    position : gamma_pos, which holds the two ribbons of a contact together, force / length
    orientation : gamma_orient, which holds them flush, force x length / radian^2

    Raises
    ------
    RodError
        If a stiffness is not positive.

    Examples
    --------
    >>> gw.rods.Springs(position=1e4).tangential
    1.0
    """

    normal: float = 1e3
    tangential: float = 1.0
    position: float = 1e3
    orientation: float = 1e6

    def __post_init__(self) -> None:
        for name in ("normal", "tangential", "position", "orientation"):
            value = getattr(self, name)
            if not (np.isfinite(value) and value > 0):
                raise RodError(f"the stiffness '{name}' is {value:g}; give a positive number")


ROUNDS = 3
"""Rounds of sliding. Each minimises energies once and then projects vertices onto the surface."""

SLID = 1e-3
"""Default tolerance of sliding. Its result is only where relaxing starts, so it can be rough."""

ROUGHLY = 1e-2
"""Tolerance of all rounds of sliding but the last."""

LEAST_GAIN = 1e-4
"""All rounds but the last end too when a step lowers the energy by less than this share of it."""

STILL = 1e-3
"""When no vertex moved by more than this share of a segment, one more round of sliding is the last."""

SOFT = 10.0
"""The first, softer stiffness that holds sections flush, in edgewise stiffnesses of a segment (B / l)."""

ROOM = 0.5
"""While ribbons slide, contacts keep at least this share of the distance between them along their rods."""

STANDING = 0.1
"""A segment stands on the surface if the normal, less its part along the segment, is shorter than this."""


def slide_rods(
    rods: Rods,
    surface: TriMesh,
    *,
    springs: Springs | None = None,
    rounds: int = ROUNDS,
    stepping: Stepping | None = None,
    fixed: ArrayLike | None = None,
    callback: Callable[[Step], None] | None = None,
) -> Equilibrium:
    """Let ribbons slide on a surface to release elastic strain (E.1).

    Each round minimises the elastic energy and the energy of springs between vertices and their anchors on
    the surface. Then the vertices are projected onto the surface, which gives new anchors, and contacts are
    moved to where ribbons now cross. With many rounds open ribbons drift to where the surface is flat, so
    the number of rounds is a parameter.

    Three things are not in the paper (DEVIATIONS, sliding and order). The first and the last contact of an
    open ribbon hold; otherwise its ends slip off the ribbons on which they end. A contact that would pass its
    neighbour on a ribbon, or come nearer than `ROOM`, holds too: the round is repeated from its start with
    these contacts held, until none is left, so the order of contacts along every ribbon stays. Sections turn
    freely while ribbons slide, and some turn onto their edge; at the end all are laid flush on the surface
    again.

    Parameters
    ----------
    rods : on or near the surface
    surface : in the same place and size
    springs : stiffnesses
    rounds : no more rounds than this
    stepping : numbers of each minimisation; a tolerance of 1e-3 if not given
    fixed : (V,) vertices that do not move
    callback : called with every `Step` of every round

    Returns
    -------
    Equilibrium
        Of the last round; its steps are those of all rounds, the repeated ones too.

    Raises
    ------
    RodError
        If a parameter is out of range.

    Examples
    --------
    >>> surface = gw.shapes.cone(faces=400).normalized()[0]
    >>> rods = gw.elastic_rods(gw.weave_pattern(surface, ribbons=8)).rods
    >>> gw.rods.slide_rods(rods, surface).converged
    True
    """
    if rounds < 1:
        raise RodError(f"sliding takes one round or more, not {rounds}")
    numbers = stepping or Stepping(tolerance=SLID)
    rough = replace(
        numbers, tolerance=max(numbers.tolerance, ROUGHLY), least_gain=max(numbers.least_gain, LEAST_GAIN)
    )
    way = _Sliding(rods, surface, springs or Springs(), _held(rods, fixed), callback)
    current, holding = rods, outermost(rods)
    steps: list[Step] = []
    left = rounds
    while left:
        left -= 1
        found, holding = way.round(current, rough if left else numbers, holding)
        steps.extend(found.steps)
        moved = np.linalg.norm(found.rods.points - current.points, axis=1).max()
        current = found.rods
        if moved <= STILL * float(current.rest.mean()):
            left = min(left, 1)
    return replace(found, rods=way.laid(current), steps=tuple(steps))


class _Sliding:
    """What all rounds of sliding share: the surface, the energies, the order of contacts."""

    def __init__(
        self,
        rods: Rods,
        surface: TriMesh,
        springs: Springs,
        held: Flags,
        callback: Callable[[Step], None] | None,
    ) -> None:
        self.surface, self.tree = surface, triangle_tree(surface.vertices[surface.faces])
        self.elastic, self.springs, self.held = elastic_terms(rods.layout), springs, held.copy()
        self.order, self.sides = gaps_of(rods), crossing_sines(rods) >= 0
        self.callback = callback

    def round(self, start: Rods, stepping: Stepping, holding: Flags) -> tuple[Equilibrium, Flags]:
        """Slide once; repeat it, holding the contacts that lost their order, until none does.

        A contact that holds keeps its places, but at a free end its segments may still turn until their angle
        has the other sign. Then their vertices do not move any more. Every repetition holds more contacts or
        more vertices, so this ends.
        """
        anchors, faces = closest_points(self.tree, start.points)
        normals, stiff = self.surface.face_normals[faces], self.springs
        spring = sliding(start.layout, anchors, normals, stiff.normal, stiff.tangential)
        steps: list[Step] = []
        while True:
            met = chosen(start.contacts, holding)
            hold = contact_position(replace(start, contacts=met), stiff.position, 0.0)
            found = minimized(
                start,
                (*self.elastic, spring, *([hold] if len(met) else [])),
                stepping=stepping,
                fixed=self.held,
                anchored=True,
                callback=self.callback,
            )
            steps.extend(found.steps)
            rods = replace(found.rods, contacts=replaced_contacts(found.rods, holding))
            over = self.turned(rods)
            lost = (self.tight(rods) | over) & ~holding
            still = _unknowns(start, start.contacts.segments[over & holding].ravel())
            if not lost.any() and self.held[still].all():
                return replace(found, rods=rods, steps=tuple(steps)), holding
            self.held[still] = True
            holding = holding | lost

    def tight(self, rods: Rods) -> Flags:
        """(C,) contacts that came too near to a neighbour or passed it."""
        order = self.order
        tight = order.moved(positions(rods)) < ROOM * order.lengths
        flags = np.zeros(len(rods.contacts), dtype=bool)
        flags[order.before[tight] // 2] = flags[order.after[tight] // 2] = True
        return flags

    def turned(self, rods: Rods) -> Flags:
        """(C,) contacts whose angle has another sign than in the design."""
        return np.asarray((crossing_sines(self.laid(rods)) >= 0) != self.sides)

    def laid(self, rods: Rods) -> Rods:
        """Turn thickness directions to the surface's normals below their segments."""
        middle = rods.points[rods.layout.ends].mean(axis=1)
        normals = smooth_normals(self.surface, *closest_points(self.tree, middle))
        aside = normals - (normals * rods.tangents).sum(axis=1)[:, None] * rods.tangents
        size = np.linalg.norm(aside, axis=1)[:, None]
        # A segment that stands on the surface keeps its thickness direction.
        directors = np.where(size > STANDING, aside / np.maximum(size, STANDING), rods.directors)
        return replace(rods, directors=directors, twists=DERIVED)


def relaxing_terms(rods: Rods, springs: Springs | None = None) -> tuple[Term, ...]:
    """Return the energies of a weave left to itself (Eq. 10): elastic ones and contacts."""
    stiff = springs or Springs()
    terms = elastic_terms(rods.layout)
    if not len(rods.contacts):
        return terms
    return (
        *terms,
        contact_position(rods, stiff.position),
        contact_orientation(rods, stiff.orientation),
        contact_side(rods, _edgewise(rods)),
    )


def _edgewise(rods: Rods) -> float:
    """Mean edgewise stiffness of a segment, B / l, force x length."""
    return float((rods.material.edgewise(rods.widths) / rods.rest).mean())


def relax_rods(
    rods: Rods,
    *,
    springs: Springs | None = None,
    stepping: Stepping | None = None,
    fixed: ArrayLike | None = None,
    gravity: ArrayLike | None = None,
    callback: Callable[[Step], None] | None = None,
) -> Equilibrium:
    """Find the shape that rods take when nothing holds them to a surface (E.2).

    With contacts as stiff as asked for, steps from a distant start are very short. So a first minimisation
    holds sections flush with a softer stiffness (`SOFT`), and a second one with that asked for (DEVIATIONS,
    rod-steps).

    Parameters
    ----------
    rods : the start
    springs : stiffnesses of the contacts
    stepping : numbers of each of the two minimisations
    fixed : (V,) vertices that do not move: a rigid boundary, or the feet it stands on. A segment whose two
        vertices are fixed is clamped, it does not turn either
    gravity : (3,) acceleration, length / time^2, in the units of the material's density
    callback : called with every `Step`

    Raises
    ------
    RodError
        If there is gravity but nothing fixed: the constraint on the centre of mass would balance it.

    Examples
    --------
    >>> rods = gw.elastic_rods(gw.weave_pattern(gw.shapes.cone(faces=400), ribbons=8)).rods
    >>> gw.rods.relax_rods(rods).energies["geodesic curvature"] < 1.0
    True
    """
    held = _held(rods, fixed)
    load = None
    if gravity is not None and np.any(np.asarray(gravity) != 0):
        pull = np.asarray(gravity, dtype=np.float64)
        if pull.shape != (3,) or not np.isfinite(pull).all():
            raise RodError(f"gravity is three finite numbers, not {gravity}")
        if not held.any():
            raise RodError(
                "nothing holds the weave against gravity, and its centre of mass is kept where it is; "
                "fix the vertices it stands on"
            )
        load = vertex_masses(rods)[:, None] * pull
    stiff, numbers = springs or Springs(), stepping or Stepping()
    terms = relaxing_terms(rods, stiff)
    pattern = hessian.analysed(rods.size, terms, held)
    soft = replace(stiff, orientation=min(SOFT * _edgewise(rods), stiff.orientation))
    harder = stiff.orientation / soft.orientation
    stages = [(terms, 1.0)]
    if len(rods.contacts) and harder > 1:
        stages.insert(0, (relaxing_terms(rods, soft), harder))
    steps: list[Step] = []

    def told(step: Step, harder: float) -> None:
        """Number the steps of both minimisations; give energies for the stiffness that was asked for."""
        energies = step.energies | {k: harder * e for k, e in step.energies.items() if k == ORIENTATION}
        steps.append(replace(step, number=len(steps), energies=energies, rods=None))
        if callback is not None:
            callback(replace(steps[-1], rods=step.rods))

    for energies, factor in stages:
        found = minimized(
            rods,
            energies,
            stepping=numbers,
            fixed=held,
            load=load,
            pattern=pattern,
            callback=partial(told, harder=factor),
        )
        rods = found.rods
    return replace(found, steps=tuple(steps))


def vertex_masses(rods: Rods) -> Scalars:
    """(V,) mass of each vertex, half of each segment it ends: ``density w h l``."""
    mass = rods.material.density * rods.material.thickness * rods.widths * rods.rest
    return np.bincount(
        rods.layout.ends.ravel(), np.repeat(0.5 * mass, 2), minlength=rods.layout.vertices
    ).astype(np.float64)


def _unknowns(rods: Rods, segments: Indices) -> Indices:
    """Coordinates of both vertices of segments, among the unknowns of `_held`."""
    return np.asarray((3 * rods.layout.ends[segments].reshape(-1, 1) + np.arange(3)).ravel())


def _held(rods: Rods, fixed: ArrayLike | None) -> Flags:
    """(3 V + S,) unknowns that do not change: fixed vertices, and angles of segments between two of them."""
    layout = rods.layout
    still = np.zeros(layout.vertices, dtype=bool) if fixed is None else np.asarray(fixed)
    if still.dtype != bool or still.shape != (layout.vertices,):
        raise RodError(f"fixed vertices are {layout.vertices} flags, not {still.dtype} {still.shape}")
    return np.concatenate([np.repeat(still, 3), still[layout.ends].all(axis=1)])
