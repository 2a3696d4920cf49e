"""``vfife map``: bifurcation diagrams, Poincaré sections and basins; ``vfife waterfall``: spectra over a
number that changes from run to run, mostly over the speed of the crank.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

import typer

from ...store.schemas import MAP
from ..job import CommandJob
from ..options import (
    FIGURE_FILE,
    AnswerFileOptions,
    FileOptions,
    JobOptions,
    ModelOptions,
    argument,
    flag,
    option,
    positive,
)
from ..registry import DefaultGroup, add_command
from ..terminal import end_interrupted, sentences, tell

if TYPE_CHECKING:
    from ...model.mechanism import Mechanism
    from ...units import NumberRange


MOST_VALUES, MOST_STARTS, MOST_TURNS, MOST_SECTION = 10_000, 2_000, 1_000_000, 10_000_000
GRID = (
    "A number of the start or of the model, from and to; twice, as in start.pin.x=-0.2..0.2mm,"
    " start.crank=0..360deg, joint.pin.clearance=0.1..1mm."
)
START = (
    'Begin every value anew: "own", or numbers of a start, as in "start.crank=90deg, start.pin.x=0.1mm"; may'
    " be repeated."
)
DROP = "Number of turns that are discarded."
SERIES = "penetration, force_max of a joint with clearance; else a place or speed"
FINEST = "the finest that a run finds at the ends and in the middle"


class MapOptions(AnswerFileOptions, ModelOptions, JobOptions):
    """What every command of maps takes."""

    target: Path | None = option(
        None, "Where to keep it.", "FILE.map", "-o", "--output", show_default="runs/MODEL.map"
    )
    figure: Path | None = option(None, "The picture.", FIGURE_FILE, show_default="FILE.png")

    def make(
        self, kind: str, ending: str, first_look: str, compute: Callable[..., Any], **style: Any
    ) -> None:
        """Compute a map of a ``kind`` into a file, draw it and describe it; ends with a sentence and an exit
        code where that cannot be.

        ``ending``: of its file's name, after that of the model; ``first_look``: options for less; ``style``:
        arguments of its figure.
        """
        with sentences(str(self.model)):
            place = self.answer_file(MAP, self.model, kind, ending)
            mechanism = self.mechanism()
        job = CommandJob(kind, place, self, first_look=first_look)
        with job.at_work(str(self.model)):
            result = compute(mechanism, file=place, progress=job)
        self.write_files(result, lambda: result.plot(**style))
        from ...report.dynamics import document

        self.answer(document(result), place, self.figure, self.csv)
        if result.done < result.planned:
            count = f"{result.done:,} of {result.planned:,} {result.noun}"
            end_interrupted(f": {count} are complete and kept in {place}; the same command goes on.")


class OrbitOptions(MapOptions):
    """What is looked at once a turn."""

    of: list[str] | None = option(None, "What is looked at once a turn.", "SERIES", show_default=SERIES)
    phase: float = option(0.0, "How far beyond its start the crank is looked at.", "DEG", min=0.0, max=360.0)
    step: str | None = option(
        None, "Time step; a turn has a whole number of them.", "TIME", show_default=FINEST
    )
    turns: int
    drop: int | None

    def arguments(self) -> dict[str, Any]:
        """Arguments that all maps have. Raises ValueError where no turn is left to look at."""
        turns, drop = self.turns, self.drop
        if drop is not None and drop >= turns:
            allowed = f"allowed: 0 to {turns - 1}, fewer of them are dropped then"
            raise ValueError(f"--drop {drop}: no turn is left to look at of --turns {turns}; {allowed}")
        shared = {"series": self.of or (), "phase": self.phase / 360.0}
        return {**shared, "turns": turns, "dropped": drop, "step": positive("--step", self.step, "s")}


class MapGroup(DefaultGroup):
    """The commands of maps. What is no command is a model, over whose number a map is made."""

    default = "sweep"


map_ = typer.Typer(
    cls=MapGroup,
    no_args_is_help=True,
    help=(
        "What becomes of a motion: vfife map MODEL --over PATH=LOW..HIGH sweeps a number up and down, draws a"
        " bifurcation diagram and says where the motion is periodic and where chaotic; commands look at one"
        " motion once a turn and at its impacts, and at many starts. What is known is kept in one file; after"
        " a kill the same command goes on."
    ),
    epilog=(
        "From which clearance on is it chaotic? vfife new slider-crank -o my.toml, then vfife map my.toml "
        "--over"
        " joint.pin.clearance=0.1..1mm"
    ),
)


class SweepOptions(OrbitOptions):
    """Options of ``vfife map sweep``."""

    over: str = option(
        ...,
        "The number, from and to, as in joint.pin.clearance=0.1..1mm.",
        "PATH=LOW..HIGH",
        show_default=False,
    )
    count: int = option(60, "Values of it, up and down again.", "N", min=2, max=MOST_VALUES)
    turns: int = option(90, "Turns at each value.", "N", min=1, max=MOST_TURNS)
    drop: int | None = option(None, DROP, "N", min=0, show_default="two thirds of them")
    start: list[str] | None = option(
        None, START, "own|PATH=VALUE,...", show_default="the state is carried on"
    )
    companions: int = option(5, "So many values again with a coarser and a finer step.", "N", min=0)


def sweep(options: SweepOptions) -> None:
    """Bifurcation diagram: a number swept up and down while the motion goes on, looked at once a turn, with
    the largest Lyapunov exponent.

    The state is carried on from value to value, so that motions which live beside each other are told apart;
    with --start every value begins anew. After Ctrl-C or a kill the same command goes on. `sweep` itself may
    be left out.
    """

    def compute(mechanism: Mechanism, **job: Any) -> Any:
        from ...dynamics.bifurcation import bifurcation
        from ...dynamics.start_states import start_numbers

        path, low, high, _ = number_range(mechanism, options.over)
        starts = [start_numbers(mechanism, text) for text in options.start or ()]
        shared: dict[str, Any] = {"count": options.count, "starts": starts, "companions": options.companions}
        return bifurcation(mechanism, path, low, high, **shared, **options.arguments(), **job)

    options.make("map", ".map", "--count 30 --turns 45", compute)


class SectionOptions(OrbitOptions):
    """Options of ``vfife map section``."""

    turns: int = option(300, "Turns.", "N", min=1, max=MOST_SECTION)
    drop: int | None = option(None, DROP, "N", min=0, show_default="a third of them")
    impacts: list[str] | None = option(
        None, "Look at every contact that begins in it.", "JOINT", show_default="all with clearance"
    )


def section(options: SectionOptions) -> None:
    """Poincaré section of one motion: once a turn, and at every impact; what it is (period, quasi-periodic,
    chaotic) and what says so.

    At impacts: where on the bearing, how fast and at which angle of the crank a contact begins, located
    inside the step. After Ctrl-C or a kill the same command goes on.
    """

    def compute(mechanism: Mechanism, **job: Any) -> Any:
        from ...dynamics.sections import poincare_section

        joints = tuple(mechanism.contacts) if options.impacts is None else tuple(options.impacts)
        return poincare_section(mechanism, joints=joints, **options.arguments(), **job)

    options.make("map", "-section.map", "--turns 90", compute)


class BasinsOptions(OrbitOptions):
    """Options of ``vfife map basins``."""

    over: list[str] = option(..., GRID, "PATH=LOW..HIGH", show_default=False)
    count: str = option("16", "Values of each.", "N[xM]")
    turns: int = option(60, "Turns of each start.", "N", min=1, max=MOST_TURNS)
    drop: int | None = option(None, DROP, "N", min=0, show_default="two thirds of them")
    exponents: bool = flag(
        "--exponents/--no-exponents", "Watch a small difference, by which chaos is told.", default=True
    )
    companions: int = option(5, "So many starts again with a coarser and a finer step.", "N", min=0)


def basins(options: BasinsOptions) -> None:
    """Basins: a grid of two numbers of the start (crank angle, journal's place and velocity in its bearing)
    or of the model, coloured by motion.

    Cases belong to one motion where their points of once a turn agree. After Ctrl-C or a kill the same
    command goes on.
    """

    def compute(mechanism: Mechanism, **job: Any) -> Any:
        from ...dynamics.basins import basins as basins_of

        if len(options.over) != 2:
            how = "name two numbers, as in --over start.pin.x=-0.2..0.2mm --over start.pin.y=-0.2..0.2mm"
            raise ValueError(f"--over: this is given {len(options.over)} times; {how}")
        x, y = (number_range(mechanism, text, starts=True)[:3] for text in options.over)
        shared: dict[str, Any] = {
            "count": counts(options.count),
            "exponents": options.exponents,
            "companions": options.companions,
        }
        return basins_of(mechanism, x, y, **shared, **options.arguments(), **job)

    options.make("map", "-basins.map", "--count 10 --turns 30", compute)


class ShowOptions(FileOptions):
    """Options of ``vfife map show``."""

    file: Path = argument("What a map was kept in.", "FILE.map")
    figure: Path | None = option(None, "The picture.", FIGURE_FILE)

    @property
    def inputs(self) -> tuple[Path, ...]:
        """Input files, which no output may replace."""
        return (self.file,)


def show(options: ShowOptions) -> None:
    """Show the results of a map, a section, basins or a waterfall so far, from their file, with a figure and
    a table.
    """
    with sentences(str(options.file)):
        from ...dynamics import load_map

        options.refuse_files()
        result = load_map(options.file)
    options.write_files(result)
    from ...report.dynamics import document

    options.answer(document(result), options.file, options.figure, options.csv)


for command in (sweep, section, basins, show):
    add_command(map_, command)


# ------------------------------------------------------------------------------------------- texts of options


def number_range(mechanism: Mechanism, text: str, starts: bool = False) -> NumberRange:
    """Return a number of the model, or of a start too (``starts``), with its range (SI): PATH=LOW..HIGH.
    Raises ValueError.
    """
    from ...dynamics.maps import unit_at
    from ...dynamics.start_states import unit_of_start
    from ...units import in_rpm, is_bare
    from ...units import number_range as parsed

    unit_of = unit_of_start if starts else unit_at
    one = parsed(text, lambda path: unit_of(mechanism, path), "--over", "joint.C.clearance=0.1..1mm")
    span = text.partition("=")[2].strip()
    if one.unit not in ("1", "") and all(map(is_bare, span.split(".."))):
        speeds = f", {in_rpm(one.low)} to {in_rpm(one.high)}" if one.unit == "rad/s" else ""
        other = {"rad/s": "rpm", "m": "mm"}.get(one.unit, one.unit)
        tell(
            "caution",
            f"--over {text}: numbers without a unit are in {one.unit}{speeds}; is {span}{other} meant?",
        )
    return one


def counts(text: str) -> tuple[int, int]:
    """Return the numbers of values of both numbers of a grid. Raises ValueError."""
    grid = text.split("x")
    if len(grid) > 2 or not all(map(str.isdecimal, grid)):
        raise ValueError(f"--count {text}: allowed: a whole number, or two as in 40x30")
    first, second = int(grid[0]), int(grid[-1])
    if not all(2 <= one <= MOST_STARTS for one in (first, second)):
        raise ValueError(f"--count {text}: allowed: 2 to {MOST_STARTS} values of each")
    return first, second


class WaterfallOptions(MapOptions):
    """Options of ``vfife waterfall``."""

    over: str = option(
        ...,
        "The number, from and to, as in driver.crank.speed=500..3000rpm.",
        "PATH=LOW..HIGH",
        show_default=False,
    )
    count: int = option(50, "Values of it, a run each.", "N", min=2, max=10_000)
    turns: int = option(12, "Turns of each run.", "N", min=1, max=1_000_000)
    last: int | None = option(
        None,
        "Number of last turns that are transformed: orders are 1/N apart.",
        "N",
        min=1,
        show_default="4, or all of fewer turns",
    )
    of: list[str] | None = option(
        None, "Series, as C.force.", "SERIES", show_default="forces of joints with clearance"
    )
    outputs: int = option(
        1440, "Samples in a turn; what is faster than half of them is folded back.", "N", min=8
    )
    highest: float = option(50.0, "Highest order that is kept.", "ORDER")
    window: str = option("hann", "hann, hamming, blackman, flat-top or rectangular.", "NAME")
    hertz: bool = flag("--hertz", "Draw frequencies instead of orders.")
    step: str | None = option(None, "Time step.", "TIME", show_default="the finer automatic one of both ends")
    target: Path | None = option(
        None, "Where to keep it.", "FILE.waterfall", "-o", "--output", show_default="runs/MODEL.waterfall"
    )
    figure: Path | None = option(None, "The picture.", FIGURE_FILE, show_default="FILE-waterfall.png")


def waterfall(options: WaterfallOptions) -> None:
    """Waterfall: spectra over a number, mostly the crank's speed, by orders of the crank; a run each, side by
    side on all cores.

    Every run begins at the model's own start. After Ctrl-C or a kill the same command goes on with the runs
    that are missing.
    """

    def compute(mechanism: Mechanism, **job: Any) -> Any:
        from ...dynamics.waterfall import waterfall as waterfall_of

        path, low, high, _ = number_range(mechanism, options.over)
        shared = {
            name: getattr(options, name)
            for name in ("count", "turns", "last", "outputs", "highest", "window")
        }
        step = positive("--step", options.step, "s")
        return waterfall_of(mechanism, path, low, high, series=options.of or (), step=step, **shared, **job)

    options.make("waterfall", ".waterfall", "--count 20", compute, hertz=options.hertz)
