"""``vfife run`` and ``vfife resume``: from a model file to a run folder and a summary; what a signal leaves
goes on to the same bits.
"""

from __future__ import annotations

import shlex
from collections.abc import Callable
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from ...compiler.runtime.cache import trouble
from ...errors import HeldError, RunFileError, StorageError
from ...files import write_text
from ...job.progress import ProgressLine
from ...solvers.status import Status
from ...store.folder import MODEL, SUMMARY, kept_run, model_of, placed
from ...store.schemas import RUN, is_run_file
from ..job import CommandJob
from ..options import (
    JsonOption,
    LawsOption,
    ModelArgument,
    RunArgument,
    SetOption,
    positive,
    read_model,
    take_laws,
    with_options,
)
from ..signals import NOW
from ..terminal import (
    BAD_INPUT,
    DIVERGED,
    ENERGY,
    STORAGE,
    command,
    fail,
    json_text,
    output,
    print_json,
    sentences,
    tell,
    writing,
)

if TYPE_CHECKING:
    from ...model.mechanism import Mechanism
    from ...simulation.result import Result
    from ...simulation.simulate import Prepared
    from ...solvers.record import Checkpoint
    from ...store.folder import RunFolder
    from ...store.runfile import RunFile

GATHER = 0.25  # s: what a kill may cost, beside the steps that are being taken


class Loops(StrEnum):
    """The loops there are."""

    auto = "auto"
    data_driven = "data-driven"
    generated = "generated"
    interpreted = "interpreted"


MODELS = "the model's"
Folder = Annotated[
    Path | None,
    typer.Option("-o", "--output", metavar="FOLDER", help="Run folder.", show_default="runs/MODEL"),
]
Step = Annotated[
    str | None,
    typer.Option(metavar="SECONDS", help='Time step, such as 1e-6 or "1 us", or auto.', show_default=MODELS),
]
Turns = Annotated[
    float | None, typer.Option(metavar="N", help="Length in turns of the crank.", show_default=MODELS)
]
UNTIL = (
    "End as soon as turns repeat within this share of their largest values, as in 1%, after --turns at the"
    " latest."
)
Settle = Annotated[str | None, typer.Option(metavar="SHARE", help=UNTIL, show_default=MODELS)]
Duration = Annotated[str | None, typer.Option(metavar="SECONDS", help="Length in time, instead of turns.")]
Outputs = Annotated[
    int | None,
    typer.Option(metavar="N", min=1, help="Outputs per turn; per run without a crank.", show_default=MODELS),
]
Figures = Annotated[bool, typer.Option("--figures/--no-figures", help="Draw the figures as well.")]
Reference = Annotated[
    bool, typer.Option("--reference/--no-reference", help="Compare with the ideal mechanism.")
]
ForceStep = Annotated[
    bool, typer.Option("--force-step", help="Take a step that is larger than the stable one.")
]
Quiet = Annotated[
    bool, typer.Option("--quiet", "-q", help="No progress line and no summary; warnings and errors are told.")
]
StartFrom = Annotated[
    Path | None,
    typer.Option(
        "--start-from",
        metavar="RUN",
        help="A new run from where a former one ended (its folder or file), by its clock.",
    ),
]
BESIDE = "Repeat a run with contact with N other step sizes, 0 to 7, to estimate its error; auto: 3."
Companions = Annotated[str | None, typer.Option(metavar="N", help=BESIDE, show_default=MODELS)]
Force = Annotated[bool, typer.Option("--force", help="Replace the run that is in the folder.")]
Yes = Annotated[
    bool, typer.Option("--yes", help="Run whatever it takes: hours, or half the memory or the disk.")
]
Resume = Annotated[
    bool, typer.Option("--resume", help="Go on with the run in the folder, if this model was begun there.")
]
LoopOption = Annotated[Loops, typer.Option(help="Loop that makes the steps; all give the same bits.")]


