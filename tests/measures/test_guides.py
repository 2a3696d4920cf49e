"""Points and sliders against the closed form of the slider-crank, and against differences of their own
positions on guides that move.
"""

import math

import numpy as np
import pytest

from support import go
from vfife.gallery import quick_return, slider_crank, slider_crank_loose_guide
from vfife.measures.catalogue import measures
from vfife.measures.motion import point_motion, slider_motion, sliders, times

SPEED = 100.0
CRANK, ROD = 0.050, 0.120  # m


@pytest.fixture(scope="module")
def record():
    return go(slider_crank(speed=SPEED), 1e-5, turns=1.0)


def piston(angle):
    """x = r cos t + sqrt(l^2 - r^2 sin^2 t) and its first two derivatives by t."""
    c, s = CRANK * np.cos(angle), CRANK * np.sin(angle)
    q = np.sqrt(ROD**2 - s**2)
    return c + q, -s - s * c / q, -c - (c * c - s * s) / q - (s * c) ** 2 / q**3


def test_a_piston_moves_as_the_closed_form_says(record) -> None:
    found = slider_motion(record, "guide")
    for k, (own, exact) in enumerate(zip(found, piston(SPEED * times(record)), strict=True)):
        np.testing.assert_allclose(own, exact * SPEED**k, atol=1e-6 * np.abs(exact * SPEED**k).max())
    numbers = measures(record)
    assert numbers["guide.position.high"] - numbers["guide.position.low"] == pytest.approx(
        2 * CRANK, rel=1e-6
    )
    assert numbers["guide.acceleration.max"] == pytest.approx(CRANK * SPEED**2 * (1 + CRANK / ROD), rel=1e-5)


def test_any_point_moves_along_any_direction(record) -> None:
    moved, angle = point_motion(record, "crank.end"), SPEED * times(record)
    for k, exact in enumerate(
        (CRANK * np.sin(angle), CRANK * SPEED * np.cos(angle), -CRANK * SPEED**2 * np.sin(angle))
    ):
        np.testing.assert_allclose(moved.along((0.0, 2.0))[k], exact, atol=1e-9 * SPEED**k)
    still = point_motion(record, "ground.O")
    assert not still.position.any() and not still.velocity.any()
    with pytest.raises(ValueError, match=r"no point 'crank.top'; there are crank.start, crank.end"):
        point_motion(record, "crank.top")
    with pytest.raises(ValueError, match="no length"):
        moved.along((0.0, 0.0))


def test_a_guide_that_turns_is_the_frame_of_its_slider() -> None:
    """In the quick return the slider goes along a rocker: velocity and acceleration are the derivatives of
    the place along it.
    """
    m = quick_return()
    record = go(m, 2e-5, turns=1.0)
    (name,) = [one for one in sliders(record) if m.joints[one].sides[0][0] != "ground"][:1]
    place, rate, second = slider_motion(record, name)
    dt = times(record)[1]
    np.testing.assert_allclose(
        rate[2:-2],
        (8 * (place[3:-1] - place[1:-3]) - (place[4:] - place[:-4])) / (12 * dt),
        atol=1e-4 * np.abs(rate).max(),
    )
    np.testing.assert_allclose(
        second[2:-2],
        (8 * (rate[3:-1] - rate[1:-3]) - (rate[4:] - rate[:-4])) / (12 * dt),
        atol=2e-3 * np.abs(second).max(),
    )
    with pytest.raises(ValueError, match="is no slider; there are"):
        slider_motion(record, "nothing")


def test_a_block_with_play_is_a_slider_too() -> None:
    record = go(slider_crank_loose_guide(), 2e-6, turns=0.1)
    place = slider_motion(record, "guide")[0]
    exact = piston(SPEED * times(record))[0] + 0.010  # the pin lies 10 mm behind the middle
    np.testing.assert_allclose(place, exact, atol=1e-4)
    assert math.isfinite(measures(record)["guide.velocity.max"])
