"""What the answers of maps say beyond the kind of a motion: longer periods, transients, loads that end."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import vfife
from vfife.dynamics.basins import few_points
from vfife.dynamics.sections import PoincareSection, SectionSpec, poincare_section
from vfife.errors import ModelError
from vfife.measures.chaos import exponent, verdict
from vfife.report.dynamics import _longer_periods


def pendulum(**load: Any) -> vfife.Mechanism:
    """A damped pendulum beside a rotor of 6 rad/s; its moment is 0.9 N m times the expression."""
    m = vfife.Mechanism("forced pendulum", gravity=(0, -9.81))
    rod = m.link("rod", length=0.3, mass=0.5, angle="-90 deg")
    m.revolute("hinge", m.point("P", 0, 0), rod.start)
    m.torsional_spring("air", "ground", "rod", damping="0.01 N m s/rad")
    rotor = m.rigid_body("rotor", mass=0.1, inertia=1e-4, position=(0.5, 0))
    m.revolute("shaft", m.point("Q", 0.5, 0), rotor.pin())
    m.drive(rotor, speed=6.0)
    m.moment("force", "rod.end", moment=0.9, **load)
    return m


def test_a_period_whose_points_alternate_may_be_longer() -> None:
    """Points of an oscillator that grazes a wall alternate by 0.21 % of the range of its motion."""
    points = np.tile([1.256009, 1.261962], 30)
    decaying = exponent(np.full(60, -0.08))
    motions = [
        ("0.77725 rad/s (up)", verdict(points, decaying, ranges=lambda: np.array([2.83]))),
        ("0.778 rad/s (up)", verdict(points, decaying, ranges=lambda: np.array([0.01]))),
        ("0.775 rad/s (up)", verdict(np.full(60, 1.2), decaying, ranges=lambda: np.array([2.83]))),
    ]
    assert [motion.kind for _, motion in motions] == ["period 1", "period 2", "period 1"]
    (sentence,) = _longer_periods(motions)
    assert sentence.startswith("Period 1 may be period 2 at 0.77725 rad/s (up): ")
    assert "by up to 0.21 % of the motion's range" in sentence and not _longer_periods(motions[1:])
    assert "(up) and 2 more: " in _longer_periods(motions[:1] * 10)[0]


def test_a_transient_at_the_begin_of_a_section_is_named() -> None:
    growth = np.array([2.0] * 40 + [-0.3] * 60)
    spec = SectionSpec("", 150, 50, ("rod.angle",), 1.0, 100, (), ("rad",))

    def section(finer: Any) -> PoincareSection:
        points = np.ones((100, 1))
        return PoincareSection.of("pendulum", spec, [(points, growth, np.zeros((0, 6)), finer)])

    later = section(growth).later_exponent
    assert later is not None and later.value == pytest.approx(-0.3)
    assert section(np.where(np.arange(100) < 97, growth, 90.0)).later_exponent is None, "not known either"
    assert section(np.zeros(0)).later_exponent is None, "without companions no range is known"


@pytest.mark.parametrize(
    ("load", "ends"),
    [
        ({"expression": "sin(6*t)", "times": [0, 2]}, True),
        ({"expression": "sin(6*t)", "times": [0, 10]}, False),
        ({"expression": "sin(6*t)", "times": [0, math.pi / 3], "repeat": True}, False),
        ({"expression": "cos(angle)", "crank": "rotor", "angles": [0, "360 deg"]}, False),
    ],
)
def test_a_load_that_ends_before_the_motion_is_named(load: dict[str, Any], ends: bool) -> None:
    """Six turns of the rotor take 6.3 s, and a chain of two values twice as long."""
    m, sentence = pendulum(**load), "keeps its last value after that, in a motion of about"
    given: Any = {"turns": 6, "step": 2e-3}
    assert (sentence in " ".join(str(poincare_section(m, **given)).split())) is ends
    chain = vfife.bifurcation(m, "load.force.moment", 0.8, 0.9, count=2, companions=0, **given)
    assert (sentence in " ".join(str(chain).split())) is (ends or load.get("times") == [0, 10])


def test_an_expression_that_oscillates_too_often_is_refused_with_the_way() -> None:
    with pytest.raises(ModelError, match="of a function that repeats to one period, with repeat = true"):
        pendulum(expression="sin(6*t)", times=[0, 1000])


def test_few_recorded_turns_are_named_before_the_work() -> None:
    assert "here 99, chaos beside other motions is not decided: 300 turns" in few_points(99)
    assert few_points(100) == ""


def test_wrong_names_of_a_start_are_refused_with_those_of_the_model(tmp_path: Path) -> None:
    m = pendulum(expression="cos(angle)", crank="rotor", angles=[0, "360 deg"])
    for path in ("start.pin.x", "start.rod"):
        with pytest.raises(ModelError, match=rf"starts\[1\].*{path}: a start has no number"):
            vfife.bifurcation(m, "load.force.moment", 0.3, 1.5, count=2, starts=[{}, {path: 1e-3}])
    with pytest.raises(ModelError, match="there is no such folder"):
        poincare_section(m, turns=6, file=tmp_path / "none" / "a.map")
    axes = ("start.crank", 0.0, 1.0), ("body.rod.angle", 0.0, 1.0)
    with pytest.raises(ModelError, match=r"exponents = \"no\""):
        vfife.dynamics.basins(m, *axes, exponents="no")  # type: ignore[arg-type]
