"""Starts of a motion by numbers: where the crank stands, where a journal is in its bearing and how fast it
goes there; other numbers by path.
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
from ..errors import Fault, ModelError, suggestion
from ..kinematics.initial import Seat, StartState, ideal_motion
from ..model.functions import turn_of
from ..model.mechanism import Mechanism
from ..modelfile import dump, loads
from ..numerics.scalar import hypot
from ..schema import Measure
from ..simulation.turn_steps import with_steps
from ..solvers.arguments import Arguments
from .maps import unit_at

Array = NDArray[np.float64]
CRANK = "start.crank"
AXES = {"x": "m", "y": "m", "vx": "m/s", "vy": "m/s"}
NEAR = 1e-4  # of a turn, over which velocities of eccentric journals are differences of positions
AT_ONCE = math.pi / 18.0  # rad that the crank is turned at once on its way to a start


def unit_of_start(mechanism: Mechanism, path: str) -> str:
    """Unit of a number of a start: ``start.crank`` (rad), ``start.JOINT.x`` and ``.y`` (m), ``.vx`` and
    ``.vy`` (m/s), else one of the model.

    Raises ValueError for what there is not.
    """
    if path == CRANK:
        return "rad"
    head, _, rest = path.partition(".")
    joint, _, axis = rest.rpartition(".")
    if head == "start" and axis in AXES:
        if joint not in mechanism.clearances:
            paths = [CRANK, *(f"start.{name}.{one}" for name in mechanism.clearances for one in AXES)]
            raise ValueError(
                f"{path}: there is no joint with clearance of this name;"
                f" {suggestion(path, paths, 'name one')}"
            )
        return AXES[axis]
    return unit_at(mechanism, path)


def values_between(
    function: str, mechanism: Mechanism, path: str, ends: Sequence[Any], count: int
) -> tuple[float, ...]:
    """Values (SI) from one end to the other, numbers or texts with a unit, of a number of a model or a start.

    Raises ModelError for the arguments of ``function``: no such number, or ends that are none of its values.
    """
    arguments = Arguments(function)
    arguments.mechanism(mechanism)
    arguments.count("count", count, optional=False)
    arguments.check()
    try:
        unit = Measure(unit_of_start(mechanism, path))
    except ValueError as error:
        raise ModelError([Fault("path", str(error))], mechanism.name) from None
    low, high = (arguments.read(name, unit, end) for name, end in zip(("low", "high"), ends, strict=True))
    arguments.check()
    return tuple(np.linspace(low, high, count).tolist())


def start_words(numbers: Iterable[tuple[str, float]]) -> str:
    """Numbers of a start in words."""
    units = {CRANK: "rad"}
    return ", ".join(
        f"{path} = {value:.4g} {units.get(path) or AXES.get(path.rpartition('.')[2], '')}".rstrip()
        for path, value in numbers
    )


def bodies_of(mechanism: Mechanism, paths: Iterable[str]) -> set[str]:
    """Bodies whose velocity follows from that of a journal in its bearing, by paths such as
    ``start.pin.vx``.
    """
    joints = {
        path.split(".")[1]
        for path in paths
        if path.startswith("start.") and path.rpartition(".")[2] in ("vx", "vy")
    }
    return {side[0] for joint in joints for side in mechanism.clearances[joint].sides} - {"ground"}


def refuse_contradiction(mechanism: Mechanism, paths: Iterable[str]) -> None:
    """Raises ModelError if ``paths`` tell the velocity of one body twice: as its own, and by that of a
    journal.
    """
    paths = list(paths)
    bodies = bodies_of(mechanism, paths)
    for path in paths:
        parts = path.split(".")
        if len(parts) > 2 and parts[0] == "body" and parts[2] == "velocity" and parts[1] in bodies:
            what = "this velocity follows from that of the body's journal, which is given, too"
            remedy = f"leave out {path}, or start.JOINT.vx and .vy"
            raise ModelError([Fault(path, what, "", "one of both", remedy)], mechanism.name)


@dataclass
class StartStates:
    """Starts of a mechanism, assembled with so many ``steps`` in a turn."""

    mechanism: Mechanism
    steps: int
    positions: dict[float, Array] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self.text = dump(self.mechanism)

    def ahead(self, numbers: Mapping[str, float], phase: float) -> float:
        """The part of a turn (1) from the start up to a phase (1) of the turn that begins at the model's own
        start.
        """
        return (phase - numbers.get(CRANK, 0.0) / (2.0 * math.pi)) % 1.0

    def at(self, numbers: Mapping[str, float]) -> Assembly:
        """The model at a start: that of its own, but for the ``numbers``. Raises VfifeError where there is
        none, as with a journal outside.

        With numbers of the start joints are closed around eccentric journals; velocities are those of the
        driven motion with the journals going on in their bearings as they are told, and what bodies have by a
        velocity of their own beyond that; elastic links begin without forces.
        """
        own = {
            path: value
            for path, value in numbers.items()
            if path.startswith("start.") and path.rpartition(".")[2] in (*AXES, "crank")
        }
        rest = [(path, value) for path, value in numbers.items() if path not in own]
        model = loads(self.text, set=rest) if rest else self.mechanism
        if not own:
            return with_steps(model, self.steps)
        turn = turn_of(model) or 0.0
        at, rate = self.journals(model, own)
        time = own.get(CRANK, 0.0) / (2.0 * math.pi) * turn
        near = self.turned(model, time, alone=bool(rest))
        ends = [
            self.position(model, time + sign * NEAR * turn, near, at, rate, sign * NEAR * turn)
            for sign in (-1.0, 0.0, 1.0)
        ]
        velocity = (ends[2] - ends[0]) / (2.0 * NEAR * turn)
        if any(any(body.velocity) for body in model.bodies.values()):
            velocity = velocity + self.own_velocity(model, time, near, bodies_of(model, own))
        motion = StartState(ends[1], velocity, frozenset(model.bodies))
        return assemble(model, turn / self.steps, turns=1, outputs=1, force_step=True, start_state=motion)

    def journals(
        self, model: Mechanism, own: Mapping[str, float]
    ) -> tuple[dict[str, Array], dict[str, Array]]:
        """Places (m) and velocities (m/s) of journals in their bearings, seen from these. Raises ModelError
        for one that is outside.
        """
        at: dict[str, Array] = {}
        rate: dict[str, Array] = {}
        for path, value in own.items():
            if path != CRANK:
                joint, _, axis = path.removeprefix("start.").rpartition(".")
                (rate if axis.startswith("v") else at).setdefault(joint, np.zeros(2))[
                    "xy".index(axis[-1])
                ] = value
        for name in sorted({*at, *rate}):
            place, play = at.setdefault(name, np.zeros(2)), model.clearances[name].clearance
            rate.setdefault(name, np.zeros(2))
            if not hypot(*place) < play:
                fault = Fault(
                    f"start.{name}",
                    "the journal is outside its bearing",
                    f"{hypot(*place):.4g} m",
                    f"less than {play:.4g} m",
                )
                raise ModelError([fault], model.name)
        return at, rate

    def turned(self, model: Mechanism, time: float, alone: bool) -> Array:
        """Where the bodies of the ideal mechanism are after a time (s), gone there in small parts of a
        turn.
        """
        positions = {} if alone else self.positions
        if 0.0 not in positions:
            positions[0.0] = ideal_motion(model).position
        if time not in positions:
            nearest = min(positions, key=lambda one: abs(one - time))
            parts = max(1, math.ceil(2.0 * math.pi * abs(time - nearest) / (turn_of(model) or 1.0) / AT_ONCE))
            position = positions[nearest]
            for k in range(1, parts + 1):
                position = ideal_motion(model, nearest + (time - nearest) * k / parts, position).position
            positions[time] = position
        return positions[time]

    @staticmethod
    def own_velocity(model: Mechanism, time: float, near: Array, unchanged: set[str]) -> Array:
        """By how much ``body.*.velocity`` changes the velocities at a time (s) near a position, shape (bodies
        + 1, 3), in m/s and rad/s.

        Bodies whose velocity is ``told`` by that of a journal keep it.
        """
        still = {
            name: dataclasses.replace(body, velocity=(0.0, 0.0, 0.0)) for name, body in model.bodies.items()
        }
        with_own, without = (
            ideal_motion(model, time, near),
            ideal_motion(dataclasses.replace(model, bodies=still), time, near),
        )
        change = with_own.velocity - without.velocity
        change[[name in unchanged for name in with_own.names]] = 0.0
        return change

    @staticmethod
    def position(
        model: Mechanism,
        time: float,
        near: Array,
        at: Mapping[str, Array],
        rate: Mapping[str, Array],
        after: float,
    ) -> Array:
        """Where the bodies are at a time (s) with journals where they are ``after`` a time."""
        there = {name: (place + after * rate[name]).tolist() for name, place in at.items()}
        seats = {name: Seat((x, y), 0.0, 0.0) for name, (x, y) in there.items()}
        return ideal_motion(model, time, near, seats=seats).position