UNTIL_HELP = 'Time at which it ends, such as 0.5 or "500 ms".'
Until = Annotated[
    str | None, typer.Option("--until", metavar="SECONDS", help=UNTIL_HELP, show_default="as planned")
]
RESULT_KEYS = ("status", "step", "steps", "wall_s", "ns_per_step", "energy_error")
NOTHING = "That was before the first step, so there is nothing to keep."


def run(
    model: ModelArgument,
    folder: Folder = None,
    set_: SetOption = None,
    laws: LawsOption = None,
    step: Step = None,
    turns: Turns = None,
    settle: Settle = None,
    duration: Duration = None,
    outputs: Outputs = None,
    loop: LoopOption = Loops.auto,
    figures: Figures = False,
    reference: Reference = True,
    force_step: ForceStep = False,
    companions: Companions = None,
    start: StartFrom = None,
    force: Force = False,
    resume: Resume = False,
    yes: Yes = False,
    as_json: JsonOption = False,
    quiet: Quiet = False,
) -> None:
    """Run a model: a progress line, a summary, and a run folder.

    The folder holds the run file, the model as it was run, the summary, and figures where they are asked for;
    a run that is there already stays unless --force is given. Exit codes: 2 for input that cannot be used, 3
    where the numbers became infinite or no equilibrium was found, 5 where something could not be written,
    130, 143 and 129 after Ctrl-C, SIGTERM and SIGHUP, which keep what was computed.
    """

    with sentences(str(model)):
        mechanism = with_options(
            read_model(model, set_, laws),
            step=step,
            turns=turns,
            duration=duration,
            outputs=outputs,
            companions=companions,
            settle=settle,
        )
        if resume and (begun := to_go_on(folder, model)) is not None:
            goes_on(begun, mechanism, figures, as_json, quiet)
            return
        place = placed(folder, model, replace=force, start=start)
    for note in place.notes if not quiet else ():
        tell("note", f"{note}.")
    with sentences(str(model)):
        from ...simulation.result import Result
        from ...simulation.simulate import prepare
        from ...solvers.arguments import RunArguments

        former = None if start is None else Result.load(start)
        job = CommandJob("run", place.target, yes=yes, quiet=quiet, announced=False)
        prepared = prepare(
            mechanism, RunArguments(loop=loop.value, force_step=force_step), reference, former, job
        )
    carried(lambda: begun_in(place, prepared), place, figures, as_json, quiet)


def resume(
    run: RunArgument,
    until: Until = None,
    laws: LawsOption = None,
    figures: Figures = False,
    as_json: JsonOption = False,
    quiet: Quiet = False,
) -> None:
    """Go on with a run that was interrupted or killed, as if nothing had happened: the same numbers, to the
    bit.

    With --until a run ends later than planned, also one that is complete; its step stays what it is. Exit
    codes are those of vfife run.
    """
    with sentences(str(run)):
        take_laws(laws)
        end = None if until is None else positive("--until", until, "s")
        from ...store.connections import located

        resumed(located(RUN, run).parent, end, figures, as_json, quiet)


def begun_in(place: RunFolder, prepared: Prepared) -> tuple[RunFile, Prepared, Checkpoint | None]:
    """A new run file in its place."""
    from ...store.runfile import RunFile

    meta = prepared.kept
    place.begin()
    (place.path / MODEL).write_text(
        meta["model"], encoding="utf-8"
    )  # in a folder that this process has just made
    file = RunFile.create(place.run_file, meta, gather=GATHER)
    file.arrive = place.settle
    return file, prepared, None


def to_go_on(folder: Path | None, model: Path) -> Path | None:
    """The folder of a run to go on with; None where there is none yet."""

    path = folder if folder is not None else Path("runs") / model.stem
    return path if is_run_file(path / "run.sqlite") else None


