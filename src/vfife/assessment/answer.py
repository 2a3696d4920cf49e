"""The answer of a design question: sensitivities, fits and wear of the joints with clearance."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..errors import Fault, ModelError
from ..laws.materials import SCATTER
from ..measures.catalogue import LAST, is_coordinate, is_reduction, unit_of
from ..model.functions import crank_faults, turn_of
from ..model.mechanism import Mechanism
from ..report.html import NotebookDocument
from ..results.derivatives import Effect, Sensitivity
from ..studies.spec.distributions import SIGMAS, of_fit
from ..studies.spec.iso286 import LARGEST_SIZE, LEAST_SIZE, LETTERS
from ..studies.study_work import Allocation
from ..tribology.wear_state import Worn
from ..units import number, unit_fault
from .ranking import Rank
from .sample import MachineSample, growth_of

RUNNING = LETTERS[: LETTERS.index("h")]  # letters of shafts that always have clearance
SENSITIVE = 0.01  # of the measure: machines that hardly differ differ by more only in a sensitive motion
SECOND_TURN = 2  # the first whose contacts are not those of the start of a run
# Above the value with the clearances of the model: the limit that fits keep unless one is given, as a share
# of this value, or of the difference of a coordinate from the ideal mechanism.
ALLOWANCE = 0.1
UNCHANGED = 0.01  # of the largest clearance: a coordinate that differs less from the ideal one is the same
LEAST_COORDINATE = 0.01  # m or rad: units of a limit are not guessed from a coordinate nearer to its zero
LIFE = 2.0  # clearance at the end of a life, by that of the model, unless a limit is given


def run_turns(mechanism: Mechanism, turns: int | None, counts: str) -> int:
    """Return the turns of each run: ``turns``, else those of the mechanism; whole ones, as machines of an
    allocation have. Contacts of the last turns (``counts``) need one before, in which the journals fall onto
    their bearings.
    """
    if turns is None:
        settings, turn = mechanism.settings, turn_of(mechanism) or 1.0
        turns = math.ceil(settings.turns or (settings.duration or turn) / turn)
    return max(int(turns), SECOND_TURN) if counts == LAST else int(turns)


class Life(NamedTuple):
    """Turns until a joint reaches its ``clearance`` (m), with their range; ``reached``: simulated, not
    extrapolated. The range is None for a wear simulation that was interrupted. ``unsmoothed``: turns until
    the deepest places as they wore reach it; ``uniform``: turns if wear spread evenly around both surfaces.
    Not ``determined``: grooves are narrower than the journal or than what the profiles resolve, and the range
    covers all three.
    """

    turns: float
    span: tuple[float, float] | None
    clearance: float
    reached: bool
    unsmoothed: float = math.inf
    uniform: float = math.inf
    determined: bool = True

    @property
    def bounds(self) -> tuple[float, float] | None:
        """The range of the life: its ``span``, or without one, for a life that is not ``determined``, what
        the model permits, without the errors of time step and scatter; None if nothing is known.
        """
        if self.span is not None or self.determined:
            return self.span
        ends = self.turns, self.unsmoothed, self.uniform
        return min(ends), max(ends)


@dataclass(frozen=True)
class JointDesign:
    """Findings for a joint with ``clearance`` (m).

    ``growth`` (m) of the clearance changes the measure by ``effect`` (value, low and high in per cent; SI
    units of a position or an angle, whose zero is arbitrary), in machines that have this growth.
    ``rank`` is the partial rank correlation of the measure with the clearance over the machines of the
    sample. ``fit`` with the ``limits`` (m) of its clearance, and ``life``. None: not computed.
    """

    name: str
    clearance: float
    growth: float
    effect: Effect | None = None
    fit: str | None = None
    limits: tuple[float, float] | None = None
    life: Life | None = None
    rank: Rank | None = None


@dataclass(frozen=True, repr=False)
class Design(NotebookDocument):
    """Which clearance matters for a ``measure``, which fits keep its ``limit``, how long joints last.

    ``sensitivity``, ``allocation`` and ``wear`` are the answers of :func:`~vfife.sensitivity`,
    :func:`~vfife.studies.allocate` and :func:`~vfife.wear`, None for a part that is ``missing``, which has
    the reason by part ("sensitivity", "fits", "life"). ``nominal`` is the measure (SI) with the clearances
    of the model, the mean of machines that hardly differ, and ``nominal_range`` their least and largest. It
    and the measures of all machines for the fits are means over the last ``averaged`` of ``turns`` turns.
    ``limit`` (SI) is that of the measure; with ``default_limit`` a tenth above the nominal value. ``ideal``
    is the measure (SI) of the mechanism without clearance, for a coordinate: a position or an angle, whose
    zero is arbitrary, is compared with it, and its default limit is a tenth of the difference above.
    ``letters`` are the nearest fits by joint, from which letters of fits come; other joints keep their
    clearance. ``sample``: machines with clearances from the finest to the coarsest fit, which rank the
    clearances. ``search``: "all" choices of fits, the "same" grades in all joints, or a "descent" from
    these joint by joint. ``corners``: machines whose clearances are limits of the chosen fits;
    ``around``: machines near that with the largest value; ``inside``: machines evenly distributed within
    the limits, beside those of the ``sample``.
    ``law_caution``: the caution of a run of the model where the contact law decides the measure; "" where
    that run has none, None without this run.
    ``growths``: effects of grown clearances by path. ``end_clearance`` (m) ends a life; None: twice the own
    one. ``joints``: the findings for each joint.
    """

    mechanism: Mechanism
    measure: str
    limit: float | None
    default_limit: bool
    share: float
    letters: Mapping[str, str]
    end_clearance: float | None = None
    sensitivity: Sensitivity | None = None
    allocation: Allocation | None = None
    wear: Worn | None = None
    missing: Mapping[str, str] = field(default_factory=dict)
    complete: bool = True
    nominal: float | None = None
    nominal_range: tuple[float, float] | None = None
    turns: int = 1
    averaged: int = 1
    sample: MachineSample | None = None
    search: str = "all"
    corners: MachineSample | None = None
    growths: Mapping[str, Effect] = field(default_factory=dict)
    ideal: float | None = None
    around: MachineSample | None = None
    inside: MachineSample | None = None
    law_caution: str | None = None

    @property
    def name(self) -> str:  # type: ignore[override]
        """Name of the mechanism."""
        return self.mechanism.name

    @property
    def value(self) -> float | None:
        """The measure (SI) with the clearances of the model, None if it is not computed."""
        return self.nominal

    @cached_property
    def ranks(self) -> Mapping[str, Rank]:
        """Partial rank correlation of the measure with each clearance, by joint, over the machines of the
        ``sample``; without joints of which it is not known.
        """
        return {} if self.sample is None else self.sample.ranks

    @property
    def sensitive(self) -> bool:
        """Whether machines that hardly differ, or runs with other time steps, differ in the measure."""
        low, high = self.nominal_range or (0.0, 0.0)
        scattered = high - low > SENSITIVE * self.scale > 0.0
        return scattered or (self.sensitivity is not None and self.measure in self.sensitivity.doubtful)

    @property
    def by_difference(self) -> bool:
        """Whether the zero of the measure is arbitrary, so that effects are differences, not shares."""
        return is_coordinate(self.measure)

    @property
    def scale(self) -> float:
        """Size (SI) by which changes of the measure are judged: see :func:`scale_of`."""
        return scale_of(self.measure, self.mechanism, self.nominal, self.ideal)

    @property
    def limit_deviations(self) -> float:
        """Standard deviations of a hole or a shaft from the middle of its tolerance zone to its limits."""
        return SIGMAS

    @cached_property
    def values_within_limits(self) -> NDArray[np.float64]:
        """The measure (SI) of machines whose clearances lie within the limits of the chosen fits, whatever
        their distribution: the ``even_machines``, the ``corners``, and those ``around`` the largest.
        """
        parts = [machines.values for machines in self._within_limits]
        values = np.concatenate(parts) if parts else np.empty(0)
        return np.asarray(values[np.isfinite(values)])

    @cached_property
    def clearances_of_largest(self) -> Mapping[str, float]:
        """Clearances (m) by joint of the machine with the largest of the :attr:`values_within_limits`; empty
        without any.
        """
        pairs = [
            (float(value), dict(zip(machines.names, map(float, row), strict=True)))
            for machines in self._within_limits
            for value, row in zip(machines.values, machines.clearances, strict=True)
            if math.isfinite(value)
        ]
        return max(pairs, key=lambda pair: pair[0])[1] if pairs else {}

    @property
    def _within_limits(self) -> list[MachineSample]:
        """The ``even_machines``, those ``around`` the largest, and the ``corners``."""
        if self.corners is None:
            return []
        ends = [machines for machines in (self.around, self.corners) if machines is not None]
        return [*self.even_machines, *ends]

    @property
    def even_machines(self) -> list[MachineSample]:
        """The machines evenly distributed within the limits of the chosen fits: those of the ``sample`` that
        lie there, and those ``inside``.

        In the sample every clearance varies: it has no machine in which a joint without fit keeps its own.
        """
        limits = {joint.name: joint.limits for joint in self.joints if joint.limits}
        parts = [] if self.inside is None else [self.inside]
        if self.sample is None or not limits.keys() >= {*self.sample.names}:
            return parts
        inside, sample = self.sample.within(limits), self.sample
        return [MachineSample(sample.names, sample.clearances[inside], sample.values[inside]), *parts]

    @cached_property
    def jump(self) -> float:
        """Root mean square of the difference (SI) between machines within the limits of the fits that have
        nearly the same clearances; 0 where the measure varies smoothly.
        """
        return max((machines.jump for machines in self._within_limits), default=0.0)

    @property
    def joints(self) -> tuple[JointDesign, ...]:
        """Findings for each joint with clearance."""
        return tuple(self._joint(name, clearance) for name, clearance in clearances(self.mechanism).items())

    @property
    def costs(self) -> str:
        """Relative cost of a hole or a shaft by grade, as text."""
        raw = {} if self.allocation is None else self.allocation.study.request["raw"].get("cost", {})
        costs: Mapping[str, float] = next(iter(raw.values()), {})
        return ", ".join(f"{grade} {cost:g}" for grade, cost in costs.items())

    @property
    def unit(self) -> str:
        """Unit of the measure."""
        units = {} if self.allocation is None else self.allocation.study.measures
        return units.get(self.measure) or unit_of(self.measure)

    @property
    def joint_to_wear(self) -> str:
        """The first joint that could wear, where no joint of the model has a table wear; else ""."""
        wearable = {
            name: joint.wear for name, joint in self.mechanism.contacts.items() if joint.keeps_profile
        }
        return "" if any(wearable.values()) else next(iter(wearable), "")

    @property
    def wears_by_pair(self) -> bool:
        """Whether a wear coefficient that was simulated is that of a pair of materials by name."""
        wears = (
            () if self.wear is None else [joint.wear for joint in self.wear.mechanism(0).contacts.values()]
        )
        return any(isinstance(side, str) for wear in wears if wear for side in (wear.bearing, wear.journal))

    @property
    def flat_joints(self) -> tuple[str, ...]:
        """Joints whose wear cannot be simulated: sliders with clearance in guides."""
        return tuple(name for name, joint in self.mechanism.contacts.items() if not joint.keeps_profile)

    @property
    def turn(self) -> float:
        """Period (s) of a turn."""
        return turn_of(self.mechanism) or math.nan

    def __repr__(self) -> str:
        fits = None if self.allocation is None else self.allocation.fits
        return f"<Design of {self.name!r} for {self.measure}: fits {fits}; see .joints, .missing>"

    def _joint(self, name: str, clearance: float) -> JointDesign:
        growth, effect = growth_of(clearance), self._effect(path_of(name))
        fit, limits = self._fit(name)
        life, rank = self._life(name, clearance), self.ranks.get(name)
        return JointDesign(name, clearance, growth, effect, fit, limits, life, rank)

    def _effect(self, path: str) -> Effect | None:
        """Return the effect of the growth of a clearance; None where runs with other time steps disagree on
        the measure, or nothing was computed.
        """
        answer = self.sensitivity
        if answer is None:  # see is_grown
            return self.growths.get(path)
        if self.measure not in answer.measures or self.measure in answer.doubtful:
            return None
        return self.growths.get(path)

    def _fit(self, name: str) -> tuple[str | None, tuple[float, float] | None]:
        choice = None if self.allocation is None else self.allocation.choice
        if self.allocation is None or choice is None:
            return None, None
        names = [parameter.name for parameter in self.allocation.task.parameters]
        if name not in names:
            return None, None
        option = choice.options[names.index(name)]
        return option.name, option.clearance.limits

    def _life(self, name: str, clearance: float) -> Life | None:
        wear = self.wear
        if wear is None or name not in wear.joints:
            return None
        end = self.end_clearance or LIFE * clearance
        life = wear.life(name, end)
        reached, shapes = bool(life.smoothed <= wear.turns[-1]), (life.deepest, life.uniform, life.determined)
        if not wear.step_difference:
            return Life(life.smoothed, None, end, reached, *shapes)
        # Errors of the rate by time step and by scatter over turns, then the scatter of tests of a pair.
        error = max(wear.step_difference) + float(wear.spread.max())
        wears = wear.mechanism(0).contacts[name].wear
        sides = () if wears is None else (wears.bearing, wears.journal)
        factor = SCATTER if any(isinstance(side, str) for side in sides) else 1.0
        high = life.longest * factor / (1.0 - error) if error < 1.0 else math.inf
        span = (life.shortest / factor / (1.0 + error), high)
        return Life(life.smoothed, span, end, reached, *shapes)


def is_grown(measure: str) -> bool:
    """Return whether effects on a measure are those of machines with larger clearances alone: a statistic of
    a channel has no derivatives, and those of a coordinate are judged by its value, whose zero is arbitrary.
    """
    return is_reduction(measure) or is_coordinate(measure)


def effects_agree(answer: Sensitivity | None, measure: str, growths: Mapping[str, Effect]) -> bool:
    """Return whether the effects of all clearances on a measure are known, and small changes have the signs
    of the ``growths`` by path. Without an ``answer``, for a measure without derivatives, these alone count.
    """
    if answer is None:
        return bool(growths) and all(growth.kind != "unknown" for growth in growths.values())
    small = {
        derivative.path: answer.effect(measure, derivative.path)
        for derivative in answer.derivatives
        if measure in derivative.values
    }
    return measure not in answer.doubtful and all(
        growth.kind != "unknown"
        and (path not in small or (small[path].kind != "unknown" and small[path].value * growth.value >= 0.0))
        for path, growth in growths.items()
    )


def clearances(mechanism: Mechanism) -> dict[str, float]:
    """Return the clearances (m) of the joints that have one."""
    pairs = ((name, getattr(joint, "clearance", None)) for name, joint in mechanism.contacts.items())
    return {name: clearance for name, clearance in pairs if clearance}


def refuse_unfit(mechanism: Mechanism) -> None:
    """Raise ModelError for a mechanism without joints with clearance, or without a crank."""
    faults = []
    if not clearances(mechanism):
        remedy = 'give a joint kind = "clearance" and a clearance'
        faults.append(Fault("joint", "no joint has clearance, so there is nothing to decide", "", "", remedy))
    if mechanism.settings.analysis == "static":
        faults.append(Fault("run.analysis", "a static analysis has no turns", "static", "dynamic", "set it"))
    else:
        faults += crank_faults(mechanism, "there are no turns to count")
    if faults:
        raise ModelError(faults, mechanism.name)


def refuse_unlikely(limit: float | str | None, measure: str, nominal: float | None) -> None:
    """Raise ModelError for a limit without a unit that is far from the ``nominal`` value (SI) of its
    measure.
    """
    origin = f"{measure} with the clearances of the model"
    if is_coordinate(measure) and isinstance(limit, str):
        nominal = max(abs(nominal or 0.0), LEAST_COORDINATE)
        if abs(number(limit, unit_of(measure))) < nominal:
            return
    if fault := unit_fault("limit", limit, unit_of(measure), nominal, origin):
        raise ModelError([fault], "design()")


def scale_of(measure: str, mechanism: Mechanism, nominal: float | None, ideal: float | None) -> float:
    """Return the size (SI) by which changes of a measure are judged: that of its ``nominal`` value, 0 if it
    is unknown. Of a coordinate, whose zero is arbitrary, it is the difference from the ``ideal`` mechanism,
    at least a hundredth of the largest clearance (m; rad on a length of 1 m), or this clearance where the
    ideal mechanism has no value.
    """
    if not is_coordinate(measure):
        return abs(nominal or 0.0)
    largest = max(clearances(mechanism).values())
    if nominal is None or ideal is None:
        return largest
    return max(abs(nominal - ideal), UNCHANGED * largest)


def default_limit(
    measure: str, mechanism: Mechanism, nominal: float | None, ideal: float | None
) -> float | None:
    """Return the limit (SI) of a measure that has none: a tenth above its ``nominal`` value. Of a coordinate,
    a tenth of what the clearances add to the ``ideal`` one; None where they make it no larger.
    """
    if nominal is None:
        return None
    if not is_coordinate(measure):
        return (1.0 + ALLOWANCE) * nominal if nominal > 0.0 else None
    threshold = UNCHANGED * max(clearances(mechanism).values())
    return None if ideal is None or nominal - ideal <= threshold else nominal + ALLOWANCE * (nominal - ideal)


def missing_limit(measure: str, nominal: float | None, scale: float) -> str:
    """Return why a measure has no default limit; with an example, the ``nominal`` value and its ``scale``."""
    if nominal is None or not is_coordinate(measure):
        value = "unknown" if nominal is None else f"{nominal:g} with the clearances of the model"
        return f"the value of {measure} is {value}; give it a limit"
    unit = unit_of(measure)
    number, unit = (1e3 * (nominal + scale), "mm") if unit == "m" else (nominal + scale, unit)
    return (
        f"the zero of {measure} is arbitrary, and the clearances of the model do not make it larger, so that"
        f' no limit follows from its value; give the largest value, as in --limit "{number:.6g} {unit}"'
    )


def nearest_fit(mechanism: Mechanism, joint: str) -> str:
    """Return the fit of grade 7 whose mean clearance is nearest to that of the joint; "" without a size."""
    contact = mechanism.contacts[joint]
    size, clearance = contact.nominal_size, clearances(mechanism)[joint]
    if size is None or not LEAST_SIZE <= size <= LARGEST_SIZE:
        return ""
    fits = [of_fit(f"H7/{letter}7", size) for letter in RUNNING]
    return min(fits, key=lambda fit: abs(0.5 * sum(fit.limits) - clearance)).fit.name


def path_of(joint: str) -> str:
    """Return the path of the clearance of a joint in a model file."""
    return f"joint.{joint}.clearance"
