"""Answers about a motion whose turns differ: a forced pendulum that strikes a stop, of period 2 with a moment
of 0.9 N m and of period 1 with 1.2 N m, as sections and an independent integration with events have it.
"""

from __future__ import annotations

import io
import math
import re
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from rich.console import Console

import vfife
from vfife.cli.commands.result import contents
from vfife.report.digits import plain_number, range_text, turns_text
from vfife.report.document import Facts
from vfife.report.run_file import info
from vfife.report.run_tables import reaction
from vfife.report.summary import show
from vfife.simulation.result import Result
from vfife.solvers.repeating import Points, alternation

PERIOD = 2.0 * math.pi / 6.0  # s, of the crank


def pendulum(amplitude: float) -> vfife.Mechanism:
    m = vfife.Mechanism("stop pendulum", gravity=(0.0, -9.81))
    rotor = m.rigid_body("rotor", mass=0.1, inertia=1e-4, position=(0.5, 0.0))
    rod = m.link("rod", length=0.3, mass=0.5, angle="-90 deg")
    m.revolute("hinge", m.point("P", 0.0, 0.0), rod.start)
    m.revolute("shaft", m.point("Q", 0.5, 0.0), rotor.pin())
    m.torsional_spring("air", "ground", "rod", damping="0.01 N m s/rad")
    m.stop(
        "wall",
        "ground",
        "rod",
        low="-150 deg",
        high="-70 deg",
        stiffness="400 N m/rad",
        damping="0.5 N m s/rad",
    )
    m.moment(
        "force", "rod.end", moment=amplitude, expression="cos(angle)", crank="rotor", angles=[0, "360 deg"]
    )
    m.drive(rotor, speed=6.0)
    return m


@cache
def run(amplitude: float, turns: int, step: Any = "auto", **options: Any) -> Result:
    return vfife.simulate(pendulum(amplitude), turns=turns, step=step, **options)


def words(result: Result) -> str:
    return " ".join(str(result).split())


def peaks(result: Result) -> np.ndarray:
    """Largest force of the hinge in each of the last turns, cut at the times of the turns (N)."""
    forces = np.sqrt(result.record.block("joint_force_squared_max")[:, 0])
    turn = np.ceil(result.time / PERIOD - 1e-6).astype(int)  # an output belongs to the turn that it ends
    return np.array([forces[turn == k].max() for k in range(31, 41)])


@pytest.mark.parametrize("step", ["auto", "100 us"])
def test_no_turn_of_period_two_exceeds_what_is_shown(step: str) -> None:
    """A step of 100 us does not divide a turn of 1.047 s, and its turns are of period 2 all the same."""
    result = run(0.9, 40, step)
    high, low = peaks(result).max(), peaks(result).min()
    assert high > 1.1 * low, "every second turn has another largest force"
    force, motion = result.measures["hinge.force.max"], result.motion
    assert motion is not None and (motion.motion, motion.period) == ("periodic", 2)
    assert motion.peaks_only == (step != "auto") and motion.scatters == (step == "auto")
    assert force.lowest <= low and force.highest >= high
    assert force.low <= force <= force.high and force == pytest.approx(0.5 * (high + low), rel=2e-3)
    text = words(result)
    assert "period 2 · means over turns" in text and "the turns repeat in pairs" in text
    assert re.search(r"single turns 84\.\d+ to 94\.\d+\)", repr(force)), repr(force)
    ends = re.search(r"hinge +([\d.]+) N +([\d.]+) to ([\d.]+) N", text)
    assert ends is not None, text
    mean, lowest, highest = (float(end) for end in ends.groups())
    assert lowest <= low and high <= highest and highest - lowest < 1.05 * (high - low)
    assert mean == pytest.approx(force, abs=5e-3 * force) and "forces and torques" in text
    assert "means of forces and torques change by" in text
    assert ("does not divide a turn" in text) == (step != "auto")


def test_a_mean_that_scatters_has_two_digits_beside_its_range() -> None:
    """As the ends of its range: 662 N of 604 to 709 N is 660, not 700."""
    bounds = {"low": 604.0, "high": 709.0, "lowest": 636.0, "highest": 765.0, "estimated": True}
    names = (
        "big.force.max",
        "small.force.max",
        "near.force.max",
        "rod.angular_acceleration.max",
        "big.penetration.max",
    )
    values = (662.3, 476.4, 96.2, 6234.0, 1.58e-6)
    summary = {
        "measures": dict(zip(names, values, strict=True)),
        "ranges": {names[0]: bounds, names[1]: bounds | {"low": 323.0, "high": 608.0}}
        | {names[2]: bounds | {"low": 90.0, "high": 105.0}, names[3]: bounds | {"low": 0.0, "high": 15000.0}}
        | {names[4]: bounds | {"low": 1.19e-6, "high": 2.09e-6}},
        "turns": {"motion": "not repeating"}, "not_estimated": [], "not_unique": [],
    }  # fmt: skip
    assert [plain_number(summary, name) for name in names] == ["660", "480", "96", "6200", "1.6e-06"]
    shown = [reaction(summary, name, summary["measures"][name]) for name in names[:4]]
    assert shown == ["660 N", "480 N", "96 N", "6,200 rad/s²"]
    summary["about_zero"] = {names[2]: 100.0}
    assert plain_number(summary, names[2]) == "100" and reaction(summary, names[2], 96.2) == "about 0"


