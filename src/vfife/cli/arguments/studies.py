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
    """Run a study; the word `run` may be omitted.

    A forecast of time and bytes comes first. The command computes only cases that the result file lacks, so
    the same command continues after an interruption and computes cases that you add to STUDY.toml. A failed
    case is stored with its reason and repeated only with --retry. Exit codes: 2 bad input, 3 a case failed, 5
    a file could not be written, 130, 143 and 129 after Ctrl-C, SIGTERM and SIGHUP.
    """


class ResumeOptions(StudyFileOptions, CaseOptions, LawOptions, RetryOptions, function="study.resume"):
    """Continue an interrupted study from its result file alone. With --retry repeat failed cases as well."""


class AddOptions(StudyFileOptions, CaseOptions, LawOptions, RetryOptions, JobOptions, function="study.add"):
    """Add cases to a study and compute them: values of a parameter, single points, or samples."""

    values: list[str] | None = argument(
        'Values to add, as in clearance="0.3 mm, 0.4 mm"; combined with those of the other parameters.',
        "NAME=VALUE,VALUE",
        None,
        show_default=True,
    )
    point: list[str] | None = option(
        None,
        "One case, with a value for each parameter; may be repeated.",
        "NAME=VALUE,NAME=VALUE",
        "--point",
    )
    count: int | None = option(None, "Total number of samples.", "N", min=1)


class ShowOptions(StudyFileOptions, JsonOptions, function="study.show"):
    """Show the results so far: minimum, mean and maximum of each measure, their cases, and failed cases."""

    cases: bool = flag("--cases", "List every case with its results.")
    members: bool = typer.Option(False, "--members", hidden=True)


class PlotOptions(StudyFileOptions, function="study.plot"):
    """Plot a study: heat maps, curves with bands, parallel coordinates, Pareto fronts (minimised, except for
    the measures in --maximise).
    """

    folder: Path | None = option(
        None, "Folder of the figures.", "FOLDER", "-o", "--output", show_default="FILE-figures"
    )
    figure: list[str] | None = option(
        None, "maps, curves, parallel or fronts; default: all; may be repeated.", "NAME"
    )
    measure: list[str] | None = option(
        None, "Measure to draw, in this order; default: all; may be repeated.", "NAME"
    )
    maximise: list[str] | None = option(None, "Measure to maximise; may be repeated.", "NAME")
    kind: str = option("png", "png, svg or pdf.", "KIND")


class ExportOptions(StudyFileOptions, function="study.export"):
    """Export a study as a table of its cases (CSV, XLSX, Parquet) or a dataset (NetCDF), with units."""

    out: Path | None = argument("File to write: .csv, .xlsx, .nc or .parquet.", "[OUT]", None)
    target: Path | None = option(None, "File to write, instead of the argument OUT.", "OUT", "-o", "--output")
    decimal: str = option("point", DECIMAL, "point|comma")
    force: bool = flag("--force", "Replace an existing file.")


class ToleranceOptions(StudyFileOptions, LawOptions, JsonOptions, function="study.tolerance"):
    """Estimate the scatter of machines from a study: quantiles of each measure, and the share that exceeds a
    limit, with confidence limits.

    The cases must be samples (method = "random", "latin" or "sobol") of fits, tolerances or distributions;
    cases added one by one do not count. The confidence limits are those of independent samples.
    """

    limit: list[str] | None = option(
        None,
        'Largest allowed value, as in C.force.max="2 kN"; default: the table limit of the study.',
        "MEASURE=VALUE",
    )
    quantiles: str = option("1,50,95,99", "Quantiles to report, in per cent.", "%,%")
    confidence: float = option(95.0, "Confidence level of the limits, in per cent.", min=50.0, max=99.99)


class IndicesOptions(StudyFileOptions, LawOptions, JsonOptions, function="study.indices"):
    """Global sensitivity of each measure to each parameter: Sobol' indices (method = "saltelli") or Morris
    effects (method = "morris").

    `vfife sensitivity` computes derivatives at one point.
    """

    measure: list[str] | None = option(None, "Measure; may be repeated.", "NAME", show_default="all")


MEASURES = "*.force.max, *.torque.max and *.angular_acceleration.max"


