"""Commands for a run that was made: info, impacts, plot, animate, report, export."""

from __future__ import annotations

import shlex
import time
import tomllib
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import typer

from ...files import write_text
from ...files.kinds import RUN_FILE
from ...job.activity import ACTIVITY
from ...job.cost import export_forecast
from ...job.progress import ProgressLine
from ...model.surfaces import law_facts
from ...report import run_file
from ...report.document import Document, Table
from ...report.run import document
from ...results.selection import Selection, selection
from ...solvers.status import Progress, Status
from ...store.connections import located, warn_of_damage
from ...store.folder import FIGURES, MODEL
from ...store.lock import holder
from ...store.runfile import RunFile
from ...store.schemas import RUN, STUDY
from ..arguments.runs import (
    AnimateOptions,
    ExportOptions,
    ImpactsOptions,
    InfoOptions,
    PlotOptions,
    ReportOptions,
)
from ..outputs import PICTURES, TABLES, one_target, refuse_ending, refuse_existing
from ..signals import ENDING
from ..terminal import amount_of_bytes, answer, command, errors, fail, sentences, span, tell, writing

if TYPE_CHECKING:
    from ...simulation.result import Result


def info(options: InfoOptions) -> None:
    """Run ``vfife info``."""
    run = options.runs[0]
    if len(options.runs) > 1:
        if names := [f"--{name}" for name in ("long", "measures", "check") if getattr(options, name)]:
            fail(f"{', '.join(names)}: this is of one run, and {len(options.runs)} are named; leave it out")
        labels = [str(path) for path in options.runs]
        results = {label: load(Path(label)) for label in dict.fromkeys(labels)}
        with sentences(", ".join(labels)):
            from ...plots.labels import differences

            mechanisms = [result.record.assembly.mechanism for result in results.values()]
            summaries = {label: result.summary for label, result in results.items()}
            inputs = differences(mechanisms, ("name",))
            answer(run_file.side_by_side(summaries, inputs), options.as_json)
        return
    if options.long and not options.as_json:
        answer(document(load(run).summary))
        return
    ACTIVITY(f"reading {run}")
    with sentences(str(run)):
        data = contents(run, options.check)
    remedy = "Run the model again, or use a backup of the file."
    warn_of_damage(Path(data["file"]), "run", tuple(data["damage"]), remedy)
    answer(run_file.info(data, options.measures), options.as_json)


def contents(path: Path, check: bool = True) -> dict[str, Any]:
    """Read what a run file states without assembling its model. Outputs of a large file are read only for
    ``check``.
    """
    with RunFile.open(path) as file:
        alone = None if check else file.finished_steps()
        meta, steps, events, last = (
            file.meta,
            file.steps if alone is None else alone,
            file.events,
            file.last_checkpoint(),
        )
        # The file notes the damage of these parts when they are read.
        for part in (file.companions, file.turns, file.reference) if alone is None else ():
            part()
        path, reference, damage = file.path, file.has_reference, file.damaged_parts
    choice, text = meta.get("choice", {}), meta.get("model", "")
    model = tomllib.loads(text)
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
        "damage": list(damage),
        "other_model": path.name == RUN_FILE and bool(text) and is_other_model(path.parent / MODEL, text),
        "checked": alone is None,
        "channels": sorted({name for name, _ in meta.get("kept", ())}),
        "laws": meta.get("laws", {}),
        "own_laws": [
            {key: law[key] for key in ("name", "kind", "file", "text")} for law in meta.get("own_laws", ())
        ],
        "reference": reference,
        "checkpoint": last[0] if last is not None else None,
        "wall_s": meta.get("wall"),
        "events": [{"step": step, "time": time, "text": text} for step, time, text in events],
        "summary": meta.get("summary"),
    }


def is_other_model(path: Path, text: str) -> bool:
    """Return whether the model file of a run folder, where there is one, differs from the text of the model
    that ran.
    """
    try:
        return path.read_text(encoding="utf-8") != text
    except FileNotFoundError:
        return False
    except (OSError, UnicodeDecodeError):
        return True


ADVICE = "--channels, --turns and --last write less."
LARGE_EXPORT = 5_000_000  # bytes of a file from which on it is said how to write less
LONG_EXPORT = 2.0  # s of an export that is announced
REPORT_SECONDS = 6.0  # s that the figures of a report take on common processors
UNCHANGED = "The run is unchanged"
AS_BEFORE = f"{UNCHANGED}, and so are existing files."
ENDINGS = (
    ".csv",
    ".xlsx",
    ".nc",
    ".nc4",
    ".h5",
    ".mat",
    ".parquet",
    ".svg",
    ".pdf",
    ".png",
)  # as Result.export has them; a test compares


