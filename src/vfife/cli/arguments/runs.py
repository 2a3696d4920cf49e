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

    figures: bool = flag("--figures/--no-figures", "Draw the standard figures.")
    long: bool = flag("--long", "Print all tables of the run instead of one screen.")


class NewRunOptions(
    ModelOptions, LengthOptions, OutputsOptions, AnswerOptions, JobOptions, function="run.run"
):
    """Run a model and print forces, knocks, losses and their uncertainty on one screen.

    The folder contains the run file, a copy of the model, the summary and, with --figures, figures. An
    existing run is replaced only with --force. Exit codes: 2 bad input, 3 the numbers grew without bound or
    no equilibrium was found, 4 the energy balance failed, 5 a file could not be written, 130, 143 and 129
    after Ctrl-C, SIGTERM and SIGHUP, which keep all computed results.
    """

    folder: Path | None = option(None, "Run folder.", "FOLDER", "-o", "--output", show_default="runs/MODEL")
    settle: str | None = option(
        None,
        "End as soon as turns repeat within this share of their largest values, as in 1%, but after at most"
        " --turns.",
        "SHARE",
        show_default=OF_MODEL,
    )
    loop: Loops = option(
        Loops.auto,
        "Implementation of the time loop; with the same step all give the same bits. By default only"
        " `generated` runs companions: the others give no ranges and choose another automatic step, unless"
        " you give --companions a number.",
    )
    reference: bool = flag("--reference/--no-reference", "Compare with the ideal mechanism.", default=True)
    start_from: Path | None = option(
        None, "Start from the end of an earlier run (folder or file); its clock continues.", "RUN"
    )
    force: bool = flag("--force", "Replace an existing run.")
    resume: bool = flag("--resume", "Continue the run in the folder if it is of this model.")


class ResumeOptions(RunOptions, LawOptions, AnswerOptions, function="run.resume"):
    """Continue an interrupted or killed run with bit-identical results.

    --until extends a run, even a complete one; its step stays the same. Exit codes are those of vfife run.
    """

    until: str | None = option(
        None, 'New end of the run, such as 0.5 or "500 ms".', "SECONDS", show_default="as planned"
    )


class CompareOptions(
    ModelOptions, LengthOptions, OutputsOptions, JsonOptions, JobOptions, function="compare.compare"
):
    """Run a model with several laws and compare the results: a table, figures, CSV and JSON.

    Every contact law is paired with every friction law. A law takes over the parameters that it shares with
    the law of the model. Complete runs are kept: after an interruption the same command with -o FOLDER
    continues after them.
    """

    contact: str | None = option(None, 'Contact laws, or "all"; default: the law of the model.', "LAW,LAW")
    friction: str | None = option(None, 'Friction laws, or "all"; default: the law of the model.', "LAW,LAW")
    joint: list[str] | None = option(
        None, "Joint whose laws change; default: all joints with clearance.", "NAME"
    )
    folder: Path | None = option(
        None, "Folder of the figures.", "FOLDER", "-o", "--output", show_default="runs/MODEL-compare"
    )
    figures: bool = flag("--figures/--no-figures", "Draw the standard figures.", default=True)
    companions: str | None = option("0", COMPANIONS, "N", show_default=OF_MODEL)
    force: bool = flag("--force", "Replace an existing comparison.")


class InfoOptions(JsonOptions, function="result.info"):
    """Show the answer of a run again and the contents of its file, even if the run was interrupted.

    Several runs share one table of the forces in their joints, of two runs with the change: vfife info NEW
    WORN.
    """

    runs: list[Path] = argument("Run folder, or the run file in it; several are compared.", "RUN...")
    long: bool = flag("--long", "Print the tables of the run.")
    measures: bool = flag("--measures", "Print every measure and law instead of the answer.")
    check: bool = flag("--check", "Read every output of a large file as well, and report damage.")


class ImpactsOptions(RunOptions, JsonOptions, function="result.impacts"):
    """List the impacts of a run, the fastest first: time, crank angle, approach speed, energy loss and depth.
    With --json list all impacts in order of time.

    No impact is missed: an impact is a contact that begins. A journal that is struck while it slides along
    its bearing is no impact; vfife info RUN --long names such blows. Impacts that begin between the same two
    outputs share one line with their number and mean speed; more outputs (vfife run --outputs) separate them.
    """

    count: int = option(10, "Number of impacts to list.", "N", "-n", "--count", min=1)


FORMATS = "|".join(ending[1:] for ending in PICTURES)


class ForceOptions(Options):
    """Whether a file is replaced."""

    force: bool = flag("--force", "Replace an existing file.")