def test_every_printed_mean_lies_in_its_range(tmp_path: Path) -> None:
    result = run(0.9, 40)
    summary = result.summary
    for name in ("hinge.force.max", "rod.angular_acceleration.max"):
        low, high = (float(end) for end in range_text(summary, name).split(" to "))
        assert low <= float(plain_number(summary, name).replace(",", "")) <= high
    result.save(tmp_path / "run.sqlite")
    document = info(contents(tmp_path / "run.sqlite"), measures=True)
    texts = [value for part in document.parts if isinstance(part, Facts) for _, value in part.rows]
    rows = dict(text.split(" = ") for text in texts if ".max = " in text)
    assert "single turns 84." in rows["hinge.force.max"] and "single turns" not in rows["shaft.force.max"]


@pytest.mark.parametrize("turns", [40, 41, 60, 120])
def test_turns_that_scatter_with_the_step_are_periodic(turns: int) -> None:
    """At the automatic step the output at which the stop is met differs from turn to turn."""
    for amplitude, period in ((1.2, 1), (0.9, 2)):
        result = run(amplitude, turns)
        motion = result.motion
        assert motion is not None and (motion.motion, motion.period) == ("periodic", period)
        assert motion.distance < motion.tolerance
        assert "not repeating" not in words(result)
    section = vfife.dynamics.poincare_section(pendulum(1.2), turns=60)
    assert section.verdict.period == 1


def test_the_long_answer_says_that_turns_scatter() -> None:
    stream = io.StringIO()
    show(Console(file=stream, width=200), run(1.2, 40))
    assert re.search(
        r"repeats itself every turn, and turns 21 to 40 scatter .* by 0\.0\d+ %", stream.getvalue()
    )
    assert turns_text(run(1.2, 40).summary, "hinge.force.max", "N")
    assert not turns_text(run(1.2, 40).summary, "shaft.force.max", "N")


def test_a_study_takes_means_of_turns_that_end_between_outputs() -> None:
    """Its step does not divide a turn; the last ten turns are five of each of the two."""
    found = vfife.study(
        pendulum(0.9), {"load.force.moment": [0.9]}, ["hinge.force.max"], turns=40, last=10, step="100 us"
    )
    assert found.values("hinge.force.max")[0] == pytest.approx(peaks(run(0.9, 40, "100 us")).mean(), rel=1e-4)


def test_a_motion_that_alternates_about_its_limit_still_settles() -> None:
    """Its deviation is multiplied by -0.84 a turn, as an independent integration has it: turns agree in pairs
    for a while, and in the end all do.
    """
    values = np.array([[1.0 + 0.06 * (-0.844) ** n] for n in range(25)])
    distance, decay = alternation(Points(values, np.ones(1)), 2)
    assert decay == pytest.approx(0.156, abs=1e-9) and distance == pytest.approx(
        abs(np.diff(values[-2:, 0]))[0]
    )
    ends = np.array([[1.0 + 0.1 * (-1.0) ** n * (1.0 + 0.5**n)] for n in range(25)])
    assert alternation(Points(ends, np.ones(1)), 2) is None


def test_a_pendulum_that_alternates_is_not_of_period_two() -> None:
    """With a longer and lighter rod and another stop the moment of 0.9 N m excites a motion of period 1."""
    m = vfife.Mechanism("settling pendulum", gravity=(0.0, -9.81))
    rod = m.link("rod", length=0.35, mass=0.4, angle="-90 deg")
    m.revolute("hinge", m.point("P", 0.0, 0.0), rod.start)
    m.torsional_spring("air", "ground", "rod", damping="0.01 N m s/rad")
    limits = {"low": "-200 deg", "high": "-75 deg"}
    m.stop("wall", "ground", "rod", **limits, stiffness="400 N m/rad", damping="0.5 N m s/rad")
    rotor = m.rigid_body("rotor", mass=0.1, inertia=1e-4, position=(0.5, 0.0))
    m.revolute("shaft", m.point("Q", 0.5, 0.0), rotor.pin())
    m.drive(rotor, speed=6.0)
    angles = {"crank": "rotor", "angles": [0, "360 deg"]}
    m.moment("force", "rod.end", moment=0.9, expression="cos(angle)", **angles)
    result = vfife.simulate(m, turns=30)
    assert result.motion.motion == "settling" and 0.10 < result.motion.decay < 0.2
    assert "Period 2" not in words(result) and "the difference shrinks by 1" in words(result)
    assert run(0.85, 30).motion.period == 2 and "Period 2" in words(run(0.85, 30))
