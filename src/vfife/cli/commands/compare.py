"""``vfife compare``: one model under several laws."""

from __future__ import annotations

import json
import shlex
from pathlib import Path
from typing import Any

import typer

from ...files import read_bytes, write_text
from ...job.cost import START, Forecast
from ...laws import ContactLaw, FrictionLaw
from ...modelfile import dump
from ...report.sensitivity import comparison, comparison_data
from ...solvers.status import Status
from ...store.folder import numbered, refuse_foreign
from ...store.lock import Lock
from ...studies.methods.compare import Comparison, Parts, required_keys
from ...studies.methods.compare import compare as run_laws
from ..arguments.runs import CompareOptions
from ..job import CommandJob
from ..terminal import DIVERGED, end_interrupted, json_text, sentences, tell, writing
from ..values import mechanism_of, with_options

SUMMARY, TABLE, MODEL = "compare.json", "compare.csv", "model.toml"
FIGURES = 1.2  # s of processor time to draw the figures of a comparison


def compare(options: CompareOptions) -> None:
    """Run ``vfife compare``."""
    model = str(options.model)
    with sentences(model):
        mechanism = with_options(mechanism_of(options), options, outputs=options.outputs)
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
        self.besides = START + FIGURES * options.figures

    def begin(self, forecast: Forecast) -> None:
        """Forecast the start of the command and its figures, too."""
        super().begin(forecast.longer(self.besides))

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
        f"Complete runs are kept in {place}; the same command with -o {shlex.quote(str(place))} continues"
        " after them."
    )


def law_names(text: str | None, kind: str) -> list[Any]:
    """Names of laws; for "all" those of a kind that have a default for every parameter."""
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
        former_model = folder / MODEL
        if (
            unfinished(folder / SUMMARY)
            and former_model.is_file()
            and read_bytes(former_model).decode("utf-8") != text
        ):
            raise ValueError(
                f"-o {folder}: the comparison in this folder is of another model or has other"
                " options; add --force to replace it"
            )
        if not unfinished(folder / SUMMARY):
            raise ValueError(
                f"-o {folder}: this folder contains a comparison; name another folder, or add --force to"
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
            f"{row['contact']} with {row['friction']}: the numbers became infinite; use a smaller step",
            "bold red",
        )
    if len(result.rows) < result.planned:
        end_interrupted(
            f": {len(result.rows)} of {result.planned} runs are complete. {saved_sentence(place)}"
        )
    if diverged:
        raise typer.Exit(DIVERGED)
