"""``vfife map basins``: to which motion each start comes."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer

from .mapcost import Work, told_of
from .mapped import Csv, Drop, Figured, Of, Phase, Target, Yes, carried_out, drawn_and_told, places, quantity_at, start_range
from .options import LawsOption, ModelArgument, SetOption, read_model
from .run import Quiet
from .targets import refuse_inputs
from .terminal import sentences

MOST_TURNS, MOST_VALUES = 1_000_000, 2_000
OVER = (
    "A number of the start or of the model, from and to; twice, as in start.pin.x=-0.2..0.2mm, start.crank=0..360deg, joint.pin.clearance=0.1..1mm."
)
Over = Annotated[list[str], typer.Option("--over", metavar="PATH=LOW..HIGH", help=OVER, show_default=False)]
Count = Annotated[str, typer.Option("--count", metavar="N[xM]", help="Values of each.")]
Turns = Annotated[int, typer.Option("--turns", metavar="N", min=1, max=MOST_TURNS, help="Turns of each start.")]
STEP = "Time step; a turn has a whole number of them."
Step = Annotated[str | None, typer.Option("--step", metavar="TIME", help=STEP, show_default="automatic")]
Exponents = Annotated[bool, typer.Option("--exponents/--no-exponents", help="Watch a small difference, by which chaos is told.")]
Companions = Annotated[int, typer.Option("--companions", metavar="N", min=0, help="So many starts again with a coarser and a finer step.")]


def basins(
    model: ModelArgument,
    over: Over,
    count: Count = "30",
    turns: Turns = 120,
    drop: Drop = 80,
    of: Of = None,
    phase: Phase = 0.0,
    exponents: Exponents = True,
    companions: Companions = 5,
    step: Step = None,
    target: Target = None,
    figure: Figured = None,
    csv: Csv = None,
    set_: SetOption = None,
    laws: LawsOption = None,
    yes: Yes = False,
    quiet: Quiet = False,
) -> None:
    """Basins: a grid of two numbers of the start (crank angle, journal's place and velocity in its bearing) or of the model, coloured by motion.

    Members are one motion where their points once a turn are. After Ctrl-C or a kill the same command goes on.
    """
    place = target if target is not None else Path("runs") / f"{model.stem}-basins.map"
    with sentences(str(model)):
        drawn = places(place, figure, csv, target is None)
        refuse_inputs((("-o", place), ("--figure", drawn), ("--csv", csv)), (model, *(laws or ())))
        mechanism = read_model(model, set_, laws)
        from ..study.basins import basins as made

        if len(over) != 2:
            how = "name two numbers, as in --over start.pin.x=-0.2..0.2mm --over start.pin.y=-0.2..0.2mm"
            raise ValueError(f"--over: this is given {len(over)} times; {how}")
        x, y = (start_range(mechanism, text) for text in over)
        size, some = quantity_at("--step", step), counts(count)
    work = Work(some[0] * some[1], "start", turns, drop, 4, len(of or (1, 1)) + 1, companions, exponents)
    told_of(work, mechanism, size, place, yes, quiet)
    with sentences(str(model)):
        given: dict[str, Any] = {
            "count": some, "turns": turns, "dropped": drop, "series": of or (), "phase": phase / 360.0, "exponents": exponents,
            "companions": companions, "step": size,
        }  # fmt: skip
        found = carried_out(place, quiet, "starts", lambda progress: made(mechanism, x, y, **given, file=place, progress=progress))
    drawn_and_told(found, place, drawn, csv, quiet)


def counts(text: str) -> tuple[int, int]:
    """Values of both numbers. Raises ValueError."""
    first, sign, second = text.partition("x")
    if not first.isdecimal() or not (second if sign else first).isdecimal():
        raise ValueError(f"--count {text}: allowed: a whole number, or two as in 40x30")
    found = int(first), int(second if sign else first)
    if not all(2 <= one <= MOST_VALUES for one in found):
        raise ValueError(f"--count {text}: allowed: 2 to {MOST_VALUES} values of each")
    return found