def export(options: ExportOptions) -> None:
    """Run ``vfife export``."""
    with sentences(str(options.run)):
        target = one_target(options.out, options.target)
    with sentences(str(target)):
        refuse_ending(target, ENDINGS)
        refuse_existing(target, options.force)
    ENDING.saved = f"Nothing was written. {AS_BEFORE}"
    result = load(options.run)
    names = options.channels
    part: dict[str, Any] = {"turns": options.turns, "by_angle": options.last}
    if options.turns is not None and options.last:
        fail("--last: this is the last turn, and --turns names others; leave one of them out")
    with sentences(str(options.run)), writing(str(target), AS_BEFORE):
        tables = options.figure is None and target.suffix.lower() not in PICTURES
        advised = not tables or options.turns is not None or options.last or bool(names)
        if tables:
            advised |= announce(target, selection(result, names, **part))
        else:
            ACTIVITY(f"drawing {target}")
        result.export(target, options.figure, options.decimal, channels=names, **part)
    size = target.stat().st_size
    typer.echo(f"{target} ({amount_of_bytes(size)})")
    if size > LARGE_EXPORT and not advised:
        tell("note", f"{target} has all series of the whole run: {ADVICE}")


def announce(target: Path, part: Selection) -> bool:
    """Print the forecast of a large export; return whether it says how to write less."""
    ACTIVITY(f"writing {target}")
    ending = target.suffix.lower()
    cost = export_forecast(ending, part.count, len(part.columns(fine=ending not in TABLES)))
    ACTIVITY(f"writing {target}", cost.seconds)
    if cost.seconds > LONG_EXPORT:
        tell("forecast", cost.sentence(target), "bold")
        if part.rows is None and not part.channels:
            tell("note", ADVICE)
            return True
    return False


def load(run: Path) -> Result:
    """Load the result of a run, with a note where the run did not reach its end."""
    with sentences(str(run)):
        result = open_result(run)
    if result.record.status != Status.COMPLETE:
        errors().print(
            f"note: this run ended as {result.record.status}; its results up to then are used", markup=False
        )
    return result


def impacts(options: ImpactsOptions) -> None:
    """Run ``vfife impacts``."""
    with sentences(str(options.run)):
        result = open_result(options.run)
        ACTIVITY(f"searching for impacts in {options.run}")
        impacts = result.impacts
    facts = law_facts(result.record.assembly.mechanism)
    answer(run_file.impacts(impacts, options.count, facts), options.as_json)


LIST = "list"


def plot(options: PlotOptions) -> None:
    """Run ``vfife plot``."""
    run, out, at = options.runs[0], options.out, options.at
    if f".{options.kind}" not in PICTURES:
        fail(
            f"--format {options.kind}: figures have no such format; allowed:"
            f" {', '.join(ending[1:] for ending in PICTURES)}"
        )
    ENDING.saved = f"{UNCHANGED}, and no figure was drawn."
    names = [name for text in options.figure or () for name in text.split(",")]
    results = [load(path) for path in options.runs]
    result = results[0]
    if LIST in names:
        list_figures(result)
        return
    with sentences(str(run)):
        from ...plots import check_count, chosen, only_mechanism, overlaid, run_labels

        labels, left_out = run_names(options.label or [], len(results)), ""
        check_count(results, labels)
        if len(results) > 1:
            if at is not None:
                raise ValueError("--at: the mechanism is drawn at a moment of one run; name one run with it")
            labels = labels or run_labels(results, [path.resolve().stem for path in options.runs])
            figures, left_out = overlaid(results, names, labels)
        else:
            if at is not None:
                only_mechanism(names)
            figures = chosen(result, names or (["mechanism"] if at is not None else []))
    single = out is not None and out.suffix.lower() in PICTURES
    if single and len(figures) != 1:
        fail(
            f"-o {out}: one file holds one figure and this draws {len(figures)}; name one with --figure, or a"
            " folder"
        )
    folder = located(RUN, run).parent / FIGURES if len(results) == 1 else overlay_folder(options.runs)
    folder = folder if out is None else out
    targets = (
        {figures[0]: folder} if single else {name: folder / f"{name}.{options.kind}" for name in figures}
    )
    refuse_figures(targets, options.force)
    draw(results, labels, targets, at)
    if left_out:
        typer.echo(left_out, err=True)
    if not names and at is None:
        typer.echo(f"More: {command()} plot {shlex.quote(str(run))} --figure {LIST}", err=True)


