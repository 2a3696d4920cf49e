"""Comparison of laws: one mechanism under each of them, in lanes; complete runs are saved in its folder until
all are complete.
"""

from __future__ import annotations

import dataclasses
import hashlib
import itertools
import os
import time
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, Unpack

import numpy as np
from numpy.typing import NDArray

from ...assembly.assembled import Assembly
from ...assembly.possible import outlook
from ...compiler.runtime.native import stream_lanes
from ...errors import RunFileError, VfifeError, suggestion
from ...files import DataTable, named_rows, share_done
from ...job import cost
from ...job.job import Job, job_of
from ...laws import ContactLaw, FrictionLaw, Law
from ...measures.trust import finer
from ...model.mechanism import Mechanism
from ...options import Run, Watch, with_options
from ...results.run_data import RunData
from ...schema import required
from ...simulation.result import Result
from ...simulation.simulate import Prepared, concluded, halved, prepare
from ...simulation.simulate import run_prepared as run_prepared
from ...simulation.start import reference_of
from ...solvers.arguments import Arguments, RunArguments
from ...solvers.repeating import Settling
from ...solvers.status import Progress, Status
from ...solvers.streaming import Lane, stepped
from ...solvers.transient import choose_loop
from ...store.schemas import is_run_file
from .comparison_rows import row_of

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@dataclass
class Comparison(DataTable):
    """Results of a mechanism under several laws. ``rows`` has one map for each run, ``results`` the runs,
    both in the order of the laws; ``planned`` is the number of runs of the whole comparison.

    A row has ``contact`` and ``friction`` (names), ``status``, ``force`` (N, largest of the joints with
    changed laws), ``lip_force`` and ``lip_acceleration`` (%, largest; None without a reference),
    ``penetration`` (m), ``impacts``, ``contact_share`` (of the time, mean over joints), ``energy_lost`` (J,
    in damping and friction of the joints), ``energy_error``, ``wall_s``, ``part`` (of the run, over which
    extremes are taken), and ``joints``: the numbers of each joint. A number whose error was estimated by
    companions has its range in ``<name>.low`` and ``<name>.high``; other numbers have neither.
    """

    mechanism: str
    joints: tuple[str, ...]
    rows: list[dict[str, Any]] = field(default_factory=list)
    results: list[RunData] = field(default_factory=list)
    reference: RunData | None = None
    planned: int = 0

    def __repr__(self) -> str:
        return (
            f"<Comparison of {self.progress or f'{len(self.rows)} runs'} of {self.mechanism!r}; see .rows,"
            " .results, .to_dataframe(), .plot()>"
        )

    @property
    def progress(self) -> str:
        """How much is computed, as in "2 of 9 runs"; empty for a complete comparison."""
        return share_done(len(self.rows), self.planned, "runs")

    if TYPE_CHECKING:  # attached by vfife.methods

        def plot(self) -> dict[str, Figure]:
            """See :func:`vfife.methods.plot_comparison`."""

    def flat(self) -> list[dict[str, Any]]:
        """Return the rows by run and joint, for tables."""
        of_run = ("status", "part", "lip_acceleration", "energy_lost", "energy_error", "wall_s")
        return [
            {
                "contact": row["contact"],
                "friction": row["friction"],
                "joint": name,
                **numbers,
                **{key: row[key] for key in row if key.removesuffix(".low").removesuffix(".high") in of_run},
            }
            for row in self.rows
            for name, numbers in row["joints"].items()
        ]

    def table(self) -> Iterator[Sequence[Any]]:
        """Yield heads, then :meth:`flat` as rows."""
        return named_rows(self.flat())


Array = NDArray[np.float64]
ROOM = 720  # outputs that a lane hands over at once


