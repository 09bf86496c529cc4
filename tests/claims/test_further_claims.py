"""Sentences of Sections 4.2, 5 and the appendices that no other test measures, each on a small surface."""

from __future__ import annotations

from functools import cache

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.sparse.linalg import lsqr
from scipy.spatial import cKDTree

import geoweave as gw
from geoweave import comparisons
from geoweave.comparisons.mixed_integer import mixed_integer_parameterization
from geoweave.curves import Curves
from geoweave.fields import as_complex, as_real, curl, gradient, sharp


@cache
def bunny() -> gw.Foliation:
    """Level sets somewhat finer than the mesh carries well: some of them end."""
    mesh = gw.models.load("bunny")
    schedule = gw.sharpening_schedule(mesh, finest=gw.fields.INTEGRABLE_END)
    field = gw.geodesic_field(gw.smoothest_field(mesh), smoothness=schedule, phases=4).field
    return gw.foliate(field, scale=1.5)


def from_dislocations(points: np.ndarray) -> np.ndarray:
    """Distance of points from the nearest face that holds a dislocation, bounding radii."""
    mesh = bunny().part.mesh
    return cKDTree(mesh.barycenters[bunny().circle.dislocated]).query(points)[0] / mesh.bounding_radius


def test_curl_free_is_not_enough_round_a_hole() -> None:
    """Section 4.2.1: curl-free "and ... the global integrability condition ... for all generators".

    The gradient of the angle has no curl on an annulus and a period round its hole: no function has it, and
    none comes near. A field whose period is zero is a gradient.
    """
    ring = gw.shapes.annulus(0.35, 1.0, faces=600)
    x, y, _ = ring.vertices.T
    start, end = ring.edges.T
    angle = np.angle(np.exp(1j * (np.arctan2(y, x)[end] - np.arctan2(y, x)[start])))
    turning = sharp(ring) @ angle
    flat = as_real(as_complex(gradient(ring) @ np.sin(2 * x + y)))
    for field in (turning, flat):
        assert np.abs(curl(ring) @ field).max() < 1e-9 * np.abs(field).max()
    mass = np.repeat(np.sqrt(ring.face_areas), 2)
    left = [
        np.linalg.norm(
            lsqr(gradient(ring).multiply(mass[:, None]).tocsr(), mass * each, atol=1e-12, btol=1e-12)[3]
        )
        / np.linalg.norm(mass * each)
        for each in (turning, flat)
    ]
    assert left[0] > 0.99
    assert left[1] < 1e-6


def test_eq_7_degenerates_without_its_norm() -> None:
    """Section 4.2.3: the norm "is needed to prevent degeneration": the rest is invariant to scaling."""
    field, _ = gw.foliation.punctured(
        gw.geodesic_field(gw.smoothest_field(gw.shapes.sphere(faces=320))).field
    )
    found = gw.foliation.integrating_factor(field, method="eigenvector")
    mesh, s, v = field.mesh, found.s, found.integrable

    def parts(s: np.ndarray, v: np.ndarray) -> tuple[float, float, float]:
        delta = v - s * gw.foliation.perpendicular(field)
        broken = np.abs(curl(mesh) @ as_real(v)).max()
        return float(np.abs(delta) ** 2 @ mesh.face_areas), float(broken), float(s**2 @ mesh.face_areas)

    one, tenth = parts(s, v), parts(0.1 * s, 0.1 * v)
    assert max(one[1], tenth[1]) < 1e-9, "either is integrable"
    assert one[0] > 1e-4, "and has something to lose"
    assert np.isclose(tenth[0], 0.01 * one[0]), "so without the norm nothing is best"
    assert np.isclose(one[2], mesh.face_areas.sum(), rtol=0.5), "with it s is about 1"


def test_dislocations_sit_where_curves_diverge() -> None:
    """Section 4.2.5: PGP can "introduce edge dislocations in regions where integral curves diverge"."""
    mesh, field = bunny().part.mesh, bunny().field
    # The divergence of w is the curl of its quarter turn.
    spread = np.abs(gw.signed_curl(gw.FaceField(mesh, -1j * field.values)))
    away = from_dislocations(mesh.barycenters)
    assert bunny().circle.dislocated.sum() >= 5
    assert np.median(spread[away < 0.06]) > 3 * np.median(spread[away > 0.18])


def test_level_sets_bend_near_dislocations() -> None:
    """Section 5.2: isolines close to edge dislocations "may be highly non-geodesic at points"."""
    lines = gw.isolines(bunny())
    bends = np.abs(gw.geodesic_curvature(lines))
    away = from_dislocations(lines.points)
    assert bends[away < 0.05].mean() > 1.6 * bends[away > 0.15].mean()


def test_there_is_no_free_lunch_in_alpha() -> None:
    """Section 4.2.5: anisotropy aligns "at the cost of very poorly-spaced integral curves"."""
    torus = comparisons.geodesic_from(gw.models.load("torus"), "random", 0)
    field, _ = gw.foliation.punctured(torus)
    found = [
        gw.foliation.alignment(field, mixed_integer_parameterization(field, 18.0, anisotropy=alpha))
        for alpha in (1.0, 0.3, 0.1, 0.03)
    ]
    off, uneven = [each.median for each in found], [each.spacing_spread for each in found]
    assert off == sorted(off, reverse=True), "a smaller alpha follows the field more closely"
    assert uneven == sorted(uneven), "and spaces the curves less evenly"
    assert off[0] > 2 * off[-1]
    assert uneven[-1] > 2 * uneven[0]


