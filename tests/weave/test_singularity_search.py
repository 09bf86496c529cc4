"""What the search keeps is what it measured; a merge takes a pair away, a move lowers the energy."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

from geoweave.errors import FieldError
from geoweave.fields.rosy import smoothest_rosy
from geoweave.models import shapes
from geoweave.weave.singularity_search import Stage, finished_energy, searched


@cache
def stages() -> tuple[Stage, ...]:
    return searched(smoothest_rosy(shapes.genus_g(2, faces=600)), fewest=33, tries=1, seed=1)


def test_every_stage_has_the_energy_and_the_curl_that_it_says():
    assert [stage.kind for stage in stages()][:2] == ["start", "merge"]
    for stage in stages()[:3]:
        assert finished_energy(stage.rosy) == (stage.energy, stage.curl)
    assert all(before.tried < after.tried for before, after in zip(stages(), stages()[1:], strict=False))


def test_a_merge_takes_a_pair_away_and_a_move_lowers_the_energy():
    moves = 0
    for before, after in zip(stages(), stages()[1:], strict=False):
        change = after.rosy.index_numerators - before.rosy.index_numerators
        # What one vertex loses another gains.
        assert sorted(change[change != 0].tolist()) == [-1, 1]
        if after.kind == "merge":
            assert np.abs(after.rosy.index_numerators).sum() == np.abs(before.rosy.index_numerators).sum() - 2
        else:
            moves += 1
            assert after.number == before.number
            assert after.energy < before.energy
    assert moves > 0


def test_it_ends_with_the_fewest_or_where_no_pair_is_left():
    assert stages()[-1].number <= 33
    ball = searched(smoothest_rosy(shapes.sphere(faces=320)), fewest=0)
    assert [stage.kind for stage in ball] == ["start"]
    with pytest.raises(FieldError, match="negative"):
        searched(ball[0].rosy, fewest=-1)