def refuse_figures(targets: dict[str, Path], force: bool) -> None:
    """End where figures exist already, unless they may be replaced."""
    existing = [path for path in targets.values() if path.exists()]
    if len(targets) == 1:
        (path,) = targets.values()
        with sentences(str(path)):
            if path.exists() or path.parent.is_file():
                refuse_existing(path, force)
    elif existing and not force:
        names = ", ".join(path.name for path in existing)
        fail(
            f"{existing[0].parent}: there are figures already: {names}; name another folder with -o, or add"
            " --force to replace them"
        )


def overlay_folder(runs: list[Path]) -> Path:
    """Return the folder for figures of several runs, beside the first of them."""
    first, second, *remaining = (path.resolve() for path in runs)
    return first.with_name(f"{first.stem}-and-{f'{len(remaining) + 1}-others' if remaining else second.stem}")


def run_names(texts: list[str], count: int) -> list[str]:
    """Return the names of ``--label`` for so many runs, repeated or with commas between them."""
    return texts if len(texts) == count else [name.strip() for text in texts for name in text.split(",")]


def draw(results: list[Result], labels: list[str], targets: dict[str, Path], at: str | None) -> None:
    """Draw one figure after the other, each of them complete or not there."""
    from ...plots import figure, overlay
    from ...plots.style import saved

    for done, (name, path) in enumerate(targets.items(), 1):
        ACTIVITY(f"drawing figure {done} of {len(targets)}, {name}")
        with sentences(str(path)), writing(str(path), AS_BEFORE):
            if len(results) > 1:
                drawing = overlay(name, results, labels)
            else:
                drawing = figure(results[0], name, results[0].reference, at)
            path.parent.mkdir(parents=True, exist_ok=True)
            saved(drawing, path)
        typer.echo(path)
        ENDING.saved = f"{UNCHANGED}; {done} of {len(targets)} figures were drawn, in {path.parent}."


def list_figures(result: Result) -> None:
    """Print what figures there are, and for which of them the run has no data."""
    from ...plots.catalogue import FIGURES

    rows = []
    for name, figure in FIGURES.items():
        reason = figure.missing(result)
        rows.append(
            (name, figure.description, f"none: {reason}" if reason else "usual" if figure.usual else "")
        )
    answer(Document([Table(("figure", "shows", ""), rows)]))


def animate(options: AnimateOptions) -> None:
    """Run ``vfife animate``."""
    target = options.out if options.out is not None else named_after(options.run, ".gif")
    with sentences(str(target)):
        refuse_existing(target, options.force)
    start = time.monotonic()
    result = load(options.run)
    ENDING.saved = f"No film was written. {AS_BEFORE}"
    with sentences(str(target)), writing(str(target), AS_BEFORE):
        from ...plots.filmfiles import animate as write_film

        with ProgressLine(options.quiet) as line:

            def report(done: int, total: int) -> None:
                line(Progress(done, total, time.monotonic() - start, f"{done} of {total} frames drawn"))

            frames, seconds = write_film(result, target, options.frames, options.fps, options.turns, report)
    size, took = amount_of_bytes(target.stat().st_size), span(time.monotonic() - start)
    typer.echo(f"{target} ({size}, {frames} frames, {seconds:.3g} s long, written in {took})")


def report(options: ReportOptions) -> None:
    """Run ``vfife report``."""
    run = options.run
    is_study = STUDY.owns(run)
    target = options.out if options.out is not None else named_after(run, "-report.html")
    with sentences(str(target)):
        from ...live.page.reports import report as write_report
        from ...live.page.reports import report_ending, study_report, write_study_pdf
        from .study import read

        ending = report_ending(target)
        refuse_existing(target, options.force)
    unchanged = "The study and existing files are unchanged." if is_study else AS_BEFORE
    ENDING.saved = f"No report was written. {unchanged}"
    result: Any = read(run) if is_study else load(run)
    ACTIVITY(f"drawing the figures of {target}", REPORT_SECONDS)
    with sentences(str(run)), writing(str(target), unchanged):
        notes: Sequence[str] = ()
        if is_study and ending == ".pdf":
            write_study_pdf(result, target, options.author, options.logo)
        elif is_study:
            page, notes = study_report(result, not options.no_live, options.author, options.logo)
            write_text(target, page)
        else:
            notes = write_report(result, target, not options.no_live, options.author, options.logo)
    for note in notes:
        tell("note", note)
    advice = "" if ending == ".pdf" else "; open it in a browser, and print it from there"
    typer.echo(f"{target} ({amount_of_bytes(target.stat().st_size)}){advice}.")


def named_after(run: Path, ending: str) -> Path:
    """Return the path of a file in the current folder, named after a run."""
    return Path(f"{(run.resolve() if run.is_dir() else run).stem}{ending}")


def open_result(run: Path) -> Result:
    """Return the result of a run, whose class takes time to load."""
    ACTIVITY(f"reading {run}")
    from ...simulation.result import Result

    return Result.load(run)
