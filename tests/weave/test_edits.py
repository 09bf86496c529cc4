"""A key tells designs apart and does not mind their size."""

from __future__ import annotations

import copy

from laidflat import cone

from geoweave.weave.edits import design_key


def test_the_key_is_that_of_the_design_whatever_its_size() -> None:
    one, other = cone().document(), cone().sized(size=300.0, width=5.0).document()
    assert design_key(one) == design_key(other)
    assert len(design_key(one)) == 16


def test_another_order_or_side_is_another_design() -> None:
    document = cone().document()
    for change in (
        lambda d: d["crossings"].pop(),
        lambda d: d["crossings"][0].update(over_index=1 - d["crossings"][0]["over_index"]),
        lambda d: d["ribbons"][0].update(label="Z9"),
    ):
        other = copy.deepcopy(document)
        change(other)
        assert design_key(other) != design_key(document)
