"""Co-simulation: a mechanism that is stepped from outside, by a controller, a hardware loop, or another
solver of the rest of a machine.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Collection, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ..assembly.assembled import Assembly, watched
from ..compiler.runtime.runner import Runner
from ..errors import Fault, ModelError, VfifeError, kind_of, shown, suggestion
from ..kernels.polynomial import polynomial
from ..kinematics.drives import constraint_drivers, kinematic_drivers
from ..kinematics.forces import Datum, actions
from ..laws.stored import refuse_recorded
from ..measures.motion import half_damping, is_free
from ..model.drivers import Driver
from ..model.geometry.polynomials import Polynomials
from ..model.mechanism import Mechanism
from ..model.validation import validate
from ..results.channels import RECORDED
from ..results.view import View
from ..solvers.arguments import Arguments, Loop
from ..solvers.record import Record, recorded_rows
from ..solvers.transient import choose_loop
from ..units import number
from .result import Result
from .start import StartFrom, assembled_at

LATE = 1e9  # s: nobody gets there
DEGREE = 7  # coefficients of a piece


@dataclass(frozen=True, kw_only=True)
class Steered(Driver):
    """A driver of constant speed (rad/s or m/s) whose motion may be changed under way: two pieces of one
    straight line.
    """

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
    """The mechanism in which the speed of some drivers, constant so far, may be changed. It moves as before,
    to rounding.
    """
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
        if (
            numbers[self.start] < 0.0
        ):  # what repeated itself does so no more: one piece that never ends, before the others
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
    """What may be set: its name, the indices of its functions (of a constant speed none), its unit, what it
    is, whether it is a speed gone to.
    """

    name: str
    functions: tuple[int, ...]
    unit: str
    words: str
    moves: bool = False


def inputs_of(assembly: Assembly) -> Iterator[Input]:
    """Loads, torques and forces, then motions, of an assembled mechanism, in its order."""
    mechanism, topology = assembly.mechanism, assembly.topology
    functions: dict[tuple[str, str], tuple[int, ...]] = {}
    for action, place in zip(
        (one for one in actions(mechanism, Datum()) for _ in one.ends), topology.load_function, strict=True
    ):
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
        yield Input(
            name,
            (topology.joint_function[assembly.ideals.index(name)],),
            f"{driver.unit}/s",
            "speed of the driver",
            True,
        )


NOTHING_TO_SET = (
    "the mechanism has nothing that can be set: before the Simulation, add a torque, as in"
    ' mechanism.torque("rotor", value=0.0), a load, or name drivers in steered=...'
)


def check_steered(arguments: Arguments, mechanism: Mechanism, steered: Collection[str]) -> None:
    """Note the names of ``steered`` that no driver of the mechanism has."""
    for name in steered:
        if name not in mechanism.drivers:
            arguments.fault(
                "steered",
                "there is no such driver",
                name,
                "",
                suggestion(str(name), mechanism.drivers, "name a driver"),
            )


def refuse_static(mechanism: Mechanism) -> None:
    """Raise ModelError for a static analysis, which a Simulation cannot step."""
    if mechanism.settings.analysis == "static":
        raise ModelError(
            [Fault("[run] analysis", "a static analysis has no steps in time", remedy="use simulate")],
            "Simulation()",
        )


class Simulation:
    """Steps a mechanism, lets every channel of it be read, and torques, forces, loads and speeds of drivers
    be set between.

    >>> sim = Simulation(mechanism)  # doctest: +SKIP
    >>> while sim.advance(sim.time + 1e-3) < 2.0:  # doctest: +SKIP
    ...     sim.set("motor", controller(sim.read("rotor.angular_velocity")))

    While nothing is set it has the bits of :func:`~vfife.simulation.simulate.simulate` with the same step; it
    is one run, without companions or ideal reference, and its automatic step is not halved.

    A torque, force or load that is set at a time acts from half a step later: a central difference takes the
    force at t_n for the time from t_n - step/2 to t_n + step/2. It stays until it is set anew, whatever it
    was over time, and the energy ledger counts what it does. A speed that is set is gone to evenly, within a
    step unless more is said. Advancing takes some 3 microseconds beside the steps, setting and reading less
    than one; channels that are derived (a force from its components, energies) take some milliseconds.
    """

    def __init__(
        self,
        mechanism: Mechanism,
        *,
        step: float | str | None = None,
        loop: Loop = "auto",
        start: StartFrom | None = None,
        steered: Collection[str] = (),
        force_step: bool = False,
    ) -> None:
        """Assembles a mechanism at its start, or at that of a former run
        (:func:`~vfife.simulation.simulate.simulate` says more of the arguments).

        ``steered``: names of drivers of constant speed whose speed is to be set; bits are those of a run to
        rounding then.

        Raises ModelError with all faults of the arguments or the mechanism, AssemblyError, StepError.
        """
        arguments = Arguments("Simulation")
        arguments.mechanism(mechanism)
        size, chosen = arguments.step(step), arguments.loop(loop)
        arguments.kind("force_step", force_step, (bool,), "True or False")
        arguments.kind(
            "start",
            start,
            (Result, str, Path, Mapping, type(None)),
            "a Result, the folder of a run, or states of bodies by name",
        )
        names = (steered,) if isinstance(steered, str) else steered
        check_steered(
            arguments, mechanism, names if isinstance(steered, str) or arguments.faults == [] else ()
        )
        arguments.check()
        validate(mechanism)
        refuse_static(mechanism)
        self.mechanism = mechanism
        former = Result.load(start) if isinstance(start, str | Path) else start
        self.assembly = assembled_at(steerable(mechanism, names), size, former, force_step=force_step)
        refuse_recorded([*self.assembly.topology.contact_laws, *self.assembly.topology.friction_laws])
        self._kept = recorded_rows(self.assembly)
        self.loop = choose_loop(self.assembly, chosen)
        self._runner = Runner(
            self.assembly.topology, self.assembly.state[:, None], self.assembly.tables[None, :], self.loop,
            self._kept,
            parts=mechanism.settings.parts, watched=watched([self.assembly], np.ones(1, dtype=bool)),
        )  # fmt: skip
        self._state, self._broken, numbers = (
            looked_into(one) for one in (self._runner.S, self._runner.broken, self._runner.functions)
        )
        self._none = np.zeros((1, 0, 1))  # rows of a call that keeps none
        self._take: Any = self._runner.take
        self._look = self._runner.look
        self.step: float = self.assembly.choice.step
        self._take(0, 1, self._none, True, self._look)
        self._n = 0
        self._first = self._rows()
        self._before = (0, self._first)
        self._seen: tuple[int, View] | None = None
        starts = self.assembly.topology.function_start
        self._inputs: dict[str, tuple[Input, list[Table]]] = {}
        for one in inputs_of(self.assembly):  # a driver that has the name of a load is called driver.NAME
            name = one.name if one.name not in self._inputs else f"driver.{one.name}"
            self._inputs[name] = one, [Table(numbers, starts[k]) for k in one.functions]
        self._readers: dict[str, Callable[[], float]] = {}

    def __repr__(self) -> str:
        return (
            f"<Simulation of {self.mechanism.name!r} at {self.time:.6g} s, steps of {self.step:.4g} s;"
            f" inputs: {', '.join(self.inputs) or 'none'}>"
        )

    # --------------------------------------------------------------------------------------------------- time

    @property
    def time(self) -> float:
        """Time reached (s)."""
        return self._n * self.step

    def advance(self, to: float) -> float:
        """Steps to the step that is nearest to a time (s), and gives the time reached; to a time that was
        reached already, nothing is done.

        Raises VfifeError where that lies before, and where numbers leave all bounds, after which nothing more
        can be had of it.
        """
        n = self._n
        try:
            count = round(to / self.step) - n
        except (TypeError, ValueError, OverflowError):
            raise ModelError(
                [Fault("to", f"this is {kind_of(to)}", shown(to), "a time in s", "give a number")],
                "advance()",
            ) from None
        if count > 0:
            self._take(n + 1, count, self._none, True, self._look)
            self._n = n + count
            if self._broken[0] > 0.0:
                where = f"between {n * self.step:g} s and {self.time:g} s"
                raise VfifeError(
                    f"{self.mechanism.name}: {where} numbers left all bounds; take a smaller step, or look at"
                    " what was set last"
                )
        elif count < 0:
            raise VfifeError(
                f"{to:g} s has passed: the simulation is at {self.time:g} s and does not go back; make a"
                " new one"
            )
        return self._n * self.step

    # ------------------------------------------------------------------------------------------------ reading

    @property
    def channels(self) -> list[str]:
        """Names of what can be read: those of ``result.series``."""
        return list(self._view().series)

    def read(self, name: str) -> float:
        """The value of a channel now: ``C.force`` (N), ``rod.angle`` (rad), ``kinetic_energy`` (J) ...

        Largest values since the last output are those since :meth:`advance` was last called. Raises
        VfifeError for a name that no channel has.
        """
        reader = self._readers.get(name)
        if reader is None:
            reader = self.channel(name)
        return reader()

    def channel(self, name: str) -> Callable[[], float]:
        """What reads a channel, again and again, without looking for its name: at once what the state has, in
        milliseconds what is derived.
        """
        if name not in self._readers:
            series = self._view().series
            if name not in series:
                raise VfifeError(
                    f"there is no channel {shown(name)}:"
                    f" {suggestion(str(name), series, 'sim.channels has their names')}"
                )
            one = series.column(name)
            self._readers[name] = self._row(one.variable, one.entity, one.owner, one.index) or self._derived(
                one.variable, one.index
            )
        return self._readers[name]

    def _row(
        self, variable: str, entity: str | None, noun: str, index: int | None
    ) -> Callable[[], float] | None:
        """What reads a channel that is a row of the state, or a velocity, which the state has half a step
        later; None for others.
        """
        state, layout = self._state, self.assembly.layout
        blocks = dict(RECORDED.get(entity or "", ()))
        if entity == "body":
            where = self.assembly.bodies[noun]
            index = where.row
            centred = variable in ("body_x", "body_y") and where.center == where.reference
            if not where.elements and (centred or variable == "body_angle"):
                at = layout.row(
                    "particle_theta" if variable == "body_angle" else f"particle_{variable[-1]}",
                    where.particles[0],
                )
                return lambda: state[at]
            if not where.elements and variable == "body_angular_velocity":
                return self._rate(where.particles[0])
        if variable in blocks and entity != "particle" and index is not None:
            row = layout.row(blocks[variable], index)
            return lambda: state[row]
        return None

    def _rate(self, particle: int) -> Callable[[], float]:
        """What reads an angular velocity at t_n; see :func:`~vfife.measures.motion.velocities`."""
        state, record = self._state, self._view().record
        rate, second = (self.assembly.layout.row(f"particle_{name}", particle) for name in ("w", "aw"))
        dt, z = half_damping(record)
        half, left = 0.5 * dt, 1.0 - z
        if not is_free(record)[particle]:
            return lambda: state[rate]
        return lambda: (state[rate] - half * state[second]) / left

    def _derived(self, variable: str, index: int | None) -> Callable[[], float]:
        def reader() -> float:
            values = self._view().channels[variable].values
            return float(values[-1] if index is None else values[-1, index])

        return reader

    def _rows(self) -> Any:
        return self._runner.states[self._kept, 0].copy()

    def _view(self) -> View:
        """The state now as a result has it, after that of the start and that of the last reading."""
        if self._seen is None or self._seen[0] != self._n:
            now, rows = self._n, self._rows()
            outputs = [
                (0, self._first),
                *([self._before] if 0 < self._before[0] < now else []),
                *([(now, rows)] if now else []),
            ]
            record = Record(
                self.assembly,
                np.array([n for n, _ in outputs]),
                np.stack([one for _, one in outputs]),
                self._kept,
                loop=self.loop,
            )
            self._seen, self._before = (now, View(record)), (now, rows)
        return self._seen[1]

    # ------------------------------------------------------------------------------------------------ setting

    @property
    def inputs(self) -> dict[str, str]:
        """What can be set, by name: what it is, and its unit."""
        return {name: f"{one.words} ({one.unit})" for name, (one, _) in self._inputs.items()}

    def set(self, name: str, value: float | str, within: float | None = None) -> None:
        """Sets an input from now on: a torque (N m), a force (N), what multiplies a load (1; along a guide
        its force, N, or pressure, Pa), or the speed of a driver (rad/s, m/s).

        Numbers are in SI units; texts may have a unit. ``within``: time (s) in which a driver goes evenly to
        its new speed, a step unless given. Raises ModelError for a name that no input has, or a value that is
        none.
        """
        entry = self._inputs.get(name)
        if entry is None:
            remedy = suggestion(str(name), self._inputs, "name one" if self._inputs else NOTHING_TO_SET)
            raise ModelError([Fault("name", "there is no such input", shown(name), "", remedy)], "set()")
        one, tables = entry
        if type(value) is not float:
            value = self._number(one, value)
        if not math.isfinite(value):
            raise ModelError(
                [Fault(name, "not a finite number", shown(value), one.unit, "give a number")], "set()"
            )
        if one.moves:
            self._go(one, tables, value, within)
            return
        if within is not None:
            raise ModelError(
                [Fault("within", "only a driver's speed is gone to", shown(within), "", "leave it out")],
                "set()",
            )
        for table in tables:
            table.hold(value)

    def _go(self, one: Input, tables: list[Table], speed: float, within: float | None) -> None:
        """Has a driver go to a speed."""
        if within is not None and not within > 0.0:
            raise ModelError(
                [
                    Fault(
                        "within", "zero or negative", shown(within), "above 0 s", "leave it out for one step"
                    )
                ],
                "set()",
            )
        if not tables or not all(table.moves for table in tables):
            what, remedy = (
                "the motion of this driver is one piece, which cannot be changed under way",
                "make it a ramp, or a table of three points",
            )
            if self.assembly.mechanism.drivers[one.name].steady_speed is not None:
                what, remedy = (
                    "the speed of this driver is constant",
                    f"name it when the simulation is made: steered=({shown(one.name)},)",
                )
            raise ModelError([Fault(one.name, what, remedy=remedy)], "set()")
        for table in tables:
            table.go(self._n * self.step, speed, self.step if within is None else within)

    def _number(self, one: Input, value: Any) -> float:
        try:
            return number(value if isinstance(value, str | bool) else float(value), one.unit)
        except (TypeError, ValueError):
            words = f"a number in {one.unit}" if one.unit != "1" else "a number"
            raise ModelError(
                [Fault(one.name, f"this is {kind_of(value)}", shown(value), words, "give one")], "set()"
            ) from None


def looked_into(numbers: Any) -> Any:
    """An array by number, three times as fast as NumPy gives and takes one."""
    return memoryview(numbers)
