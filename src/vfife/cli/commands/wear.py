"""``vfife wear``: how joints with clearance wear over millions of turns."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from ...store.schemas import WEAR
from ..job import RUNS, CommandJob
from ..options import FIGURE_FILE, TABLE_FILE, JobOptions, ModelOptions, argument, option, positive
from ..outputs import figure_path, refuse_endings, refuse_inputs, write_files
from ..terminal import answer, end_interrupted, print_line, sentences

MOST_BLOCK, MOST_HARMONICS, MOST_TURNS = 100_000, 32, 1e15


class WearOptions(ModelOptions, JobOptions):
    """Options of ``vfife wear``."""

    model: Path = argument("Model file, or a wear file to be shown.", "MODEL.toml")
    turns: float = option(1e6, "Turns of the crank, as in 1e7.", "N", min=1, show_default="1e6")
    block: int = option(4, "Turns that are simulated for a rate.", "N", min=1, max=MOST_BLOCK)
    settle: int = option(4, "Turns before them that are not looked at.", "N", min=1, max=MOST_BLOCK)
    tolerance: float = option(0.01, "Most error of a jump, as a share of the smallest clearance.", "SHARE")
    harmonics: int = option(
        8, "Of the worn profiles that clearances follow; 0: they do not.", "N", min=0, max=MOST_HARMONICS
    )
    clearance: str | None = option(None, "Clearance of a joint that ends its life.", "LENGTH")
    force: str | None = option(None, "Force of a joint that ends its life.", "FORCE")
    step: str | None = option(
        None, "Time step; a turn has a whole number of them.", "TIME", show_default="automatic"
    )
    target: Path | None = option(
        None, "Where to keep it.", "FILE.wear", "-o", "--output", show_default="runs/MODEL.wear"
    )
    figure: Path | None = option(None, "The figure.", FIGURE_FILE, show_default="FILE-wear.png")
    csv: Path | None = option(None, "All depths as a table.", TABLE_FILE)
    final_model: Path | None = option(None, "The model as it is worn in the end.", "WORN.toml", "--worn")


def wear(options: WearOptions) -> None:
    """Wear of joints with clearance over many turns, by Archard's law: blocks of turns that are simulated,
    and jumps with a known error between them.

    The joints that wear have a table wear in the model. Clearances follow the worn surfaces. After Ctrl-C or
    a kill the same command goes on.
    """
    model, turns, target = options.model, options.turns, options.target
    is_wear_file = WEAR.owns(model)
    place = model if is_wear_file else target if target is not None else RUNS / f"{model.stem}.wear"
    with sentences(str(model)):
        if not turns <= MOST_TURNS:  # not a bound of the option: its help would be widened by all its zeros
            raise ValueError(f"--turns {turns:g}: more than can be counted; allowed: 1 to {MOST_TURNS:g}")
        figure = figure_path(place, "wear", options.figure, options.csv, target is None and not is_wear_file)
        refuse_endings(None, None, options.final_model, model_option="--worn")
        targets = (("--figure", figure), ("--csv", options.csv), ("--worn", options.final_model))
        refuse_inputs((*targets, *((("-o", place),) if not is_wear_file else ())), options.inputs)
        from ...tribology.simulate_wear import load_wear

        result = load_wear(model) if is_wear_file else simulate_wear(options, place)
    write_files(result, figure, options.csv)
    if options.final_model is not None:
        from ...modelfile.write import save_model

        with sentences(str(options.final_model)):
            save_model(result.mechanism(), options.final_model)
    if not options.quiet:
        from ...report.wear import document

        answer(document(result))
        print_line(f"{place}, {figure}")
    if not result.complete and not is_wear_file:
        end_interrupted(
            f": {result.turns[-1]:,.0f} of {turns:,.0f} turns are known and kept in {place}; the same command"
            " goes on."
        )


def simulate_wear(options: WearOptions, place: Path) -> Any:
    """Wear of a model, kept in a file."""
    from ...tribology.simulate_wear import wear as simulate

    job = CommandJob("wear", place, yes=options.yes, quiet=options.quiet)
    mechanism = options.mechanism()
    lengths = {
        "clearance": positive("--clearance", options.clearance, "m"),
        "force": positive("--force", options.force, "N"),
        "step": positive("--step", options.step, "s"),
    }
    numbers = {name: getattr(options, name) for name in ("block", "settle", "tolerance", "harmonics")}
    with job.at_work(str(options.model)):
        job.start()
        return simulate(mechanism, options.turns, **numbers, **lengths, file=place, progress=job)
