"""Members of a study: one mechanism with other numbers each, run on all that the machine has; of each the
measures that are wanted are left.

A member is what its own run would be, to the bit, whatever runs beside it.
"""

from __future__ import annotations

import dataclasses
import math
import threading
from collections import deque
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from functools import partial
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...assembly.assemble import Reassembler, assemble
from ...assembly.assembled import Assembly, limited_rows
from ...assembly.possible import Outlook, outlook
from ...compiler.runtime.cuda import WITHOUT, card
from ...errors import DeviceError, VfifeError
from ...measures.catalogue import PEAKS, WantedMeasures, last_turn, over_turn
from ...measures.energy import ledger
from ...measures.ranges import DEEP_HALVINGS
from ...measures.turns import each_turn
from ...model.joints import Contact
from ...model.mechanism import Mechanism
from ...model.validation import Checks, across
from ...modelfile import dump, loads
from ...modelfile.parameter import Parameter, replaced
from ...results.view import Reductions
from ...simulation.simulate import carry_out, prepare
from ...simulation.start import ideal_of
from ...solvers.arguments import Loop, RunArguments
from ...solvers.companions import measured_rows
from ...solvers.interrupts import Workers
from ...solvers.record import Columns, Record, places, recorded_rows
from ...solvers.repeating import Settling, outputs_of_a_turn
from ...solvers.status import Status
from ...solvers.streaming import Lane, stepped
from ...solvers.transient import choose_loop, run

Array = NDArray[np.float64]

# ends of turns that are kept to see whether energy is accounted for; every second of them goes when there are
# more
ENDS = 64
AT_ONCE = 16  # turns between two looks, where nothing is asked for at their ends
DOUBTFUL = (
    0.1  # of the energy limit: a ledger that is as open at the ends of turns is looked at output by output
)


@dataclass(frozen=True)
class Wanted:
    """What is asked of every member: ``measures`` by the names that ``vfife run --json`` gives them, all
    where there are none.

    It is stepped for so many ``turns`` at the most, and ends before where turns repeat within ``settle`` (1).
    Measures of a turn are means over the ``last`` turns. ``step`` (s): None takes the automatic step of each.
    """

    measures: tuple[str, ...]
    turns: int
    settle: float | None = None
    last: int = 1
    step: float | None = None

    @classmethod
    def of(cls, written: Mapping[str, Any]) -> Wanted:
        """Return what was written as a mapping of its fields."""
        return cls(**{**written, "measures": tuple(written["measures"])})


def streams(assembly: Assembly, loop: Loop = "auto") -> bool:
    """Whether a member may be stepped in a lane: turns of a crank at constant speed, in whole outputs, and a
    step that is written out.
    """
    settings = assembly.mechanism.settings
    return (
        settings.analysis != "static"
        and outputs_of_a_turn(assembly) is not None
        and choose_loop(assembly, loop) == "generated"
    )


class Plan:
    """What is kept of members that differ in numbers of play: the rows that their lanes hand out, and where
    blocks stand among them.

    Where one row for each turn tells all that is ``wanted``, and nobody asks whether turns repeat, a turn is
    handed out as one output.
    """

    def __init__(self, assembly: Assembly, wanted: Wanted, measures: WantedMeasures) -> None:
        self.wanted, self.measures = wanted, measures
        self.recorded = recorded_rows(assembly)
        self.fine = wanted.settle is not None or not measures.by_turn
        self.handed = rows_by_turn(assembly) if measures.by_turn and self.fine else self.recorded
        self.told, self.ends = Columns(assembly.layout, self.handed), Columns(assembly.layout, self.recorded)
        self.limited = places(self.handed, limited_rows(assembly))
        self.deep = assembly.layout["contact_deep"]


