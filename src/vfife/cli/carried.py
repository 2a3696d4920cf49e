"""A run under way in its folder, begun or taken up: whatever ends it, what is kept is told, and how to go on."""

from __future__ import annotations

import shlex
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import typer

from ..solvers.status import Status
from .signals import NOW
from .terminal import BAD_INPUT, DIVERGED, ENERGY, STORAGE, command, fail, json_text, output, print_json, tell, writing

if TYPE_CHECKING:
    from ..result import Result
    from ..results.place import RunFolder
    from ..results.runfile import RunFile
    from ..simulation import Prepared
    from ..solvers.record import Checkpoint

RESULT_KEYS = ("status", "step", "steps", "wall_s", "ns_per_step", "energy_error")
NOTHING = "That was before the first step, so there is nothing to keep."


def carried(opened: Callable[[], tuple[RunFile, Prepared, Checkpoint | None]], place: RunFolder, quiet: bool) -> Result:
    """Runs into a place until the run ends, however it does; ends with a sentence and an exit code where it cannot be finished."""
    from ..errors import HeldError, StorageError
    from ..simulation import carry_out
    from .progress import ProgressLine

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
    from ..errors import RunFileError

    if file is not None:
        try:
            file.close()
        except RunFileError:
            return


def kept_in(place: RunFolder) -> str:
    """What is kept of a run that was broken off, in a sentence."""
    if not place.settled:
        return NOTHING
    return f"What was computed until then is kept in {place.path}; go on with: {command()} resume {shlex.quote(str(place.path))}"


def concluded(result: Result, place: RunFolder, figures: bool, as_json: bool, quiet: bool) -> None:
    """Summary, figures, the one object or the tables, and the exit code."""
    from ..codegen.cache import trouble
    from ..files import write_text
    from ..results.folder import SUMMARY

    cached = trouble()
    notes = [*place.notes, *([cached] if cached else []), *result.summary["run"]["notes"], *result.summary["warnings"]]
    if cached and not quiet:
        tell("note", f"{cached}.")
    NOW.saved = f"The run itself is whole, in {place.path}." if result.record.status == Status.COMPLETE else kept_in(place)
    with writing(str(place.path), f"The run itself is whole, in {place.path}."):
        write_text(place.path / SUMMARY, json_text(result.summary) + "\n")
        if figures and result.record.status != Status.INTERRUPTED:
            from ..plots import figures as drawn
            from ..plots import save

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
    told = {key: result.summary[key] for key in ("turns", "part", "measures", "ranges", "not_unique", "not_estimated", "trust")}
    return {**found, "run": str(place.path), "loop": result.record.loop, "notes": notes, **told}


def show(result: Result, place: RunFolder, figures: bool) -> None:
    """The summary, and what to do next."""
    from rich.text import Text

    from ..report.summary import show as show_summary

    console, quoted = output(), shlex.quote(str(place.path))
    show_summary(console, result, result.reference)
    console.print()
    kept = ", ".join(sorted(entry.name + "/" * entry.is_dir() for entry in place.path.iterdir() if entry.name != "run.lock"))
    console.print(Text.assemble(("Run folder: ", "bold"), f"{place.path} ({kept})"))
    then = f"figures are in {place.path / 'figures'}" if figures else f"{command()} plot {quoted}"
    console.print(Text.assemble(("Next: ", "bold"), f"{then}; {command()} info {quoted}; {command()} export {quoted} out.nc"), soft_wrap=True)


def ending(result: Result, place: RunFolder) -> tuple[str, str, int]:
    """How a run ended that did not come to its end: in a word, in a sentence, and as an exit code."""
    record = result.record
    status, choice, go_on = record.status, record.assembly.choice, f"{command()} resume {shlex.quote(str(place.path))}"
    if record.message:
        done = max(len(record.steps) - 1, 0)
        kept = f"The {done} load factors before are kept in {place.path}" if done else f"The start is kept in {place.path}"
        broken = status == Status.INTERRUPTED
        return status, f"{record.message} {kept}{f'; go on with: {go_on}' if broken else '.'}", NOW.code if broken else DIVERGED
    if status == Status.INTERRUPTED:
        made = f"{NOW.by}: {record.reached:,} of {choice.steps:,} steps were made"
        return status, f"{made}; they are kept in {place.path}, and the run goes on with: {go_on}", NOW.code
    if status == Status.ENERGY:
        from ..report.diverged import energy_cause

        return status, f"{energy_cause(result)} All of it is kept in {place.path}.", ENERGY
    if status == Status.DIVERGED:
        from ..report.diverged import diverged

        return status, f"{diverged(record)} What was computed before is kept in {place.path}.", DIVERGED
    return status, "", 0
