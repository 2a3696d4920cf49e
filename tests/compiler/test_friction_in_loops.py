"""Friction laws in the loops: one model with a joint for each law, the same bits in every loop; what a law
remembers is state.
"""

import dataclasses
import math
from functools import cache
from typing import ClassVar

import numpy as np
import pytest

from support import bits, go, journal_in_bearing, lanes, with_settings
from vfife.assembly.assemble import assemble
from vfife.assembly.assembled import Assembly
from vfife.compiler.runtime.loops import python_line
from vfife.compiler.trace.source import Gathered, dispatch
from vfife.errors import SourceError
from vfife.kernels.arrays import Layout
from vfife.kernels.blocks import FRICTION_MEMORY
from vfife.laws import FrictionLaw, LankaraniNikravesh, LuGre, Stribeck, quantity
from vfife.laws.law import Pair
from vfife.model.drivers import Torque
from vfife.model.mechanism import Mechanism

LAWS = sorted(FrictionLaw.registry.values(), key=lambda law: law.name)
CONTACT = LankaraniNikravesh(restitution=0.6, stiffness=1e9)
STEP, EVERY, OUTPUTS, INTERPRETED, LANES = 4e-6, 50, 40, 12, 4


def model(lane: int) -> Mechanism:
    """A spinning disc on an arm in a bearing of its own for every law; a driven crank, a link on it and one
    hung with clearance from that.
    """
    m = Mechanism("every law", gravity=(0.4, -9.81 - lane))
    for n, law in enumerate(LAWS):
        changes = (
            {"coefficient": 0.12 + 0.01 * lane}
            if any(field.name == "coefficient" for field in dataclasses.fields(law))
            else {}
        )
        arm = 0.02 if n % 2 else 0.0
        m.point(f"O{n}", 0.1 * n, 0.0)
        m.rigid_body(
            f"d{n}",
            mass=1.0,
            inertia=5e-5 + arm**2,
            center=(arm, 0.0),
            pins={"eye": (0.0, 0.0)},
            angle=-1.2,
            velocity=(0.4, -0.3, 9.0 - lane),
        )
        m.clearance_joint(
            f"J{n}",
            f"ground.O{n}",
            f"d{n}.eye",
            clearance=1e-4,
            bearing_radius=0.01,
            contact=CONTACT,
            friction=law(**changes),
        )
    m.point("A", 0.0, 0.5)
    m.link("crank", length=0.05, mass=1.0)
    m.link("upper", length=0.2, mass=0.8, angle=-1.2)
    m.link("lower", length=0.15, mass=0.5, angle=-0.9)
    m.revolute("A", "ground.A", "crank.start")
    m.revolute("P", "crank.end", "upper.start")
    m.clearance_joint(
        "Q",
        "upper.end",
        "lower.start",
        clearance=1e-4,
        bearing_radius=0.02,
        contact=CONTACT,
        friction=Stribeck(coefficient=0.2, static_coefficient=0.4, viscous=0.1),
    )
    m.drive("crank", speed=30.0 + lane)
    m.drivers["lower"] = Torque(body="lower", value=0.5)
    return with_settings(m, damping=2.0)


@cache
def assembled(lane: int = 0) -> Assembly:
    """A lane of the model, with a step of its own."""
    return assemble(model(lane), STEP * (1 - 0.05 * lane), duration=1e-3, force_step=True)


@cache
def computed(loop: str, width: int) -> tuple[np.ndarray, Layout, np.ndarray]:
    """Rows of so many lanes, all state and extremes; their layout and numbers."""
    runner = lanes([assembled(lane) for lane in range(width)], loop)
    rows = np.concatenate(
        [runner.advance(1, 1), runner.advance(EVERY, INTERPRETED if loop == "interpreted" else OUTPUTS)]
    )
    return rows, runner.layout, runner.row_numbers


def same(ours: np.ndarray, theirs: np.ndarray) -> bool:
    return bool((bits(ours) == bits(theirs)).all())


def test_four_lanes_are_data_driven_each():
    assert same(computed("generated", LANES)[0], computed("data-driven", LANES)[0])


@pytest.mark.system("steps in the interpreter")
def test_interpreted_is_data_driven():
    plain = computed("interpreted", 1)[0]
    assert same(plain, computed("data-driven", LANES)[0][: len(plain), :, :1])


def test_the_generated_text_is_data_driven():
    runner = lanes([assembled()], "interpreted")
    runner.take = python_line(runner.topology)(runner.memory)
    plain = np.concatenate([runner.advance(1, 1), runner.advance(EVERY, INTERPRETED)])
    assert same(plain, computed("data-driven", LANES)[0][: len(plain), :, :1])


