"""``vfife.design``: one answer from sensitivities, allocated fits and wear of a mechanism."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, Unpack

from ..compiler.runtime.native import CONTACT_LANES
from ..errors import Fault, ModelError, VfifeError, suggestion
from ..job.cost import LANES, LONG, Forecast, cores, run_cost
from ..job.job import Interrupted, Job, PartJob, job_of
from ..job.progress import span
from ..measures.catalogue import counts_of, differentiable, is_coordinate
from ..model.functions import turns_of_cycles
from ..model.mechanism import Mechanism
from ..options import Watch, with_options
from ..results.derivatives import Effect, Sensitivity
from ..simulation.simulate import Prepared, prepare
from ..solvers.arguments import Arguments
from ..solvers.status import Progress
from ..studies.engine.cases import run_cases
from ..studies.forecast import allotment_remark
from ..studies.methods.allocation import (
    ALL_CHOICES,
    DESCENT,
    SAME_FITS,
    expected_machines,
    machine_counts,
    most_machines,
    read_allotment,
)
from ..studies.methods.derivatives import forecast as sensitivity_forecast
from ..studies.methods.derivatives import sensitivity
from ..studies.spec.iso286 import LARGEST_SIZE, LEAST_SIZE
from ..studies.spec.plan import CaseSpec
from ..studies.study_work import Allocation, allocate, tables_of
from ..tribology.simulate_wear import wear, wear_forecast
from ..tribology.wear_state import Worn, surfaces_of, with_wear
from .answer import (
    LIFE,
    SENSITIVE,
    Design,
    clearances,
    default_limit,
    effects_agree,
    is_grown,
    missing_limit,
    nearest_fit,
    path_of,
    refuse_unfit,
    refuse_unlikely,
    run_turns,
    scale_of,
)
from .sample import (
    CLEARANCE_SPREAD,
    EVEN_MACHINES,
    EVEN_SEED,
    FIT_MACHINES,
    MACHINES,
    NEAR_MACHINES,
    PARTS,
    ROUNDS,
    MachineSample,
    clearances_around,
    corner_clearances,
    corner_count,
    growth_effects,
    ideal_value,
    joined,
    law_caution,
    limits_of,
    near_machines,
    run_machines,
    sampled_clearances,
    timed_machine,
    total_forecast,
    with_growths,
)

FORCE = "{}.force.max"
SHARE = 0.95  # of all machines; 59 machines without a failure show it with 95 % confidence
BATCH = 32  # machines simulated at once: fewer go to choices dearer than the one that is taken
# Relative cost of a hole or shaft by grade: the reciprocal of its tolerance, which grows by 1.6 with each
# grade (ISO 286-1). An assumption, not data of a workshop: --cost states one's own.
RELATIVE_COST = {"IT7": 2.5, "IT8": 1.6, "IT9": 1.0}
# Choices of fits that are all tried; of more (four joints with five fits each), joint by joint.
MOST_CHOICES = 125
BRIEF = 6.0  # s: machines like the model that take less are run before the forecast, which they time
INTERRUPTED = "the computation was interrupted"
RANKING = "only the ranking of the clearances was requested (ranking)"


class DesignOptions(Watch, total=False):
    """Keywords of :func:`design`."""

    limit: float | str | None  # of the measure; a tenth above its value with the clearances of the model
    share: float  # of all machines that shall keep the limit
    cost: Mapping[str, float] | None  # of a hole or shaft by grade, as in {"IT7": 5}, or of a fit
    turns: int | None  # of each run; those of the mechanism
    wear: float | str | None  # coefficient (1/Pa) or pair of materials for joints without a table wear
    wear_turns: float  # over which wear is simulated; lives beyond are extrapolated
    clearance: float | None  # m, the clearance that ends a life; twice the own one
    joints: Sequence[str] | None  # that get a fit, others keep their clearance; all
    same_fit: bool  # in all joints, the same grades where their letters differ
    ranking: bool  # of the clearances alone, without fits and lives


@with_options(DesignOptions, share=SHARE, wear_turns=1e6, same_fit=False, ranking=False, confirm=False)
def design(mechanism: Mechanism, of: str | None = None, **options: Unpack[DesignOptions]) -> Design:
    """Answer which clearance matters for a measure, which ISO fits keep its limit, and how long joints last.

    >>> vfife.design(vfife.gallery.compressor(), limit="2.6 kN").joints  # doctest: +SKIP

    ``of``: the measure, by default the largest force of a joint with clearance. Sensitivities are those of
    :func:`vfife.sensitivity` to all clearances; where none is known, clearances are ranked by partial rank
    correlation over machines whose clearances vary from the finest to the coarsest fit. Fits are those of
    :func:`vfife.studies.allocate`: of grades with a ``cost``, with the letters whose clearance at grade 7 is
    nearest to that of the model, so that a ``share`` of all machines keeps the ``limit`` (SI or a text). More
    than 125 choices of fits are not all tried: the cheapest grades common to all ``joints`` come first, then
    cheaper fits joint by joint, unless ``same_fit``. Lives are those of :func:`vfife.wear`, for
    joints with a table ``wear``, or all with the coefficient ``wear``; a life ends at ``clearance`` (m).
    With ``ranking`` the answer has neither fits nor lives.

    A measure of knocks, such as ``C.approach_speed.max``, is that of the later half of the ``turns``, at
    least two: without the fall of the journals onto their bearings with which a run starts.

    A part that cannot be computed has its reason in ``missing``. ``progress(share, text)`` is called with the
    share that is done; ``turns`` is the length of each run, ``wear_turns`` that of the wear. Returns a
    :class:`Design`. Raises ModelError with all faults of the mechanism and the arguments, and for work of
    hours without ``confirm``; :class:`~vfife.job.job.Interrupted` on Ctrl-C, with the parts that are there.
    """
    work = DesignWork(mechanism, of, options)
    report: Any = options["progress"]
    job = job_of("design", None, options["confirm"], report, lambda state: report(state.share, state.text))
    with job:
        answer = work.run(job)
    if not answer.complete:
        raise Interrupted(answer)
    return answer


@dataclass
class DesignWork:
    """The parts of a design question, computed one after another. Raises ModelError for a mechanism without
    joints with clearance or without a crank, and for arguments that no part accepts.
    """

    mechanism: Mechanism
    of: str | None
    options: Any
    answers: dict[str, Any] = field(default_factory=dict)
    missing: dict[str, str] = field(default_factory=dict)
    nominal: float | None = None
    ideal: float | None = None
    nominal_range: tuple[float, float] | None = None
    machine_seconds: float | None = None  # on all cores, of a machine
    sample: MachineSample | None = None
    corners: MachineSample | None = None
    around: MachineSample | None = None
    inside: MachineSample | None = None
    search: str = ALL_CHOICES
    law_caution: str | None = None
    growths: Mapping[str, Effect] = field(default_factory=dict)

    def __post_init__(self) -> None:
        arguments = Arguments("design")
        arguments.mechanism(self.mechanism)
        arguments.kind("of", self.of, (str, type(None)), "the name of a measure, or None")
        arguments.check()
        refuse_unfit(self.mechanism)
        self.clearances = clearances(self.mechanism)
        self.measure = self.of or FORCE.format(next(iter(self.clearances)))
        self.counts = counts_of(self.measure)
        self.turns = run_turns(self.mechanism, self.options["turns"], self.counts)
        self.averaged = turns_of_cycles(self.mechanism, max(1, self.turns // 2), self.turns - 1)
        self.all_letters = {
            name: fit for name in self.clearances if (fit := nearest_fit(self.mechanism, name))
        }
        self.letters = {name: self.all_letters[name] for name in self.joints() if name in self.all_letters}
        self.wearing = with_wear(self.mechanism, self.options["wear"], "design()")
        limit = self.options["limit"]
        self.allotment: Any = self.read(1.0 if limit is None else limit) if self.letters else None
        choices = 0 if self.allotment is None else math.prod(map(len, self.allotment[1].options))
        if search := SAME_FITS if self.options.get("same_fit") else DESCENT if choices > MOST_CHOICES else "":
            self.search = search
            self.allotment = self.allotment and self.read(1.0 if limit is None else limit)
        self.limit = None if limit is None or self.allotment is None else self.allotment[1].bound.high

    def joints(self) -> list[str]:
        """Return the joints that get a fit. Raises ModelError for others than joints with clearance."""
        names = self.options.get("joints")
        names = list(self.clearances) if names is None else [names] if isinstance(names, str) else list(names)
        if faults := [
            Fault(
                "joints", "no joint with clearance has this name", name, ", ".join(self.clearances),
                suggestion(name, self.clearances, "correct it"),
            )
            for name in names
            if name not in self.clearances
        ]:  # fmt: skip
            raise ModelError(faults, "design()")
        return [name for name in self.clearances if name in names]

    def spec(self, *measures: str) -> CaseSpec:
        """Return what is computed of every machine: ``measures``, by default that of the question."""
        return CaseSpec(measures or (self.measure,), self.turns, last=self.averaged, counts=self.counts)

    def tables(self, limit: float | str) -> dict[str, Any]:
        """Return the arguments of the allocation; joints whose clearances matter least come first, and so are
        the first that a descent makes cheaper.
        """
        ranks = {} if self.sample is None else self.sample.ranks
        order = sorted(self.letters, key=lambda name: abs(ranks[name].value) if name in ranks else 0.0)
        vary = {
            name: {"path": path_of(name), "fit": fit, "diameter": self.mechanism.contacts[name].nominal_size}
            for name, fit in ((name, self.letters[name]) for name in order)
        }
        cost = self.options["cost"] or RELATIVE_COST
        share = {
            "measure": self.measure, "share": self.options["share"], "batch": BATCH, "search": self.search,
        }  # fmt: skip
        return {
            "vary": vary, "measures": [self.measure], "turns": self.turns, "last": self.averaged,
            "counts": self.counts, "allocation": share,
            "cost": {name: dict(cost) for name in vary}, "limit": {self.measure: limit},
        }  # fmt: skip

    def read(self, limit: float | str) -> Any:
        """Return plan and task of the allocation. Raises ModelError with every fault."""
        tables = self.tables(limit)
        vary, measures = tables.pop("vary"), tables.pop("measures")
        return read_allotment(tables_of(self.mechanism, vary, measures, tables, "design()"))

    @cached_property
    def prepared(self) -> Prepared:
        """The run of the model."""
        return prepare(self.mechanism, Arguments("design").run(turns=self.turns))

    @property
    def table_seconds(self) -> float:
        """Time (s) of a machine on all cores, by the table of costs."""
        return run_cost(self.prepared.assembly).stepping * LANES[CONTACT_LANES] / CONTACT_LANES / cores()

    @property
    def sensitive(self) -> bool:
        """Whether machines that hardly differ differ in the measure: derivatives mean nothing then."""
        low, high = self.nominal_range or (0.0, 0.0)
        return high - low > SENSITIVE * self.scale > 0.0

    @property
    def scale(self) -> float:
        """Size (SI) by which changes of the measure are judged."""
        return scale_of(self.measure, self.mechanism, self.nominal, self.ideal)

    def forecast(self) -> dict[str, Forecast]:
        """Return the forecasts of the parts."""
        seconds, parts = self.machine_seconds or self.table_seconds, {}
        steps = self.prepared.assembly.choice.steps

        def machines(count: int, remarks: tuple[str, ...] = ()) -> Forecast:
            return Forecast("case", count, steps, count * seconds, threads=cores(), remarks=remarks)

        differentiated = differentiable(self.measure) and not self.sensitive
        if differentiated:
            count = len(self.clearances)
            answer = machines(0)
            if not is_grown(self.measure):
                answer = sensitivity_forecast(self.prepared, self.mechanism, count, None)
            parts["sensitivity"] = with_growths(answer, count, seconds)
        if self.needs_ranks(has_effects=differentiated):
            parts["ranks"] = machines(MACHINES)
        if self.options.get("ranking"):
            return parts
        if self.allotment is not None:
            task = self.allotment[1]
            count = expected_machines(task) + corner_count(len(self.letters)) + FIT_MACHINES
            fits = machines(count, (allotment_remark(task, seconds),))
            ends = min(machine_counts(task)) * seconds, most_machines(task) * seconds
            parts["fits"] = dataclasses.replace(fits, ends=ends)
        if surfaces_of(self.wearing):
            turns, end = self.options["wear_turns"], self.end_of_life
            with suppress(VfifeError):  # it becomes the reason why lives are missing
                parts["life"] = wear_forecast(self.wearing, turns, clearance=end)
        return parts

    def needs_ranks(self, has_effects: bool) -> bool:
        """Return whether clearances are ranked: not all effects are known, or several joints descend in an
        order.
        """
        return not has_effects or (self.search == DESCENT and len(self.letters) > 1)

    def run(self, job: Job) -> Design:
        """Compute the parts; one that fails or is interrupted is named with its reason."""
        complete, forecasts = True, dict[str, Forecast]()
        try:
            if brief := NEAR_MACHINES * self.table_seconds < BRIEF:
                self.run_nominal()
            if NEAR_MACHINES * self.table_seconds < BRIEF * self.turns:
                self.machine_seconds = self.timed_machine()
            forecasts = self.forecast()
            ranking = 0.0 if "ranks" in forecasts else MACHINES * (self.machine_seconds or self.table_seconds)
            job.begin(total_forecast(forecasts, self.remedy(forecasts), ranking))
            if not brief:
                self.run_nominal()
            self.law_caution = law_caution(self.prepared, self.measure)
        except KeyboardInterrupt:
            complete = False
        self.run_parts(job, forecasts, complete)
        return self.design()

    def design(self) -> Design:
        """Return the answer with what is computed."""
        return Design(
            self.mechanism, self.measure, self.limit, self.options["limit"] is None,
            self.options["share"], self.letters, self.options["clearance"], self.answers.get("sensitivity"),
            self.answers.get("fits"), self.answers.get("life"), self.missing,
            not any(reason == INTERRUPTED for reason in self.missing.values())
            and is_complete(self.answers.get("life")),
            self.nominal, self.nominal_range, self.turns, self.averaged, self.sample, self.search,
            self.corners, self.growths, self.ideal, self.around, self.inside, self.law_caution,
        )  # fmt: skip

    def run_parts(self, job: Job, forecasts: Mapping[str, Forecast], complete: bool) -> None:
        """Compute the parts one after another, none after an interruption (not ``complete``)."""
        weights = {name: forecast.longest for name, forecast in forecasts.items()}
        if "life" in forecasts:  # it is expected to end at its limit, not after all turns
            weights["life"] = forecasts["life"].seconds
        if forecasts and "ranks" not in weights:  # needed if a derivative is not known
            weights["ranks"] = MACHINES * (self.machine_seconds or self.table_seconds)
        total, begin = sum(weights.values()) or 1.0, 0.0
        machines = 0 if self.allotment is None else most_machines(self.allotment[1])
        parts = self.sensitivities, self.ranks, self.fits, self.limits_of_fits, self.lives
        work: dict[str, Callable[[Job], Any]] = dict(zip(PARTS, parts, strict=True))
        for name, compute in work.items():
            if self.options.get("ranking") and name in ("fits", "life"):
                self.missing[name] = RANKING
            if name in self.missing or (name == "limits" and self.answers.get("fits") is None):
                continue
            end = min(1.0, begin + weights.get(name, 0.0) / total)
            try:
                if not complete:
                    raise KeyboardInterrupt
                self.answers[name] = compute(
                    PartJob(job, PARTS[name], (begin, end), machines if name == "fits" else 0)
                )
                complete = is_complete(self.answers[name])
            except KeyboardInterrupt:
                self.missing[name], complete = INTERRUPTED, False
            except VfifeError as error:
                self.missing[name] = str(error)
            begin = end

    def remedy(self, forecasts: Mapping[str, Forecast]) -> str:
        """Return what makes a long answer shorter, with its forecast, what helps most first."""
        seconds = {name: forecast.seconds for name, forecast in forecasts.items()}
        total = sum(seconds.values())
        if total <= LONG:
            return "ask for fewer turns"
        ways = dict[str, float]()
        if self.allotment is not None and "fits" in seconds:
            task, fits = self.allotment[1], seconds["fits"]
            machine = fits / max(1, expected_machines(task))
            common_task = dataclasses.replace(task, table=dataclasses.replace(task.table, search=SAME_FITS))
            if self.search != SAME_FITS and len(self.letters) > 1:
                ways["--same-fit"] = total - fits + machine * (expected_machines(common_task))
            if max(map(len, task.options)) > 1:
                ways["one grade (--cost IT7=1)"] = total - fits + machine * task.table.least_count
        if self.turns > 2:
            life = seconds.get("life", 0.0)
            ways["--turns 2"] = life + 2.0 / self.turns * (total - life)
        if (turns := self.options["wear_turns"]) > 1e4 and "life" in seconds:
            ways["--wear-turns 1e4"] = total - seconds["life"] * (1.0 - 1e4 / turns)
        shortest = sorted(ways.items(), key=lambda way: way[1])
        texts = [f"{way}: {span(left)}" for way, left in shortest if left < 0.9 * total]
        return f"choose {', or '.join(texts[:3])}" if texts else "ask for fewer turns"

    def run_nominal(self) -> None:
        """Run machines with the clearances of the model as those for the fits are run; choose the measure
        unless it was named, and a limit unless one was given. A sensitive motion is another one in each of
        these machines, so that their mean stands for the model.
        """
        names = [self.of] if self.of is not None else [FORCE.format(name) for name in self.clearances]
        values: dict[str, list[float]] = {name: [] for name in names}
        machines = near_machines({path_of(name): gap for name, gap in self.clearances.items()})
        for _, outcome in run_cases(self.mechanism, machines, self.spec(*names)):
            for name, value in outcome.values.items():
                values[name].append(value)
        means = {name: math.fsum(numbers) / len(numbers) for name, numbers in values.items() if numbers}
        if self.of is None:
            self.measure = max(names, key=lambda force: means.get(force, 0.0))
        self.nominal = means.get(self.measure)
        refuse_unlikely(self.options["limit"], self.measure, self.nominal)
        if numbers := values[self.measure]:
            self.nominal_range = min(numbers), max(numbers)
        if is_coordinate(self.measure):
            self.ideal = ideal_value(self.mechanism, self.spec())
        if self.limit is None:
            self.limit = default_limit(self.measure, self.mechanism, self.nominal, self.ideal)

    def timed_machine(self) -> float:
        """Return the time (s) of a machine on all cores, from a turn of machines as those that rank."""
        limits = {path_of(name): self.clearance_limits(name) for name in self.clearances}
        force = FORCE.format(next(iter(self.clearances)))
        return self.turns * timed_machine(self.mechanism, limits, force, NEAR_MACHINES)

    def sensitivities(self, job: Job) -> Sensitivity | None:
        """Run machines with larger clearances, then differentiate the measure by all clearances, which checks
        the effects. These machines alone (None) for a coordinate and for a statistic of a channel: see
        :func:`is_grown`, and where they leave no effect to check. Raises VfifeError for a measure without
        effects.
        """
        if not differentiable(self.measure):
            raise VfifeError(f"{self.measure} has no derivatives")
        if self.sensitive and self.nominal_range is not None:
            low, high = self.nominal_range
            raise VfifeError(
                f"the motion is sensitive: machines whose clearances differ by {100.0 * CLEARANCE_SPREAD:g} %"
                f" differ by {100.0 * (high - low) / self.scale:.3g} %"
                f"{' of the difference from the ideal one' * is_coordinate(self.measure)} in {self.measure}"
            )
        paths = {path_of(name): gap for name, gap in self.clearances.items()}
        machines = PartJob(job, "larger clearances", (0.0, 1.0))
        self.growths = growth_effects(self.mechanism, paths, self.spec(), machines)
        unknown = all(growth.kind == "unknown" for growth in self.growths.values())
        if unknown or is_grown(self.measure):
            return None
        return sensitivity(self.mechanism, [self.measure], list(paths), turns=self.turns, progress=job)

    def ranks(self, job: Job) -> MachineSample | None:
        """Run machines by which clearances are ranked, unless the effects of all of them are known."""
        answer = self.answers.get("sensitivity")
        derived = answer is not None or is_grown(self.measure)
        if not self.needs_ranks(derived and effects_agree(answer, self.measure, self.growths)):
            return None
        limits = {name: self.clearance_limits(name) for name in self.clearances}
        job(Progress(0, MACHINES, 0.0, f"{MACHINES} machines with clearances of all fits"))
        self.sample = self.run_machines(list(limits), sampled_clearances(limits), job)
        return self.sample

    def run_machines(self, names: Sequence[str], clearances: Any, job: Job) -> MachineSample:
        """Run machines with ``clearances`` (m) of the joints ``names``, shape (machines, joints), over the
        turns of those for the fits. The ``job`` counts the machines.
        """
        paths = {name: path_of(name) for name in names}
        return run_machines(self.mechanism, clearances, paths, self.spec(), job)

    def clearance_limits(self, joint: str) -> tuple[float, float]:
        """Return the least and largest clearance (m) of the fits that a joint may have."""
        size, cost = self.mechanism.contacts[joint].nominal_size, self.options["cost"] or RELATIVE_COST
        return limits_of(self.all_letters.get(joint), size or 0.0, cost, self.clearances[joint])

    def fits(self, job: Job) -> Allocation:
        """Allocate fits that keep the limit. Raises VfifeError where there is no limit or no fit."""
        if not self.letters:
            sizes = f"{1e3 * LEAST_SIZE:g} to {1e3 * LARGEST_SIZE:g} mm"
            raise VfifeError(f"no joint has a nominal size of {sizes}")
        if self.limit is None:
            raise VfifeError(missing_limit(self.measure, self.nominal, self.scale))
        return allocate(self.mechanism, **self.tables(self.limit), progress=job)

    def limits_of_fits(self, job: Job) -> None:
        """Run machines at the limits of the clearances of the chosen fits, within them, and near the machine
        with the largest value.
        """
        limits = {joint.name: joint.limits for joint in self.design().joints if joint.limits}
        if not limits:
            return
        self.corners = self.run_machines(list(limits), corner_clearances(limits), job)
        count = EVEN_MACHINES - sum(len(part.values) for part in self.design().even_machines)
        if count > 0:
            self.inside = self.run_machines(list(limits), sampled_clearances(limits, count, EVEN_SEED), job)
        for _ in range(ROUNDS):
            if machine := self.design().clearances_of_largest:
                part = self.run_machines(list(limits), clearances_around(machine, limits), job)
                self.around = joined([self.around, part] if self.around else [part])

    def lives(self, job: Job) -> Worn:
        """Simulate wear. Raises VfifeError for a mechanism that does not wear."""
        if not surfaces_of(self.wearing):
            raise VfifeError("no joint of the model has a coefficient of wear")
        return wear(self.wearing, self.options["wear_turns"], clearance=self.end_of_life, progress=job)

    @property
    def end_of_life(self) -> float:
        """Clearance (m) that ends the simulation of wear."""
        return self.options["clearance"] or LIFE * max(pair.clearance for pair in surfaces_of(self.wearing))


def is_complete(answer: Any) -> bool:
    """Return whether a part ran to its end: a wear simulation returns what it has on Ctrl-C."""
    return not isinstance(answer, Worn) or (answer.complete and bool(answer.step_difference))
