"""What ideal joints open by in a step and how their rows turn, against the joints' own equations in complex
numbers, one kind beside the other.
"""

import cmath
import dataclasses
import math
from dataclasses import dataclass

import numpy as np
import pytest

from vfife import Mechanism
from vfife.assembly.assemble import assemble
from vfife.compiler.trace.tables import tables
from vfife.kernels.arrays import CONSTRAINT, CONSTRAINT_INDEX, HEADER, JOINT_INDEX, PARTICLE, SYSTEM
from vfife.kernels.closing import (
    GAIN,
    close_by_newton,
    closure_error,
    linearisation_error,
    newton,
    residual,
    turn_driven,
)
from vfife.kernels.constraint import levers
from vfife.kernels.elementary import sincos, turned
from vfife.kernels.topology import (
    ACROSS_LINE,
    ALONG_LINE,
    FREE,
    GEARED,
    LOCKED,
    ON_PATH,
    PINNED,
    SPACED,
    UNPLACED,
    Topology,
)
from vfife.solvers.transient import run

KINDS = (
    (PINNED, FREE),
    (ACROSS_LINE, LOCKED),
    (ALONG_LINE, FREE),
    (ON_PATH, FREE),
    (SPACED, FREE),
    (UNPLACED, GEARED),
    (PINNED, LOCKED),
)
MOVED = (2, 4, 6)  # joints with a function
AIM, FROM, TO = 0.03, 0.11, 0.16  # offset of all, value of their function at t_n and at t_(n+1)
RATIO, RADIUS = -0.7, 0.8  # of the gears; of the path, an arc about (0, RADIUS) of the bearing's frame
PINS = {
    joint: (
        complex(0.1 + 0.05 * joint, -0.2),
        complex(-0.15, 0.1 + 0.03 * joint),
        cmath.rect(1.0, 0.4 + 0.2 * joint),
    )
    for joint in range(len(KINDS))
}
AT = np.array(
    [[0.0, 0.0, 0.0], [0.3, -0.2, 0.7], [0.9, 0.5, -0.4], [0.2, 0.1, 0.3]]
)  # (x, y, angle) of ground, bearing, journal, carrier
BY = np.array([[0.0, 0.0, 0.0], [0.04, 0.03, 0.09], [-0.05, 0.02, -0.11], [0.01, -0.02, 0.05]])


@dataclass
class Model:
    """The kernels' arrays with all kinds of joints between bodies 1 and 2, gears on body 3."""

    S: list[float]
    I: list[int]
    first: list[int]
    y: list[int]


@pytest.fixture
def model() -> Model:
    topology = Topology(
        particles=4, free=(1, 2, 3), trig=(1, 2, 3), joint_bearing=(1,) * len(KINDS),
        joint_journal=(2,) * len(KINDS),
        joint_place=tuple(p for p, _ in KINDS), joint_turn=tuple(t for _, t in KINDS),
        joint_path=(-1, -1, -1, 0, -1, -1, -1), joint_carrier=(0, 0, 0, 0, 0, 3, 0), path_pieces=(1,),
        joint_function=tuple(0 if k in MOVED else -1 for k in range(len(KINDS))), function_start=(0,),
        function_argument=((0, 0, 0),),
    )  # fmt: skip
    integers, layout, rows = tables(topology)
    S, I = [0.0] * rows, integers.tolist()
    for i, (x, y, angle) in enumerate(AT.tolist()):
        step = [*BY[i].tolist(), *turned(BY[i, 2])]
        values = (x, y, angle, math.cos(angle), math.sin(angle), *step, 0.8 + 0.1 * i, 3.0 + i)
        names = (
            "x",
            "y",
            "theta",
            "c",
            "s",
            "step_x",
            "step_y",
            "step_turn",
            "step_sine",
            "step_versine",
            "inverse_mass",
            "inverse_inertia",
        )
        for name, value in zip(names, values, strict=True):
            if i or name in ("c",):
                S[layout.record("particle", i) + getattr(PARTICLE, name)] = value
    for k, (bearing, journal, along) in PINS.items():
        for name, z in (("bearing", bearing), ("journal", journal), ("direction", along)):
            S[layout.row(f"joint_{name}_x", k)], S[layout.row(f"joint_{name}_y", k)] = z.real, z.imag
        S[layout.row("joint_offset", k)], S[layout.row("joint_ratio", k)] = AIM, RATIO
    S[layout.row("function_value")], S[layout.row("function_next")] = FROM, TO
    for name, value in (("x", 0.0), ("y", 0.0), ("cosine", 1.0), ("sine", 0.0), ("curvature", 1.0 / RADIUS)):
        S[layout.row(f"piece_{name}")] = value
    starts = [I[HEADER.joint] + JOINT_INDEX.SIZE * k for k in range(len(KINDS))]
    return Model(S, I, [I[r + JOINT_INDEX.first] for r in starts], [I[r + JOINT_INDEX.y] for r in starts])


