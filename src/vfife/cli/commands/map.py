"""``vfife map``: what becomes of a motion over a number, from turn to turn, and from start to start."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer
from typer.core import TyperGroup

from ..job import RUNS, CommandJob, places
from ..options import LawsOption, ModelArgument, SetOption, positive, read_model, refuse_inputs
from ..registry import Command, Plainly
from ..signals import NOW
from ..terminal import answer, print_line, sentences, tell, writing
from .run import Quiet

if TYPE_CHECKING:
    from ...model.mechanism import Mechanism

SWEEP = "sweep"
MOST_VALUES, MOST_STARTS, MOST_TURNS, MOST_SECTION = 10_000, 2_000, 1_000_000, 10_000_000
OVER = "The number, from and to, as in joint.pin.clearance=0.1..1mm."
Over = Annotated[str, typer.Option("--over", metavar="PATH=LOW..HIGH", help=OVER, show_default=False)]
GRID = (
    "A number of the start or of the model, from and to; twice, as in start.pin.x=-0.2..0.2mm,"
    " start.crank=0..360deg, joint.pin.clearance=0.1..1mm."
)
OverTwo = Annotated[
    list[str], typer.Option("--over", metavar="PATH=LOW..HIGH", help=GRID, show_default=False)
]
Count = Annotated[
    int, typer.Option("--count", metavar="N", min=2, max=MOST_VALUES, help="Values of it, up and down again.")
]
Counts = Annotated[str, typer.Option("--count", metavar="N[xM]", help="Values of each.")]
Turns = Annotated[
    int, typer.Option("--turns", metavar="N", min=1, max=MOST_TURNS, help="Turns at each value.")
]
TurnsOfStart = Annotated[
    int, typer.Option("--turns", metavar="N", min=1, max=MOST_TURNS, help="Turns of each start.")
]
TurnsOfAll = Annotated[int, typer.Option("--turns", metavar="N", min=1, max=MOST_SECTION, help="Turns.")]
FROM = (
    'Begin every value anew: "own", or numbers of a start, as in "start.crank=90deg, start.pin.x=0.1mm"; may'
    " be repeated."
)
From = Annotated[
    list[str] | None,
    typer.Option("--start", metavar="own|PATH=VALUE,...", help=FROM, show_default="the state is carried on"),
]
Companions = Annotated[
    int,
    typer.Option(
        "--companions", metavar="N", min=0, help="So many values again with a coarser and a finer step."
    ),
]
StartCompanions = Annotated[
    int,
    typer.Option(
        "--companions", metavar="N", min=0, help="So many starts again with a coarser and a finer step."
    ),
]
Exponents = Annotated[
    bool, typer.Option("--exponents/--no-exponents", help="Watch a small difference, by which chaos is told.")
]
Impacts = Annotated[
    list[str] | None,
    typer.Option(
        "--impacts",
        metavar="JOINT",
        help="Look at every contact that begins in it.",
        show_default="all with play",
    ),
]
DROP = "So many of them are not looked at."
Drop = Annotated[
    int | None, typer.Option("--drop", metavar="N", min=0, help=DROP, show_default="two thirds of them")
]
Third = Annotated[
    int | None, typer.Option("--drop", metavar="N", min=0, help=DROP, show_default="a third of them")
]
SERIES = "penetration, force_max of a joint with play; else a place or speed"
Of = Annotated[
    list[str] | None,
    typer.Option("--of", metavar="SERIES", help="What is looked at once a turn.", show_default=SERIES),
]
Phase = Annotated[
    float,
    typer.Option(
        "--phase", metavar="DEG", min=0.0, max=360.0, help="How far beyond its start the crank is looked at."
    ),
]
STEP = "Time step; a turn has a whole number of them."
FINEST = "the finest that a run finds at the ends and in the middle"
Step = Annotated[str | None, typer.Option("--step", metavar="TIME", help=STEP, show_default=FINEST)]
Target = Annotated[
    Path | None,
    typer.Option(
        "-o", "--output", metavar="FILE.map", help="Where to keep it.", show_default="runs/MODEL.map"
    ),
]
Figured = Annotated[
    Path | None,
    typer.Option("--figure", metavar="FILE.png|svg|pdf", help="The picture.", show_default="FILE.png"),
]
Csv = Annotated[
    Path | None, typer.Option("--csv", metavar="FILE.csv", help="All points as a table.", show_default=False)
]
Kept = Annotated[Path, typer.Argument(metavar="FILE.map", help="What a map was kept in.", show_default=False)]
Yes = Annotated[bool, typer.Option("--yes", help="Make it whatever it takes: hours, or half the disk.")]


class Group(Plainly, TyperGroup):
    """The commands of maps. What is no command is a model, over whose number a map is made."""

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        """Puts the command before a model; a word that is no file's name is a command that there is not."""
        word = args[0] if args else "--help"
        if (
            word not in self.commands
            and word != "--help"
            and (word.startswith("-") or Path(word).suffix or Path(word).exists())
        ):
            args = [SWEEP, *args]
        return super().parse_args(ctx, args)


