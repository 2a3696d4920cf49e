"""``vfife map``: what becomes of a motion over a number, from turn to turn, and from start to start."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer
from typer.core import TyperGroup

from .basins import basins
from .mapcost import Brief, Work
from .mapmaking import Given, Question, answered
from .mapoptions import Csv, Drop, Figured, Kept, Of, Phase, Step, Target, Yes, drop_of, number_range, quantity_at, start_numbers, turning_steps
from .mapped import drawn_and_told
from .options import LawsOption, ModelArgument, SetOption
from .plainly import Command, Plainly
from .run import Quiet
from .sections import section
from .targets import refuse_inputs
from .terminal import sentences

if TYPE_CHECKING:
    from ..model.mechanism import Mechanism

SWEEP = "sweep"
BRIEF = Brief(30, 45, "--count 30 --turns 45")
MOST_VALUES, MOST_TURNS = 10_000, 1_000_000
OVER = "The number, from and to, as in joint.pin.clearance=0.1..1mm."
Over = Annotated[str, typer.Option("--over", metavar="PATH=LOW..HIGH", help=OVER, show_default=False)]
Count = Annotated[int, typer.Option("--count", metavar="N", min=2, max=MOST_VALUES, help="Values of it, up and down again.")]
Turns = Annotated[int, typer.Option("--turns", metavar="N", min=1, max=MOST_TURNS, help="Turns at each value.")]
FROM = 'Begin every value anew: "own", or numbers of a start, as in "start.crank=90deg, start.pin.x=0.1mm"; may be repeated.'
From = Annotated[list[str] | None, typer.Option("--start", metavar="own|PATH=VALUE,...", help=FROM, show_default="the state is carried on")]
Companions = Annotated[int, typer.Option("--companions", metavar="N", min=0, help="So many values again with a coarser and a finer step.")]


class Group(Plainly, TyperGroup):
    """The commands of maps. What is no command is a model, over whose number a map is made."""

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        """Puts the command before a model; a word that is no file's name is a command that there is not."""
        word = args[0] if args else "--help"
        if word not in self.commands and word != "--help" and (word.startswith("-") or Path(word).suffix or Path(word).exists()):
            args = [SWEEP, *args]
        return super().parse_args(ctx, args)


map_ = typer.Typer(
    cls=Group,
    no_args_is_help=True,
    help="What becomes of a motion: vfife map MODEL --over PATH=LOW..HIGH sweeps a number up and down, draws a bifurcation diagram and says where "
    "the motion is periodic and where chaotic; commands look at one motion once a turn and at its impacts, and at many starts. What is known is "
    "kept in one file; after a kill the same command goes on.",
    epilog="From which play on is it chaotic? vfife new slider-crank -o my.toml, then vfife map my.toml --over joint.pin.clearance=0.1..1mm",
)


@map_.command(SWEEP, cls=Command)
def sweep(
    model: ModelArgument,
    over: Over,
    count: Count = 60,
    turns: Turns = 90,
    drop: Drop = None,
    of: Of = None,
    phase: Phase = 0.0,
    step: Step = None,
    start: From = None,
    companions: Companions = 5,
    target: Target = None,
    figure: Figured = None,
    csv: Csv = None,
    set_: SetOption = None,
    laws: LawsOption = None,
    yes: Yes = False,
    quiet: Quiet = False,
) -> None:
    """Bifurcation diagram: a number swept up and down while the motion goes on, looked at once a turn, with the largest Lyapunov exponent.

    The state is carried on from value to value, so that motions which live beside each other are told apart; with --start every value begins anew.
    After Ctrl-C or a kill the same command goes on. `sweep` itself may be left out.
    """

    def understood(mechanism: Mechanism) -> Question:
        from ..study.maps.bifurcation import bifurcation
        from ..study.maps.section_series import models_along

        path, low, high = swept = number_range(mechanism, over)
        starts, size, left = [start_numbers(mechanism, text) for text in start or ()], quantity_at("--step", step), drop_of(drop, turns)
        lanes, chains = (4, 1) if starts else (2, 2)
        steps = turning_steps(models_along(mechanism, (swept,)), size)
        work = Work(count * max(len(starts), 1), "value", turns, left, steps, lanes, (len(of or (1, 1)) + 1) * chains, companions, brief=BRIEF)
        given = {
            "path": path, "low": low, "high": high, "count": count, "turns": turns, "dropped": left, "series": of or (), "phase": phase / 360.0,
            "companions": companions, "step": size, "starts": starts,
        }  # fmt: skip
        return Question(work, "values", bifurcation, given)

    answered(Given(model, ".map", target, figure, csv, set_, laws, yes, quiet), understood)


map_.command(cls=Command)(section)
map_.command(cls=Command)(basins)


@map_.command(cls=Command)
def show(file: Kept, figure: Figured = None, csv: Csv = None) -> None:
    """What a map, a section, basins or a waterfall came to so far, from their file; a figure and a table of it."""
    with sentences(str(file)):
        from ..study.maps.kept import load_map

        refuse_inputs((("--figure", figure), ("--csv", csv)), (file,))
        found = load_map(file)
    drawn_and_told(found, file, figure, csv, quiet=False, whole=False)
