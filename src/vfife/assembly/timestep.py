"""The step of a run: the largest stable step and its cause, the motions that it has to resolve, and the
division of turns and outputs into whole steps.

An explicit step has three kinds of limits. Stability (:mod:`~vfife.assembly.stability`): a larger step
diverges. Accuracy of contacts: the shortest half period of a contact needs enough steps. Accuracy of motions:
turns and prescribed functions (:mod:`~vfife.assembly.input_functions`) need enough steps. An automatic step
is the largest that all of them allow, reduced until outputs fall on the same angles in every turn. A given
step is only checked for stability.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..errors import Fault, ModelError, StepError, VfifeError
from ..kernels.arrays import Layout
from ..kernels.topology import Topology
from ..kinematics.initial import attempt
from ..model.functions import NO_CRANK, shortest_turn, turn_of
from ..model.mechanism import Mechanism, Settings
from ..numerics.elementwise import hypot
from .assembled import StepChoice
from .input_functions import RESOLVED, InputFunction, input_functions, step_limits
from .stability import (
    Limits,
    arm_limits,
    at_once,
    attached_stiffness,
    contact_limits,
    contact_periods,
    contact_stiffness,
    demands,
    element_limits,
    spring_limits,
)

if TYPE_CHECKING:
    from .entities import Touch

Array = NDArray[np.float64]

# Largest share of the stable step that is taken.
SAFETY = 0.9
# Least number of steps in half a period of the contact with the shortest one, without companions that check
# whether they suffice. docs/trust.md states this number and the next one, docs/accuracy.md twice the next.
CONTACT_STEPS = 80
# The same with companions, as usual, for the coarsest of them; the run, at half its step, has twice as many.
# This value also marks a request as one with companions, so it must differ from CONTACT_STEPS.
FIRST_CONTACT_STEPS = 20
# A step that outputs make shorter than this share of what all limits allow is said to be set by them.
SHORT_STEP, MANY_OUTPUTS = 0.5, "the number of outputs"
# Least number of outputs in a turn that ends between two of them: it is then counted to the nearest one, and
# a peak that falls in the half interval between is counted in the next turn.
FEWEST_OUTPUTS = 36
# Share of the stable step of an element that is taken where its body touches another in a contact. The
# central difference stays stable up to the limit only for forces that are linear. Beside a nonlinear one it
# is in resonance with a vibration of which a period has n steps, at sin(pi/n) of the limit, and feeds it
# energy until it grows beyond all bounds, the more slowly the larger n; 0.2 leaves n above 15. Source: T.
# Schlick, M. Mandziuk, R. D. Skeel, K. Srinivas, Nonlinear resonance artifacts in molecular dynamics
# simulations, J. Comput. Phys. 140 (1998). Two masses on a contact without damping keep their energy within
# 6 % with 0.2 over 170 bounces and gain a third of it within 700; from 0.48 on it multiplies within 50. In a
# four-bar with a loose pin at an elastic coupler, without friction and damping, vibrations grow over 4 turns
# from shares of 0.6 with 1 to 4 elements, 0.5 with 8, 0.45 with 12 and 0.35 with 16; over 8 turns from 0.27
# with 16.
CONTACT_SHARE = 0.2
TURN_STEPS = 3600  # steps in a turn if nothing else limits them
LEAST_SIZE = 1e-3  # m, of a mechanism whose pins are all in the centres of their bodies
LONGEST_STEP = 2.0  # of the length of a run: longer steps are mistakes of units
# Steps in a turn below each of which ideal joints are corrected once more, and the fewest with which ideal
# mechanisms are followed.
COARSE_STEPS = (1500, 500, 250)
COARSEST_STEPS = 60
USUAL_OUTPUTS = Settings().outputs  # in a turn, where neither a run nor its model says another number
MOST_STEPS = 10**15  # time is the number of the step times its size, which is exact up to here


@dataclass(frozen=True)
class StepRequest:
    """The requested ``step`` (s, or "auto"), length (``turns`` or ``duration``, s) and ``outputs`` in a turn
    of a run; None stands for those of the settings.

    ``contact_steps``: least number of automatic steps in the shortest half period of a contact. With
    FIRST_CONTACT_STEPS the run has twice as many, and its coarsest companion these.
    """

    step: float | str | None = None
    turns: float | None = None
    duration: float | None = None
    outputs: int | None = None
    force_step: bool = False
    contact_steps: int = CONTACT_STEPS


@dataclass(frozen=True)
class StepModels:
    """Mechanisms of one topology with the arrays on which their steps depend.

    ``states`` [cases, rows]; ``touches``: contacts of each; ``owners``: the body of each element; ``ideals``:
    names of ideal joints; ``expected``: largest force (N) of each joint of each; ``free``: number of motions
    that drivers leave free in each; ``turning`` [cases]: result of :func:`~.stability.turning_errors`, if it
    is known.
    """

    mechanisms: Sequence[Mechanism]
    layout: Layout
    states: Array
    topology: Topology
    touches: Sequence[Sequence[Touch]]
    owners: Sequence[str]
    ideals: Sequence[str]
    expected: Sequence[Mapping[str, float]]
    free: Sequence[int]
    turning: Array | None = None


@dataclass(frozen=True)
class Times:
    """Times (s) of a run: a ``turn`` of its crank, its ``length``, and the shortest ``period`` of free
    motions and of turns at the largest speed of a driver.
    """

    turn: float | None
    length: float
    period: float = math.inf


def choose_steps(models: StepModels, request: StepRequest) -> list[StepChoice | VfifeError]:
    """Choose the step, the number of steps, and the steps between two outputs of each mechanism; the error of
    one without a step stands in its place.

    "auto" takes at most SAFETY of the stable step, has enough steps in the shortest half period of a contact,
    resolves prescribed motions and forces, and divides a turn into whole steps. Free motions have a period of
    their own, which may be shorter than a turn. A StepError is that of a given step that is not stable,
    unless it is forced.
    """
    if models.mechanisms[0].settings.analysis == "static":
        return [static_choice(mechanism) for mechanism in models.mechanisms]
    limits = bounds(models)
    return [attempt(_choice, models, case, case_bounds, request) for case, case_bounds in enumerate(limits)]


def _choice(models: StepModels, case: int, bounds: Bounds, request: StepRequest) -> StepChoice:
    """Choose the step of one mechanism within its bounds. Raises StepError and ModelError."""
    mechanism, layout, state = models.mechanisms[case], models.layout, models.states[case]
    turn = turn_of(mechanism)
    length = length_of(mechanism, request.turns, request.duration, turn)
    pace = shortest_turn(mechanism)
    period = pace or math.inf
    if models.free[case] or not pace:
        period = min(period, _time_scale(mechanism, layout, state, length, has_crank=bool(pace)))
    motions = partial(functions_of, mechanism, layout, state, length)
    return step_within(mechanism.settings, bounds, Times(turn, length, period), motions, request)


class Bounds(NamedTuple):
    """Largest stable steps (s) by name of ``parts`` and of ideal joints on long ``arms``, and half
    ``periods`` (s) of contacts.
    """

    parts: list[tuple[str, float]]
    arms: list[tuple[str, float]]
    periods: list[tuple[str, float]]


def bounds(models: StepModels) -> list[Bounds]:
    """Return the limits of the step of each mechanism."""
    layout, states, topology = models.layout, models.states, models.topology
    touches = models.touches[0]
    stiffness, mobility = contact_stiffness(models.touches, layout, states, topology, models.expected)
    limits = (
        _limits(models, stiffness),
        arm_limits(layout, states, topology, models.ideals, models.turning),
        contact_periods(touches, stiffness, mobility),
    )
    return list(map(Bounds, *(by_case(case_limits, len(states)) for case_limits in limits)))


def by_case(limits: Limits, count: int) -> list[list[tuple[str, float]]]:
    """Return the limits of each of ``count`` cases, without those that it does not have."""
    if not limits:
        return [[] for _ in range(count)]
    names = [name for name, _ in limits]
    rows = np.stack([steps for _, steps in limits], axis=-1)
    if not np.isnan(rows).any():
        return [list(zip(names, row, strict=True)) for row in rows.tolist()]
    return [
        [(name, step) for name, step in zip(names, row, strict=True) if step == step] for row in rows.tolist()
    ]


class Limit(NamedTuple):
    """An upper limit of the step (s) and its cause."""

    step: float
    culprit: str


class Division(NamedTuple):
    """A step (s), the number of steps between two outputs, and the cause of the step: the limit that was met
    before turns and outputs were divided into whole steps.
    """

    step: float
    interval: int
    culprit: str


def step_within(
    settings: Settings,
    bounds: Bounds,
    times: Times,
    motions: Callable[[], Iterator[InputFunction]],
    request: StepRequest,
) -> StepChoice:
    """Choose the step within ``bounds`` for a run with these ``times``.

    ``motions`` yields what is prescribed. Sampling it takes longer than everything else, and only an
    automatic step needs it. Raises StepError for a step that is too large or a run with too many steps.
    """
    # Limits of arms are those of the start, and arms turn: only the strictest is listed with the parts.
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
    interval = min(division.interval, max(1, math.ceil(length / size * (1.0 - 1e-9))))
    count = max(1, math.ceil(length / size / interval * (1.0 - 1e-9)))
    if not interval * count <= MOST_STEPS:
        raise StepError(
            f"a run of {length:.4g} s in steps of {size:.4g} s takes {length / size:.1e} of them, and no run"
            f" does more than {MOST_STEPS:.0e}; the step was"
            f" {f'chosen for {division.culprit}' if step == 'auto' else 'given'}: check the units of lengths,"
            " masses, stiffnesses and speeds"
        )
    requested = per if per != USUAL_OUTPUTS or request.outputs else None
    return StepChoice(
        size, stable.step, division.culprit, step == "auto", tuple(limits), times.turn, interval, count,
        requested_outputs=requested if step != "auto" and interval == division.interval else None,
    )  # fmt: skip


def _automatic(
    stable: Limit,
    periods: Limits,
    times: Times,
    motions: Iterator[InputFunction],
    contact_steps: int,
    per: int,
) -> Division:
    """Return the largest step that stability, contacts, turns and prescribed motions allow, with ``per``
    outputs in a turn; with companions (FIRST_CONTACT_STEPS) half of it.
    """
    turn, length = times.turn, times.length
    reason = f"{TURN_STEPS} steps a turn" if turn and turn <= times.period else "the motion itself"
    limits = [Limit(SAFETY * stable.step, stable.culprit)]
    finer = 2 if contact_steps == FIRST_CONTACT_STEPS else 1
    for name, half in periods:
        accurate = f"joint {name}, {finer * contact_steps} steps in half a period of its contact"
        limits.append(Limit(half / contact_steps, accurate))
    limits.append(Limit(min(turn or math.inf, times.period) / TURN_STEPS, reason))
    limits += [Limit(allowed, name) for name, allowed in step_limits(motions, RESOLVED, TURN_STEPS)]
    largest = min(limits)
    # Outputs are at the same angles in every turn: a turn (or the run) is divided into whole intervals, and
    # these into whole steps. With companions, the step of the coarsest one, twice the run's, is within all
    # limits: the number of steps is doubled after it is rounded up.
    chunk = turn or length / max(1, round(length / (turn or length)))
    spacing = chunk / per / largest.step
    interval = max(1, math.ceil(spacing * (1.0 - 1e-12))) * finer
    culprit = largest.culprit
    if spacing < SHORT_STEP:
        culprit = f"{MANY_OUTPUTS}, {per:,} ({culprit} would allow {1.0 / spacing:,.3g} times as much)"
    return Division(chunk / (per * interval), interval, culprit)


def _requested(size: float, stable: Limit, times: Times, force: bool, per: int) -> Division:
    """Return the given step with a number of steps between outputs. Raises StepError if it is not stable or
    is longer than the run, unless it is forced.
    """
    if size > SAFETY * stable.step and not force:
        shown, largest = different_numbers(size, SAFETY * stable.step)
        raise StepError(
            f"a step of {shown} s is too large: {stable.culprit} allows {stable.step:.4g} s, and"
            f" {SAFETY} of it ({largest} s) is the"
            f' largest allowed; use "auto" or a smaller step, or force it (--force-step;'
            f" in Python force_step=True)"
        )
    if size > LONGEST_STEP * times.length and not force:
        raise StepError(
            f"a step of {size:.4g} s is longer than the whole run of {times.length:.4g} s; check their units,"
            " or leave the step out"
        )
    interval = _divisor(max(1, round((times.turn or times.length) / size)), per)
    return Division(size, interval, stable.culprit)


def different_numbers(first: float, second: float) -> tuple[str, str]:
    """Return two numbers with four digits, or as many as it takes to show that they differ."""
    for digits in range(4, 17):
        texts = f"{first:.{digits}g}", f"{second:.{digits}g}"
        if texts[0] != texts[1]:
            return texts
    return repr(first), repr(second)


def static_choice(mechanism: Mechanism) -> StepChoice:
    """Return the choice of a static analysis: one step for each load factor, without a limit, because its
    iterations have a step of their own.
    """
    return StepChoice(
        1.0, math.inf, "fictitious masses", True, (), None, 1, len(mechanism.settings.load_factors)
    )


def _limits(models: StepModels, stiffness: Array) -> Limits:
    """Return the stable steps of contacts, of ``stiffness`` (N/m) [cases, contacts], springs and elements."""
    layout, states, topology, owners = models.layout, models.states, models.topology, models.owners
    if not (stiffness.size or topology.spring_first or topology.frame_nodes):
        return []
    first = models.touches[0]
    names = [touch.joint.name for touch in first]
    if len({*names}) < len(names):
        sharing = np.array([at_once(touches) for touches in models.touches])
        stiffness = stiffness / sharing
    load = demands(layout, states, topology, attached_stiffness(layout, states, topology, stiffness))
    limits = contact_limits(first, layout, states, topology, load)
    limits += spring_limits(layout, states, topology, tuple(models.mechanisms[0].springs), load)
    if topology.frame_nodes:
        touching = meshes_in_contact(topology, owners)
        for kind, steps in zip(
            ("axial", "bending"), element_limits(layout, states, topology, load), strict=True
        ):
            steps = np.where(touching, CONTACT_SHARE * steps, steps)
            worst = np.argmin(steps, axis=-1)
            shortest = np.take_along_axis(steps, worst[:, None], axis=-1)[:, 0]
            # The same element need not be the worst of all cases: each that is has a limit of its own.
            for element in np.unique(worst).tolist():
                owner = owners[element] if owners else "the model"
                number = element - owners.index(owner) + 1 if owners else element + 1
                step = np.where((worst == element) & np.isfinite(shortest), shortest, np.nan)
                place = f"{kind}, beside contact" if touching[element] else kind
                limits.append((f"element {number} of {owner} ({place})", step))
    return limits


def meshes_in_contact(topology: Topology, owners: Sequence[str]) -> NDArray[np.bool_]:
    """Return whether each element belongs to a body that touches another one in a contact, and bends
    [elements]; ``owners`` are the bodies of the elements, none where there is one body.

    Bars, released at both ends, have no vibration across that contact excites: they keep the whole limit.
    """
    touching = {*topology.contact_bearing, *topology.contact_journal}
    bodies = list(owners) or ["the model"] * len(topology.frame_nodes)
    loose = {body for body, nodes in zip(bodies, topology.frame_nodes, strict=True) if touching & {*nodes}}
    return np.array(
        [
            body in loose and release != 3
            for body, release in zip(bodies, topology.frame_release, strict=True)
        ],
        dtype=bool,
    )


def length_of(mechanism: Mechanism, turns: float | None, duration: float | None, turn: float | None) -> float:
    """Return the length of a run (s): that of its arguments, else of the settings, else two turns of the
    driver, ``turn`` (s) each, else up to the end of the drivers' tables, else one second. Raises ModelError
    for turns without a crank.
    """
    settings = mechanism.settings
    if turns is None and duration is None:
        turns, duration = settings.turns, settings.duration
    if duration is not None:
        return duration
    if turn is None:
        if turns is not None:
            remedy = "give a duration in seconds instead, or drive a body with a speed"
            raise ModelError(
                [Fault("turns", f"{NO_CRANK}, so there are no turns to count", f"{turns:g}", "", remedy)],
                mechanism.name,
            )
        ends = (driver.end or 0.0 for driver in mechanism.drivers.values())
        left = max(ends, default=0.0) - mechanism.clock
        return left if left > 0.0 else 1.0
    return (2.0 if turns is None else turns) * turn


def _divisor(per_turn: int, outputs: int) -> int:
    """Return the steps between two outputs: the divisor of the steps of a turn, so that a turn has whole
    intervals, that is nearest to the requested number of ``outputs``.
    """
    target = max(1, round(per_turn / outputs))
    low, high = max(1, target // 2), 2 * target
    # Divisors come in pairs, and the smaller ones are fewer: 720 outputs of 1e8 steps are found among some
    # 1,000 numbers of outputs rather than among 200,000 intervals.
    if target <= outputs:
        divisors = [interval for interval in range(low, high + 1) if per_turn % interval == 0]
    else:
        counts = range(max(1, per_turn // high), per_turn // low + 1)
        divisors = [per_turn // count for count in counts if per_turn % count == 0]
    divisors = [interval for interval in divisors if low <= interval <= high]
    return min(divisors, key=lambda interval: (abs(interval - target), interval), default=target)


def _time_scale(mechanism: Mechanism, layout: Layout, state: Array, length: float, has_crank: bool) -> float:
    """Return a period (s) to be resolved in a mechanism without a crank or with free bodies: that of a
    pendulum of its size, of its fastest particle on a circle of that size, and of its fastest turning,
    whichever is shortest.

    Where all pins are centres of bodies, there is no circle: the size is only a bound. It is not used with a
    crank, whose turn is a scale of time, because the speed of a start would then decide the step of a map.
    """
    size = size_of(mechanism)
    if has_crank and size <= LEAST_SIZE:
        size = math.inf
    gravity = hypot(*mechanism.gravity)
    speed = float(hypot(state[layout["particle_u"]], state[layout["particle_v"]]).max())
    spin = float(np.abs(state[layout["particle_w"]]).max())
    scales = [2.0 * math.pi * math.sqrt(size / gravity)] if gravity else []
    scales += [2.0 * math.pi * size / speed] if speed else []
    scales += [2.0 * math.pi / spin] if spin else []
    return min([*scales, length])


def size_of(mechanism: Mechanism) -> float:
    """Return the largest distance (m) of a pin from the origin of its body."""
    pins = np.array([pin for body in mechanism.bodies.values() for pin in body.points.values()])
    return max(float(hypot(*pins.reshape(-1, 2).T).max(initial=0.0)), LEAST_SIZE)


def _spin(mechanism: Mechanism, layout: Layout, state: Array) -> float:
    """Return the fastest turning (rad/s) that is known before a run: that of the start and of drivers."""
    driven = (
        driver.largest_speed for driver in mechanism.drivers.values() if driver.moves and not driver.is_linear
    )
    return max(float(np.abs(state[layout["particle_w"]]).max(initial=0.0)), *driven, 0.0)


def functions_of(
    mechanism: Mechanism, layout: Layout, state: Array, length: float
) -> Iterator[InputFunction]:
    """Yield the prescribed functions of a run of a ``length`` (s)."""
    return input_functions(mechanism, length, _spin(mechanism, layout, state), partial(size_of, mechanism))


def coarse(mechanism: Mechanism, choice: StepChoice, layout: Layout, state: Array) -> int:
    """Return the number of additional corrections of ideal joints because a turn has few steps: a turn of the
    driver, else of the fastest turning that is known.
    """
    if mechanism.settings.analysis == "static":
        # An iteration is a large step: it may move a flat structure by more than its rise.
        return len(COARSE_STEPS)
    return coarseness(choice, spin_of(choice.turn, mechanism, layout, state))


def spin_of(turn: float | None, mechanism: Mechanism, layout: Layout, state: Array) -> float:
    """Return the speed (rad/s) of a crank with a ``turn`` (s), else the fastest turning known before a
    run.
    """
    return 2.0 * math.pi / turn if turn else _spin(mechanism, layout, state)


def coarseness(choice: StepChoice, spin: float) -> int:
    """Return the number of additional corrections for a turning of ``spin`` (rad/s) at the chosen step."""
    return sum(choice.step * spin * steps > 2.0 * math.pi for steps in COARSE_STEPS)
