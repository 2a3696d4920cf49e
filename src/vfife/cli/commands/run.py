"""``vfife run`` and ``vfife resume``: from a model file to a run folder and a summary; an interrupted run
goes on to the same bits.

What simulates, stores and reports is loaded after the model is read, so that a wrong one is answered at once.
"""

from __future__ import annotations

import shlex
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import typer

from ...compiler.runtime.cache import trouble
from ...errors import HeldError, RunFileError, StorageError
from ...files import write_text
from ...job.activity import ACTIVITY
from ...job.progress import ProgressLine
from ...modelfile import dump
from ...solvers.arguments import RunArguments
from ...solvers.status import Status
from ...store.connections import located
from ...store.folder import MODEL, SUMMARY, RunFolder, existing_run, model_of, placed
from ...store.schemas import RUN, is_run_file
from ..arguments.runs import AnswerOptions, NewRunOptions, ResumeOptions
from ..job import CommandJob
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
from ..values import positive, read_model, take_laws, with_options

if TYPE_CHECKING:
    from ...model.mechanism import Mechanism
    from ...simulation.result import Result
    from ...simulation.simulate import Prepared
    from ...solvers.record import Checkpoint
    from ...store.runfile import RunFile

RESULT_KEYS = ("status", "step", "steps", "wall_s", "ns_per_step", "energy_error")
SUMMARY_KEYS = (
    "turns", "part", "measures", "ranges", "not_unique", "not_estimated", "about_zero", "ground", "trust",
    "warnings", "law_dependent", "law_shocks", "law_loads", "start_fall", "meshes_not_covered",
)  # fmt: skip
NOT_STARTED = "The run had not made a step, so there is nothing to keep."


class OpenRun(NamedTuple):
    """An open run file, what is run into it, and the checkpoint from which the run goes on."""

    file: RunFile
    prepared: Prepared
    last: Checkpoint | None


def run(options: NewRunOptions) -> None:
    """Run ``vfife run``."""
    model, folder = options.model, options.folder
    with sentences(str(model)):
        mechanism = with_options(
            read_model(options.model, options.set_, options.laws),
            options,
            outputs=options.outputs,
            settle=options.settle,
        )
        former_run = folder if folder is not None else Path("runs") / model.stem
        if options.resume and is_run_file(former_run / "run.sqlite"):
            refuse_other_model(former_run, mechanism)
            go_on(former_run, None, options)
            return
        place = placed(folder, model, replace=options.force, start=options.start_from)
    for note in place.notes if not options.quiet else ():
        tell("note", f"{note}.")
    from ...simulation.result import Result
    from ...simulation.simulate import prepare

    with sentences(str(model)):
        former = None if options.start_from is None else Result.load(options.start_from)
        job = CommandJob("run", place.target, options, announced=False)
        arguments = RunArguments(loop=options.loop.value, force_step=options.force_step)
        prepared = prepare(mechanism, arguments, options.reference, former, job)
    run_into(place, lambda: create(place, prepared), options)


def resume(options: ResumeOptions) -> None:
    """Run ``vfife resume``."""
    with sentences(str(options.run)):
        take_laws(options.laws)
        until = positive("--until", options.until, "s")
        go_on(located(RUN, options.run).parent, until, options)


def create(place: RunFolder, prepared: Prepared) -> OpenRun:
    """Create a new run file in its folder."""
    from ...store.runfile import GATHER, RunFile

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
    if model_of(path) != dump(mechanism):
        raise ValueError(
            f"--resume: the run in {path} is that of another model, or of other options; name another folder,"
            " or leave --resume out"
        )


def go_on(path: Path, until: float | None, options: AnswerOptions) -> None:
    """Go on with the run in a folder. Raises HeldError where another process does, ResumeError where there is
    nothing to go on with.
    """
    place = existing_run(path)

    def reopen() -> OpenRun:
        from ...simulation.resumption import reopen_run
        from ...store.runfile import GATHER, RunFile

        file = RunFile.write(place.run_file, gather=GATHER)
        try:
            prepared, last = reopen_run(file, until)
        except BaseException:
            file.close()
            raise
        if not options.quiet:
            tell(
                "note",
                f"continues after step {0 if last is None else last.step:,} of"
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
        ACTIVITY("measuring the run and its companions")
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
    return f"All results up to then are kept in {place.path}; continue with: {resume_command(place)}"


def resume_command(place: RunFolder) -> str:
    """Return the command that continues a run."""
    return f"{command()} resume {shlex.quote(str(place.path))}"


def conclude(result: Result, place: RunFolder, options: AnswerOptions) -> None:
    """Write summary and figures, print the object or the tables, and end with the exit code of the run."""
    cached, record = trouble(), result.record
    warnings = [*result.summary["run"]["notes"], *result.summary["warnings"]]
    if cached and not options.quiet:
        tell("note", f"{cached}.")
    complete = f"The run itself is complete, in {place.path}."
    ENDING.saved = complete if record.status == Status.COMPLETE else saved_sentence(place)
    with writing(str(place.path), complete):
        write_text(place.path / SUMMARY, json_text(result.summary) + "\n")
        if options.figures and record.status != Status.INTERRUPTED:
            from ...plots import figures, save

            ACTIVITY(f"drawing figures in {place.path / 'figures'}")
            save(figures(result, result.reference), place.path / "figures")
    ending = ending_of(result, place)
    if options.as_json:
        data = {key: result.summary[key] for key in RESULT_KEYS}
        data |= {
            "run": str(place.path),
            "loop": record.loop,
            "notes": [*place.notes, *([cached] if cached else []), *warnings],
        }
        data |= {key: result.summary[key] for key in SUMMARY_KEYS if key in result.summary}
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
    from ...report import overview, trust

    certain = not overview.uncertain(result.summary)
    leading = trust.verdict(result.summary) if certain else ""
    for warning in warnings:
        if certain and warning == leading:
            tell("note", overview.certainty(result.summary))
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
    from ...report.divergence import diverged, energy_cause

    record, code = result.record, DIVERGED
    status, next_command = record.status, resume_command(place)
    if record.message:
        done = max(len(record.steps) - 1, 0)
        place_text = (
            f"The {done} load factors before are kept in {place.path}"
            if done
            else f"The start is kept in {place.path}"
        )
        interrupted = status == Status.INTERRUPTED
        sentence = (
            f"{record.message} {place_text}{f'; continue with: {next_command}' if interrupted else '.'}"
        )
        code = ENDING.code if interrupted else DIVERGED
    elif status == Status.INTERRUPTED:
        progress = f"{ENDING.by}: {record.reached:,} of {record.assembly.choice.steps:,} steps were made"
        sentence, code = (
            f"{progress}; they are kept in {place.path}; continue with: {next_command}",
            ENDING.code,
        )
    elif status == Status.ENERGY:
        sentence, code = f"{energy_cause(result)} All results are kept in {place.path}.", ENERGY
    elif status == Status.DIVERGED:
        sentence = f"{diverged(record)} The results before that are kept in {place.path}."
    else:
        sentence, code = "", 0
    return Ending(status, sentence, code)
