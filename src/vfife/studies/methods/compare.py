"""Comparison of laws: one mechanism under each, side by side in lanes; runs that are complete stay in its
folder until all of them are.
"""

from __future__ import annotations

import dataclasses
import hashlib
import os
import time
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...assembly.assembled import Assembly
from ...assembly.possible import outlook
from ...compiler.runtime.native import stream_lanes
from ...errors import RunFileError, VfifeError, suggestion
from ...job.cost import LANES, LIBRARIES, WORTH, Forecast, cores, run_cost, timed_step
from ...job.job import Job, job_of
from ...laws import ContactLaw, FrictionLaw, Law
from ...measures.ranges import finer
from ...model.mechanism import Mechanism
from ...results.comparison import Comparison
from ...simulation.result import Result
from ...simulation.simulate import Prepared, carry_out, concluded, halved, prepare
from ...simulation.start import reference_of
from ...solvers.arguments import Arguments, Loop, RunArguments
from ...solvers.record import Record
from ...solvers.repeating import Settling
from ...solvers.status import Progress, Status
from ...solvers.streaming import Lane, stepped
from ...solvers.transient import choose_loop
from ...store.schemas import is_run_file

Array = NDArray[np.float64]
ROOM = 720  # outputs between two looks


class Recorded(Lane):
    """A run in a lane. It is ``doubtful`` where numbers left all bounds: then its own run tells where."""

    def __init__(self, number: int, prepared: Prepared, assembly: Assembly) -> None:
        super().__init__(number, assembly, loop=prepared.loop)
        self.prepared, settle = prepared, assembly.mechanism.settings.settle
        self.settling = None if settle is None else Settling(assembly, self.handed, settle)
        self.result: Result | None = None

    @property
    def outputs(self) -> int:
        """Outputs up to the next look; a turn is looked at when it ends."""
        room = self.settling.room if self.settling is not None else 0
        return min(ROOM, room or ROOM, self.assembly.choice.outputs - self.done)

    def start(self, state: Array) -> None:
        """The first output."""
        self.began = time.perf_counter()
        super().start(state)

    def take(self, rows: Array, broken: int, state: Array) -> None:
        """Some outputs."""
        super().take(rows, broken, state)
        if self.settling is not None:
            self.settling.take(rows)
        self.final = state + 0.0

    @property
    def ended(self) -> bool:
        """Whether no output is left to make."""
        return super().ended or (self.settling is not None and self.settling.ended)

    def end(self) -> Recorded | None:
        """Its result; where an automatic step was too large, it is made again with half of that."""
        if self.doubtful:
            self.parts.clear()
            return None
        rows, loop = np.concatenate(self.parts), choose_loop(self.assembly, self.prepared.loop)
        steps, wall = np.arange(len(rows), dtype=np.int64) * self.every, time.perf_counter() - self.began
        record = Record(
            self.assembly, steps, rows, self.handed, wall, loop, final=self.final, reached=int(steps[-1])
        )
        if self.prepared.searches and (tried := finer(record)) is not None:
            return Recorded(self.number, self.prepared, halved(self.prepared, self.assembly, tried))
        self.result = concluded(record, self.prepared.reference)
        return None


def fits(one: Prepared) -> bool:
    """Whether a run may be made in a lane: not one with companions, which have the lanes beside it, nor one
    that is made again at half its step.
    """
    return (
        not (one.static or one.companions or one.refined)
        and choose_loop(one.assembly, one.loop) == "generated"
    )


def carried_out(
    ready: Sequence[Prepared], told: Callable[[Progress], None] | None = None
) -> Iterator[tuple[int, Result]]:
    """Results by the place of what was prepared, as they end: on all cores in lanes where that is possible,
    then one after the other. ``told`` hears how far all of them are.
    """
    alone = [k for k, one in enumerate(ready) if not fits(one)]
    beside = [Recorded(k, one, one.assembly) for k, one in enumerate(ready) if k not in alone]
    alike, began = Counter(one.assembly.topology for one in beside), time.perf_counter()

    def tick() -> None:
        if told is not None:
            done, steps = (
                sum(one.done * one.every for one in beside),
                sum(one.assembly.choice.steps for one in beside),
            )
            told(Progress(done, steps, time.perf_counter() - began))

    for one in stepped(beside, len(beside), alike=max(alike.values()), tick=tick) if len(beside) > 1 else ():
        if one.result is not None:
            yield one.number, one.result
            tick()
        else:
            alone.append(one.number)
    for k in sorted([*alone, *(one.number for one in beside if len(beside) == 1)]):
        yield k, carry_out(ready[k], progress=told)


