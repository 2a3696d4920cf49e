"""``vfife wear``: how joints with clearance wear over millions of turns."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from ...store.schemas import WEAR
from ..job import CommandJob
from ..options import FIGURE_FILE, AnswerFileOptions, JobOptions, ModelOptions, argument, option, positive
from ..terminal import end_interrupted, sentences

MOST_BLOCK, MOST_HARMONICS, MOST_TURNS = 100_000, 32, 1e15


class WearOptions(AnswerFileOptions, ModelOptions, JobOptions):
    """Options of ``vfife wear``."""

    model: Path = argument("Model file, or a wear file to be shown.", "MODEL.toml")
    turns: float = option(1e6, "Turns of the crank, as in 1e7.", "N", min=1, show_default="1e6")
    block: int = option(4, "Turns that are simulated for a rate.", "N", min=1, max=MOST_BLOCK)
    settle: int = option(4, "Turns before them that are discarded.", "N", min=1, max=MOST_BLOCK)
    tolerance: float = option(0.01, "Largest error of a jump, as a share of the smallest clearance.", "SHARE")
    harmonics: int = option(
        8, "Of the worn profiles that clearances follow; 0: they do not.", "N", min=0, max=MOST_HARMONICS
    )
    clearance: str | None = option(
        None, "Clearance that ends a joint's life, at the deepest places of its smoothed profiles.", "LENGTH"
    )
    force: str | None = option(None, "Force of a joint that ends its life.", "FORCE")
    step: str | None = option(
        None, "Time step; a turn has a whole number of them.", "TIME", show_default="automatic"
    )
    target: Path | None = option(
        None, "Where to keep it.", "FILE.wear", "-o", "--output", show_default="runs/MODEL.wear"
    )
    figure: Path | None = option(None, "The figure.", FIGURE_FILE, show_default="FILE-wear.png")
    final_model: Path | None = option(None, "The model as it is worn in the end.", "WORN.toml", "--worn")


def wear(options: WearOptions) -> None:
    """Wear of joints with clearance over many turns, by Archard's law: blocks of turns that are simulated,
    and jumps with a known error between them.

    The joints that wear have a table wear in the model. Clearances follow the worn surfaces. After Ctrl-C or
    a kill the same command goes on.
    """
    model, turns, is_wear_file = options.model, options.turns, WEAR.owns(options.model)
    with sentences(str(model)):
        if not turns <= MOST_TURNS:  # not a bound of the option: its help would be widened by all its zeros
            raise ValueError(f"--turns {turns:g}: more than can be counted; allowed: 1 to {MOST_TURNS:g}")
        place = options.answer_file(WEAR, model, "wear", ".wear", ("--worn", options.final_model))
        from ...tribology.simulate_wear import load_wear

        result = load_wear(model) if is_wear_file else simulate_wear(options, place)
    options.write_files(result)
    if options.final_model is not None:
        from ...modelfile.write import save_model

        with sentences(str(options.final_model)):
            save_model(result.mechanism(), options.final_model)
    from ...report.wear import document

    options.answer(document(result), place, options.figure)
    if not result.complete and not is_wear_file:
        end_interrupted(
            f": {result.turns[-1]:,.0f} of {turns:,.0f} turns are known and kept in {place}; the same command"
            " goes on."
        )


def simulate_wear(options: WearOptions, place: Path) -> Any:
    """Wear of a model, kept in a file."""
    from ...tribology.simulate_wear import wear as simulate

    job = CommandJob("wear", place, options)
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
