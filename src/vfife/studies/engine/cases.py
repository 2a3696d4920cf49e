"""Cases of a study: one mechanism with different numbers, run on all cores, of which only the requested
measures are kept.

A case has the bits of its own run, whatever runs beside it. A *model* is assembled
once for all cases that differ only in numbers of clearance joints.
"""

from __future__ import annotations

import dataclasses
import gc
import threading
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from functools import cache, cached_property, partial
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np

from ...assembly.assemble import assemble, assemble_all
from ...assembly.assembled import Assembly
from ...assembly.possible import Outlook, outlooks
from ...assembly.reassemble import Reassembler, is_reassemblable
from ...assembly.timestep import StepRequest
from ...compiler.runtime.cuda import WITHOUT, card
from ...errors import DeviceError, VfifeError
from ...kernels.arrays import Layout
from ...kinematics.batch import Structures
from ...kinematics.initial import attempt
from ...measures.catalogue import RequestedMeasures
from ...model.joints import Contact
from ...model.mechanism import Mechanism
from ...model.validation import Checks, conflict_faults
from ...model.validation.bodies import check_bodies
from ...model.validation.loads import check_straight
from ...modelfile import dump, loads
from ...modelfile.parameter import Parameter, replaced
from ...results.run_data import Reductions
from ...simulation.start import ideals_of
from ...solvers.interrupts import Workers
from ...solvers.status import Status
from ...solvers.streaming import stepped
from ..spec.plan import CaseSpec
from .lanes import Plan, Stepped, peaks_of, streams
from .outcome import FAILED, Outcome, sentence, single

Numbers = Mapping[str, float | str]
LAWS = ("contact", "friction")
LOAD = ".force.max"  # ends the name of the largest force of a joint
# Cases whose models are made at once. Each call of numpy costs as much for one case as for all.
BATCH = 256
# Latest models that are cached; fewer than BATCH would drop some of a batch before its cases are made.
MOST_MODELS = BATCH


class ClearanceNumber(NamedTuple):
    """A number of a clearance joint, or of one of its laws (``law`` is "contact" or "friction", else "")."""

    joint: str
    law: str
    field: str
    parameter: Parameter


@dataclass(frozen=True)
class CaseModel:
    """A mechanism assembled for all cases that differ from it only in numbers of clearance joints.

    ``reference``: largest values of the ideal mechanism; ``again`` assembles one of the cases with another
    step (s).
    """

    reassembler: Reassembler
    plan: Plan
    reference: Mapping[str, float] | None
    assemble_again: Callable[[Mechanism, float], Assembly]

    @property
    def assembly(self) -> Assembly:
        """Assembly with the clearance joints of the model itself."""
        return self.reassembler.assembly


@dataclass
class NoLane:
    """A case that no lane can step: ``reason`` tells why it cannot run at all; None means that it needs a run
    of its own.
    """

    number: int
    reason: str | None = None
    finished: bool = True


