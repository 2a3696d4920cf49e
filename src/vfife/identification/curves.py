"""Curves of a mechanism with changed parameters: runs in lanes, and from each the measured channels over time
or crank angle.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import groupby
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray

from ..assembly.assemble import assemble, assemble_all
from ..assembly.assembled import Assembly
from ..assembly.reassemble import Reassembler
from ..assembly.timestep import StepRequest
from ..errors import VfifeError
from ..kinematics.initial import Motion, attempt, ideal_motions
from ..measures.motion import point_motion, times
from ..model.functions import turn_of
from ..model.mechanism import Mechanism
from ..results.run_data import standing
from ..results.series import SeriesReader, columns
from ..solvers.record import Record
from ..solvers.streaming import Lane, stepped
from ..studies.engine.cases import BATCH, CaseModel, Cases, NoLane, Numbers, sound
from ..studies.spec.plan import CaseSpec
from .run_length import RunLength
from .starts import split, with_starts

Array = NDArray[np.float64]
MOVED = {
    "x": "m",
    "y": "m",
    "velocity_x": "m/s",
    "velocity_y": "m/s",
    "acceleration_x": "m/s^2",
    "acceleration_y": "m/s^2",
}


@dataclass(frozen=True)
class Trace:
    """Channels of one case: ascending times (s) or angles (rad) ``places`` of its outputs, shape (outputs,),
    their ``values``, shape (outputs, channels), and the duration of a ``turn`` (s), if there is one.
    """

    places: Array
    values: Array
    turn: float | None

    @cached_property
    def slopes(self) -> Array:
        """Derivatives of the values by the places, shape (outputs, channels)."""
        return np.asarray(np.gradient(self.values, self.places, axis=0), dtype=float)


class Channels:
    """Read channels from records: those of a result by their names, and motions of points such as
    ``body.pin.acceleration_x``.
    """

    def __init__(self, mechanism: Mechanism, names: Sequence[str]) -> None:
        self.names, self.reader = tuple(names), SeriesReader(standing(assemble(mechanism)), names)

    def read(self, record: Record) -> Array:
        """Return the values of all channels, shape (outputs, channels)."""
        series = self.reader.read(record)
        points = {name: point_values(record, name) for name in self.names if name not in series}
        return np.stack([(series | points)[name] for name in self.names], axis=1)


def point_values(record: Record, name: str) -> Array:
    """Return a component of the position, velocity or acceleration of a point of a body, such as
    ``rod.end.velocity_x``, shape (outputs,).
    """
    point, _, component = name.rpartition(".")
    quantity, _, axis = component.rpartition("_")
    motion = point_motion(record, point)
    values = {"": motion.position, "velocity": motion.velocity, "acceleration": motion.acceleration}[quantity]
    return np.asarray(values[:, "xy".index(axis)], dtype=float)


def units_of(mechanism: Mechanism) -> dict[str, str]:
    """Return the unit of every channel that a measured curve can have, by name."""
    assembly = assemble(mechanism)
    units = {
        column.name: column.unit
        for column in columns(standing(assembly))
        if column.name not in ("time", "crank_angle")
    }
    for name, body in assembly.bodies.items():
        for pin in body.nodes if body.elements else body.pins:
            units |= {f"{name}.{pin}.{component}": unit for component, unit in MOVED.items()}
    return units


class FitCases(Cases):
    """Assemble cases of a fit, with the duration and the step that the comparison needs."""

    def __init__(self, base: Mechanism, length: RunLength) -> None:
        super().__init__(base, CaseSpec(("*",), 1))
        self.length = length

    def make_all(self, numbers: Sequence[Numbers]) -> list[CaseModel | VfifeError | None]:
        """Return models of cases; those with equal steps and outputs are assembled at once."""
        parts = [split(case) for case in numbers]
        bases = [attempt(self.mechanism, model_numbers) for model_numbers, _ in parts]
        mechanisms = with_starts(bases, [start for _, start in parts])
        result: list[CaseModel | VfifeError | None] = [
            mechanism if isinstance(mechanism, VfifeError) else None for mechanism in mechanisms
        ]
        groups: dict[tuple[float, tuple[tuple[str, Any], ...]], list[int]] = {}
        for k, mechanism in enumerate(mechanisms):
            if isinstance(mechanism, Mechanism):
                step, run = self.cut(mechanism)
                groups.setdefault((step, tuple(run.items())), []).append(k)
        for (step, items), indices in groups.items():
            run = dict(items)
            assemblies = self.assemblies([mechanisms[k] for k in indices], step, run)
            for k, assembly in zip(indices, assemblies, strict=True):
                result[k] = assembly if isinstance(assembly, VfifeError) else model_of(assembly, step, run)
        return result

    def cut(self, mechanism: Mechanism) -> tuple[float, dict[str, Any]]:
        """Return the step of a run (s), and its length and number of outputs."""
        length, turn = self.length, turn_of(mechanism)
        run: dict[str, Any] = {"outputs": length.outputs, "force_step": True}
        if length.turns is not None and turn is not None:
            return turn / (length.outputs * length.steps_per_output), {
                **run, "turns": math.ceil(length.turns(turn) - 1e-9)
            }  # fmt: skip
        return length.step, {**run, "duration": length.duration}

    def assemblies(
        self, mechanisms: Sequence[Any], step: float, run: Mapping[str, Any]
    ) -> list[Assembly | VfifeError]:
        """Return assemblies of mechanisms with equal steps and outputs, or the errors of those without."""
        motions = [motion if isinstance(motion, Motion) else None for motion in ideal_motions(mechanisms)]
        expected: list[Mapping[str, float]] = [{}] * len(mechanisms)
        return assemble_all(mechanisms, step, expected=expected, motions=motions, **run)

    def assembled(self, numbers: Numbers) -> Assembly:
        """Return the assembly of a case. Raises VfifeError if it cannot be assembled."""
        # Numbers of joints with clearance do not change the ideal motion: a model that was assembled with
        # the same other numbers is reused, and only its contacts are filled again.
        clearance = {path: value for path, value in numbers.items() if self.of_clearance(path)}
        model = cast(
            CaseModel, self.model({path: value for path, value in numbers.items() if path not in clearance})
        )
        assembly = self.reassembled(model, clearance) if clearance else model.assembly
        if assembly is None:
            assembly = cast(CaseModel, sound(self.make_all([numbers])[0])).assembly
        return assembly


def model_of(assembly: Assembly, step: float, run: Mapping[str, Any]) -> CaseModel:
    """Return the model shared by cases that differ only in clearances."""
    return CaseModel(Reassembler(assembly, StepRequest(step, **run)), None, None, lambda *_: assembly)  # type: ignore[arg-type]


class Curves:
    """Compute traces of a mechanism with given numbers; ``channels`` are the measured ones."""

    def __init__(
        self, mechanism: Mechanism, channels: Channels, length: RunLength, workers: int | None = None
    ) -> None:
        self.cases = FitCases(mechanism, length)
        self.channels, self.length, self.workers = channels, length, workers

    @property
    def has_contacts(self) -> bool:
        """Whether the mechanism has joints with clearance or other contacts."""
        return bool(self.cases.base.contacts)

    def changed(self, finer: int, turns: float, denser: int = 1) -> Curves:
        """Return the same curves with ``finer`` more steps between two outputs, ``turns`` more turns, and
        ``denser`` times as many outputs.
        """
        length = self.length
        steps, last = math.ceil((length.steps_per_output + finer) / denser), length.turns
        longer = None if last is None else lambda turn: last(turn) + turns
        length = replace(
            length, turns=longer, outputs=length.outputs * denser, steps_per_output=steps,
            step=length.step * length.steps_per_output / (denser * steps),
        )  # fmt: skip
        return Curves(self.cases.base, self.channels, length, self.workers)

    def case_traces(self, cases: Sequence[tuple[Curves, Numbers]]) -> list[Trace | str]:
        """Return the trace of each case, of these curves or of others, or the reason why it has none. All
        cases are stepped side by side.
        """
        result: list[Trace | str] = [""] * len(cases)
        for lane in stepped(_lanes(cases), len(cases), workers=self.workers):
            if isinstance(lane, NoLane):
                result[lane.number] = lane.reason or ""
            else:
                curves = cases[lane.number][0]
                result[lane.number] = (
                    "numbers grew without bound" if lane.doubtful else curves.trace(lane.record)
                )
        return result

    def trace(self, record: Record) -> Trace:
        """Return the channels of a record over time (s) or crank angle (rad), ascending."""
        places = times(record)
        if self.length.abscissa == "angle":
            angle = record.block("particle_theta")[:, record.assembly.topology.driven[0]]
            places = angle if angle[-1] >= angle[0] else -angle
        return Trace(places, self.channels.read(record), record.assembly.choice.turn)


def _lanes(cases: Sequence[tuple[Curves, Numbers]]) -> Iterator[Lane | NoLane]:
    """Lanes of cases; models of those that follow one another and have the same curves are made at once."""
    for first in range(0, len(cases), BATCH):
        batch = cases[first : first + BATCH]
        for _, group in groupby(batch, key=lambda case: id(case[0])):
            pairs = list(group)
            pairs[0][0].cases.prepare([numbers for _, numbers in pairs])
        for k, (curves, numbers) in enumerate(batch, start=first):
            try:
                yield Lane(k, curves.cases.assembled(numbers))
            except VfifeError as error:
                yield NoLane(k, " ".join(str(error).split()))
