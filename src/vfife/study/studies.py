"""How the answer moves: one mechanism with many numbers, from a study file or from Python, kept in one study file."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import Any

from ..errors import Fault, ModelError, kind_of, shown
from ..model.mechanism import Mechanism
from ..modelfile import load
from ..modelfile.read import raw_of, text_of
from ..modelfile.tables import Raw
from ..results.lock import Lock
from ..results.studied import Study
from .carry import Runner, carry_out, opened, read_back
from .cluster import elsewhere, joined
from .plan import Plan
from .planfile import of_mapping, understood
from .repetition import repeat_sample

ENDING = ".study"


def study(
    model: str | Path | Mechanism,
    vary: Mapping[str, Any] | None = None,
    measures: str | Iterable[str] | None = None,
    *,
    file: str | Path | None = None,
    force: bool = False,
    workers: int | None = None,
    lanes: int | None = None,
    cluster: str | None = None,
    device: str | None = None,
    retry: bool = False,
    progress: Callable[[int, int], None] | None = None,
    **more: Any,
) -> Study:
    """Runs a mechanism once for every choice of some of its numbers, and gives what was wanted of each run.

    >>> vfife.study(model, {"joint.C.clearance": ["0.1 mm", "0.2 mm"]}, ["C.force.max"], turns=10).data  # doctest: +SKIP

    ``model``: a mechanism, a model file, or alone the path of a study file. ``vary``: by path a list of values, or by any name a table as a study
    file has it (``path``, ``values``, ``from`` and ``to`` ...). ``measures``: names of measures, or max, min, mean, rms, range of a channel, as in
    "mean(C.force)". ``more`` are the other keys of a study file: ``turns``, ``settle``, ``last``, ``step``, ``method``, ``count``, ``seed``,
    ``set``; counts and depths of landings, speeds of approach and shares of contact are of the whole run, whatever ``last`` is. ``file``: the study
    file to keep it in; what is in it already is not computed again, and where another study is there it gives way to ``force`` alone. ``workers``,
    ``lanes``: threads, and members side by side in each; ``cluster``: "local", for processes in their place, or the address of a scheduler of
    dask.distributed; ``device``: "cuda" steps them on an NVIDIA card; ``retry``: members that failed before are tried again. ``progress`` hears how
    many of how many members have ended. Ctrl-C ends it with what has. Raises ModelError with all faults, HeldError where another process writes the
    file, StorageError where it cannot be written, DeviceError for a card that cannot be used.
    """
    plan, base, name = asked_in_python(model, vary, measures, more)
    run = elsewhere(cluster, device)
    if file is None:
        with tempfile.TemporaryDirectory() as folder:
            found = made(Path(folder) / f"s{ENDING}", plan, base, name, force, workers, lanes, progress, cluster, run, retry)
        found.path = None
        return found
    return made(Path(file), plan, base, name, force, workers, lanes, progress, cluster, run, retry)


def made(
    path: Path,
    plan: Plan,
    base: Mechanism,
    name: str,
    force: bool = False,
    workers: int | None = None,
    lanes: int | None = None,
    progress: Callable[[int, int], None] | None = None,
    cluster: str | None = None,
    otherwise: Runner | None = None,
    retry: bool = False,
) -> Study:
    """A plan carried out into its file."""
    told = None if progress is None else lambda done, of, _: progress(done, of)
    with locked(path), joined(cluster, workers, otherwise) as runner, opened(path, plan, base, name, replace=force) as file:
        if carry_out(file, base, workers=workers, lanes=lanes, told=told, runner=runner, retry=retry):
            repeat_sample(file, base, workers=workers, lanes=lanes, runner=runner)
        return read_back(file)


def locked(path: Path) -> Lock:
    """The right to write a study file. Raises HeldError."""
    return Lock(path.absolute().parent, f"{path.name}.lock", "this study")


def asked_in_python(model: Any, vary: Any, measures: Any, more: Mapping[str, Any]) -> tuple[Plan, Mechanism, str]:
    """The plan of the arguments. Raises ModelError with all faults."""
    tables, known_as, folder, mechanism, name = written(model, vary, measures, more, "study()")
    plan, base = understood(tables, known_as, folder, mechanism)
    return plan, base, name or base.name


def written(model: Any, vary: Any, measures: Any, more: Mapping[str, Any], caller: str) -> tuple[Raw, str, Path | None, Mechanism | None, str]:
    """The arguments as the tables of a study file, what these are known as, their folder, the model where it is at hand, the name of a file.
    Raises ModelError."""
    if vary is None and measures is None and isinstance(model, str | os.PathLike):
        if more:
            fault = Fault(
                next(iter(more)), "a study file says this itself", shown(next(iter(more.values()))), "", "leave it out, or change the file"
            )
            raise ModelError([fault], caller)
        path = Path(model)
        return raw_of(text_of(path), str(path)), str(path), path.parent, None, path.stem
    if not isinstance(model, str | os.PathLike | Mechanism):
        fault = Fault("model", f"this is {kind_of(model)}", shown(model), "a Mechanism, or a model file", "make one, or name a file")
        raise ModelError([fault], caller)
    base = model if isinstance(model, Mechanism) else load(Path(model))
    named = [measures] if isinstance(measures, str) else None if measures is None else list(measures)
    raw = of_mapping({"measures": named, "vary": dict(vary) if isinstance(vary, Mapping) else vary, **more})
    return raw, caller, None, base, ""