class Cases:
    """Assembles the cases of a study in batches; each has the bits that it would have alone."""

    def __init__(self, base: Mechanism, spec: CaseSpec) -> None:
        settings = dataclasses.replace(base.settings, settle=spec.settle, companions=0)
        self.base, self.wanted = dataclasses.replace(base, settings=settings), spec
        reduced = Reductions(spec.measures)
        self.measures = RequestedMeasures(
            spec.measures, reduced.compute if reduced.requested else None, spec.counts
        )
        self.parameters: dict[str, Parameter | None] = {}
        self.clearances: dict[str, ClearanceNumber | None] = {}
        # Without reassembly a clearance is a number like any other, so its cases are assembled as a batch.
        self.reassembles = is_reassemblable(self.base)
        self.models: dict[ModelKey, CaseModel | VfifeError | None] = {}
        self.neighbour = Outlook()
        self.plans: dict[int, tuple[Layout, Plan]] = {}
        keep_memory()

    @cached_property
    def text(self) -> str:
        """The model file of the mechanism, in which values that no object holds are replaced."""
        return dump(self.base)

    def prepare_each(self, numbers: Sequence[Numbers]) -> Iterator[Stepped | NoLane]:
        """Yield the cases in order, assembled in batches of 1, 16, BATCH, BATCH, ...: the first ones are few,
        so that lanes start at once.
        """
        for first, end in pairwise((0, 1, *range(17, len(numbers), BATCH), len(numbers))):
            self.prepare(numbers[first:end])
            for k in range(first, min(end, len(numbers))):
                result = attempt(self.case, k, numbers[k])
                yield NoLane(k, sentence(result)) if isinstance(result, VfifeError) else result

    def prepare(self, numbers: Sequence[Numbers]) -> None:
        """Make all models that these cases need and that are not cached; the oldest models are dropped."""
        distinct = {
            model_key(model_numbers): model_numbers for model_numbers in map(self.without_clearance, numbers)
        }
        # Models of this batch move to the end: the batch's new ones drop older models before them.
        self.models |= {key: self.models.pop(key) for key in distinct if key in self.models}
        unknown = {key: model_numbers for key, model_numbers in distinct.items() if key not in self.models}
        with collector_paused():
            models = self.make_all(list(unknown.values()))
        for key, result in zip(unknown, models, strict=True):
            # Dictionaries keep the order of insertion, so the first model is the oldest. Neighbouring cases
            # of a study share models, so that an old one is rarely needed again.
            while len(self.models) >= MOST_MODELS:
                del self.models[next(iter(self.models))]
            self.models[key] = result

    def without_clearance(self, numbers: Numbers) -> Numbers:
        """Return the numbers that do not belong to clearance joints."""
        return {path: value for path, value in numbers.items() if not self.of_clearance(path)}

    def case(self, number: int, numbers: Numbers) -> Stepped | NoLane:
        """Return a case ready for a lane. Raises VfifeError if it cannot be assembled."""
        model_numbers = self.without_clearance(numbers)
        clearance = {path: value for path, value in numbers.items() if path not in model_numbers}
        try:
            model = self.model(model_numbers)
        except VfifeError:
            if not clearance:
                raise
            # What cannot be with the clearances of the base may be with its own.
            model, clearance = self.make(numbers), {}
        assembly = model and (self.reassembled(model, clearance) if clearance else model.assembly)
        if model and not assembly and (model := self.make(numbers)):
            assembly = model.assembly
        if not model or not assembly:
            return NoLane(number)
        return Stepped(number, assembly, model.plan, model.reference, model.assemble_again)

    def parameter(self, path: str) -> Parameter | None:
        """Return the parameter of a path that is a number of an object of the mechanism; None for others,
        which require reading the model's text again.
        """
        if path not in self.parameters:
            self.parameters[path] = None
            with suppress(VfifeError):
                result = Parameter(self.base, path)
                result = (
                    result if result.steps else Parameter(self.base, result.path)
                )  # a joint by the bodies that it connects
                self.parameters[path] = result if result.steps else None
        return self.parameters[path]

    def of_clearance(self, path: str) -> ClearanceNumber | None:
        """Return the number of a path if it belongs to a clearance joint or its laws and affects nothing
        else, else None.
        """
        if path not in self.clearances:
            self.clearances[path] = None
            result = self.parameter(path)
            steps = (
                ()
                if result is None or result.quantity is None or result.quantity.words
                else tuple(map(str, result.steps or ()))
            )
            of_law = len(steps) == 4 and steps[2] in LAWS
            if (
                result is not None
                and self.reassembles
                and steps[:1] == ("joints",)
                and self.base.joints[steps[1]].refits
                and (len(steps) == 3 or of_law)
            ):
                self.clearances[path] = ClearanceNumber(
                    steps[1], steps[2] if of_law else "", steps[-1], result
                )
        return self.clearances[path]

    def reassembled(self, model: CaseModel, clearance: Numbers) -> Assembly | None:
        """Return the assembly with other numbers of its clearance joints; None if a value is invalid or needs
        a full assembly.
        """
        changes: dict[str, dict[str, dict[str, float]]] = {}
        for path, value in clearance.items():
            number = self.of_clearance(path)
            if number is None:
                return None
            try:
                changes.setdefault(number.joint, {}).setdefault(number.law, {})[number.field] = (
                    number.parameter.read(value)
                )
            except ValueError:
                return None
        joints: dict[str, Contact] = {}
        for name, parts in changes.items():
            result: Any = model.assembly.mechanism.joints[name]
            try:
                laws = {
                    kind: dataclasses.replace(getattr(result, kind), **values)
                    for kind, values in parts.items()
                    if kind
                }
                joints[name] = dataclasses.replace(result, **parts.get("", {}), **laws)
            except ValueError:
                return None
        return model.reassembler.with_joints(joints)

    def model(self, numbers: Numbers) -> CaseModel | None:
        """Return the model with these numbers, none of which belongs to a clearance joint. Raises VfifeError
        if it cannot be made.
        """
        key = model_key(numbers)
        if key not in self.models:
            self.prepare([numbers])
        return sound(self.models[key])

    def make(self, numbers: Numbers) -> CaseModel | None:
        """Return a model and run its ideal mechanism; None if it cannot run in a lane. Raises VfifeError if
        it cannot be made.
        """
        return sound(self.make_all([numbers])[0])

    def make_all(self, numbers: Sequence[Numbers]) -> list[CaseModel | VfifeError | None]:
        """Return many models, or the error of each that cannot be made. Starts are solved, ranges of motion
        examined and ideal mechanisms run side by side.
        """
        # Each stage works on all mechanisms that passed the one before it, side by side: one by one, solving
        # many small systems takes up to ten times as long. An error takes the place of its mechanism and
        # stops none of the others.
        turns = float(self.wanted.turns)
        read = [attempt(self.mechanism, case_numbers) for case_numbers in numbers]
        result: list[CaseModel | VfifeError | None] = [
            mechanism if isinstance(mechanism, VfifeError) else None for mechanism in read
        ]
        structures = Structures()
        # A static analysis takes no steps, a duration has no turns: None sends a case to a run of its own.
        mechanisms = {
            k: mechanism
            for k, mechanism in enumerate(read)
            if isinstance(mechanism, Mechanism)
            and mechanism.settings.analysis != "static"
            and self.wanted.duration is None
        }
        looks = outlooks(list(mechanisms.values()), turns, self.neighbour, structures=structures)
        answers = dict(zip(mechanisms, looks, strict=True))
        outlook = {k: answer for k, answer in answers.items() if isinstance(answer, Outlook)}
        # The next batch differs in numbers only, so its ranges of motion are predicted from the last one of
        # this batch.
        self.neighbour = next(reversed(outlook.values()), self.neighbour)
        # Ideal mechanisms run before the assembly, because the automatic step follows from their largest
        # forces.
        passing = {k: mechanisms[k] for k, answer in outlook.items() if answer.passes}
        motions = [outlook[k].motion for k in passing]
        ideal = ideals_of(list(passing.values()), turns, motions, structures)
        ideals = dict(zip(passing, ideal, strict=True))
        peaks = peaks_of({k: ideal for k, ideal in ideals.items() if isinstance(ideal, Assembly)}, structures)
        # An ideal mechanism that ended without peaks leaves None in ``result``: the case has a run of its
        # own, which reports the reason.
        ready = [k for k in outlook if ideals.get(k) is None or k in peaks]
        expected = [largest_forces(peaks.get(k, {})) for k in ready]
        assemblies = assemble_all(
            [mechanisms[k] for k in ready], self.wanted.step, expected=expected,
            motions=[outlook[k].motion for k in ready], turns=turns, structures=structures,
        )  # fmt: skip
        for k, fault in (*answers.items(), *ideals.items(), *zip(ready, assemblies, strict=True)):
            result[k] = fault if isinstance(fault, VfifeError) else result[k]
        for k, assembly, forces in zip(ready, assemblies, expected, strict=True):
            if isinstance(assembly, Assembly):
                result[k] = self.lane_model(assembly, forces, peaks.get(k), outlook[k].passes)
        return result

    def lane_model(
        self,
        assembly: Assembly,
        expected: Mapping[str, float],
        reference: Mapping[str, float] | None,
        passes: bool,
    ) -> CaseModel | None:
        """Return the model of an assembly for lanes; None if it cannot run in a lane."""
        if not streams(assembly):
            return None
        # Where clearance has to bridge what opens, it decides whether it can, so other clearances are
        # assembled anew.
        turns = float(self.wanted.turns)
        reassembler = Reassembler(assembly, StepRequest(self.wanted.step, turns=turns), expected, passes)
        layout = assembly.layout
        if id(layout) not in self.plans:  # the layout is kept, so that no other one gets its identity
            self.plans[id(layout)] = layout, Plan(assembly, self.wanted, self.measures)
        return CaseModel(
            reassembler,
            self.plans[id(layout)][1],
            reference,
            partial(assemble, expected=expected, turns=turns),
        )

    def mechanism(self, numbers: Numbers) -> Mechanism:
        """Return the mechanism with other numbers. Raises VfifeError with the faults that its text has with
        them.
        """
        # Replacing fields skips the reader of model files. Checks of single fields run all the same, and
        # ``conflicts`` tests the fields against each other. If any of them fails, the text is read with the
        # new numbers, because the reader explains the fault by its place in the file.
        parameters = [self.parameter(path) for path in numbers]
        with suppress(ValueError):
            result = self.valid_base
            for parameter, value in zip(parameters, numbers.values(), strict=True):
                if result is None or parameter is None or parameter.steps is None:
                    break
                result = replaced(result, parameter.steps, parameter.read(value))
            else:
                if result is not None and not self.conflicts(result, parameters):
                    return result
        return loads(self.text, set=list(numbers.items()))

    @cached_property
    def valid_base(self) -> Mechanism | None:
        """The base without its file; None if it contradicts itself."""
        return None if conflict_faults(Checks(self.base)) else dataclasses.replace(self.base, source=None)

    def conflicts(self, mechanism: Mechanism, parameters: Iterable[Parameter | None]) -> bool:
        """Return whether numbers of a mechanism that differs from the valid base in these parameters
        contradict each other.
        """
        if mechanism is self.valid_base:
            return False
        checks = Checks(mechanism)
        sections = {parameter.steps[0] for parameter in parameters if parameter and parameter.steps}
        if sections <= {"bodies"}:
            # Other sections refer to bodies by names and kinds, except a load along a moving guide: what
            # slides there turns with the guide only if it has an inertia.
            check_bodies(checks)
            for name, load in mechanism.loads.items():
                if load.on_guide:
                    check_straight(checks, ("load", name), load)
            return bool(checks.faults)
        return bool(conflict_faults(checks))


