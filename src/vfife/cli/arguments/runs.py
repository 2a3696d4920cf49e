"""Arguments and options of commands that run a model or read a run."""

from __future__ import annotations

from enum import StrEnum
from pathlib import Path

from ..options import (
    COMPANIONS,
    OF_MODEL,
    FileOptions,
    JobOptions,
    JsonOptions,
    LawOptions,
    LengthOptions,
    ModelOptions,
    Options,
    OutputsOptions,
    QuietOptions,
    RunOptions,
    argument,
    flag,
    option,
)
from ..outputs import DECIMAL, PICTURES


class Loops(StrEnum):
    """The loops there are."""

    auto = "auto"
    data_driven = "data-driven"
    generated = "generated"
    interpreted = "interpreted"


class AnswerOptions(JsonOptions, QuietOptions):
    """What is printed and drawn of a run."""

    figures: bool = flag("--figures/--no-figures", "Draw the figures as well.")
    long: bool = flag("--long", "Print all tables of the run, not one screen.")


class NewRunOptions(
    ModelOptions, LengthOptions, OutputsOptions, AnswerOptions, JobOptions, function="run.run"
):
    """Run a model and answer on one screen: forces, knocks, losses, and how certain they are.

    The folder holds the run file, the model as it was run, the summary, and figures where they are asked for;
    a run that is there already stays unless --force is given. Exit codes: 2 for input that cannot be used, 3
    where the numbers became infinite or no equilibrium was found, 5 where something could not be written,
    130, 143 and 129 after Ctrl-C, SIGTERM and SIGHUP, which keep what was computed.
    """

    folder: Path | None = option(None, "Run folder.", "FOLDER", "-o", "--output", show_default="runs/MODEL")
    settle: str | None = option(
        None,
        "End as soon as turns repeat within this share of their largest values, as in 1%, after --turns at"
        " the latest.",
        "SHARE",
        show_default=OF_MODEL,
    )
    loop: Loops = option(
        Loops.auto,
        "Loop that makes the steps; with the same step all give the same bits. By default only `generated`"
        " runs companions: the others give no ranges and take another automatic step, unless --companions"
        " names a number.",
    )
    reference: bool = flag("--reference/--no-reference", "Compare with the ideal mechanism.", default=True)
    start_from: Path | None = option(
        None, "A new run from where a former one ended (its folder or file), by its clock.", "RUN"
    )
    force: bool = flag("--force", "Replace the run that is in the folder.")
    resume: bool = flag("--resume", "Go on with the run in the folder, if this model was begun there.")


class ResumeOptions(RunOptions, LawOptions, AnswerOptions, function="run.resume"):
    """Go on with a run that was interrupted or killed, as if nothing had happened: the same numbers, to the
    bit.

    With --until a run ends later than planned, also one that is complete; its step stays what it is. Exit
    codes are those of vfife run.
    """

    until: str | None = option(
        None, 'Time at which it ends, such as 0.5 or "500 ms".', "SECONDS", show_default="as planned"
    )


class CompareOptions(
    ModelOptions, LengthOptions, OutputsOptions, JsonOptions, JobOptions, function="compare.compare"
):
    """Run a model under several laws and tell how its numbers differ: a table, figures, CSV and JSON.

    Every contact law is paired with every friction law. A law takes over parameters of the one in whose place
    it comes, where both have them. Runs that are complete are kept: after Ctrl-C or a kill the same command
    with -o FOLDER goes on after them.
    """

    contact: str | None = option(None, 'Contact laws, or "all"; the model\'s own if left out.', "LAW,LAW")
    friction: str | None = option(None, 'Friction laws, or "all"; the model\'s own if left out.', "LAW,LAW")
    joint: list[str] | None = option(None, "Joint whose laws change; all with clearance if left out.", "NAME")
    folder: Path | None = option(
        None, "Folder of the figures.", "FOLDER", "-o", "--output", show_default="runs/MODEL-compare"
    )
    figures: bool = flag("--figures/--no-figures", "Draw the figures as well.", default=True)
    companions: str | None = option("0", COMPANIONS, "N", show_default=OF_MODEL)
    force: bool = flag("--force", "Replace the comparison that is in the folder.")


class InfoOptions(RunOptions, JsonOptions, function="result.info"):
    """Show the answer of a run again, and what its file contains; also of an interrupted or killed run."""

    long: bool = flag("--long", "Print the tables of the run.")
    measures: bool = flag("--measures", "Print every measure and law, instead of the answer of the run.")
    check: bool = flag("--check", "Read every output of a large file as well, and tell what is damaged.")


class ImpactsOptions(RunOptions, JsonOptions, function="result.impacts"):
    """List the impacts of a run, the fastest first: time, crank angle, approach speed, energy lost and depth.
    With --json all of them in the order of time.

    The list is complete. Impacts that began between the same two outputs share one line with their number and
    mean speed; more outputs (vfife run --outputs) separate them.
    """

    count: int = option(10, "Number of impacts.", "N", "-n", "--count", min=1)


FORMATS = "|".join(ending[1:] for ending in PICTURES)


class ForceOptions(Options):
    """Whether a file is replaced."""

    force: bool = flag("--force", "Replace the file if there is one.")


