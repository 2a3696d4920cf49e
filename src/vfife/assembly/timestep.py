"""The largest stable step, what sets it, motions that it has to resolve, and the step a run takes."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from typing import TYPE_CHECKING, Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..errors import Fault, ModelError, StepError
from ..kernels.arrays import Layout
from ..kernels.topology import Topology
from ..model.functions import turn_of
from ..model.mechanism import Mechanism, Settings
from ..numerics.elementwise import hypot
from .assembled import StepChoice
from .prescribed import MISSED, RESOLVED, Prescribed, prescribed, prescribed_limits
from .stability import (
    Limits,
    arm_limits,
    at_once,
    contact_limits,
    contact_periods,
    contact_stiffness,
    demands,
    element_limits,
    held,
    spring_limits,
)

if TYPE_CHECKING:
    from .entities import Touch

Array = NDArray[np.float64]

SAFETY = 0.9
# steps in half a period of the stiffest contact, where no companions look whether they are enough
CONTACT_STEPS = 80
# the same where companions do: those of the coarsest companion, so that the run, at half its step, begins
# with twice as many. It also marks a request as one with companions, so it must differ from CONTACT_STEPS.
FIRST_CONTACT_STEPS = 20
TURN_STEPS = 3600  # steps a turn where nothing else limits them
LONGEST_STEP = 2.0  # of the length of a run
COARSE_STEPS = (1500, 500, 250)  # steps a turn below which ideal joints are corrected once more
COARSEST_STEPS = 60  # steps a turn down to which ideal mechanisms hold
MOST_STEPS = 10**15  # time is the number of the step times its size: beyond, it would no longer be exact


@dataclass(frozen=True)
class StepRequest:
    """The step (s, or "auto") and the length of a run that are asked for; None stands for those of the
    settings.

    ``contact_steps``: steps in half a period of the stiffest contact that an automatic step makes at least;
    with FIRST_CONTACT_STEPS it makes twice as many, and its coarsest companion these.
    """

    step: float | str | None = None
    turns: float | None = None
    duration: float | None = None
    outputs: int | None = None
    force_step: bool = False
    contact_steps: int = CONTACT_STEPS


@dataclass(frozen=True)
class StepModel:
    """A mechanism in the arrays that its step depends on.

    ``owners``: the body of each element; ``ideals``: names of ideal joints; ``expected``: largest force (N)
    of each joint; ``free``: motions that are left to a driven mechanism; ``turning`` is that of
    :func:`~.stability.turning_errors`, where it is known.
    """

    mechanism: Mechanism
    layout: Layout
    state: Array
    topology: Topology
    touches: Sequence[Touch] = ()
    owners: Sequence[str] = ()
    ideals: Sequence[str] = ()
    expected: Mapping[str, float] = field(default_factory=dict)
    free: int = 0
    turning: float | None = None


@dataclass(frozen=True)
class Times:
    """Times (s) of a run: a turn of its crank, how long it lasts, and the period of free motions."""

    turn: float | None
    length: float
    own: float = math.inf


def choose_step(model: StepModel, request: StepRequest) -> StepChoice:
    """The step, its limits, and the number of steps and outputs.

    "auto" takes 0.9 of the stable step, makes enough steps in half a period of the stiffest contact, resolves
    motions and forces that are prescribed, and divides a turn into whole steps; motions that are left free
    have a period of their own, which may be shorter than a turn. Raises StepError for a larger one than
    stable unless that is forced.
    """
    mechanism, layout, state = model.mechanism, model.layout, model.state
    if mechanism.settings.analysis == "static":
        return static_choice(mechanism)
    turn = turn_of(mechanism)
    length = length_of(mechanism, request.turns, request.duration, turn)
    own = _time_scale(mechanism, layout, state, length) if model.free or not turn else math.inf
    motions = partial(_prescribed, mechanism, layout, state, length)
    return step_within(mechanism.settings, bounds(model), Times(turn, length, own), motions, request)


@dataclass(frozen=True)
class Bounds:
    """Largest stable steps (s) of parts, of ideal joints on long arms, and half periods (s) of contacts."""

    parts: Limits
    arms: Limits
    periods: Limits


def bounds(model: StepModel) -> Bounds:
    """What limits the step of an assembly."""
    layout, state, topology = model.layout, model.state, model.topology
    contacts = contact_stiffness(model.touches, layout, state, topology, model.expected)
    return Bounds(
        _limits(model, contacts),
        arm_limits(layout, state, topology, model.ideals, model.turning),
        contact_periods(model.touches, contacts),
    )


class Limit(NamedTuple):
    """A step (s) that something does not allow to be larger, and what it is."""

    step: float
    culprit: str


class Division(NamedTuple):
    """A step (s), steps between two outputs, and what set the step. The text tells the limit that was met
    before the step was divided, not the steps that come of it.
    """

    step: float
    every: int
    culprit: str


def step_within(
    settings: Settings,
    bounds: Bounds,
    times: Times,
    motions: Callable[[], Iterator[Prescribed]],
    request: StepRequest,
) -> StepChoice:
    """Choose the step within ``bounds`` for a run of such ``times``. Raises StepError.

    ``motions`` yields what is prescribed; sampling it takes longer than all else, so that only an automatic
    step does.
    """
    # Arms are of the start alone and turn later: of all of them only the strictest counts, beside all parts.
    limits = bounds.parts + sorted(bounds.arms, key=lambda entry: entry[1])[:1]
    stable = min((Limit(value, name) for name, value in limits), default=Limit(math.inf, "nothing"))
    step: float | Literal["auto"] | str = settings.step if request.step is None else request.step
    per = request.outputs or settings.outputs
    if step == "auto":
        division = _automatic(stable, bounds.periods, times, motions(), request.contact_steps, per)
    else:
        division = _requested(float(step), stable, times, request.force_step, per)
    size, length = division.step, times.length
    # a run may be shorter than the time between two outputs of a turn
    every = min(division.every, max(1, math.ceil(length / size * (1.0 - 1e-9))))
    count = max(1, math.ceil(length / size / every * (1.0 - 1e-9)))
    if not every * count <= MOST_STEPS:
        raise StepError(
            f"a run of {length:.4g} s in steps of {size:.4g} s takes {length / size:.1e} of them, and no run"
            f" does more than {MOST_STEPS:.0e}; the step was"
            f" {f'chosen for {division.culprit}' if step == 'auto' else 'given'}: check the units of lengths,"
            " masses, stiffnesses and speeds"
        )
    return StepChoice(
        size, stable.step, division.culprit, step == "auto", tuple(limits), times.turn, every, count
    )


def _automatic(
    stable: Limit, periods: Limits, times: Times, motions: Iterator[Prescribed], contact_steps: int, per: int
) -> Division:
    """Largest step that stability, contacts, turns and prescribed motions allow, ``per`` outputs a turn."""
    turn, length = times.turn, times.length
    reason = f"{TURN_STEPS} steps a turn" if turn and turn <= times.own else "the motion itself"
    limits = [Limit(SAFETY * stable.step, stable.culprit)]
    finer = 2 if contact_steps == FIRST_CONTACT_STEPS else 1
    for name, half in periods:
        accurate = f"joint {name}, {finer * contact_steps} steps in half a period of its contact"
        limits.append(Limit(half / contact_steps, accurate))
    limits.append(Limit(min(turn or math.inf, times.own) / TURN_STEPS, reason))
    limits += [Limit(allowed, name) for name, allowed in prescribed_limits(motions, RESOLVED, TURN_STEPS)]
    largest = min(limits)
    # Outputs lie at the same angles in every turn, so a turn (or the run) is divided into whole intervals and
    # these into whole steps. Where a companion takes steps of twice the size, that companion's step is within
    # all limits, and the run's is half of it.
    chunk = turn or length / max(1, round(length / (turn or length)))
    every = max(1, math.ceil(chunk / per / largest.step * (1.0 - 1e-12))) * finer
    return Division(chunk / (per * every), every, largest.culprit)


def _requested(size: float, stable: Limit, times: Times, force: bool, per: int) -> Division:
    """A step that was asked for, if it is stable and no longer than the run, or is forced."""
    if size > SAFETY * stable.step and not force:
        raise StepError(
            f"a step of {size:.4g} s is too large: {stable.culprit} allows {stable.step:.4g} s, and"
            f" {SAFETY} of it ({SAFETY * stable.step:.4g} s) is the most "
            f'that is taken; use "auto" or a smaller step, or force it if you know better (--force-step;'
            f" in Python force_step=True)"
        )
    if size > LONGEST_STEP * times.length and not force:
        raise StepError(
            f"a step of {size:.4g} s is longer than the whole run of {times.length:.4g} s; check their units,"
            " or leave the step out"
        )
    every = _divisor(max(1, round((times.turn or times.length) / size)), per)
    return Division(size, every, stable.culprit)


def static_choice(mechanism: Mechanism) -> StepChoice:
    """One step for each load factor, and no limit: the iterations of a static analysis have a step of their
    own.
    """
    return StepChoice(
        1.0, math.inf, "fictitious masses", True, (), None, 1, len(mechanism.settings.load_factors)
    )


def _limits(model: StepModel, contacts: Sequence[tuple[float, float]]) -> Limits:
    layout, state, topology, owners = model.layout, model.state, model.topology, model.owners
    load = demands(layout, state, topology, held(layout, state, topology, at_once(model.touches, contacts)))
    limits = contact_limits(model.touches, layout, state, topology, load)
    limits += spring_limits(layout, state, topology, tuple(model.mechanism.springs), load)
    if topology.frame_nodes:
        for kind, steps in zip(
            ("axial", "bending"), element_limits(layout, state, topology, load), strict=True
        ):
            worst = int(np.argmin(steps))
            if math.isfinite(steps[worst]):
                owner = owners[worst] if owners else "the model"
                number = worst - owners.index(owner) + 1 if owners else worst + 1
                limits.append((f"element {number} of {owner} ({kind})", float(steps[worst])))
    return limits


def length_of(mechanism: Mechanism, turns: float | None, duration: float | None, turn: float | None) -> float:
    """How long a run lasts (s): its arguments, else the settings, else two turns (s each) of the driver, else
    a second.
    """
    settings = mechanism.settings
    if turns is None and duration is None:
        turns, duration = settings.turns, settings.duration
    if duration is not None:
        return duration
    if turn is None:
        if turns is not None:
            remedy = "give a duration in seconds instead, or drive a body"
            raise ModelError(
                [
                    Fault(
                        "turns",
                        "no driver turns a body round and round, so there are no turns",
                        f"{turns:g}",
                        "",
                        remedy,
                    )
                ],
                mechanism.name,
            )
        return 1.0
    return (2.0 if turns is None else turns) * turn


def _divisor(per_turn: int, outputs: int) -> int:
    """Steps between outputs: a divisor of the steps of a turn, so that a turn holds whole intervals, near
    what is asked for.
    """
    target = max(1, round(per_turn / outputs))
    if target > 100_000:
        return target
    near = sorted(range(max(1, target // 2), 2 * target + 1), key=lambda every: abs(every - target))
    return next((every for every in near if per_turn % every == 0), target)


def _time_scale(mechanism: Mechanism, layout: Layout, state: Array, length: float) -> float:
    """A period (s) to be resolved where no crank gives one: size over the largest speed, or the root of size
    over gravity.
    """
    size = size_of(mechanism)
    gravity = hypot(*mechanism.gravity)
    speed = float(hypot(state[layout["particle_u"]], state[layout["particle_v"]]).max())
    spin = float(np.abs(state[layout["particle_w"]]).max())
    scales = [2.0 * math.pi * math.sqrt(size / gravity)] if gravity else []
    scales += [2.0 * math.pi * size / speed] if speed else []
    scales += [2.0 * math.pi / spin] if spin else []
    return min([*scales, length])


def size_of(mechanism: Mechanism) -> float:
    """Largest distance (m) of a pin from the origin of its body."""
    pins = np.array([pin for body in mechanism.bodies.values() for pin in body.points.values()])
    return max(float(hypot(*pins.reshape(-1, 2).T).max(initial=0.0)), 1e-3)


def _spin(mechanism: Mechanism, layout: Layout, state: Array) -> float:
    """Fastest turning (rad/s) that is known before a run: that of the start, and what drivers of bodies ask
    for.
    """
    driven = (
        driver.largest_speed for driver in mechanism.drivers.values() if driver.moves and not driver.along
    )
    return max(float(np.abs(state[layout["particle_w"]]).max(initial=0.0)), *driven, 0.0)


def _prescribed(mechanism: Mechanism, layout: Layout, state: Array, length: float) -> Iterator[Prescribed]:
    return prescribed(mechanism, length, _spin(mechanism, layout, state), size_of(mechanism))


def missed(mechanism: Mechanism, choice: StepChoice, layout: Layout, state: Array) -> tuple[str, ...]:
    """Sentences on what is prescribed and a given step is too coarse for."""
    if choice.automatic:
        return ()
    length = choice.step * choice.steps
    limits = prescribed_limits(_prescribed(mechanism, layout, state, length), MISSED, COARSEST_STEPS)
    return tuple(
        f"The step of {choice.step:.4g} s is too coarse for {name}: more than {100.0 * MISSED:g} % of the"
        " largest that it prescribes are missed. "
        f'Take at most {allowed:.4g} s, or "auto".'
        for name, allowed in limits
        if choice.step > allowed
    )


def coarse(mechanism: Mechanism, choice: StepChoice, layout: Layout, state: Array) -> int:
    """How many corrections more ideal joints get because a turn has few steps: a turn of the driver, else the
    fastest that is known.
    """
    if mechanism.settings.analysis == "static":
        return len(
            COARSE_STEPS
        )  # an iteration is a large step: what a flat structure is moved by in one may be more than its rise
    return coarseness(choice, spin_of(choice.turn, mechanism, layout, state))


def spin_of(turn: float | None, mechanism: Mechanism, layout: Layout, state: Array) -> float:
    """Turning (rad/s) of what has a ``turn`` (s), else the fastest that is known before a run."""
    return 2.0 * math.pi / turn if turn else _spin(mechanism, layout, state)


def coarseness(choice: StepChoice, spin: float) -> int:
    """Corrections more at a step, of what turns so fast (rad/s)."""
    return sum(choice.step * spin * steps > 2.0 * math.pi for steps in COARSE_STEPS)
