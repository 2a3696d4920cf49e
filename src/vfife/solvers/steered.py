"""What may be set while a mechanism is stepped from outside: functions of torques, forces, loads and motions, in the tables that a step reads."""

from __future__ import annotations

import dataclasses
from collections.abc import Collection, Iterator
from dataclasses import dataclass
from typing import Any

from ..assembly.assembled import Assembly
from ..kernels.polynomial import polynomial
from ..kinematics.drives import constraint_drivers, kinematic_drivers
from ..kinematics.forces import Datum, actions
from ..model.drivers import Driver
from ..model.mechanism import Mechanism
from ..model.polynomials import Polynomials

LATE = 1e9  # s: nobody gets there
DEGREE = 7  # coefficients of a piece


@dataclass(frozen=True, kw_only=True)
class Steered(Driver):
    """A driver of constant speed (rad/s or m/s) whose motion may be changed under way: two pieces of one straight line."""

    speed: float = 0.0
    revolves = True

    def motion(self, offset: float = 0.0) -> Polynomials:
        """The straight line (rad or m), ``offset`` added."""
        return Polynomials((0.0, LATE), ((offset, self.speed), (offset + self.speed * LATE, self.speed)))

    @property
    def largest_speed(self) -> float:
        """The speed that it has at the start (rad/s or m/s)."""
        return abs(self.speed)


def steerable(mechanism: Mechanism, names: Collection[str]) -> Mechanism:
    """The mechanism in which the speed of some drivers, constant so far, may be changed. It moves as before, to rounding."""
    drivers = dict(mechanism.drivers)
    for name in names:
        driver = drivers[name]
        aim = {field.name: getattr(driver, field.name) for field in dataclasses.fields(Driver)}
        if driver.moves and driver.steady_speed is not None:
            drivers[name] = Steered(**aim, speed=driver.steady_speed)
    return dataclasses.replace(mechanism, drivers=drivers)


class Table:
    """One function in the tables of a run, ``numbers``, from ``start`` on."""

    def __init__(self, numbers: Any, start: int) -> None:
        self.numbers, self.start = numbers, start
        pieces = int(numbers[start])
        self.pieces, self.first = abs(pieces), start + (1 if pieces > 0 else 3)
        self.levels = [self.first + self.pieces + DEGREE * k for k in range(self.pieces)]
        self.held = False

    def hold(self, value: float) -> None:
        """The value from now on, whatever the function was."""
        if not self.held:
            for k in self.levels:
                for j in range(1, DEGREE):
                    self.numbers[k + j] = 0.0
            self.held = True
        for k in self.levels:
            self.numbers[k] = value

    def go(self, time: float, speed: float, within: float) -> None:
        """From where it is at a time (s), evenly to a speed (1/s) within so long (s), and on with that."""
        numbers, kinks = self.numbers, self.first + 8 * self.pieces
        value, rate, _, passed = polynomial(numbers, self.start, time)
        rising = (value, rate, 0.5 * (speed - rate) / within, 0.0, 0.0, 0.0, 0.0)
        later = (value + 0.5 * (rate + speed) * within, speed, 0.0, 0.0, 0.0, 0.0, 0.0)
        if numbers[self.start] < 0.0:  # what repeated itself does so no more: one piece that never ends, before the others
            self.numbers[self.start + 1] = 2.0 * LATE
        for k in range(self.pieces):
            numbers[self.first + k] = time if k == 0 else time + within if k == 1 else LATE
            for j, c in enumerate(rising if k == 0 else later):
                numbers[self.levels[k] + j] = c
            numbers[kinks + k] = passed + (1.0 if k == 0 else 2.0)

    @property
    def moves(self) -> bool:
        """Whether it has the pieces that a change of speed takes."""
        return self.pieces >= 2


@dataclass(frozen=True)
class Input:
    """What may be set: its name, the indices of its functions (of a constant speed none), its unit, what it is, whether it is a speed gone to."""

    name: str
    functions: tuple[int, ...]
    unit: str
    words: str
    moves: bool = False


def inputs_of(assembly: Assembly) -> Iterator[Input]:
    """Loads, torques and forces, then motions, of an assembled mechanism, in its order."""
    mechanism, topology = assembly.mechanism, assembly.topology
    functions: dict[tuple[str, str], tuple[int, ...]] = {}
    for action, place in zip((one for one in actions(mechanism, Datum()) for _ in one.ends), topology.load_function, strict=True):
        functions[action.owner] = tuple(dict.fromkeys((*functions.get(action.owner, ()), place)))
    for name, load in mechanism.loads.items():
        yield Input(name, functions.get(("load", name), ()), *load.measured)
    for name, driver in mechanism.drivers.items():
        if not driver.moves:
            words = f"{'force' if driver.along else 'torque'} of the driver"
            yield Input(name, functions.get(("driver", name), ()), "N" if driver.along else "N m", words)
    for body, driver in kinematic_drivers(mechanism).items():
        index = topology.driven_function[int(assembly.bodies[body].driven or 0)]
        name = next(name for name, one in mechanism.drivers.items() if one is driver)
        yield Input(name, (index,) if index >= 0 else (), f"{driver.unit}/s", "speed of the driver", True)
    for name, driver in constraint_drivers(mechanism).items():
        yield Input(name, (topology.joint_function[assembly.ideals.index(name)],), f"{driver.unit}/s", "speed of the driver", True)