def test_every_law_has_something_to_do():
    """In the part that is interpreted already: every joint is struck and lets go, rubs and remembers; no loop
    agrees on nothing.
    """
    rows, layout, kept = computed("data-driven", LANES)
    assert np.isfinite(rows).all()
    where = {int(row): k for k, row in enumerate(kept)}

    def block(name: str, part: int = 0) -> np.ndarray:
        return rows[:, [where[int(row) + part] for row in layout[name]]]

    names = [law.name for law in LAWS]
    early = block("contact_friction_work")[INTERPRETED, :, 0]
    assert all((early[k] > 0) == (name != "none") for k, name in enumerate(names))
    assert block("contact_onsets")[-1, : len(names)].min() >= 1
    assert (block("contact_normal_force")[:, : len(names)] == 0).any()
    for k, law in enumerate(LAWS):
        for part in range(FRICTION_MEMORY):
            assert block("contact_memory", part)[:, k].any() == (part < len(law.memory)), (law.name, part)


# ----------------------------------------------------------------------------------------------------- memory


def test_memory_is_state_and_in_pieces_as_in_one():
    """All its rows are kept and checkpointed; a run in pieces has the bits of a run in one."""
    layout = computed("data-driven", LANES)[1]
    rows = {int(row) + part for row in layout["contact_memory"] for part in range(FRICTION_MEMORY)}
    assert rows <= set(layout.of("state"))
    whole, pieces = (lanes([assembled()], "generated") for _ in range(2))
    whole.advance(600, 1)
    for count in (1, 7, 592):
        pieces.advance(count, 1)
    state = layout.of("state")
    assert same(whole.states[state], pieces.states[state])


def test_bristles_spring_back_where_nothing_presses():
    """A journal strikes, slides and leaves: its memory lives while the normal force does and is nothing
    after.
    """
    m = journal_in_bearing(contact=CONTACT, friction=LuGre())
    m.bodies["journal"] = dataclasses.replace(m.bodies["journal"], inertia=1e-4, velocity=(1.0, 0.0, 30.0))
    record = go(m, 5e-7, duration=2e-3, outputs=4000)
    normal = record.block("contact_normal_force")[:, 0]
    where = {int(row): k for k, row in enumerate(record.row_numbers)}
    first = record.assembly.layout.row("contact_memory")
    memory = record.rows[:, [where[first + part] for part in range(3)]]
    pressed = normal > 0.0
    assert pressed.sum() > 100 and not pressed[-1]
    assert (memory[pressed] != 0.0)[2:].all(axis=1).any() and (memory[~pressed] == 0.0).all()


@dataclasses.dataclass(frozen=True)
class Counting(FrictionLaw):
    """A law from elsewhere with one number to remember: how many steps the contact has lasted, up to which it
    rubs more.
    """

    slots: ClassVar[tuple[str, ...]] = ("coefficient",)
    memory: ClassVar[tuple[str, ...]] = ("steps (1)",)
    coefficient: float = quantity("1", "friction coefficient", 1e-5)

    def parameters(self, pair: Pair) -> tuple[float, ...]:
        return (self.coefficient,)

    @staticmethod
    def force(normal_force, free_velocity, mobility, memory, dt, p):
        limit = p[0] * memory * normal_force
        return (-limit if free_velocity > 0.0 else limit), memory + 1.0


def test_a_law_with_one_number_remembers_a_number():
    Counting.name = "counting"
    m = journal_in_bearing(contact=CONTACT, friction=Counting())
    m.bodies["journal"] = dataclasses.replace(m.bodies["journal"], inertia=1e-4, velocity=(1.0, 0.0, 300.0))
    record = go(m, 5e-7, duration=2e-3, outputs=4000, loop="interpreted")
    normal, friction, steps = (
        record.block(f"contact_{name}")[:, 0] for name in ("normal_force", "friction_force", "memory")
    )
    pressed = np.flatnonzero(normal > 0.0)
    assert (steps[pressed] == np.arange(1, len(pressed) + 1)).all() and steps[-1] == 0.0
    assert np.abs(friction[pressed]) == pytest.approx(
        1e-5 * (steps[pressed] - 1) * normal[pressed], rel=1e-14
    )
    assert math.copysign(1.0, friction[pressed[5]]) == -1.0


def test_a_law_that_remembers_too_much_is_told_so():
    class Elephant(Counting):
        name: ClassVar[str] = ""
        memory: ClassVar[tuple[str, ...]] = ("a (m)", "b (m)", "c (m)", "d (m)")

    with pytest.raises(SourceError, match="remembers 4 numbers; a law may remember 3"):
        dispatch("friction", (Elephant,), Gathered())
