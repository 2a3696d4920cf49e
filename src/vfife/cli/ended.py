"""``vfife info``, ``vfife export``: what to do with a run that was made, or that was interrupted or killed."""

from __future__ import annotations

import tomllib
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from ..results.folder import find_run
from ..results.lock import holder
from ..solvers.status import Status
from .options import JsonOption, RunArgument
from .signals import NOW
from .terminal import amount_of_bytes, errors, output, print_json, sentences, span, writing

if TYPE_CHECKING:
    from ..result import Result


CheckOption = Annotated[bool, typer.Option("--check", help="Read every output of a large file as well, and tell what is damaged.")]


def info(run: RunArgument, check: CheckOption = False, as_json: JsonOption = False) -> None:
    """What a run file holds, also that of a run that was interrupted or killed."""
    with sentences(str(run)):
        found = contents(find_run(run), check)
    if as_json:
        print_json(found)
        return
    from rich.table import Table
    from rich.text import Text

    table = Table.grid(padding=(0, 2))
    for name, text in lines(found):
        table.add_row(Text(name, style="cyan"), Text(text))
    output().print(table)


def contents(path: Path, check: bool = True) -> dict[str, Any]:
    """What is known of a run without assembling its model. The outputs of a large file are read where they are to be checked."""
    from ..results.runfile import RunFile

    with RunFile.open(path) as file:
        alone = None if check else file.steps_alone()
        meta, steps, events, last = file.meta, file.steps if alone is None else alone, file.events, file.last_checkpoint()
        reference, lost = file.has_reference, file.lost
    choice, model = meta.get("choice", {}), tomllib.loads(meta.get("model", ""))
    status = meta.get("status", "unknown")
    return {
        "file": str(path),
        "bytes": path.stat().st_size,
        "status": Status.UNFINISHED if status == Status.RUNNING else status,
        "model": model.get("name", ""),
        "source": meta.get("source"),
        "created": meta.get("created"),
        "finished": meta.get("finished"),
        "versions": meta.get("versions", {}),
        "loop": meta.get("loop"),
        "step": meta.get("step"),
        "steps": int(steps[-1]) if len(steps) else 0,
        "static": model.get("run", {}).get("analysis") == "static",
        "steps_planned": choice.get("outputs", 0) * choice.get("outputs_every", 0),
        "turn": choice.get("turn"),
        "outputs": len(steps),
        "written_by": holder(path.parent),
        "damage": list(lost),
        "checked": alone is None,
        "channels": sorted({name for name, _ in meta.get("kept", ())}),
        "laws": meta.get("laws", {}),
        "own_laws": [{key: law[key] for key in ("name", "kind", "file", "text")} for law in meta.get("own_laws", ())],
        "reference": reference,
        "checkpoint": last[0] if last is not None else None,
        "wall_s": meta.get("wall"),
        "events": [{"step": step, "time": time, "text": text} for step, time, text in events],
        "summary": meta.get("summary"),
    }


