"""Identification: numbers of a model from measured curves, by least squares from many starts, all of whose runs go side by side in lanes.

Starts are the best of points on Sobol's sequence, scrambled; from each a trust-region search within the bounds (Branch, Coleman and Li, SIAM
Journal on Scientific Computing 21 (1999) 1-23, as scipy has it). Confidence is that of the linear model at the best point: s^2 (J^T J)^-1 with
Student's t, widened where residuals follow one another.
"""

from __future__ import annotations

import dataclasses
import math
import time
import tomllib
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any, Literal, get_args

import numpy as np
from numpy.typing import NDArray

from ..errors import Fault, ModelError, VfifeError
from ..model.mechanism import Mechanism
from ..modelfile import dump
from ..results.fitted import Fit, Laid, Value
from ..solvers.arguments import Arguments
from ..solvers.progress import Progress
from .asking import Together
from .confidence import confident, offset_error
from .curves import Curves, Timing, Trace, units_of
from .extent import few, length, offset_of, timing_of
from .jacobians import Ask, Point, Slopes, answers, compared, questions
from .measurements import Measured, columns_of, measured
from .misfit import Fitted, How, Misfit
from .sampling import sobol
from .sought import Sought
from .sought import parameters as understood

Array = NDArray[np.float64]
Derivatives = Literal["auto", "tangents", "differences"]
APART = 0.05  # of the diagonal of the bounds: how far apart starts lie
CLOSE = 1e-6  # relative change of cost and of the parameters at which a search ends
PATIENT, HOPELESS = 8, 30.0  # evaluations after which a search is left whose cost is so many times the best
UNSETTLED = 0.25  # of what is left, from which on turns that differ are told
MOST_SKIPPED = 100_000  # turns
MISSED = 0.25  # of the data's deviation, from which on what is left is told: ± knows of noise alone
ROUNDS = 40  # evaluations of one local search, at the most
GUESS = 8  # of them, as a search usually takes: for the progress line alone


def fit(
    mechanism: Mechanism,
    data: str | Path | Measured,
    parameters: Mapping[Any, Any] | Sequence[str],
    *,
    columns: Sequence[str] | Mapping[str, str] | None = None,
    weights: Mapping[str, float] | None = None,
    offset: str | float | tuple[Any, Any] | None = None,
    skip: float = 3.0,
    compare: How = "curve",
    width: str | float | None = None,
    step: float | str | None = None,
    screened: int = 64,
    starts: int = 4,
    confidence: float = 0.95,
    derivatives: Derivatives = "auto",
    seed: int = 0,
    workers: int | None = None,
    progress: Callable[[Progress], None] | None = None,
) -> Fit:
    """Finds numbers of a mechanism from measured curves: a CSV file with time or crank_angle and channels of a result as columns.

    ``parameters``: what is looked for, as ``{"joint.C.clearance": ("0.1 mm", "1 mm")}``, several paths in one key being one number; or texts,
    ``"joint.C.clearance=0.1..1 mm"``. ``columns`` says which column is which channel, ``{"acc": "C.force"}``, and which is only proportional to
    one, ``{"mic": "~rod.angular_acceleration"}``; ``weights`` of columns, 1 unless said: residuals are over each curve's standard deviation.

    ``offset``: where the first sample lies; "free": anywhere in a turn, after ``skip`` turns; a number or two bounds (s or rad) add to
    the places of the file. None: free over time where a crank turns, else 0. ``compare``: the curves themselves, their "envelope" (moving root
    mean square over a ``width``, a fiftieth of the data if not given) or "spectrum", where motions do not repeat. ``step`` (s): one for all,
    the finest that the model's automatic choice takes at the bounds if not given.

    ``screened`` points are run first, the best ``starts`` of them are searched from. ``derivatives``: carried along the run ("tangents"), by
    "differences" of runs in lanes, or the former where both agree. ``seed`` of the points. With Ctrl-C the best so far is returned, its status
    "interrupted".

    Raises ModelError with all faults of arguments, data and parameters, and VfifeError where no member of them has a motion.
    """
    given = Arguments("fit")
    given.mechanism(mechanism)
    for name, value in {"screened": screened, "starts": starts, "workers": workers}.items():
        given.count(name, value, optional=name == "workers")
    for name, word, words in (("compare", compare, get_args(How)), ("derivatives", derivatives, get_args(Derivatives))):
        if word not in words:
            given.fault(name, "this is none of the words", word, " or ".join(f'"{one}"' for one in words), "name one of them")
    if not 0.0 < confidence < 1.0:
        given.fault("confidence", "this is no share", confidence, "above 0 and below 1", "write 0.95 for 95 per cent")
    if not 0.0 <= skip < MOST_SKIPPED:
        given.fault("skip", "out of range", skip, f"0 to {MOST_SKIPPED:,} turns", "give fewer")
    given.callable("progress", progress)
    given.tell()
    if mechanism.settings.analysis == "static":
        raise ModelError([Fault("run.analysis", "a static analysis has no curves over time", "static", "dynamic")], mechanism.name)
    seen = data if isinstance(data, Measured) else measured(data, units_of(mechanism), columns_of(columns), weights)
    text = dump(mechanism)
    sought = understood(parameters, tomllib.loads(text), text)
    laid = offset_of(offset, seen, mechanism)
    few(seen, sought)
    timing = timing_of(mechanism, text, seen, sought, laid, skip, step)
    misfit = Misfit(seen, laid, skip, compare, length(width, seen))
    search = Search(mechanism, seen, sought, misfit, timing, derivatives, workers, progress)
    return search.run(screened, starts, seed, confidence)


