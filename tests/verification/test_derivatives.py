"""Derivatives of the largest values of a turn by every number of a model: against central differences of
whole runs that take the same steps.

Where the differences are known to 1e-4, derivatives agree with them to 1e-4, or as closely as the differences
are known. (The others have a kink of friction, or an onset that falls into another step, within 2e-5 of the
model.) docs/sensitivity.md has what was found as a table.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import vfife
from differences import compared
from vfife_validation.paper.mechanisms import Parameters, four_bar

pytestmark = pytest.mark.verify

CASES: dict[
    str, tuple[str, dict[str, Any], float]
] = {  # model, length and step, part of the differences that is known to 1e-4
    "case a": ("four_bar_ideal", {"turns": 1.0}, 1.0),
    "case b": ("four_bar_case_b", {"turns": 1.0, "step": 4e-6}, 0.8),
    "case c": ("four_bar_case_c", {"turns": 0.25, "step": 1e-6}, 0.7),
    "slider-crank": ("slider_crank", {"turns": 1.0}, 1.0),
    "quick return": ("quick_return", {"turns": 1.0}, 1.0),
    "scotch yoke": ("scotch_yoke", {"turns": 1.0}, 0.9),
    "six-bar press": ("six_bar_press", {"turns": 1.0}, 0.9),
    "Jansen's leg": ("jansen_leg", {"turns": 0.25}, 0.9),
    "slider-crank with a loose pin": ("slider_crank_loose_pin", {"turns": 0.25}, 0.6),
    "slider-crank with a loose guide": ("slider_crank_loose_guide", {"turns": 0.1}, 0.5),
    "block on an incline": ("block_on_incline", {}, 0.5),
    "the paper's four-bar": ("", {"turns": 0.02}, 0.7),
}


@pytest.mark.parametrize("name", CASES)
def test_derivatives_are_central_differences(name):
    model, length, known = CASES[name]
    mechanism = vfife.load(f"examples/{model}.toml") if model else four_bar(Parameters(), 2e-4)
    found = compared(mechanism, **length)
    sure = found.unknown < 1e-4
    print(f"| {name} | {len(sure)} | {sure.sum()} | {np.median(found.known):.0e} | {found.known.max():.0e} |")
    assert sure.mean() >= known
    assert (found.apart[sure] <= 1e-4 + 2.0 * found.unknown[sure]).all(), found.names[
        int(np.argmax(np.where(sure, found.apart, 0.0)))
    ]
    assert np.median(found.known) < 1e-5
