"""Co-simulation: a mechanism that is stepped by the caller, such as a controller, a hardware loop or the
solver of another part of the machine.
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
from ..kinematics.forces import actions
from ..laws.stored import refuse_recorded
from ..measures.motion import half_damping, is_free
from ..model.drivers import Driver
from ..model.geometry.polynomials import Polynomials
from ..model.mechanism import Mechanism
from ..model.validation import validate
from ..results.channels import RECORDED
from ..results.run_data import RunData
from ..solvers.arguments import Arguments, Loop
from ..solvers.record import Record, recorded_rows
from ..solvers.transient import choose_loop
from ..units import number
from .result import Result
from .start import StartFrom, assembled_at

LATE = 1e9  # s, later than the end of any run
DEGREE = 7  # coefficients of a piece


@dataclass(frozen=True, kw_only=True)
class Steered(Driver):
    """A driver of constant speed (rad/s or m/s) whose speed can be changed during the run. Its motion is one
    straight line in two pieces; :meth:`Table.go` overwrites them.
    """

    speed: float = 0.0
    revolves = True
    has_turns = True

    def motion(self, offset: float = 0.0) -> Polynomials:
        """Return the motion (rad or m), plus ``offset``."""
        return Polynomials((0.0, LATE), ((offset, self.speed), (offset + self.speed * LATE, self.speed)))

    @property
    def largest_speed(self) -> float:
        """Speed (rad/s or m/s) at the start, unsigned."""
        return abs(self.speed)


def steerable(mechanism: Mechanism, names: Collection[str]) -> Mechanism:
    """Return the mechanism with the constant-speed drivers of these names replaced by :class:`Steered` ones.
    The motion changes by rounding errors only.
    """
    drivers = dict(mechanism.drivers)
    for name in names:
        driver = drivers[name]
        aim = {field.name: getattr(driver, field.name) for field in dataclasses.fields(Driver)}
        if driver.moves and driver.steady_speed is not None:
            drivers[name] = Steered(**aim, speed=driver.steady_speed)
    return dataclasses.replace(mechanism, drivers=drivers)


class Table:
    """A piecewise polynomial in the tables of a run: ``numbers`` from index ``start``."""

    def __init__(self, numbers: Any, start: int) -> None:
        self.numbers, self.start = numbers, start
        pieces = int(numbers[start])
        self.pieces, self.first = abs(pieces), start + (1 if pieces > 0 else 3)
        self.levels = [self.first + self.pieces + DEGREE * k for k in range(self.pieces)]
        self.held = False

    def hold(self, value: float) -> None:
        """Replace the function by a constant."""
        if not self.held:
            for k in self.levels:
                for j in range(1, DEGREE):
                    self.numbers[k + j] = 0.0
            self.held = True
        for k in self.levels:
            self.numbers[k] = value

    def go(self, time: float, speed: float, within: float) -> None:
        """Replace the motion from ``time`` (s) on: constant acceleration to ``speed`` (1/s) ``within`` a time
        (s), then constant speed. Position and speed are continuous.
        """
        numbers, kinks = self.numbers, self.first + 8 * self.pieces
        value, rate, _, passed = polynomial(numbers, self.start, time)
        rising = (value, rate, 0.5 * (speed - rate) / within, 0.0, 0.0, 0.0, 0.0)
        later = (value + 0.5 * (rate + speed) * within, speed, 0.0, 0.0, 0.0, 0.0, 0.0)
        # A negative number of pieces marks a periodic function; a period beyond any run makes it aperiodic.
        if numbers[self.start] < 0.0:
            self.numbers[self.start + 1] = 2.0 * LATE
        # Unused pieces begin after any run, and the kink counts continue from those passed, so that the step
        # detects the beginning and the end of the acceleration as kinks.
        for k in range(self.pieces):
            numbers[self.first + k] = time if k == 0 else time + within if k == 1 else LATE
            for j, c in enumerate(rising if k == 0 else later):
                numbers[self.levels[k] + j] = c
            numbers[kinks + k] = passed + (1.0 if k == 0 else 2.0)

    @property
    def moves(self) -> bool:
        """Whether the function has the two pieces that a change of speed needs."""
        return self.pieces >= 2


@dataclass(frozen=True)
class Input:
    """A quantity that can be set: its name, the indices of its functions (none for a constant speed), its
    unit, description, and whether it is the speed of a driver (``moves``).
    """

    name: str
    functions: tuple[int, ...]
    unit: str
    words: str
    moves: bool = False


def inputs_of(assembly: Assembly) -> Iterator[Input]:
    """Yield the inputs of an assembled mechanism: loads, then torques and forces, then speeds of drivers."""
    mechanism, topology = assembly.mechanism, assembly.topology
    functions: dict[tuple[str, str], tuple[int, ...]] = {}
    for action, place in zip(
        (load for load in actions(mechanism) for _ in load.ends), topology.load_function, strict=True
    ):
        functions[action.owner] = tuple(dict.fromkeys((*functions.get(action.owner, ()), place)))
    for name, load in mechanism.loads.items():
        yield Input(name, functions.get(("load", name), ()), *load.measured)
    for name, driver in mechanism.drivers.items():
        if not driver.moves:
            words = f"{'force' if driver.is_linear else 'torque'} of the driver"
            yield Input(name, functions.get(("driver", name), ()), "N" if driver.is_linear else "N m", words)
    for body, driver in kinematic_drivers(mechanism).items():
        index = topology.driven_function[int(assembly.bodies[body].driven or 0)]
        name = next(name for name, entry in mechanism.drivers.items() if entry is driver)
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
    """Add a fault for each name in ``steered`` that is no driver of the mechanism."""
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
    """Raise ModelError for a static analysis, which has no steps in time."""
    if mechanism.settings.analysis == "static":
        raise ModelError(
            [Fault("[run] analysis", "a static analysis has no steps in time", remedy="use simulate")],
            "Simulation()",
        )


class Simulation:
    """A run that the caller steps: channels can be read and torques, forces, loads and driver speeds set
    between steps.

    >>> sim = Simulation(mechanism)  # doctest: +SKIP
    >>> while sim.advance(sim.time + 1e-3) < 2.0:  # doctest: +SKIP
    ...     sim.set("motor", controller(sim.read("rotor.angular_velocity")))

    As long as no input is set, the run has the bits of :func:`~vfife.simulation.simulate.simulate` with the
    same step. It is one run without companions and ideal reference, and an automatic step is not refined.

    A torque, force or load acts from half a step after the time at which it is set, because a central
    difference applies the force at t_n from t_n - step/2 to t_n + step/2. It remains constant until it is set
    again, and the energy balance includes its work. A speed is reached with constant acceleration, by default
    within one step. In addition to the steps, a call of :meth:`advance` takes about 3 microseconds, setting
    and reading less than one; derived channels (resultant forces, energies) take milliseconds.
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
        """Assemble a mechanism at its start or at that of a former run; arguments as in
        :func:`~vfife.simulation.simulate.simulate`.

        ``steered``: names of constant-speed drivers whose speed can be set; their motion agrees with that of
        a run to rounding. Raises ModelError with all faults of arguments and mechanism, AssemblyError,
        StepError.
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
            looked_into(array) for array in (self._runner.S, self._runner.broken, self._runner.functions)
        )
        self._none = np.zeros((1, 0, 1))  # rows of a call that keeps none
        self._take: Any = self._runner.take
        self._look = self._runner.look
        self.step: float = self.assembly.choice.step
        # Step 0 has half a step's length and starts the central difference; advance() continues from step 1.
        self._take(0, 1, self._none, True, self._look)
        self._n = 0
        self._first = self._rows()
        self._before = (0, self._first)
        self._seen: tuple[int, RunData] | None = None
        starts = self.assembly.topology.function_start
        self._inputs: dict[str, tuple[Input, list[Table]]] = {}
        for port in inputs_of(self.assembly):  # a driver that has the name of a load is called driver.NAME
            name = port.name if port.name not in self._inputs else f"driver.{port.name}"
            self._inputs[name] = port, [Table(numbers, starts[k]) for k in port.functions]
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
        """Advance to the step nearest to the time ``to`` (s) and return the time reached (s); do nothing if
        it has been reached already.

        Raises VfifeError for an earlier time, and if numbers become non-finite or exceed their bounds; the
        simulation cannot continue then.
        """
        n = self._n
        try:
            count = round(to / self.step) - n
        except (TypeError, ValueError, OverflowError) as error:
            is_number = not isinstance(error, TypeError)  # NaN or infinite
            message = "this is not a finite number" if is_number else f"this is {kind_of(to)}"
            fault = Fault("to", message, shown(to), "a time in s", "give a finite number")
            raise ModelError([fault], "advance()") from None
        if count > 0:
            self._take(n + 1, count, self._none, True, self._look)
            self._n = n + count
            if self._broken[0] > 0.0:
                span = f"between {n * self.step:g} s and {self.time:g} s"
                raise VfifeError(
                    f"{self.mechanism.name}: {span} numbers grew without bound; use a smaller step, or check"
                    " the last input"
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
        """Names that :meth:`read` accepts: those of ``result.series``."""
        return list(self._view().series)

    def read(self, name: str) -> float:
        """Return the present value of a channel, such as ``C.force`` (N), ``rod.angle`` (rad) or
        ``kinetic_energy`` (J).

        Channels with the largest value since the last output have that since the last call of
        :meth:`advance`. Raises VfifeError for an unknown name.
        """
        reader = self._readers.get(name)
        if reader is None:
            reader = self.channel(name)
        return reader()

    def channel(self, name: str) -> Callable[[], float]:
        """Return a function that reads a channel, to avoid the lookup of its name in a loop. Raises
        VfifeError for an unknown name.
        """
        if name not in self._readers:
            series = self._view().series
            if name not in series:
                raise VfifeError(
                    f"there is no channel {shown(name)}:"
                    f" {suggestion(str(name), series, 'sim.channels has their names')}"
                )
            column = series.column(name)
            self._readers[name] = self._row(
                column.variable, column.entity, column.owner, column.index
            ) or self._derived(column.variable, column.index)
        return self._readers[name]

    def _row(
        self, variable: str, entity: str | None, noun: str, index: int | None
    ) -> Callable[[], float] | None:
        """Return a reader for a channel that is a row of the state, or an angular velocity; None
        for others.
        """
        # Rows of the state are read in place. Bodies have rows only if rigid, and positions only if the
        # centre of mass is the body's reference point; all other channels are computed by the code of a
        # result.
        state, layout = self._state, self.assembly.layout
        blocks = dict(RECORDED.get(entity or "", ()))
        if entity == "body":
            body = self.assembly.bodies[noun]
            index = body.row
            centred = variable in ("body_x", "body_y") and body.center == body.reference
            if not body.elements and (centred or variable == "body_angle"):
                at = layout.row(
                    "particle_theta" if variable == "body_angle" else f"particle_{variable[-1]}",
                    body.particles[0],
                )
                return lambda: state[at]
            if not body.elements and variable == "body_angular_velocity":
                return self._rate(body.particles[0])
        if variable in blocks and entity != "particle" and index is not None:
            row = layout.row(blocks[variable], index)
            return lambda: state[row]
        return None

    def _rate(self, particle: int) -> Callable[[], float]:
        """Return a reader of an angular velocity at t_n, which the state contains at t_n + step/2; see
        :func:`~vfife.measures.motion.velocities`.
        """
        state, record = self._state, self._view().record
        rate, second = (self.assembly.layout.row(f"particle_{name}", particle) for name in ("w", "aw"))
        dt, z = half_damping(record)
        half, left = 0.5 * dt, 1.0 - z
        if not is_free(record)[particle]:
            return lambda: state[rate]
        return lambda: (state[rate] - half * state[second]) / left

    def _derived(self, variable: str, index: int | None) -> Callable[[], float]:
        """Return a reader for a channel that is computed from a view of the present state."""

        def reader() -> float:
            values = self._view().channels[variable].values
            return float(values[-1] if index is None else values[-1, index])

        return reader

    def _rows(self) -> Any:
        return self._runner.states[self._kept, 0].copy()

    def _view(self) -> RunData:
        """Return the present state as a result, after the outputs of the start and of the last reading, from
        which rates of change follow.
        """
        # Three outputs suffice: the first, because energies count from it; the one before, because means and
        # extremes count from it; and the present one. The view is cached until the next step.
        if self._seen is None or self._seen[0] != self._n:
            step_count, rows = self._n, self._rows()
            outputs = [
                (0, self._first),
                *([self._before] if 0 < self._before[0] < step_count else []),
                *([(step_count, rows)] if step_count else []),
            ]
            record = Record(
                self.assembly,
                np.array([n for n, _ in outputs]),
                np.stack([row for _, row in outputs]),
                self._kept,
                loop=self.loop,
            )
            self._seen, self._before = (step_count, RunData(record)), (step_count, rows)
        return self._seen[1]

    # ------------------------------------------------------------------------------------------------ setting

    @property
    def inputs(self) -> dict[str, str]:
        """Inputs that :meth:`set` accepts: description and unit by name."""
        return {name: f"{port.words} ({port.unit})" for name, (port, _) in self._inputs.items()}

    def set(self, name: str, value: float | str, within: float | None = None) -> None:
        """Set an input from now on: a torque (N m), a force (N), the factor of a load (1; of a load along a
        guide its force, N, or pressure, Pa), or the speed of a driver (rad/s, m/s).

        ``value`` is a number in SI units or a text with a unit. ``within``: time (s) in which a driver
        reaches its new speed, by default one step. Raises ModelError for an unknown name or an invalid value.
        """
        entry = self._inputs.get(name)
        if entry is None:
            remedy = suggestion(str(name), self._inputs, "name one" if self._inputs else NOTHING_TO_SET)
            raise ModelError([Fault("name", "there is no such input", shown(name), "", remedy)], "set()")
        port, tables = entry
        if type(value) is not float:
            value = self._number(port, value)
        if not math.isfinite(value):
            raise ModelError(
                [Fault(name, "not a finite number", shown(value), port.unit, "give a number")], "set()"
            )
        if port.moves:
            self._go(port, tables, value, within)
            return
        if within is not None:
            raise ModelError(
                [Fault("within", "only a driver's speed is gone to", shown(within), "", "leave it out")],
                "set()",
            )
        for table in tables:
            table.hold(value)

    def _go(self, port: Input, tables: list[Table], speed: float, within: float | None) -> None:
        """Set the speed of a driver."""
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
            reason = "the motion of this driver is one piece, which cannot be changed during the run"
            remedy = "make it a ramp, or a table of three points"
            if self.assembly.mechanism.drivers[port.name].steady_speed is not None:
                reason = "the speed of this driver is constant"
                remedy = f"name it when the simulation is made: steered=({shown(port.name)},)"
            raise ModelError([Fault(port.name, reason, remedy=remedy)], "set()")
        for table in tables:
            table.go(self._n * self.step, speed, self.step if within is None else within)

    def _number(self, port: Input, value: Any) -> float:
        """Return a value in the SI unit of an input."""
        try:
            return number(value if isinstance(value, str | bool) else float(value), port.unit)
        except (TypeError, ValueError):
            words = f"a number in {port.unit}" if port.unit != "1" else "a number"
            raise ModelError(
                [Fault(port.name, f"this is {kind_of(value)}", shown(value), words, "give one")], "set()"
            ) from None


def looked_into(numbers: Any) -> Any:
    """Return a memory view of an array: single numbers are read and written three times as fast as
    by NumPy.
    """
    return memoryview(numbers)
