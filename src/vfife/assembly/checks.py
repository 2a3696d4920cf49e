"""What assemble refuses, whether ideal joints hold more than there is to hold, and cautions on a given step:
on what is prescribed, on the outputs of a turn, and on the length of the run.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from itertools import pairwise
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..compiler.trace.graph import derive
from ..compiler.trace.tables import tables
from ..errors import VfifeError
from ..kernels.arrays import CONSTRAINT_INDEX, HEADER, Layout
from ..kernels.constraint import levers
from ..kernels.factors import factor, fill
from ..kernels.topology import FREE, PLACE_ROWS, Topology
from ..kinematics.drives import constraint_drivers, motor_angles, spinless
from ..kinematics.forces import driven_body
from ..model.bodies import Link, PointMass
from ..model.mechanism import Mechanism
from ..model.rows import Coincide, Turn
from ..numerics import dense
from ..numerics.dense import norm, product
from ..numerics.elementwise import cos, sin
from .assembled import StepChoice
from .input_functions import MISSED, step_limits
from .stability import constraint_rows, inverse_masses, joined_particles
from .timestep import COARSEST_STEPS, FEWEST_OUTPUTS, different_numbers, functions_of

if TYPE_CHECKING:
    from ..kinematics.initial import Motion
    from .entities import Touch

Array = NDArray[np.float64]

FULL_TURN = 6.283185307179586  # rad
DEGREE = FULL_TURN / 360.0
OFF_ANGLE = 0.01 * DEGREE  # rad, between the angles at which a body starts and at which the model has it
LONGER = 1e-4  # of its length, by which a run has to be longer than requested to be said so


def refuse_idle(mechanism: Mechanism) -> None:
    """VfifeError, all at once, for what turns or holds a particle without inertia, or an end of a link that
    is released.
    """
    points, faults = spinless(mechanism), []
    released = {
        name: body.release
        for name, body in mechanism.bodies.items()
        if isinstance(body, Link) and body.element_count
    }
    for thing, bodies in turned(mechanism):
        for body in bodies:
            if body in points:
                faults.append(
                    f"{thing} acts on the angle of {body!r}, a particle without inertia, which has none: give"
                    " it an inertia"
                )
            elif released.get(body) in ("start", "both"):
                faults.append(
                    f"{thing} acts on {body!r} at its start, which is released, and would turn nothing but"
                    " the pin: exchange start and end, or remove the release"
                )
    for name, joint in mechanism.joints.items():
        for body, pin in joint.sides if {Coincide(), Turn()} <= {*joint.rows()} else ():
            if released.get(body) in (pin, "both"):
                faults.append(
                    f"weld {name!r} holds {body}.{pin}, an end that is released, not the link: take an ideal"
                    " joint, or remove the release"
                )
    if faults:
        raise VfifeError("; ".join(faults))


def turned(mechanism: Mechanism) -> Iterator[tuple[str, tuple[str, ...]]]:
    """Everything that acts on angles of bodies, and those bodies; welds and guides are not among it."""
    for name, gear in mechanism.gears.items():
        yield f"gear {name!r}", (gear.first, gear.second)
    for name, spring in mechanism.springs.items():
        if spring.turns and spring.between_pins:
            points = [end.partition(".") for end in (spring.first, spring.second)]
            yield (
                f"{spring.kind} {name!r}",
                tuple(body for body, _, _ in points if isinstance(mechanism.bodies.get(body), PointMass)),
            )
        elif spring.turns:
            yield f"spring {name!r}", (spring.first, spring.second)
    for name, driver in mechanism.drivers.items():
        if not driver.moves and not driver.point:
            yield f"driver {name!r}", (driven_body(name, driver), driver.against)
    for name, driver in constraint_drivers(mechanism).items():
        if driven_body(name, driver):
            yield f"driver {name!r}", (driven_body(name, driver), driver.against)
    for name, load in mechanism.loads.items():
        for push in load.pushes(mechanism.joints):
            if push.acts[2] and isinstance(mechanism.bodies.get(push.body), PointMass):
                yield f"the moment of load {name!r}", (push.body,)


def refuse_infinite(motion: Motion) -> None:
    """VfifeError where the start has numbers beyond all bounds."""
    if motion.finite:
        return
    for quantity, values in (
        ("position", motion.position),
        ("velocity", motion.velocity),
        ("acceleration", motion.acceleration),
    ):
        bad = [name for k, name in enumerate(motion.names) if not np.isfinite(values[..., k, :]).all()]
        if bad:
            raise VfifeError(
                f"the {quantity} of {', '.join(bad)} at the start is too large for a number: check the units"
                " of speeds, forces, lengths and masses"
            )


def refuse_deep(touches: Sequence[Touch], depths: Sequence[float]) -> None:
    """VfifeError, all at once, for contacts that start so deep (m) that a body stands in another."""
    faults = []
    for touch, depth in zip(touches, depths, strict=True):
        limit, surface = touch.joint.deepest_start
        if depth > limit:
            bearing, journal = touch.joint.bearing, touch.joint.journal
            faults.append(
                f"joint {touch.joint.name!r} starts with {journal} {depth:.4g} m deep in {bearing}, beyond"
                f" {surface}: check position and angle of {journal.partition('.')[0]!r}, the side of the"
                " surface (a line's material lies to the right of its direction), and units"
            )
    if faults:
        raise VfifeError("; ".join(dict.fromkeys(faults)))


def refuse_stuck(motion: Motion) -> None:
    """VfifeError where joints and other drivers hold what a driver is to move."""
    drives = motion.system.drives
    result = motion.mobility
    if result.free - result.after_drives < len(drives):
        names = ", ".join(drive.name for drive in drives)
        left = result.free - result.after_drives
        raise VfifeError(
            f"the drivers ({names}) prescribe {len(drives)} motions, and the joints leave {left} of them free"
            " here: joints or another driver hold what is driven, or this is a dead centre; remove a driver,"
            " loosen a joint, or start elsewhere"
        )


def refuse_static(mechanism: Mechanism) -> None:
    """VfifeError, all faults at once, for settings and drivers that a static analysis, if there is to be one,
    has no use for.
    """
    if mechanism.settings.analysis != "static":
        return
    settings, faults = mechanism.settings, []
    if not settings.load_factors:
        faults.append("load_factors is empty: give one or more, as in load_factors = [0.5, 1]")
    for name in ("turns", "duration"):
        if getattr(settings, name) is not None:
            faults.append(
                f"{name} = {getattr(settings, name):g} has no meaning, since the load factor takes the place"
                " of time: leave it out"
            )
    if settings.step != "auto":
        faults.append(
            f"step = {settings.step} has no meaning, since iterations have a step of their own: leave it out"
        )
    widest = max((abs(b - a) for a, b in pairwise((0.0, *settings.load_factors))), default=0.0)
    for name, driver in mechanism.drivers.items():
        speed = driver.steady_speed
        if speed is None or driver.slider or driver.point:
            continue
        way = widest * abs(speed)
        if way > FULL_TURN * (1.0 + 1e-9):
            faults.append(
                f"driver {name!r} turns {way:.4g} rad from one load factor to the next (speed {speed:.4g}"
                f" rad/s, the load factor being the time); at most one turn, {FULL_TURN:.4g} rad, can be"
                " followed: take a table of angles, load factors closer together, or a dynamic analysis"
            )
    if faults:
        raise VfifeError("static analysis: " + "; ".join(faults))


DEPENDENT = 1e-9  # pivot, of what it was before elimination, of a row that may follow from those before it
# singular value of rows of unit length that is none: a pivot goes as its square, and small ones are not told
# from it there
VANISHING = 1e-7
FELT = 1e-6  # part of a joint in reactions that move nothing, of all of them


def redundant(layout: Layout, states: Array, topology: Topology) -> NDArray[np.bool_]:
    """Whether a constraint follows from the others, in the start of each of the states [cases, rows]; only
    those that close loops may.
    """
    if not any(derive(topology).closing):
        return np.zeros(len(states), dtype=bool)
    deficient = idle_rows(layout, states, topology).deficient
    return np.array(
        [
            bool(missing) and _small(layout, state, topology)
            for state, missing in zip(states, deficient, strict=True)
        ]
    )


def _small(layout: Layout, state: Array, topology: Topology) -> bool:
    """Whether the pivot of a row that closes a loop is so small that it may be none."""
    integers, _, rows = tables(topology)
    I, S = integers.tolist(), [*state.tolist(), *([0.0] * (rows - layout.rows))]
    turned = [p for p in topology.bound if p > 0]
    for name, values in (("c", cos), ("s", sin)):
        for p in turned:
            S[layout.row(name, p)] = float(values(float(state[layout.row("particle_theta", p)])))
        S[layout.row(name, 0)] = float(values(0.0))
    levers(S, I)
    fill(S, I)
    factor(S, I, 0.0)
    for k in range(I[HEADER.constraint_count]):
        r = I[HEADER.constraint] + CONSTRAINT_INDEX.SIZE * k
        diagonal, inverse = S[I[r + CONSTRAINT_INDEX.at] + k], S[I[HEADER.inverse] + k]
        if (
            I[r + CONSTRAINT_INDEX.closing]
            and diagonal > 0.0
            and not 0.0 < DEPENDENT * diagonal * inverse < 1.0
        ):
            return True
    return False


class IdleRows(NamedTuple):
    """G [cases, rows, 3 particles] of the joined particles, its left singular vectors [cases, rows, rows],
    and how many of the last ones move nothing [cases].
    """

    rows: Array
    left: Array
    deficient: NDArray[np.intp]
    joined: list[int]


def idle_rows(layout: Layout, states: Array, topology: Topology) -> IdleRows:
    """Reactions N that move nothing, orthonormal in energy: the last vectors of each case, G M^-1 G^T N = 0.

    Rows of G are divided by the roots of their own diagonals of G M^-1 G^T, so that N does not depend on
    units: N^T N = 1 are squares of reactions times what they would do alone, as the step weighs them.
    """
    joined = joined_particles(topology)
    inverse = inverse_masses(layout, states, joined)[:, None]
    rows = constraint_rows(layout, states, topology, joined)[:, 0]
    alone = np.sqrt((rows * rows * inverse).sum(axis=-1, keepdims=True))
    rows = rows / np.where(alone > 0.0, alone, 1.0)
    left, size, _ = dense.svd(rows * np.sqrt(inverse))
    return IdleRows(rows, left, rows.shape[1] - (size > VANISHING).sum(axis=-1), joined)


def shared(
    layout: Layout,
    state: Array,
    topology: Topology,
    ideals: Sequence[str],
    pivots: Sequence[str],
    driven: Sequence[str],
) -> tuple[str, ...]:
    """Reactions that rigid bodies leave open, ``<joint>.force``, ``<joint>.moment`` and
    ``<driven body>.torque``: those that have a part in some distribution that moves nothing. What is told of
    them is the one of least norm.

    ``ideals``, ``pivots`` and ``driven`` are names in the order of the topology's joints and driven bodies.
    """
    if not topology.redundant:
        return ()
    idle = idle_rows(layout, state[None], topology)
    rows, joined, stress = (
        idle.rows[0],
        idle.joined,
        idle.left[0, :, idle.rows.shape[1] - int(idle.deficient[0]) :],
    )
    parts = norm(stress, axis=1)
    result = []
    for (place, turn), first, end, name in zip(
        topology.held, topology.constraint_starts, topology.constraint_starts[1:], ideals, strict=False
    ):
        turns = end if turn == FREE else end - 1
        result += [f"{name}.force"] if PLACE_ROWS[place] and parts[first:turns].max() > FELT else []
        result += [f"{name}.moment"] if turn != FREE and parts[turns] > FELT else []
    on_driven = product(rows.T, stress).reshape(len(joined), 3, -1)
    largest = float(np.abs(rows).max(initial=0.0))
    for particle, pivot, body in zip(topology.driven, pivots, driven, strict=True):
        if particle in joined:
            fx, fy, moment = np.abs(on_driven[joined.index(particle)]).max(axis=1)
            result += [f"{pivot}.force"] if max(fx, fy) > FELT * largest else []
            result += [f"{body}.torque"] if moment > FELT * largest else []
    return tuple(result)


def off_angle(mechanism: Mechanism, motion: Motion) -> tuple[str, ...]:
    """Return a caution for each body that a torque turns and that does not start at the angle that the model
    gives it, or at zero, the default.
    """
    if mechanism.settings.analysis == "static":
        return ()
    sentences, grounded = [], motor_angles(mechanism)
    for body, angle in motor_angles(mechanism, relative=True).items():
        start = float(motion.of(body)[0][2])
        if abs(start - angle) > OFF_ANGLE:
            place, angle_text = different_numbers(start / DEGREE, angle / DEGREE)
            origin = "the model says" if angle else "its angle is (0 is the default)"
            cause = "the joints do not close there" if body in grounded else "it moved to close the joints"
            sentences.append(
                f"{body} starts at {place} deg, {origin} {angle_text} deg: its driver is a torque,"
                f" and {cause}. Correct this angle, those of the other bodies, or the lengths."
            )
    return tuple(sentences)


def missed(mechanism: Mechanism, choice: StepChoice, layout: Layout, state: Array) -> tuple[str, ...]:
    """Return a sentence on each prescribed function for which a given step is too coarse."""
    if choice.automatic:
        return ()
    length = choice.step * choice.steps
    limits = step_limits(functions_of(mechanism, layout, state, length), MISSED, COARSEST_STEPS)
    return tuple(
        f"The step of {choice.step:.4g} s is too coarse for {name}: more than {100.0 * MISSED:g} % of the"
        " largest that it prescribes are missed. "
        f'Take at most {allowed:.4g} s, or "auto".'
        for name, allowed in limits
        if choice.step > allowed
    )


def outside_tables(mechanism: Mechanism, choice: StepChoice) -> tuple[str, ...]:
    """Return a caution for each driver whose table of angles or travels ends before the run does: the cubic
    of its last piece goes on, and leaves any reasonable motion soon.
    """
    if mechanism.settings.analysis == "static":
        return ()
    end = mechanism.clock + choice.step * choice.steps
    return tuple(
        f"The table of driver {name} ends at {driver.end:.4g} s, and the run at {end:.4g} s: beyond the"
        " table the cubic of its last piece continues. End the run with the table, or lengthen it."
        for name, driver in mechanism.drivers.items()
        if driver.end is not None and end > (1.0 + LONGER) * driver.end
    )


def other_outputs(mechanism: Mechanism, choice: StepChoice, length: float) -> tuple[str, ...]:
    """Return a caution if a given step has another number of outputs in a turn than was requested, with the
    next smaller step that has that number; if it does not divide the turns of a run of several, with the
    nearest step that does; or if the run is longer than the requested ``length`` (s).
    """
    sentences = (*_outputs_of_turn(mechanism, choice), *_longer_run(choice, length))
    return (" ".join(sentences),) if sentences else ()


def _longer_run(choice: StepChoice, length: float) -> tuple[str, ...]:
    """Return a sentence if a run with a step that does not divide a turn into whole outputs ends later than
    requested, ``length`` (s), because it ends with an output.

    Refined automatic steps are given steps too, and divide the turn.
    """
    time, turn = choice.step * choice.steps, choice.turn
    divides = turn is not None and _has_integral_turns(turn / (choice.step * choice.outputs_every))
    if choice.automatic or divides or not time > length * (1.0 + LONGER):
        return ()
    unit, word = (1.0, "s") if choice.turn is None else (choice.turn, "turns")
    lasting, requested = different_numbers(time / unit, length / unit)
    return (
        f"The run ends with an output, after {lasting} {word} instead of {requested}: means over the run or"
        " its last turn are of the time up to there.",
    )


def _outputs_of_turn(mechanism: Mechanism, choice: StepChoice) -> tuple[str, ...]:
    """Return a sentence on a number of outputs in a turn that was not requested, or is not whole."""
    turn, requested = choice.turn, choice.requested_outputs
    if turn is None:
        return ()
    outputs = turn / (choice.step * choice.outputs_every)
    effect, opening = _effect_on_turns(mechanism, choice, outputs), f"The step of {choice.step:.4g} s"
    if requested is None or abs(outputs - requested) <= 1e-9 * requested:
        steps = max(1, round(outputs)) * choice.outputs_every
        remedy = f"Take a step of {turn / steps!r} s ({steps:,} a turn)."
        return (f"{opening} {_division(turn / choice.step)}: {effect}. {remedy}",) if effect else ()
    places = "" if _has_integral_turns(outputs) else ", at other angles in each turn"
    steps = requested * max(1, math.ceil(turn / requested / choice.step * (1.0 - 1e-12)))
    return (
        f"{opening} gives {outputs:.6g} outputs a turn instead of"
        f" {requested:,}{places}: a turn is {turn / choice.step:.10g} steps"
        f"{f', so {effect}' if effect else ''}. For {requested:,} outputs take"
        f" a step of {turn / steps!r} s ({steps:,} a turn).",
    )


def _effect_on_turns(mechanism: Mechanism, choice: StepChoice, outputs: float) -> str:
    """Return what a turn of this number of outputs means for the measures of a run of at least a turn; "" for
    a whole number.
    """
    length = 0.0 if choice.turn is None else choice.steps * choice.step / choice.turn
    if length < 1.0 - 1e-9 or _has_integral_turns(outputs):
        return ""
    cut = "mean powers and torques, energies and wear of a turn are interpolated at its ends"
    steady = all(driver.steady_speed is not None for driver in mechanism.drivers.values() if driver.moves)
    if length < 2.0 - 1e-9 or not steady:
        return cut
    if outputs < FEWEST_OUTPUTS:
        return f"turns cannot be compared, all values are those of the last turn alone, and {cut}"
    return f"turns are compared by their largest values only, and {cut}"


def _division(steps: float) -> str:
    """Return how a turn of this number of ``steps`` misses whole outputs, as the end of a sentence."""
    if _has_integral_turns(steps):
        return (
            f"divides a turn into {round(steps):,} steps, but these into no whole number of outputs near the"
            " requested one"
        )
    return f"does not divide a turn, which is {steps:.10g} steps"


def _has_integral_turns(outputs: float) -> bool:
    return abs(outputs - round(outputs)) <= 1e-9 * outputs
