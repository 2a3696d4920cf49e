"""Start of a run from the end of another, with its whole state or by bodies, or from positions and velocities
by name.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping, Sequence
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from ..assembly.assembled import Assembly
from ..assembly.timestep import MOST_STEPS
from ..errors import ResumeError
from ..kernels.blocks import BLOCKS
from ..kernels.polynomial import polynomial
from ..kernels.topology import FREE
from ..kinematics.guess import first_guess
from ..kinematics.initial import Motion, ideal_motion
from ..kinematics.pins import centred
from ..kinematics.start import StartState
from ..measures.motion import body_motion, body_velocity
from ..model.mechanism import Mechanism
from ..numerics.scalar import sincos
from ..solvers.record import Record, lasting_rows
from ..solvers.status import Status
from .run_data import RunData

Array = NDArray[np.float64]
RESET = ("_work", "_power", "_onsets", "_grazing", "_deep", "_deepest", "_fastest", "_steps")


def refuse_finished(record: Record, until: float | None, place: str) -> None:
    """Raise ResumeError for a run that cannot continue, with a remedy."""
    if any(damage.startswith("output") for damage in record.damaged_parts):
        raise ResumeError(
            f"{place}: this run file is damaged ({', '.join(record.damaged_parts)}), and would continue"
            " with a gap; run the model again"
        )
    if record.status in (Status.DIVERGED, Status.NOT_CONVERGED, Status.ENERGY):
        raise ResumeError(
            f"{place}: this run failed ({record.status}), and would fail again; change the model or"
            " its step, and start a new run"
        )
    if record.status == Status.COMPLETE and until is None:
        raise ResumeError(
            f"{place}: this run is complete; give a later end (--until), or start a new one from"
            " its end (--start-from)"
        )


def refuse_stateless(record: Record, name: str, alike: bool) -> None:
    """Raise ResumeError if a new run cannot start from the end of a former one.

    Either outputs at its end are lost, or the two have the same layout (``alike``) and the forces in elements
    and contacts are missing, without which the new run would be another motion.
    """
    if record.final is not None:
        return
    last, topology = int(record.steps[-1]), record.assembly.topology
    if record.reached > last and (
        missing := [damage for damage in record.damaged_parts if damage.startswith("output")]
    ):
        raise ResumeError(
            f"the run of {name!r} is damaged ({', '.join(missing)}): its end is unknown; run the model again"
        )
    if alike and (topology.contact_bearing or topology.frame_nodes):
        raise ResumeError(
            f"the run of {name!r} ({record.status}) has no complete state at its last output; without the"
            " forces in its contacts and elastic links a new run would begin a different motion; complete it"
            " first (vfife resume), or start from another run"
        )


def extended(record: Record, until: float, place: str) -> Assembly:
    """Extend the assembly of a run until a time (s), with its step and output interval."""
    assembly, choice = record.assembly, record.assembly.choice
    if record.static:
        raise ResumeError(
            f"{place}: a static analysis has load factors and no time; set load_factors in a new run"
        )
    interval = choice.step * choice.outputs_every
    outputs, done = math.ceil(until / interval * (1.0 - 1e-9)), len(record.steps) - 1
    if outputs < max(done, 1):
        raise ResumeError(
            f"{place}: this run is at {done * interval:.6g} s already; --until has to be later than that, and"
            f" was {until:.6g} s"
        )
    if not outputs * choice.outputs_every <= MOST_STEPS:
        raise ResumeError(
            f"{place}: until {until:.6g} s it takes {until / choice.step:.1e} steps, and no run does more"
            f" than {MOST_STEPS:.0e}"
        )
    mechanism = assembly.mechanism
    mechanism = dataclasses.replace(
        mechanism, settings=dataclasses.replace(mechanism.settings, turns=None, duration=until, settle=None)
    )
    return dataclasses.replace(
        assembly, mechanism=mechanism, choice=dataclasses.replace(choice, outputs=outputs)
    )


def final_record(source: RunData | Mapping[str, Any], time: float | None) -> Record | None:
    """Record of a run that is continued from its end with its whole state; None for a start by bodies."""
    if time is not None or isinstance(source, Mapping):
        return None
    return source.record if source.record.final is not None else None


def same_layout(assembly: Assembly, record: Record) -> bool:
    """Return whether particles, elements, joints and springs agree in number and kind, so that the state of
    one fits the other.
    """
    new, former = assembly.topology, record.assembly.topology
    names = ("particles", "frame_nodes", "contact_bearing", "contact_journal", "contact_kind",
            "joint_bearing", "joint_journal", "joint_place", "joint_turn", "path_pieces",
            "spring_first", "spring_second", "spring_kind", "driven", "path_unit")  # fmt: skip
    laws = [[topology.friction_laws[k] for k in topology.friction_form] for topology in (new, former)]
    return all(getattr(new, name) == getattr(former, name) for name in names) and laws[0] == laws[1]


def step_of(record: Record, assembly: Assembly) -> float | None:
    """Step (s) of a former run of the same layout, which the continued run keeps; None if it chooses its own.

    A mechanism that was changed keeps a step finer than its own, not a coarser one.
    """
    if record.static or not assembly.choice.automatic or not same_layout(assembly, record):
        return None
    new, former, step = assembly.mechanism, record.assembly.mechanism, record.assembly.choice.step
    is_same = all(
        getattr(new, name) == getattr(former, name)
        for name in ("bodies", "joints", "gears", "springs", "drivers", "loads", "gravity")
    )
    return step if step <= (assembly.choice.stable if is_same else assembly.choice.step) else None


def with_last_state(assembly: Assembly, record: Record) -> Assembly:
    """Give an assembly the last state of a run of the same layout: positions, velocities, element and contact
    forces. Companions get those of the companions.

    Works and counts start at zero, and so do steps; prescribed angles and travels continue by the clock of
    the mechanism. Velocities, which a state holds at half steps, are those at the step.
    """
    tables = assembly.tables.copy()
    state = _continued(assembly, record, record.assembly.state if record.final is None else record.final)
    _drivers(assembly, state, tables)
    lanes = [_continued(assembly, record, lane) for lane in companion_ends(record)]
    for lane in lanes:
        _drivers(assembly, lane, assembly.tables.copy())
    return dataclasses.replace(
        assembly, state=state, tables=tables, companion_states=np.column_stack(lanes) if lanes else None
    )


def companion_ends(record: Record) -> list[Array]:
    """Return the states S of the companions at the end of a run, each (rows,); none without companions,
    without their states, and where one has numbers that are not finite.
    """
    last, layout = record.checkpoint, record.assembly.layout
    if last is None or last.values.ndim == 1 or last.step != record.steps[-1]:
        return []
    if not np.isfinite(last.values).all():
        return []
    states = np.zeros((layout.rows, last.values.shape[1]))
    states[lasting_rows(layout)] = last.values
    return list(states.T[1:])


def _continued(assembly: Assembly, record: Record, old: Array) -> Array:
    """Return the state at the start of a run that goes on from the state ``old`` of a former one, before its
    prescribed motions do.
    """
    state, new_layout, old_layout = assembly.state.copy(), assembly.layout, record.assembly.layout
    for block in BLOCKS:
        fresh = block.entity in ("system", "function", "body") or block.name.endswith(RESET)
        if block.role in ("state", "memory") and not fresh:
            state[new_layout.rows_of(block.name)] = old[old_layout.rows_of(block.name)]
    free = np.array(assembly.topology.free, dtype=int)
    dt, damping = float(old[old_layout["step"]][0]), float(old[old_layout["damping"]][0])
    at_rest = record.assembly.mechanism.settings.analysis == "static"
    for rate, second in (("u", "ax"), ("v", "ay"), ("w", "aw")):
        half, a = (old[old_layout[f"particle_{name}"][free]] for name in (rate, second))
        state[new_layout[f"particle_{rate}"][free]] = (
            0.0 if at_rest else (half - 0.5 * dt * a) / (1.0 - 0.5 * damping * dt)
        )
    return state


def _drivers(assembly: Assembly, state: Array, tables: Array) -> None:
    """Let prescribed motions continue from the state: start angles of constant speeds, constants of
    functions, offsets of travels.
    """
    t, layout = assembly.topology, assembly.layout
    for k, (body, function) in enumerate(zip(t.driven, t.driven_function, strict=True)):
        angle = float(state[layout.row("particle_theta", body)])
        if function < 0:
            state[layout.row("driven_angle", k)] = angle
        else:
            start = t.function_start[function]
            _raise(tables, start, angle - float(polynomial(tables, start, 0.0)[0]))
    for k, ((_, turn), function) in enumerate(zip(t.held, t.joint_function, strict=True)):
        if function >= 0:
            begin = float(polynomial(tables, t.function_start[function], 0.0)[0])
            state[layout.row("joint_offset", k)] = _travelled(assembly, state, k, turn) - begin


def _raise(tables: Array, start: int, by: float) -> None:
    """Add a constant to a piecewise polynomial."""
    pieces = int(tables[start])
    first = start + 1 + 2 * (pieces < 0) + abs(pieces)
    tables[first : first + 7 * abs(pieces) : 7] += by


def _travelled(assembly: Assembly, state: Array, k: int, turn: int) -> float:
    """Return the relative angle (rad), or place along the guide (m), of the two sides of a
    prescribed motion.
    """
    t, layout = assembly.topology, assembly.layout
    sides = []
    for side, p in (("bearing", t.joint_bearing[k]), ("journal", t.joint_journal[k])):
        x, y, angle = (float(state[layout.row(f"particle_{axis}", p)]) for axis in ("x", "y", "theta"))
        px, py = (float(state[layout.row(f"joint_{side}_{axis}", k)]) for axis in "xy")
        s, c = sincos(angle)
        sides.append((x + c * px - s * py, y + s * px + c * py, angle))
    if turn != FREE:
        return sides[1][2] - sides[0][2]
    dx, dy = (float(state[layout.row(f"joint_direction_{axis}", k)]) for axis in "xy")
    s, c = sincos(sides[0][2])
    return float(
        (c * dx - s * dy) * (sides[1][0] - sides[0][0]) + (s * dx + c * dy) * (sides[1][1] - sides[0][1])
    )


States: TypeAlias = Mapping[str, Sequence[float] | tuple[Sequence[float], Sequence[float]]]


def start_from(source: RunData | States, mechanism: Mechanism, time: float | None = None) -> Motion:
    """Return the motion that starts where a former run was at ``time`` (s), by default its last output, or
    from states by name.

    A mapping has for each body (x, y, angle) of its frame's origin (m, m, rad), or that and its velocity
    (m/s, m/s, rad/s); other bodies start as in the model. Positions are solved from there on the nearest
    branch; velocities are the nearest, in kinetic energy, that joints and drivers allow. Clearance joints
    between given bodies stay as they are. Driven angles and travels continue by the clock of the former run;
    free lengths and angles of torques are those of the model. Raises ValueError if names, numbers or the time
    do not fit, AssemblyError if the joints cannot close.
    """
    return ideal_motion(on_clock(mechanism, source, time), start_state=initial_state(source, mechanism, time))


def on_clock(mechanism: Mechanism, source: RunData | States, time: float | None = None) -> Mechanism:
    """Set the clock of a mechanism to that of a former run at ``time`` (s), by default its last output.

    A mechanism with a ``start.time`` keeps it. States by name and static analyses have no clock, which then
    starts at 0.
    """
    if isinstance(source, Mapping) or source.record.static or mechanism.start.time is not None:
        return mechanism
    passed = source.time[-1 if time is None else int(np.argmin(np.abs(source.time - time)))]
    clock = source.record.assembly.mechanism.clock + float(passed)
    return dataclasses.replace(mechanism, start=dataclasses.replace(mechanism.start, time=clock))


def initial_state(source: RunData | States, mechanism: Mechanism, time: float | None = None) -> StartState:
    """Return the positions and velocities of the centres of mass from a run or a mapping."""
    subject, states = (
        ("the start", source)
        if isinstance(source, Mapping)
        else (f"the run of {source.name!r}", _states(source, time))
    )
    if time is not None and isinstance(source, Mapping):
        raise ValueError(
            f"the start is given by name and has no times, so it cannot be taken at {time:g} s; leave the"
            " time out"
        )
    names = ("ground", *mechanism.bodies)
    unknown = [name for name in states if name not in mechanism.bodies]
    if unknown or not states:
        raise ValueError(
            f"{subject} has the bodies {', '.join(states) or 'none'}; {mechanism.name!r} has"
            f" {', '.join(mechanism.bodies)}"
        )
    position, velocity = first_guess(mechanism), np.zeros((len(names), 3))
    for name, state in states.items():
        row = names.index(name)
        position[row], velocity[row] = centred(mechanism, name, *_two(name, state))
    return StartState(position, velocity, frozenset(states))


def _two(name: str, state: Any) -> tuple[Array, Array]:
    """Return the position and velocity of a state, each (3,)."""
    try:
        numbers = np.array(state, dtype=float)
    except (TypeError, ValueError):
        numbers = np.full(1, np.nan)
    if numbers.shape not in ((3,), (2, 3)) or not np.isfinite(numbers).all():
        raise ValueError(
            f"start of {name!r} must be (x, y, angle), or that and its velocity, in m, rad and s; not"
            f" {state!r}"
        )
    return (numbers, np.zeros(3)) if numbers.ndim == 1 else (numbers[0], numbers[1])


def _states(result: RunData, time: float | None) -> dict[str, tuple[Array, Array]]:
    """Return the (x, y, angle) of each body's frame and its velocity at the output nearest ``time``."""
    times = result.time
    span = 0.5 * (times[-1] - times[0]) / max(len(times) - 1, 1)
    if time is not None and not times[0] - span <= time <= times[-1] + span:
        raise ValueError(
            f"the run of {result.name!r} lasts from {times[0]:g} to {times[-1]:g} s; there is no state at"
            f" {time:g} s"
        )
    k = len(times) - 1 if time is None else int(np.argmin(np.abs(times - time)))
    moved, speeds = body_motion(result.record), body_velocity(result.record)
    states = {}
    for row, (name, body) in enumerate(result.record.assembly.bodies.items()):
        x, y, angle, w = (float(moved[key][k, row]) for key in ("x", "y", "angle", "angular_velocity"))
        s, c = sincos(angle)
        r = np.array([c * body.center[0] - s * body.center[1], s * body.center[0] + c * body.center[1]])
        u, v = (float(value) for value in speeds[k, row])
        states[name] = np.array([x - r[0], y - r[1], angle]), np.array([u + w * r[1], v - w * r[0], w])
    return states
