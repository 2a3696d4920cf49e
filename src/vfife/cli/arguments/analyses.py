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
from ..outputs import DECIMAL
from ..registry import DefaultGroup, add_command

MOST_VALUES, MOST_STARTS, MOST_TURNS, MOST_SECTION = 10_000, 2_000, 1_000_000, 10_000_000


GRID = (
    "Range of a number of the start or of the model; give it twice, as in start.pin.x=-0.2..0.2mm,"
    " start.crank=0..360deg, joint.pin.clearance=0.1..1mm."
)


START = (
    'Start anew at every value: "own", or numbers of a start, as in "start.crank=90deg, start.pin.x=0.1mm";'
    " may be repeated."
)


DROP = "Number of turns at the start that are not recorded."
SERIES = "penetration, force_max of a joint with clearance; otherwise a position or velocity"
FINEST = "the finest that a run chooses at the ends and in the middle"


class MapOptions(AnswerFileOptions, ModelOptions, JobOptions):
    """What every command of maps takes."""

    target: Path | None = option(
        None, "Result file.", "FILE.map", "-o", "--output", show_default="runs/MODEL.map"
    )
    figure: Path | None = option(None, "File of the figure.", FIGURE_FILE, show_default="FILE.png")
    force: bool = flag("--force", "Replace an existing map.")


class OrbitOptions(MapOptions):
    """Series recorded once a turn."""

    of: list[str] | None = option(
        None,
        "Series recorded once per turn, as in rail.position and rail.velocity of a slider, or rod.x and rod.u"
        " of a body.",
        "SERIES",
        show_default=SERIES,
    )
    phase: float = option(
        0.0, "Crank angle of the section, relative to the start.", "DEG", min=0.0, max=360.0
    )
    step: str | None = option(
        None, "Time step; a turn has a whole number of steps.", "TIME", show_default=FINEST
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
        "At which clearance does it become chaotic? vfife new slider-crank -o my.toml, then vfife map my.toml"
        " --over joint.pin.clearance=0.1..1mm"
    ),
)


class SweepOptions(OrbitOptions, function="map.sweep"):
    """Bifurcation diagram: vary a parameter up and down, record the motion once per turn, and compute the
    largest Lyapunov exponent.

    The motion continues from value to value, which reveals coexisting motions; with --start every value
    starts anew. After an interruption the same command continues. The word `sweep` may be omitted.
    """

    over: str = option(
        ...,
        "Parameter and its range, as in joint.pin.clearance=0.1..1mm.",
        "PATH=LOW..HIGH",
        show_default=False,
    )
    count: int = option(60, "Number of values, passed upwards and downwards.", "N", min=2, max=MOST_VALUES)
    turns: int = option(90, "Turns at each value.", "N", min=1, max=MOST_TURNS)
    drop: int | None = option(None, DROP, "N", min=0, show_default="two thirds")
    start: list[str] | None = option(None, START, "own|PATH=VALUE,...", show_default="the motion continues")
    companions: int = option(5, "Number of values repeated with a coarser and a finer step.", "N", min=0)


class SectionOptions(OrbitOptions, function="map.section"):
    """Poincaré section of one motion, once per turn and at every impact; classify the motion (periodic,
    quasi-periodic, chaotic) with evidence.

    At impacts: position on the bearing, speed and crank angle at which a contact begins, located inside the
    step. After an interruption the same command continues.
    """

    turns: int = option(300, "Number of turns.", "N", min=1, max=MOST_SECTION)
    drop: int | None = option(None, DROP, "N", min=0, show_default="a third")
    impacts: list[str] | None = option(
        None, "Joint whose impacts are recorded; may be repeated.", "JOINT", show_default="all with clearance"
    )


class BasinsOptions(OrbitOptions, function="map.basins"):
    """Basins of attraction: a grid of two numbers of the start (crank angle, position and velocity of a
    journal in its bearing) or of the model, coloured by motion.

    Cases with the same section points belong to the same motion. After an interruption the same command
    continues.
    """

    over: list[str] = option(..., GRID, "PATH=LOW..HIGH", show_default=False)
    count: str = option("16", "Number of values of each.", "N[xM]")
    turns: int = option(60, "Turns of each start.", "N", min=1, max=MOST_TURNS)
    drop: int | None = option(None, DROP, "N", min=0, show_default="two thirds")
    exponents: bool = flag(
        "--exponents/--no-exponents", "Compute Lyapunov exponents, which show chaos.", default=True
    )
    companions: int = option(5, "Number of starts repeated with a coarser and a finer step.", "N", min=0)


