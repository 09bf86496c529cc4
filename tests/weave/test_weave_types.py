import numpy as np
import pytest
from flatweaves import grid

from geoweave.errors import FieldError
from geoweave.weave.passages import Passages
from geoweave.weave.weave_types import WEAVE_TYPES, rules_of, weave_type_of


def of_a_grid(rows, columns, side):
    """Sides of a torus of rows and columns by ``side(i, j)``, 0 or 1."""
    i, j = (each.ravel() for each in np.meshgrid(np.arange(rows), np.arange(columns), indexing="ij"))
    return np.asarray(side(i, j)).astype(np.int64)


def twills():
    """The eight of the textbook: two diagonals, four shifts of each."""
    return [lambda i, j, d=d, k=k: (i + d * j + k) % 4 // 2 for d in (1, -1) for k in range(4)]


def baskets():
    """The eight of the textbook: blocks of two by two, four shifts of rows, and two sides of the cloth."""
    return [
        lambda i, j, a=a, b=b, c=c: (i + a) // 2 + (j + b) // 2 + c & 1
        for a in (0, 1)
        for b in (0, 1)
        for c in (0, 1)
    ]


@pytest.mark.parametrize(("name", "textbook"), [("twill", twills()), ("basket", baskets())])
def test_on_a_torus_of_fours_the_rules_leave_the_textbooks_weaves_alone(name, textbook):
    """Every side from any four corners of one cell: the rules carry them over the whole grid, or refuse."""
    crossings = grid(8, 4)
    rules = rules_of(crossings, name)
    found = {tuple(of_a_grid(8, 4, side)) for side in textbook}
    assert len(found) == 8
    assert len(rules) == 2 * 32 + 32
    for sides in found:
        assert not rules.broken(np.array(sides)).any()
    # Rules are linear in the sides, so that the number of weaves that meet them is that of the kernel.
    other = next(iter(found))
    unit = np.eye(32, dtype=np.int64)
    columns = np.array([rules.broken(np.array(other) ^ each) for each in unit]).T.astype(np.int64)
    assert 2 ** (32 - rank_over_two(columns)) == len(found)


def rank_over_two(matrix):
    matrix, rank = matrix.copy() % 2, 0
    for column in range(matrix.shape[1]):
        pivots = np.flatnonzero(matrix[rank:, column]) + rank
        if not len(pivots):
            continue
        matrix[[rank, pivots[0]]] = matrix[[pivots[0], rank]]
        others = np.flatnonzero(matrix[:, column])
        matrix[others[others != rank]] ^= matrix[rank]
        rank += 1
    return rank


def test_neither_is_the_other_and_a_plain_weave_is_none():
    crossings = grid(8, 8)
    twill, basket = of_a_grid(8, 8, twills()[0]), of_a_grid(8, 8, baskets()[0])
    plain = of_a_grid(8, 8, lambda i, j: (i + j) % 2)
    count = {name: rules_of(crossings, name) for name in ("twill", "basket")}
    assert count["twill"].broken(basket).sum() == count["basket"].broken(twill).sum() == 64  # every cell
    assert count["twill"].broken(plain).sum() == 128 + 64  # every row, every cell
    assert count["basket"].broken(plain).sum() == 128


def test_the_order_in_which_ribbons_are_given_does_not_matter():
    crossings, rng = grid(8, 8), np.random.default_rng(4)
    turned = rng.random(64) < 0.5
    ribbons, places = crossings.ribbons.copy(), crossings.arclengths.copy()
    ribbons[turned], places[turned] = ribbons[turned, ::-1], places[turned, ::-1]
    backwards = rng.random(16) < 0.5
    places = np.where(backwards[ribbons], 7.0 - places, places)
    again = Passages(ribbons, places, crossings.closed)
    for name, side in (("twill", twills()[2]), ("basket", baskets()[3])):
        over = of_a_grid(8, 8, side) ^ turned
        assert not rules_of(again, name).broken(over).any()


def test_a_ribbon_that_passes_once_or_twice_has_no_rule_of_its_own():
    once = Passages([[0, 0]], [[0.2, 0.7]], [True])
    assert len(rules_of(once, "twill").cell) == 0
    alone = Passages([[0, 1]], [[0.5, 0.5]], [False, True])
    assert len(rules_of(alone, "basket")) == 0
    assert not rules_of(Passages([], [], []), "twill").broken(np.zeros(0, dtype=np.int64)).size


def test_what_symmetry_a_pattern_needs():
    assert [weave_type_of(None, each)[0] for each in WEAVE_TYPES] == [6, 4, 4, 4]
    assert [weave_type_of(n, None)[1] for n in (3, 4, 6, 8)] == ["plain", "plain", "kagome", "plain"]
    assert weave_type_of(8, "plain") == (8, "plain")
    for symmetry, pattern in ((6, "twill"), (6, "basket"), (6, "plain"), (4, "kagome"), (8, "twill")):
        with pytest.raises(FieldError, match=f"a {pattern} weave has .* not {symmetry}"):
            weave_type_of(symmetry, pattern)
    with pytest.raises(FieldError, match="no pattern 'satin'"):
        weave_type_of(None, "satin")


def test_a_rule_lies_at_a_crossing_of_all_its_links():
    crossings = grid(8, 8)
    rules, links = rules_of(crossings, "twill"), crossings.relations
    ends = np.stack([links.first, links.second], axis=1)
    for where, held in zip(rules.crossings, [*rules.row, *rules.cell[:, [0, 3]]], strict=True):
        assert all(where in ends[link] for link in held)
