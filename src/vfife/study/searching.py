"""Searches from Python: parameters with which measures are least, and the cheapest fits; their members are those of a study."""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeVar

from ..model.mechanism import Mechanism
from ..results.studied import Study
from .carry import read_back
from .cluster import elsewhere, joined
from .growing import BrokenOff, Growing, grown
from .optimise import Found, best, imported
from .plan import Plan
from .quantiles import Estimate
from .searches import allotment_of, allotted, optimised, search_of
from .studies import ENDING, locked, written

Work = TypeVar("Work")


@dataclass(frozen=True)
class Optimum:
    """What a search came to: ``best``, the one best member or the Pareto front of several measures, the best of the first measure first, and empty
    where none keeps the limits; every one of its ``members`` in order; the ``study`` that they are kept in; how many of the last members
    derivatives led to (``refined``), and ``why`` there are no more of these, where they did not come to an end. Numbers are in SI units."""

    best: tuple[Found, ...]
    members: tuple[Found, ...]
    study: Study
    refined: int = 0
    why: str = ""


@dataclass(frozen=True)
class Allocation:
    """The cheapest fits by parameter and what they ``cost`` (None where no choice keeps the limit), the ``quantile`` of the measure with them,
    ``failures`` of so many ``machines`` tried, the choices ``rejected`` that are as cheap or cheaper, and the ``study`` of all members."""

    fits: Mapping[str, str] | None
    cost: float | None
    quantile: Estimate | None
    failures: int
    machines: int
    rejected: tuple[tuple[Mapping[str, str], float], ...]
    study: Study


def optimise(
    model: str | Path | Mechanism,
    vary: Mapping[str, Any] | None = None,
    measures: str | Iterable[str] | None = None,
    *,
    file: str | Path | None = None,
    force: bool = False,
    workers: int | None = None,
    cluster: str | None = None,
    device: str | None = None,
    progress: Callable[[int], None] | None = None,
    **more: Any,
) -> Optimum:
    """Looks for the parameters with which measures are least, or largest, within limits: min f(x) with low ≤ g(x) ≤ high; of several f the Pareto
    front. One f is searched by tree-structured Parzen estimators, several by NSGA-II (optuna, extra ``optimise``); from the best of one f on
    derivatives of the run lead to at most ``refine`` members more (SLSQP), where the measures have any.

    >>> vfife.optimise(model, {"play": {"path": "joint.C.clearance", "from": "0.1 mm", "to": "0.5 mm"}}, ["C.force.max", "C.impacts"],
    ...     optimise={"minimise": ["C.force.max"], "members": 100}, limit={"C.impacts": 40}).best  # doctest: +SKIP

    ``model``, ``vary`` and ``measures`` as of :func:`vfife.study`, or alone the path of a study file; every parameter has ``from`` and ``to``, or
    ``values``. ``more`` are the other keys of a study file: ``optimise`` (``minimise``, ``maximise``, ``members``, ``seed``, ``batch``,
    ``refine``), ``limit`` (by measure the most allowed, or ``low`` and ``high``), ``turns``, ``settle``, ``last``, ``step``, ``set``. Numbers are
    in SI units, texts have theirs. ``file`` keeps the members, and the same search goes on after what it has; ``force`` replaces another study
    there. ``workers``, ``cluster``, ``device``: where members run. ``progress`` hears how many members have been computed.

    Raises ModelError with all faults, VfifeError without optuna or where another study is in the file, HeldError, StorageError, DeviceError;
    KeyboardInterrupt after Ctrl-C, what ended being kept in ``file``.
    """
    tables, known_as, folder, base, name = written(model, vary, measures, more, "optimise()")
    plan, base, search = search_of(tables, known_as, folder, base)
    imported()
    (found, last), study = kept(
        file, plan, base, name, lambda grow: optimised(grow, plan, search, base), force=force, workers=workers, cluster=cluster, device=device,
        progress=progress,
    )  # fmt: skip
    return Optimum(tuple(best(search, found)), tuple(found), study, len(last.members), last.why)


def allocate(
    model: str | Path | Mechanism,
    vary: Mapping[str, Any] | None = None,
    measures: str | Iterable[str] | None = None,
    *,
    file: str | Path | None = None,
    force: bool = False,
    workers: int | None = None,
    cluster: str | None = None,
    device: str | None = None,
    progress: Callable[[int], None] | None = None,
    **more: Any,
) -> Allocation:
    """Looks for the cheapest fits with which a measure keeps its limit in a share of all machines: min Σ cost with P(y ≤ limit) ≥ share.

    >>> vfife.allocate("crank.toml").fits  # doctest: +SKIP

    Arguments as of :func:`vfife.optimise`; every parameter has a fit, a tolerance or a distribution, and ``more`` has ``allocation`` (``measure``,
    ``share``, ``confidence``, ``count``, ``seed``), ``cost`` (by parameter a cost for each grade, as in {"IT7": 5}, or for each fit, as in
    {"H8/f7": 7.5}) and ``limit`` (of the measure, a number in SI units or a text). Choices are tried from the cheapest on with the same
    ``machines`` drawn for all. One is taken when at most k of n are beyond the limit, k the most with P(B ≤ k) ≤ 1 - confidence for B binomial of
    n and 1 - share; so of none beyond it n is 299 for 99 % with 95 %.

    Raises what :func:`vfife.optimise` raises, but needs no optuna.
    """
    tables, known_as, folder, base, name = written(model, vary, measures, more, "allocate()")
    plan, base, task = allotment_of(tables, known_as, folder, base)
    found, study = kept(
        file, plan, base, name, lambda grow: allotted(grow, task), force=force, workers=workers, cluster=cluster, device=device,
        progress=progress,
    )  # fmt: skip
    chosen, rejected = found.choice, tuple((task.chosen(one), one.cost) for one in found.rejected)
    cheapest, cost = (None, None) if chosen is None else (task.chosen(chosen), chosen.cost)
    return Allocation(cheapest, cost, found.estimate, found.failures, found.count, rejected, study)


def kept(
    file: str | Path | None,
    plan: Plan,
    base: Mechanism,
    name: str,
    work: Callable[[Growing], Work],
    *,
    force: bool,
    workers: int | None,
    cluster: str | None,
    device: str | None,
    progress: Callable[[int], None] | None,
) -> tuple[Work, Study]:
    """What a search comes to, and the study of its members, which are kept in a file where there is one to be."""
    run = elsewhere(cluster, device)
    if file is None:
        with tempfile.TemporaryDirectory() as folder:
            found, study = kept(
                Path(folder) / f"s{ENDING}", plan, base, name, work, force=force, workers=workers, cluster=cluster, device=device, progress=progress
            )
        study.path = None
        return found, study
    told = None if progress is None else lambda done, of, outcome: progress(done)
    path = Path(file)
    with locked(path), joined(cluster, workers, run) as runner, grown(path, plan, base, name or base.name, replace=force) as members:
        try:
            found = work(Growing(members, base, workers=workers, runner=runner, told=told))
        except BrokenOff:
            raise KeyboardInterrupt from None
        return found, read_back(members)
