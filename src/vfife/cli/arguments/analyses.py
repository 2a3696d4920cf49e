"""Arguments and options of maps, waterfalls, wear and fits."""

from __future__ import annotations

from enum import StrEnum
from pathlib import Path

import typer

from ..options import (
    FIGURE_FILE,
    OF_MODEL,
    SET,
    AnswerFileOptions,
    FileOptions,
    JobOptions,
    JsonOptions,
    LawOptions,
    ModelOptions,
    argument,
    flag,
    option,
)
from ..registry import DefaultGroup, add_command

MOST_VALUES, MOST_STARTS, MOST_TURNS, MOST_SECTION = 10_000, 2_000, 1_000_000, 10_000_000


GRID = (
    "A number of the start or of the model, from and to; twice, as in start.pin.x=-0.2..0.2mm,"
    " start.crank=0..360deg, joint.pin.clearance=0.1..1mm."
)


START = (
    'Begin every value anew: "own", or numbers of a start, as in "start.crank=90deg, start.pin.x=0.1mm"; may'
    " be repeated."
)


DROP = "Number of turns at the start that are not recorded."
SERIES = "penetration, force_max of a joint with clearance; else a place or speed"
FINEST = "the finest that a run finds at the ends and in the middle"


class MapOptions(AnswerFileOptions, ModelOptions, JobOptions):
    """What every command of maps takes."""

    target: Path | None = option(
        None, "Where to keep it.", "FILE.map", "-o", "--output", show_default="runs/MODEL.map"
    )
    figure: Path | None = option(None, "The picture.", FIGURE_FILE, show_default="FILE.png")
    force: bool = flag("--force", "Replace the map that is in the file.")


class OrbitOptions(MapOptions):
    """Series recorded once a turn."""

    of: list[str] | None = option(None, "Series recorded once a turn.", "SERIES", show_default=SERIES)
    phase: float = option(0.0, "Crank angle of the records beyond its start.", "DEG", min=0.0, max=360.0)
    step: str | None = option(
        None, "Time step; a turn has a whole number of them.", "TIME", show_default=FINEST
    )
    turns: int
    drop: int | None


class MapGroup(DefaultGroup):
    """The commands of maps. What is no command is a model, over whose number a map is made."""

    default = "sweep"


map_ = typer.Typer(
    cls=MapGroup,
    no_args_is_help=True,
    help=(
        "Bifurcation diagram: vfife map MODEL --over PATH=LOW..HIGH varies a parameter up and down and"
        " classifies the motion. Its commands make Poincaré sections of one motion, and basins over many"
        " starts. Results go into one file; an interrupted map continues with the same command."
    ),
    epilog=(
        "From which clearance on is it chaotic? vfife new slider-crank -o my.toml, then vfife map my.toml "
        "--over"
        " joint.pin.clearance=0.1..1mm"
    ),
)


class SweepOptions(OrbitOptions, function="map.sweep"):
    """Bifurcation diagram: vary a parameter up and down, record the motion once a turn, and compute the
    largest Lyapunov exponent.

    The motion continues from value to value, which shows motions that exist at the same value; with --start
    every value begins anew. After Ctrl-C or a kill the same command goes on. `sweep` itself may
    be left out.
    """

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
    companions: int = option(5, "Values repeated with a coarser and a finer step.", "N", min=0)


class SectionOptions(OrbitOptions, function="map.section"):
    """Poincaré section of one motion: once a turn, and at every impact; what it is (period, quasi-periodic,
    chaotic) and what says so.

    At impacts: where on the bearing, how fast and at which angle of the crank a contact begins, located
    inside the step. After Ctrl-C or a kill the same command goes on.
    """

    turns: int = option(300, "Turns.", "N", min=1, max=MOST_SECTION)
    drop: int | None = option(None, DROP, "N", min=0, show_default="a third of them")
    impacts: list[str] | None = option(
        None, "Joint whose contacts are recorded too.", "JOINT", show_default="all with clearance"
    )


class BasinsOptions(OrbitOptions, function="map.basins"):
    """Basins: a grid of two numbers of the start (crank angle, journal's place and velocity in its bearing)
    or of the model, coloured by motion.

    Cases belong to one motion where their points of once a turn agree. After Ctrl-C or a kill the same
    command goes on.
    """

    over: list[str] = option(..., GRID, "PATH=LOW..HIGH", show_default=False)
    count: str = option("16", "Values of each.", "N[xM]")
    turns: int = option(60, "Turns of each start.", "N", min=1, max=MOST_TURNS)
    drop: int | None = option(None, DROP, "N", min=0, show_default="two thirds of them")
    exponents: bool = flag(
        "--exponents/--no-exponents", "Follow a small difference, whose growth shows chaos.", default=True
    )
    companions: int = option(5, "Starts repeated with a coarser and a finer step.", "N", min=0)


class ShowOptions(FileOptions, function="map.show"):
    """Show the results of a map, a section, basins or a waterfall so far, from their file, with a figure and
    a table.
    """

    file: Path = argument("What a map was kept in.", "FILE.map")
    figure: Path | None = option(None, "The picture.", FIGURE_FILE)

    @property
    def inputs(self) -> tuple[Path, ...]:
        """Input files, which no output may replace."""
        return (self.file,)


class WaterfallOptions(MapOptions, function="map.waterfall"):
    """Waterfall: spectra over a number, mostly the crank's speed, by orders of the crank; a run each, side by
    side on all cores.

    Every run begins at the model's own start. After Ctrl-C or a kill the same command goes on with the runs
    that are missing.
    """

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


