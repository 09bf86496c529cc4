"""No step of physics changes the topology of a weave: order, over and under, signs of angles."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from rodded import grid, rods_of

from geoweave.errors import RodError
from geoweave.meshing.remesh import isotropic_remesh
from geoweave.models import catalogue, shapes
from geoweave.rods.contact_order import crossing_sines, gaps_of, order_changes, positions
from geoweave.rods.rods import Contacts
from geoweave.rods.weave_at_rest import Relaxed, relaxed_weave
from geoweave.weave.design import weave_pattern

MODELS = ("bunny", "spot", "camel", "armadillo")
SHAPES = {
    "cone": (lambda: shapes.cone(faces=1500), 10),
    "torus": (lambda: shapes.torus(faces=1500), 12),
    "sphere": (lambda: shapes.sphere(600), 10),
    "saddle": (lambda: shapes.saddle(faces=1500), 20),
}


@cache
def rested(name: str) -> Relaxed:
    if name in SHAPES:
        make, ribbons = SHAPES[name]
        return relaxed_weave(weave_pattern(make(), ribbons=ribbons))
    return relaxed_weave(weave_pattern(isotropic_remesh(catalogue.load(name), 1500), ribbons=20))


def test_gaps_are_those_along_the_bars() -> None:
    rods = grid()
    order = gaps_of(rods)
    np.testing.assert_allclose(order.lengths, 1.0)
    assert len(order.before) == 6 * 2
    np.testing.assert_allclose(positions(rods)[0], 1.0)
    np.testing.assert_allclose(crossing_sines(rods), 1.0)
    assert not order_changes(rods, rods)


def test_a_contact_that_passes_its_neighbour_is_told() -> None:
    rods = grid()
    segments = rods.contacts.segments.copy()
    segments[0, 0] += 12  # from the first bar it meets to beyond the second
    changed = replace(rods, contacts=replace(rods.contacts, segments=segments))
    found = order_changes(rods, changed)
    assert found.passed.tolist() == [[0, 1]]
    assert not len(found.turned)
    assert not len(found.swapped)


def test_another_rod_above_and_another_sign_are_told() -> None:
    rods = grid()
    over = rods.contacts.over.copy()
    over[4] = 0
    assert order_changes(
        rods, replace(rods, contacts=replace(rods.contacts, over=over))
    ).swapped.tolist() == [4]
    turned = replace(rods, directors=-rods.directors)
    assert order_changes(rods, turned).turned.tolist() == list(range(9))
    with pytest.raises(RodError, match="other contacts"):
        order_changes(rods, replace(rods, contacts=Contacts([], [], [])))


def test_on_a_closed_rod_the_last_contact_is_before_the_first() -> None:
    angle = np.linspace(0, 2 * np.pi, 24, endpoint=False)
    ring = np.column_stack([np.cos(angle), np.sin(angle), 0 * angle])
    other = ring[:, [0, 2, 1]]
    pair = [[0, 24], [12, 36]]
    rods = rods_of(
        [ring, other],
        ring_normals(ring, other),
        closed=True,
        contacts=Contacts(pair, [[0, 0], [0, 0]], [0, 1]),
    )
    order = gaps_of(rods)
    whole = rods.rest[:24].sum()
    np.testing.assert_allclose(order.lengths, whole / 2)
    # moved backwards over the start of the ring, the contact comes nearer to the other one from behind
    back = replace(rods.contacts, segments=[[23, 24], [12, 36]])
    np.testing.assert_allclose(
        sorted(order.moved(positions(rods, back)))[::3], [whole / 2 - whole / 24, whole / 2 + whole / 24]
    )


def ring_normals(ring: np.ndarray, other: np.ndarray) -> np.ndarray:
    middle = [0.5 * (each + np.roll(each, -1, axis=0)) for each in (ring, other)]
    return np.concatenate(middle) / np.linalg.norm(np.concatenate(middle), axis=1)[:, None]


@pytest.mark.parametrize("name", [*SHAPES, *MODELS])
def test_sliding_and_relaxing_keep_the_weave(name: str) -> None:
    found = rested(name)
    assert found.converged
    order = gaps_of(found.designed)
    assert order.moved(positions(found.slid.rods)).min() > 0
    assert not order_changes(found.designed, found.slid.rods)
    assert not order_changes(found.designed, found.left.rods)


@pytest.mark.parametrize("name", ["cone", "torus"])
def test_strips_alternate_as_they_were_designed(name: str) -> None:
    """The table's share of alternating neighbours is that of the strips that are cut."""
    found = rested(name)
    shares = []
    for rods in (found.designed, found.left.rods):
        order = gaps_of(rods)
        above = np.column_stack([rods.contacts.over == 0, rods.contacts.over == 1]).ravel()
        shares.append((above[order.before] != above[order.after]).mean())
    assert shares[0] == shares[1]