class SensitivityOptions(
    ModelOptions, LengthOptions, FileOptions, JsonOptions, JobOptions, function="design.sensitivity"
):
    """Which parameter matters? Derivatives of every measure with respect to every number of the model,
    checked with finite changes.

    The table shows elasticities: the change of a measure in per cent if a number changes by one per cent.
    Measures belong to the last turn, or to the whole run if no crank turns at constant speed. The command
    also changes each number by 1 % and 0.1 % in both directions and repeats everything with steps 1.4, 1.7
    and 2 times as long. The range of an elasticity covers the differences between these runs. If finite
    changes contradict the derivative, the table shows the change for 1 % and its range instead; if the sign
    is uncertain, a question mark.
    """

    of: list[str] | None = option(
        None,
        "Measures; * matches any characters; repeated or with commas.",
        "MEASURE,MEASURE",
        show_default=MEASURES,
    )
    to: list[str] | None = option(
        None,
        "Numbers of the model; * matches any characters; repeated or with commas.",
        "PATH,PATH",
        show_default="all but points of tables",
    )
    top: int = option(8, "Number of parameters to show for each measure.", "N", "-n", "--top", min=1)
    runs: int | None = option(
        None,
        "Average over this number of runs with displaced steps, 1 to 8.",
        "N",
        show_default="2 with contact",
    )


class DesignOptions(JsonOptions, ModelOptions, JobOptions, function="design.design"):
    """Which clearance matters, which ISO fits keep a limit, and how long do joints last? One page.

    The answer contains checked sensitivities of one measure to every clearance, the cheapest ISO 286 fits
    with which nearly all machines keep a limit, and wear by Archard's law for joints with a table wear. It
    marks unknown values "not estimated" and names the command for each next step. Three joints may take
    minutes; the ranking comes first. After Ctrl-C the answer has the completed parts; the same command
    begins again.
    """

    of: str | None = option(
        None,
        "Measure to judge the design by.",
        "MEASURE",
        show_default="the largest force of a joint with clearance",
    )
    limit: str | None = option(
        None, "Largest allowed value, as in 2.6kN.", "VALUE", show_default="10 % above the nominal value"
    )
    share: float = option(0.95, "Share of all machines that must keep the limit.", "SHARE")
    cost: list[str] | None = option(
        None,
        "Cost of a hole or a shaft of this grade; may be repeated.",
        "IT7=COST",
        show_default="IT7 to IT9",
    )
    joints: str | None = option(
        None,
        "Joints that get a fit; in their machines others keep their clearance.",
        "D,E,F",
        show_default="all",
    )
    same_fit: bool = flag("--same-fit", "Use the same fit, or the same grades, in all joints.")
    ranking: bool = flag("--ranking", "Rank the clearances only: neither fits nor lives.")
    turns: int | None = option(
        None, "Turns of each run; at least 2 for knocks.", "N", min=1, show_default="the model's"
    )
    wear: str | None = option(None, "Wear coefficient of joints without a table wear.", "1/Pa")
    wear_turns: float = option(
        1e6, "Number of turns over which wear is simulated.", "N", min=1, show_default="1e6"
    )
    clearance: str | None = option(
        None, "Clearance that ends the life of a joint.", "LENGTH", show_default="twice the nominal one"
    )
    target: Path | None = option(
        None, "Also write a page, a document for printing or data.", "FILE.html|pdf|json", "-o", "--output"
    )
    force: bool = flag("--force", "Replace an existing file.")
    author: str = option("", "Author on the page.", "NAME")
    logo: Path | None = option(None, "Picture on the page, PNG or JPEG.", "FILE")


class OptimiseOptions(StudyRunOptions, function="study.optimise"):
    """Find the parameters that minimise or maximise measures within limits, as the table optimise of a study
    file states.

    A forecast of time and bytes comes first. For one measure, the search continues from the best case with
    derivatives of the run; for several measures, it finds a Pareto front. One study file stores completed
    cases, so the same command continues after an interruption, and `vfife study show` and `plot` read it.
    Exit codes as for `vfife study`; 3 if no case keeps the limits.
    """


class AllocateOptions(StudyRunOptions, function="study.allocate"):
    """Find the cheapest fits with which nearly all machines keep a limit, as the tables allocation and cost
    of a study file state.

    A forecast of time and bytes comes first. The search tries choices of fits from the cheapest on and
    abandons a choice as soon as too many machines exceed the limit. One study file stores completed cases, so
    the same command continues after an interruption. Exit codes as for `vfife study`; 3 if no choice keeps
    the limit.
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
