"""Likely causes of a divergence: step, time, quantity and remedy, and a position that the drivers cannot
pass.
"""

from __future__ import annotations

import math
import re
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ..assembly.assemble import assemble
from ..assembly.assembled import Bounds
from ..compiler.runtime.runner import Runner
from ..errors import AssemblyError, VfifeError
from ..kernels.blocks import BLOCKS
from ..kinematics.drives import constraint_drivers, kinematic_drivers
from ..kinematics.forces import Datum, driven_body
from ..kinematics.initial import datum_of, ideal_motion
from ..measures.energy import own_floor
from ..model.drivers import Driver
from ..model.functions import motion_function
from ..model.mechanism import Mechanism
from ..model.surfaces import surfaces
from ..solvers.record import Record
from ..solvers.status import Status

if TYPE_CHECKING:
    from ..assembly.assembled import Assembly
    from ..results.run_data import RunData

Array = NDArray[np.float64]
HALVINGS = 30  # of the time between a position that closes and one that does not
WAY_POINTS = 50  # positions on the way
SMOOTH_STEPS = 20  # before a number leaves its bounds, in which a penetration is followed
# Of the limit of a penetration, its largest change in a step: a step that is too large for a contact makes it
# leap, by a tenth of the limit and more.
SMOOTH = 0.02
LARGE_STEP = 4.0  # times the automatic step, beyond which a step is a likely cause

FLOOR = (
    "the error of elements of the present length does not depend on the step; use more elements, or strain ="
    ' "reference" for them'
)

# Forces come first: where a step makes several quantities infinite, a force is the cause.
ENTITIES = ("contact", "frame", "spring", "joint", "driven", "function", "system", "body", "particle")


def diverged(record: Record) -> str:
    """Return why a run diverged: step, time, quantity and remedy."""
    choice = record.assembly.choice
    if soft := soft_contact(record):
        return soft
    step, name = first_infinite(record)
    return f"in step {step:,}, at {step * choice.step:.6g} s, {name}. {cause(record, step * choice.step)}"


def first_infinite(record: Record) -> tuple[int, str]:
    """Return the step and name of the first number that exceeded its bounds.

    If it was not recorded, the steps after the last sound output are repeated one by one.
    """
    if record.burst is not None:
        event = "grew without bound" if record.burst.finite else "became infinite"
        return record.burst.step, f"{quantity_name(record.assembly, record.burst.rows)} {event}"
    step, rows, bad = last_steps(record)
    if not bad.any():
        return step, "a number of the state grew without bound"
    event = "became infinite" if not np.isfinite(rows[-1]).all() else "grew without bound"
    return step, f"{quantity_name(record.assembly, record.row_numbers[bad])} {event}"


def last_steps(record: Record) -> tuple[int, list[Array], NDArray[np.bool_]]:
    """Repeat the steps after the last sound output up to the first with a number beyond its bounds. Return
    that step, the rows of the last :data:`SMOOTH_STEPS` steps at most, and which rows are beyond.
    """
    assembly, last = record.assembly, int(record.steps[-1])
    state = assembly.state.copy()
    state[record.row_numbers] = record.rows[-1]
    loop = "generated" if record.loop == "generated" else "data-driven"  # the one that is compiled
    runner = Runner(
        assembly.topology,
        state[:, None],
        assembly.tables[None, :],
        loop,
        record.row_numbers,
        parts=assembly.mechanism.settings.parts,
    )
    runner.done = last + 1  # step 0, which makes output 0, is one of those that were made
    limits, states = Bounds(assembly, record.row_numbers), [record.rows[-1]]
    for step in range(last + 1, last + assembly.choice.outputs_every + 1):
        rows = runner.advance(1, 1)[:, :, 0]
        states = [*states[1 - SMOOTH_STEPS :], rows[0].copy()]
        bad = limits.unsound(rows)[0]
        if bad.any():
            return step, states, bad
    return last + assembly.choice.outputs_every, states, np.zeros(len(record.row_numbers), dtype=bool)


def soft_contact(record: Record) -> str:
    """Return a sentence on a contact whose penetration rose smoothly to its bound: too soft, or overloaded;
    "" where another number, the step, or a position that the drivers cannot pass ended a run.
    """
    assembly = record.assembly
    choice = assembly.choice
    if not assembly.contacts or record.status != Status.DIVERGED or choice.step > choice.stable:
        return ""
    step, rows, bad = last_steps(record)
    columns = {int(row): k for k, row in enumerate(record.row_numbers)}
    depths = [columns[int(row)] for row in assembly.layout["contact_penetration"]]
    contacts = [k for k, column in enumerate(depths) if bad[column]]
    if not contacts or not np.isfinite(rows[-1]).all():
        return ""
    index = contacts[0]
    joint = assembly.mechanism.contacts[assembly.contact_joints[index]]
    course = _depths_before(record, rows, depths[index])
    rise = float(np.abs(np.diff(course)).max()) / joint.reach
    if rise > SMOOTH or end_of_reach(record, (step + 1) * assembly.choice.step):
        return ""
    misfit = joint.contact.misfit(surfaces(assembly.mechanism, joint))
    remedy = (
        f"{misfit[0].upper()}{misfit[1:]}"
        if misfit
        else "Check loads, masses, sizes and the stiffness of its law"
    )
    return (
        f"at {step * choice.step:.6g} s the penetration of joint {assembly.contacts[index]} reached"
        f" {1e3 * course[-1]:.4g} mm, and {joint.extent[1]}, {1e3 * joint.reach:.4g} mm, is the limit. It"
        f" rose smoothly, by at most {100.0 * rise:.2g} % of that in a step: a smaller step ends in the same"
        f" way. The contact is too soft, or overloaded. {remedy}."
    )