class RecordingLane(Lane):
    """A run in a lane. Where its numbers left all bounds it has no ``result``: a run of its own then reports
    where.
    """

    def __init__(self, number: int, prepared: Prepared, assembly: Assembly) -> None:
        super().__init__(number, assembly, loop=prepared.loop)
        self.prepared, settle = prepared, assembly.mechanism.settings.settle
        self.settling = None if settle is None else Settling(assembly, self.handed, settle)
        self.result: Result | None = None

    @property
    def outputs(self) -> int:
        """Outputs up to the next call of :meth:`take`; a turn that may repeat the one before it ends with
        one.
        """
        room = self.settling.remaining if self.settling is not None else 0
        return min(ROOM, room or ROOM, self.assembly.choice.outputs - self.done)

    def start(self, state: Array) -> None:
        """Take the first output."""
        self.began = time.perf_counter()
        super().start(state)

    def take(self, rows: Array, broken: int, state: Array) -> None:
        """Take some outputs."""
        super().take(rows, broken, state)
        if self.settling is not None:
            self.settling.take(rows)
        self.final = state + 0.0

    @property
    def finished(self) -> bool:
        """Whether no output is left to make."""
        return super().finished or (self.settling is not None and self.settling.settled)

    def end(self) -> RecordingLane | None:
        """Make the result; where an automatic step was too large, return the run with half of it."""
        if self.doubtful:
            self.parts.clear()
            return None
        record = dataclasses.replace(
            self.record,
            wall=time.perf_counter() - self.began,
            loop=choose_loop(self.assembly, self.prepared.loop),
            final=self.final,
            reached=self.done * self.every,
        )
        if self.prepared.searches and (tried := finer(record)) is not None:
            return RecordingLane(self.number, self.prepared, halved(self.prepared, self.assembly, tried))
        self.result = concluded(record, self.prepared.reference)
        return None


def fits_lane(prepared: Prepared) -> bool:
    """Return whether a run can be made in a lane: not with companions, which need the other lanes, and not if
    it is refined.
    """
    is_single = prepared.static or prepared.companions or prepared.refined
    return not is_single and choose_loop(prepared.assembly, prepared.loop) == "generated"


def run_all(
    runs: Sequence[Prepared], progress: Callable[[Progress], None] | None = None
) -> Iterator[tuple[int, Result]]:
    """Yield results with the index of their run as they end: in lanes on all cores where that is possible,
    then one after another.
    """
    lanes = [
        RecordingLane(k, prepared, prepared.assembly)
        for k, prepared in enumerate(runs)
        if fits_lane(prepared)
    ]
    lanes = lanes if len(lanes) > 1 else []
    left, began = set(range(len(runs))), time.perf_counter()

    def tick() -> None:
        if progress is not None:
            done = sum(lane.done * lane.every for lane in lanes)
            steps = sum(lane.assembly.choice.steps for lane in lanes)
            progress(Progress(done, steps, time.perf_counter() - began))

    largest_kind = max(Counter(lane.assembly.topology for lane in lanes).values(), default=0)
    for lane in stepped(lanes, len(lanes), alike=largest_kind, tick=tick) if lanes else ():
        if lane.result is not None:
            left.remove(lane.number)
            yield lane.number, lane.result
            tick()
    for k in sorted(left):
        yield k, run_prepared(runs[k], progress=progress)


NAME = "part-{}.sqlite"


@dataclass(frozen=True)
class Parts:
    """The complete runs of an unfinished comparison in a ``folder``, or nowhere.

    Their names are hashes of the model, the run arguments, the versions and the text of the step.
    """

    folder: Path | None

    def path(self, prepared: Prepared) -> Path:
        """Return the file of a run, which exists once it is complete."""
        meta = prepared.run_meta
        key = [meta["model"], sorted(meta["asked"].items()), meta["versions"], prepared.companions]
        name = NAME.format(hashlib.blake2b(repr(key).encode(), digest_size=10).hexdigest())
        return (self.folder or Path(os.devnull)) / name

    def load(self, prepared: Prepared) -> Result | None:
        """Return a run that was made before; None where there is none, or it is damaged."""
        if not (path := self.path(prepared)).is_file():
            return None
        with suppress(RunFileError):
            result = Result.load(path)
            if not result.record.damaged_parts and result.record.status == Status.COMPLETE:
                result.reference = prepared.reference
                return result
        return None

    def save(self, prepared: Prepared, result: Result) -> None:
        """Save a complete run. Raises StorageError where it cannot be written."""
        if self.folder is not None:
            Result(result.record).save(self.path(prepared))

    def remove(self) -> None:
        """Remove all of them, as the comparison is complete."""
        if self.folder is not None:
            for path in self.folder.glob(NAME.format("*")):
                if is_run_file(path):
                    path.unlink()


