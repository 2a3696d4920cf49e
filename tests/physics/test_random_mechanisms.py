"""Mechanisms that nobody drew: trees and loops with joints of every kind, springs, loads and drivers, as
hypothesis makes them up.

Each is closed or refused in words; what runs keeps its joints closed, its energy and momentum accounted for,
and the same bits as plain Python.
"""

from __future__ import annotations

import dataclasses
import math
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, assume, given, settings
from hypothesis import strategies as st

from choice import default_cases
from support import finer, often
from vfife.assembly.assemble import assemble
from vfife.assembly.assembled import Assembly
from vfife.kinematics.drives import rigid_system
from vfife.kinematics.initial import ideal_motion
from vfife.kinematics.system import equations
from vfife.laws import Ambrosio, Coulomb, Frictionless, LankaraniNikravesh
from vfife.measures.energy import ledger
from vfife.measures.motion import velocities
from vfife.model.bodies import RigidBody, Section
from vfife.model.drivers import AngleTable, ConstantSpeed, Harmonic, Ramp, StepTo, Torque
from vfife.model.functions import carrier_of
from vfife.model.loads import PointForce
from vfife.model.mechanism import Mechanism
from vfife.model.validation import validate
from vfife.modelfile import dump, loads
from vfife.solvers.record import Record
from vfife.solvers.transient import run

SIZE = 1.0  # m, of a body
STEP = 1e-4  # s
STEPS = 120
few = settings(
    max_examples=often(150), deadline=None, derandomize=True, suppress_health_check=list(HealthCheck)
)
fewer = settings(few, max_examples=6)

place = st.tuples(st.floats(-0.5, 0.5), st.floats(-0.5, 0.5))
angle = st.floats(-3.0, 3.0)
SOFT = LankaraniNikravesh(restitution=0.8, stiffness=1e6)


def turned(at: tuple[float, float], by: float) -> np.ndarray:
    c, s = math.cos(by), math.sin(by)
    return np.array([c * at[0] - s * at[1], s * at[0] + c * at[1]])


class Builder:
    """Draws a mechanism body by body; each body is put where its first joint is closed."""

    def __init__(self, draw: st.DrawFn, gravity: bool = True) -> None:
        self.draw, self.m = (
            draw,
            Mechanism(
                "drawn",
                gravity=draw(st.tuples(st.floats(-10, 10), st.floats(-10, 10))) if gravity else (0.0, 0.0),
            ),
        )
        self.origin: dict[str, np.ndarray] = {"ground": np.zeros(2)}
        self.angle = {"ground": 0.0}
        self.count = 0

    def fresh(self, letter: str) -> str:
        self.count += 1
        return f"{letter}{self.count}"

    def pin(self, body: str, world: np.ndarray) -> str:
        """A pin of a rigid body, or a point of the ground, at a place of the start."""
        name, (x, y) = self.fresh("p"), turned(tuple(world - self.origin[body]), -self.angle[body])
        if body == "ground":
            self.m.point(name, x, y)
            return f"ground.{name}"
        noun = self.m.bodies[body]
        assert isinstance(noun, RigidBody)
        noun.pins[name] = (float(x), float(y))
        return f"{body}.{name}"

    def body(self, **more: Any) -> str:
        name, turn = self.fresh("b"), self.draw(angle)
        at = np.array(self.draw(st.tuples(st.floats(-2, 2), st.floats(-2, 2))))
        self.m.rigid_body(
            name, mass=self.draw(st.floats(0.3, 3.0)), inertia=self.draw(st.floats(0.05, 0.5)),
            center=self.draw(place), angle=turn, position=(float(at[0]), float(at[1])), **more,
        )  # fmt: skip
        self.origin[name], self.angle[name] = at, turn
        return name

    def at(self, body: str) -> np.ndarray:
        """A place near a body."""
        return self.origin[body] + np.array(self.draw(place)) * SIZE

    def join(self, one: str, two: str, kinds: tuple[str, ...]) -> str:
        """A joint that is closed as the two bodies stand, and its kind."""
        kind, name, where = self.draw(st.sampled_from(kinds)), self.fresh("j"), self.at(two)
        bearing, journal = self.pin(one, where), self.pin(two, where)
        way = self.draw(angle)
        if kind == "revolute":
            self.m.revolute(name, bearing, journal)
        elif kind == "weld":
            self.m.weld(name, bearing, journal)
        elif kind in ("slider", "slot"):
            self.m.slider(
                name, bearing, journal, direction=(math.cos(way), math.sin(way)), turning=kind == "slot"
            )
        elif kind == "clearance":
            law = self.draw(
                st.sampled_from(
                    [Frictionless(), Coulomb(coefficient=0.2), Ambrosio(coefficient=0.1, v0=1e-3, v1=1e-2)]
                )
            )
            self.m.clearance_joint(
                name,
                bearing,
                journal,
                clearance=self.draw(st.floats(1e-4, 1e-2)),
                bearing_radius=0.05,
                contact=SOFT,
                friction=law,
            )
        elif kind == "guide":
            self.m.clearance_slider(
                name, bearing, journal, clearance=1e-3, length=0.2, height=0.1, contact=SOFT,
                friction=Coulomb(coefficient=0.1),
                direction=(math.cos(way), math.sin(way)),
            )  # fmt: skip
        return kind

    def spring(self, one: str, two: str) -> None:
        kind, name = self.draw(st.sampled_from(["spring", "torsional", "bushing", "stop"])), self.fresh("s")
        stiff, damping = self.draw(st.floats(0.0, 300.0)), self.draw(st.floats(0.1, 10.0))
        if kind == "torsional":
            self.m.torsional_spring(name, one, two, stiffness=stiff, damping=damping)
        elif kind == "stop":
            self.m.stop(
                name,
                one,
                two,
                low=-5.0,
                high=self.draw(st.floats(-4.0, 4.0)),
                stiffness=1.0 + stiff,
                damping=damping,
            )
        else:
            first, second = self.pin(one, self.at(one)), self.pin(two, self.at(two))
            if kind == "spring":
                self.m.spring(name, first, second, stiffness=stiff, damping=damping)
            else:
                self.m.bushing(
                    name, first, second, stiffness=(stiff, 100.0, 10.0), damping=(damping, 1.0, 0.5)
                )


