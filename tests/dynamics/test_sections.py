"""Sections against a billiard in a circle, whose bounces are known; pieces that go on; starts and steps that
are changed on the way.
"""

import dataclasses
import math
import sqlite3

import numpy as np
import pytest

import vfife
from vfife.dynamics import load_map
from vfife.dynamics.sections import poincare_section
from vfife.dynamics.start_states import StartStates
from vfife.errors import ModelError, VfifeError
from vfife.laws import Ambrosio, Frictionless, LankaraniNikravesh
from vfife.modelfile import load
from vfife.report.dynamics import document
from vfife.simulation.turn_steps import with_steps
from vfife.solvers.impact_section import COLUMNS, ImpactSection
from vfife.solvers.turn_runner import TurnRunner, restepped

CLEARANCE, SPEED = 1e-3, 0.4
LOOSE = "examples/slider_crank_loose_pin.toml"


def billiard(offset: float) -> vfife.Mechanism:
    """A journal that flies in its bearing without gravity and loses nothing, beside a crank that turns."""
    m = vfife.Mechanism("billiard")
    m.point("O", 0.0, 0.0)
    m.point("P", 1.0, 0.0)
    m.link("crank", length=0.1, mass=0.1)
    m.revolute("P", "ground.P", "crank.start")
    m.drive("crank", speed=100.0)
    m.rigid_body(
        "ball",
        mass=0.1,
        inertia=1e-5,
        position=(offset, 0.0),
        velocity=(0.0, SPEED, 0.0),
        pins={"pin": (0.0, 0.0)},
    )
    law = LankaraniNikravesh(restitution=1.0, stiffness=2e10)
    m.clearance_joint(
        "O",
        "ground.O",
        "ball.pin",
        clearance=CLEARANCE,
        bearing_radius=0.01,
        contact=law,
        friction=Frictionless(),
    )
    return m


@pytest.fixture(scope="module")
def flown():
    """A section at impacts of a ball that begins 0.6 clearances off the middle, across it."""
    m = billiard(0.0)
    start = StartStates(m, 6000).at({"start.O.x": 0.6 * CLEARANCE, "start.O.vy": SPEED})
    found = ImpactSection.of(start, (0,)).find_onsets(*begun(start), 30_000)
    return dict(zip(COLUMNS, found.T, strict=True))


def begun(start):
    """State and steps after the first one."""
    runner = TurnRunner([start]).runner
    runner.advance(1, 1)
    return runner.states[:, 0].copy(), runner.done


def test_bounces_in_a_circle_turn_by_one_angle(flown) -> None:
    """A chord at distance d from the middle of a circle of radius c is seen from there under 2 acos(d / c),
    and so is the next; the speed of approach is v sqrt(1 - (d / c)^2); the first bounce is at acos(d / c),
    after c sin of it over v.
    """
    half = math.acos(0.6)
    assert len(flown["place"]) >= 40 and (flown["count"] == 1.0).all()
    assert flown["place"][0] == pytest.approx(half, abs=2e-4)
    assert flown["time"][0] == pytest.approx(CLEARANCE * math.sin(half) / SPEED, rel=2e-4)
    turned = np.mod(np.diff(flown["place"]), 2.0 * math.pi)
    assert turned == pytest.approx(
        2.0 * half, abs=0.03
    )  # the journal presses in for a while at each bounce, and goes on across
    assert flown["speed"][0] == pytest.approx(SPEED * math.sin(half), rel=1e-4)
    assert flown["speed"] == pytest.approx(SPEED * math.sin(half), rel=0.02)
    assert flown["crank"] == pytest.approx(100.0 * flown["time"], rel=1e-12)


