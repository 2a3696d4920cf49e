"""``vfife.design``: one answer from sensitivities, allocated fits and wear of a mechanism."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any, Unpack

from ..errors import Fault, ModelError, VfifeError
from ..job.cost import Forecast
from ..job.job import Interrupted, Job, PartJob, job_of
from ..job.progress import span
from ..measures.catalogue import differentiable
from ..model.functions import crank_faults, turn_of
from ..model.mechanism import Mechanism
from ..model.wear import COEFFICIENT, Wear
from ..options import Watch, with_options
from ..results.derivatives import Sensitivity
from ..simulation.simulate import prepare
from ..solvers.arguments import Arguments
from ..studies.engine.cases import run_cases
from ..studies.forecast import allotment_forecast
from ..studies.methods.allocation import read_allotment
from ..studies.methods.derivatives import forecast as sensitivity_forecast
from ..studies.methods.derivatives import sensitivity
from ..studies.spec.distributions import of_fit
from ..studies.spec.iso286 import LARGEST_SIZE, LEAST_SIZE, LETTERS
from ..studies.spec.plan import CaseSpec
from ..studies.study_work import Allocation, allocate, tables_of
from ..tribology.simulate_wear import wear
from ..tribology.wear_state import Worn, surfaces_of
from .answer import LIFE, Design, clearances, path_of

FORCE = "{}.force.max"
# A tenth above the value with the clearances of the model: the limit that fits keep unless one is given.
ALLOWANCE = 1.1
SHARE = 0.95  # of all machines; 59 machines without a failure show it with 95 % confidence
BATCH = 32  # machines simulated at once: fewer go to choices dearer than the one that is taken
# Relative cost of a hole or shaft by grade: the reciprocal of its tolerance, which grows by 1.6 with each
# grade (ISO 286-1). An assumption, not data of a workshop: --cost states one's own.
RELATIVE_COST = {"IT7": 2.5, "IT8": 1.6, "IT9": 1.0}
# Machines that stand for the model, and the share by which clearances differ, far less than tolerances do.
NEAR_MACHINES, CLEARANCE_SPREAD = 8, 2e-4
RUNNING = LETTERS[: LETTERS.index("h")]  # letters of shafts that always have clearance
PARTS = {"sensitivity": "sensitivities", "fits": "fits", "life": "wear"}
INTERRUPTED = "not computed: interrupted"


class DesignOptions(Watch, total=False):
    """Keywords of :func:`design`."""

    limit: float | str | None  # of the measure; a tenth above its value with the clearances of the model
    share: float  # of all machines that shall keep the limit
    cost: Mapping[str, float] | None  # of a hole or shaft by grade, as in {"IT7": 5}, or of a fit
    turns: int | None  # of each run; those of the mechanism
    wear: float | str | None  # coefficient (1/Pa) or pair of materials for joints without a table wear
    wear_turns: float  # over which wear is simulated; lives beyond are extrapolated
    clearance: float | None  # m, the clearance that ends a life; twice the own one


@with_options(DesignOptions, share=SHARE, wear_turns=1e6, confirm=False)
def design(mechanism: Mechanism, of: str | None = None, **options: Unpack[DesignOptions]) -> Design:
    """Answer which clearance matters for a measure, which ISO fits keep its limit, and how long joints last.

    >>> vfife.design(vfife.gallery.compressor(), limit="2.6 kN").joints  # doctest: +SKIP

    ``of``: the measure, by default the largest force of a joint with clearance. Sensitivities are those of
    :func:`vfife.sensitivity` to all clearances; where none is known, clearances are ranked by partial rank
    correlation over the machines of the fits. Fits are those of :func:`vfife.studies.allocate`: of grades
    with a ``cost``, with the letters whose clearance at grade 7 is nearest to that of the model, so that a
    ``share`` of all machines keeps the ``limit`` (SI or a text). Lives are those of :func:`vfife.wear`, for
    joints with a table ``wear``, or all with the coefficient ``wear``; a life ends at ``clearance`` (m).

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
    nominal_range: tuple[float, float] | None = None

    def __post_init__(self) -> None:
        arguments = Arguments("design")
        arguments.mechanism(self.mechanism)
        arguments.check()
        refuse_unfit(self.mechanism)
        self.clearances, self.turns = clearances(self.mechanism), self.run_turns()
        self.averaged = max(1, self.turns // 2)  # turns over which measures are means: the later half
        self.letters = {name: fit for name in self.clearances if (fit := nearest_fit(self.mechanism, name))}
        self.wearing = with_wear(self.mechanism, self.options["wear"])
        limit = self.options["limit"]
        self.measure = self.of or FORCE.format(next(iter(self.clearances)))
        self.allotment: Any = self.read(1.0 if limit is None else limit) if self.letters else None
        self.limit = None if limit is None or self.allotment is None else self.allotment[1].bound.high

    def run_turns(self) -> int:
        """Return the turns of each run: whole ones, as machines of an allocation have."""
        if (turns := self.options["turns"]) is None:
            settings, turn = self.mechanism.settings, turn_of(self.mechanism) or 1.0
            turns = math.ceil(settings.turns or (settings.duration or turn) / turn)
        return int(turns)

    def tables(self, limit: float | str) -> dict[str, Any]:
        """Return the arguments of the allocation."""
        vary = {
            name: {"path": path_of(name), "fit": fit, "diameter": self.mechanism.contacts[name].nominal_size}
            for name, fit in self.letters.items()
        }
        cost = self.options["cost"] or RELATIVE_COST
        share = {"measure": self.measure, "share": self.options["share"], "batch": BATCH}
        return {
            "vary": vary, "measures": [self.measure], "turns": self.turns, "last": self.averaged,
            "allocation": share,
            "cost": {name: dict(cost) for name in vary}, "limit": {self.measure: limit},
        }  # fmt: skip

    def read(self, limit: float | str) -> Any:
        """Return plan and task of the allocation. Raises ModelError with every fault."""
        tables = self.tables(limit)
        vary, measures = tables.pop("vary"), tables.pop("measures")
        return read_allotment(tables_of(self.mechanism, vary, measures, tables, "design()"))

    def forecast(self) -> dict[str, Forecast]:
        """Return the forecasts of the parts; wear makes its own after its first block."""
        arguments = Arguments("design").run(turns=self.turns)
        prepared = prepare(self.mechanism, arguments)
        parts = {}
        if differentiable(self.measure):
            count = len(self.clearances)
            parts["sensitivity"] = sensitivity_forecast(prepared, self.mechanism, count, None)
        if self.allotment is not None:
            plan, task = self.allotment
            parts["fits"] = allotment_forecast(plan, task, None)
        return parts

    def run(self, job: Job) -> Design:
        """Compute the parts; one that fails or is interrupted is named with its reason."""
        forecasts = self.forecast()
        job.begin(total_forecast(forecasts, bool(surfaces_of(self.wearing))))
        share_done, complete = 0.0, True
        total = sum(forecast.seconds for forecast in forecasts.values()) / 0.8 or 1.0
        try:
            self.run_nominal()
        except KeyboardInterrupt:
            complete = False
        work: dict[str, Callable[[Job], Any]]
        work = {"sensitivity": self.sensitivities, "fits": self.fits, "life": self.lives}
        for name, compute in work.items():
            share = forecasts[name].seconds / total if name in forecasts else 0.0
            share = 1.0 - share_done if name == "life" else share
            try:
                if complete:
                    self.answers[name] = compute(
                        PartJob(job, PARTS[name], (share_done, min(share_done + share, 1.0)))
                    )
                    complete = is_complete(self.answers[name])
                else:
                    self.missing[name] = INTERRUPTED
            except KeyboardInterrupt:
                self.missing[name], complete = INTERRUPTED, False
            except VfifeError as error:
                self.missing[name] = str(error)
            share_done += share
        return Design(
            self.mechanism, self.measure, self.limit, self.options["limit"] is None,
            self.options["share"], self.letters, self.options["clearance"], self.answers.get("sensitivity"),
            self.answers.get("fits"), self.answers.get("life"), self.missing, complete, self.nominal,
            self.nominal_range, self.turns, self.averaged,
        )  # fmt: skip

    def run_nominal(self) -> None:
        """Run machines with the clearances of the model as those for the fits are run; choose the measure
        unless it was named, and a limit unless one was given. A sensitive motion is another one in each of
        these machines, so that their mean stands for the model.
        """
        names = [self.of] if self.of is not None else [FORCE.format(name) for name in self.clearances]
        spec = CaseSpec(tuple(names), self.turns, last=self.averaged)
        values: dict[str, list[float]] = {name: [] for name in names}
        for _, outcome in run_cases(self.mechanism, self.near_machines(), spec):
            for name, value in outcome.values.items():
                values[name].append(value)
        means = {name: math.fsum(numbers) / len(numbers) for name, numbers in values.items() if numbers}
        if self.of is None:
            self.measure = max(names, key=lambda force: means.get(force, 0.0))
        self.nominal = means.get(self.measure)
        if numbers := values[self.measure]:
            self.nominal_range = min(numbers), max(numbers)
        if self.limit is None and self.nominal is not None and self.nominal > 0.0:
            self.limit = ALLOWANCE * self.nominal

    def near_machines(self) -> list[dict[str, float | str]]:
        """Return the numbers of machines whose clearances are nearly those of the model."""
        shares = (1.0 + CLEARANCE_SPREAD * (k / (NEAR_MACHINES - 1) - 0.5) for k in range(NEAR_MACHINES))
        return [
            {path_of(name): share * clearance for name, clearance in self.clearances.items()}
            for share in shares
        ]

    def sensitivities(self, job: Job) -> Sensitivity:
        """Differentiate the measure by all clearances. Raises VfifeError for a measure without
        derivatives.
        """
        if not differentiable(self.measure):
            raise VfifeError(f"{self.measure} has no derivatives")
        paths = [path_of(name) for name in self.clearances]
        return sensitivity(self.mechanism, [self.measure], paths, turns=self.turns, progress=job)

    def fits(self, job: Job) -> Allocation:
        """Allocate fits that keep the limit. Raises VfifeError where there is no limit or no fit."""
        if not self.letters:
            raise VfifeError(
                f"no joint has a nominal size of {1e3 * LEAST_SIZE:g} to {1e3 * LARGEST_SIZE:g} mm"
            )
        if self.limit is None:
            raise VfifeError(f"the value of {self.measure} is not known; give it a limit")
        return allocate(self.mechanism, **self.tables(self.limit), progress=job)

    def lives(self, job: Job) -> Worn:
        """Simulate wear. Raises VfifeError for a mechanism that does not wear."""
        surfaces, end = surfaces_of(self.wearing), self.options["clearance"]
        if not surfaces:
            raise VfifeError("no joint of the model has a coefficient of wear")
        end = end or LIFE * max(surface.clearance for surface in surfaces)
        return wear(self.wearing, self.options["wear_turns"], clearance=end, progress=job)


def refuse_unfit(mechanism: Mechanism) -> None:
    """Raise ModelError for a mechanism without joints with clearance, or without a crank."""
    faults = []
    if not clearances(mechanism):
        remedy = 'give a joint kind = "clearance" and a clearance'
        faults.append(Fault("joint", "no joint has clearance, so nothing is to be decided", "", "", remedy))
    if mechanism.settings.analysis == "static":
        faults.append(Fault("run.analysis", "a static analysis has no turns", "static", "dynamic", "set it"))
    else:
        faults += crank_faults(mechanism, "there are no turns to count")
    if faults:
        raise ModelError(faults, mechanism.name)


def nearest_fit(mechanism: Mechanism, joint: str) -> str:
    """Return the fit of grade 7 whose mean clearance is nearest to that of the joint; "" without a size."""
    contact = mechanism.contacts[joint]
    size, clearance = contact.nominal_size, clearances(mechanism)[joint]
    if size is None or not LEAST_SIZE <= size <= LARGEST_SIZE:
        return ""
    fits = [of_fit(f"H7/{letter}7", size) for letter in RUNNING]
    return min(fits, key=lambda fit: abs(0.5 * sum(fit.limits) - clearance)).fit.name


def with_wear(mechanism: Mechanism, coefficient: float | str | None) -> Mechanism:
    """Return the mechanism with a ``coefficient`` of wear (1/Pa, or a pair of materials) for the joints that
    can wear and have no table; unchanged for None. Raises ModelError.
    """
    if coefficient is None:
        return mechanism
    try:
        value = COEFFICIENT.take(coefficient, written=isinstance(coefficient, str))
    except Fault as fault:
        raise ModelError([fault.at("wear")], "design()") from None
    model = dataclasses.replace(mechanism, joints=dict(mechanism.joints))
    for name, joint in mechanism.contacts.items():
        if joint.keeps_profile and joint.wear is None:
            model.joints[name] = dataclasses.replace(joint, wear=Wear(bearing=value, journal=value))
    return model


def total_forecast(parts: Mapping[str, Forecast], wears: bool) -> Forecast:
    """Return the forecast of all parts."""
    texts = [f"{PARTS[name]}: {span(forecast.seconds)}{forecast.note}." for name, forecast in parts.items()]
    texts += list(parts["fits"].remarks[-1:]) if "fits" in parts else []
    texts += ["wear: its first turns show how long the others take."] if wears else []
    seconds = sum(forecast.seconds for forecast in parts.values())
    names = " and ".join([*(PARTS[name] for name in parts), *(["wear"] if wears else [])])
    return Forecast(
        "part", len(parts), seconds=seconds,
        memory=max((forecast.memory for forecast in parts.values()), default=0.0),
        threads=max((forecast.threads for forecast in parts.values()), default=1), work=names,
        parts=tuple(texts), remedy="ask for fewer turns, or a smaller share",
    )  # fmt: skip


def is_complete(answer: Any) -> bool:
    """Return whether a part ran to its end: a wear simulation returns what it has on Ctrl-C."""
    return not isinstance(answer, Worn) or (answer.complete and bool(answer.step_difference))
