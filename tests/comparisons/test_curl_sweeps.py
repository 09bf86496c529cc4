"""Drops of total curl over meshes and over the end of the sharpening."""

from __future__ import annotations

import pytest

import geoweave as gw
from geoweave.comparisons.curl_sweeps import curl_by_last_smoothness, curl_by_resolution


def test_each_resolution_is_met_and_loses_curl() -> None:
    rows = curl_by_resolution(gw.shapes.genus_g(2, faces=900), [400, 800])
    assert [row.value for row in rows] == [400, 800]
    assert rows[0].before != rows[1].before
    assert all(0.3 < row.drop < 1.0 for row in rows)


def test_the_default_end_is_what_the_default_schedule_gives() -> None:
    start = gw.smoothest_field(gw.shapes.genus_g(2, faces=900))
    (row,) = curl_by_last_smoothness(start, [gw.fields.SHARPENING_END])
    assert row.after == pytest.approx(gw.total_curl(gw.geodesic_field(start).field))
    assert row.drop == pytest.approx(1 - row.after / gw.total_curl(start))