def motion(draw: st.DrawFn, **target: Any) -> Any:
    """A driver of any kind that prescribes a motion."""
    return draw(
        st.sampled_from(
            [
                ConstantSpeed(**target, speed=3.0),
                Ramp(**target, speed=-4.0, duration=0.01),
                StepTo(**target, travel=0.3, duration=0.02),
                Harmonic(**target, amplitude=0.1, frequency=20.0, phase=0.4),
                AngleTable(**target, times=(0.0, 0.01, 0.02), values=(0.0, 0.05, -0.02)),
            ]
        )
    )


IDEAL = ("revolute", "revolute", "revolute", "slider", "slot", "weld")


@st.composite
def mechanisms(
    draw: st.DrawFn, kinds: tuple[str, ...] = IDEAL, *, loops: bool = True, grounded: bool = True
) -> Mechanism:
    """A tree, with springs and loads, closed by further joints to loops."""
    b = Builder(draw, gravity=grounded)
    names: list[str] = []
    own = {} if grounded else {"velocity": (0.5, -0.3, 1.0)}
    for k in range(draw(st.integers(1 if grounded else 2, 4))):
        name = b.body(**own)
        if grounded or k:
            b.join(draw(st.sampled_from([*names, "ground"] if grounded else names)), name, kinds)
        names.append(name)
    for _ in range(draw(st.integers(0, 2))):
        one, two = draw(st.permutations([*names, "ground"] if grounded else names))[:2]
        b.spring(one, two)
    m = b.m
    if not grounded:
        return m
    if loops and draw(st.booleans()) and len(names) > 1:
        one, two = draw(st.permutations(names))[:2]
        b.join(one, two, ("revolute", "slot"))
    if draw(st.booleans()) and len(names) > 1:
        one, two = draw(st.permutations(names))[:2]
        m.gear(b.fresh("g"), one, two, ratio=draw(st.sampled_from([-1.0, -0.4, 2.0])))
    m.loads["load"] = PointForce(
        name="load",
        at=b.pin(names[-1], b.at(names[-1])),
        force=draw(st.tuples(st.floats(-20, 20), st.floats(-20, 20))),
        moment=draw(angle),
        follow=draw(st.booleans()),
    )
    pivots = [
        j.journal.partition(".")[0]
        for j in m.joints.values()
        if type(j).__name__ == "IdealRevolute" and j.bearing.startswith("ground")
    ]
    sliders = [j.name for j in m.joints.values() if type(j).__name__ == "Slider"]
    what = draw(st.sampled_from(["none", "torque", "angle", "travel"]))
    if what == "torque":
        m.drivers["motor"] = Torque(body=names[0], value=(3.0, 0.0), speeds=(0.0, 20.0))
    elif what == "angle" and pivots and pivots.count(pivots[0]) == 1:
        m.drivers["motor"] = motion(draw, body=pivots[0])
    elif what == "travel" and sliders:
        m.drivers["motor"] = motion(draw, slider=sliders[0])
    return m


