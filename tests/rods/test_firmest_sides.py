from functools import cache

import numpy as np

from geoweave.models import shapes
from geoweave.rods.contact_order import positions
from geoweave.rods.crossing_forces import contact_forces
from geoweave.rods.firmest_sides import firmest
from geoweave.rods.rods import Rods
from geoweave.rods.slid_weave import elastic_rods, slide
from geoweave.rods.slide_and_relax import relax_rods
from geoweave.weave.design import weave_pattern
from geoweave.weave.interlacing import judged
from geoweave.weave.passages import Passages


@cache
def cone() -> Rods:
    return slide(elastic_rods(weave_pattern(shapes.cone(faces=600), ribbons=10))).cut


def test_fewer_crossings_need_a_fastener_and_ribbons_alternate_as_often():
    rods = cone()
    start, best = relax_rods(rods), firmest(rods)
    assert best.converged
    before, after = (len(contact_forces(each.rods).fasten()) for each in (start, best))
    assert after <= before
    layout = rods.layout
    met = Passages(layout.rod_of_segment[rods.contacts.segments], positions(rods), layout.closed)
    one, other = (judged(met, each.rods.contacts.over) for each in (start, best))
    assert other.broken.sum() <= one.broken.sum()


def test_it_finds_the_better_of_a_weave_and_its_mirror_image():
    """Both orders alternate alike; whichever it starts from, the result is no worse than the other."""
    rods = cone()
    mirrored = Rods(
        rods.layout, rods.points, rods.directors, rods.widths, rods.rest,
        type(rods.contacts)(rods.contacts.segments, rods.contacts.places, 1 - rods.contacts.over),
        rods.material, natural=rods.natural,
    )  # fmt: skip
    plain = [len(contact_forces(relax_rods(each).rods).fasten()) for each in (rods, mirrored)]
    found = [len(contact_forces(firmest(each).rods).fasten()) for each in (rods, mirrored)]
    assert max(found) <= min(plain)
    assert np.isfinite(found).all()
