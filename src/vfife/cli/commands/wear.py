"""``vfife wear``: how joints with clearance wear over millions of turns."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from ...modelfile.write import save_model
from ...report.wear import document
from ...results.export import check_decimal
from ...store.schemas import WEAR
from ...tribology.simulate_wear import load_wear
from ...tribology.simulate_wear import wear as simulate
from ..arguments.analyses import MOST_WEAR_TURNS, WearOptions
from ..job import CommandJob
from ..terminal import end_interrupted, sentences
from ..values import clearance_limit, force_limit, mechanism_of, positive


def wear(options: WearOptions) -> None:
    """Run ``vfife wear``."""
    model, turns, is_wear_file = options.model, options.turns, WEAR.owns(options.model)
    with sentences(str(model)):
        # Not a bound of the option: its help would be widened by all its zeros.
        if not turns <= MOST_WEAR_TURNS:
            raise ValueError(
                f"--turns {turns:g}: more than can be counted; allowed: 1 to {MOST_WEAR_TURNS:g}"
            )
        check_decimal(options.decimal, options.csv or Path("wear.csv"))
        place = options.answer_file(WEAR, model, "wear", ".wear", ("--worn", options.final_model))
        result = load_wear(model) if is_wear_file else simulate_wear(options, place)
    options.write_files(result)
    if options.final_model is not None:
        with sentences(str(options.final_model)):
            save_model(result.mechanism(), options.final_model)
    options.answer(document(result), place, options.figure, options.csv, options.final_model)
    if not result.complete and not is_wear_file:
        end_interrupted(
            f": {result.turns[-1]:,.0f} of {turns:,.0f} turns are complete and kept in {place}; the same"
            " command continues."
        )


def simulate_wear(options: WearOptions, place: Path) -> Any:
    """Wear of a model, kept in a file."""
    job = CommandJob("wear", place, options)
    mechanism = mechanism_of(options)
    lengths = {
        "clearance": clearance_limit(options.clearance, mechanism),
        "force": force_limit(options.force, mechanism),
        "step": positive("--step", options.step, "s"),
    }
    numbers = {name: getattr(options, name) for name in ("block", "settle", "tolerance", "harmonics", "wear")}
    with job.at_work(str(options.model)):
        job.start()
        return simulate(mechanism, options.turns, **numbers, **lengths, file=place, progress=job)
