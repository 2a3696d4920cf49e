"""Cases of a study: a mechanism with other numbers each, assembled so that lanes can step it.

Most numbers of a study are those of clearance joints, which reach neither the ideal mechanism nor the solved start: such cases are reassembled from
a model that has all their other numbers. With other numbers the start is solved, the ideal mechanism run and the mechanism assembled anew. A case
is what it is alone, to the bit: what cases leave to one another only spares work (:class:`~vfife.assembly.possible.Outlook`).
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import partial
from typing import Any

from ..analysis.measures import PEAKS, WantedMeasures, last_turn, over_turn
from ..assembly.assemble import assemble
from ..assembly.assembled import Assembly
from ..assembly.possible import Outlook, outlook
from ..assembly.refit import Refit
from ..errors import VfifeError
from ..model.joints import Contact
from ..model.mechanism import Mechanism
from ..model.validate import Checks, across
from ..modelfile import dump, loads
from ..modelfile.parameter import Parameter, replaced
from ..results.view import Reductions
from ..solvers.status import Status
from ..solvers.transient import run
from ..start import ideal_of
from .member import Plan, Stepped, Wanted, streams

Numbers = Mapping[str, float | str]
LAWS = ("contact", "friction")
MOST_MODELS = 64  # that differ in other numbers than those of clearance joints


@dataclass(frozen=True)
class CaseModel:
    """A mechanism assembled for cases that differ from it in numbers of its clearance joints alone.

    ``reference``: largest values of the ideal mechanism; ``again`` assembles one of the cases with another step (s).
    """

    refit: Refit
    plan: Plan
    reference: Mapping[str, float] | None
    again: Callable[[Mechanism, float], Assembly]

    @property
    def assembly(self) -> Assembly:
        """That of the model's own clearance joints."""
        return self.refit.assembly


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
            model, clearance = self.make(numbers), {}  # what cannot be with the clearances of the base may be with its own
        if model is None:
            return NoLane(number)
        assembly = self.reassembled(model, clearance) if clearance else model.assembly
        if assembly is None:
            model = self.make(numbers)
            return NoLane(number) if model is None else Stepped(number, model.assembly, model.plan, model.reference, model.again)
        return Stepped(number, assembly, model.plan, model.reference, model.again)

    def parameter(self, path: str) -> Parameter | None:
        """A number that an object of the mechanism holds; None of any other, which takes a reader of models."""
        if path not in self.parameters:
            self.parameters[path] = None
            with suppress(VfifeError):
                found = Parameter(self.base, path)
                found = found if found.steps else Parameter(self.base, found.path)  # a joint by the bodies that it connects
                self.parameters[path] = found if found.steps else None
        return self.parameters[path]

    def of_clearance(self, path: str) -> bool:
        """Whether it is a number of a revolute joint with clearance, or of its laws, and of nothing else."""
        found = self.parameter(path)
        if found is None or found.steps is None or found.steps[0] != "joints" or found.quantity is None or found.quantity.words:
            return False
        joint = self.base.joints[str(found.steps[1])]
        return joint.refits and (len(found.steps) == 3 or (len(found.steps) == 4 and found.steps[2] in LAWS))

    def reassembled(self, model: CaseModel, clearance: Numbers) -> Assembly | None:
        """The assembly with other numbers of its clearance joints; None where a value is none that can be taken as it is."""
        changes: dict[str, dict[str, dict[str, float]]] = {}
        for path, value in clearance.items():
            parameter = self.parameter(path)
            if parameter is None or parameter.steps is None:
                return None
            _, joint, *inner = map(str, parameter.steps)
            try:
                changes.setdefault(joint, {}).setdefault(inner[0] if len(inner) == 2 else "", {})[inner[-1]] = parameter.read(value)
            except ValueError:
                return None
        joints: dict[str, Contact] = {}
        for name, parts in changes.items():
            found: Any = model.assembly.mechanism.joints[name]
            try:
                laws = {kind: dataclasses.replace(getattr(found, kind), **values) for kind, values in parts.items() if kind}
                joints[name] = dataclasses.replace(found, **parts.get("", {}), **laws)
            except ValueError:
                return None
        return model.refit.with_joints(joints)

    def model(self, numbers: Numbers) -> CaseModel | None:
        """The model with such numbers, none of them of clearance joints. Raises VfifeError where there can be none."""
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
        expected = {name.removesuffix(".force.max"): value for name, value in (reference or {}).items() if name.endswith(".force.max")}
        assembly = assemble(mechanism, self.wanted.step, expected=expected, motion=seen.motion, turns=turns)
        if not streams(assembly):
            return None
        refit = Refit(assembly, self.wanted.step, expected, turns=turns)
        refit.usable = refit.usable and seen.through  # where clearance has to bridge what opens, it decides whether it can
        return CaseModel(refit, Plan(assembly, self.wanted, self.measures), reference, partial(assemble, expected=expected, turns=turns))

    def mechanism(self, numbers: Numbers) -> Mechanism:
        """The mechanism with other numbers. Raises VfifeError, as its text does that is read with them, which is needed for some of them."""
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