NAME = "part-{}.sqlite"


class Parts:
    """The complete runs in a folder, each under a name that is made of its model, of what was asked, and of
    the text of the step.
    """

    def __init__(self, folder: str | Path | None) -> None:
        self.folder = None if folder is None else Path(folder)

    def path(self, folder: Path, one: Prepared) -> Path:
        """Where a run is kept."""
        meta = one.kept
        told = [meta["model"], sorted(meta["asked"].items()), meta["versions"], one.companions]
        return folder / NAME.format(hashlib.blake2b(repr(told).encode(), digest_size=10).hexdigest())

    def path_of(self, one: Prepared) -> Path:
        """Where a run would be kept; a place that is none without a folder."""
        return self.path(self.folder or Path(os.devnull), one)

    def found(self, one: Prepared) -> Result | None:
        """A run that was made before; None where there is none, or it is damaged."""
        if not (path := self.path_of(one)).is_file():
            return None
        with suppress(RunFileError):
            result = Result.load(path)
            if not result.record.lost and result.record.status == Status.COMPLETE:
                result.reference = one.reference
                return result
        return None

    def keep(self, one: Prepared, result: Result) -> None:
        """Keeps a run. Raises StorageError where it cannot be written."""
        if self.folder is not None:
            Result(result.record).save(self.path(self.folder, one))

    def remove(self) -> None:
        """Takes away what was kept, for all of it is told."""
        if self.folder is not None:
            for path in self.folder.glob(NAME.format("*")):
                if is_run_file(path):
                    path.unlink()


Choice = str | Law | type[Law]
PER_JOINT = (
    "force.max",
    "penetration.max",
    "impacts",
    "grazing",
    "deep_landings",
    "share.continuous_contact",
)


def compare(
    mechanism: Mechanism,
    contact: Sequence[Choice] = (),
    friction: Sequence[Choice] = (),
    *,
    joints: Iterable[str] | None = None,
    progress: Callable[[str], Callable[[Progress], None] | None] | Job | None = None,
    turns: float | None = None,
    duration: float | str | None = None,
    step: float | str | None = None,
    outputs: int | None = None,
    loop: Loop = "auto",
    force_step: bool = False,
    companions: int | str = 0,
    folder: str | Path | None = None,
    confirm: bool = False,
) -> Comparison:
    """Runs a mechanism under every pair of the given laws, and under its own where a kind is not given.

    A law is a name, a class or an instance. Of a name or a class the parameters are those of the law it takes
    the place of, where both have a field of the same name and unit (restitution, coefficient ...), else its
    defaults. ``joints``: those whose laws are changed, all with clearance if left out. Runs are made side by
    side, on all cores. ``progress`` receives a word on all of them first, then the name of each when it has
    ended, and may return a call for how far all are; the others are arguments of :func:`~vfife.simulate`.
    Without companions, which are none unless asked for, an automatic step is the finer one that nobody has to
    look at. Ctrl-C ends with the runs that are complete. In a ``folder`` (there already) they are kept until
    all are, so that the same comparison, broken off or killed, goes on after them. ``confirm``: compare even
    where it takes more than an hour, or half of the memory. Raises VfifeError with every law that cannot be
    used, before the first run, and StorageError where a run cannot be kept.
    """
    given = Arguments("compare")
    given.mechanism(mechanism)
    asked = given.run(
        turns=turns,
        duration=duration,
        step=step,
        outputs=outputs,
        loop=loop,
        force_step=force_step,
        companions=companions,
    )
    given.callable("progress", progress)
    given.kind("folder", folder, (str, Path, type(None)), "a folder")
    given.check()
    names = chosen_joints(mechanism, joints)
    variants = list(varied(mechanism, contact, friction, names))
    reference = (
        reference_of(mechanism, asked.turns, asked.duration)
        if outlook(mechanism, asked.turns, asked.duration).through
        else None
    )
    ready = prepared(variants, reference, asked)
    found = Comparison(mechanism.name, names, reference=reference, planned=len(variants))
    results: dict[int, Result] = {}
    lines: list[Callable[[Progress], None] | None] = [None]
    name = progress if callable(progress) and not isinstance(progress, Job) else lambda text: None
    job = job_of(
        "compare", folder, confirm, progress, lambda one: None if lines[-1] is None else lines[-1](one)
    )
    parts = Parts(folder)
    job.begin(forecast([one for _, one in ready if not parts.path_of(one).is_file()], len(ready)))
    with job, suppress(KeyboardInterrupt):
        lines.append(name(f"{len(ready)} runs, side by side" if len(ready) > 1 else ready[0][0]))
        for k, result in made(ready, parts, job):
            lines.append(name(f"{len(results) + 1} of {len(ready)}: {ready[k][0]}"))
            if result.record.status == Status.INTERRUPTED:
                break
            results[k] = result
    for _, result in sorted(results.items()):
        found.results.append(result)
        found.rows.append(numbers_of(result, names))
    return found


