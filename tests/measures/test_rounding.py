"""Rounding of positions shows in accelerations if a step is very small, and a caution says so."""

from __future__ import annotations

from pathlib import Path

import pytest

import vfife
from vfife.measures.rounding import LARGE, NOISE, rounding_noise

EXAMPLES = Path(__file__).parents[2] / "examples"
AUTOMATIC = 8.79e-7  # s, of Jansen's leg with clearance


def leg(step: float) -> vfife.Result:
    model = vfife.load_model(EXAMPLES / "jansen_leg_loose.toml")
    return vfife.simulate(model, turns=0.02, step=step, companions=0, reference=False)


@pytest.fixture(scope="module")
def usual() -> vfife.Result:
    return leg(AUTOMATIC)


@pytest.fixture(scope="module")
def small() -> vfife.Result:
    return leg(AUTOMATIC / 16)


def test_a_caution_names_the_body_and_a_step(usual: vfife.Result, small: vfife.Result) -> None:
    """The upper rod's largest angular acceleration is 4.0 rad/s² at the usual step, 4.5 at a sixteenth."""
    noise = rounding_noise(small.record, small.measures)
    assert noise is not None and rounding_noise(usual.record, usual.measures) is None
    name = f"{noise.body}.angular_acceleration.max"
    change = small.measures[name] / usual.measures[name] - 1.0
    assert change > LARGE and change / NOISE < noise.share < NOISE * change
    assert small.record.assembly.choice.step < noise.step < AUTOMATIC
    said = [text for text in small.summary["warnings"] if "rounding of positions" in text]
    assert len(said) == 1 and noise.body in said[0] and 'or "auto"' in said[0]
    assert not any("rounding" in text for text in usual.summary["warnings"])


def test_noise_above_the_tolerance_of_the_automatic_step_has_a_caution(usual: vfife.Result) -> None:
    """In a whole turn at 125 ns the upper rod has 33.09 rad/s² instead of 32.86, 0.7 % more; at the start of
    the turn, where it has 4 rad/s², 260 ns have as much.
    """
    finer = leg(2.6e-7)
    noise = rounding_noise(finer.record, finer.measures)
    assert noise is not None and noise.body == "upper-rod" and LARGE < noise.share < 0.02
    name = "upper-rod.angular_acceleration.max"
    assert finer.measures[name] > (1.0 + 1e-3) * usual.measures[name]
    assert any("rounding of positions" in text for text in finer.summary["warnings"])
    assert finer.record.assembly.mechanism.settings.tolerance >= LARGE


def test_the_named_step_is_large_enough(small: vfife.Result, usual: vfife.Result) -> None:
    noise = rounding_noise(small.record, small.measures)
    assert noise is not None
    name, better = f"{noise.body}.angular_acceleration.max", leg(noise.step)
    assert better.measures[name] == pytest.approx(usual.measures[name], rel=LARGE)
    assert rounding_noise(better.record, better.measures) is None or noise.share > 2.0 * LARGE


def test_noise_grows_as_the_step_shrinks_squared() -> None:
    """A four-bar with ideal joints: what is added to the smooth motion is within the estimate."""
    model = vfife.load_model(EXAMPLES / "four_bar_ideal.toml")
    options = {"duration": 2e-5, "companions": 0, "reference": False, "outputs": 20_000}
    name = "follower.angular_acceleration.max"
    smooth = vfife.simulate(model, step=1e-7, **options).measures[name]
    added, shares = [], []
    for step in (2e-10, 1e-10):
        result = vfife.simulate(model, step=step, **options)
        noise = rounding_noise(result.record, result.measures)
        assert noise is not None and noise.body == "follower"
        added.append(result.measures[name] - smooth)
        shares.append(noise.share * result.measures[name])
    assert added[1] / added[0] == pytest.approx(4.0, rel=0.3)
    assert shares[1] / shares[0] == pytest.approx(4.0, rel=1e-3)
    assert all(share / 50.0 < extra < share for extra, share in zip(added, shares, strict=True))