Choice = str | Law | type[Law]
LawList = list[Law | type[Law] | None]


class CompareOptions(Run, Watch, total=False):
    """Keywords of :func:`compare`."""

    joints: Iterable[str] | None  # whose laws are changed; all with clearance unless given
    outputs: int | None  # per turn
    folder: str | Path | None  # keeps the runs until all are complete


@with_options(CompareOptions, loop="auto", force_step=False, companions=0, confirm=False)
def compare(
    mechanism: Mechanism,
    contact: Sequence[Choice] | Choice = (),
    friction: Sequence[Choice] | Choice = (),
    **options: Unpack[CompareOptions],
) -> Comparison:
    """Run a mechanism with every pair of a contact and a friction law, in lanes on all cores.

    mechanism: the mechanism
    contact: laws of normal contact: names, classes or instances. A name or a class takes over the parameters
    of the law that it replaces, where both have a field of the same name and unit (restitution, coefficient
    ...)
    friction: laws of friction; where no law of a kind is named, each joint keeps its own
    joints: names of the joints whose laws are replaced, by default all with clearance
    companions: 0 by default, so that the finer automatic step is taken
    outputs: number per turn
    turns, duration, step, settle, loop, force_step: as of :func:`~vfife.simulate`
    folder: an existing folder in which complete runs are saved until all are complete; the same comparison
    continues there after an interrupt or a kill
    progress: called with a text on all runs first, then with the name of each as it ends; it may return a
    function that is called with the progress of all
    confirm: True compares even if it takes more than an hour, or half of the memory

    Returns a table of the measures under each pair. Ctrl-C ends it with the runs that are complete. Raises
    VfifeError with every law that cannot be used, before the first run, and StorageError if a run cannot be
    saved.
    """
    arguments, folder = Arguments("compare"), options["folder"]
    progress: Any = options["progress"]
    arguments.mechanism(mechanism)
    run = arguments.run(**{name: options.get(name) for name in (*Run.__annotations__, "outputs")})
    arguments.callable("progress", progress)
    arguments.kind("folder", folder, (str, Path, type(None)), "a folder")
    arguments.check()
    names = chosen_joints(mechanism, options["joints"])
    variants = list(law_variants(mechanism, listed(contact), listed(friction), names))
    goes_through = outlook(mechanism, run.turns, run.duration).passes
    reference = reference_of(mechanism, run.turns, run.duration) if goes_through else None
    labels, runs = [label for label, _ in variants], prepare_all(variants, reference, run)
    parts = Parts(None if folder is None else Path(folder))
    lines: list[Callable[[Progress], None] | None] = [None]  # that of the run that ended last is called
    name = progress if callable(progress) and not isinstance(progress, Job) else lambda text: None

    def show(report: Progress) -> None:
        if lines[-1] is not None:
            lines[-1](report)

    job = job_of("compare", folder, options["confirm"], progress, show)
    job.begin(forecast([prepared for prepared in runs if not parts.path(prepared).is_file()], len(runs)))
    results: dict[int, Result] = {}
    with job, suppress(KeyboardInterrupt):
        lines.append(name(f"{len(runs)} runs, side by side" if len(runs) > 1 else labels[0]))
        for k, result in remaining_results(runs, parts, job):
            lines.append(name(f"{len(results) + 1} of {len(runs)}: {labels[k]}"))
            if result.record.status == Status.INTERRUPTED:
                break
            results[k] = result
    if len(results) < len(runs):
        job.interrupted()
    complete = [results[k] for k in sorted(results)]
    rows = [row_of(result, names) for result in complete]
    return Comparison(mechanism.name, names, rows, list(complete), reference, planned=len(runs))


