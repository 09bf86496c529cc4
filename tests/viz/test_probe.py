"""The probe draws a triangle of known size."""

from geoweave.viz import probe


def test_the_triangle_is_in_the_picture() -> None:
    found = probe.draw()
    # The camera fits the triangle's bounding sphere: a right triangle covers about a fifth of the square.
    assert 0.15 < found["red"] < 0.3
    assert found["window"].endswith("RenderWindow")
