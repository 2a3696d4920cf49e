"""Cubic pieces against their definitions: they meet, they bend as asked, and they are those of SciPy."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.interpolate import CubicSpline, PchipInterpolator

from vfife.numerics import splines


def points(count: int) -> tuple[list[float], list[float]]:
    rng = np.random.default_rng(count)
    return np.cumsum(rng.uniform(0.2, 2.0, count)).tolist(), np.round(rng.normal(size=count), 1).tolist()


@pytest.mark.parametrize("count", [2, 3, 4, 5, 12, 60])
@pytest.mark.parametrize("kind", ["natural", "periodic", "monotone"])
def test_pieces_are_those_of_scipy(kind: str, count: int) -> None:
    places, values = points(count)
    values[-1] = values[0] if kind == "periodic" else values[-1]
    if kind == "monotone":
        known = PchipInterpolator(places, values).c
    else:
        known = CubicSpline(places, values, bc_type=kind).c
    rows = np.array(getattr(splines, kind)(places, values))
    assert np.allclose(rows, known[::-1].T, rtol=1e-10, atol=1e-10)


def test_values_between_places() -> None:
    places, values = points(9)
    rows, x = splines.monotone(places, values), np.linspace(0.0, 12.0, 80)
    known = PchipInterpolator(places, values)(x)
    assert np.allclose(
        [splines.value_at(places, rows, one) for one in x.tolist()], known, rtol=1e-9, atol=1e-9
    )