def _depths_before(record: Record, rows: list[Array], column: int) -> list[float]:
    """Return the penetrations (m) of the last steps, after those of outputs that are a single step apart."""
    course = [float(row[column]) for row in rows]
    if record.assembly.choice.outputs_every > 1:
        return course
    return [*record.rows[-SMOOTH_STEPS:-1, column].tolist(), *course]


def quantity_name(assembly: Assembly, rows: Any) -> str:
    """Return the name of the first of these state rows in the order of ``ENTITIES``, with its joint
    or body.
    """
    entries = []
    for block in BLOCKS:
        index_of_row = {int(row): k for k, row in enumerate(assembly.layout[block.name])}
        entries += [
            (ENTITIES.index(block.entity), block, index_of_row[int(row)])
            for row in rows
            if block.entity in ENTITIES and int(row) in index_of_row
        ]
    if not entries:
        return "a number of the state"
    _, block, index = min(entries, key=lambda entry: entry[0])
    meaning = re.split(" at (?:step|the start)| since", block.meaning)[0]
    return f"the {meaning} of {owner(assembly, block.entity, index)}"


def owner(assembly: Assembly, entity: str, index: int) -> str:
    """Return the name of the joint or body of an entry of a block."""
    names = {
        "contact": assembly.contacts,
        "joint": assembly.ideals,
        "spring": assembly.springs,
        "driven": assembly.pivots,
        "body": tuple(assembly.bodies),
    }
    if entity in names:
        return f"{entity if entity in ('body', 'spring') else 'joint'} {names[entity][index]}"
    words = {"frame": "element"}
    for name, body in assembly.bodies.items():
        parts = {"frame": body.elements, "particle": body.particles}.get(entity, ())
        if index in parts:
            return (
                f"body {name}"
                if len(parts) == 1
                else f"body {name} ({words.get(entity, entity)} {parts.index(index) + 1} of {len(parts)})"
            )
    return "the whole"


def energy_cause(result: RunData) -> str:
    """Return why the energy balance of a run is open beyond its limit, with a remedy."""
    record, choice = result.record, result.record.assembly.choice
    limit = record.assembly.mechanism.settings.energy_limit
    opening = (
        f"the energy ledger is open by {100.0 * result.ledger.error:.3g} % of the largest energy, and"
        f" {100.0 * limit:.3g} % is the limit."
    )
    if own_floor(record) and choice.step <= choice.stable:
        return f"{opening} {FLOOR[0].upper()}{FLOOR[1:]}, or raise the limit (energy_limit in [run])."
    if choice.step > choice.stable:
        return (
            f"{opening} The step of {choice.step:.4g} s was forced, and is larger than the stable"
            f" {choice.stable:.4g} s that {choice.culprit} allows: take --step auto, without --force-step."
        )
    return (
        f"{opening} Take a smaller step, --step {0.5 * choice.step:.4g}, or raise the limit"
        " (energy_limit in [run]) if you accept the error."
    )


def automatic_step(assembly: Assembly) -> float:
    """Return the automatic step (s) of a run of the same length; infinite if there is none."""
    choice = assembly.choice
    try:
        return assemble(
            assembly.mechanism, "auto", duration=choice.steps * choice.step, outputs=choice.outputs
        ).choice.step
    except VfifeError:
        return math.inf


