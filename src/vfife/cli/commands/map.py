"""``vfife map``: bifurcation diagrams, Poincaré sections and basins; ``vfife waterfall``: spectra over a
number that changes from run to run, mostly over the speed of the crank.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from ...dynamics import load_map
from ...dynamics.basins import basins as basins_of
from ...dynamics.bifurcation import bifurcation
from ...dynamics.maps import unit_at
from ...dynamics.sections import poincare_section
from ...dynamics.start_states import start_numbers, unit_of_start
from ...dynamics.waterfall import waterfall as waterfall_of
from ...model.mechanism import Mechanism
from ...report.dynamics import document
from ...store.lock import Lock
from ...store.schemas import MAP
from ...units import NumberRange, ends_of, in_rpm, is_bare
from ...units import number_range as parsed
from ..arguments.analyses import (
    MOST_STARTS,
    BasinsOptions,
    MapOptions,
    OrbitOptions,
    SectionOptions,
    ShowOptions,
    SweepOptions,
    WaterfallOptions,
)
from ..job import CommandJob
from ..terminal import end_interrupted, sentences, tell
from ..values import mechanism_of, positive, separated


def sweep(options: SweepOptions) -> None:
    """Run ``vfife map sweep``."""

    def compute(mechanism: Mechanism, **job: Any) -> Any:
        path = number_range(mechanism, options.over).path
        low, high = ends_of(options.over.partition("=")[2].strip()) or ("", "")
        starts = [start_numbers(mechanism, text) for text in options.start or ()]
        shared: dict[str, Any] = {"count": options.count, "starts": starts, "companions": options.companions}
        return bifurcation(mechanism, path, low, high, **shared, **run_arguments(mechanism, options), **job)

    make_map(options, "map", ".map", "--count 30 --turns 45", compute)


def section(options: SectionOptions) -> None:
    """Run ``vfife map section``."""

    def compute(mechanism: Mechanism, **job: Any) -> Any:
        joints = tuple(mechanism.contacts) if options.impacts is None else tuple(options.impacts)
        return poincare_section(mechanism, joints=joints, **run_arguments(mechanism, options), **job)

    make_map(options, "map", "-section.map", "--turns 90", compute)


def basins(options: BasinsOptions) -> None:
    """Run ``vfife map basins``."""

    def compute(mechanism: Mechanism, **job: Any) -> Any:
        if len(options.over) != 2:
            advice = "name two numbers, as in --over start.pin.x=-0.2..0.2mm --over start.pin.y=-0.2..0.2mm"
            raise ValueError(f"--over: given {len(options.over)} times; {advice}")
        x, y = (number_range(mechanism, text, starts=True)[:3] for text in options.over)
        shared: dict[str, Any] = {
            "count": counts(options.count),
            "exponents": options.exponents,
            "companions": options.companions,
        }
        return basins_of(mechanism, x, y, **shared, **run_arguments(mechanism, options), **job)

    make_map(options, "map", "-basins.map", "--count 10 --turns 30", compute)


def show(options: ShowOptions) -> None:
    """Run ``vfife map show``."""
    with sentences(str(options.file)):
        options.refuse_files()
        result = load_map(options.file)
    options.write_files(result)
    options.answer(document(result), options.file, options.figure, options.csv)


# ------------------------------------------------------------------------------------------- texts of options


def number_range(mechanism: Mechanism, text: str, starts: bool = False) -> NumberRange:
    """Return a number of the model, or of a start too (``starts``), with its range (SI): PATH=LOW..HIGH.
    Raises ValueError.
    """
    unit_of = unit_of_start if starts else unit_at
    limits = parsed(text, lambda path: unit_of(mechanism, path), "--over", "joint.C.clearance=0.1..1mm")
    span = text.partition("=")[2].strip()
    if limits.unit not in ("1", "") and all(map(is_bare, span.split(".."))):
        speeds = f", {in_rpm(limits.low)} to {in_rpm(limits.high)}" if limits.unit == "rad/s" else ""
        likely_unit = {"rad/s": "rpm", "m": "mm"}.get(limits.unit, limits.unit)
        tell(
            "caution",
            f"--over {text}: numbers without a unit are in {limits.unit}{speeds};"
            f" is {span}{likely_unit} meant?",
        )
    return limits


def counts(text: str) -> tuple[int, int]:
    """Return the numbers of values of both numbers of a grid. Raises ValueError."""
    grid = text.split("x")
    if len(grid) > 2 or not all(map(str.isdecimal, grid)):
        raise ValueError(f"--count {text}: allowed: a whole number, or two as in 40x30")
    first, second = int(grid[0]), int(grid[-1])
    if not all(2 <= count <= MOST_STARTS for count in (first, second)):
        raise ValueError(f"--count {text}: allowed: 2 to {MOST_STARTS} values of each")
    return first, second


def waterfall(options: WaterfallOptions) -> None:
    """Run ``vfife waterfall``."""

    def compute(mechanism: Mechanism, **job: Any) -> Any:
        path, low, high, _ = number_range(mechanism, options.over)
        shared = {
            name: getattr(options, name)
            for name in ("count", "turns", "last", "outputs", "highest", "window")
        }
        step = positive("--step", options.step, "s")
        names = tuple(separated(options.of, mechanism))
        return waterfall_of(mechanism, path, low, high, series=names, step=step, **shared, **job)

    make_map(options, "waterfall", ".waterfall", "--count 20", compute, hertz=options.hertz)


def make_map(
    options: MapOptions, kind: str, ending: str, first_look: str, compute: Callable[..., Any], **style: Any
) -> None:
    """Compute a map of a ``kind`` into a file, draw it and describe it; ends with a sentence and an exit
    code where that cannot be.

    ``ending``: of its file's name, after that of the model; ``first_look``: options for less; ``style``:
    arguments of its figure.
    """
    with sentences(str(options.model)):
        place = options.answer_file(MAP, options.model, kind, ending)
        mechanism = mechanism_of(options)
        if options.force:
            with Lock(place.absolute().parent, f"{place.name}.lock", "this map"):
                place.unlink(missing_ok=True)
    job = CommandJob(kind, place, options, first_look=first_look)
    with job.at_work(str(options.model)):
        result = compute(mechanism, file=place, progress=job)
    options.write_files(result, lambda: result.plot(**style))
    options.answer(document(result), place, options.figure, options.csv)
    if result.done < result.planned:
        count = f"{result.done:,} of {result.planned:,} {result.noun}"
        end_interrupted(f": {count} are complete and kept in {place}; the same command continues.")


def run_arguments(mechanism: Mechanism, options: OrbitOptions) -> dict[str, Any]:
    """Arguments that all maps have. Raises ValueError where no turn is left to look at."""
    turns, drop = options.turns, options.drop
    if drop is not None and drop >= turns:
        allowed = f"allowed: 0 to {turns - 1}, fewer of them are dropped then"
        raise ValueError(f"--drop {drop}: no turn of --turns {turns} remains; {allowed}")
    shared = {"series": tuple(separated(options.of, mechanism)), "phase": options.phase / 360.0}
    return {**shared, "turns": turns, "dropped": drop, "step": positive("--step", options.step, "s")}