def built(m: Mechanism, step: float = STEP) -> Assembly:
    """The assembled mechanism; one that cannot be is refused in words that name something of it."""
    try:
        validate(m)
        assembly = assemble(m, step, duration=STEPS * step, outputs=STEPS // 10, force_step=True)
    except ValueError as error:
        named = [*m.bodies, *m.joints, *m.gears, *m.drivers, *m.springs, *m.loads]
        assert any(name in str(error) for name in named) and len(str(error)) > 40, error
        assume(False)
    return assembly


def gaps(record: Record) -> float:
    """Largest opening (m, or rad times 1 m) of the ideal joints over the run, from the positions of the
    bodies alone.
    """
    m, where = record.assembly.mechanism, record.assembly.bodies
    places = {name: record.block(f"particle_{name}") for name in ("x", "y", "theta")}

    def pose(body: str) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        if body == "ground":
            return (np.zeros(len(record.steps)),) * 3
        k = where[body].particles[0]
        return places["x"][:, k], places["y"][:, k], places["theta"][:, k]

    def point(side: tuple[str, str]) -> np.ndarray:
        x, y, turn = pose(side[0])
        at = np.array(m.points[side[1]] if side[0] == "ground" else m.bodies[side[0]].points[side[1]])
        at = at - (np.zeros(2) if side[0] == "ground" else np.array(where[side[0]].reference))
        return np.array(
            [x + np.cos(turn) * at[0] - np.sin(turn) * at[1], y + np.sin(turn) * at[0] + np.cos(turn) * at[1]]
        )

    worst = 0.0
    for joint in m.joints.values():
        kind = type(joint).__name__
        if kind not in ("IdealRevolute", "Slider", "Weld"):
            continue
        apart = point(joint.sides[1]) - point(joint.sides[0])
        turn = pose(joint.sides[1][0])[2] - pose(joint.sides[0][0])[2]
        if kind == "Slider":
            x, y = turned(joint.direction, 0.0) / math.hypot(*joint.direction)
            base = pose(joint.sides[0][0])[2]
            across = apart[1] * (np.cos(base) * x - np.sin(base) * y) - apart[0] * (
                np.sin(base) * x + np.cos(base) * y
            )
            worst = max(worst, float(np.abs(across).max()))
        else:
            worst = max(worst, float(np.abs(apart).max()))
        if kind == "Weld" or (kind == "Slider" and not joint.turning):
            worst = max(worst, float(np.ptp(turn)))
    for gear in m.gears.values():
        arm = pose(carrier_of(m, gear))[2]  # what is drawn may hang both wheels on a third body
        worst = max(
            worst, float(np.ptp(pose(gear.second)[2] - arm - gear.ratio * (pose(gear.first)[2] - arm)))
        )
    return worst


def calm(record: Record) -> bool:
    """Whether the motion is resolved by the step, and near no dead centre: forces are those of such bodies,
    turns in a step are small.
    """
    spin = np.abs(record.block("particle_w")).max(initial=0.0)
    force = max(
        np.abs(record.block(name)).max(initial=0.0) for name in ("joint_fx", "joint_fy", "joint_moment")
    )
    return record.status == "complete" and spin * STEP < 0.02 and force < 1e5


@few
@given(mechanisms())
def test_ideal_mechanisms_stay_closed_and_account_for_their_energy(m: Mechanism) -> None:
    assembly = built(m)
    assume(not assembly.mobility.singular)
    record = run(assembly, loop="data-driven")
    assume(calm(record))
    assert np.isfinite(record.rows).all()
    half = run(finer(assembly, 2), loop="data-driven")
    # What a step's corrections leave open falls with its fourth power; where a motion begins abruptly it may
    # be a little more.
    opened = gaps(record), gaps(half)
    assert opened[0] < 1e-9 or (opened[0] < 1e-8 and opened[1] < opened[0] / 8.0), opened
    errors = [float(np.abs(ledger(one).residual).max()) for one in (record, half)]
    largest = max(ledger(record).largest, 1e-3)
    assert errors[0] < 1e-4 * largest, (errors, largest)
    assert errors[1] < 0.35 * errors[0] + 1e-8 * largest, (errors, largest)


@few
@given(mechanisms())
def test_degrees_of_freedom_are_those_of_a_numerical_jacobian(m: Mechanism) -> None:
    """3 n less the rank, by singular values, of differences of the gaps of all joints and gears."""
    assembly = built(m)
    system = rigid_system(m)
    at = ideal_motion(m).position
    free = at[1:].size

    def open_by(q: np.ndarray) -> np.ndarray:
        return equations(system, np.vstack([np.zeros(3), q.reshape(-1, 3)]), np.zeros_like(at)).phi[
            : system.joint_rows
        ]

    q, h = at[1:].ravel(), 1e-6
    jacobian = np.array(
        [(open_by(q + h * e) - open_by(q - h * e)) / (2.0 * h) for e in np.eye(free)]
    ).T.reshape(-1, free)
    values = np.linalg.svd(jacobian, compute_uv=False) if jacobian.size else np.zeros(0)
    assume(not ((values > 1e-7) & (values < 1e-4)).any())  # nearly singular: rank is a matter of taste
    assert assembly.mobility.free == free - int((values > 1e-5).sum())


@few
@given(mechanisms(("revolute", "slider", "slot", "weld", "clearance", "guide"), grounded=False))
def test_what_floats_keeps_its_momentum(m: Mechanism) -> None:
    assembly = built(m, 2e-5)
    record = run(assembly, loop="data-driven")
    assume(record.status == "complete" and np.abs(record.block("particle_w")).max() < 200.0)
    v, x, y = velocities(record), record.block("particle_x")[:, 1:], record.block("particle_y")[:, 1:]
    mass, inertia = (
        1.0 / record.parameter("particle_inverse_mass")[1:],
        1.0 / record.parameter("particle_inverse_inertia")[1:],
    )
    u, w, r = v["u"][:, 1:], v["v"][:, 1:], v["w"][:, 1:]
    fastest, farthest = (sum(float(np.abs(one).max()) for one in some) for some in ((u, w, r), (x, y)))
    scale = fastest * float(mass.sum() + inertia.sum()) * (1.0 + farthest)
    assert np.ptp(u @ mass) < 1e-11 * scale
    assert np.ptp(w @ mass) < 1e-11 * scale
    assert np.ptp((x * w - y * u) @ mass + r @ inertia) < 1e-7 * scale


@fewer
@given(mechanisms((*IDEAL, "clearance", "guide")))
def test_plain_python_gives_the_same_bits(m: Mechanism) -> None:
    rows, assembly = [], assemble_short(m)
    for loop in ("data-driven", "interpreted"):
        with np.errstate(all="ignore"):
            rows.append(run(assembly, loop=loop).rows)
    assert rows[0].tobytes() == rows[1].tobytes()


def assemble_short(m: Mechanism) -> Assembly:
    whole = built(m)
    return dataclasses.replace(whole, choice=dataclasses.replace(whole.choice, outputs_every=2, outputs=3))


@few
@given(mechanisms((*IDEAL, "clearance", "guide")))
def test_its_file_gives_it_back(m: Mechanism) -> None:
    built(m)
    assert loads(dump(m)) == m


@pytest.mark.parametrize(
    "elements", default_cases([1, 3], lambda elements: elements == 3, "draws chains of single elements, too")
)
@fewer
@given(
    st.lists(st.tuples(angle, st.floats(0.3, 1.0)), min_size=1, max_size=3), st.sampled_from([-3.0, 0.5, 5.0])
)
def test_chains_of_elastic_links_account_for_their_energy(
    elements: int, chain: list[tuple[float, float]], spin: float
) -> None:
    m = Mechanism("chain", gravity=(0.0, -9.81))
    m.point("O", 0.0, 0.0)
    last = "ground.O"
    section = Section.square(1e-4)
    for k, (turn, length) in enumerate(chain):
        m.link(f"l{k}", length=length, angle=turn, model="elastic", elements=elements, section=section)
        m.revolute(f"j{k}", last, f"l{k}.start")
        last = f"l{k}.end"
    m.drivers["l0"] = ConstantSpeed(body="l0", speed=spin)
    record = run(assemble(m, duration=0.002, outputs=20), loop="data-driven")
    assert record.status == "complete" and np.isfinite(record.rows).all()
    assert ledger(record).error < 1e-4
