"""``vfife compare``: one model under several laws."""

from __future__ import annotations

import json
import shlex
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from ...files import read_bytes, write_text
from ...solvers.status import Status
from ...store.folder import numbered, refuse_foreign
from ...store.lock import Lock
from ..job import CommandJob
from ..options import JsonOption, LawsOption, ModelArgument, SetOption, read_model, with_options
from ..signals import NOW
from ..terminal import DIVERGED, answer, json_text, sentences, tell, writing
from .run import Companions, Duration, Figures, Force, ForceStep, Outputs, Quiet, Step, Turns, Yes

if TYPE_CHECKING:
    from ...results.comparison import Comparison
    from ...store.lock import Lock

SUMMARY, TABLE, MODEL = "compare.json", "compare.csv", "model.toml"
Folder = Annotated[
    Path | None,
    typer.Option("-o", "--output", metavar="FOLDER", help="Where to.", show_default="runs/MODEL-compare"),
]
Contact = Annotated[
    str | None,
    typer.Option(
        metavar="LAW,LAW", help='Contact laws, or "all"; the model\'s own if left out.', show_default=False
    ),
]
Friction = Annotated[
    str | None,
    typer.Option(
        metavar="LAW,LAW", help='Friction laws, or "all"; the model\'s own if left out.', show_default=False
    ),
]
JointOption = Annotated[
    list[str] | None,
    typer.Option("--joint", metavar="NAME", help="Joint whose laws change; all with clearance if left out."),
]


def compare(
    model: ModelArgument,
    contact: Contact = None,
    friction: Friction = None,
    joint: JointOption = None,
    folder: Folder = None,
    set_: SetOption = None,
    laws: LawsOption = None,
    step: Step = None,
    turns: Turns = None,
    duration: Duration = None,
    outputs: Outputs = None,
    figures: Figures = True,
    force_step: ForceStep = False,
    companions: Companions = "0",
    force: Force = False,
    yes: Yes = False,
    as_json: JsonOption = False,
    quiet: Quiet = False,
) -> None:
    """Run a model under several laws and tell how its numbers differ: a table, figures, CSV and JSON.

    Every contact law is paired with every friction law. A law takes over parameters of the one in whose place
    it comes, where both have them. Runs that are complete are kept: after Ctrl-C or a kill the same command
    with -o FOLDER goes on after them.
    """
    from ...modelfile import dump
    from ...report.sensitivity import comparison, comparison_data
    from ...studies.methods.compare import Parts
    from ...studies.methods.compare import compare as compared

    with sentences(str(model)):
        mechanism = with_options(
            read_model(model, set_, laws),
            step=step,
            turns=turns,
            duration=duration,
            outputs=outputs,
            companions=companions,
        )
        place = folder_for(folder, model, dump(mechanism), force)
        job = ComparisonJob(place, dump(mechanism), yes, quiet)
    try:
        with job.at_work(str(model), job.saved):
            kinds, beside = (
                (named(contact, "contact"), named(friction, "friction")),
                mechanism.settings.companions,
            )
            found = compared(
                mechanism,
                *kinds,
                joints=joint,
                progress=job,
                force_step=force_step,
                companions=beside,
                folder=place,
            )
        with writing(str(place), kept_in(place)):
            write_text(place / SUMMARY, json_text(comparison_data(found)) + "\n")
            found.write_csv(place / TABLE)
            if figures:
                from ...plots.sensitivity import save_comparison

                save_comparison(found, place)
            if len(found.rows) == found.planned:
                Parts(place).remove()
    finally:
        if job.lock is not None:
            job.lock.release()
    if as_json or not quiet:
        answer(comparison(found, str(place), sorted(entry.name for entry in place.iterdir())), as_json)
    end(found, place)


class ComparisonJob(CommandJob):
    """The job of a comparison; its folder is made, and locked, when it begins."""

    def __init__(self, place: Path, text: str, yes: bool, quiet: bool) -> None:
        super().__init__("comparison", place, yes=yes, quiet=quiet, saved=kept_in(place))
        self.text, self.lock = text, None

    lock: Lock | None

    def start(self) -> None:
        """Make the folder, in which nobody else writes from now on."""

        self.target.mkdir(parents=True, exist_ok=True)
        self.lock = Lock(self.target)
        self.hold(self.lock)
        write_text(self.target / MODEL, self.text)
        write_text(self.target / SUMMARY, json_text({"model": None, "planned": None, "runs": []}) + "\n")
        super().start()


def kept_in(place: Path) -> str:
    """What is kept of a comparison that was broken off."""
    return (
        f"Runs that are complete are kept in {place}; the same command with -o {shlex.quote(str(place))} goes"
        " on after them."
    )


def named(text: str | None, kind: str) -> list[Any]:
    """Names of laws; all of a kind where "all" is asked for."""
    from ...laws import ContactLaw, FrictionLaw

    registry = (ContactLaw if kind == "contact" else FrictionLaw).registry
    names = [name.strip().lower() for name in (text or "").split(",") if name.strip()]
    return sorted(registry) if names == ["all"] else list(dict.fromkeys(names))


def folder_for(asked: Path | None, model: Path, text: str, force: bool) -> Path:
    """The folder to write into. Raises ValueError for one that holds something else, or a comparison that is
    not to be gone on with.
    """
    if asked is None:
        return next(path for path in numbered(Path("runs") / f"{model.stem}-compare") if not path.exists())
    refuse_foreign(asked, SUMMARY, "comparison")
    if (asked / SUMMARY).is_file() and not force:
        before = asked / MODEL
        if unfinished(asked / SUMMARY) and before.is_file() and read_bytes(before).decode("utf-8") != text:
            raise ValueError(
                f"-o {asked}: the comparison that was begun here is that of another model, or of other"
                " options; add --force to replace it"
            )
        if not unfinished(asked / SUMMARY):
            raise ValueError(
                f"-o {asked}: there is a comparison here already; name another folder, or add --force to"
                " replace it"
            )
    return asked


def unfinished(path: Path) -> bool:
    """Whether a comparison was broken off, as its file says."""
    try:
        said = json.loads(read_bytes(path))
        return said["planned"] is None or len(said["runs"]) < said["planned"]
    except (OSError, ValueError, KeyError, TypeError, RecursionError):
        return False


def end(found: Comparison, place: Path) -> None:
    """Says which runs did not come to their end, and ends with the exit code of that."""
    for one in found.rows:
        if one["status"] != Status.COMPLETE:
            tell(
                Status.DIVERGED,
                f"{one['contact']} with {one['friction']}: the numbers became infinite; take a smaller step"
                " for it",
                "bold red",
            )
    if len(found.rows) < found.planned:
        tell(
            Status.INTERRUPTED,
            f"{NOW.by}: {len(found.rows)} of {found.planned} runs are complete. {kept_in(place)}",
        )
        raise typer.Exit(NOW.code)
    if any(one["status"] != Status.COMPLETE for one in found.rows):
        raise typer.Exit(DIVERGED)
