import numpy as np
import pytest

from geoweave.weave.flat_curve import FlatCurve, check_curvature


def test_an_arc_is_an_arc():
    arc = FlatCurve(((0.0, -0.05),), 100.0)
    s = np.linspace(-10.0, 100.0, 23)
    np.testing.assert_allclose(arc.heading(s), -0.05 * s, atol=1e-12)
    expected = 20 * np.column_stack([np.sin(s / 20), np.cos(s / 20) - 1])
    np.testing.assert_allclose(arc.points(s), expected, atol=1e-8)


def test_curvature_is_linear_between_knots_and_headings_are_its_integral():
    curve = FlatCurve(((10.0, 0.0), (30.0, 0.1), (50.0, -0.02)), 60.0)
    np.testing.assert_allclose(curve.curvature([0, 10, 20, 30, 40, 60]), [0, 0, 0.05, 0.1, 0.04, -0.02])
    s = np.linspace(0, 60, 60_001)
    summed = np.concatenate([[0], np.cumsum(curve.curvature(0.5 * (s[1:] + s[:-1])) * np.diff(s))])
    np.testing.assert_allclose(curve.heading(s), summed, atol=1e-9)
    steps = np.diff(curve.points(s), axis=0) / np.diff(s)[:, None]
    middle = curve.heading(0.5 * (s[1:] + s[:-1]))
    np.testing.assert_allclose(steps, np.column_stack([np.cos(middle), np.sin(middle)]), atol=1e-6)


def test_a_closed_strip_goes_on_as_it_began():
    knots = ((0.0, 0.02), (25.0, -0.01), (60.0, 0.05))
    curve = FlatCurve(knots, 80.0, closed=True)
    s = np.linspace(0.0, 30.0, 7)
    np.testing.assert_allclose(curve.curvature(s + 80.0), curve.curvature(s), atol=1e-12)
    assert curve.curvature(70.0) == pytest.approx(0.035)


def test_a_part_is_the_same_curve():
    curve = FlatCurve(((10.0, 0.0), (30.0, 0.1), (50.0, -0.02)), 60.0)
    part = curve.part(17.0, 25.0)
    s = np.linspace(0.0, 25.0, 11)
    np.testing.assert_allclose(part.curvature(s), curve.curvature(s + 17.0), atol=1e-12)
    np.testing.assert_allclose(part.heading(s), curve.heading(s + 17.0) - curve.heading(17.0), atol=1e-12)


@pytest.mark.parametrize(
    ("knots", "words"),
    [(((0.0, 0.1), (0.0, 0.2)), "do not increase"), (((0.0, -0.4),), "edges of a strip 5 wide cross")],
)
def test_curves_that_no_strip_has_are_refused(knots, words):
    check_curvature(((0.0, 0.3), (1.0, -0.3)), 5.0, "it")
    with pytest.raises(ValueError, match=words):
        check_curvature(knots, 5.0, "it")
