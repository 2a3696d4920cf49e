"""``vfife map section``: one motion once a turn, and at its impacts."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer

from .mapcost import Work, told_of
from .mapped import Csv, Drop, Figured, Of, Phase, Target, Yes, carried_out, drawn_and_told, places, quantity_at
from .options import LawsOption, ModelArgument, SetOption, read_model
from .run import Quiet
from .targets import refuse_inputs
from .terminal import sentences

MOST_TURNS = 10_000_000
Turns = Annotated[int, typer.Option("--turns", metavar="N", min=1, max=MOST_TURNS, help="Turns.")]
STEP = "Time step; a turn has a whole number of them."
Step = Annotated[str | None, typer.Option("--step", metavar="TIME", help=STEP, show_default="automatic")]
Impacts = Annotated[
    list[str] | None, typer.Option("--impacts", metavar="JOINT", help="Look at every contact that begins in it.", show_default="all with play")
]


def section(
    model: ModelArgument,
    turns: Turns = 300,
    drop: Drop = 100,
    of: Of = None,
    phase: Phase = 0.0,
    impacts: Impacts = None,
    step: Step = None,
    target: Target = None,
    figure: Figured = None,
    csv: Csv = None,
    set_: SetOption = None,
    laws: LawsOption = None,
    yes: Yes = False,
    quiet: Quiet = False,
) -> None:
    """Poincaré section of one motion: once a turn, and at every impact; what it is (period, quasi-periodic, chaotic) and what says so.

    At impacts: where on the bearing, how fast and at which angle of the crank a contact begins, located inside the step. After Ctrl-C or a kill the
    same command goes on.
    """
    place = target if target is not None else Path("runs") / f"{model.stem}-section.map"
    with sentences(str(model)):
        drawn = places(place, figure, csv, target is None)
        refuse_inputs((("-o", place), ("--figure", drawn), ("--csv", csv)), (model, *(laws or ())))
        mechanism = read_model(model, set_, laws)
        from ..study.sections import poincare_section as made

        joints = tuple(mechanism.contacts) if impacts is None else tuple(impacts)
        size = quantity_at("--step", step)
    told_of(Work(1, "motion", turns, drop, 1, len(of or (1, 1)) + 1, struck=bool(joints)), mechanism, size, place, yes, quiet)
    with sentences(str(model)):
        given: dict[str, Any] = {
            "turns": turns, "dropped": drop, "series": of or (), "phase": phase / 360.0, "joints": joints, "step": size,
        }  # fmt: skip
        found = carried_out(place, quiet, "turns", lambda progress: made(mechanism, **given, file=place, progress=progress))
    drawn_and_told(found, place, drawn, csv, quiet)