class ShowOptions(FileOptions, function="map.show"):
    """Show the results so far of a bifurcation diagram, section, basins or waterfall from its file, with a
    figure and a table.
    """

    file: Path = argument("Result file of a map or waterfall.", "FILE.map")
    figure: Path | None = option(None, "File of the figure.", FIGURE_FILE)

    @property
    def inputs(self) -> tuple[Path, ...]:
        """Input files, which no output may replace."""
        return (self.file,)


class WaterfallOptions(MapOptions, function="map.waterfall"):
    """Waterfall: spectra over a parameter, usually the crank speed, by orders of the crank. The runs use all
    cores.

    Every run begins at the model's own start. After an interruption the same command computes the missing
    runs.
    """

    over: str = option(
        ...,
        "Parameter and its range, as in driver.crank.speed=500..3000rpm.",
        "PATH=LOW..HIGH",
        show_default=False,
    )
    count: int = option(50, "Number of values, with one run each.", "N", min=2, max=10_000)
    turns: int = option(12, "Turns of each run.", "N", min=1, max=1_000_000)
    last: int | None = option(
        None,
        "Transform the last N turns: orders are 1/N apart.",
        "N",
        min=1,
        show_default="4, or all of fewer turns",
    )
    of: list[str] | None = option(
        None, "Series, as C.force.", "SERIES", show_default="forces of joints with clearance"
    )
    outputs: int = option(
        1440, "Samples per turn; orders above half of this number appear at wrong, lower orders.", "N", min=8
    )
    highest: float = option(50.0, "Highest order in the result.", "ORDER")
    window: str = option("hann", "hann, hamming, blackman, flat-top or rectangular.", "NAME")
    hertz: bool = flag("--hertz", "Draw frequencies instead of orders.")
    step: str | None = option(
        None, "Time step.", "TIME", show_default="the finer of the automatic steps at both ends"
    )
    target: Path | None = option(
        None, "Result file.", "FILE.waterfall", "-o", "--output", show_default="runs/MODEL.waterfall"
    )
    figure: Path | None = option(None, "File of the figure.", FIGURE_FILE, show_default="FILE-waterfall.png")


MOST_BLOCK, MOST_HARMONICS, MOST_WEAR_TURNS = 100_000, 32, 1e15


class WearOptions(AnswerFileOptions, ModelOptions, JobOptions, function="wear.wear"):
    """Wear of joints with clearance over many turns, by Archard's law: simulated blocks of turns, with
    jumps of estimated error between them.

    Joints with a table wear in the model wear, and the others by --wear. Clearances follow the worn
    surfaces. After an interruption the same command continues.
    """

    model: Path = argument("Model file, or a wear file to show.", "MODEL.toml")
    turns: float = option(1e6, "Turns of the crank, as in 1e7.", "N", min=1, show_default="1e6")
    block: int = option(
        4, "Simulated turns in a block, which give the wear rate.", "N", min=1, max=MOST_BLOCK
    )
    settle: int = option(4, "Turns before each block that are discarded.", "N", min=1, max=MOST_BLOCK)
    tolerance: float = option(0.01, "Largest error of a jump, as a share of the smallest clearance.", "SHARE")
    harmonics: int = option(
        8,
        "Harmonics of the worn profiles that clearances follow; 0: clearances stay constant.",
        "N",
        min=0,
        max=MOST_HARMONICS,
    )
    clearance: str | None = option(
        None,
        "Clearance that ends the life of a joint, at the deepest places of its smoothed profiles.",
        "LENGTH",
    )
    force: str | None = option(None, "Joint force that ends the life of a joint.", "FORCE")
    wear: str | None = option(None, "Wear coefficient of joints without a table wear.", "1/Pa")
    step: str | None = option(
        None, "Time step; a turn has a whole number of steps.", "TIME", show_default="automatic"
    )
    target: Path | None = option(
        None, "Result file.", "FILE.wear", "-o", "--output", show_default="runs/MODEL.wear"
    )
    figure: Path | None = option(None, "File of the figure.", FIGURE_FILE, show_default="FILE-wear.png")
    final_model: Path | None = option(None, "Write the worn model to this file.", "WORN.toml", "--worn")
    decimal: str = option("point", DECIMAL, "point|comma")