def test_the_journal_begins_where_and_as_fast_as_it_is_told() -> None:
    """From the velocities of both bodies: the journal's in the frame of its bearing; the crank stands and
    turns as it is driven.
    """
    m = load(LOOSE)
    at, rate = np.array([2e-4, -3e-4]), np.array([0.7, -0.4])
    numbers = dict(
        zip(("start.pin.x", "start.pin.y", "start.pin.vx", "start.pin.vy"), [*at, *rate], strict=True)
    )
    start = StartStates(m, 6000).at({"start.crank": 1.0, **numbers})
    layout, state = start.layout, start.state
    read = lambda name, body: float(state[layout.row(f"particle_{name}", start.bodies[body].particles[0])])  # noqa: E731
    angle, w = read("theta", "rod"), read("w", "rod")
    c, s = math.cos(angle), math.sin(angle)
    arm = np.array([[c, -s], [s, c]]) @ (np.array([0.12, 0.0]) - np.array(start.bodies["rod"].center))
    bearing = np.array([read("x", "rod"), read("y", "rod")]) + arm
    moving = np.array([read("u", "rod") - w * arm[1], read("v", "rod") + w * arm[0]])
    apart = np.array([read("x", "block"), read("y", "block")]) - bearing
    relative = np.array([read("u", "block"), read("v", "block")]) - moving
    turn = np.array([[c, s], [-s, c]])
    assert turn @ apart == pytest.approx(at, abs=1e-12)
    seen = turn @ relative + w * np.array([(turn @ apart)[1], -(turn @ apart)[0]])
    assert seen == pytest.approx(rate, abs=1e-5)
    assert read("theta", "crank") == pytest.approx(1.0, abs=1e-12) and read("w", "crank") == pytest.approx(
        100.0
    )
    with pytest.raises(ModelError, match="outside its bearing"):
        StartStates(m, 6000).at({"start.pin.x": 0.6e-3})


def test_a_step_is_changed_under_way_without_a_jolt() -> None:
    """What a harmonic oscillation differs by with a third and with twice the step is what steps of second
    order leave, (1 - 1/9) and (1 - 4) parts of one error; a jolt in its velocity would be of first order, and
    a thousand times as large. With the same step nothing changes.
    """
    from dynamics.test_maps import oscillator

    m = oscillator(damping=0.0)
    once = with_steps(m, 4000)
    runner = TurnRunner([once]).runner
    runner.advance(1, 1)
    runner.advance(1234, 1)
    state, done = runner.states[:, 0].copy(), runner.done
    layout = once.layout
    same, number = restepped(state, done, once)
    rows = layout.of("state", "parameter")
    assert number == done and same[rows] == pytest.approx(state[rows], rel=1e-12, abs=1e-12)
    x = layout.row("particle_x", once.bodies["block"].particles[0])
    runner.advance(400, 1)
    reached = float(runner.states[x, 0])
    off = []
    for factor in (3.0, 0.5):
        other = with_steps(m, round(factor * 4000))
        begun_, number = restepped(state, done, other)
        again = TurnRunner([other]).runner
        again.states[:, 0], again.done = begun_, number
        again.advance(round(400 * factor), 1)
        off.append(float(again.states[x, 0]) - reached)
    assert abs(off[0]) < 5e-8 and off[1] / off[0] == pytest.approx(-27.0 / 8.0, rel=1e-3)


SHORT = {"turns": 9, "dropped": 3, "step": 1e-5, "joints": ("pin",)}


def loose() -> vfife.Mechanism:
    """A slider-crank whose pin strikes its bearing, by coarse steps."""
    return load(LOOSE, set=[("joint.pin.contact.restitution", 0.3)])


def test_a_section_is_the_run_of_its_own_and_misses_no_impact() -> None:
    """Points are those of a simulation; as many contacts begin, with the mean speed, as the step counts
    itself.
    """
    found = poincare_section(loose(), **SHORT)
    step = 2.0 * math.pi / 100.0 / found.spec.steps
    alone = vfife.simulate(
        loose(), turns=10, outputs=1, step=step, companions=0, reference=False, force_step=True
    )
    assert np.array_equal(found.points["pin.force_max"], alone.series["pin.force_max"].values[5:11])
    record, struck = alone.record, found.struck["pin"]
    for block, value in (
        ("contact_onsets", struck["count"].sum()),
        ("contact_approach", (struck["count"] * struck["speed"]).sum()),
    ):
        assert value == pytest.approx(float(record.block(block)[10, 0] - record.block(block)[4, 0]), rel=1e-9)
    assert len(found.growth) == 6 and found.verdict.kind == "chaotic" and "exponent" in found.verdict.evidence