def test_three_independent_foliations_have_no_weave_dislocation() -> None:
    """Section 5: "designing each family independently does not allow for ... dislocation singularities".

    Six vectors that go round with one field on the sphere keep their names: their cover falls into six
    spheres. Those of the smoothest 6-RoSy change names at twelve branch points: one cover.
    """
    ball = gw.shapes.sphere(faces=1280)
    alone = gw.smoothest_field(ball)
    independent = gw.branched_cover(gw.RoSyField(ball, 6, alone.normalized().values ** 6))
    woven = gw.branched_cover(gw.smoothest_rosy(ball, 6))
    assert independent.mesh.n_components == 6
    assert woven.mesh.n_components == 1
    assert woven.rosy.index_numerators[woven.rosy.branch_points].tolist() == [1] * 12


@cache
def ball() -> tuple[gw.weave.WeaveField, gw.Weave]:
    made = gw.weave_field(gw.shapes.sphere(faces=1500), phase="free")
    return made, made.pattern(scale=0.6)


@cache
def crown() -> tuple[gw.weave.WeaveField, gw.Weave]:
    """Sharp points and far too many branch points."""
    made = gw.weave_field(gw.shapes.crown(faces=3000).normalized()[0], phase="free")
    return made, made.pattern(scale=0.6)


def level_sets(made: gw.weave.WeaveField, weave: gw.Weave) -> Curves:
    """What is there before ribbons are cut, extended and trimmed."""
    return made.cover.project(gw.isolines(made.cover.quotient.lifted(weave.design.foliation)))


def parts(lines: Curves) -> int:
    """Into how many parts curves fall, those that cross belong together."""
    one, other = gw.crossings(lines).curves.T
    pairs = coo_array((np.ones(len(one)), (one, other)), shape=(len(lines), len(lines)))
    return int(connected_components(pairs, directed=False)[0])


def from_branch_points(weave: gw.Weave, points: np.ndarray) -> np.ndarray:
    """Distance of points from the nearest branch point, in spacings."""
    return cKDTree(weave.mesh.vertices[weave.branch_points]).query(points)[0] / weave.ribbons.spacing


def test_families_cross_at_sixty_degrees_near_branch_points_too() -> None:
    """Section 5: branch points are placed for "approximate 3-fold symmetry of the final weaving pattern"."""
    _, weave = ball()
    near = from_branch_points(weave, weave.ribbons.crossings.points) < 1.5
    angles = weave.crossing_angles[near]
    assert near.sum() > 40
    assert abs(np.median(angles) - 60.0) < 5.0
    assert np.mean(np.abs(angles - 60.0) < 25.0) > 0.9


def test_extending_ribbons_patches_the_weave_near_singularities() -> None:
    """Section 5.2: extending ribbons along geodesics "also helps patch the weave near singularities"."""
    made, weave = ball()
    out = np.ones(weave.mesh.n_faces, dtype=bool)
    out[made.cover.part.faces] = False
    level, ribbons = level_sets(made, weave), weave.ribbons.curves
    assert out.any()
    assert level.segment_lengths[out[level.faces]].sum() == 0, "no level set enters a puncture"
    share = ribbons.segment_lengths[out[ribbons.faces]].sum() / ribbons.lengths.sum()
    assert share > 0.5 * weave.mesh.face_areas[out].sum() / weave.mesh.face_areas.sum(), (
        "ribbons do, nearly as elsewhere"
    )


def test_punctures_disconnect_the_weave_before_it_is_patched() -> None:
    """Section 5.2: removing faces at singularities "can also result in disconnected weaves"."""
    made, weave = crown()
    assert len(weave.branch_points) > 100
    assert parts(level_sets(made, weave)) > 3
    assert parts(weave.ribbons.curves) == 1


def test_sliding_relieves_most_near_singularities() -> None:
    """Appendix E: sliding "reduces strain in the weave, particularly near singularities"."""
    _, weave = ball()
    slid = gw.slide(gw.elastic_rods(weave))
    densities = []
    for rods in (slid.designed, slid.slid.rods):
        energy = sum(gw.rods.energy_density(rods).values()) * rods.rest
        near = from_branch_points(weave, rods.points[rods.layout.ends].mean(axis=1)) < 1.5
        densities.append([energy[each].sum() / rods.rest[each].sum() for each in (near, ~near)])
    (near, away), (near_slid, away_slid) = densities
    assert near_slid < near
    assert near - near_slid > 3 * (away - away_slid)


def test_the_change_of_w_falls_from_step_to_step() -> None:
    """Appendix B.1 plots "the change in w between iterations" (Fig. 26, lambda = 100)."""
    start = gw.smoothest_field(gw.shapes.sphere(faces=1280), 0, phase="seeded")
    solve = gw.geodesic_field(start, smoothness=[100.0], iterations=10, acceleration="none", tolerance=0)
    changes = [step.change for step in solve.steps]
    assert len(changes) == 20
    assert changes[5] < 0.01 * changes[0]
    assert changes[-1] < changes[5] < changes[2] < changes[0]


def test_lambda_holds_the_curl_above_what_is_possible() -> None:
    """Appendix B.1: the curl "never reaches exactly zero", for the regularization too."""
    sphere = gw.shapes.sphere(faces=1280)
    egg = gw.TriMesh(sphere.vertices * [1.0, 0.75, 0.75], sphere.faces)
    start = gw.smoothest_field(egg, 0, phase="seeded")
    curls = [gw.total_curl(start)]
    for weight in (100.0, 1.0, 1e-2, 1e-3):
        curls.append(gw.total_curl(gw.geodesic_field(start, smoothness=[weight]).field))
    assert curls == sorted(curls, reverse=True)
    assert curls[1] < 0.2 * curls[0], "nearly all of the drop is there for any lambda"
    assert 0 < curls[-1] < 0.9 * curls[1], "a smaller one takes a tenth more, and never all"
