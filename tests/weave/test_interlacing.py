import itertools

import numpy as np
import pytest
from flatweaves import anything, grid, segments

from geoweave.errors import GeoweaveError
from geoweave.weave.interlacing import greedy, judged, optimal
from geoweave.weave.passages import Passages


def triaxial(lines, pieces, seed):
    """Three families of parallel chords of the unit disk at 60 degrees, cut at random with gaps."""
    rng = np.random.default_rng(seed)
    start, end = [], []
    for family in range(3):
        angle = family * np.pi / 3 + 0.01
        along, across = np.array([np.cos(angle), np.sin(angle)]), np.array([-np.sin(angle), np.cos(angle)])
        for k in range(lines):
            offset = 2 * (k - lines / 2 + 0.37 * family + 0.2) / lines
            half = np.sqrt(max(1 - offset**2, 0.0))
            cuts = np.concatenate([[-half], np.sort(rng.uniform(-half, half, rng.poisson(pieces))), [half]])
            for low, high in itertools.pairwise(cuts):
                if high - low > 0.1:
                    start.append(offset * across + (low + 0.03 * rng.random()) * along)
                    end.append(offset * across + (high - 0.03 * rng.random()) * along)
    return segments(np.array(start), np.array(end))


def great_circles(count, seed):
    """Closed curves on the sphere that meet two by two in two points."""
    normals = np.random.default_rng(seed).normal(size=(count, 3))
    first, second = np.triu_indices(count, 1)
    point = np.cross(normals[first], normals[second])
    ribbons = np.tile(np.c_[first, second], (2, 1))
    points = np.concatenate([point, -point])
    u = np.cross(normals, [0.3, -0.5, 0.8])
    v = np.cross(normals, u) / np.linalg.norm(normals, axis=1, keepdims=True)
    angles = [np.arctan2((points * v[r]).sum(axis=1), (points * u[r]).sum(axis=1)) for r in ribbons.T]
    return Passages(ribbons, np.column_stack(angles) + np.pi, np.ones(count, dtype=bool))


def counted(crossings, over):
    """Consecutive passages on the same side, ribbon by ribbon as a weaver would count them."""
    same = pairs = 0
    for ribbon, closed in enumerate(crossings.closed):
        here = crossings.ribbons == ribbon
        place, (crossing, side) = crossings.arclengths[here], np.nonzero(here)
        sequence = (over[crossing] == side)[np.argsort(place)]
        if closed and len(sequence) > 1:
            sequence = np.append(sequence, sequence[0])
        same += int((sequence[1:] == sequence[:-1]).sum())
        pairs += max(len(sequence) - 1, 0)
    return same, pairs


@pytest.mark.parametrize("seed", range(40))
def test_optimal_on_everything_small(seed):
    crossings = anything(seed)
    found = optimal(crossings)
    same, pairs = counted(crossings, found.over)
    assert (found.broken.sum(), len(found.broken)) == (same, pairs)
    every = [np.array(sides) for sides in itertools.product((0, 1), repeat=len(crossings))]
    fewest = min(counted(crossings, sides)[0] for sides in every)
    assert found.bound == same == fewest
    assert found.proven
    # among the best ones, none interleaves more triangles
    best = [judged(crossings, sides) for sides in every if counted(crossings, sides)[0] == fewest]
    assert found.triples_proven
    assert found.interleaved == max(each.interleaved for each in best)
    assert greedy(crossings, seed).broken.sum() >= fewest


@pytest.mark.parametrize(("rows", "columns"), [(6, 8), (6, 9), (7, 8), (7, 9), (20, 31)])
def test_plain_weave_of_a_torus(rows, columns):
    """Each row or column of an odd number of crossings stays on its side once, and once is enough."""
    found = optimal(grid(rows, columns))
    assert found.proven
    assert found.broken.sum() == rows * (columns % 2) + columns * (rows % 2)
    assert len(found.broken) == 2 * rows * columns


def test_closed_curves_on_the_sphere_alternate_throughout():
    """Closed curves in the plane always do: the faces of their arrangement take two colours."""
    crossings = great_circles(25, 1)
    found = optimal(crossings)
    assert found.alternation == found.alternation_bound == 1.0
    assert found.proven
    # where all alternate, every triangle of neighbours interleaves; the greedy rule misses some
    assert found.interleaved == found.triples > 0
    rule = greedy(crossings, 0)
    assert rule.alternation < 1.0
    assert rule.interleaved < rule.triples


