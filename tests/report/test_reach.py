"""What is told of a driver that leads a mechanism past its reach: the position, not a smaller step."""

import math
import re

import pytest

from vfife import simulate
from vfife.assembly.assemble import assemble
from vfife.kinematics.passage import passage
from vfife.model.drivers import AngleTable, ConstantSpeed
from vfife.model.mechanism import Mechanism
from vfife.report.divergence import cause, end_of_reach
from vfife.solvers.record import Record
from vfife.solvers.transient import run

CRANK, ROD, GUIDE = 0.1, 0.3, 0.25


def slider_crank(play: bool = False) -> Mechanism:
    """Driven at the block, whose guide is counted from a point 0.25 m from the pivot."""
    m = Mechanism("slider-crank")
    m.point("O", 0.0, 0.0)
    m.point("G", GUIDE, 0.0)
    m.link("crank", length=CRANK, mass=1.0, angle=0.5)
    m.link("rod", length=ROD, mass=1.0, angle=-0.2)
    m.rigid_body("block", mass=1.0, inertia=1e-3)
    m.revolute("O", "ground.O", "crank.start")
    m.revolute("A", "crank.end", "rod.start")
    if play:
        m.clearance_joint("B", "rod.end", "block.center", clearance=1e-4, bearing_radius=0.01)
    else:
        m.revolute("B", "rod.end", "block.center")
    m.slider("S", "ground.G", "block.center")
    m.drivers["push"] = ConstantSpeed(slider="S", speed=0.16)
    return m


def driven_on(mechanism: Mechanism, step: float, duration: float) -> Record:
    """A run that nobody looked ahead for, as those of mechanisms too large for it are; a look ahead sees
    where it jams.
    """
    jam, _ = passage(mechanism, duration, lengths=False)
    assert jam is not None
    return run(assemble(mechanism, step, duration=duration, outputs=50, force_step=True), loop="data-driven")


@pytest.mark.system("bisects a travel")
@pytest.mark.parametrize("play", [False, True])
def test_a_travel_past_a_dead_centre_names_the_position(play):
    """Crank and rod in line: the pin is at CRANK + ROD from the pivot."""
    step = 2e-6 if play else 1e-4
    record = driven_on(slider_crank(play), step, 0.3)
    assert record.status == "diverged" or play
    said = cause(record, 0.3)
    assert f"joint S at {CRANK + ROD - GUIDE:.6g} m along its guide" in said
    time, gone = (
        float(found) for found in re.search(r"at ([\d.]+) s .* ([\d.]+) m from where it began", said).groups()
    )
    assert gone == pytest.approx(0.16 * time, rel=1e-5)
    assert "No step size helps" in said and "half the step" not in said


@pytest.mark.system("bisects a travel")
def test_an_angle_past_its_limit_is_named():
    """A four-bar whose crank cannot turn fully: coupler and follower in line at acos of the
    law of cosines.
    """
    m = Mechanism("rocker")
    m.point("A", 0.0, 0.0)
    m.point("D", 0.5, 0.0)
    m.link("crank", length=0.4, mass=1.0, angle=0.6)
    m.link("coupler", length=0.3, mass=1.0, angle=0.5)
    m.link("follower", length=0.35, mass=1.0, angle=1.2)
    m.revolute("A", "ground.A", "crank.start")
    m.revolute("B", "crank.end", "coupler.start")
    m.revolute("C", "coupler.end", "follower.end")
    m.revolute("D", "ground.D", "follower.start")
    m.drivers["crank"] = AngleTable(body="crank", times=(0.0, 1.0), values=(0.6, 3.0))
    record = driven_on(m, 1e-4, 1.0)
    most = math.degrees(math.acos((0.4**2 + 0.5**2 - 0.65**2) / (2.0 * 0.4 * 0.5)))
    assert f"crank at {most:.6g} degrees" in end_of_reach(record, 1.0)


def test_nothing_is_said_of_what_closes():
    m = slider_crank()
    m.drivers["push"] = ConstantSpeed(slider="S", speed=-0.05)
    assert (
        end_of_reach(
            simulate(m, step=1e-4, duration=0.1, outputs=5, reference=False, loop="data-driven").record, 0.1
        )
        == ""
    )