def cause(record: Record, time: float) -> str:
    """Return the likely cause of a divergence at ``time`` (s), and the remedy."""
    choice = record.assembly.choice
    forced = (
        f"The step of {choice.step:.4g} s is larger than the stable {choice.stable:.4g} s that"
        f" {choice.culprit} allows"
    )
    if limit := end_of_reach(record, time + choice.step):
        text = (
            f"The drivers lead to a position that the mechanism cannot pass: {limit}. No step size helps:"
            " end the motion of the driver earlier, or drive the mechanism elsewhere, such as at the crank."
        )
        return f"{text} {forced}, too." if choice.step > choice.stable else text
    if choice.step > choice.stable:
        return f"{forced}, which is the likely cause; take --step auto, without --force-step."
    if not choice.automatic and choice.step > LARGE_STEP * (automatic := automatic_step(record.assembly)):
        return (
            f"The step of {choice.step:.4g} s is {choice.step / automatic:.3g} times as large as the"
            f" automatic step of {automatic:.4g} s, which is the likely cause; take --step auto."
        )
    topology = record.assembly.topology
    if record.assembly.ideals and not (topology.frame_nodes or topology.contact_bearing):
        lead = (
            "the drivers lead it"
            if record.assembly.mobility is not None and record.assembly.mobility.after_drives == 0
            else "the motion leads"
        )
        return (
            f"The likely cause is that {lead} to a place where the ideal joints cannot stay closed: a dead"
            " centre, or beyond the reach of the links. Check lengths (vfife check tells the class of a"
            " four-bar), the motion of the drivers, and the last outputs with `vfife plot`."
        )
    deepest = ""
    if record.assembly.contacts:
        depths = record.block("contact_penetration_max").max(axis=0)
        worst = int(np.argmax(depths))
        deepest = (
            f" (the deepest so far is {1e6 * depths[worst]:.3g} µm at joint"
            f" {record.assembly.contacts[worst]})"
        )
    return (
        "The likely cause is a contact or an element that became stiffer than the step was chosen"
        f" for{deepest}, or a load that grows without limit; try half the step, --step"
        f" {0.5 * choice.step:.4g}, and look at the last outputs with `vfife plot`."
    )


def end_of_reach(record: Record, until: float) -> str:
    """Return a description of the position beyond which the ideal mechanism no longer closes before ``until``
    (s); "" if it closes throughout.

    Only for motions that drivers alone determine; elastic links are treated as rigid, and clearances as zero.
    """
    assembly = record.assembly
    if assembly.mobility is None or assembly.mobility.after_drives > 0:
        return ""
    mechanism = assembly.mechanism.ideal()
    try:
        datum = datum_of(mechanism)
        last = _last(mechanism, until, datum, max(WAY_POINTS, 2 * len(record.steps)))
    except AssemblyError:
        return ""
    if last is None:
        return ""
    time, joints = last
    places = "; ".join(
        _place(mechanism, name, driver, datum, time) for name, driver in _moving(mechanism).items()
    )
    open_joints = f", where {', '.join(joints)} cannot stay closed" if joints else ""
    return f"at {time:.6g} s {places}: a dead centre, or the end of the links' reach{open_joints}"


def _last(
    mechanism: Mechanism, until: float, datum: Datum, count: int
) -> tuple[float, tuple[str, ...]] | None:
    """Return the time of the last position that closes, and the joints that do not beyond it; None where all
    close.
    """
    guess, closed = ideal_motion(mechanism, datum=datum).position, 0.0
    open_at: list[tuple[float, Array]] = []  # times at which it did not close, and the positions it came from
    for time in np.linspace(0.0, until, count + 1)[1:].tolist():
        try:
            guess, closed = ideal_motion(mechanism, time, guess, datum=datum, named=False).position, time
        except AssemblyError:
            open_time = time
            open_at.append((time, guess))
            break
    else:
        return None
    for _ in range(HALVINGS):
        middle = 0.5 * (closed + open_time)
        try:
            guess, closed = ideal_motion(mechanism, middle, guess, datum=datum, named=False).position, middle
        except AssemblyError:
            open_time = middle
            open_at.append((middle, guess))
    return closed, next(
        (names for names in (_open(mechanism, *attempt, datum) for attempt in reversed(open_at)) if names), ()
    )


def _open(mechanism: Mechanism, time: float, guess: Array, datum: Datum) -> tuple[str, ...]:
    """Joints that do not close at a time (s), from a position before."""
    try:
        ideal_motion(mechanism, time, guess, datum=datum)
    except AssemblyError as error:
        return error.joints
    return ()


def _moving(mechanism: Mechanism) -> dict[str, Driver]:
    """Return all drivers that prescribe a motion."""
    return {**kinematic_drivers(mechanism), **constraint_drivers(mechanism)}


def _place(mechanism: Mechanism, name: str, driver: Driver, datum: Datum, time: float) -> str:
    """Return where a driver has what it moves."""
    body = driven_body(name, driver)
    if body:
        start = datum.angle.get(body, mechanism.bodies[body].angle)
        start -= (
            0.0
            if driver.against == "ground"
            else datum.angle.get(driver.against, mechanism.bodies[driver.against].angle)
        )
        return (
            f"driver {name} has {body} at"
            f" {math.degrees(motion_function(driver, start, mechanism.clock)(time)[0]):.6g} degrees"
        )
    begin = datum.travel.get(name, 0.0)
    value = motion_function(driver, begin, mechanism.clock)(time)[0]
    place = (
        f"joint {driver.slider} at {value:.6g} m along its guide"
        if driver.slider
        else f"{driver.point} at {value:.6g} m along its direction"
    )
    return f"driver {name} has {place}, {abs(value - begin):.6g} m from where it began"