def test_a_ribbon_that_ends_inside_costs_a_relation():
    """A ribbon ends in a square of four others: the face on its end has one turn less, and so is odd."""
    whole = np.array([[0, 1, 3, 1], [0, 2, 3, 2], [1, 0, 1, 3], [2, 0, 2, 3]], dtype=float)
    through = np.array([[1.5, 0, 1.5, 3.0]])
    ends_inside = np.array([[1.5, 0, 1.5, 1.5]])
    both = [np.vstack([whole, extra]) for extra in (through, ends_inside)]
    fewest = [optimal(segments(each[:, :2], each[:, 2:])).broken.sum() for each in both]
    assert fewest == [0, 1]


@pytest.mark.parametrize("seed", [0, 1])
def test_a_weave_of_a_hundred_ribbons_is_proven_and_repeats(seed):
    crossings = triaxial(20, 1.0, seed)
    assert len(crossings) > 600
    found, again = optimal(crossings), optimal(crossings)
    np.testing.assert_array_equal(found.over, again.over)
    assert found.proven
    assert counted(crossings, found.over)[0] == found.broken.sum()
    rules = [greedy(crossings, order) for order in range(5)]
    assert len({rule.over.tobytes() for rule in rules}) == 5
    assert all(rule.alternation < found.alternation for rule in rules)


def test_the_bound_holds_when_the_effort_is_used_up():
    crossings = triaxial(20, 1.0, 0)
    hasty, patient = optimal(crossings, 1), optimal(crossings)
    assert patient.proven
    assert not hasty.proven
    assert hasty.bound <= patient.bound <= hasty.broken.sum()
    assert 0.5 < hasty.alternation <= patient.alternation <= hasty.alternation_bound


def test_greedy_alternates_the_first_ribbon_and_respects_it():
    """One long ribbon across many: whichever is first, each ribbon alternates but for settled crossings."""
    crossings = Passages(np.c_[np.zeros(6), 1 + np.arange(6)], np.c_[np.arange(6), np.zeros(6)], [False] * 7)
    for seed in range(8):
        rule = greedy(crossings, seed)
        if np.random.default_rng(seed).permutation(7)[0] == 0:
            assert rule.alternation == 1.0
    np.testing.assert_array_equal(greedy(crossings, 3).over, greedy(crossings, 3).over)


def test_which_ribbon_comes_first_in_a_crossing_is_only_a_name():
    crossings = triaxial(10, 1.0, 4)
    flip = np.random.default_rng(1).random(len(crossings)) < 0.5
    ribbons, lengths = crossings.ribbons.copy(), crossings.arclengths.copy()
    ribbons[flip], lengths[flip] = ribbons[flip, ::-1], lengths[flip, ::-1]
    other = Passages(ribbons, lengths, crossings.closed)
    assert optimal(other).broken.sum() == optimal(crossings).broken.sum()
    np.testing.assert_array_equal(greedy(other, 7).over ^ flip, greedy(crossings, 7).over)


def test_a_triangle_interleaves_or_is_stacked():
    three = np.array([[0, 0, 2, 0], [0.2, -0.5, 1.5, 2], [1.8, -0.5, 0.5, 2]], dtype=float)
    crossings = segments(three[:, :2], three[:, 2:])
    assert crossings.triples.shape == (1, 3)
    for sides in itertools.product((0, 1), repeat=3):
        upper = crossings.ribbons[np.arange(3), list(sides)]
        result = judged(crossings, sides)
        # interleaved exactly when each ribbon is once the upper one
        assert result.interleaved == (len(set(upper.tolist())) == 3)
    assert optimal(crossings).interleaved == 1


def test_small_and_empty():
    nothing = Passages(np.zeros((0, 2)), np.zeros((0, 2)), [])
    for result in (optimal(nothing), greedy(nothing)):
        assert (result.alternation, result.alternation_bound, len(result.over)) == (1.0, 1.0, 0)
    loop = Passages([[0, 0]], [[1.0, 2.0]], [True])  # a figure of eight goes over itself once
    assert optimal(loop).alternation == 1.0
    assert len(optimal(loop).broken) == 2


def test_sides_that_do_not_fit_are_refused():
    one = Passages([[0, 1]], [[0.0, 0.0]], [False, False])
    with pytest.raises(GeoweaveError, match="zeros and ones"):
        judged(one, [2])