def goes_on(path: Path, mechanism: Mechanism, figures: bool, as_json: bool, quiet: bool) -> None:
    """Goes on with the run in a folder, if it is that of the model."""
    from ...modelfile import dump

    if model_of(path) != dump(mechanism):
        raise ValueError(
            f"--resume: the run in {path} is that of another model, or of other options; name another folder,"
            " or leave --resume out"
        )
    resumed(path, None, figures, as_json, quiet)


def resumed(path: Path, until: float | None, figures: bool, as_json: bool, quiet: bool) -> None:
    """Goes on with the run in a folder. Raises HeldError where another process does, ResumeError where there
    is nothing to go on with.
    """
    from ...simulation.simulate import taken_up
    from ...store.runfile import RunFile

    place = kept_run(path)

    def opened() -> tuple[RunFile, Prepared, Checkpoint | None]:
        file = RunFile.write(place.run_file, gather=GATHER)
        try:
            prepared, last = taken_up(file, until)
        except BaseException:
            file.close()
            raise
        done = 0 if last is None else last.step
        if not quiet:
            tell("note", f"goes on after step {done:,} of {prepared.assembly.choice.steps:,}.")
        return file, prepared, last

    def ending(result: Result) -> None:
        if until is not None:
            from ...modelfile import dump

            write_text(place.path / MODEL, dump(result.record.assembly.mechanism))

    carried(opened, place, figures, as_json, quiet, ending)


# ------------------------------------------------------------------------------------------------------------------ flow


def carried(
    opened: Callable[[], tuple[RunFile, Prepared, Checkpoint | None]],
    place: RunFolder,
    figures: bool,
    as_json: bool,
    quiet: bool,
    ended: Callable[[Result], None] = lambda result: None,
) -> None:
    """Runs into a place, and says what came of it; ``ended`` sees the result first."""
    try:
        result = stepped(opened, place, quiet)
        ended(result)
        concluded(result, place, figures, as_json, quiet)
    finally:
        place.leave()


def stepped(
    opened: Callable[[], tuple[RunFile, Prepared, Checkpoint | None]], place: RunFolder, quiet: bool
) -> Result:
    """Runs into a place until the run ends, however it does; ends with a sentence and an exit code where it
    cannot be finished.
    """
    from ...simulation.simulate import carry_out

    NOW.saved = NOTHING if not place.settled else kept_in(place)
    NOW.last.append(place.leave)
    file: RunFile | None = None
    try:
        file, prepared, resume = opened()
        with ProgressLine(quiet) as line:
            result = carry_out(prepared, progress=line, file=file, resume=resume)
        NOW.saved = kept_in(place)
        if result.record.status == Status.INTERRUPTED:
            file.put({"status": Status.INTERRUPTED})  # a summary of a long run takes its time
        result.finish(file)
        file.close()
        return result
    except KeyboardInterrupt:
        closed(file)
        fail(f"{NOW.by}. {kept_in(place)}", NOW.code, word="interrupted")
    except (StorageError, OSError, MemoryError) as error:
        closed(file)
        said = str(error) if str(error) else "there is not enough memory"
        fail(f"{said} {kept_in(place)}", STORAGE)
    except HeldError as error:
        closed(file)
        fail(str(error), BAD_INPUT)
    finally:
        closed(file)
        if not place.settled:
            place.leave()


def closed(file: RunFile | None) -> None:
    """Closes a run file, whatever state it is in: what was not committed is gone."""

    if file is not None:
        try:
            file.close()
        except RunFileError:
            return


def kept_in(place: RunFolder) -> str:
    """What is kept of a run that was broken off, in a sentence."""
    if not place.settled:
        return NOTHING
    return (
        f"What was computed until then is kept in {place.path}; go on with: {command()} resume"
        f" {shlex.quote(str(place.path))}"
    )


