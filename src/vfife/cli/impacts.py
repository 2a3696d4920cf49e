"""``vfife impacts``: the contacts that began in a run, one by one as far as its outputs tell them apart."""

from __future__ import annotations

from typing import Annotated

import typer

from .options import JsonOption, RunArgument
from .terminal import answer, sentences

Count = Annotated[int, typer.Option("-n", "--count", metavar="N", min=1, help="So many of the hardest.")]


def impacts(run: RunArgument, count: Count = 10, as_json: JsonOption = False) -> None:
    """The impacts of a run: time, crank angle, approach speed, energy lost and depth, the hardest first; with --json all of them in their order.

    None is missed. Those that began between the same two outputs are told together, with their number and mean speed; more outputs
    (vfife run --outputs) tell more of them apart.
    """
    with sentences(str(run)):
        from ..result import Result

        found = Result.load(run).impacts
    from ..report import runfile

    answer(runfile.impacts(found, count), as_json)