class PlotOptions(Options, function="result.plot"):
    """Draw figures of a run: the mechanism, journal paths, forces and accelerations with their ideal values;
    --figure draws others.

    Several runs share one figure with a line for each: vfife plot NEW WORN.
    """

    runs: list[Path] = argument("Run folders or run files; several runs are overlaid.", "RUN...")
    figure: list[str] | None = option(
        None,
        "Figure to draw; may be repeated. all: every figure of the run; list: names of the figures.",
        "NAME",
        show_default="the usual ones",
    )
    out: Path | None = option(
        None,
        "Folder of the figures, or a file for a single figure, as forces.svg.",
        "FOLDER",
        "-o",
        "--output",
        show_default="RUN/figures; for several runs RUN-and-RUN",
    )
    label: list[str] | None = option(
        None,
        "Name of a run in the legend; repeat it for each run, or separate the names with commas.",
        "TEXT",
        show_default="the parameters in which the models differ",
    )
    kind: str = option("png", "Format of the files.", FORMATS, "--format")
    at: str | None = option(
        None,
        "Crank angle in the last turn, as 90deg, or time, as 12ms, at which the mechanism is drawn.",
        "ANGLE|TIME",
    )
    force: bool = flag("--force", "Replace existing figures.")


class AnimateOptions(RunOptions, ForceOptions, function="result.animate"):
    """Write a film of a run: the moving mechanism with enlarged clearances, and the largest joint forces over
    time.
    """

    out: Path | None = option(
        None,
        "Film to write: .gif, or .mp4 with the extra video.",
        "FILM",
        "-o",
        "--output",
        show_default="RUN.gif",
    )
    frames: int = option(240, "Number of frames, at most the number of outputs shown.", "N")
    fps: float = option(25.0, "Frames per second.", "N")
    turns: float = option(
        1.0, "Number of last turns to show; without a crank the film shows the whole run.", "N"
    )
    force: bool = flag("--force", "Replace an existing file.")
    quiet: bool = flag("--quiet", "No progress line.", "-q")


class ReportOptions(RunOptions, ForceOptions, function="result.report"):
    """Write a report of a run as a page (.html) or for printing (.pdf): conclusion, figures, numbers,
    cautions and the model.

    A page also runs the mechanism. The report of a study (FILE.study) has its numbers, figures and cases; as
    a page it also runs the case that the reader selects.

    The report is a single file.
    """

    out: Path | None = option(
        None, "File to write: .html or .pdf.", "REPORT", "-o", "--output", show_default="RUN-report.html"
    )
    author: str = option("", "Author on the first page.", "NAME")
    logo: Path | None = option(None, "Picture on the first page, PNG or JPEG.", "FILE")
    no_live: bool = flag("--no-live", "Omit the running mechanism.")


class ExportOptions(RunOptions, ForceOptions, function="result.export"):
    """Export the channels of a run with their units, or a figure; the file name sets the format.

    A table of the last turn over the crank angle, for a chart in a spreadsheet: vfife export RUN turn.xlsx
    --last --channels "*.force".
    """

    out: Path | None = argument(
        "File to write: .csv, .xlsx, .nc, .mat, .parquet; or .svg, .pdf, .png, named after a figure.",
        "[OUT]",
        None,
    )
    target: Path | None = option(None, "File to write, instead of the argument OUT.", "OUT", "-o", "--output")
    channels: list[str] | None = option(
        None,
        'Series to write, as small-end.force or "*.force", or names of joints and bodies, with commas;'
        " may be repeated.",
        "NAME,...",
        show_default="all",
    )
    turns: str | None = option(None, "Turns to write, as 60 or 59..60.", "FIRST..LAST", show_default="all")
    last: bool = flag("--last", "Write the last turn, ordered by crank angle.")
    figure: str | None = option(None, "Name of the figure, if the file has another name.", "NAME")
    decimal: str = option("point", DECIMAL, "point|comma")


KINDS = ("spectrum", "spectrogram", "envelope")


class SpectrumOptions(RunOptions, FileOptions, function="vibration.spectrum"):
    """Spectrum, spectrogram or envelope of any series of a run: the strongest components, by orders of the
    crank or in Hz, with a figure and a table.

    The spectrum uses the outputs of the run. Frequencies above half the output rate appear at wrong, lower
    frequencies, so choose several outputs for the shortest impact (vfife run --outputs).
    """

    of: list[str] | None = option(
        None,
        "Series, as C.force; repeated or with commas.",
        "SERIES,SERIES",
        show_default="the largest forces",
    )
    kind: str = option(
        "spectrum",
        "Amplitude over frequency, over time and frequency, or of the vibrations in a band over time.",
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
        show_default="the run; for a spectrogram a sixteenth of it",
    )
    turns: float | None = option(None, "Length of the windows in turns of the crank.", "N")
    overlap: float | None = option(
        None, "Overlap of the windows.", "SHARE", show_default="0.5; for a spectrogram 0.75"
    )
    band: str | None = option(
        None, "Frequency band of an envelope, as 2..8kHz.", "LOW..HIGH", show_default="all frequencies"
    )
    hertz: bool = flag("--hertz", "Use frequencies instead of orders in figure and table.")


class ModesOptions(ModelOptions, JsonOptions, function="vibration.modes"):
    """Natural frequencies and mode shapes about the start, of the whole mechanism and of each elastic link on
    its own.

    The range of each frequency covers its mesh error, estimated with twice and four times the elements;
    otherwise the frequency is marked "not estimated". --json contains the mode shapes: displacement (m, m,
    rad) of every particle, in the order of the particles of a result, the ground first.
    """

    count: int = option(10, "Number of modes, the lowest first.", "N", "-n", "--count", min=1)
    released: bool = flag("--released", "Release the drivers; otherwise they hold what they drive.")