map_ = typer.Typer(
    cls=Group,
    no_args_is_help=True,
    help=(
        "What becomes of a motion: vfife map MODEL --over PATH=LOW..HIGH sweeps a number up and down, draws a"
        " bifurcation diagram and says where the motion is periodic and where chaotic; commands look at one"
        " motion once a turn and at its impacts, and at many starts. What is known is kept in one file; after"
        " a kill the same command goes on."
    ),
    epilog=(
        "From which play on is it chaotic? vfife new slider-crank -o my.toml, then vfife map my.toml --over"
        " joint.pin.clearance=0.1..1mm"
    ),
)


@map_.command(SWEEP, cls=Command)
def sweep(
    model: ModelArgument,
    over: Over,
    count: Count = 60,
    turns: Turns = 90,
    drop: Drop = None,
    of: Of = None,
    phase: Phase = 0.0,
    step: Step = None,
    start: From = None,
    companions: Companions = 5,
    target: Target = None,
    figure: Figured = None,
    csv: Csv = None,
    set_: SetOption = None,
    laws: LawsOption = None,
    yes: Yes = False,
    quiet: Quiet = False,
) -> None:
    """Bifurcation diagram: a number swept up and down while the motion goes on, looked at once a turn, with
    the largest Lyapunov exponent.

    The state is carried on from value to value, so that motions which live beside each other are told apart;
    with --start every value begins anew. After Ctrl-C or a kill the same command goes on. `sweep` itself may
    be left out.
    """

    def made(mechanism: Mechanism, **job: Any) -> Any:
        from ...dynamics.bifurcation import bifurcation

        path, low, high = number_range(mechanism, over)
        return bifurcation(
            mechanism, path, low, high, count=count, starts=[start_numbers(mechanism, text) for text in start or ()],
            companions=companions, **looked_at(turns, drop, of, phase, step), **job,
        )  # fmt: skip

    MapCommand(model, ".map", target, figure, csv, set_, laws, yes, quiet, "--count 30 --turns 45").run(made)


@map_.command(cls=Command)
def section(
    model: ModelArgument,
    turns: TurnsOfAll = 300,
    drop: Third = None,
    of: Of = None,
    phase: Phase = 0.0,
    impacts: Impacts = None,
    step: Step = None,
    target: Target = None,
    figure: Figured = None,
    csv: Csv = None,
    set_: SetOption = None,
    laws: LawsOption = None,
    yes: Yes = False,
    quiet: Quiet = False,
) -> None:
    """Poincaré section of one motion: once a turn, and at every impact; what it is (period, quasi-periodic,
    chaotic) and what says so.

    At impacts: where on the bearing, how fast and at which angle of the crank a contact begins, located
    inside the step. After Ctrl-C or a kill the same command goes on.
    """

    def made(mechanism: Mechanism, **job: Any) -> Any:
        from ...dynamics.sections import poincare_section

        joints = tuple(mechanism.contacts) if impacts is None else tuple(impacts)
        return poincare_section(mechanism, joints=joints, **looked_at(turns, drop, of, phase, step), **job)

    MapCommand(model, "-section.map", target, figure, csv, set_, laws, yes, quiet, "--turns 90").run(made)


@map_.command(cls=Command)
def basins(
    model: ModelArgument,
    over: OverTwo,
    count: Counts = "16",
    turns: TurnsOfStart = 60,
    drop: Drop = None,
    of: Of = None,
    phase: Phase = 0.0,
    exponents: Exponents = True,
    companions: StartCompanions = 5,
    step: Step = None,
    target: Target = None,
    figure: Figured = None,
    csv: Csv = None,
    set_: SetOption = None,
    laws: LawsOption = None,
    yes: Yes = False,
    quiet: Quiet = False,
) -> None:
    """Basins: a grid of two numbers of the start (crank angle, journal's place and velocity in its bearing)
    or of the model, coloured by motion.

    Members are one motion where their points once a turn are. After Ctrl-C or a kill the same command goes
    on.
    """

    def made(mechanism: Mechanism, **job: Any) -> Any:
        from ...dynamics.basins import basins as basins_of

        if len(over) != 2:
            how = "name two numbers, as in --over start.pin.x=-0.2..0.2mm --over start.pin.y=-0.2..0.2mm"
            raise ValueError(f"--over: this is given {len(over)} times; {how}")
        x, y = (number_range(mechanism, text, starts=True) for text in over)
        asked = looked_at(turns, drop, of, phase, step)
        return basins_of(
            mechanism, x, y, count=counts(count), exponents=exponents, companions=companions, **asked, **job
        )

    MapCommand(
        model, "-basins.map", target, figure, csv, set_, laws, yes, quiet, "--count 10 --turns 30"
    ).run(made)


@map_.command(cls=Command)
def show(file: Kept, figure: Figured = None, csv: Csv = None) -> None:
    """What a map, a section, basins or a waterfall came to so far, from their file; a figure and a table of
    it.
    """
    with sentences(str(file)):
        from ...dynamics.load_map import load_map

        refuse_inputs((("--figure", figure), ("--csv", csv)), (file,))
        found = load_map(file)
    drawn_and_told(found, file, figure, csv, quiet=False, whole=False)


