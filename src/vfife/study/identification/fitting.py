"""Identification: numbers of a model from measured curves, by least squares from many starts, all of whose runs go side by side in lanes.

Starts are the best of points on Sobol's sequence, scrambled; from each a trust-region search within the bounds (Branch, Coleman and Li, SIAM
Journal on Scientific Computing 21 (1999) 1-23, as scipy has it). Confidence is that of the linear model at the best point: s^2 (J^T J)^-1 with
Student's t, widened where residuals follow one another, and by what the curves change with steps and turns that nobody can know.
"""

from __future__ import annotations

import dataclasses
import hashlib
import tomllib
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any, get_args

from ...errors import Fault, ModelError
from ...model.mechanism import Mechanism
from ...modelfile import dump
from ...results.fitfile import FitFile
from ...results.fitted import Fit
from ...results.lock import Lock
from ...solvers.arguments import Arguments
from ...solvers.progress import Progress
from .concluded import Ended, concluded
from .curves import Curves, Timing, units_of
from .descents import Derivatives, Descents
from .evaluations import Evaluations, Look
from .extent import few, length, offset_of, timing_of
from .measurements import Measured, columns_of, measured
from .misfit import How, Misfit
from .sought import Sought
from .sought import parameters as understood

MOST_SKIPPED = 100_000  # turns
GUESS = 8  # evaluations that a search from one start usually takes: for forecast and progress alone


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
    file: str | Path | None = None,
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
    "differences" of runs in lanes, or the former where both agree. ``seed`` of the points. With a ``file`` every point is kept in it as it is
    known, and the same call goes on there, to the same bits. With Ctrl-C the best so far is returned, its status "interrupted".

    Raises ModelError with all faults of arguments, data and parameters, VfifeError where no member of them has a motion or the file asks something
    else, and HeldError where another process writes it.
    """
    given = Arguments("fit")
    given.callable("progress", progress)
    given.tell()
    task = planned(
        mechanism, data, parameters, columns=columns, weights=weights, offset=offset, skip=skip, compare=compare, width=width, step=step,
        screened=screened, starts=starts, confidence=confidence, derivatives=derivatives, seed=seed, workers=workers,
    )  # fmt: skip
    return task.run(file, progress)


def planned(
    mechanism: Mechanism, data: str | Path | Measured, parameters: Mapping[Any, Any] | Sequence[str], *,
    columns: Sequence[str] | Mapping[str, str] | None, weights: Mapping[str, float] | None, offset: Any, skip: float, compare: How,
    width: str | float | None, step: float | str | None, screened: int, starts: int, confidence: float, derivatives: Derivatives, seed: int,
    workers: int | None = None,
) -> Task:  # fmt: skip
    """A fit that is understood and not begun; see :func:`fit`. Raises ModelError."""
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
    return Task(mechanism, text, seen, sought, misfit, timing, screened, starts, seed, confidence, derivatives, workers)


@dataclasses.dataclass(frozen=True)
class Task:
    """A fit that is understood: what is looked for, in what, and how."""

    mechanism: Mechanism
    text: str
    seen: Measured
    sought: list[Sought]
    misfit: Misfit
    timing: Timing
    screened: int
    starts: int
    seed: int
    confidence: float
    derivatives: Derivatives
    workers: int | None

    @property
    def asked(self) -> dict[str, Any]:
        """What decides how every point fits: two fits that ask the same have points in common."""
        seen, offset, timing = self.seen, self.misfit.offset, self.timing
        numbers = hashlib.sha256(seen.places.tobytes())
        for one in seen.curves:
            numbers.update(repr((one.channel, one.head, one.proportional, one.weight)).encode() + one.values.tobytes())
        return {
            "model": self.text, "data": seen.name, "numbers": numbers.hexdigest(), "over": seen.over,
            "parameters": [[one.name, list(one.paths), one.low, one.high] for one in self.sought],
            "offset": [offset.low, offset.high, offset.free], "skip": self.misfit.skip, "compare": self.misfit.how, "window": self.misfit.window,
            "step": timing.step, "outputs": timing.outputs, "every": timing.every, "duration": timing.duration,
        }  # fmt: skip

    @property
    def how(self) -> dict[str, Any]:
        """How it is looked for: what else decides what is found."""
        return {name: getattr(self, name) for name in ("screened", "starts", "seed", "confidence", "derivatives")}

    @property
    def runs(self) -> int:
        """About so many, with derivatives by differences."""
        return self.screened + self.starts * GUESS * (2 * len(self.sought) + 1)

    def curves(self) -> Curves:
        """What makes curves of members."""
        return Curves(self.mechanism, [one.channel for one in self.seen.curves], self.timing, self.workers)

    def run(self, file: str | Path | None = None, progress: Callable[[Progress], None] | None = None, replace: bool = False) -> Fit:
        """The whole fit, or the rest of it that the file does not have; with ``replace`` what is there gives way."""
        if file is None:
            return self.found(None, progress)
        with Lock(Path(file).absolute().parent, f"{Path(file).name}.lock", "this fit"), self.opened(Path(file), replace) as kept:
            before = kept.found(self.how)
            if before is not None and before.status == "complete":
                return before
            found = self.found(kept, progress)
            kept.conclude(found, self.how)
            return found

    def opened(self, path: Path, replace: bool) -> FitFile:
        """The file of the fit. Raises VfifeError for one that asks something else."""
        return FitFile.create(path, self.asked) if replace else FitFile.going_on(path, self.asked)

    def found(self, file: FitFile | None, progress: Callable[[Progress], None] | None) -> Fit:
        """What is found, with the points of a file."""
        looked = Evaluations(self.curves(), self.sought, self.misfit, file, progress, self.runs)
        ended, slopes = Ended(), None
        try:
            descents = Descents(looked, ended, self.derivatives)
            descents.run(self.screened, self.starts, self.seed)
            if looked.best is not None:
                slopes = looked.slopes(Look(tuple(looked.best[1]), None, ended.tangents), looked.best[2])
            return concluded(self.mechanism.name, self.seen, units_of(self.mechanism), looked, ended, slopes, self.confidence)
        except KeyboardInterrupt:
            if looked.best is None:
                raise
            return concluded(self.mechanism.name, self.seen, units_of(self.mechanism), looked, ended, None, self.confidence)