def test_the_place_is_seen_from_a_bearing_that_turns() -> None:
    """Where outputs at every step show the journal pressing, in the frame of the rod, right
    after each onset.
    """
    steps = 6284
    start, step = with_steps(loose(), steps), 2.0 * math.pi / 100.0 / steps
    struck = dict(
        zip(COLUMNS, ImpactSection.of(start, (0,)).find_onsets(*begun(start), steps).T, strict=True)
    )
    alone = vfife.simulate(
        loose(), turns=1, outputs=steps, step=step, companions=0, reference=False, force_step=True
    )
    after = np.ceil(struck["time"] / step).astype(int)
    seen = alone.series["pin.contact_angle"].values[after]
    assert (
        len(after) > 3 and np.abs(np.mod(struck["place"] - seen + 1.0, 2.0 * math.pi) - 1.0).max() < 0.01
    )  # as far as it goes in a step


def test_a_section_goes_on_where_it_was_broken_off(tmp_path, monkeypatch) -> None:
    """To the bit, in the turns that are dropped and in those that are looked at."""
    from vfife.solvers import impact_section

    monkeypatch.setattr(impact_section, "TURNS", 2)
    monkeypatch.setattr(impact_section, "ALIGNED", 1)
    whole = poincare_section(loose(), **SHORT, file=tmp_path / "whole.map")

    def stop(after: int):
        def told(done: int, of_all: int) -> None:
            if done >= after:
                raise KeyboardInterrupt

        return told

    for after in (2, 3, 5, 7):
        try:
            poincare_section(loose(), **SHORT, file=tmp_path / "a.map", progress=stop(after))
        except KeyboardInterrupt:
            assert after <= 3
    rest = poincare_section(loose(), **SHORT, file=tmp_path / "a.map")
    for found in (rest, load_map(tmp_path / "a.map")):
        assert np.array_equal(found.growth, whole.growth)
        assert len(found.finer) == 6 and np.array_equal(found.finer, whole.finer)
        assert all(np.array_equal(found.points[name], whole.points[name]) for name in whole.points)
        assert all(
            np.array_equal(found.struck["pin"][name], whole.struck["pin"][name])
            for name in whole.struck["pin"]
        )
    with pytest.raises(VfifeError, match="with another specification"):
        poincare_section(loose(), **{**SHORT, "turns": 10}, file=tmp_path / "a.map")
    rest.write_csv(tmp_path / "a.csv")
    assert len((tmp_path / "a.csv").read_text().splitlines()) == 1 + 6
    assert len((tmp_path / "a.impacts.csv").read_text().splitlines()) == 1 + len(whole.struck["pin"]["time"])


@pytest.mark.system("follows 260 turns of two motions")
def test_the_range_of_an_exponent_holds_that_of_a_fine_step() -> None:
    """Of the shipped slider-crank: 5.31 in a thousand turns of half a microsecond. A step of ten microseconds
    makes it half as large again, and its halves agree within 3 %.
    """
    model = load(LOOSE)
    for step, turns, dropped in ((1e-5, 200, 50), (2e-6, 60, 20)):
        found = poincare_section(model, turns=turns, dropped=dropped, step=step).exponent
        assert found.low <= 5.31 <= found.high
        assert found.low < min(found.halves) and found.high > max(found.halves)