class Hopeless(Exception):
    """A search that leads nowhere beside another."""


@dataclasses.dataclass
class Search:
    """A search under way, and what it has seen."""

    mechanism: Mechanism
    seen: Measured
    sought: list[Sought]
    misfit: Misfit
    timing: Timing
    derivatives: Derivatives
    workers: int | None
    progress: Callable[[Progress], None] | None

    def __post_init__(self) -> None:
        self.curves = Curves(self.mechanism, [one.channel for one in self.seen.curves], self.timing, self.workers)
        self.began, self.evaluations, self.expected = time.monotonic(), 0, 1
        self.best: tuple[float, Array, Fitted] | None = None
        self.trace: Trace | None = None
        self.reasons: list[str] = []
        self.ended: list[tuple[float, tuple[float, ...]]] = []
        self.tangents = False
        self.notes: list[str] = []

    def run(self, screened: int, starts: int, seed: int, confidence: float) -> Fit:
        """The whole search."""
        status = "complete"
        count = len(self.sought)
        self.expected = screened + starts * GUESS * (2 * count + 1)
        slopes: Slopes | None = None
        try:
            chosen = self.screen(screened, starts, seed)
            self.choose_derivatives(chosen[0])
            Together(self.answer).run([lambda ask, at=at: self.local(ask, at) for at in chosen])  # type: ignore[misc]
            assert_motion(self)
            slopes = Slopes.at(self.answer, self.misfit, self.best[1], self.best[2].offset, self.tangents)  # type: ignore[index]
        except KeyboardInterrupt:
            status = "interrupted"
        assert_motion(self)
        return self.result(status, slopes, confidence)

    def answer(self, points: Sequence[Point]) -> list[Any]:
        """What points were asked for: traces, or those to both sides by the derivatives of the steps."""
        found = answers(self.curves, self.sought, points)
        self.evaluations += len(points)
        self.tell()
        return found

    def tell(self) -> None:
        """Says where it stands."""
        if self.progress is not None:
            best = f", residual {100.0 * self.misfit_share(self.best[2]):.3g} %" if self.best is not None else ""
            done = min(self.evaluations, self.expected)
            self.progress(Progress(done, self.expected, time.monotonic() - self.began, f"{self.evaluations} runs{best}"))

    def misfit_share(self, one: Fitted) -> float:
        """Root mean square of residuals."""
        return float(np.sqrt((one.residuals**2).mean()))

    def laid(self, shares: Array, trace: Trace | str, near: float | None = None) -> Fitted | None:
        """A member laid on the samples; the best of all is kept."""
        if isinstance(trace, str):
            self.reasons.append(trace)
            return None
        found = self.misfit(trace, near)
        if math.isfinite(found.cost) and (self.best is None or found.cost < self.best[0]):
            self.best, self.trace = (found.cost, np.array(shares), found), trace
        return found

    def screen(self, count: int, starts: int, seed: int) -> list[tuple[Array, Fitted]]:
        """The best points of the sequence, and the model's own, far enough apart."""
        places = sobol(count, len(self.sought), seed)
        if all(one.here is not None for one in self.sought):
            own = [one.share(one.here) for one in self.sought if one.here is not None]
            places = np.concatenate([[own], places[: max(count - 1, 0)]])
        found: list[tuple[Array, Fitted]] = []
        size = 16
        for first in range(0, len(places), size):  # so many at once that progress is seen, and lanes are full
            some = places[first : first + size]
            traces = self.answer([Point(tuple(one)) for one in some])
            found += [(at, one) for at, trace in zip(some, traces, strict=True) if (one := self.laid(at, trace)) is not None]
        assert_motion(self)
        found.sort(key=lambda one: one[1].cost)
        chosen: list[tuple[Array, Fitted]] = []
        for at, one in found:
            if len(chosen) < starts and all(np.linalg.norm(at - other) > APART * math.sqrt(len(at)) for other, _ in chosen):
                chosen.append((at, one))
        return chosen

    def choose_derivatives(self, start: tuple[Array, Fitted]) -> None:
        """Tangents where differences of runs say the same; where they do not, an end of a contact or a far neighbour decides, and a tangent
        of one run leads nowhere.
        """
        if self.derivatives == "differences":
            return
        at, one = start
        try:
            by_steps = Slopes.at(self.answer, self.misfit, at, one.offset, True)
        except VfifeError as error:
            if self.derivatives == "tangents":
                raise
            self.notes.append(f"no derivatives were carried along: {' '.join(str(error).split())}")
            return
        self.tangents = self.derivatives == "tangents" or compared(by_steps, Slopes.at(self.answer, self.misfit, at, one.offset, False))

    def local(self, ask: Ask, start: tuple[Array, Fitted]) -> None:
        """One search from a start. A member and what its derivatives need are asked for at once: lanes have room for them."""
        from scipy.optimize import least_squares

        near, count = start[1].offset, 0
        met: dict[bytes, tuple[Array, Slopes | None]] = {}

        def at(shares: Array) -> tuple[Array, Slopes | None]:
            nonlocal near, count
            if (key := shares.tobytes()) not in met:
                trace, *beside = ask([Point(tuple(shares)), *questions(shares, self.tangents)])
                found = self.laid(shares, trace, near)
                if found is None:
                    met[key] = self.misfit.lost, None
                else:
                    near, count = found.offset, count + 1
                    met[key] = found.residuals, Slopes.of(beside, self.misfit, shares, near, self.tangents)
                    if count > PATIENT and self.best is not None and found.cost > HOPELESS * self.best[0]:
                        raise Hopeless
            return met[key]

        def jacobian(shares: Array) -> Array:
            slopes = at(shares)[1]
            return slopes.jacobian if slopes is not None else np.zeros((self.misfit.count, len(shares)))

        inside = np.clip(start[0], 1e-6, 1.0 - 1e-6)
        try:
            found = least_squares(
                lambda shares: at(shares)[0], inside, jacobian, (0.0, 1.0), "trf", ftol=CLOSE, xtol=CLOSE, gtol=1e-12, max_nfev=ROUNDS
            )
        except Hopeless:
            return
        self.ended.append((float(found.cost), tuple(float(one.value(x)) for one, x in zip(self.sought, found.x, strict=True))))

    def result(self, status: str, slopes: Slopes | None, confidence: float) -> Fit:
        """What was found."""
        if self.best is None:  # told before
            raise VfifeError("no member has a motion")
        _, shares, one = self.best
        nuisance = 2 * int(self.misfit.proportional.sum()) + (0 if self.misfit.offset.fixed and not self.misfit.offset.free else 1)
        parts = list(self.misfit.columns(one.residuals).T)
        told = confident(parts, self.sought, shares, None if slopes is None else slopes.jacobian, len(self.sought) + nuisance, confidence)
        values = [
            Value(s.name, s.paths, s.unit, s.value(float(x)), float(e), float(low), float(high), (s.low, s.high), s.here, s.logarithmic)
            for s, x, e, (low, high) in zip(self.sought, shares, told.errors, told.limits, strict=True)
        ]
        units, apart = units_of(self.mechanism), 0.0 if self.trace is None else self.misfit.unsettled(self.trace)
        if apart > UNSETTLED * max(self.misfit_share(one), 1e-3):
            said = f"the model's turns do not repeat after those that are skipped (they differ by {100.0 * apart:.2g} % of the curves' deviations)"
            remedy = "skip more, measure a motion that repeats, or give the offset from the start"
            self.notes.append(f"{said}: numbers that rule how it settles may be wrong; {remedy}")
        if (left := self.misfit_share(one)) > MISSED:
            causes = "much noise, another minimum, a motion that does not repeat, or a model that is wrong"
            said = f"the model misses the data by {100.0 * left:.3g} % of their deviation"
            self.notes.append(f"{said}, by {causes}: of these the errors know only noise")
        by = "derivatives of the steps" if self.tangents else "differences of runs"
        return Fit(
            self.mechanism.name, self.seen.name, status, values, told.correlation, told.directions, self.where(one),
            offset_error(slopes, told, self.misfit),
            self.seen.over, self.curves_of(one, units), sorted(self.ended), self.evaluations, len(self.reasons), by, told.autocorrelation,
            confidence, time.monotonic() - self.began, self.misfit.how, [*self.notes, *self.reasons[:3]],
        )  # fmt: skip

    def where(self, one: Fitted) -> float:
        """The offset; of a free one within a turn."""
        span = self.misfit.offset.high if self.seen.over == "time" else 2.0 * math.pi
        return one.offset % span if self.misfit.offset.free else one.offset

    def curves_of(self, one: Fitted, units: Mapping[str, str]) -> list[Laid]:
        """Measured and model's curves."""
        wanted, found = self.misfit.wanted, []
        over, places = self.misfit.places()
        for k, curve in enumerate(self.seen.curves):
            factor, level = (float(value) for value in one.gains[:, k])
            unit = units.get(curve.channel, "") if not curve.proportional else "1"
            found.append(Laid(curve.channel, curve.head, unit, over, places, wanted[:, k], one.values[:, k], factor, level))
        return found


def assert_motion(search: Search) -> None:
    """Raises VfifeError where no member had a motion."""
    if search.best is None and search.reasons:
        raise VfifeError(f"none of {search.evaluations} members has a motion: {search.reasons[0]}; correct the bounds")
