"""``vfife map basins``: to which motion each start comes."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

import typer

from .mapcost import MADE, TURNED, Brief, Work
from .mapmaking import Given, Question, answered
from .mapoptions import Csv, Drop, Figured, Of, Phase, Step, Target, Yes, drop_of, number_range, quantity_at, turning_steps
from .options import LawsOption, ModelArgument, SetOption
from .run import Quiet

if TYPE_CHECKING:
    from ..model.mechanism import Mechanism

BRIEF = Brief(100, 30, "--count 10 --turns 30")
MOST_TURNS, MOST_VALUES = 1_000_000, 2_000
OVER = (
    "A number of the start or of the model, from and to; twice, as in start.pin.x=-0.2..0.2mm, start.crank=0..360deg, joint.pin.clearance=0.1..1mm."
)
Over = Annotated[list[str], typer.Option("--over", metavar="PATH=LOW..HIGH", help=OVER, show_default=False)]
Count = Annotated[str, typer.Option("--count", metavar="N[xM]", help="Values of each.")]
Turns = Annotated[int, typer.Option("--turns", metavar="N", min=1, max=MOST_TURNS, help="Turns of each start.")]
Exponents = Annotated[bool, typer.Option("--exponents/--no-exponents", help="Watch a small difference, by which chaos is told.")]
Companions = Annotated[int, typer.Option("--companions", metavar="N", min=0, help="So many starts again with a coarser and a finer step.")]


def basins(
    model: ModelArgument,
    over: Over,
    count: Count = "16",
    turns: Turns = 60,
    drop: Drop = None,
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

    def understood(mechanism: Mechanism) -> Question:
        from ..study.maps.basins import basins as made
        from ..study.maps.section_series import models_along

        if len(over) != 2:
            how = "name two numbers, as in --over start.pin.x=-0.2..0.2mm --over start.pin.y=-0.2..0.2mm"
            raise ValueError(f"--over: this is given {len(over)} times; {how}")
        x, y = (number_range(mechanism, text, starts=True) for text in over)
        size, some, left = quantity_at("--step", step), counts(count), drop_of(drop, turns)
        steps = turning_steps(models_along(mechanism, (x, y)), size)
        made_in = TURNED if any(path == "start.crank" for path, *_ in (x, y)) else MADE
        work = Work(some[0] * some[1], "start", turns, left, steps, 4, len(of or (1, 1)) + 1, companions, exponents, made=made_in, brief=BRIEF)
        given = {
            "x": x, "y": y, "count": some, "turns": turns, "dropped": left, "series": of or (), "phase": phase / 360.0, "exponents": exponents,
            "companions": companions, "step": size,
        }  # fmt: skip
        return Question(work, "starts", made, given)

    answered(Given(model, "-basins.map", target, figure, csv, set_, laws, yes, quiet), understood)


def counts(text: str) -> tuple[int, int]:
    """Values of both numbers. Raises ValueError."""
    first, sign, second = text.partition("x")
    if not first.isdecimal() or not (second if sign else first).isdecimal():
        raise ValueError(f"--count {text}: allowed: a whole number, or two as in 40x30")
    found = int(first), int(second if sign else first)
    if not all(2 <= one <= MOST_VALUES for one in found):
        raise ValueError(f"--count {text}: allowed: 2 to {MOST_VALUES} values of each")
    return found