def measured(q: np.ndarray, joint: int) -> list[float]:
    """What the rows of a joint measure at (x, y, angle) of all bodies."""
    bearing, journal, along = PINS[joint]
    place, turn = KINDS[joint]
    turns = [cmath.rect(1.0, angle) for angle in q[:, 2]]
    pin = complex(*q[1, :2]) + bearing * turns[1]
    apart = complex(*q[2, :2]) + journal * turns[2] - pin
    seen = apart / turns[1]
    kept = {
        PINNED: [apart.real, apart.imag], ACROSS_LINE: [(seen / along).imag],
        ALONG_LINE: [(seen / along).real],
        SPACED: [abs(apart)],
        ON_PATH: [RADIUS - abs(seen - 1j * RADIUS)], UNPLACED: [],
    }[place]  # fmt: skip
    relative = q[2, 2] - q[1, 2] if turn == LOCKED else (q[2, 2] - q[3, 2]) - RATIO * (q[1, 2] - q[3, 2])
    return kept + ([] if turn == FREE else [relative])


@pytest.mark.parametrize("joint", range(len(KINDS)))
def test_what_a_joint_opens_by(model, joint):
    levers(model.S, model.I)
    residual(model.S, model.I)
    before, after = measured(AT, joint), measured(AT + BY, joint)
    place, turn = KINDS[joint]
    for c, (old, new) in enumerate(zip(before, after, strict=True)):
        aimed = place in (ALONG_LINE, SPACED) or (turn != FREE and c == len(before) - 1)
        aim, move = (AIM + FROM * (joint in MOVED), (TO - FROM) * (joint in MOVED)) if aimed else (0.0, 0.0)
        expected = new if place == ON_PATH else new - old - move + GAIN * (old - aim)
        assert model.S[model.y[joint] + c] == pytest.approx(expected, rel=1e-12, abs=1e-15)


def gradient(joint: int, row: int, body: int) -> list[float]:
    """By (x, y, angle) of a body, where the step leads to."""
    found = []
    for axis in range(3):
        small = np.zeros_like(AT)
        small[body, axis] = 1e-6
        found.append((measured(AT + BY + small, joint)[row] - measured(AT + BY - small, joint)[row]) / 2e-6)
    return found


@pytest.mark.parametrize("joint", range(len(KINDS)))
def test_how_its_rows_turn(model, joint):
    levers(model.S, model.I)
    residual(model.S, model.I)
    for row in range(len(measured(AT, joint))):
        q = model.first[joint] + row * CONSTRAINT.SIZE
        now = {name: model.S[q + getattr(CONSTRAINT, name)] for name in ("nx", "ny", "jb", "jk", "jc")}
        more = {name: model.S[q + getattr(CONSTRAINT, f"turn_{name[1]}")] for name in now}
        after = {name: now[name] + more[name] for name in now}
        assert (after["nx"], after["ny"], after["jk"]) == pytest.approx(gradient(joint, row, 2), abs=1e-8)
        assert (-after["nx"], -after["ny"], -after["jb"]) == pytest.approx(gradient(joint, row, 1), abs=1e-8)
        assert (0.0, 0.0, -after["jc"]) == pytest.approx(gradient(joint, row, 3), abs=1e-8)