def concluded(result: Result, place: RunFolder, figures: bool, as_json: bool, quiet: bool) -> None:
    """Summary, figures, the one object or the tables, and the exit code."""

    cached = trouble()
    notes = [
        *place.notes,
        *([cached] if cached else []),
        *result.summary["run"]["notes"],
        *result.summary["warnings"],
    ]
    if cached and not quiet:
        tell("note", f"{cached}.")
    NOW.saved = (
        f"The run itself is whole, in {place.path}."
        if result.record.status == Status.COMPLETE
        else kept_in(place)
    )
    with writing(str(place.path), f"The run itself is whole, in {place.path}."):
        write_text(place.path / SUMMARY, json_text(result.summary) + "\n")
        if figures and result.record.status != Status.INTERRUPTED:
            from ...plots import figures as drawn
            from ...plots import save

            save(drawn(result, result.reference), place.path / "figures")
    word, sentence, code = ending(result, place)
    if as_json:
        print_json(payload(result, place, notes) | {"faults": [{"what": sentence}] if sentence else []})
    elif not quiet:
        show(result, place, figures)
    elif result.record.status == Status.COMPLETE:
        for warning in (*result.summary["run"]["notes"], *result.summary["warnings"]):
            tell("warning", warning)
    place.leave()
    if code:
        tell(word, sentence, "bold yellow" if word == Status.INTERRUPTED else "bold red")
        raise typer.Exit(code)


def payload(result: Result, place: RunFolder, notes: list[str]) -> dict[str, Any]:
    """What ``--json`` prints."""
    found = {key: result.summary[key] for key in RESULT_KEYS}
    told = {
        key: result.summary[key]
        for key in ("turns", "part", "measures", "ranges", "not_unique", "not_estimated", "trust")
    }
    return {**found, "run": str(place.path), "loop": result.record.loop, "notes": notes, **told}


def show(result: Result, place: RunFolder, figures: bool) -> None:
    """The summary, and what to do next."""
    from rich.text import Text

    from ...report.summary import show as show_summary

    console, quoted = output(), shlex.quote(str(place.path))
    show_summary(console, result, result.reference)
    console.print()
    kept = ", ".join(
        sorted(
            entry.name + "/" * entry.is_dir() for entry in place.path.iterdir() if entry.name != "run.lock"
        )
    )
    console.print(Text.assemble(("Run folder: ", "bold"), f"{place.path} ({kept})"))
    then = f"figures are in {place.path / 'figures'}" if figures else f"{command()} plot {quoted}"
    console.print(
        Text.assemble(
            ("Next: ", "bold"), f"{then}; {command()} info {quoted}; {command()} export {quoted} out.nc"
        ),
        soft_wrap=True,
    )


def ending(result: Result, place: RunFolder) -> tuple[str, str, int]:
    """How a run ended that did not come to its end: in a word, in a sentence, and as an exit code."""
    record = result.record
    status, choice, go_on = (
        record.status,
        record.assembly.choice,
        f"{command()} resume {shlex.quote(str(place.path))}",
    )
    if record.message:
        done = max(len(record.steps) - 1, 0)
        kept = (
            f"The {done} load factors before are kept in {place.path}"
            if done
            else f"The start is kept in {place.path}"
        )
        broken = status == Status.INTERRUPTED
        return (
            status,
            f"{record.message} {kept}{f'; go on with: {go_on}' if broken else '.'}",
            NOW.code if broken else DIVERGED,
        )
    if status == Status.INTERRUPTED:
        made = f"{NOW.by}: {record.reached:,} of {choice.steps:,} steps were made"
        return status, f"{made}; they are kept in {place.path}, and the run goes on with: {go_on}", NOW.code
    if status == Status.ENERGY:
        from ...report.divergence import energy_cause

        return status, f"{energy_cause(result)} All of it is kept in {place.path}.", ENERGY
    if status == Status.DIVERGED:
        from ...report.divergence import diverged

        return status, f"{diverged(record)} What was computed before is kept in {place.path}.", DIVERGED
    return status, "", 0
