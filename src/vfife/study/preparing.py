"""Numbers by path to mechanisms that can be stepped: what members have in common is worked out once.

Most numbers of a study are those of joints with play, which reach neither the ideal mechanism nor the closed start: such members are made from one
that was assembled. Where other numbers differ, the mechanism is read, closed and run without its play anew.
"""

from __future__ import annotations

import dataclasses
import tomllib
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from functools import partial
from typing import Any

import numpy as np

from ..analysis.measures import PEAKS, WantedMeasures, last_turn, over_turn
from ..assembly.assemble import assemble
from ..assembly.assembled import Assembly
from ..assembly.possible import Outlook, outlook
from ..assembly.refit import Refit
from ..errors import Fault, Path, VfifeError
from ..fields import Measure, value_of
from ..model.joints import Contact
from ..model.mechanism import Mechanism
from ..model.validate import Checks, across
from ..modelfile import dump, loads
from ..modelfile.paths import parsed, resolve
from ..results.view import Reductions
from ..simulation import ideal_of
from ..solvers.status import Status
from ..solvers.transient import run
from .batches import FEW, Batches, Through
from .columns import Column, Unfit, column, varied
from .member import Plan, Stepped, Wanted, streams

Numbers = Mapping[str, float | str]
LAWS = ("contact", "friction")
FORCES = ("gravity", "load", "material")
OF_FORCE = {("body", "mass"), ("body", "inertia"), ("spring", "stiffness"), ("spring", "damping")}
FIRST = 8  # members that are made one by one, so that lanes begin soon, where they differ in numbers of play alone
SIZES = (64, 512)  # of batches, one after the other
KEPT = 64  # mechanisms with other numbers than those of play that are remembered


@dataclass(frozen=True)
class Made:
    """A mechanism whose play may be changed: what is assembled of it, and the largest values of the ideal one."""

    refit: Refit
    plan: Plan
    reference: Mapping[str, float] | None
    again: Callable[[Mechanism, float], Assembly]
    ideal: Assembly | None = None
    through: bool = False

    @property
    def assembly(self) -> Assembly:
        """That of the model's own play."""
        return self.refit.assembly


@dataclass
class Unstepped:
    """A member that is not stepped in a lane: why it cannot be run, or nothing where it has a run of its own."""

    number: int
    reason: str | None = None
    ended: bool = True


