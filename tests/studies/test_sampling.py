"""Places in the space of parameters: what each method promises, the same on every machine."""

from __future__ import annotations

import numpy as np
import pytest

from vfife.errors import Fault
from vfife.studies.spec.distributions import METHODS, Normal, Uniform, places, points


@pytest.mark.parametrize("method", METHODS)
def test_places_are_inside_and_repeat(method: str) -> None:
    one, again, other = (places(method, 100, 3, seed) for seed in (1, 1, 2))
    assert one.shape == (100 * {"saltelli": 5, "morris": 4}.get(method, 1), 3)
    assert np.array_equal(one, again)
    assert not np.array_equal(one, other)
    assert np.all((one > 0) & (one < 1))


def test_places_are_those_of_every_machine() -> None:
    """Taken once; a random one by hand from the published stream of PCG64: its first 53 bits of 64."""
    raw = np.random.PCG64(7).random_raw(2)
    assert places("random", 1, 2, 7)[0].tolist() == [
        (int(whole) >> 11) * 2.0**-53 + 2.0**-54 for whole in raw
    ]


def test_more_points_keep_the_first() -> None:
    for method in ("random", "sobol", "saltelli", "morris"):
        few, many = (places(method, count, 4, 5) for count in (48, 96))
        assert np.array_equal(few, many[: len(few)])


def test_a_latin_hypercube_has_one_place_in_each_slice() -> None:
    one = places("latin", 37, 5, 11)
    for axis in one.T:
        assert sorted((axis * 37).astype(int)) == list(range(37))


def test_sobol_fills_every_dyadic_box() -> None:
    """A (0, m, 2) net in base two: of 2^m points of the first two axes each box of area 2^-m holds exactly
    one, scrambled or not.
    """
    one = places("sobol", 64, 2, 9)
    for k in range(7):
        boxes = {(int(x * 2**k), int(y * 2 ** (6 - k))) for x, y in one}
        assert len(boxes) == 64


def test_the_mean_over_sobol_points_is_closer_than_at_random() -> None:
    """Of x1 x2 x3 over the unit cube, 1/8: the error of 1024 points is below 1e-3, that of random ones is
    some 5e-3.
    """
    assert np.prod(places("sobol", 1024, 3, 0), axis=1).mean() == pytest.approx(1 / 8, abs=1e-3)


@pytest.mark.parametrize("method", ["latin", "random", "sobol", "saltelli"])
def test_points_follow_their_distributions(method: str) -> None:
    values = points([Uniform(2, 4), Normal(10, 1)], method, 2000, 1)
    assert values.mean(axis=0) == pytest.approx([3, 10], abs=0.1)
    assert values.std(axis=0) == pytest.approx([2 / np.sqrt(12), 1], rel=0.06)
    assert points([], method, 5).shape == (5, 0)


def test_what_cannot_be_sampled_is_refused() -> None:
    for method, count, dimensions, said in (
        ("halton", 5, 1, "unknown way"),
        ("sobol", 0, 1, "count"),
        ("latin", 5, 1001, "more parameters"),
    ):
        with pytest.raises(Fault, match=said):
            places(method, count, dimensions)
