"""``vfife map``: bifurcation diagrams, Poincaré sections and basins."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import typer

from ..job import RUNS, CommandJob
from ..options import (
    FIGURE_FILE,
    TABLE_FILE,
    ModelOptions,
    Options,
    QuietOptions,
    argument,
    flag,
    option,
    positive,
)
from ..outputs import figure_path, refuse_inputs, write_files
from ..registry import DefaultGroup, add_command
from ..terminal import answer, end_interrupted, print_line, sentences, tell

if TYPE_CHECKING:
    from ...model.mechanism import Mechanism

MOST_VALUES, MOST_STARTS, MOST_TURNS, MOST_SECTION = 10_000, 2_000, 1_000_000, 10_000_000
GRID = (
    "A number of the start or of the model, from and to; twice, as in start.pin.x=-0.2..0.2mm,"
    " start.crank=0..360deg, joint.pin.clearance=0.1..1mm."
)
START = (
    'Begin every value anew: "own", or numbers of a start, as in "start.crank=90deg, start.pin.x=0.1mm"; may'
    " be repeated."
)
DROP = "So many of them are not looked at."
SERIES = "penetration, force_max of a joint with clearance; else a place or speed"
FINEST = "the finest that a run finds at the ends and in the middle"


class MapFileOptions(Options):
    """Where a map, its figure and its table are kept."""

    target: Path | None = option(
        None, "Where to keep it.", "FILE.map", "-o", "--output", show_default="runs/MODEL.map"
    )
    figure: Path | None = option(None, "The picture.", FIGURE_FILE, show_default="FILE.png")
    csv: Path | None = option(None, "All points as a table.", TABLE_FILE)


class MapJobOptions(QuietOptions):
    """Confirmation of long work."""

    yes: bool = flag("--yes", "Make it whatever it takes: hours, or half the disk.")


class MapOptions(MapFileOptions, ModelOptions, MapJobOptions):
    """What every command of maps takes."""

    def make(
        self, kind: str, ending: str, first_look: str, compute: Callable[..., Any], **style: Any
    ) -> None:
        """Compute a map of a ``kind`` into a file, draw it and describe it; ends with a sentence and an exit
        code where that cannot be.

        ``ending``: of its file's name, after that of the model; ``first_look``: options for less; ``style``:
        arguments of its figure.
        """
        place = self.target if self.target is not None else RUNS / f"{self.model.stem}{ending}"
        with sentences(str(self.model)):
            figure = figure_path(place, kind, self.figure, self.csv, self.target is None)
            refuse_inputs((("-o", place), ("--figure", figure), ("--csv", self.csv)), self.inputs)
            mechanism = self.mechanism()
        job = CommandJob(kind, place, yes=self.yes, quiet=self.quiet, first_look=first_look)
        with job.at_work(str(self.model)):
            result = compute(mechanism, file=place, progress=job)
        write_files(result, figure, self.csv, lambda: result.plot(**style))
        if not self.quiet:
            describe(result, place, figure, self.csv)
        if left := unfinished(result):
            end_interrupted(f": {left} are complete and kept in {place}; the same command goes on.")


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
        step = positive("--step", self.step, "s")
        return {
            "turns": turns,
            "dropped": drop,
            "series": self.of or (),
            "phase": self.phase / 360.0,
            "step": step,
        }


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

        path, low, high = number_range(mechanism, options.over)
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
        x, y = (number_range(mechanism, text, starts=True) for text in options.over)
        shared: dict[str, Any] = {
            "count": counts(options.count),
            "exponents": options.exponents,
            "companions": options.companions,
        }
        return basins_of(mechanism, x, y, **shared, **options.arguments(), **job)

    options.make("map", "-basins.map", "--count 10 --turns 30", compute)


class ShowOptions(Options):
    """Options of ``vfife map show``."""

    file: Path = argument("What a map was kept in.", "FILE.map")
    figure: Path | None = option(None, "The picture.", FIGURE_FILE, show_default="FILE.png")
    csv: Path | None = option(None, "All points as a table.", TABLE_FILE)


def show(options: ShowOptions) -> None:
    """What a map, a section, basins or a waterfall came to so far, from their file; a figure and a table of
    it.
    """
    with sentences(str(options.file)):
        from ...dynamics.load_map import load_map

        refuse_inputs((("--figure", options.figure), ("--csv", options.csv)), (options.file,))
        result = load_map(options.file)
    write_files(result, options.figure, options.csv)
    describe(result, options.file, options.figure, options.csv)


for command in (sweep, section, basins, show):
    add_command(map_, command)


def describe(result: Any, *files: Path | None) -> None:
    """Print what a map shows, and the files that were written."""
    from ...report.dynamics import document

    answer(document(result))
    print_line(", ".join(str(path) for path in files if path is not None))


def unfinished(result: Any) -> str:
    """How much of a map is complete, in words; nothing where all of it is."""
    from ...dynamics.basins import Basins
    from ...dynamics.sections import PoincareSection

    if isinstance(result, PoincareSection):
        total, noun = result.spec.turns - result.spec.dropped, "turns"
    elif isinstance(result, Basins):
        total, noun = result.spec.count, "starts"
    else:
        total, noun = len(result.spec.values), "values"
    return f"{result.done:,} of {total:,} {noun}" if result.done < total else ""


# ------------------------------------------------------------------------------------------- texts of options


class NumberRange(NamedTuple):
    """A number of a model by its path, and its range (SI)."""

    path: str
    low: float
    high: float


def start_numbers(mechanism: Mechanism, text: str) -> dict[str, float]:
    """Numbers of a start: "own", or PATH=VALUE, PATH=VALUE. Raises ValueError."""
    from ...dynamics.start_states import unit_of_start
    from ...units import number

    values: dict[str, float] = {}
    for item in [] if text.strip() == "own" else text.split(","):
        path, sign, value = (part.strip() for part in item.partition("="))
        if not (sign and path and value):
            raise ValueError(
                f"--start {text}: this is neither own nor PATH=VALUE; write it as in --start"
                ' "start.crank=90deg, start.pin.x=0.1mm"'
            )
        try:
            values[path] = number(value, unit_of_start(mechanism, path))
        except ValueError as error:
            raise ValueError(f"--start {item.strip()}: {error}") from None
    return values


def number_range(mechanism: Mechanism, text: str, starts: bool = False) -> NumberRange:
    """A number of the model, or of a start too (``starts``), with its range (SI): PATH=LOW..HIGH. Raises
    ValueError.
    """
    from ...dynamics.maps import unit_at
    from ...dynamics.start_states import unit_of_start
    from ...units import ends_of, in_rpm, is_bare, number

    path, sign, span = (part.strip() for part in text.partition("="))
    ends = ends_of(span)
    if not (sign and path and ends):
        raise ValueError(
            f"--over {text}: this is not PATH=LOW..HIGH; write it as in --over joint.C.clearance=0.1..1mm"
        )
    try:
        unit = (unit_of_start if starts else unit_at)(mechanism, path)
        low, high = (number(end, unit) for end in ends)
    except ValueError as error:
        raise ValueError(f"--over {text}: {error}") from None
    if not low < high:
        raise ValueError(f"--over {text}: the range is empty; write its lower end first")
    if unit not in ("1", "") and all(is_bare(end) for end in ends):
        speeds = f", {in_rpm(low)} to {in_rpm(high)}" if unit == "rad/s" else ""
        other = "rpm" if unit == "rad/s" else "mm" if unit == "m" else unit
        tell(
            "caution", f"--over {text}: numbers without a unit are in {unit}{speeds}; is {span}{other} meant?"
        )
    return NumberRange(path, low, high)


def counts(text: str) -> tuple[int, int]:
    """Values of both numbers of a grid. Raises ValueError."""
    first, sign, second = text.partition("x")
    if not first.isdecimal() or not (second if sign else first).isdecimal():
        raise ValueError(f"--count {text}: allowed: a whole number, or two as in 40x30")
    grid = int(first), int(second if sign else first)
    if not all(2 <= one <= MOST_STARTS for one in grid):
        raise ValueError(f"--count {text}: allowed: 2 to {MOST_STARTS} values of each")
    return grid