@contextmanager
def collector_paused() -> Iterator[None]:
    """Pause the garbage collector: nearly all objects of a batch live on, so that looking for cycles among
    them takes an eighth of the time and finds none.
    """
    enabled = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if enabled:
            # The objects of the batch become old, as after a collection that found them all in use. Objects
            # that the user froze stay frozen.
            if not gc.get_freeze_count():
                gc.freeze()
                gc.unfreeze()
            gc.enable()


@cache
def keep_memory() -> None:
    """Make the C library of Linux keep the memory of arrays that are gone.

    Arrays of a batch have up to some MB each. By default such memory goes back to the system at once, and the
    next array gets it page by page. The library keeps blocks up to the size of the largest one that it gave
    back, 32 MiB at most. This block of 32 MB is never written.
    """
    np.empty(4_000_000)


def largest_forces(peaks: Mapping[str, float]) -> dict[str, float]:
    """Return the largest force (N) of each joint, from the largest values of an ideal mechanism."""
    return {name.removesuffix(LOAD): value for name, value in peaks.items() if name.endswith(LOAD)}


ModelKey = tuple[tuple[str, float | str], ...]


def sound(model: CaseModel | VfifeError | None) -> CaseModel | None:
    """Return a model. Raises the error in its place."""
    if isinstance(model, VfifeError):
        raise VfifeError(str(model))
    return model


