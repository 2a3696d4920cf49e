"""Arguments and options of commands that compute many cases or the influence of parameters."""

from __future__ import annotations

from pathlib import Path

import typer

from ..options import (
    CaseOptions,
    FileOptions,
    JobOptions,
    JsonOptions,
    LawOptions,
    LengthOptions,
    ModelOptions,
    RetryOptions,
    StudyFileOptions,
    StudyRunOptions,
    argument,
    flag,
    option,
)
from ..outputs import DECIMAL
from ..registry import DefaultGroup, add_command


class StudyGroup(DefaultGroup):
    """The commands of a study. What is no command is a study file, which is run."""

    default = "run"


study = typer.Typer(
    cls=StudyGroup,
    no_args_is_help=True,
    help=(
        "Run a model for many values of its parameters: vfife study STUDY.toml. Results go into one"
        " file, which can be read while it grows; an interrupted study continues with the same command."
    ),
)


class RunStudyOptions(StudyRunOptions, RetryOptions, function="study.run"):
    """Run a study; `run` itself may be left out.

    A forecast of time and bytes comes first. Cases that the file has already are not computed again, so the
    same command goes on after a kill, and computes what was added to STUDY.toml. A case that fails is kept
    with its reason, and tried again with --retry alone. Exit codes: 2 for input that cannot be used, 3 where
    a case failed, 5 where something could not be written, 130, 143 and 129 after Ctrl-C, SIGTERM and
    SIGHUP.
    """


class ResumeOptions(StudyFileOptions, CaseOptions, LawOptions, RetryOptions, function="study.resume"):
    """Go on with a study that was interrupted or killed, from its file alone. Cases that failed are tried
    again with --retry.
    """


class AddOptions(StudyFileOptions, CaseOptions, LawOptions, RetryOptions, JobOptions, function="study.add"):
    """Add cases to a study and compute those alone: values of a parameter, single points, or samples."""

    values: list[str] | None = argument(
        'Values to add, as in clearance="0.3 mm, 0.4 mm"; they are combined with all others.',
        "NAME=VALUE,VALUE",
        None,
        show_default=True,
    )
    point: list[str] | None = option(
        None, "One case, a value for each parameter; may be repeated.", "NAME=VALUE,NAME=VALUE", "--point"
    )
    count: int | None = option(None, "So many samples in all.", "N", min=1)


class ShowOptions(StudyFileOptions, JsonOptions, function="study.show"):
    """Results of a study so far: least, mean and largest value of each measure and where, and what failed."""

    cases: bool = flag("--cases", "Every case with its results.")
    members: bool = typer.Option(False, "--members", hidden=True)


class PlotOptions(StudyFileOptions, function="study.plot"):
    """Draw a study: heat maps, curves with bands, parallel coordinates, Pareto fronts (of the smallest
    values; --maximise names measures that shall be large).
    """

    folder: Path | None = option(
        None, "Folder of the figures.", "FOLDER", "-o", "--output", show_default="FILE-figures"
    )
    figure: list[str] | None = option(None, "maps, curves, parallel or fronts; all unless named.", "NAME")
    measure: list[str] | None = option(None, "A measure to draw, in this order; all unless named.", "NAME")
    maximise: list[str] | None = option(
        None, "A measure that is better the larger it is; may be repeated.", "NAME"
    )
    kind: str = option("png", "png, svg or pdf.", "KIND")


class ExportOptions(StudyFileOptions, function="study.export"):
    """Write a study as a table of its cases (CSV, XLSX, Parquet) or a dataset (NetCDF), with units."""

    out: Path | None = argument("File to write: .csv, .xlsx, .nc or .parquet.", "[OUT]", None)
    target: Path | None = option(None, "File to write, instead of the argument OUT.", "OUT", "-o", "--output")
    decimal: str = option("point", DECIMAL, "point|comma")
    force: bool = flag("--force", "Replace the file if there is one.")


class ToleranceOptions(StudyFileOptions, LawOptions, JsonOptions, function="study.tolerance"):
    """Estimate the scatter of a series of machines from a study: quantiles of each measure, and the share
    that exceeds a limit, with confidence.

    The cases must be drawn (method = "random", "latin" or "sobol") from fits, tolerances or distributions;
    cases added one by one do not count. The confidence limits are those of independent draws.
    """

    limit: list[str] | None = option(
        None,
        'The most allowed, as in C.force.max="2 kN"; else the table limit of the study.',
        "MEASURE=VALUE",
    )
    quantiles: str = option("1,50,95,99", "Quantiles to tell, in percent.", "%,%")
    confidence: float = option(95.0, "Confidence of their limits, in percent.", min=50.0, max=99.99)