def forecast(left: Sequence[Prepared], planned: int) -> Forecast:
    """The forecast of runs that are left of those planned: side by side in lanes, or one after another."""
    costs = [run_cost(one.assembly, companions=one.companions, refined=one.refined) for one in left]
    lanes = stream_lanes(1) if left and fits(left[0]) else 1
    faster = cores() * min(lanes, len(left)) / LANES[lanes] if lanes > 1 and len(left) > 1 else 1.0
    seconds = sum(one.seconds for one in costs) / faster
    if seconds > WORTH and costs[0].loop == "generated":
        seconds *= 1e9 * timed_step(left[0].assembly) / costs[0].ns_per_step
    steps = sum(one.assembly.choice.steps for one in left) / max(len(left), 1)
    memory, disk = sum(one.memory - LIBRARIES for one in costs) + LIBRARIES, sum(one.disk for one in costs)
    return Forecast(
        "run",
        len(left),
        steps,
        seconds,
        memory,
        disk,
        planned - len(left),
        cores(),
        lanes,
        less="compare fewer laws, or over fewer turns",
    )


def made(
    ready: Sequence[tuple[str, Prepared]], parts: Parts, told: Callable[[Progress], None]
) -> Iterator[tuple[int, Result]]:
    """Results by their place, those first that were made before; each is kept until the last one is there."""
    kept = {k: result for k, (_, one) in enumerate(ready) if (result := parts.found(one)) is not None}
    yield from kept.items()
    left = [k for k in range(len(ready)) if k not in kept]
    for count, (at, result) in enumerate(carried_out([ready[k][1] for k in left], told), len(kept) + 1):
        if result.record.status == Status.COMPLETE and count < len(ready):
            parts.keep(ready[left[at]][1], result)
        yield left[at], result


def chosen_joints(mechanism: Mechanism, joints: Iterable[str] | None) -> tuple[str, ...]:
    """Joints whose laws are changed. Raises VfifeError for one without clearance."""
    known = mechanism.clearances
    if not known:
        raise VfifeError(
            "no joint of this mechanism has clearance, so there is no law to compare; give one kind ="
            ' "clearance"'
        )
    names = tuple(dict.fromkeys(joints)) if joints is not None else tuple(known)
    for name in names:
        if name in mechanism.joints and name not in known:
            raise VfifeError(
                f"joint {name} is ideal and has no law; joints with clearance are {', '.join(known)}"
            )
        if name not in known:
            raise VfifeError(
                f"there is no joint {name!r}. {suggestion(name, known, 'Name one with clearance')}"
            )
    return names