RECORDED = 1.4  # time of a step in lanes that are recorded, over that of lanes that are not


def forecast(left: Sequence[Prepared], planned: int) -> cost.Forecast:
    """Forecast the runs that are left of those planned: in lanes, or one after another. With companions an
    automatic step may be halved twice, that of a smooth run that is repeated three times.
    """
    costs = [
        cost.run_cost(prepared.assembly, companions=prepared.companions, refined=prepared.refined)
        for prepared in left
    ]
    lanes = stream_lanes(1) if left and fits_lane(left[0]) else 1
    threads, speedup = 1, 1.0
    if lanes > 1 and len(left) > 1:
        threads = cost.cores()
        speedup = threads * min(lanes, len(left)) / (RECORDED * cost.LANES[lanes])
    recording = sum(cost.RECORD_SECONDS * price.bytes for price in costs)
    seconds = (sum(price.seconds for price in costs) - recording) / speedup
    if seconds > cost.WORTH and costs[0].loop == "generated":
        seconds *= 1e9 * cost.timed_step(left[0].assembly) / costs[0].ns_per_step
    besides = recording + sum(price.measuring for price in costs)
    searched = [prepared for prepared in left if prepared.assembly.choice.automatic]
    searched = [prepared for prepared in searched if prepared.companions or prepared.refined]
    tries = cost.SMOOTH_TRIES if any(prepared.refined for prepared in searched) else cost.MOST_TRIES
    ends = seconds + besides, (tries if searched else 1.0) * seconds + besides
    steps = sum(prepared.assembly.choice.steps for prepared in left) / max(len(left), 1)
    memory, disk = (
        sum(price.memory - cost.LIBRARIES for price in costs) + cost.LIBRARIES,
        sum(price.disk for price in costs),
    )
    amounts = len(left), steps, ends[0], memory, disk, planned - len(left), threads, lanes
    growth = max((price.disk_growth for price in costs), default=1.0)
    remedy = "compare fewer laws, or over fewer turns"
    first = cost.Forecast("run", *amounts, remedy=remedy, disk_growth=growth)
    return first.with_ends(*ends) if searched else first


def remaining_results(
    runs: Sequence[Prepared], parts: Parts, progress: Callable[[Progress], None]
) -> Iterator[tuple[int, Result]]:
    """Yield results with the index of their run, those first that were made before; each is saved until the
    last one has ended.
    """
    saved = {k: result for k, prepared in enumerate(runs) if (result := parts.load(prepared)) is not None}
    yield from saved.items()
    left = [k for k in range(len(runs)) if k not in saved]
    for count, (index, result) in enumerate(run_all([runs[k] for k in left], progress), len(saved) + 1):
        if result.record.status == Status.COMPLETE and count < len(runs):
            parts.save(runs[left[index]], result)
        yield left[index], result


def chosen_joints(mechanism: Mechanism, joints: Iterable[str] | None) -> tuple[str, ...]:
    """Return the joints whose laws are replaced. Raises VfifeError for one without clearance."""
    clearances = mechanism.clearances
    if not clearances:
        kinds = ", ".join(f"{name} ({joint.kind})" for name, joint in mechanism.contacts.items())
        message = "no pin of this mechanism has clearance, so there is no law to compare"
        if kinds:
            message = f"only laws of pins with clearance are compared, and the contacts here are {kinds}"
        raise VfifeError(f'{message}; give a joint kind = "clearance"')
    names = tuple(dict.fromkeys(clearances if joints is None else joints))
    for name in names:
        if name in mechanism.joints and name not in clearances:
            remedy = f"joints with clearance are {', '.join(clearances)}"
            raise VfifeError(f"joint {name} is ideal and has no law; {remedy}")
        if name not in clearances:
            remedy = suggestion(name, clearances, "Name one with clearance")
            raise VfifeError(f"there is no joint {name!r}. {remedy}")
    return names


def listed(laws: Sequence[Choice] | Choice) -> Sequence[Choice]:
    """Return laws as a sequence; a single one may stand for itself."""
    return [laws] if isinstance(laws, str | Law | type) else laws


