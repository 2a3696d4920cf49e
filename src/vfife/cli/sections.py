"""``vfife map section``: one motion once a turn, and at its impacts."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

import typer

from .mapcost import Brief, Work
from .mapmaking import Given, Question, answered
from .mapoptions import Csv, Figured, Of, Phase, Step, Target, Yes, drop_of, quantity_at, turning_steps
from .options import LawsOption, ModelArgument, SetOption
from .run import Quiet

if TYPE_CHECKING:
    from ..model.mechanism import Mechanism

BRIEF = Brief(1, 90, "--turns 90")
MOST_TURNS = 10_000_000
Turns = Annotated[int, typer.Option("--turns", metavar="N", min=1, max=MOST_TURNS, help="Turns.")]
Third = Annotated[int | None, typer.Option("--drop", metavar="N", min=0, help="So many of them are not looked at.", show_default="a third of them")]
Impacts = Annotated[
    list[str] | None, typer.Option("--impacts", metavar="JOINT", help="Look at every contact that begins in it.", show_default="all with play")
]


def section(
    model: ModelArgument,
    turns: Turns = 300,
    drop: Third = None,
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

    def understood(mechanism: Mechanism) -> Question:
        from ..study.maps.sections import DROPPED, poincare_section

        size, left = quantity_at("--step", step), drop_of(drop, turns, DROPPED)
        joints = tuple(mechanism.contacts) if impacts is None else tuple(impacts)
        work = Work(1, "motion", turns, left, turning_steps([mechanism], size), 1, len(of or (1, 1)) + 1, struck=bool(joints), brief=BRIEF)
        given = {"turns": turns, "dropped": left, "series": of or (), "phase": phase / 360.0, "joints": joints, "step": size}
        return Question(work, "turns", poincare_section, given)

    answered(Given(model, "-section.map", target, figure, csv, set_, laws, yes, quiet), understood)
