"""Mechanisms and readings that several tests share. Reference numbers stay in the tests that use them."""

from __future__ import annotations

import dataclasses
import math
import os
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from one_loop import compiled_already
from vfife.assembly.assemble import assemble
from vfife.assembly.assembled import Assembly
from vfife.compiler.runtime.runner import Runner
from vfife.laws import Ambrosio, ContactLaw, LankaraniNikravesh
from vfife.model.bodies import Link, RigidBody, Section
from vfife.model.mechanism import Mechanism
from vfife.solvers.record import Record, recorded_rows
from vfife.solvers.refinement import with_step
from vfife.solvers.transient import run

CRANK_SPEED = 50.0 * math.pi  # rad/s, the paper's fastest
TURN = 0.04  # s, one turn of that crank
SQUARE = Section.square(1e-3)  # the links of the paper: A = 1e-3 m^2
EPS = 2.0**-52
# steps of a run for which no straight line is compiled: what that takes is the time of some 400,000 steps of
# the data-driven loop
FEW = 300_000
SHARE = 1.0 if os.environ.get("VFIFE_EXAMPLES") == "all" else 0.2  # of the examples of a property in one run


def often(examples: int) -> int:
    """How many examples of a property are tried in this run: a share of them, all in `make soak`."""
    return round(SHARE * examples)


def rounds(count: int, fewer: int = 1) -> int:
    """How often a race is run, or by how many: fewer times in `make test` than in `make soak`, for which the
    test is marked ``rounds``.
    """
    return count if SHARE == 1.0 else fewer


def four_bar(
    clear: str = "BCD",
    model: str = "rigid",
    *,
    contact: Any = None,
    friction: Any = None,
    clearance: float = 2e-4,
    speed: float = CRANK_SPEED,
    joint: dict[str, Any] | None = None,
    below: bool = False,
    mirrored: bool = False,
    exchanged: bool = False,
    crank_angle: float = 0.0,
    **link: Any,
) -> Mechanism:
    """The paper's four-bar (Table 1): joints B, C, D with clearance where ``clear`` names them, the defaults
    of cases b and c elsewhere.

    ``model`` and ``link`` are those of coupler and follower. ``below`` chooses the other branch (joint C
    below the line of the ground pivots); ``mirrored`` turns that and the crank's sense round; ``exchanged``
    swaps bearing and journal of B, C and D.
    """
    side = -1.0 if below != mirrored else 1.0
    sense = -1.0 if mirrored else 1.0
    m = Mechanism("four-bar")
    m.point("A", 0.0, 0.0)
    m.point("D", 0.15, 0.0)
    m.link("crank", length=0.4, mass=3.12, angle=sense * crank_angle)
    m.link("coupler", length=0.26, mass=2.028, angle=side * math.radians(51), model=model, **link)
    m.link("follower", length=0.46, mass=3.588, angle=side * math.radians(26), model=model, **link)
    m.revolute("A", "ground.A", "crank.start")
    options = {
        "clearance": clearance,
        "bearing_radius": 0.01,
        "contact": contact or LankaraniNikravesh(restitution=0.9, stiffness=6.6e10),
        "friction": friction or Ambrosio(coefficient=0.1, v0=1e-4, v1=1e-2),
    } | (joint or {})
    for name, *ends in (
        ("B", "crank.end", "coupler.start"),
        ("C", "coupler.end", "follower.end"),
        ("D", "ground.D", "follower.start"),
    ):
        sides = ends[::-1] if exchanged else ends
        if name in clear:
            m.clearance_joint(name, *sides, **options)
        else:
            m.revolute(name, *sides)
    m.drive("crank", speed=sense * speed)
    return m


def journal_in_bearing(speed: float = 1.0, mass: float = 1.0, **joint: Any) -> Mechanism:
    """A free journal that flies from the centre of a fixed bearing against its wall."""
    m = Mechanism("journal in bearing")
    m.point("O", 0.0, 0.0)
    m.point_mass("journal", mass=mass, velocity=(speed, 0.0, 0.0))
    m.clearance_joint(
        "J", "ground.O", "journal.center", **{"clearance": 5e-4, "bearing_radius": 0.01, **joint}
    )
    return m


