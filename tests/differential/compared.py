"""A drawn mechanism through the package and through the plain equations, and how far apart the two are."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from differential.constrained import Unfit
from differential.drawn import drawn
from differential.pencil import Drawn
from support import finer
from vfife.assembly.assemble import assemble
from vfife.assembly.assembled import Assembly
from vfife.measures.forces import joint_force, joint_moment, joint_rows
from vfife.measures.motion import velocities
from vfife.model.validation import validate
from vfife.solvers.record import Record
from vfife.solvers.transient import run

Array = np.ndarray
TIGHT, TIGHTER = (
    1e-10,
    1e-12,
)  # of a step of the plain equations: what the first leaves may add up to some 1e-8


@dataclass
class Compared:
    """At the end of a run: values by the plain equations, and by the package at a step and at half of it."""

    drawn: Drawn
    truth: dict[str, Array]
    coarse: dict[str, Array]
    fine: dict[str, Array]


def seen(one: Drawn, record: Record) -> dict[str, Array]:
    """Centres of mass and angles, velocities, accelerations, and the force and moment of each joint, at the
    last output.
    """
    where = record.assembly.bodies
    particles = [where[name].particles[0] for name in one.m.bodies]
    v = velocities(record)
    position = np.stack(
        [record.block(f"particle_{axis}")[-1, particles] for axis in ("x", "y", "theta")], axis=1
    )
    velocity = np.stack([v[axis][-1, particles] for axis in "uvw"], axis=1)
    acceleration = np.stack(
        [record.block(f"particle_{axis}")[-1, particles] for axis in ("ax", "ay", "aw")], axis=1
    )
    arms = np.array([np.subtract(where[name].center, where[name].reference) for name in one.m.bodies])
    c, s = np.cos(position[:, 2]), np.sin(position[:, 2])
    arm = np.stack([c * arms[:, 0] - s * arms[:, 1], s * arms[:, 0] + c * arms[:, 1]], axis=1)
    across = np.stack([-arm[:, 1], arm[:, 0]], axis=1)
    position[:, :2] += arm
    acceleration[:, :2] += across * acceleration[:, 2:] - arm * velocity[:, 2:] ** 2
    velocity[:, :2] += across * velocity[:, 2:]
    found = {"position": position, "velocity": velocity, "acceleration": acceleration}
    if one.system.touches:
        found["force"] = joint_force(record)[
            -1, [list(joint_rows(record)).index(touch.name) for touch in one.system.touches]
        ]
        return found
    names, force, moment = list(joint_rows(record)), joint_force(record)[-1], joint_moment(record)[-1]
    for name in one.reactions:
        if name in names:
            found[f"force of {name}"] = force[names.index(name)]
            found[f"moment of {name}"] = np.array([moment[names.index(name)]])
    return found


def truth(one: Drawn, tight: float) -> dict[str, Array]:
    """The same by the plain equations, to a tolerance; reactions where no constraint is redundant."""
    system = one.system
    q, v = system.advance(one.velocity, [one.duration], tight)[0]
    acceleration, _, multipliers, now = system.solved(one.duration, q, v)
    found = {"position": q, "velocity": v, "acceleration": acceleration}
    if system.touches:
        forces = [touch.force(now)[0] for touch in system.touches]
        found["force"] = np.array([[f.real, f.imag] for f in forces])
        return found
    if system.freedom()[1] == 0:
        for name, by in multipliers.items():
            joint = one.m.joints.get(name)
            if joint is None:
                continue
            held = [c for c in system.constraints if c.name == name]
            if type(held[0]).__name__ == "Pin":
                force, rest = by[:2], by[2:]
            else:
                n = held[0].normal * now.turn[held[0].a]
                force, rest = by[0] * np.array([n.real, n.imag]), by[1:]
            found[f"force of {name}"] = force
            found[f"moment of {name}"] = rest if len(rest) else np.zeros(1)
            one.reactions.append(name)
    return found


def taken(assembly: Assembly, loop: str) -> Record:
    """The package's run."""
    record = run(assembly, loop=loop)  # type: ignore[arg-type]
    assert record.status == "complete", record.status
    return record


def fitting(seed: int, family: str, often: int = 1) -> tuple[Drawn, dict[str, Array]]:
    """The first mechanism of a seed whose motion leads nowhere singular, and where it leads by the plain
    equations.

    These look for contacts in steps of a length of their own, and so many times as ``often``; by more than
    one they are solved more tightly too.
    """
    for again in range(20):
        one = drawn(seed, family, again)
        one.system.longest /= often
        try:
            return one, truth(one, TIGHT if often == 1 else TIGHTER)
        except Unfit:
            continue
    raise AssertionError(f"{family} {seed}: twenty mechanisms that lead to a singular position")


def stepped(one: Drawn, exact: dict[str, Array], steps: int, loop: str) -> Compared:
    """The same by the package in a number of steps and in twice as many."""
    validate(one.m)
    coarse = assemble(
        one.m, one.duration / (steps * one.finer), duration=one.duration, outputs=1, force_step=True
    )
    return Compared(
        one, exact, *(seen(one, taken(assembly, loop)) for assembly in (coarse, finer(coarse, 2)))
    )


def compared(seed: int, family: str, steps: int, loop: str = "data-driven", often: int = 1) -> Compared:
    """The mechanism of a seed by both."""
    return stepped(*fitting(seed, family, often), steps, loop)
