"""``vfife run``: from a model file to a run folder and a summary."""

from __future__ import annotations

from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from .carried import carried, concluded
from .options import JsonOption, LawsOption, ModelArgument, SetOption, read_model, with_options
from .terminal import fail, sentences, tell

if TYPE_CHECKING:
    from ..assembly.assembled import Assembly
    from ..model.mechanism import Mechanism
    from ..result import Result
    from ..results.place import RunFolder
    from ..results.runfile import RunFile
    from ..simulation import Prepared
    from ..solvers.record import Checkpoint

GATHER = 0.25  # s: what a kill may cost, beside the steps that are being taken


class Loops(StrEnum):
    """The loops there are."""

    auto = "auto"
    data_driven = "data-driven"
    generated = "generated"
    interpreted = "interpreted"


MODELS = "the model's"
Folder = Annotated[Path | None, typer.Option("-o", "--output", metavar="FOLDER", help="Run folder.", show_default="runs/MODEL")]
Step = Annotated[str | None, typer.Option(metavar="SECONDS", help='Time step, such as 1e-6 or "1 us", or auto.', show_default=MODELS)]
Turns = Annotated[float | None, typer.Option(metavar="N", help="Length in turns of the crank.", show_default=MODELS)]
UNTIL = "End as soon as turns repeat within this share of their largest values, as in 1%, after --turns at the latest."
Settle = Annotated[str | None, typer.Option(metavar="SHARE", help=UNTIL, show_default=MODELS)]
Duration = Annotated[str | None, typer.Option(metavar="SECONDS", help="Length in time, instead of turns.")]
Outputs = Annotated[int | None, typer.Option(metavar="N", min=1, help="Outputs per turn; per run without a crank.", show_default=MODELS)]
Figures = Annotated[bool, typer.Option("--figures/--no-figures", help="Draw the figures as well.")]
Reference = Annotated[bool, typer.Option("--reference/--no-reference", help="Compare with the ideal mechanism.")]
ForceStep = Annotated[bool, typer.Option("--force-step", help="Take a step that is larger than the stable one.")]
Quiet = Annotated[bool, typer.Option("--quiet", "-q", help="No progress line and no summary; warnings and errors are told.")]
StartFrom = Annotated[
    Path | None, typer.Option("--start-from", metavar="RUN", help="A new run from where a former one ended (its folder or file), by its clock.")
]
BESIDE = "Repeat a run with contact with N other step sizes, 0 to 7, to estimate its error; auto: 3."
Companions = Annotated[str | None, typer.Option(metavar="N", help=BESIDE, show_default=MODELS)]
Force = Annotated[bool, typer.Option("--force", help="Replace the run that is in the folder.")]
Yes = Annotated[bool, typer.Option("--yes", help="Run whatever it takes: hours, or half the memory or the disk.")]
Resume = Annotated[bool, typer.Option("--resume", help="Go on with the run in the folder, if this model was begun there.")]
LoopOption = Annotated[Loops, typer.Option(help="Loop that makes the steps; all give the same bits.")]


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

    The folder holds the run file, the model as it was run, the summary, and figures where they are asked for; a run that is there already stays
    unless --force is given. Exit codes: 2 for input that cannot be used, 3 where the numbers became infinite or no equilibrium was found, 5 where
    something could not be written, 130, 143 and 129 after Ctrl-C, SIGTERM and SIGHUP, which keep what was computed.
    """
    from ..results.place import placed

    with sentences(str(model)):
        mechanism = with_options(read_model(model, set_, laws), step, turns, duration, outputs, companions, settle)
        if resume and (begun := to_go_on(folder, model)) is not None:
            goes_on(begun, mechanism, figures, as_json, quiet)
            return
        place = placed(folder, model, replace=force, start=start)
    for note in place.notes if not quiet else ():
        tell("note", f"{note}.")
    with sentences(str(model)):
        from ..result import Result
        from ..simulation import prepare
        from ..solvers.arguments import Asked

        former = None if start is None else Result.load(start)
        ideal = reference_for(mechanism, former, place, force_step, yes) if reference else None
        prepared = prepare(mechanism, Asked(loop=loop.value, force_step=force_step), False if ideal is None else ideal, former)
    refuse_no_room(prepared.assembly, None if ideal is None else ideal.record.assembly, place, yes, prepared.refined)
    try:
        result = carried(lambda: begun_in(place, prepared), place, quiet)
        concluded(result, place, figures, as_json, quiet)
    finally:
        place.leave()


def begun_in(place: RunFolder, prepared: Prepared) -> tuple[RunFile, Prepared, Checkpoint | None]:
    """A new run file in its place."""
    from ..results.folder import MODEL
    from ..results.runfile import RunFile

    meta = prepared.kept
    place.begin()
    (place.path / MODEL).write_text(meta["model"], encoding="utf-8")  # in a folder that this process has just made
    file = RunFile.create(place.run_file, meta, gather=GATHER)
    file.arrive = place.settle
    return file, prepared, None


def reference_for(mechanism: Mechanism, start: Result | None, place: RunFolder, force_step: bool, yes: bool) -> Result | None:
    """The ideal reference. One that takes its time is forecast before it is run, with what it is for."""
    from ..results.cost import BRIEF, estimate
    from ..simulation import assembled_at, ideal_of, referred

    ideal = ideal_of(mechanism)
    if ideal is not None and estimate(ideal)["seconds"] > BRIEF:
        refuse_no_room(assembled_at(mechanism, start=start, force_step=force_step), ideal, place, yes)
    return referred(ideal)


def refuse_no_room(assembly: Assembly, ideal: Assembly | None, place: RunFolder, yes: bool, refined: bool = False) -> None:
    """Ends with exit code 5 where the disk has no room for the outputs, with 2 where the run takes more than may be meant and nobody said yes."""
    from ..results.cost import estimate, too_much, with_repetition
    from ..results.tables import free_bytes

    found = with_repetition(estimate(assembly, ideal), assembly, refined)
    free, needed = free_bytes(place.target), found["disk"]
    if free is not None and needed > free:
        from .terminal import STORAGE

        fail(
            f"{place.target}: the outputs of this run take some {needed:,.0f} bytes, and {free:,} are free there; ask for fewer (--outputs), or "
            "name a folder on another disk. Nothing was begun, and nothing is touched.",
            STORAGE,
        )
    if not yes and (much := too_much(found, place.target)):
        static = assembly.mechanism.settings.analysis == "static"
        less = "fewer load_factors, elements or iterations" if static else "--turns, --duration, --outputs"
        fail(f"this run takes {much}; add --yes if that is meant, or ask for less ({less}). Nothing was begun.")


def to_go_on(folder: Path | None, model: Path) -> Path | None:
    """The folder of a run to go on with; None where there is none yet."""
    from ..results.header import is_run_file

    path = folder if folder is not None else Path("runs") / model.stem
    return path if is_run_file(path / "run.sqlite") else None


def goes_on(path: Path, mechanism: Mechanism, figures: bool, as_json: bool, quiet: bool) -> None:
    """Goes on with the run in a folder, if it is that of the model."""
    from ..modelfile import dump
    from ..results.folder import model_of
    from .resume import resumed

    if model_of(path) != dump(mechanism):
        raise ValueError(f"--resume: the run in {path} is that of another model, or of other options; name another folder, or leave --resume out")
    resumed(path, None, figures, as_json, quiet)
