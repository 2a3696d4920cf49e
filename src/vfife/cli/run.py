"""``vfife run``: from a model file to a run folder and a summary."""

from __future__ import annotations

import shlex
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from ..solvers.status import Status
from .options import JsonOption, LawsOption, ModelArgument, SetOption, read_model, with_options
from .terminal import DIVERGED, INTERRUPTED, json_text, output, print_json, sentences, tell

if TYPE_CHECKING:
    from ..model.mechanism import Mechanism
    from ..result import Result
    from ..results.folder import RunFolder
    from ..solvers.arguments import Loop

GATHER = 0.25  # s: what a kill may cost, beside the steps that are being taken
RESULT_KEYS = ("status", "step", "steps", "wall_s", "ns_per_step", "energy_error")


class Loops(StrEnum):
    """The loops there are."""

    auto = "auto"
    data_driven = "data-driven"
    generated = "generated"
    interpreted = "interpreted"


MODELS = "the model's"
Folder = Annotated[Path | None, typer.Option("-o", "--output", metavar="FOLDER", help="Run folder.", show_default="runs/MODEL")]
Step = Annotated[str | None, typer.Option(metavar="SECONDS", help='Time step, such as 1e-6 or "1 us", or auto.', show_default=MODELS)]
Turns = Annotated[float | None, typer.Option(metavar="N", help="Length in turns of the crank.", show_default=MODELS)]
Duration = Annotated[str | None, typer.Option(metavar="SECONDS", help="Length in time, instead of turns.")]
Outputs = Annotated[int | None, typer.Option(metavar="N", min=1, help="Outputs per turn; per run without a crank.", show_default=MODELS)]
Figures = Annotated[bool, typer.Option("--figures/--no-figures", help="Draw the figures as well.")]
Reference = Annotated[bool, typer.Option("--reference/--no-reference", help="Compare with the ideal mechanism.")]
ForceStep = Annotated[bool, typer.Option("--force-step", help="Take a step that is larger than the stable one.")]
Quiet = Annotated[bool, typer.Option("--quiet", "-q", help="No progress line and no summary; warnings and errors are told.")]
StartFrom = Annotated[Path | None, typer.Option("--start-from", metavar="RUN", help="Go on where a former run ended (its folder or file).")]
BESIDE = "Runs with displaced steps beside it, 0 to 7, or auto: their range tells how far it can be trusted."
Companions = Annotated[str | None, typer.Option(metavar="N", help=BESIDE, show_default=MODELS)]
LoopOption = Annotated[Loops, typer.Option(help="Loop that makes the steps; all give the same bits.")]


def run(
    model: ModelArgument,
    folder: Folder = None,
    set_: SetOption = None,
    laws: LawsOption = None,
    step: Step = None,
    turns: Turns = None,
    duration: Duration = None,
    outputs: Outputs = None,
    loop: LoopOption = Loops.auto,
    figures: Figures = False,
    reference: Reference = True,
    force_step: ForceStep = False,
    companions: Companions = None,
    start: StartFrom = None,
    as_json: JsonOption = False,
    quiet: Quiet = False,
) -> None:
    """Run a model: a progress line, a summary, and a run folder.

    The folder holds the run file, the model as it was run, the summary, and figures where they are asked for. Exit codes: 2 for
    input that cannot be used, 3 where the numbers became infinite or no equilibrium was found, 130 after Ctrl-C, which keeps what was computed.
    """
    with sentences(str(model)):
        from ..results.folder import refuse_foreign

        refuse_foreign(folder)
        mechanism = with_options(read_model(model, set_, laws), step, turns, duration, outputs, companions)
    result, place = simulated(mechanism, model, folder, loop.value, reference, force_step, quiet, start)
    notes = [*place.notes, *result.summary["run"]["notes"], *result.summary["warnings"]]
    (place.path / "summary.json").write_text(json_text(result.summary) + "\n", encoding="utf-8")
    if figures and result.record.status != Status.INTERRUPTED:
        from ..plots import figures as drawn
        from ..plots import save

        save(drawn(result, result.reference), place.path / "figures")
    if as_json:
        print_json(payload(result, place, notes))
    elif not quiet:
        show(result, place, figures)
    elif result.record.status == Status.COMPLETE:
        for warning in (*result.summary["run"]["notes"], *result.summary["warnings"]):
            tell("warning", warning)
    end(result, place)