Compared = StrEnum("Compared", "curve envelope spectrum")


Derivatives = StrEnum("Derivatives", "auto tangents differences")


StartOf = StrEnum("StartOf", "model data")


class FitOptions(FileOptions, LawOptions, JsonOptions, JobOptions, function="fit.fit"):
    """Identify parameters of a model from measured curves: values with confidence limits and correlations,
    and parameters that the data do not determine.

    The columns of DATA.csv are time or crank_angle and channels of a result (as vfife export writes them),
    with units in brackets: "C.force [N]". Several records share the parameters; a fit plan, a TOML file with
    a table named record for each, lists what differs between them. With --law, DATA.csv contains penetration
    and force, and unloading if it was measured.
    A forecast comes first. A file keeps every computed point: after an interruption the same command
    continues, and vfife fit FILE.fit shows the result.
    """

    files: list[Path] = argument(
        "Model and measured records, a fit plan, a curve (with --law), or a fit file.",
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
        None, "Parameter with a separate value for each record, and its bounds.", "PATH=A..B", "--own"
    )
    start: StartOf = option(
        StartOf.model,
        "model: its own start; data: identify angles and speeds of bodies from the first samples.",
    )
    every: int = option(1, "Use every Nth sample of a record.", "N", min=1)
    column: list[str] | None = option(
        None,
        "Channel of a column; COLUMN~CHANNEL if the column is only proportional to it.",
        "COLUMN=CHANNEL",
        "-c",
        "--column",
    )
    weight: list[str] | None = option(None, "Weight of a column's residuals.", "COLUMN=W", show_default="1")
    offset: str | None = option(
        None,
        "Position of the first sample: free (anywhere in a turn), a number or two bounds.",
        "A..B",
        show_default="free over time",
    )
    skip: float = option(
        3.0, "Turns before the earliest start of the data, if the offset is free.", "TURNS", min=0.0
    )
    compare: Compared = option(
        Compared.curve, "Compare the curves, or, for motions that do not repeat, their envelope or spectrum."
    )
    width: str | None = option(None, "Window of the envelope.", "SPAN", show_default="a fiftieth of the data")
    step: str | None = option(
        None, 'Time step, such as 1e-6 or "1 us", or auto.', "SECONDS", show_default=OF_MODEL
    )
    screened: int = option(64, "Number of points that are tried first.", "N", min=1)
    starts: int = option(4, "Number of the best points from which searches start.", "N", min=1)
    restarts: int = option(
        3, "Number of times that the searches start again if the residuals exceed noise.", "N", min=0
    )
    confidence: float = option(95.0, "Confidence level of the limits.", "%", min=50.0, max=99.99)
    derivatives: Derivatives = option(
        Derivatives.auto, "Tangents along the run, or differences of runs; auto: tangents if both agree."
    )
    seed: int = option(0, "Seed of the points that are tried first.", min=0)
    law: str | None = option(None, "Fit this contact law to a curve of force over penetration.", "NAME")
    set_: list[str] | None = option(None, SET, "PATH=VALUE", "--set")
    target: Path | None = option(
        None, "Result file.", "FILE.fit", "-o", "--output", show_default="runs/MODEL.fit"
    )
    fitted: Path | None = option(None, "Write the model with the identified values.", "FITTED.toml")
    force: bool = flag("--force", "Replace an existing fit.")

    @property
    def inputs(self) -> tuple[Path, ...]:
        """Files that are read, over which nothing may be written."""
        return (*self.files, *(self.laws or ()))


for options in (SweepOptions, SectionOptions, BasinsOptions, ShowOptions):
    add_command(map_, options)
