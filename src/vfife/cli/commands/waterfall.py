"""``vfife waterfall``: spectra of series over a number that changes from run to run, mostly over the speed of
the crank.
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from ..options import LawsOption, ModelArgument, SetOption, positive
from .map import MapCommand, Yes, number_range
from .run import Quiet

if TYPE_CHECKING:
    from ...model.mechanism import Mechanism

OVER = "The number, from and to, as in driver.crank.speed=500..3000rpm."
Over = Annotated[str, typer.Option("--over", metavar="PATH=LOW..HIGH", help=OVER, show_default=False)]
Count = Annotated[
    int, typer.Option("--count", metavar="N", min=2, max=10_000, help="Values of it, a run each.")
]
Turns = Annotated[int, typer.Option("--turns", metavar="N", min=1, max=1_000_000, help="Turns of each run.")]
LAST = "So many of the last are transformed: orders are 1/N apart."
Last = Annotated[
    int | None, typer.Option("--last", metavar="N", min=1, help=LAST, show_default="4, or all of fewer turns")
]
Of = Annotated[
    list[str] | None,
    typer.Option(
        "--of", metavar="SERIES", help="Series, as C.force.", show_default="forces of joints with play"
    ),
]
Outputs = Annotated[
    int,
    typer.Option(
        "--outputs",
        metavar="N",
        min=8,
        help="Samples in a turn; what is faster than half of them is folded back.",
    ),
]
Highest = Annotated[float, typer.Option("--highest", metavar="ORDER", help="Highest order that is kept.")]
Window = Annotated[
    str, typer.Option("--window", metavar="NAME", help="hann, hamming, blackman, flat-top or rectangular.")
]
Hertz = Annotated[bool, typer.Option("--hertz", help="Draw frequencies instead of orders.")]
Step = Annotated[
    str | None,
    typer.Option(
        "--step", metavar="TIME", help="Time step.", show_default="the finer automatic one of both ends"
    ),
]
Target = Annotated[
    Path | None,
    typer.Option(
        "-o",
        "--output",
        metavar="FILE.waterfall",
        help="Where to keep it.",
        show_default="runs/MODEL.waterfall",
    ),
]
Figure = Annotated[
    Path | None,
    typer.Option(
        "--figure", metavar="FILE.png|svg|pdf", help="The picture.", show_default="FILE-waterfall.png"
    ),
]
Table = Annotated[
    Path | None,
    typer.Option("--csv", metavar="FILE.csv", help="All amplitudes as a table.", show_default=False),
]


def waterfall(
    model: ModelArgument,
    over: Over,
    count: Count = 50,
    turns: Turns = 12,
    last: Last = None,
    of: Of = None,
    outputs: Outputs = 1440,
    highest: Highest = 50.0,
    window: Window = "hann",
    hertz: Hertz = False,
    step: Step = None,
    target: Target = None,
    figure: Figure = None,
    csv: Table = None,
    set_: SetOption = None,
    laws: LawsOption = None,
    yes: Yes = False,
    quiet: Quiet = False,
) -> None:
    """Waterfall: spectra over a number, mostly the crank's speed, by orders of the crank; a run each, side by
    side on all cores.

    Every run begins at the model's own start. After Ctrl-C or a kill the same command goes on with the runs
    that are missing.
    """

    def made(mechanism: Mechanism, **job: Any) -> Any:
        from ...dynamics.waterfall import waterfall as waterfall_of

        path, low, high = number_range(mechanism, over)
        return waterfall_of(
            mechanism, path, low, high, count=count, turns=turns, last=last, series=of or (), outputs=outputs, highest=highest,
            window=window, step=None if step is None else positive("--step", step, "s"), **job,
        )  # fmt: skip

    flow = MapCommand(
        model, ".waterfall", target, figure, csv, set_, laws, yes, quiet, "--count 20", "waterfall"
    )
    flow.run(made, {"hertz": hertz})