@pytest.mark.filterwarnings("ignore::vfife.errors.DamageWarning")
def test_a_section_of_a_former_file_says_that_its_step_is_not_judged(tmp_path) -> None:
    """Without the second motion there is no range; the same call computes it."""
    path = tmp_path / "a.map"
    whole = poincare_section(loose(), **SHORT, file=path)
    with sqlite3.connect(path) as file:
        file.execute("delete from arrays where key like 'finer%'")
    before = load_map(path)
    assert not before.exponent.estimated and "step: not estimated" in before.verdict.evidence
    assert np.array_equal(before.growth, whole.growth) and before.verdict.kind == whole.verdict.kind
    after = poincare_section(loose(), **SHORT, file=path)
    assert np.array_equal(after.finer, whole.finer) and after.exponent.low == whole.exponent.low


def test_what_cannot_be_looked_at_is_told() -> None:
    for words, said in (
        ({"joints": ("guide",)}, "joint with clearance"),
        ({"dropped": 9}, "no turn remains"),
        ({"series": ("pin.forc",)}, "pin.force"),
    ):
        with pytest.raises(ModelError, match=said):
            poincare_section(loose(), **{**SHORT, **words})


def test_a_section_stopped_in_its_discarded_turns_is_shown(tmp_path, monkeypatch) -> None:
    """The call returns it, and its file is read, drawn and written; the same call continues it."""
    from vfife.solvers import impact_section

    def stop(done: int, of_all: int) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(impact_section, "TURNS", 2)
    part = poincare_section(loose(), **SHORT, file=tmp_path / "a.map", progress=stop)
    for found in (part, load_map(tmp_path / "a.map")):
        dropped = found.spec.dropped
        assert found.done == 0 and f"nothing recorded yet, the first {dropped} turns are discarded" in str(
            found
        )
        assert found.verdict.kind == "not decided" and found.plot() and len(list(found.table())) == 1
    assert poincare_section(loose(), **SHORT, file=tmp_path / "a.map").done == part.planned


def test_an_unknown_series_has_the_names_of_its_body() -> None:
    with pytest.raises(ModelError, match=r"Name one of ball\.x, ball\.y, .*ball\.u, ball\.v"):
        poincare_section(billiard(0.0), turns=3, series=["ball.velocity_x"])


def test_a_load_that_ends_with_the_first_turn_is_a_caution() -> None:
    m = billiard(0.0)
    m.moment(
        "push", "ball.center", moment=1e-6, expression="angle", crank=next(iter(m.drivers.values())).body
    )
    text = str(document(poincare_section(m, turns=3, step=1e-5)))
    assert "keeps its last value in all later turns" in text


def test_a_coefficient_of_zero_is_no_friction() -> None:
    m = billiard(0.0)
    assert "friction none" in poincare_section(m, turns=3, step=5e-5).laws
    m.joints["O"] = dataclasses.replace(m.joints["O"], friction=Ambrosio(coefficient=0.0))
    assert poincare_section(m, turns=3, step=5e-5).laws.endswith(", no friction")


def test_a_difference_that_decays_fast_is_followed_for_any_number_of_turns() -> None:
    """A damped rod, with c T/(2 J) = 5; e^-5 a turn leaves the range of numbers after 140 turns."""
    m = vfife.Mechanism("damped rod", gravity=(0.0, 0.0))
    rod = m.link("rod", length=1.0, mass=3.0)
    m.revolute("hinge", m.point("P", 0.0, 0.0), rod.start)
    m.torsional_spring("spring", "ground", "rod", stiffness=100.0, damping=10.0)
    rotor = m.rigid_body("rotor", mass=0.1, inertia=1e-3, position=(2.0, 0.0))
    m.revolute("shaft", m.point("Q", 2.0, 0.0), rotor.pin())
    m.drive(rotor, speed=math.tau)
    m.moment("force", "rod.end", moment=0.9, expression="cos(angle)", crank="rotor", angles=[0, "360 deg"])
    found = poincare_section(m, turns=250, dropped=10, step=2e-3)
    assert found.exponent is not None and found.exponent.low <= -5.0 <= found.exponent.high
    assert found.exponent.value == pytest.approx(-5.0, abs=0.01)
