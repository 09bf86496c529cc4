from functools import cache

import numpy as np

from geoweave import viz
from geoweave.models import shapes
from geoweave.rods.weave_at_rest import Relaxed, relaxed_weave
from geoweave.viz import style
from geoweave.viz.fastened_scene import held_crossings
from geoweave.weave.design import weave_pattern


@cache
def cone() -> Relaxed:
    return relaxed_weave(weave_pattern(shapes.cone(faces=400), ribbons=8))


def red_share(friction: float) -> float:
    """Share of the picture in the colour of crossings that need a fastener."""
    scene = held_crossings(cone(), "cone", friction=friction)
    pixels = viz.gallery([scene], [("", "")], width=300, accents=[style.RED]).pixels[..., :3].astype(int)
    red = np.array([int(style.RED[k : k + 2], 16) for k in (1, 3, 5)])
    return float((np.abs(pixels - red).max(axis=2) < 40).mean())


def test_more_crossings_are_marked_where_friction_is_low() -> None:
    counts = [len(cone().forces.fasten(friction)) for friction in (0.05, 1e9)]
    assert counts[0] > counts[1]
    assert red_share(0.05) > red_share(1e9) + 0.002
