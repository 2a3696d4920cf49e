"""What a fit will cost before it is begun: about so many runs, of as many steps as the data are long."""

from __future__ import annotations

import os
from pathlib import Path
from typing import TYPE_CHECKING, Any

from .terminal import STORAGE, amount_of_bytes, counted, fail, sentences, span, tell

if TYPE_CHECKING:
    from ..study.identification.fitting import Task

LAID = 2e-6  # s that a sample of a curve takes, laid on a run at all offsets that are tried
PACKED = 0.9  # of the bytes of numbers


def forecast(task: Task, place: Path) -> dict[str, Any]:
    """Runs that are left, those that are kept, steps of each, seconds, bytes; estimates, and called so. Raises VfifeError as assembling does."""
    import numpy as np

    from ..codegen.native import stream_lanes
    from ..files import free_bytes
    from ..job.cost import LIBRARIES, RECORD_COPIES, run_cost
    from ..study.identification.sought import numbers_at
    from .forecast import MADE, SHARED

    one = task.curves().members.assembled(numbers_at(task.sought, np.full(len(task.sought), 0.5)))
    alone, cores, lanes = run_cost(one), os.cpu_count() or 1, stream_lanes(len(one.topology.contact_bearing))
    kept = known(task, place)
    left = max(task.runs - kept, 0)
    values, at_once = task.misfit.count, task.starts * (2 * len(task.sought) + 1)
    free = free_bytes(place)
    return {
        "members": left, "kept": kept, "steps": one.choice.steps, "workers": cores, "lanes": lanes,
        "seconds": left * (alone.seconds / min(cores * max(1.0, SHARED * lanes), at_once) + MADE + LAID * values),
        "bytes": int(PACKED * 8 * values * left), "free": float("inf") if free is None else free,
        "memory": RECORD_COPIES * alone.bytes * min(cores * lanes, task.runs) + LIBRARIES,
    }  # fmt: skip


def known(task: Task, place: Path) -> int:
    """Runs that a fit file has of the same question; as good as all where it was answered."""
    from ..errors import VfifeError
    from ..results.fitfile import FitFile

    if not place.exists():
        return 0
    try:
        with FitFile.open(place) as file:
            return task.runs if file.fit(task.how) is not None else len(file.keys("looks"))
    except VfifeError:  # told when it is gone on with
        return 0


def told_of(task: Task, place: Path, force: bool, yes: bool, quiet: bool) -> None:
    """The forecast, and the end of what nobody can mean."""
    from ..job.cost import Forecast

    with sentences(str(place)):
        found = forecast(task, Path(os.devnull) if force else place)
    said = f"{counted(found['members'], 'run')} of {found['steps']:,} steps"
    much = Forecast("run", seconds=found["seconds"], memory=found["memory"], disk=found["bytes"]).excess(place)
    if much and found["bytes"] > found["free"]:
        fail(f"{place}: this fit takes {much}, for {said}. Nothing was begun, and nothing is touched.", STORAGE)
    if much and not yes:
        remedy = "add --yes if that is meant, or give fewer points (--screened, --starts), a shorter piece of the data or a coarser --step"
        fail(f"this fit takes {much}, for {said}; {remedy}. Nothing was begun.")
    if quiet or not found["members"]:
        return
    beside = f" beside {found['kept']:,} that are there" if found["kept"] else ""
    tell(
        "forecast",
        f"about {said}{beside}: {span(found['seconds'])} with {counted(found['workers'], 'thread')} of {found['lanes']} lanes, "
        f"{amount_of_bytes(found['bytes'])} in {place}; up to four times that where what is left is no noise.",
        "bold",
    )