class IndicesOptions(StudyFileOptions, LawOptions, JsonOptions, function="study.indices"):
    """Which parameters a measure depends on over their whole ranges: Sobol' indices (method = "saltelli") or
    effects of Morris (method = "morris").

    For the slope at one point, by derivatives, see `vfife sensitivity`.
    """

    measure: list[str] | None = option(None, "A measure; may be repeated.", "NAME", show_default="all")


MEASURES = "*.force.max, *.torque.max and *.angular_acceleration.max"


class SensitivityOptions(
    ModelOptions, LengthOptions, FileOptions, JsonOptions, JobOptions, function="design.sensitivity"
):
    """Which number matters? The derivative of every measure by every number of the model, checked by finite
    changes of the number.

    Shown are elasticities: by how many per cent a measure changes with one per cent of a number. Measures are
    of the last turn. Each number is also changed by 1 % and 0.1 %, both ways, and all of it is repeated with
    steps 1.4, 1.7 and 2 times as long. The range of an elasticity covers what these runs differ by. Where
    finite changes contradict the derivative, the change for 1 % and its range stand in its place; where the
    sign is not known, a question mark.
    """

    of: list[str] | None = option(
        None, "Measures, * for any signs; repeated or with commas.", "MEASURE,MEASURE", show_default=MEASURES
    )
    to: list[str] | None = option(
        None,
        "Numbers of the model, * for any signs; repeated or with commas.",
        "PATH,PATH",
        show_default="all but points of tables",
    )
    top: int = option(8, "So many numbers of each measure.", "N", "-n", "--top", min=1)
    runs: int | None = option(
        None,
        "So many runs with displaced steps, 1 to 8, have their mean taken.",
        "N",
        show_default="2 with contact",
    )


class DesignOptions(JsonOptions, ModelOptions, JobOptions, function="design.design"):
    """Which clearance matters, which ISO fits keep a limit, and how long do joints last? One page.

    The answer consists of checked sensitivities of a measure to every clearance, of the cheapest fits of ISO
    286 with which nearly all machines keep a limit, and of wear by Archard's law for joints with a table
    wear. It names what is not known, and the command for each next step. After Ctrl-C the parts that are
    complete are shown.
    """

    of: str | None = option(
        None, "Measure that matters.", "MEASURE", show_default="the largest force of a joint with clearance"
    )
    limit: str | None = option(
        None, "Largest value of it, as in 2.6kN.", "VALUE", show_default="10 % above its value"
    )
    share: float = option(0.95, "Of all machines that shall keep the limit.", "SHARE")
    cost: list[str] | None = option(
        None, "Cost of a hole or a shaft of a grade; may be repeated.", "IT7=COST", show_default="IT7 to IT9"
    )
    joints: str | None = option(
        None, "Joints that get a fit; others keep their clearance.", "D,E,F", show_default="all"
    )
    same_fit: bool = flag("--same-fit", "The same fit, or the same grades, in all joints.")
    turns: int | None = option(None, "Turns of each run.", "N", min=1, show_default="the model's")
    wear: str | None = option(None, "Coefficient of wear for joints without a table wear.", "1/Pa")
    wear_turns: float = option(1e6, "Turns over which wear is simulated.", "N", min=1, show_default="1e6")
    clearance: str | None = option(
        None, "Clearance that ends the life of a joint.", "LENGTH", show_default="twice its own"
    )
    target: Path | None = option(
        None, "Also write a page, a document for printing or data.", "FILE.html|pdf|json", "-o", "--output"
    )
    author: str = option("", "Author on the page.", "NAME")
    logo: Path | None = option(None, "Picture on the page, PNG or JPEG.", "FILE")


class OptimiseOptions(StudyRunOptions, function="study.optimise"):
    """Find the parameters with which measures are least, or largest, within limits: what the table optimise
    of a study file asks for.

    A forecast of time and bytes comes first. One measure has a best case, from which derivatives of the run
    lead on, several have a Pareto front. Cases are kept in one study file as they end, so the same command
    goes on after a kill, and `vfife study show` and `plot` read it. Exit codes as of `vfife study`; 3 where
    no case keeps the limits.
    """


class AllocateOptions(StudyRunOptions, function="study.allocate"):
    """Find the cheapest fits with which nearly all machines keep a limit: what the tables allocation and cost
    of a study file ask for.

    A forecast of time and bytes comes first. Choices of fits are tried from the cheapest on, each until more
    machines are beyond the limit than may be. Cases are kept in one study file, so the same command goes on
    after a kill. Exit codes as of `vfife study`; 3 where no choice keeps the limit.
    """


for options in (
    RunStudyOptions,
    ResumeOptions,
    AddOptions,
    ShowOptions,
    PlotOptions,
    ExportOptions,
    ToleranceOptions,
    IndicesOptions,
    AllocateOptions,
):
    add_command(study, options)