CONTACT_LAWS = sorted(
    (law for law in ContactLaw.registry.values() if law.__module__.startswith("vfife.")),
    key=lambda law: law.name,
)
# Values of the parameters that laws have no default for.
GIVEN = {"stiffness": 2e9, "exponent": 1.4, "damping_coefficient": 2e3, "full_damping_depth": 3e-5}
GIVEN |= {"loading": tuple((d * 1e-6, 6.6e10 * (d * 1e-6) ** 1.5) for d in (0, 1, 3, 10, 30, 100, 300))}


def contact_law(law: Any, **parameters: Any) -> Any:
    """A contact law with those of the parameters that it knows, and a value for what has no default; a film
    is as good as none.
    """
    parameters = {"viscosity": 1e-12} | parameters
    fields = dataclasses.fields(law)
    needed = {f.name: GIVEN[f.name] for f in fields if f.default is dataclasses.MISSING}
    return law(**needed | {f.name: parameters[f.name] for f in fields if f.name in parameters})


def with_settings(mechanism: Mechanism, **settings: Any) -> Mechanism:
    """The mechanism with other settings (damping, path_unit ...)."""
    return dataclasses.replace(mechanism, settings=dataclasses.replace(mechanism.settings, **settings))


def go(mechanism: Mechanism, step: float, *, loop: str = "auto", **options: Any) -> Record:
    """Assembles and runs; every run of a test must come to its end."""
    return went(assemble(mechanism, step, force_step=True, **options), loop)


def went(assembly: Assembly, loop: str = "auto") -> Record:
    """The run of what is assembled.

    A short one is taken by the data-driven loop, which is compiled once for all tests and gives the bits of
    the straight line; that would take longer to compile than it saves. Loops are compared in
    ``tests/codegen``, and `make verify` leaves the choice to the package.
    """
    if loop == "auto" and assembly.choice.steps < FEW and compiled_already(assembly.topology):
        loop = "data-driven"
    record = run(assembly, loop=loop)  # type: ignore[arg-type]
    assert record.status == "complete"
    return record


def finer(assembly: Assembly, times: int) -> Assembly:
    """The same with so many times as many steps; nothing else of a start depends on its step, and it is not
    assembled anew.
    """
    choice = dataclasses.replace(
        assembly.choice,
        step=assembly.choice.step / times,
        outputs_every=times * assembly.choice.outputs_every,
    )
    return dataclasses.replace(with_step(assembly, choice.step), choice=choice)


def times(record: Record) -> np.ndarray:
    """Times (s) of the outputs."""
    return record.steps * record.assembly.choice.step


def within(record: Record, first: float, last: float) -> np.ndarray:
    """Outputs after ``first`` up to ``last`` (s): their extremes are those of the steps in between."""
    t, slack = times(record), 0.5 * record.assembly.choice.step
    return (t > first + slack) & (t <= last + slack)


def largest_alpha(record: Record, body: str, window: np.ndarray) -> float:
    """Largest absolute angular acceleration (rad/s^2) of a body."""
    return float(record.block("body_alpha_max")[window, record.assembly.bodies[body].row].max())


def largest_force(record: Record, joint: str, window: np.ndarray) -> float:
    """Largest force (N) in a joint."""
    a = record.assembly
    for names, block in ((a.contacts, "contact"), (a.ideals, "joint"), (a.pivots, "driven")):
        if joint in names:
            return math.sqrt(record.block(f"{block}_force_squared_max")[window, names.index(joint)].max())
    raise KeyError(joint)


def onsets(record: Record) -> list[int]:
    """Contacts that began in each clearance joint."""
    return [int(value) for value in record.block("contact_onsets")[-1]]


def particle(record: Record, name: str, which: int = 0) -> dict[str, np.ndarray]:
    """Recorded motion of a particle of a body: x, y, theta at n, u, v, w at n + 1/2."""
    index = record.assembly.bodies[name].particles[which]
    return {axis: record.block(f"particle_{axis}")[:, index] for axis in ("x", "y", "theta", "u", "v", "w")}