@dataclass
class Preparing:
    """Prepares members of a mechanism one after the other."""

    base: Mechanism
    wanted: Wanted
    known: dict[tuple[tuple[str, float | str], ...], Made | str | None] = field(default_factory=dict)
    paths: dict[str, tuple[Path, Measure] | None] = field(default_factory=dict)
    forces: dict[str, bool] = field(default_factory=dict)
    through_already: set[Any] = field(default_factory=set)
    columns: dict[str, Column | None] = field(default_factory=dict)
    neighbour: Outlook = field(default_factory=Outlook)  # of the member before

    def __post_init__(self) -> None:
        settings = dataclasses.replace(self.base.settings, settle=self.wanted.settle, companions=0)
        self.base = dataclasses.replace(self.base, settings=settings)
        self.text = dump(self.base)
        self.raw = tomllib.loads(self.text)
        reduced = Reductions(self.wanted.measures)
        self.measures = WantedMeasures(self.wanted.measures, reduced.over if reduced.asked else None)

    def each(self, numbers: Sequence[Numbers]) -> Iterator[Stepped | Unstepped]:
        """The members, in their order; they are made in batches, and one by one where that is not possible."""
        batches, begin, sizes = self.batches(), self.soon(numbers), iter(SIZES)
        yield from (self._alone(k, one) for k, one in enumerate(numbers[:begin]))
        while begin < len(numbers):
            some = numbers[begin : begin + next(sizes, SIZES[-1])]
            found = batches.of(some, begin)
            yield from (found[k] if k in found else self._alone(begin + k, one) for k, one in enumerate(some))
            begin += len(some)

    def batches(self) -> Batches:
        """What makes many of them at once."""
        return Batches(self.base, self.raw, self.wanted, self.made, self.of_play, Through(self.through, self.ways, self.through_already))

    def soon(self, numbers: Sequence[Numbers]) -> int:
        """How many of the first members are quicker made one by one than in a batch."""
        rests = [self._parted(one)[1] for one in numbers[:FIRST]]
        alike = next((k for k, rest in enumerate(rests) if rest != rests[0]), len(rests))
        return alike if alike >= FEW else 0

    def _parted(self, numbers: Numbers) -> tuple[Numbers, Numbers]:
        """Numbers of play, and others."""
        play = {path: value for path, value in numbers.items() if self.of_play(path)}
        return play, {path: value for path, value in numbers.items() if path not in play}

    def _alone(self, k: int, numbers: Numbers) -> Stepped | Unstepped:
        """One of them, or why there is none."""
        try:
            return self.member(k, numbers)
        except VfifeError as error:
            return Unstepped(k, sentence(error))

    def member(self, k: int, numbers: Numbers) -> Stepped | Unstepped:
        """One of them. Raises VfifeError where it cannot be assembled."""
        play, rest = self._parted(numbers)
        try:
            made = self.made(rest)
        except VfifeError:
            if not play:
                raise
            made = self.make(numbers)  # what cannot be with the play of the base may be with its own
            play = {}
        if made is None:
            return Unstepped(k)
        assembly = self.refitted(made, play) if play else made.refit.assembly
        if assembly is None:
            made = self.make(numbers)
            if made is None:
                return Unstepped(k)
            assembly = made.refit.assembly
        return Stepped(k, assembly, made.plan, made.reference, made.again)

    def of_play(self, path: str) -> tuple[Path, Measure] | None:
        """Where a number is that only a revolute joint with clearance and its laws have, and what it holds; None of any other."""
        if path not in self.paths:
            self.paths[path] = self._of_play(path)
        return self.paths[path]

    def _of_play(self, path: str) -> tuple[Path, Measure] | None:
        try:
            at = resolve(self.raw, path)
        except Fault:
            return None
        joint = self.base.joints.get(str(at[1])) if at[0] == "joint" and len(at) in (3, 4) else None
        if joint is None or not joint.refits:
            return None
        held = measure(joint if len(at) == 3 else getattr(joint, str(at[2])) if at[2] in LAWS else None, str(at[-1]))
        return None if held is None else (at, held)

    def refitted(self, made: Made, play: Numbers) -> Assembly | None:
        """The assembly with other numbers of its play; None where a value is none that can be taken as it is."""
        given: dict[str, dict[str, dict[str, float]]] = {}
        for path, value in play.items():
            if (known := self.of_play(path)) is None:
                return None
            at, held = known
            try:
                read = held.take(parsed(value) if isinstance(value, str) else value, written=True)
            except Fault:
                return None
            given.setdefault(str(at[1]), {}).setdefault(str(at[2]) if len(at) == 4 else "", {})[str(at[-1])] = read
        joints: dict[str, Contact] = {}
        for name, parts in given.items():
            joint: Any = made.refit.assembly.mechanism.joints[name]
            try:
                laws = {kind: dataclasses.replace(getattr(joint, kind), **values) for kind, values in parts.items() if kind}
                joints[name] = dataclasses.replace(joint, **parts.get("", {}), **laws)
            except ValueError:
                return None
        return made.refit.with_joints(joints)

    def made(self, rest: Numbers) -> Made | None:
        """The mechanism with such other numbers, with the play of the base. Raises VfifeError where there can be none."""
        key = tuple(sorted(rest.items()))
        if key not in self.known:
            if len(self.known) >= KEPT:
                del self.known[next(iter(self.known))]
            try:
                self.known[key] = self.make(rest)
            except VfifeError as error:
                self.known[key] = str(error)
        found = self.known[key]
        if isinstance(found, str):
            raise VfifeError(found)
        return found

    def make(self, numbers: Numbers) -> Made | None:
        """A mechanism read, assembled and run without its play; None for one that does not go into a lane."""
        wanted = self.wanted
        mechanism = self.mechanism(numbers)
        turns = float(wanted.turns)
        if mechanism.settings.analysis == "static":
            return None
        seen = outlook(mechanism, turns, neighbour=self.neighbour)
        self.neighbour = seen
        through = seen.through
        ideal = ideal_of(mechanism, turns, motion=seen.motion) if through else None
        reference = None
        if ideal is not None:
            record = run(ideal)
            if record.status != Status.COMPLETE:
                return None
            reference = over_turn(record, last_turn(record), PEAKS)
        expected = {name.removesuffix(".force.max"): value for name, value in (reference or {}).items() if name.endswith(".force.max")}
        asked: dict[str, Any] = {"turns": turns}
        assembly = assemble(mechanism, wanted.step, expected=expected, motion=seen.motion, **asked)
        if not streams(assembly):
            return None
        refit = Refit(assembly, wanted.step, expected, **asked)
        refit.usable = refit.usable and through  # where play has to bridge what opens, it decides whether it can
        return Made(refit, Plan(assembly, wanted, self.measures), reference, partial(assemble, expected=expected, **asked), ideal, through)

    def mechanism(self, numbers: Numbers) -> Mechanism:
        """The mechanism with other numbers. Raises VfifeError, as its text does that is read with them, which is needed for some of them."""
        with suppress(Unfit):
            columns = [self.column(path) for path in numbers]
            found = varied(self.base, [(one, one.read(value)) for one, value in zip(columns, numbers.values(), strict=True)])
            if not across(Checks(found)):
                return found
        return loads(self.text, set=list(numbers.items()))

    def column(self, path: str) -> Column:
        """Where a number is. Raises Unfit where that takes a reader of models."""
        if path not in self.columns:
            try:
                self.columns[path] = column(self.base, self.raw, path)
            except Unfit:
                self.columns[path] = None
        if (found := self.columns[path]) is None:
            raise Unfit
        return found

    def through(self, numbers: Numbers, mechanism: Mechanism) -> bool:
        """Whether the ideal mechanism gets through its turns: its geometry decides, and which way it is driven. Raises VfifeError."""
        (key,) = self.ways([numbers], mechanism)
        if key not in self.through_already:
            if not outlook(mechanism, float(self.wanted.turns)).through:
                return False
            self.through_already.add(key)
        return True

    def ways(self, numbers: Sequence[Numbers], mechanism: Mechanism) -> list[tuple[Any, ...]]:
        """What decides whether ideal mechanisms get through: the geometry of each, and which way it is driven.

        They have ``numbers`` of the same paths; ``mechanism`` is that of one, or of all side by side.
        """
        moving = [driver.steady_speed for driver in mechanism.drivers.values() if driver.moves]
        shape = sorted(path for path in numbers[0] if not self.of_play(path) and not self.moves_nothing(path, len(moving)))
        towards = [np.broadcast_to(np.asarray(speed is not None and speed > 0.0), len(numbers)).tolist() for speed in moving]
        return [(*((path, one[path]) for path in shape), *(each[k] for each in towards)) for k, one in enumerate(numbers)]

    def moves_nothing(self, path: str, drivers: int) -> bool:
        """Whether a number is none of the geometry: a mass, what a spring or load has of force, the only steady speed."""
        if path not in self.forces:
            try:
                at = resolve(self.raw, path)
            except Fault:
                at = ("",)
            self.forces[path] = (
                at[0] in FORCES or (len(at) == 3 and (at[0], at[2]) in OF_FORCE) or (drivers == 1 and at[0] == "driver" and at[-1] == "speed")
            )
        return self.forces[path]


def measure(noun: Any, key: str) -> Measure | None:
    """What a field of a noun holds, where it is a quantity."""
    for one in dataclasses.fields(noun) if noun is not None else ():
        if one.name == key and one.metadata:
            held = value_of(one)
            return held if isinstance(held, Measure) and not held.series and not held.words else None
    return None


def sentence(error: VfifeError) -> str:
    """An error in one line."""
    return " ".join(line.strip() for line in str(error).splitlines() if line.strip())