# ------------------------------------------------------------------------------------------------------------------ flow


@dataclass(frozen=True)
class MapCommand:
    """What every command of maps takes; ``ending``: of its file's name, after that of the model; ``kind``: of
    the file; ``first_look``: options for less.
    """

    model: Path
    ending: str
    target: Path | None
    figure: Path | None
    csv: Path | None
    set_: list[str] | None
    laws: list[Path] | None
    yes: bool
    quiet: bool
    first_look: str = ""
    kind: str = "map"

    def run(self, made: Callable[..., Any], plot: Mapping[str, Any] | None = None) -> None:
        """Makes it, draws it and says what it is; ends with a sentence and an exit code where it cannot be."""
        place = self.target if self.target is not None else RUNS / f"{self.model.stem}{self.ending}"
        with sentences(str(self.model)):
            drawn = places(place, self.kind, self.figure, self.csv, self.target is None)
            refuse_inputs(
                (("-o", place), ("--figure", drawn), ("--csv", self.csv)), (self.model, *(self.laws or ()))
            )
            mechanism = read_model(self.model, self.set_, self.laws)
        job = CommandJob(self.kind, place, yes=self.yes, quiet=self.quiet, first_look=self.first_look)
        with job.at_work(str(self.model)):
            found = made(mechanism, file=place, progress=job)
        drawn_and_told(found, place, drawn, self.csv, self.quiet, plot=plot)


def looked_at(
    turns: int, drop: int | None, of: list[str] | None, phase: float, step: str | None
) -> dict[str, Any]:
    """Arguments that all maps have. Raises ValueError where no turn is left to look at."""
    if drop is not None and drop >= turns:
        raise ValueError(
            f"--drop {drop}: no turn is left to look at of --turns {turns}; allowed: 0 to {turns - 1}, fewer"
            " of them are dropped then"
        )
    size = None if step is None else positive("--step", step, "s")
    return {"turns": turns, "dropped": drop, "series": of or (), "phase": phase / 360.0, "step": size}


def start_numbers(mechanism: Mechanism, text: str) -> dict[str, float]:
    """Numbers of a start: "own", or PATH=VALUE, PATH=VALUE. Raises ValueError."""
    from ...dynamics.start_states import unit_of_start
    from ...units import number

    found: dict[str, float] = {}
    for item in [] if text.strip() == "own" else text.split(","):
        path, sign, value = (part.strip() for part in item.partition("="))
        if not (sign and path and value):
            raise ValueError(
                f"--start {text}: this is neither own nor PATH=VALUE; write it as in --start"
                ' "start.crank=90deg, start.pin.x=0.1mm"'
            )
        try:
            found[path] = number(value, unit_of_start(mechanism, path))
        except ValueError as error:
            raise ValueError(f"--start {item.strip()}: {error}") from None
    return found


def number_range(mechanism: Mechanism, text: str, starts: bool = False) -> tuple[str, float, float]:
    """A number of the model, or of a start too (``starts``), with its range (SI): PATH=LOW..HIGH. Raises
    ValueError.
    """
    from ...dynamics.maps import unit_at
    from ...dynamics.start_states import unit_of_start
    from ...units import ends_of, number

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
    return path, low, high


def counts(text: str) -> tuple[int, int]:
    """Values of both numbers of a grid. Raises ValueError."""
    first, sign, second = text.partition("x")
    if not first.isdecimal() or not (second if sign else first).isdecimal():
        raise ValueError(f"--count {text}: allowed: a whole number, or two as in 40x30")
    found = int(first), int(second if sign else first)
    if not all(2 <= one <= MOST_STARTS for one in found):
        raise ValueError(f"--count {text}: allowed: 2 to {MOST_STARTS} values of each")
    return found


def drawn_and_told(
    found: Any,
    place: Path,
    drawn: Path | None,
    csv: Path | None,
    quiet: bool,
    *,
    whole: bool = True,
    plot: Mapping[str, Any] | None = None,
) -> None:
    """Draws it, as ``plot`` says, writes its table, and says what it is; where it is not ``whole``, nobody
    waits for the rest.
    """
    if drawn is not None:
        with writing(str(drawn)):
            from ...plots.style import saved

            saved(found.plot(**plot or {}), drawn)
    if csv is not None:
        with writing(str(csv)):
            found.write_csv(csv)
    done, of_all, what = counted(found)
    if not quiet:
        from ...report.dynamics import document

        answer(document(found))
        print_line(", ".join(str(path) for path in (place, drawn, csv) if path is not None))
    if whole and done < of_all:
        tell(
            "interrupted",
            f"{NOW.by}: {done:,} of {of_all:,} {what} are complete and kept in {place}; the same command"
            " goes on.",
        )
        raise typer.Exit(NOW.code)


def counted(found: Any) -> tuple[int, int, str]:
    """How much of it is done, of how much."""
    from ...dynamics.basins import Basins
    from ...dynamics.sections import PoincareSection

    if isinstance(found, PoincareSection):
        return found.done, found.spec.turns - found.spec.dropped, "turns"
    if isinstance(found, Basins):
        return found.done, found.spec.count, "starts"
    return found.done, len(found.spec.values), "values"