def model_key(numbers: Numbers) -> ModelKey:
    """Return the numbers as a key that does not depend on their order."""
    return tuple(sorted(numbers.items()))


__all__ = ["Outcome", "run_cases"]


def run_cases(
    base: Mechanism,
    numbers: Sequence[Numbers],
    spec: CaseSpec,
    *,
    workers: int | None = None,
    lanes: int | None = None,
    stop: threading.Event | None = None,
    device: str | None = None,
) -> Iterator[tuple[int, Outcome]]:
    """Run a mechanism with each of ``numbers`` and yield index and outcome of each case as it ends.

    ``numbers``: values by path, in SI units or as texts with a unit. A case that cannot be assembled or
    diverges has an outcome with the reason; the others continue. ``workers``: threads, by default one per
    core; ``lanes``: simulations side by side in each. When ``stop`` is set, unfinished cases are dropped.
    ``device``: "cuda" steps all cases on an NVIDIA card except those that need a run of their own; raises
    DeviceError.
    """
    stop, cases = stop or threading.Event(), Cases(base, spec)
    alone: list[int] = []
    for case in stepped(
        cases.prepare_each(numbers), len(numbers), lanes=lanes, workers=workers, stop=stop, device=device
    ):
        # Doubtful cases (numbers out of bounds, energy that does not balance) run again by themselves at the
        # end: lanes keep too little of a motion to determine status and reason.
        if isinstance(case, NoLane) and case.reason is not None:
            yield case.number, Outcome(status=FAILED, reason=case.reason)
        elif isinstance(case, Stepped) and not case.doubtful:
            step, interval = case.assembly.choice.step, case.per * case.assembly.choice.outputs_every
            yield (
                case.number,
                Outcome(
                    case.values,
                    case.turns,
                    case.settled,
                    str(Status.COMPLETE),
                    None,
                    step,
                    case.turns * interval,
                    case.period,
                    case.measured_turns,
                    case.ranges,
                    case.cautions,
                ),
            )
        else:
            alone.append(case.number)
    yield from by_themselves(cases, numbers, alone, workers, stop)


def on_device(name: str | None) -> Callable[..., Iterator[tuple[int, Outcome]]] | None:
    """Return a function that runs cases on a device, None for the processor. Raises DeviceError if the device
    cannot be used.
    """
    if name is None:
        return None
    if name != "cuda":
        raise DeviceError(
            f'device {name}: there is no such device; there is "cuda", an NVIDIA card; {WITHOUT}'
        )
    card()
    return partial(run_cases, device=name)


def by_themselves(
    cases: Cases, numbers: Sequence[Numbers], alone: Sequence[int], workers: int | None, stop: threading.Event
) -> Iterator[tuple[int, Outcome]]:
    """Run the cases that need runs of their own: those that fit no lane, and those whose outcome a lane
    cannot determine.
    """

    def one(k: int) -> tuple[int, Outcome | None]:
        return k, None if stop.is_set() else single(cases, numbers[k])

    with Workers(workers) as threads:
        for k, result in threads.results([threads.submit(one, k) for k in alone]):
            if result is not None:
                yield k, result