def law_variants(
    mechanism: Mechanism, contact: Sequence[Choice], friction: Sequence[Choice], joints: Sequence[str]
) -> Iterator[tuple[str, Mechanism]]:
    """Yield label and mechanism of every pair of laws; where no law of a kind is named, each joint keeps its
    own.
    """
    if not contact and not friction:
        raise VfifeError("name contact laws, friction laws or both; `vfife laws` lists them")
    contacts: LawList = [law_of(choice, ContactLaw, "contact") for choice in contact]
    frictions: LawList = [law_of(choice, FrictionLaw, "friction") for choice in friction]
    for normal, tangential in itertools.product(contacts or [None], frictions or [None]):
        changed = dict(mechanism.joints)
        for name in joints:
            joint = mechanism.clearances[name]
            laws = {
                "contact": replaced_law(joint.contact, normal),
                "friction": replaced_law(joint.friction, tangential),
            }
            changed[name] = dataclasses.replace(joint, **laws)  # type: ignore[arg-type]
        label = " with ".join(law.name for law in (normal, tangential) if law is not None)
        yield label, dataclasses.replace(mechanism, joints=changed)


def law_of(choice: Choice, base: type[Law], kind: str) -> Law | type[Law]:
    """Return a law or its class. Raises VfifeError for a name that no law has, and for a law of the other
    kind.
    """
    if isinstance(choice, str):
        if choice not in base.registry:
            remedy = suggestion(choice, base.registry, f"name a {kind} law")
            raise VfifeError(f"no {kind} law is called {choice!r}. {remedy[0].upper()}{remedy[1:]}")
        return base.registry[choice]
    law_class: Any = choice if isinstance(choice, type) else type(choice)
    if not issubclass(law_class, base):
        raise VfifeError(f"{choice!r} is no {kind} law")
    return choice


def required_keys(law: type[Law]) -> list[str]:
    """Return the names of the parameters of a law that have no defaults."""
    return [parameter.name for parameter in dataclasses.fields(law) if required(parameter)]


def replaced_law(old: Law, new: Law | type[Law] | None) -> Law:
    """Return the new law with the fields of the old one that have the same name and unit; an instance as it
    is, the old one for None.
    """
    if new is None or isinstance(new, Law):
        return old if new is None else new
    old_units, units = (
        {parameter.name: parameter.metadata.get("unit") for parameter in dataclasses.fields(law)}
        for law in (old, new)
    )
    shared = {
        name: getattr(old, name) for name in units if name in old_units and units[name] == old_units[name]
    }
    values = {name: value for name, value in shared.items() if value is not None}
    if missing := [name for name in required_keys(new) if name not in values]:
        keys = " and ".join(f"{name} (in {units[name]})" for name in missing)
        joint = f"joint.NAME.{'contact' if issubclass(new, ContactLaw) else 'friction'}"
        options = " ".join(f"--set {joint}.{name}=VALUE" for name in missing)
        raise VfifeError(
            f"the law {new.name!r} has no default for {keys}, and {old.name!r} has none to take over. Run it"
            f" by itself: vfife run MODEL --set {joint}.law={new.name} {options}. In Python, give compare()"
            f" an instance: {new.__name__}({', '.join(f'{name}=...' for name in missing)})"
        )
    try:
        return new(**values)
    except (TypeError, ValueError) as error:
        message = f"the law {new.name!r} cannot take the place of {old.name!r}: {error}"
        raise VfifeError(f"{message}; give it in Python as an instance") from None


def prepare_all(
    variants: Sequence[tuple[str, Mechanism]], reference: Result | None, arguments: RunArguments
) -> list[Prepared]:
    """Prepare the run of every variant. Raises VfifeError with all that cannot be run."""
    faults, runs = [], []
    for label, variant in variants:
        try:
            runs.append(prepare(variant, arguments, reference if reference is not None else False))
        except ValueError as error:
            faults.append(f"{label}: {error}")
    if faults:
        raise VfifeError("\n".join(dict.fromkeys(faults)))
    return runs