def pin(record: Record, name: str, at: str) -> np.ndarray:
    """Path of a pin of a body, or of a point of the ground, shape (outputs, 2), from recorded positions and
    the body's geometry.
    """
    if name == "ground":
        return np.tile(record.assembly.mechanism.points[at], (len(record.steps), 1))
    where = record.assembly.bodies[name]
    if where.elements:
        p = particle(record, name, 0 if at == "start" else -1)
        return np.stack([p["x"], p["y"]], axis=1)
    p = particle(record, name)
    rx, ry = np.subtract(where.pins[at], where.reference)
    c, s = np.cos(p["theta"]), np.sin(p["theta"])
    return np.stack([p["x"] + c * rx - s * ry, p["y"] + s * rx + c * ry], axis=1)


def joint_gap(record: Record, joint: str) -> float:
    """Largest distance (m) between the two pins of a joint over all outputs."""
    bearing, journal = (pin(record, *side) for side in record.assembly.mechanism.joints[joint].sides)
    return float(np.linalg.norm(journal - bearing, axis=1).max())


def lanes(
    assemblies: Sequence[Assembly], loop: str, parts: int = 8, shares: Sequence[float] | None = None
) -> Runner:
    """A runner over assemblies of one topology, one lane each, that keeps what a run keeps."""
    first = assemblies[0]
    if any(a.topology != first.topology for a in assemblies):
        raise ValueError("lanes must share a topology")
    states = np.stack([a.state for a in assemblies], axis=1)
    tables = np.stack([a.tables for a in assemblies])
    beside = None if shares is None else np.array(shares)
    return Runner(first.topology, states, tables, loop, recorded_rows(first), parts=parts, shares=beside)


def bits(values: np.ndarray) -> np.ndarray:
    """The bits of numbers, the two zeros taken as one."""
    return (np.asarray(values) + 0.0).view(np.int64)


def order(errors: Sequence[float], ratio: float = 2.0) -> list[float]:
    """Orders of convergence between neighbours of a sequence of errors, the step divided by ``ratio`` each
    time.
    """
    return [
        math.log(coarse / fine) / math.log(ratio) for coarse, fine in zip(errors, errors[1:], strict=False)
    ]


def observed(function: Callable[[float], Any], steps: Sequence[float]) -> list[Any]:
    """A function at each step size."""
    return [function(step) for step in steps]


def mirrored(mechanism: Mechanism) -> Mechanism:
    """The mirror image at the x axis: y, angles, moments and senses of rotation turned round."""

    def flip(point: tuple[float, float]) -> tuple[float, float]:
        return point[0], -point[1]

    def body(b: Any) -> Any:
        changes = {
            "angle": -b.angle,
            "velocity": (b.velocity[0], -b.velocity[1], -b.velocity[2]),
            "position": b.position and flip(b.position),
        }
        if isinstance(b, RigidBody):
            changes |= {"center": flip(b.center), "pins": {name: flip(at) for name, at in b.pins.items()}}
        if isinstance(b, Link):
            changes |= {"pins": {name: flip(at) for name, at in b.pins.items()}}
        return dataclasses.replace(b, **changes)

    def driver(d: Any) -> Any:
        name = {"Torque": "value", "AngleTable": "values"}.get(type(d).__name__, "speed")
        value = getattr(d, name)
        return dataclasses.replace(
            d, **{name: tuple(-v for v in value) if isinstance(value, tuple) else -value}
        )

    return dataclasses.replace(
        mechanism,
        gravity=flip(mechanism.gravity),
        points={name: flip(at) for name, at in mechanism.points.items()},
        bodies={name: body(b) for name, b in mechanism.bodies.items()},
        drivers={name: driver(d) for name, d in mechanism.drivers.items()},
        loads={
            name: dataclasses.replace(load, force=flip(load.force), moment=-load.moment)
            for name, load in mechanism.loads.items()
        },
    )


TURNED_ROUND = {
    "particle_y", "particle_theta", "particle_v", "particle_w", "particle_ay", "particle_aw",
    "frame_moment_1", "frame_moment_2", "reference_sine", "reference_theta_1", "reference_theta_2",
    "reference_moment_1", "reference_moment_2", "contact_friction_force", "contact_memory", "joint_fy",
    "driven_torque", "driven_fy", "body_alpha", "function_value", "function_rate", "function_acceleration",
    "function_next",
}  # fmt: skip
