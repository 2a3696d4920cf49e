"""Cycle jumps against differential equations with known solutions: order, tolerance, what is between."""

import math
from types import SimpleNamespace

import numpy as np
import pytest

from vfife.measures.wear import Rubbing
from vfife.tribology.jumps import Standing, depth_within, factor, jumps

K = 1e-6


def size(change: np.ndarray) -> float:
    return float(np.abs(change).max())


def followed(
    rate, until: float, tolerance: float, reach: float = math.inf, first: float = 1e4
) -> list[Standing]:
    start = np.zeros(2)
    begin = Standing(0.0, start, rate(start), first)
    return [begin, *jumps(rate, begin, until, tolerance, size, reach)]


def growing(depth: np.ndarray) -> np.ndarray:
    """h' = k (1 + h) and -k h: e^(k N) - 1, and nothing."""
    return np.array([K * (1.0 + depth[0]), -K * depth[1]])


@pytest.mark.parametrize("tolerance", [1e-2, 1e-3, 1e-4])
def test_a_jump_errs_by_less_than_the_tolerance(tolerance):
    """The rate doubles and more; each jump is of second order, so that its own error is far below that of
    Euler's, which it is judged by.
    """
    found = followed(growing, 2e6, tolerance)
    assert found[-1].turns == 2e6 and found[-1].depth[1] == 0.0
    assert all(one.error <= tolerance for one in found)
    exact = math.expm1(2.0)
    assert abs(found[-1].depth[0] - exact) < 2.0 * tolerance * len(found)
    assert len(found) < 4.0 / math.sqrt(tolerance)


def test_ten_times_the_jumps_have_a_hundredth_of_the_error():
    """Second order: a tolerance of a hundredth makes ten times as many jumps."""
    rough, fine = (followed(growing, 2e6, tolerance) for tolerance in (1e-3, 1e-5))
    errors = [abs(one[-1].depth[0] - math.expm1(2.0)) for one in (rough, fine)]
    assert len(fine) / len(rough) == pytest.approx(10.0, rel=0.35)
    assert errors[0] / errors[1] == pytest.approx(100.0, rel=0.6)


def test_what_does_not_change_its_rate_takes_few_jumps():
    found = followed(lambda _: np.array([K, 0.0]), 1e9, 1e-9)
    assert (
        found[-1].depth[0] == pytest.approx(1e3, rel=1e-12)
        and len(found) < 12
        and sum(one.refused for one in found) == 0
    )


def test_a_kink_refuses_jumps():
    """A rate that is ten times as high beyond a depth: the jump over it is taken in parts."""
    found = followed(lambda depth: np.array([K * (10.0 if depth[0] > 1.0 else 1.0), 0.0]), 2e6, 1e-3)
    assert sum(one.refused for one in found) > 2
    assert found[-1].depth[0] == pytest.approx(1.0 + 10.0, abs=0.02)


def test_no_jump_goes_beyond_the_reach():
    found = followed(lambda _: np.array([K, 0.0]), 1e6, 1.0, reach=0.1)
    assert [one.size for one in found[3:]] == pytest.approx([1e5] * (len(found) - 4) + [found[-1].size])


def test_what_is_between_is_of_second_order():
    first, second = followed(growing, 1e5, 1.0, first=1e5)
    assert depth_within(first, 0.5, second.size, second.end_rate)[0] == pytest.approx(
        math.expm1(0.05), rel=1e-3
    )
    assert depth_within(first, 1.0, second.size, second.end_rate) == pytest.approx(second.depth)


def test_factors_are_bounded():
    assert factor(0.0, 1.0) == 4.0 and factor(1e9, 1.0) == 0.2 and factor(0.81, 1.0) == pytest.approx(1.0)


def test_the_error_of_a_jump_is_that_of_eulers_step():
    """Of h' = k (1 + h) over D turns Euler's step leaves out e^(k D) - 1 - k D; the error of the jump is
    that.
    """
    far = 1e-3 / K
    begin = Standing(0.0, np.zeros(2), growing(np.zeros(2)), far)
    one = next(jumps(growing, begin, far, 1.0, size, math.inf))
    assert one.size == far and one.error == pytest.approx(math.expm1(1e-3) - 1e-3, rel=1e-3)
    assert one.depth[0] == pytest.approx(1e-3 + 0.5e-6, rel=1e-12), "Heun's step"


def test_what_the_mean_of_a_block_leaves_open_is_a_standard_error():
    """Work of 1, 2 and 3 in three turns: deviation 1 of the sample, so 1/sqrt(3) of the mean, over 2."""
    from vfife.tribology import wear_state

    surface = SimpleNamespace(joint="J", side="journal", k=1e-15)
    record = SimpleNamespace(assembly=SimpleNamespace(contact_joints=("J",)))
    part = Rubbing(np.repeat([1.0, 2.0, 3.0], 4) / 4.0, np.zeros(12), np.zeros(12))
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(wear_state, "rubbing", lambda *_: part)
        patch.setattr(wear_state, "areas", lambda *_: (1.0, 2.0))
        depth, (spread,) = wear_state.rates(record, [surface], 3)
        assert spread == pytest.approx(1.0 / math.sqrt(3.0) / 2.0, rel=1e-14)
        assert depth.sum() == pytest.approx(1e-15 / 2.0 * 6.0 / 3.0, rel=1e-12)
        assert wear_state.rates(record, [surface], 1)[1] == [0.0]
