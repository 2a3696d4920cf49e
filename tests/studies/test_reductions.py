"""Reductions of channels are those of the case's own run over its last turns, and of known curves what
analysis says.
"""

from __future__ import annotations

import math

import numpy as np
import pytest

import vfife
from studies.studies import BASE
from vfife.results.series import REDUCED

STEP = 0.04 / 720 / 6  # of a turn of 0.04 s


def test_of_a_sine_over_a_turn() -> None:
    """max, min and range of a + b sin are a ± b and 2 b; its mean a, its mean square a² + b²/2."""
    time = np.linspace(0.0, 1.0, 721)
    values = 3.0 + 2.0 * np.sin(2.0 * math.pi * time)
    wanted = {"max": 5.0, "min": 1.0, "range": 4.0, "mean": 3.0, "rms": math.sqrt(11.0)}
    assert {name: how(time, values) for name, how in REDUCED.items()} == pytest.approx(wanted, rel=1e-12)


@pytest.mark.parametrize("last", [1, 2])
def test_of_a_cases_last_turns(last: int) -> None:
    names = (
        "mean(C.force)",
        "rms(crank.torque)",
        "range(follower.angle)",
        "min(kinetic_energy)",
        "max(C.force_max)",
        "C.force.max",
    )
    base = vfife.load_model(BASE)
    found = vfife.study(base, {"joint.C.clearance": [2e-4, 3e-4]}, names, turns=3, last=last, step=STEP)
    own = vfife.simulate(
        vfife.load(BASE, {"joint.C.clearance": 3e-4}), turns=3, step=STEP, companions=0, reference=False
    )
    n = 720 * last + 1
    force, torque, angle = (
        own.series[name].values[-n:] for name in ("C.force", "crank.torque", "follower.angle")
    )
    time = own.time[-n:]
    wanted = {
        "mean(C.force)": np.trapezoid(force, time) / (time[-1] - time[0]),
        "rms(crank.torque)": np.sqrt(np.trapezoid(torque**2, time) / (time[-1] - time[0])),
        "range(follower.angle)": np.ptp(angle),
        "min(kinetic_energy)": own.series["kinetic_energy"].values[-n:].min(),
    }
    for name, value in wanted.items():
        assert found.values(name)[1] == pytest.approx(value, rel=1e-9), name
    assert found.measures["mean(C.force)"] == "N" and found.measures["range(follower.angle)"] == "rad"
    if last == 1:
        assert found.values("C.force.max")[1] == own.measures["C.force.max"] >= force.max()
