"""Start states of a motion, described by numbers: the crank angle, the place and velocity of a journal in its
bearing, and any parameter of the model by its path.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..assembly.assemble import assemble
from ..assembly.assembled import Assembly
from ..errors import Fault, ModelError, VfifeError, shown, suggestion
from ..kinematics.initial import ideal_motion
from ..kinematics.start import Misfit, Seat, StartState
from ..model.functions import bodies_at_rest, turn_of
from ..model.mechanism import Mechanism
from ..modelfile import dump, loads
from ..numerics.scalar import hypot
from ..schema import Measure
from ..simulation.turn_steps import with_steps
from ..solvers.arguments import Arguments
from ..units import assignments, number
from .maps import unit_at

Array = NDArray[np.float64]
CRANK = "start.crank"
AXES = {"x": "m", "y": "m", "vx": "m/s", "vy": "m/s"}
# Velocities of a mechanism with eccentric journals are central differences of positions, this share of a turn
# before and after the start: the error is about the square of it.
DIFFERENCE = 1e-4
# Largest angle (rad) by which the crank is turned between two solved positions, so that Newton's method stays
# on the branch on which the mechanism was assembled.
LARGEST_TURN = math.pi / 18.0
# Stands for a rate of zero (rad/s) on an axis, which is given; the zero of a model is the default, and joints
# may change that.
NO_RATE = 1e-200


def start_numbers(mechanism: Mechanism, text: str) -> dict[str, float]:
    """Return the numbers of a start (SI) by path: of "own" none, or of PATH=VALUE, PATH=VALUE. Raises
    ValueError.
    """
    values: dict[str, float] = {}
    example = '"start.crank=90deg, start.pin.x=0.1mm"'
    items = [] if text.strip() == "own" else text.split(",")
    for path, value in assignments("--start", items, example, "neither own nor PATH=VALUE"):
        try:
            values[path] = number(value, unit_of_start(mechanism, path))
        except ValueError as error:
            raise ValueError(f"--start {path}={value}: {error}") from None
    return values


def unit_of_start(mechanism: Mechanism, path: str) -> str:
    """Return the unit of the number at ``path``: rad for ``start.crank``, m for ``start.JOINT.x`` and ``.y``,
    m/s for ``start.JOINT.vx`` and ``.vy``, otherwise that of the model's parameter.

    Raises ValueError for an unknown joint or parameter, with the most similar names.
    """
    if path == CRANK:
        return "rad"
    head, _, tail = path.partition(".")
    joint, _, axis = tail.rpartition(".")
    if head == "start" and axis in AXES and joint in mechanism.clearances:
        return AXES[axis]
    try:
        return unit_at(mechanism, path)
    except ValueError:
        if head != "start":
            raise
        paths = [CRANK, *(f"start.{name}.{key}" for name in mechanism.clearances for key in AXES)]
        remedy = suggestion(path, paths, "name one")
        raise ValueError(f"{path}: a start has no number of this name; {remedy}") from None


def unit_of_argument(argument: str, mechanism: Mechanism, path: str) -> str:
    """Return the unit of the number at the ``path`` that an ``argument`` names; raise ModelError for none."""
    try:
        return unit_of_start(mechanism, path)
    except ValueError as error:
        raise ModelError([Fault(argument, str(error))], mechanism.name) from None


def values_between(
    function: str, mechanism: Mechanism, path: str, ends: Sequence[Any], count: int
) -> tuple[float, ...]:
    """Return ``count`` equally spaced values (SI) of the number at ``path``, from one to the other of two
    ``ends``, which are numbers (SI) or texts with a unit.

    Raises ModelError, in the name of the public ``function``, for an unknown path, an end that is no value of
    the number, and equal ends of several values.
    """
    arguments = Arguments(function)
    arguments.mechanism(mechanism)
    arguments.kind("path", path, (str,), 'the path of a number, such as "joint.C.clearance"')
    arguments.count("count", count, optional=False)
    arguments.check()
    unit = Measure(unit_of_argument("path", mechanism, path))
    for name, end in zip(("low", "high"), ends, strict=True):
        if end is None:
            arguments.fault(name, "a value is missing", end, f"a number in {unit.unit}", "give one")
    low, high = (arguments.read(name, unit, end) for name, end in zip(("low", "high"), ends, strict=True))
    arguments.check()
    if low == high and count > 1:
        message, remedy = f"{path} has the same value at both ends", "give another end, or count = 1"
        arguments.fault("high", message, ends[1], f"another value than low = {shown(ends[0])}", remedy)
    arguments.check()
    return tuple(np.linspace(low, high, count).tolist())


def start_words(numbers: Iterable[tuple[str, float]]) -> str:
    """Return the numbers (path, value) of a start as text with units."""
    units = {CRANK: "rad"}
    return ", ".join(
        f"{path} = {value:.4g} {units.get(path) or AXES.get(path.rpartition('.')[2], '')}".rstrip()
        for path, value in numbers
    )


def bodies_of(mechanism: Mechanism, paths: Iterable[str]) -> set[str]:
    """Return the names of the bodies whose velocity follows from a journal's velocity among ``paths``, such
    as ``start.pin.vx``.
    """
    joints = {
        path.split(".")[1]
        for path in paths
        if path.startswith("start.") and path.rpartition(".")[2] in ("vx", "vy")
    }
    return {side[0] for joint in joints for side in mechanism.clearances[joint].sides} - {"ground"}


def refuse_contradiction(mechanism: Mechanism, paths: Iterable[str]) -> None:
    """Raise ModelError if ``paths`` specify the velocity of a body twice: as the body's own, and by that of a
    journal.
    """
    paths = list(paths)
    bodies = bodies_of(mechanism, paths)
    for path in paths:
        parts = path.split(".")
        if len(parts) > 2 and parts[0] == "body" and parts[2] == "velocity" and parts[1] in bodies:
            message = "this velocity follows from that of the body's journal, which is specified, too"
            remedy = f"leave out {path}, or start.JOINT.vx and .vy"
            raise ModelError([Fault(path, message, "", "one of both", remedy)], mechanism.name)


@dataclass
class StartStates:
    """Start states of a mechanism, each assembled with ``steps`` steps in a turn.

    ``positions`` caches positions of the ideal mechanism by time (s), shape (bodies + 1, 3) each.
    """

    mechanism: Mechanism
    steps: int
    positions: dict[float, Array] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self.text = dump(self.mechanism)

    def ahead(self, numbers: Mapping[str, float], phase: float) -> float:
        """Return the share of a turn (1) from a start with these ``numbers`` to the next time at which the
        crank has the ``phase`` (1), counted from the model's own start.
        """
        return (phase - numbers.get(CRANK, 0.0) / (2.0 * math.pi)) % 1.0

    def at(self, numbers: Mapping[str, float]) -> Assembly:
        """Assemble the model at its own start, changed by ``numbers`` (path to value in SI units).

        If numbers of the start are among them, the joints are closed around the eccentric journals. The
        velocities are those of the driven motion while the journals move in their bearings with the specified
        velocities, plus the change by bodies' own velocities. Elastic links begin without forces.

        Raises VfifeError where there is no such start, for example with a journal outside its bearing.
        """
        of_start, of_model, model = self.parted(numbers)
        if not of_start:
            return with_steps(model, self.steps)
        turn = turn_of(model) or 0.0
        places, velocities = self.journals(model, of_start)
        time = of_start.get(CRANK, 0.0) / (2.0 * math.pi) * turn
        ideal_position = self.turned(model, time, is_changed=bool(of_model))
        # Positions a little before, at and after the start, the journals moving on in their bearings: their
        # difference is the velocity. Kinematics with eccentric journals has no derivative of its own.
        span = DIFFERENCE * turn
        position_before, at_start, position_after = (
            self.position(model, time + shift, ideal_position, places, velocities, shift)
            for shift in (-span, 0.0, span)
        )
        velocity = (position_after - position_before) / (2.0 * span)
        if any(any(body.velocity) for body in model.bodies.values()):
            velocity = velocity + self.own_velocity(model, time, ideal_position, bodies_of(model, of_start))
        motion = StartState(at_start, velocity, frozenset(model.bodies))
        return assemble(model, turn / self.steps, turns=1, outputs=1, force_step=True, start_state=motion)

    def parted(
        self, numbers: Mapping[str, float]
    ) -> tuple[dict[str, float], list[tuple[str, float]], Mechanism]:
        """Return the numbers of the start, those of the model, and the model with these."""
        of_start = {
            path: value
            for path, value in numbers.items()
            if path.startswith("start.") and path.rpartition(".")[2] in (*AXES, "crank")
        }
        of_model = [
            (path, value or NO_RATE if path.startswith("body.") and path.endswith(".velocity.2") else value)
            for path, value in numbers.items()
            if path not in of_start
        ]
        return of_start, of_model, loads(self.text, set=of_model) if of_model else self.mechanism

    def misfits(self, numbers: Mapping[str, float]) -> tuple[Misfit, ...]:
        """Return the velocities given at a start with these ``numbers`` that are not those of the run; none
        where there is no start.
        """
        try:
            of_start, of_model, model = self.parted(numbers)
            time = of_start.get(CRANK, 0.0) / (2.0 * math.pi) * (turn_of(model) or 0.0)
            guess = self.turned(model, time, is_changed=bool(of_model)) if time else None
            motion = ideal_motion(model, time, guess)
        except VfifeError:
            return ()
        unchanged = bodies_of(model, of_start)
        return tuple(misfit for misfit in motion.misfits if misfit.body not in unchanged)

    def journals(
        self, model: Mechanism, of_start: Mapping[str, float]
    ) -> tuple[dict[str, Array], dict[str, Array]]:
        """Return places (m) and velocities (m/s) of journals by joint, seen from their bearings, shape (2,)
        each, from the numbers ``of_start``. Raises ModelError for a journal outside its bearing.
        """
        places: dict[str, Array] = {}
        velocities: dict[str, Array] = {}
        for path, value in of_start.items():
            if path != CRANK:
                joint, _, axis = path.removeprefix("start.").rpartition(".")
                vectors = velocities if axis.startswith("v") else places
                vectors.setdefault(joint, np.zeros(2))["xy".index(axis[-1])] = value
        for name in sorted({*places, *velocities}):
            place, clearance = places.setdefault(name, np.zeros(2)), model.clearances[name].clearance
            velocities.setdefault(name, np.zeros(2))
            if not hypot(*place) < clearance:
                fault = Fault(
                    f"start.{name}",
                    "the journal is outside its bearing",
                    f"{hypot(*place):.4g} m",
                    f"less than {clearance:.4g} m",
                )
                raise ModelError([fault], model.name)
        return places, velocities

    def turned(self, model: Mechanism, time: float, is_changed: bool) -> Array:
        """Return the position of the ideal mechanism at a time (s), shape (bodies + 1, 3), followed there in
        small parts of a turn; a model that ``is_changed`` does not use the cache of positions.
        """
        positions = {} if is_changed else self.positions
        if 0.0 not in positions:
            positions[0.0] = ideal_motion(model).position
        if time not in positions:
            nearest = min(positions, key=lambda instant: abs(instant - time))
            angle = 2.0 * math.pi * abs(time - nearest) / (turn_of(model) or 1.0)
            parts = max(1, math.ceil(angle / LARGEST_TURN))
            position = positions[nearest]
            for k in range(1, parts + 1):
                position = ideal_motion(model, nearest + (time - nearest) * k / parts, position).position
            positions[time] = position
        return positions[time]

    @staticmethod
    def own_velocity(model: Mechanism, time: float, guess: Array, unchanged: set[str]) -> Array:
        """Return the change of velocities (m/s, rad/s) by the parameters ``body.*.velocity``, shape
        (bodies + 1, 3), at a time (s) near a position; it is zero for the bodies ``unchanged``.
        """
        moving_state, resting_state = (
            ideal_motion(model, time, guess),
            ideal_motion(dataclasses.replace(model, bodies=bodies_at_rest(model)), time, guess),
        )
        change = moving_state.velocity - resting_state.velocity
        change[[name in unchanged for name in moving_state.names]] = 0.0
        return change

    @staticmethod
    def position(
        model: Mechanism,
        time: float,
        guess: Array,
        places: Mapping[str, Array],
        velocities: Mapping[str, Array],
        shift: float,
    ) -> Array:
        """Return the position of the mechanism at a time (s), shape (bodies + 1, 3), with the journals where
        they are ``shift`` (s) after the start.
        """
        shifted = {name: (place + shift * velocities[name]).tolist() for name, place in places.items()}
        seats = {name: Seat((x, y), 0.0, 0.0) for name, (x, y) in shifted.items()}
        return ideal_motion(model, time, guess, seats=seats).position