class PlotOptions(Options, function="result.plot"):
    """Draw figures of a run: the mechanism, journal paths, forces and accelerations over the ideal ones; more
    with --figure.

    Of several runs, draw one figure with a line for each: vfife plot NEW WORN.
    """

    runs: list[Path] = argument("Run folders, or the run files in them; several are overlaid.", "RUN...")
    figure: list[str] | None = option(
        None,
        "Figure to draw, once for each; all draws every one that the run has, list says which there are.",
        "NAME",
        show_default="the usual ones",
    )
    out: Path | None = option(
        None,
        "Folder of the figures; of one figure also a file, as forces.svg.",
        "FOLDER",
        "-o",
        "--output",
        show_default="RUN/figures; of several RUN-and-RUN",
    )
    label: list[str] | None = option(
        None,
        "Name of a run in the legend, once for each run.",
        "TEXT",
        show_default="the parameters in which the models differ",
    )
    kind: str = option("png", "Format of the files.", FORMATS, "--format")
    at: str | None = option(
        None, "Moment at which the mechanism is drawn, as 90deg of the last turn, or 12ms.", "ANGLE|TIME"
    )
    force: bool = flag("--force", "Replace figures that are there.")


class AnimateOptions(RunOptions, ForceOptions, function="result.animate"):
    """Write a film of a run: the mechanism as it moves, its clearance drawn larger, and beside it the largest
    joint forces as they come.
    """

    out: Path | None = option(
        None,
        "Film to write: .gif, or .mp4 with the extra video.",
        "FILM",
        "-o",
        "--output",
        show_default="RUN.gif",
    )
    frames: int = option(240, "Frames; no more than the part shown has outputs.", "N")
    fps: float = option(25.0, "Frames a second.", "N")
    turns: float = option(
        1.0, "Last turns of the crank that are shown; without a crank the whole run is.", "N"
    )
    force: bool = flag("--force", "Replace the file if there is one.")
    quiet: bool = flag("--quiet", "No progress line.", "-q")


class ReportOptions(RunOptions, ForceOptions, function="result.report"):
    """Write a report of a run, as a page (.html) or for printing (.pdf): conclusion, figures, numbers,
    cautions and the model.

    A page also runs the mechanism. Of a study (FILE.study): its numbers, figures, and a case of the reader's
    choice running, as a page.

    The report is one file that needs no other.
    """

    out: Path | None = option(
        None, "File to write: .html or .pdf.", "REPORT", "-o", "--output", show_default="RUN-report.html"
    )
    author: str = option("", "Author on the first page.", "NAME")
    logo: Path | None = option(None, "Picture on the first page, PNG or JPEG.", "FILE")
    no_live: bool = flag("--no-live", "Without the page in which the mechanism runs.")


class ExportOptions(RunOptions, ForceOptions, function="result.export"):
    """Write the channels of a run with their units, or a figure, in the format of the file's ending.

    A table of the last turn over the crank angle, for a diagram in a spreadsheet: vfife export RUN turn.xlsx
    --last --channels "*.force".
    """

    out: Path | None = argument(
        "File to write: .csv, .xlsx, .nc, .mat, .parquet; a figure as .svg, .pdf, .png, by its name.",
        "[OUT]",
        None,
    )
    target: Path | None = option(None, "File to write, instead of the argument OUT.", "OUT", "-o", "--output")
    channels: list[str] | None = option(
        None,
        'Series to write, as small-end.force or "*.force", or joints and bodies by name; once for each, or'
        " separated by commas.",
        "NAME,...",
        show_default="all",
    )
    turns: str | None = option(None, "Turns to write, as 60 or 59..60.", "FIRST..LAST", show_default="all")
    last: bool = flag("--last", "Write the last turn, in the order of the crank angle.")
    figure: str | None = option(None, "The figure, if the file is not called by its name.", "NAME")
    decimal: str = option("point", DECIMAL, "point|comma")


KINDS = ("spectrum", "spectrogram", "envelope")


class SpectrumOptions(RunOptions, FileOptions, function="vibration.spectrum"):
    """Spectrum of any series of a run, spectrogram or envelope: the strongest waves, by orders of the crank
    or in Hz; a figure, a table.

    A run is seen at its outputs: what is faster than half their rate is folded back, so let short impacts
    have several each (vfife run --outputs).
    """

    of: list[str] | None = option(
        None,
        "Series, as C.force; repeated or with commas.",
        "SERIES,SERIES",
        show_default="the largest forces",
    )
    kind: str = option(
        "spectrum",
        "Over frequency; over time and frequency; or the size of what vibrates.",
        "|".join(KINDS),
        "--as",
    )
    window: str | None = option(
        None, "hann, hamming, blackman, flat-top or rectangular.", "NAME", show_default="hann"
    )
    length: str | None = option(
        None,
        "Length of the windows, as 5ms.",
        "TIME",
        show_default="the run; of a spectrogram a sixteenth of it",
    )
    turns: float | None = option(None, "The same in turns of the crank.", "N")
    overlap: float | None = option(
        None, "Overlap of the windows.", "SHARE", show_default="0.5; of a spectrogram 0.75"
    )
    band: str | None = option(
        None, "Band of an envelope, as 2..8kHz.", "LOW..HIGH", show_default="all frequencies"
    )
    hertz: bool = flag("--hertz", "Frequencies in the figure and table, also where a crank turns evenly.")


class ModesOptions(ModelOptions, JsonOptions, function="vibration.modes"):
    """Natural frequencies and shapes about the start: of the whole mechanism, and of its elastic links by
    themselves.

    Each frequency has the range of its error by the mesh, from the same vibration with twice and four times
    the elements, or "not estimated". Shapes are in the JSON value: displacement (m, m, rad) of every
    particle, in the order of the particles of a result, the ground first.
    """

    count: int = option(10, "Number of modes, the lowest first.", "N", "-n", "--count", min=1)
    released: bool = flag("--released", "Without drivers, which otherwise hold what they drive.")