class Stepped(Lane):
    """A member in a lane. ``again`` assembles it with another step, ``reference`` are measures of the ideal
    mechanism.

    It is ``doubtful`` where its own run has to tell what became of it: where numbers left all bounds, or
    energy may be unaccounted for.
    """

    def __init__(
        self,
        number: int,
        assembly: Assembly,
        plan: Plan,
        reference: Mapping[str, float] | None,
        again: Callable[[Mechanism, float], Assembly],
    ) -> None:
        super().__init__(number, assembly, plan.handed, limited=plan.limited)
        self.plan, self.reference, self.again = plan, reference, again
        if not plan.fine:
            self.every *= self.per
        self.rows = self.per if plan.fine else 1  # of a turn
        self.turns, self.values = 0, dict[str, float]()
        self.settling: Settling | None = None

    @property
    def outputs(self) -> int:
        """Rows up to the next look: those of a turn, or where they are one, of several turns."""
        return self.rows if self.plan.fine else min(AT_ONCE, self.plan.wanted.turns - self.turns)

    def start(self, state: Array) -> None:
        """The first output."""
        plan, settle = self.plan, self.plan.wanted.settle
        if settle is not None:
            self.settling = Settling(self.assembly, self.handed, settle)
        self.last: deque[Array] = deque(maxlen=plan.wanted.last)
        self.before, self.ends = state[None, self.handed], [(0, state[self.plan.recorded])]

    def take(self, rows: Array, broken: int, state: Array) -> None:
        """A turn, or several of a row each."""
        self.doubtful = (
            broken >= 0
            or bool(self.bounds.unsound(rows).any())
            or not np.isfinite(state[self.plan.recorded]).all()
        )
        if self.doubtful:
            return
        for turn in np.split(rows, len(rows) // self.rows):
            self.turns += 1
            self.last.append(np.concatenate([self.before, turn]))
            self.before = turn[-1:]
            self.ends.append((self.turns, state[self.plan.recorded] if self.plan.fine else turn[-1]))
            if len(self.ends) > ENDS:
                del self.ends[1::2]
        if self.settling is not None:
            self.settling.take(rows)
        self.final = state

    @property
    def ended(self) -> bool:
        """Whether no turn is left to make."""
        return (
            self.doubtful
            or self.turns == self.plan.wanted.turns
            or (self.settling is not None and self.settling.ended)
        )

    @property
    def settled(self) -> int | None:
        """The turn after which it ended because turns repeat."""
        return self.turns if self.settling is not None and self.settling.ended else None

    def end(self) -> Stepped | None:
        """Takes its measures; where first contacts landed too deep for an automatic step, it is made again
        with half of that.
        """
        choice, assembly = self.assembly.choice, self.assembly
        if self.doubtful:
            return None
        deep = bool(np.any(self.final[self.plan.deep]))
        if deep and choice.automatic and len(choice.tried) < DEEP_HALVINGS[0]:
            return Stepped(self.number, self._halved(), self.plan, self.reference, self.again)
        size = self.per * choice.outputs_every
        steps, rows = zip(*self.ends, strict=True)
        whole = Record(
            assembly,
            np.array(steps, dtype=np.int64) * size,
            np.array(rows),
            self.plan.recorded,
            columns=self.plan.ends,
        )
        self.doubtful = ledger(whole).error > DOUBTFUL * assembly.mechanism.settings.energy_limit
        first = self.turns - len(self.last)
        records = []
        for k, own in enumerate(self.last, first):
            at = np.arange(k * self.rows, (k + 1) * self.rows + 1, dtype=np.int64) * self.every
            records.append(Record(assembly, at, own, self.handed, columns=self.plan.told))
        self.values = self.plan.measures.over(records, self.reference)
        del self.final, self.before
        self.last.clear()
        self.ends.clear()
        return None

    def _halved(self) -> Assembly:
        """The same with half the step, which stays an automatic one."""
        choice = self.assembly.choice
        found = self.again(self.assembly.mechanism, 0.5 * choice.step)
        tried = (*choice.tried, (choice.step, None))
        return dataclasses.replace(
            found, choice=dataclasses.replace(found.choice, automatic=True, tried=tried)
        )


def rows_by_turn(assembly: Assembly) -> NDArray[np.uint32]:
    """Rows of S that tell the measures of a turn of which its extremes and its end are enough, whether turns
    repeat, and whether it broke.
    """
    forces = np.asarray(assembly.layout.rows_of("contact_normal_force"), dtype=np.uint32)
    return np.unique(np.concatenate([measured_rows(assembly), limited_rows(assembly), forces]))


Numbers = Mapping[str, float | str]
LAWS = ("contact", "friction")
MOST_MODELS = 64  # that differ in other numbers than those of clearance joints


class ClearanceNumber(NamedTuple):
    """A number of a clearance joint, or of one of its laws ("contact", "friction", else "")."""

    joint: str
    law: str
    field: str
    parameter: Parameter


@dataclass(frozen=True)
class CaseModel:
    """A mechanism assembled for cases that differ from it in numbers of its clearance joints alone.

    ``reference``: largest values of the ideal mechanism; ``again`` assembles one of the cases with another
    step (s).
    """

    reassembler: Reassembler
    plan: Plan
    reference: Mapping[str, float] | None
    again: Callable[[Mechanism, float], Assembly]

    @property
    def assembly(self) -> Assembly:
        """That of the model's own clearance joints."""
        return self.reassembler.assembly


@dataclass
class NoLane:
    """A case that no lane steps: the reason why it cannot be run, or None where it needs a run of its own."""

    number: int
    reason: str | None = None
    ended: bool = True


class Cases:
    """Assembles cases of a mechanism one after the other."""

    def __init__(self, base: Mechanism, wanted: Wanted) -> None:
        settings = dataclasses.replace(base.settings, settle=wanted.settle, companions=0)
        self.base, self.wanted = dataclasses.replace(base, settings=settings), wanted
        self.text = dump(self.base)
        reduced = Reductions(wanted.measures)
        self.measures = WantedMeasures(wanted.measures, reduced.over if reduced.asked else None)
        self.parameters: dict[str, Parameter | None] = {}
        self.clearances: dict[str, ClearanceNumber | None] = {}
        self.models: dict[tuple[tuple[str, float | str], ...], CaseModel | VfifeError | None] = {}
        self.neighbour = Outlook()

    def each(self, numbers: Sequence[Numbers]) -> Iterator[Stepped | NoLane]:
        """The cases in their order."""
        for k, one in enumerate(numbers):
            try:
                yield self.case(k, one)
            except VfifeError as error:
                yield NoLane(k, sentence(error))

    def case(self, number: int, numbers: Numbers) -> Stepped | NoLane:
        """One of them. Raises VfifeError where it cannot be assembled."""
        clearance = {path: value for path, value in numbers.items() if self.of_clearance(path)}
        try:
            model = self.model({path: value for path, value in numbers.items() if path not in clearance})
        except VfifeError:
            if not clearance:
                raise
            model, clearance = (
                self.make(numbers),
                {},
            )  # what cannot be with the clearances of the base may be with its own
        if model is None:
            return NoLane(number)
        assembly = self.reassembled(model, clearance) if clearance else model.assembly
        if assembly is None:
            model = self.make(numbers)
            return (
                NoLane(number)
                if model is None
                else Stepped(number, model.assembly, model.plan, model.reference, model.again)
            )
        return Stepped(number, assembly, model.plan, model.reference, model.again)

    def parameter(self, path: str) -> Parameter | None:
        """A number that an object of the mechanism holds; None of any other, which takes a reader of models."""
        if path not in self.parameters:
            self.parameters[path] = None
            with suppress(VfifeError):
                found = Parameter(self.base, path)
                found = (
                    found if found.steps else Parameter(self.base, found.path)
                )  # a joint by the bodies that it connects
                self.parameters[path] = found if found.steps else None
        return self.parameters[path]

    def of_clearance(self, path: str) -> ClearanceNumber | None:
        """A number of a revolute joint with clearance, or of its laws, and of nothing else; None of any
        other.
        """
        if path not in self.clearances:
            self.clearances[path] = None
            found = self.parameter(path)
            steps = (
                ()
                if found is None or found.quantity is None or found.quantity.words
                else tuple(map(str, found.steps or ()))
            )
            of_law = len(steps) == 4 and steps[2] in LAWS
            if (
                found is not None
                and steps[:1] == ("joints",)
                and self.base.joints[steps[1]].refits
                and (len(steps) == 3 or of_law)
            ):
                self.clearances[path] = ClearanceNumber(
                    steps[1], steps[2] if of_law else "", steps[-1], found
                )
        return self.clearances[path]

    def reassembled(self, model: CaseModel, clearance: Numbers) -> Assembly | None:
        """The assembly with other numbers of its clearance joints; None where a value is none that can be
        taken as it is.
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
            found: Any = model.assembly.mechanism.joints[name]
            try:
                laws = {
                    kind: dataclasses.replace(getattr(found, kind), **values)
                    for kind, values in parts.items()
                    if kind
                }
                joints[name] = dataclasses.replace(found, **parts.get("", {}), **laws)
            except ValueError:
                return None
        return model.reassembler.with_joints(joints)

    def model(self, numbers: Numbers) -> CaseModel | None:
        """The model with such numbers, none of them of clearance joints. Raises VfifeError where there can be
        none.
        """
        key = tuple(sorted(numbers.items()))
        if key not in self.models:
            if len(self.models) >= MOST_MODELS:
                del self.models[next(iter(self.models))]
            try:
                self.models[key] = self.make(numbers)
            except VfifeError as error:
                self.models[key] = error
        found = self.models[key]
        if isinstance(found, VfifeError):
            raise VfifeError(str(found))
        return found

    def make(self, numbers: Numbers) -> CaseModel | None:
        """A model assembled, and its ideal mechanism run; None for one that does not go into a lane."""
        mechanism, turns = self.mechanism(numbers), float(self.wanted.turns)
        if mechanism.settings.analysis == "static":
            return None
        self.neighbour = seen = outlook(mechanism, turns, neighbour=self.neighbour)
        ideal = ideal_of(mechanism, turns, motion=seen.motion) if seen.through else None
        reference = None
        if ideal is not None:
            record = run(ideal)
            if record.status != Status.COMPLETE:
                return None
            reference = over_turn(record, last_turn(record), PEAKS)
        expected = {
            name.removesuffix(".force.max"): value
            for name, value in (reference or {}).items()
            if name.endswith(".force.max")
        }
        assembly = assemble(mechanism, self.wanted.step, expected=expected, motion=seen.motion, turns=turns)
        if not streams(assembly):
            return None
        # Where clearance has to bridge what opens, it decides whether it can, so other clearances are
        # assembled anew.
        reassembler = Reassembler(assembly, self.wanted.step, expected, usable=seen.through, turns=turns)
        return CaseModel(
            reassembler,
            Plan(assembly, self.wanted, self.measures),
            reference,
            partial(assemble, expected=expected, turns=turns),
        )

    def mechanism(self, numbers: Numbers) -> Mechanism:
        """The mechanism with other numbers. Raises VfifeError, as its text does that is read with them, which
        is needed for some of them.
        """
        parameters = [self.parameter(path) for path in numbers]
        with suppress(ValueError):
            found = dataclasses.replace(self.base, source=None)
            for parameter, value in zip(parameters, numbers.values(), strict=True):
                if parameter is None or parameter.steps is None:
                    break
                found = replaced(found, parameter.steps, parameter.read(value))
            else:
                if not across(Checks(found)):
                    return found
        return loads(self.text, set=list(numbers.items()))


def sentence(error: VfifeError) -> str:
    """An error in one line."""
    return " ".join(line.strip() for line in str(error).splitlines() if line.strip())


FAILED = "failed"

__all__ = ["Outcome", "Wanted", "run_members"]


@dataclass(frozen=True)
class Outcome:
    """What a member leaves: ``values`` by measure, SI units, none where it failed; whole turns made, the one
    from which on turns repeat.

    ``status`` as of a run ("complete", "diverged", "energy"), or "failed" where it could not be assembled;
    ``reason``: one sentence where it is not complete. ``step`` (s) and ``steps`` are those it was run with.
    """

    values: dict[str, float] = field(default_factory=dict)
    turns: int = 0
    settled: int | None = None
    status: str = "complete"
    reason: str | None = None
    step: float = math.nan
    steps: int = 0


def run_members(
    base: Mechanism,
    numbers: Sequence[Numbers],
    wanted: Wanted,
    *,
    workers: int | None = None,
    lanes: int | None = None,
    stop: threading.Event | None = None,
    device: str | None = None,
) -> Iterator[tuple[int, Outcome]]:
    """Runs a mechanism with each of ``numbers``, values by path as ``--set`` takes them (SI, or texts with a
    unit); outcomes come as they end.

    A member that cannot be assembled or diverges is an outcome with its reason; the others go on.
    ``workers``: threads, one a core unless given; ``lanes``: simulations side by side in each. With ``stop``
    set, members that have not ended are left out. ``device``: "cuda" steps them on an NVIDIA card, but for
    those that have a run of their own; it raises DeviceError.
    """
    stop, cases = stop or threading.Event(), Cases(base, wanted)
    alone: list[int] = []
    for one in stepped(
        cases.each(numbers), len(numbers), lanes=lanes, workers=workers, stop=stop, device=device
    ):
        if isinstance(one, NoLane) and one.reason is not None:
            yield one.number, Outcome(status=FAILED, reason=one.reason)
        elif isinstance(one, Stepped) and not one.doubtful:
            step, every = one.assembly.choice.step, one.per * one.assembly.choice.outputs_every
            yield (
                one.number,
                Outcome(
                    one.values, one.turns, one.settled, str(Status.COMPLETE), None, step, one.turns * every
                ),
            )
        else:
            alone.append(one.number)
    yield from by_themselves(cases, numbers, alone, workers, stop)


def on_device(name: str | None) -> Callable[..., Iterator[tuple[int, Outcome]]] | None:
    """What runs members on a device; None for the processor. Raises DeviceError where it cannot be used,
    before anything is done.
    """
    if name is None:
        return None
    if name != "cuda":
        raise DeviceError(
            f'device {name}: there is no such device; there is "cuda", an NVIDIA card; {WITHOUT}'
        )
    card()
    return partial(run_members, device=name)


def by_themselves(
    cases: Cases, numbers: Sequence[Numbers], which: Sequence[int], workers: int | None, stop: threading.Event
) -> Iterator[tuple[int, Outcome]]:
    """Members that have runs of their own: those that go into no lane, and those of which a lane cannot tell
    what became of them.
    """

    def one(k: int) -> tuple[int, Outcome | None]:
        return k, None if stop.is_set() else single(cases, numbers[k])

    with Workers(workers) as threads:
        for k, found in threads.results([threads.submit(one, k) for k in which]):
            if found is not None:
                yield k, found


def single(cases: Cases, numbers: Numbers) -> Outcome:
    """A member run by itself, as ``vfife run`` does without companions."""
    wanted = cases.wanted
    try:
        mechanism = cases.mechanism(numbers)
        asked = RunArguments(turns=float(wanted.turns), step=wanted.step, companions=0, settle=wanted.settle)
        result = carry_out(prepare(mechanism, asked))
    except VfifeError as error:
        return Outcome(status=FAILED, reason=sentence(error))
    record, choice = result.record, result.record.assembly.choice
    per = outputs_of_a_turn(record.assembly) or 0
    made, steps = (len(record.steps) - 1) // per if per else 0, int(record.steps[-1])
    if record.status != Status.COMPLETE:
        return Outcome({}, made, None, str(record.status), unsound(record), choice.step, steps)
    parts = list(each_turn(record, max(1, made - wanted.last + 1), made)) if made else [record]
    values = cases.measures.over(parts, None if result.reference is None else result.reference.measures)
    settling = None if wanted.settle is None else Settling(record.assembly, record.kept, wanted.settle)
    if settling is not None:
        settling.restore(record.rows)
    settled = made if settling is not None and settling.ended else None
    return Outcome(values, made, settled, str(Status.COMPLETE), None, choice.step, steps)


def unsound(record: Record) -> str:
    """Why a run is not complete, in a sentence."""
    time = record.steps[-1] * record.assembly.choice.step
    if record.status == Status.DIVERGED:
        remedy = "take a smaller step, or look for parts that are far too stiff or light"
        return f"numbers left all bounds after step {record.reached}, {time:.4g} s: {remedy}"
    return f"it ended as {record.status} after step {record.reached}, {time:.4g} s"