def varied(
    mechanism: Mechanism, contact: Sequence[Choice], friction: Sequence[Choice], joints: Sequence[str]
) -> Iterator[tuple[str, Mechanism]]:
    """Name and mechanism of every pair of laws; None in place of a law keeps the joint's own."""
    if not contact and not friction:
        raise VfifeError("name contact laws, friction laws or both; `vfife laws` lists them")
    contacts: list[Law | type[Law] | None] = [law_of(one, ContactLaw, "contact") for one in contact] or [None]
    frictions: list[Law | type[Law] | None] = [law_of(one, FrictionLaw, "friction") for one in friction] or [
        None
    ]
    for normal in contacts:
        for tangential in frictions:
            changed = dict(mechanism.joints)
            for name in joints:
                joint = mechanism.clearances[name]
                laws = {
                    "contact": carried(joint.contact, normal),
                    "friction": carried(joint.friction, tangential),
                }
                changed[name] = dataclasses.replace(joint, **laws)  # type: ignore[arg-type]
            label = " with ".join(law.name for law in (normal, tangential) if law is not None)
            yield label, dataclasses.replace(mechanism, joints=changed)


def law_of(one: Choice, base: type[Law], kind: str) -> Law | type[Law]:
    """The law that is meant. Raises VfifeError for a name that no law has, and for a law of the other kind."""
    if isinstance(one, str):
        if one not in base.registry:
            remedy = suggestion(one, base.registry, f"name a {kind} law")
            raise VfifeError(f"no {kind} law is called {one!r}. {remedy[0].upper()}{remedy[1:]}")
        return base.registry[one]
    kind_of_it: Any = one if isinstance(one, type) else type(one)
    if not issubclass(kind_of_it, base):
        raise VfifeError(f"{one!r} is no {kind} law")
    return one


def carried(old: Law, new: Law | type[Law] | None) -> Law:
    """The new law with what the old one and it both have: fields of the same name and unit."""
    if new is None:
        return old
    if isinstance(new, Law):
        return new
    had = {one.name: one.metadata.get("unit") for one in dataclasses.fields(old)}
    same = {
        one.name
        for one in dataclasses.fields(new)
        if one.name in had and had[one.name] == one.metadata.get("unit")
    }
    values = {name: getattr(old, name) for name in same if getattr(old, name) is not None}
    try:
        return new(**values)
    except (TypeError, ValueError) as error:
        raise VfifeError(
            f"the law {new.name!r} cannot take the place of {old.name!r}: {error}; give it in Python as an"
            " instance"
        ) from None


def prepared(
    variants: Sequence[tuple[str, Mechanism]], reference: Result | None, asked: RunArguments
) -> list[tuple[str, Prepared]]:
    """Every variant, ready to run. Raises VfifeError with all that cannot be run."""
    faults, ready = [], []
    for label, variant in variants:
        try:
            ready.append((label, prepare(variant, asked, reference if reference is not None else False)))
        except ValueError as error:
            faults.append(f"{label}: {error}")
    if faults:
        raise VfifeError("\n".join(dict.fromkeys(faults)))
    return ready


def numbers_of(result: Result, joints: Sequence[str]) -> dict[str, Any]:
    """The row of a run."""
    measures, mechanism = result.measures, result.record.assembly.mechanism
    noun = mechanism.clearances[joints[0]]
    each: dict[str, dict[str, Any]] = {
        name: (
            {key: measures[f"{name}.{key}"] for key in PER_JOINT if f"{name}.{key}" in measures}
            | {"lip_force": measures.get(f"{name}.force.lip")}
        )
        for name in joints
    }
    ledger = result.ledger
    lip = [value for key, value in measures.items() if key.endswith(".angular_acceleration.lip")]
    lips = [one["lip_force"] for one in each.values() if one["lip_force"] is not None]
    return {
        "contact": noun.contact.name,
        "friction": noun.friction.name,
        "status": result.record.status,
        "part": measures.part,
        "force": max(one["force.max"] for one in each.values()),
        "lip_force": max(lips, default=None),
        "lip_acceleration": max(lip, default=None),
        "penetration": max(one["penetration.max"] for one in each.values()),
        "impacts": int(sum(one["impacts"] for one in each.values())),
        "contact_share": sum(one["share.continuous_contact"] for one in each.values()) / len(each),
        "energy_lost": float(ledger.terms["contact_loss"][-1] + ledger.terms["friction_loss"][-1]),
        "energy_error": ledger.error,
        "wall_s": result.record.wall,
        "joints": each,
    }
