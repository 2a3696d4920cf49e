"""``vfife compare``: one model under several laws."""

from __future__ import annotations

import json
import shlex
from pathlib import Path
from typing import TYPE_CHECKING, Any

import typer

from ...files import read_bytes, write_text
from ...solvers.status import Status
from ...store.folder import numbered, refuse_foreign
from ...store.lock import Lock
from ..job import CommandJob
from ..options import (
    COMPANIONS,
    OF_MODEL,
    JobOptions,
    JsonOptions,
    LengthOptions,
    ModelOptions,
    OutputsOptions,
    flag,
    option,
    with_options,
)
from ..terminal import DIVERGED, end_interrupted, json_text, sentences, tell, writing

if TYPE_CHECKING:
    from ...studies.methods.compare import Comparison

SUMMARY, TABLE, MODEL = "compare.json", "compare.csv", "model.toml"


class CompareOptions(ModelOptions, LengthOptions, OutputsOptions, JsonOptions, JobOptions):
    """Options of ``vfife compare``."""

    contact: str | None = option(None, 'Contact laws, or "all"; the model\'s own if left out.', "LAW,LAW")
    friction: str | None = option(None, 'Friction laws, or "all"; the model\'s own if left out.', "LAW,LAW")
    joint: list[str] | None = option(None, "Joint whose laws change; all with clearance if left out.", "NAME")
    folder: Path | None = option(
        None, "Folder of the figures.", "FOLDER", "-o", "--output", show_default="runs/MODEL-compare"
    )
    figures: bool = flag("--figures/--no-figures", "Draw the figures as well.", default=True)
    companions: str | None = option("0", COMPANIONS, "N", show_default=OF_MODEL)
    force: bool = flag("--force", "Replace the comparison that is in the folder.")


def compare(options: CompareOptions) -> None:
    """Run a model under several laws and tell how its numbers differ: a table, figures, CSV and JSON.

    Every contact law is paired with every friction law. A law takes over parameters of the one in whose place
    it comes, where both have them. Runs that are complete are kept: after Ctrl-C or a kill the same command
    with -o FOLDER goes on after them.
    """
    from ...modelfile import dump
    from ...report.sensitivity import comparison
    from ...studies.methods.compare import compare as run_laws

    model = str(options.model)
    with sentences(model):
        mechanism = with_options(options.mechanism(), options, outputs=options.outputs)
        place = folder_for(options.folder, options.model, dump(mechanism), options.force)
        job = ComparisonJob(place, dump(mechanism), options)
    try:
        with job.at_work(model):
            pairs = law_names(options.contact, "contact"), law_names(options.friction, "friction")
            settings: dict[str, Any] = {
                "force_step": options.force_step,
                "companions": mechanism.settings.companions,
            }
            result = run_laws(mechanism, *pairs, joints=options.joint, progress=job, folder=place, **settings)
        with writing(str(place), saved_sentence(place)):
            write_results(result, place, options.figures)
    finally:
        if job.lock is not None:
            job.lock.release()
    options.answer(comparison(result, str(place), sorted(entry.name for entry in place.iterdir())))
    end(result, place)


class ComparisonJob(CommandJob):
    """The job of a comparison; its folder is made, and locked, when it begins."""

    lock: Lock | None = None

    def __init__(self, place: Path, text: str, options: CompareOptions) -> None:
        super().__init__("comparison", place, options, saved=saved_sentence(place))
        self.text, self.saved_before = text, self.saved

    def start(self) -> None:
        """Make the folder, in which nobody else writes from now on."""
        self.target.mkdir(parents=True, exist_ok=True)
        self.lock = Lock(self.target)
        self.hold(self.lock)
        write_text(self.target / MODEL, self.text)
        write_text(self.target / SUMMARY, json_text({"model": None, "planned": None, "runs": []}) + "\n")
        super().start()


def write_results(result: Comparison, place: Path, figures: bool) -> None:
    """Write summary, table and figures of a comparison; runs are kept until all of them are made."""
    from ...report.sensitivity import comparison_data
    from ...studies.methods.compare import Parts

    write_text(place / SUMMARY, json_text(comparison_data(result)) + "\n")
    result.write_csv(place / TABLE)
    if figures:
        from ...plots.sensitivity import save_comparison

        save_comparison(result, place)
    if len(result.rows) == result.planned:
        Parts(place).remove()


def saved_sentence(place: Path) -> str:
    """State which runs of an interrupted comparison are saved, and the command that continues it."""
    return (
        f"Runs that are complete are kept in {place}; the same command with -o {shlex.quote(str(place))} goes"
        " on after them."
    )


def law_names(text: str | None, kind: str) -> list[Any]:
    """Names of laws; for "all" those of a kind that have a default for every parameter."""
    from ...laws import ContactLaw, FrictionLaw
    from ...studies.methods.compare import required_keys

    registry = (ContactLaw if kind == "contact" else FrictionLaw).registry
    names = [name.strip().lower() for name in (text or "").split(",") if name.strip()]
    if names != ["all"]:
        return list(dict.fromkeys(names))
    if left := sorted(name for name, law in registry.items() if required_keys(law)):
        tell("note", f"{', '.join(left)} left out: a parameter of each has no default.")
    return sorted(registry.keys() - left)


def folder_for(folder: Path | None, model: Path, text: str, force: bool) -> Path:
    """Return the folder to write into. Raises ValueError for a folder that holds something else, or a
    comparison of another model.
    """
    if folder is None:
        return next(path for path in numbered(Path("runs") / f"{model.stem}-compare") if not path.exists())
    refuse_foreign(folder, SUMMARY, "comparison")
    if (folder / SUMMARY).is_file() and not force:
        before = folder / MODEL
        if unfinished(folder / SUMMARY) and before.is_file() and read_bytes(before).decode("utf-8") != text:
            raise ValueError(
                f"-o {folder}: the comparison that was begun here is that of another model, or of other"
                " options; add --force to replace it"
            )
        if not unfinished(folder / SUMMARY):
            raise ValueError(
                f"-o {folder}: there is a comparison here already; name another folder, or add --force to"
                " replace it"
            )
    return folder


def unfinished(path: Path) -> bool:
    """Whether a comparison was interrupted, as its file says."""
    try:
        summary = json.loads(read_bytes(path))
        return summary["planned"] is None or len(summary["runs"]) < summary["planned"]
    except (OSError, ValueError, KeyError, TypeError, RecursionError):
        return False


def end(result: Comparison, place: Path) -> None:
    """Name the runs that diverged, and end with the exit code of that."""
    diverged = [row for row in result.rows if row["status"] != Status.COMPLETE]
    for row in diverged:
        tell(
            Status.DIVERGED,
            f"{row['contact']} with {row['friction']}: the numbers became infinite; take a smaller step"
            " for it",
            "bold red",
        )
    if len(result.rows) < result.planned:
        end_interrupted(
            f": {len(result.rows)} of {result.planned} runs are complete. {saved_sentence(place)}"
        )
    if diverged:
        raise typer.Exit(DIVERGED)