def test_what_a_correction_leaves_open(model):
    """The change of the rows times what the correction displaces, all places together."""
    S, I = model.S, model.I
    levers(S, I)
    residual(S, I)
    change = np.random.default_rng(3).uniform(-1.0, 1.0, (4, 3))
    change[0] = 0.0
    dt, k, total = 1e-2, 7e-3, 0.0
    particles = [I[I[HEADER.constraint] + getattr(CONSTRAINT_INDEX, side)] for side in ("bearing", "journal")]
    moved = []
    for body, i in zip((1, 2), particles, strict=True):
        S[i + PARTICLE.change_x], S[i + PARTICLE.change_y], S[i + PARTICLE.change_m] = change[body].tolist()
        moved.append(dt * k * change[body] * np.array([0.8 + 0.1 * body, 0.8 + 0.1 * body, 3.0 + body]))
    for joint in range(len(KINDS)):
        for row in range(0 if KINDS[joint][0] == UNPLACED else 2 if KINDS[joint][0] == PINNED else 1):
            q = model.first[joint] + row * CONSTRAINT.SIZE
            x, y, b, j = (S[q + getattr(CONSTRAINT, f"turn_{name}")] for name in "xybk")
            total += (np.dot([x, y, j], moved[1]) - np.dot([x, y, b], moved[0])) ** 2
    assert linearisation_error(S, I, dt, k) == pytest.approx(total, rel=1e-12)


def test_a_fine_step_closes_a_sixteenth_of_what_is_open() -> None:
    """A pivot that is 1 µm open at the start: positions of steps, without the constant of the kernel."""
    m = Mechanism("pendulum", gravity=(0.0, -9.81))
    rod = m.link("rod", length=1.0, mass=1.0)
    m.revolute("A", m.point("pivot", 0.0, 0.0), rod.start)
    assembly = assemble(m, 1e-5, duration=2e-4, outputs=20)
    state = assembly.state.copy()
    state[assembly.layout.row("joint_bearing_x", 0)] = -1e-6
    record = run(dataclasses.replace(assembly, state=state))
    x, angle = (record.block(f"particle_{name}")[:, 1] for name in ("x", "theta"))
    opened = x + np.cos(angle) * state[assembly.layout.row("joint_journal_x", 0)] + 1e-6
    assert opened == pytest.approx(1e-6 * (15.0 / 16.0) ** np.arange(21), rel=1e-6)


def turning_bar(coarse: int) -> tuple[list[float], list[int]]:
    """The kernels' arrays of a bar on a pin that turns by half a radian in a step, before any reaction."""
    m = Mechanism("bar", gravity=(0.0, 0.0))
    m.point("O", 0.0, 0.0)
    m.rigid_body("bar", mass=1.0, inertia=0.2, pins={"P": (-0.4, 0.1)}, velocity=(-50.0, 200.0, 500.0))
    m.revolute("O", "ground.O", "bar.P")
    assembly = assemble(m, 1e-3, duration=1e-2, force_step=True)
    integers, _, rows = tables(assembly.topology.corrected(coarse))
    S, I = assembly.state.tolist(), integers.tolist()
    S += [0.0] * (rows - len(S))
    for q in range(I[HEADER.trig], I[HEADER.trig_end]):
        S[I[q] + PARTICLE.s], S[I[q] + PARTICLE.c] = sincos(S[I[q] + PARTICLE.theta])
    levers(S, I)
    turn_driven(S, I, S[SYSTEM.step])
    return S, I


@pytest.mark.parametrize("coarse", [0, 1, 2, 3])
def test_newton_corrects_twice_and_a_coarse_step_reports_what_the_first_has_left(coarse: int) -> None:
    """Errors before each of four corrections that are made one by one, against those of one call."""
    S, I = turning_bar(coarse)
    step = S[SYSTEM.step], 1.0, 1.0
    errors = [newton(S, I, *step) for _ in range(4)]
    for much in (0.9 * errors[1], 1.1 * errors[1]):
        S, I = turning_bar(coarse)
        close_by_newton(S, I, *step, much)
        assert closure_error(S, I, *step) == errors[2] and errors[3] < 1e-3 * errors[2]
        assert S[SYSTEM.event] == (1.0 if coarse and much < errors[1] else 0.0)