def simulated(
    mechanism: Mechanism, model: Path, asked: Path | None, loop: Loop, compare: bool, force_step: bool, quiet: bool, start: Path | None
) -> tuple[Result, RunFolder]:
    """Runs a mechanism into a folder; every fault of the input is told before the folder is touched."""
    from ..errors import RunFileError
    from ..results.folder import make_folder
    from ..results.runfile import RunFile
    from ..simulation import carry_out, prepare
    from ..solvers.arguments import Asked
    from .progress import ProgressLine

    with sentences(str(model)):
        prepared = prepare(mechanism, Asked(loop=loop, force_step=force_step), compare, start)
        meta = prepared.kept
    with sentences(str(asked or "runs")):
        place = make_folder(asked, model)
        (place.path / "model.toml").write_text(meta["model"], encoding="utf-8")
        file = RunFile.create(place.run_file, meta, gather=GATHER)
    for note in place.notes if not quiet else ():
        tell("note", f"{note}.")
    with file:
        try:
            with ProgressLine(quiet) as line:
                result = carry_out(prepared, progress=line, file=file)
            result.finish(file)
        except (RunFileError, OSError) as error:
            tell("error", f"{error}", "bold red")
            raise typer.Exit(1) from None
        except BaseException as error:
            if len(file.steps):
                raise
            file.close()
            place.discard()
            if not isinstance(error, KeyboardInterrupt):
                raise
            tell(Status.INTERRUPTED, "Stopped by Ctrl-C before the first step, so there is nothing to keep.")
            raise typer.Exit(INTERRUPTED) from None
    return result, place


def payload(result: Result, place: RunFolder, notes: list[str]) -> dict[str, Any]:
    """What ``--json`` prints."""
    found = {key: result.summary[key] for key in RESULT_KEYS}
    told = {key: result.summary[key] for key in ("measures", "ranges", "not_unique", "trust")}
    return {**found, "run": str(place.path), "loop": result.record.loop, "notes": notes, **told}


def show(result: Result, place: RunFolder, figures: bool) -> None:
    """The summary, and what to do next."""
    from rich.text import Text

    from ..report.summary import show as show_summary

    console, quoted = output(), shlex.quote(str(place.path))
    show_summary(console, result, result.reference)
    console.print()
    kept = ", ".join(sorted(entry.name + "/" * entry.is_dir() for entry in place.path.iterdir()))
    console.print(Text.assemble(("Run folder: ", "bold"), f"{place.path} ({kept})"))
    then = f"figures are in {place.path / 'figures'}" if figures else f"vfife plot {quoted}"
    console.print(Text.assemble(("Next: ", "bold"), f"{then}; vfife info {quoted}; vfife export {quoted} out.nc"))


def end(result: Result, place: RunFolder) -> None:
    """Says how a run ended that did not come to its end, and ends with its exit code."""
    status, choice = result.record.status, result.record.assembly.choice
    if result.record.message:
        done = max(len(result.record.steps) - 1, 0)
        kept = f"The {done} load factors before are kept in {place.path}." if done else f"The start is kept in {place.path}."
        tell(status, f"{result.record.message} {kept}", "bold red")
        raise typer.Exit(INTERRUPTED if status == Status.INTERRUPTED else DIVERGED)
    if status == Status.INTERRUPTED:
        done = int(result.record.steps[-1])
        tell(Status.INTERRUPTED, f"{done:,} of {choice.steps:,} steps were made; they are kept in {place.path}.")
        raise typer.Exit(INTERRUPTED)
    if status == Status.DIVERGED:
        from ..report.diverged import diverged

        tell(Status.DIVERGED, f"{diverged(result.record)} What was computed before is kept in {place.path}.", "bold red")
        raise typer.Exit(DIVERGED)