def lines(found: Mapping[str, Any]) -> Iterator[tuple[str, str]]:
    """The same for people: names and texts."""
    yield "Run file", f"{found['file']}, {amount_of_bytes(found['bytes'])}"
    yield "Model", f"{found['model']}" + (f", from {found['source']}" if found["source"] else "")
    ending = f", finished {found['finished']}" if found["finished"] else ": killed; what it wrote is whole, and vfife resume goes on with it"
    if found["written_by"]:
        ending = f"; {found['written_by']} is at work on it"
    yield "Status", f"{found['status']}; begun {found['created']}{ending}"
    if found["step"] and found["static"]:
        yield "Load factors", f"{found['steps']:,} of {found['steps_planned']:,}"
    elif found["step"]:
        time = found["steps"] * found["step"]
        turns = f" = {time / found['turn']:.4g} turns" if found["turn"] else ""
        yield "Steps", f"{found['steps']:,} of {found['steps_planned']:,}, of {found['step']:.6g} s: {time:.6g} s{turns}"
    yield "Outputs", f"{found['outputs']:,}, of {len(found['channels'])} kinds of numbers each"
    yield "Checkpoint", in_words(found["checkpoint"])
    yield "Reference", "the ideal mechanism is kept beside it" if found["reference"] else "none"
    wall = f", {span(found['wall_s'])}" if found["wall_s"] else ""
    versions = ", ".join(f"{name} {version}" for name, version in found["versions"].items())
    yield "Computed by", f"{found['loop']} loop{wall}; {versions}"
    for name, source in found["laws"].items():
        yield "Law", f"{name}: {source}"
    for law in found["own_laws"]:
        text = "its text is kept here (--json prints it)" if law["text"] else "its text could not be kept"
        yield "Own law", f"{law['name']} ({law['kind']}), from {law['file']}: {text}; reading this run does not run it"
    if found["damage"]:
        yield "Damage", f"{', '.join(found['damage'])} cannot be read"
    if not found["checked"]:
        yield "Outputs", "are not looked at for damage in so large a file; --check does, and so does whatever reads them"
    for event in found["events"]:
        yield "Event", f"step {event['step']:,}: {event['text']} ({event['time']})"
    if part := (found["summary"] or {}).get("part"):
        yield "Measures", f"{part}; counts, shares and energies are those of the whole run; in SI units, lip in %"
    from ..report.digits import bounds, plain

    for name in (found["summary"] or {}).get("measures") or {}:
        yield "Measure", f"{name} = {plain(found['summary'], name)} ({bounds(found['summary'], name)})"


def in_words(step: int | None) -> str:
    """A checkpoint in words."""
    return "none" if step is None else f"step {step:,}"


ENDINGS = (".csv", ".nc", ".nc4", ".h5", ".mat", ".parquet", ".svg", ".pdf", ".png")  # as Result.export has them; a test compares
AS_IT_WAS = "The run is as it was, and so is what was there before."
ForceFile = Annotated[bool, typer.Option("--force", help="Replace the file if there is one.")]


def export(
    run: RunArgument,
    target: Annotated[
        Path,
        typer.Argument(
            metavar="OUT", help="File to write: .csv, .nc, .mat, .parquet; a figure as .svg, .pdf, .png, by its name.", show_default=False
        ),
    ],
    figure: Annotated[str | None, typer.Option("--figure", metavar="NAME", help="The figure, if the file is not called by its name.")] = None,
    force: ForceFile = False,
) -> None:
    """Write all channels of a run with their units, or a figure, in the format that the file's ending says."""
    with sentences(str(target)):
        refuse_ending(target, ENDINGS)
        refuse_taken(target, force)
    NOW.saved = f"Nothing was written. {AS_IT_WAS}"
    result, _ = loaded(run)
    with sentences(str(run)), writing(str(target), AS_IT_WAS):
        result.export(target, figure)
    typer.echo(f"{target} ({amount_of_bytes(target.stat().st_size)})")


def refuse_ending(target: Path, endings: Sequence[str]) -> None:
    """Raises ValueError where the ending of a file says none of the formats that there are."""
    if target.suffix.lower() not in endings:
        known = f"{', '.join(endings[:-1])} and {endings[-1]}"
        raise ValueError(f'nothing is written as "{target.suffix or target.name}"; name a file such as {target.stem}.csv: there are {known}')


def refuse_taken(target: Path, force: bool) -> None:
    """Raises ValueError where a file cannot be written, or takes the place of another one that ``force`` does not give up."""
    if target.is_dir():
        raise ValueError(f"this is a folder; name a file, such as out{target.suffix}")
    if target.exists() and not force:
        raise ValueError("there is a file of this name already; name another one, or add --force to replace it")
    if not target.absolute().parent.is_dir():
        raise ValueError(f"there is no folder {target.absolute().parent}; make it first")


def loaded(run: Path) -> tuple[Result, Path]:
    """The result of a run and its file; says so where the run did not come to its end."""
    with sentences(str(run)):
        from ..result import Result

        file = find_run(run)
        result = Result.load(file)
    if result.record.status != Status.COMPLETE:
        errors().print(f"note: this run ended as {result.record.status}; what it wrote until then is used", markup=False)
    return result, file
