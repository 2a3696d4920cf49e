"""``vfife run`` and ``vfife resume``: from a model file to a run folder and a summary; an interrupted run
goes on to the same bits.
"""

from __future__ import annotations

import shlex
from collections.abc import Callable, Iterable
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import typer

from ...compiler.runtime.cache import trouble
from ...errors import HeldError, RunFileError, StorageError
from ...files import write_text
from ...job.progress import ProgressLine
from ...solvers.status import Status
from ...store.folder import MODEL, SUMMARY, existing_run, model_of, placed
from ...store.schemas import RUN, is_run_file
from ..job import CommandJob
from ..options import (
    OF_MODEL,
    JobOptions,
    JsonOptions,
    LawOptions,
    LengthOptions,
    ModelOptions,
    OutputsOptions,
    QuietOptions,
    RunOptions,
    flag,
    option,
    positive,
    take_laws,
    with_options,
)
from ..signals import ENDING
from ..terminal import (
    BAD_INPUT,
    DIVERGED,
    ENERGY,
    STORAGE,
    answer,
    command,
    fail,
    json_text,
    print_json,
    print_line,
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
RESULT_KEYS = ("status", "step", "steps", "wall_s", "ns_per_step", "energy_error")
SUMMARY_KEYS = ("turns", "part", "measures", "ranges", "not_unique", "not_estimated", "trust")
NOT_STARTED = "That was before the first step, so there is nothing to keep."


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


class NewRunOptions(ModelOptions, LengthOptions, OutputsOptions, AnswerOptions, JobOptions):
    """Options of ``vfife run``."""

    folder: Path | None = option(None, "Run folder.", "FOLDER", "-o", "--output", show_default="runs/MODEL")
    settle: str | None = option(
        None,
        "End as soon as turns repeat within this share of their largest values, as in 1%, after --turns at"
        " the latest.",
        "SHARE",
        show_default=OF_MODEL,
    )
    loop: Loops = option(Loops.auto, "Loop that makes the steps; all give the same bits.")
    reference: bool = flag("--reference/--no-reference", "Compare with the ideal mechanism.", default=True)
    start_from: Path | None = option(
        None, "A new run from where a former one ended (its folder or file), by its clock.", "RUN"
    )
    force: bool = flag("--force", "Replace the run that is in the folder.")
    resume: bool = flag("--resume", "Go on with the run in the folder, if this model was begun there.")


class ResumeOptions(RunOptions, LawOptions, AnswerOptions):
    """Options of ``vfife resume``."""

    until: str | None = option(
        None, 'Time at which it ends, such as 0.5 or "500 ms".', "SECONDS", show_default="as planned"
    )


class OpenRun(NamedTuple):
    """An open run file, what is run into it, and the checkpoint from which the run goes on."""

    file: RunFile
    prepared: Prepared
    last: Checkpoint | None


def run(options: NewRunOptions) -> None:
    """Run a model and answer on one screen: forces, knocks, losses, and how certain they are.

    The folder holds the run file, the model as it was run, the summary, and figures where they are asked for;
    a run that is there already stays unless --force is given. Exit codes: 2 for input that cannot be used, 3
    where the numbers became infinite or no equilibrium was found, 5 where something could not be written,
    130, 143 and 129 after Ctrl-C, SIGTERM and SIGHUP, which keep what was computed.
    """
    model, folder = options.model, options.folder
    with sentences(str(model)):
        mechanism = with_options(options.mechanism(), options, outputs=options.outputs, settle=options.settle)
        former_run = folder if folder is not None else Path("runs") / model.stem
        if options.resume and is_run_file(former_run / "run.sqlite"):
            refuse_other_model(former_run, mechanism)
            go_on(former_run, None, options)
            return
        place = placed(folder, model, replace=options.force, start=options.start_from)
    for note in place.notes if not options.quiet else ():
        tell("note", f"{note}.")
    with sentences(str(model)):
        from ...simulation.result import Result
        from ...simulation.simulate import prepare
        from ...solvers.arguments import RunArguments

        former = None if options.start_from is None else Result.load(options.start_from)
        job = CommandJob("run", place.target, options, announced=False)
        arguments = RunArguments(loop=options.loop.value, force_step=options.force_step)
        prepared = prepare(mechanism, arguments, options.reference, former, job)
    run_into(place, lambda: create(place, prepared), options)


def resume(options: ResumeOptions) -> None:
    """Go on with a run that was interrupted or killed, as if nothing had happened: the same numbers, to the
    bit.

    With --until a run ends later than planned, also one that is complete; its step stays what it is. Exit
    codes are those of vfife run.
    """
    with sentences(str(options.run)):
        take_laws(options.laws)
        until = positive("--until", options.until, "s")
        from ...store.connections import located

        go_on(located(RUN, options.run).parent, until, options)


def create(place: RunFolder, prepared: Prepared) -> OpenRun:
    """Create a new run file in its folder."""
    from ...store.runfile import RunFile

    meta = prepared.run_meta
    place.begin()
    (place.path / MODEL).write_text(
        meta["model"], encoding="utf-8"
    )  # in a folder that this process has just made
    file = RunFile.create(place.run_file, meta, gather=GATHER)
    file.arrive = place.settle
    return OpenRun(file, prepared, None)


def refuse_other_model(path: Path, mechanism: Mechanism) -> None:
    """Raise ValueError where the run in a folder is not that of the mechanism."""
    from ...modelfile import dump

    if model_of(path) != dump(mechanism):
        raise ValueError(
            f"--resume: the run in {path} is that of another model, or of other options; name another folder,"
            " or leave --resume out"
        )


def go_on(path: Path, until: float | None, options: AnswerOptions) -> None:
    """Go on with the run in a folder. Raises HeldError where another process does, ResumeError where there is
    nothing to go on with.
    """
    from ...simulation.simulate import reopen_run
    from ...store.runfile import RunFile

    place = existing_run(path)

    def reopen() -> OpenRun:
        file = RunFile.write(place.run_file, gather=GATHER)
        try:
            prepared, last = reopen_run(file, until)
        except BaseException:
            file.close()
            raise
        if not options.quiet:
            tell(
                "note",
                f"goes on after step {0 if last is None else last.step:,} of"
                f" {prepared.assembly.choice.steps:,}.",
            )
        return OpenRun(file, prepared, last)

    run_into(place, reopen, options, lengthened=until is not None)


# ------------------------------------------------------------------------------------------------------ flow


def run_into(
    place: RunFolder, open_run: Callable[[], OpenRun], options: AnswerOptions, lengthened: bool = False
) -> None:
    """Run into a place, and describe the result; the model of a ``lengthened`` run is written anew."""
    try:
        result = simulate_into(place, open_run, options.quiet)
        if lengthened:
            from ...modelfile import dump

            write_text(place.path / MODEL, dump(result.record.assembly.mechanism))
        conclude(result, place, options)
    finally:
        place.leave()


def simulate_into(place: RunFolder, open_run: Callable[[], OpenRun], quiet: bool) -> Result:
    """Run into a place until the run ends, in whatever way; ends with a sentence and an exit code where it
    cannot be finished.
    """
    from ...simulation.simulate import run_prepared

    ENDING.saved = NOT_STARTED if not place.settled else saved_sentence(place)
    ENDING.last.append(place.leave)
    file: RunFile | None = None
    try:
        file, prepared, last = open_run()
        with ProgressLine(quiet) as line:
            result = run_prepared(prepared, progress=line, file=file, resume=last)
        ENDING.saved = saved_sentence(place)
        if result.record.status == Status.INTERRUPTED:
            file.put({"status": Status.INTERRUPTED})  # a summary of a long run takes its time
        result.finish(file)
        file.close()
        return result
    except KeyboardInterrupt:
        close(file)
        fail(f"{ENDING.by}. {saved_sentence(place)}", ENDING.code, word="interrupted")
    except (StorageError, OSError, MemoryError) as error:
        close(file)
        fail(f"{str(error) or 'there is not enough memory'} {saved_sentence(place)}", STORAGE)
    except HeldError as error:
        close(file)
        fail(str(error), BAD_INPUT)
    finally:
        close(file)
        if not place.settled:
            place.leave()


def close(file: RunFile | None) -> None:
    """Close a run file in whatever state it is: what was not committed is lost."""
    if file is not None:
        try:
            file.close()
        except RunFileError:
            return


def saved_sentence(place: RunFolder) -> str:
    """State which part of an interrupted run is saved."""
    if not place.settled:
        return NOT_STARTED
    return f"What was computed until then is kept in {place.path}; go on with: {resume_command(place)}"


def resume_command(place: RunFolder) -> str:
    """Return the command that continues a run."""
    return f"{command()} resume {shlex.quote(str(place.path))}"


def conclude(result: Result, place: RunFolder, options: AnswerOptions) -> None:
    """Write summary and figures, print the object or the tables, and end with the exit code of the run."""
    cached, record = trouble(), result.record
    warnings = [*result.summary["run"]["notes"], *result.summary["warnings"]]
    if cached and not options.quiet:
        tell("note", f"{cached}.")
    complete = f"The run itself is whole, in {place.path}."
    ENDING.saved = complete if record.status == Status.COMPLETE else saved_sentence(place)
    with writing(str(place.path), complete):
        write_text(place.path / SUMMARY, json_text(result.summary) + "\n")
        if options.figures and record.status != Status.INTERRUPTED:
            from ...plots import figures, save

            save(figures(result, result.reference), place.path / "figures")
    ending = ending_of(result, place)
    if options.as_json:
        data = {key: result.summary[key] for key in RESULT_KEYS}
        data |= {
            "run": str(place.path),
            "loop": record.loop,
            "notes": [*place.notes, *([cached] if cached else []), *warnings],
        }
        data |= {key: result.summary[key] for key in SUMMARY_KEYS}
        print_json(data | {"faults": [{"what": ending.sentence}] if ending.sentence else []})
    elif not options.quiet:
        show(result, place, options)
    elif record.status == Status.COMPLETE:
        warn(result, warnings)
    place.leave()
    if ending.code:
        tell(ending.word, ending.sentence, "bold yellow" if ending.word == Status.INTERRUPTED else "bold red")
        raise typer.Exit(ending.code)


def warn(result: Result, warnings: Iterable[str]) -> None:
    """Print warnings; where forces and torques are certain, what else depends on the step is a note."""
    from ...report.overview import certainty, uncertain
    from ...report.trust import verdict

    certain = not uncertain(result.summary)
    leading = verdict(result.summary) if certain else ""
    for warning in warnings:
        if certain and warning == leading:
            tell("note", certainty(result.summary))
        else:
            tell("warning", warning)


def show(result: Result, place: RunFolder, options: AnswerOptions) -> None:
    """Print the answer of a run, and what to do next."""
    from ...report.overview import overview
    from ...report.run import document

    answer((document if options.long else overview)(result.summary))
    quoted = shlex.quote(str(place.path))
    figures = f"figures are in {place.path / 'figures'}" if options.figures else f"{command()} plot {quoted}"
    print_line(f"Run folder: {place.path}")
    measures = result.summary["measures"].items()
    knocks = any(value for name, value in measures if name.endswith(".approach_speed.max"))
    noise = f"; {command()} help noise" if knocks else ""
    print_line(f"Next: {figures}; {command()} info {quoted} --long; {command()} report {quoted}{noise}")


class Ending(NamedTuple):
    """How a run ended that did not come to its end: in a word, in a sentence, and as an exit code."""

    word: str
    sentence: str
    code: int


def ending_of(result: Result, place: RunFolder) -> Ending:
    """How a run ended; its code is 0 where it is complete."""
    record, code = result.record, DIVERGED
    status, again = record.status, resume_command(place)
    if record.message:
        done = max(len(record.steps) - 1, 0)
        place_text = (
            f"The {done} load factors before are kept in {place.path}"
            if done
            else f"The start is kept in {place.path}"
        )
        interrupted = status == Status.INTERRUPTED
        sentence = f"{record.message} {place_text}{f'; go on with: {again}' if interrupted else '.'}"
        code = ENDING.code if interrupted else DIVERGED
    elif status == Status.INTERRUPTED:
        progress = f"{ENDING.by}: {record.reached:,} of {record.assembly.choice.steps:,} steps were made"
        sentence, code = (
            f"{progress}; they are kept in {place.path}, and the run goes on with: {again}",
            ENDING.code,
        )
    elif status == Status.ENERGY:
        from ...report.divergence import energy_cause

        sentence, code = f"{energy_cause(result)} All of it is kept in {place.path}.", ENERGY
    elif status == Status.DIVERGED:
        from ...report.divergence import diverged

        sentence = f"{diverged(record)} What was computed before is kept in {place.path}."
    else:
        sentence, code = "", 0
    return Ending(status, sentence, code)