MOST_BLOCK, MOST_HARMONICS, MOST_WEAR_TURNS = 100_000, 32, 1e15


class WearOptions(AnswerFileOptions, ModelOptions, JobOptions, function="wear.wear"):
    """Wear of joints with clearance over many turns, by Archard's law: blocks of turns that are simulated,
    and jumps with a known error between them.

    The joints that wear have a table wear in the model. Clearances follow the worn surfaces. After Ctrl-C or
    a kill the same command goes on.
    """

    model: Path = argument("Model file, or a wear file to be shown.", "MODEL.toml")
    turns: float = option(1e6, "Turns of the crank, as in 1e7.", "N", min=1, show_default="1e6")
    block: int = option(4, "Turns that are simulated for a rate.", "N", min=1, max=MOST_BLOCK)
    settle: int = option(4, "Turns before them that are discarded.", "N", min=1, max=MOST_BLOCK)
    tolerance: float = option(0.01, "Largest error of a jump, as a share of the smallest clearance.", "SHARE")
    harmonics: int = option(
        8, "Of the worn profiles that clearances follow; 0: they do not.", "N", min=0, max=MOST_HARMONICS
    )
    clearance: str | None = option(
        None, "Clearance that ends a joint's life, at the deepest places of its smoothed profiles.", "LENGTH"
    )
    force: str | None = option(None, "Force of a joint that ends its life.", "FORCE")
    step: str | None = option(
        None, "Time step; a turn has a whole number of them.", "TIME", show_default="automatic"
    )
    target: Path | None = option(
        None, "Where to keep it.", "FILE.wear", "-o", "--output", show_default="runs/MODEL.wear"
    )
    figure: Path | None = option(None, "The figure.", FIGURE_FILE, show_default="FILE-wear.png")
    final_model: Path | None = option(None, "The model as it is worn in the end.", "WORN.toml", "--worn")


Compared = StrEnum("Compared", "curve envelope spectrum")


Derivatives = StrEnum("Derivatives", "auto tangents differences")


StartOf = StrEnum("StartOf", "model data")


class FitOptions(FileOptions, LawOptions, JsonOptions, JobOptions, function="fit.fit"):
    """Find numbers of a model from measured curves: values with their confidence and correlations, and
    what the data cannot decide.

    DATA.csv has time or crank_angle and channels of a result as columns (as vfife export writes them), units
    in brackets: "C.force [N]". Several records have the parameters in common; a fit plan, a TOML file with a
    table named record for each, says what each has of its own. With --law it has penetration and force, and
    unloading where it was measured.
    A forecast comes first. Every point is kept in a file: after Ctrl-C or a kill the same command goes on,
    and vfife fit FILE.fit shows it.
    """

    files: list[Path] = argument(
        "Model and measured records; a fit plan; with --law a curve alone; or a fit file.",
        "MODEL.toml DATA.csv...",
        show_default=True,
    )
    parameter: list[str] | None = option(
        None,
        'Parameter to identify and its bounds, as in joint.C.clearance="0.1..1 mm".',
        "PATH=A..B",
        "-p",
        "--parameter",
    )
    own: list[str] | None = option(
        None, "The same of a number of which each record has its own value.", "PATH=A..B", "--own"
    )
    start: StartOf = option(
        StartOf.model, "data: angles and speeds of bodies near the first samples are identified."
    )
    every: int = option(1, "Every so many samples of a record count.", "N", min=1)
    column: list[str] | None = option(
        None,
        "Which channel a column is; COLUMN~CHANNEL: only proportional to it.",
        "COLUMN=CHANNEL",
        "-c",
        "--column",
    )
    weight: list[str] | None = option(None, "Weight of a column's residuals.", "COLUMN=W", show_default="1")
    offset: str | None = option(
        None,
        "Where the first sample lies: free (in a turn), a number or two bounds.",
        "A..B",
        show_default="free over time",
    )
    skip: float = option(3.0, "Turns before the data may begin, where the offset is free.", "TURNS", min=0.0)
    compare: Compared = option(
        Compared.curve, "The curves, or of motions that do not repeat their envelope or spectrum."
    )
    width: str | None = option(None, "Window of the envelope.", "SPAN", show_default="a fiftieth of the data")
    step: str | None = option(
        None, 'Time step, such as 1e-6 or "1 us", or auto.', "SECONDS", show_default=OF_MODEL
    )
    screened: int = option(64, "Points that are tried first.", "N", min=1)
    starts: int = option(4, "The best of them, from which searches begin.", "N", min=1)
    restarts: int = option(3, "Times that searches begin again where more than noise is left.", "N", min=0)
    confidence: float = option(95.0, "Confidence of the limits.", "%", min=50.0, max=99.99)
    derivatives: Derivatives = option(
        Derivatives.auto, "Carried along the run, or differences of runs; auto: the former where both agree."
    )
    seed: int = option(0, "Of the points that are tried first.", min=0)
    law: str | None = option(None, "Fit this contact law to force over penetration.", "NAME")
    set_: list[str] | None = option(None, SET, "PATH=VALUE", "--set")
    target: Path | None = option(
        None, "Where to keep it.", "FILE.fit", "-o", "--output", show_default="runs/MODEL.fit"
    )
    fitted: Path | None = option(None, "Write the model with what was found.", "FITTED.toml")
    force: bool = flag("--force", "Replace the fit that is in the file.")

    @property
    def inputs(self) -> tuple[Path, ...]:
        """Files that are read, over which nothing may be written."""
        return (*self.files, *(self.laws or ()))


for options in (SweepOptions, SectionOptions, BasinsOptions, ShowOptions):
    add_command(map_, options)
