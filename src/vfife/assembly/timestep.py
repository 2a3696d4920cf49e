"""The largest step that stays stable, what sets it, motions that it has to resolve, and the step a run takes."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import lru_cache, partial
from typing import TYPE_CHECKING, Literal

import numpy as np
from numpy.typing import NDArray

from ..errors import Fault, ModelError, StepError
from ..kernels.arrays import Layout
from ..kernels.topology import Topology
from ..kinematics.forces import driven_body
from ..model.functions import motion_function, timed, turn_of
from ..model.geometry.polynomials import Polynomials
from ..model.mechanism import Mechanism, Settings
from ..numerics.elementwise import hypot
from .assembled import StepChoice
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

RESOLVED = 5e-4  # of the largest acceleration, or force: by how much an automatic step may miss it anywhere
MISSED = 1e-2  # the same of a step that is given, beyond which it is told
SAMPLES, MOST_SAMPLES = 8, 50_000  # a piece; of a function
BETWEEN_KINKS = 100  # steps
SHORTEST = 1e-6  # of the time looked at: no step that is sought is smaller
SEVERAL = 3  # halvings after which a function stays resolved
SPLITS = 10  # bisections: to a thousandth of the step
EPS = float(np.finfo(float).eps)


@dataclass(frozen=True)
class Prescribed:
    """A function, whose it is, and where (s; rad over an angle) a run asks for it; ``pace``: its argument's
    rate (1/s; 1 over time).

    ``motion``: rows are closed by its second difference; else it is a force, which moves by its second
    integral. ``reach`` (m): the size of what a travel moves, 1 for an angle (rad), infinite for what turns
    nothing.
    """

    name: str
    function: Polynomials
    window: tuple[float, float]
    motion: bool
    pace: float = 1.0
    reach: float = math.inf


def prescribed(mechanism: Mechanism, length: float, spin: float, size: float) -> Iterator[Prescribed]:
    """What drivers and loads prescribe in a run so long (s), bodies turning at up to ``spin`` (rad/s), links
    so long (m).
    """
    for name, driver in mechanism.drivers.items():
        body = driven_body(name, driver)
        if driver.moves:
            whose = f"the motion law of {f'joint {driver.slider}' if driver.slider else driver.point or body}"
            reach = (
                math.inf if driver.revolves and body else 1.0 if body else size
            )  # round and round: that is a turn, which is divided anyway
            if reach == math.inf and driver.steady_speed is not None:
                continue  # of an even turning nothing is missed
            yield Prescribed(
                whose, motion_function(driver, 0.0, mechanism.clock), (0.0, length), True, reach=reach
            )
        elif driver.over == "time":
            yield Prescribed(
                f"the force on {driver.point or body}",
                timed(driver.effort(), mechanism.clock),
                (0.0, length),
                False,
            )
        elif driver.over == "angle" and spin > 0.0:
            effort = driver.effort()
            yield Prescribed(
                f"the torque on {body}", effort, (effort.starts[0], effort.starts[-1]), False, spin
            )
    for name, load in mechanism.loads.items():
        function, gap = load.course()
        ends = (function.starts[0], function.starts[-1])
        if load.over == "time":
            yield Prescribed(f"the load {name}", timed(function, mechanism.clock), (0.0, length), False)
        elif load.over == "angle" and spin > 0.0:
            yield Prescribed(
                f"the load {name}",
                function,
                ends if function.period is None else (0.0, function.period),
                False,
                spin,
            )
        elif load.over == "travel" and spin > 0.0 and len(function.starts) > 1:
            stroke = 0.5 * (
                ends[1] - ends[0] - gap
            )  # its table has as much before its first place; half of it goes by sin(spin t)
            yield Prescribed(f"the load {name}", function, ends, False, 0.5 * spin * stroke)


def prescribed_limits(
    result: Iterator[Prescribed], share: float, turn_steps: float
) -> list[tuple[str, float]]:
    """Largest step (s) at which each is missed by no more than ``share`` of its largest value, and
    ``turn_steps`` are left to a turn; inf else.
    """
    limits = []
    for one in result:
        step = _missed_at(one, share) / one.pace
        rate = float(np.abs(_times_of(one)[1][:, 1]).max(initial=0.0)) if math.isfinite(one.reach) else 0.0
        limits.append(
            (one.name, min(step, 2.0 * math.pi * one.reach / (rate * turn_steps) if rate > 0.0 else math.inf))
        )
    return limits


@lru_cache(maxsize=64)
def _times_of(one: Prescribed) -> tuple[Array, Array]:
    """Where a function is looked at, its knots among them, and its value and derivatives there."""
    first, last = one.window
    function = one.function
    if function.period is not None:
        last = min(last, first + function.period)
    knots = np.array([first, *(start for start in function.starts if first < start < last), last])
    parts = max(1, min(SAMPLES, MOST_SAMPLES // len(knots)))
    inside = knots[:-1, None] + np.diff(knots)[:, None] * (np.arange(parts) / parts)
    times = np.append(inside.ravel(), last)
    return times, function.sampled(times)


@lru_cache(maxsize=64)
def _missed_at(one: Prescribed, share: float) -> float:
    """Largest step (in the function's argument) at which it is missed by a share of its largest value; inf
    where none misses it so.
    """
    times, values = _times_of(one)
    kinks = np.array(one.function.kinks)
    span = float(times[-1] - times[0])
    spacing = np.diff(kinks[(kinks >= times[0]) & (kinks <= times[-1])])
    longest: float = min(0.25 * span, float(spacing.min()) / BETWEEN_KINKS if len(spacing) else math.inf)
    if not span > 0.0 or not np.abs(values[:, 1:]).max() > 0.0:
        return math.inf
    if one.motion and not np.abs(values[:, 2]).max() > 0.0:  # nothing of an even motion is missed at any step
        return longest if len(spacing) else math.inf

    def missed(step: float) -> bool:
        return _miss(one, times, values, kinks, step) > share

    result, step, resolved = math.inf, longest, 0
    while step > SHORTEST * span and resolved < SEVERAL:  # a step of a whole wave misses nothing of it
        result, resolved = (step, 0) if missed(step) else (result, resolved + math.isfinite(result))
        step *= 0.5
    if not math.isfinite(result):
        return longest if len(spacing) else math.inf
    low, high = 0.5 * result, result
    for _ in range(SPLITS):
        middle = 0.5 * (low + high)
        low, high = (low, middle) if missed(middle) else (middle, high)
    return low


def _miss(one: Prescribed, times: Array, values: Array, kinks: Array, step: float) -> float:
    """Share of the largest value by which a step misses it, where no kink is near: steps with kinks are taken
    in parts.

    A bend of a force counts as if its pieces shared it.
    """
    bends = np.array(one.function.bends).reshape(-1, 2)
    breaks = np.sort(np.append(kinks, bends[:, 0]))
    at = (
        np.searchsorted(breaks, times - step * (1.0 + 1e-9)),
        np.searchsorted(breaks, times + step * (1.0 + 1e-9)),
    )
    smooth = at[0] == at[1]
    before, after = (one.function.sampled(times[smooth] + side * step)[:, 0] for side in (-1.0, 1.0))
    here = values[smooth, 0]
    second = after - 2.0 * here + before
    noise = 8.0 * EPS * float(np.abs(values[:, 0]).max(initial=0.0))
    if one.motion:
        largest = float(np.abs(values[:, 2]).max()) * (step * step)
        error = np.abs(second - values[smooth, 2] * (step * step))
    else:
        largest, error = float(np.abs(values[:, 0]).max()), np.abs(second) / 12.0
    worst = max(
        0.0, float(error.max(initial=0.0)) - noise, float(bends[:, 1].max(initial=0.0)) * (step * step) / 12.0
    )
    return worst / largest if largest > 0.0 else 0.0


SAFETY = 0.9
CONTACT_STEPS = (
    80  # steps in half a period of the stiffest contact, where nobody looks whether they are enough
)
# where companions do: a search for the step begins with half of what they allow, and with a companion of
# twice that
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

    ``contact_steps``: steps in half a period of the stiffest contact that an automatic step makes at least.
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
    return chosen(
        mechanism.settings,
        bounds(model),
        Times(turn, length, own),
        partial(_prescribed, mechanism, layout, state, length),
        request,
    )


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


def chosen(
    settings: Settings,
    result: Bounds,
    times: Times,
    motions: Callable[[], Iterator[Prescribed]],
    request: StepRequest,
) -> StepChoice:
    """The step within bounds, of a run of such times in which bodies are ``told`` to move."""
    turn, length, own, contact_steps = times.turn, times.length, times.own, request.contact_steps
    limits = result.parts + sorted(result.arms, key=lambda entry: entry[1])[:1]
    stable, culprit = min(((value, name) for name, value in limits), default=(math.inf, "nothing"))
    step: float | Literal["auto"] | str = settings.step if request.step is None else request.step
    per = request.outputs or settings.outputs
    if step == "auto":
        largest = SAFETY * stable
        for name, half in result.periods:
            accurate = half / contact_steps
            largest, culprit = min(
                (largest, culprit),
                (accurate, f"joint {name}, {contact_steps} steps in half a period of its contact"),
            )
        default = (
            min(turn or math.inf, own) / TURN_STEPS,
            f"{TURN_STEPS} steps a turn" if turn and turn <= own else "the motion itself",
        )
        largest, culprit = min((largest, culprit), default)
        for name, allowed in prescribed_limits(motions(), RESOLVED, TURN_STEPS):
            largest, culprit = min((largest, culprit), (allowed, name))
        chunk = turn or length / max(1, round(length / (turn or length)))
        every = max(1, math.ceil(chunk / per / largest * (1.0 - 1e-12))) * (
            2 if contact_steps == FIRST_CONTACT_STEPS else 1
        )
        size = chunk / (per * every)
    else:
        size = float(step)
        if size > SAFETY * stable and not request.force_step:
            raise StepError(
                f"a step of {size:.4g} s is too large: {culprit} allows {stable:.4g} s, and {SAFETY} of it"
                f" ({SAFETY * stable:.4g} s) is the most "
                f'that is taken; use "auto" or a smaller step, or force it if you know better (--force-step;'
                f" in Python force_step=True)"
            )
        _refuse_long(size, length, request.force_step)
        every = _divisor(max(1, round((turn or length) / size)), per)
    every = min(
        every, max(1, math.ceil(length / size * (1.0 - 1e-9)))
    )  # a run may be shorter than the time between two outputs of a turn
    count = max(1, math.ceil(length / size / every * (1.0 - 1e-9)))
    if not every * count <= MOST_STEPS:
        raise StepError(
            f"a run of {length:.4g} s in steps of {size:.4g} s takes {length / size:.1e} of them, and no run"
            f" does more than {MOST_STEPS:.0e}; the step was"
            f" {f'chosen for {culprit}' if step == 'auto' else 'given'}: check the units of lengths,"
            " masses, stiffnesses and speeds"
        )
    return StepChoice(size, stable, culprit, step == "auto", tuple(limits), turn, every, count)


def _refuse_long(size: float, length: float, force: bool) -> None:
    if size > LONGEST_STEP * length and not force:
        raise StepError(
            f"a step of {size:.4g} s is longer than the whole run of {length:.4g} s; check their units, or"
            " leave the step out"
        )


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
    return max(
        [float(hypot(*pin)) for body in mechanism.bodies.values() for pin in body.points.values()] + [1e-3]
    )


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
