from dataclasses import replace

import numpy as np
from rodded import crumpled, ring

from geoweave.rods.elastic_energies import edgewise_bending
from geoweave.rods.natural_curvature import curvature_knots, natural_of_strips
from geoweave.weave.flat_curve import FlatCurve


def test_a_strip_cut_to_a_ring_is_at_rest_in_it():
    flat = ring(60, 2.0, upright=False)
    whole = flat.rest.sum()
    curve = FlatCurve(((0.0, 2 * np.pi / whole),), whole, closed=True)  # turns left, seen from tau
    rods = replace(flat, natural=natural_of_strips(flat, [curve]))
    assert edgewise_bending(rods.layout).energy(rods) < 1e-20
    assert edgewise_bending(rods.layout).energy(flat) > 1.0


def test_natural_curvatures_come_back_from_their_knots_in_any_unit():
    rods = crumpled()
    place = np.cumsum(rods.spans)
    smooth = 0.2 * rods.spans * np.sin(place / 2)
    rods = replace(rods, natural=smooth)
    unit = 40.0
    wholes = unit * np.add.reduceat(rods.rest, rods.layout.segment_offsets[:-1])
    curves = [
        FlatCurve(knots, whole, closed)
        for knots, whole, closed in zip(
            curvature_knots(rods, unit), wholes, rods.layout.closed.tolist(), strict=True
        )
    ]
    # Between joints it is linear, which rounds off what bends more, and a closed rod has a jump here.
    found = natural_of_strips(rods, curves)
    np.testing.assert_allclose(found[:5], smooth[:5], atol=0.01)
    np.testing.assert_allclose(found[6:-2], smooth[6:-2], atol=0.01)


def test_straight_rods_have_no_knots():
    rods = replace(crumpled(), natural=np.zeros(len(crumpled().natural)))
    assert curvature_knots(rods, 1.0) == [[], []]
    assert not natural_of_strips(rods, [None, None]).any()
