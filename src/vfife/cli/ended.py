"""``vfife info``, ``vfife export``: what to do with a run that was made, or that was interrupted or killed."""

from __future__ import annotations

import tomllib
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from ..results.folder import find_run
from ..results.lock import holder
from ..solvers.status import Status
from .options import JsonOption, RunArgument
from .signals import NOW
from .terminal import amount_of_bytes, answer, errors, sentences, writing

if TYPE_CHECKING:
    from ..result import Result


CheckOption = Annotated[bool, typer.Option("--check", help="Read every output of a large file as well, and tell what is damaged.")]


def info(run: RunArgument, check: CheckOption = False, as_json: JsonOption = False) -> None:
    """What a run file holds, also that of a run that was interrupted or killed."""
    with sentences(str(run)):
        found = contents(find_run(run), check)
    from ..report import runfile

    answer(runfile.info(found), as_json)


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
