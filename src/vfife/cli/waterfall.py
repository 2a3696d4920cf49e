"""``vfife waterfall``: spectra of series over a number that changes from run to run, mostly over the speed of the crank."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer

from .mapped import carried_out, drawn_and_told, places, quantity_at
from .options import LawsOption, ModelArgument, SetOption, read_model
from .run import Quiet
from .targets import refuse_inputs
from .terminal import sentences, writing

OVER = "The number, from and to, as in driver.crank.speed=500..3000rpm."
Over = Annotated[str, typer.Option("--over", metavar="PATH=LOW..HIGH", help=OVER, show_default=False)]
Count = Annotated[int, typer.Option("--count", metavar="N", min=2, max=10_000, help="Values of it, a run each.")]
Turns = Annotated[int, typer.Option("--turns", metavar="N", min=1, max=1_000_000, help="Turns of each run.")]
Last = Annotated[int, typer.Option("--last", metavar="N", min=1, help="So many of the last are transformed: orders are 1/N apart.")]
Of = Annotated[list[str] | None, typer.Option("--of", metavar="SERIES", help="Series, as C.force.", show_default="forces of joints with play")]
Outputs = Annotated[int, typer.Option("--outputs", metavar="N", min=8, help="Samples in a turn; what is faster than half of them is folded back.")]
Highest = Annotated[float, typer.Option("--highest", metavar="ORDER", help="Highest order that is kept.")]
Window = Annotated[str, typer.Option("--window", metavar="NAME", help="hann, hamming, blackman, flat-top or rectangular.")]
Hertz = Annotated[bool, typer.Option("--hertz", help="Draw frequencies instead of orders.")]
Step = Annotated[str | None, typer.Option("--step", metavar="TIME", help="Time step.", show_default="the finer automatic one of both ends")]
Target = Annotated[
    Path | None, typer.Option("-o", "--output", metavar="FILE.waterfall", help="Where to keep it.", show_default="runs/MODEL.waterfall")
]
Figure = Annotated[Path | None, typer.Option("--figure", metavar="FILE.png|svg|pdf", help="The picture.", show_default="FILE-waterfall.png")]
Table = Annotated[Path | None, typer.Option("--csv", metavar="FILE.csv", help="All amplitudes as a table.", show_default=False)]


def waterfall(
    model: ModelArgument,
    over: Over,
    count: Count = 50,
    turns: Turns = 12,
    last: Last = 4,
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
    quiet: Quiet = False,
) -> None:
    """Waterfall: spectra over a number, mostly the crank's speed, by orders of the crank; a run each, side by side on all cores.

    Every run begins at the model's own start. After Ctrl-C or a kill the same command goes on with the runs that are missing.
    """
    place = target if target is not None else Path("runs") / f"{model.stem}.waterfall"
    with sentences(str(model)):
        drawn = places(place, figure, csv, target is None, "waterfall")
        refuse_inputs((("-o", place), ("--figure", drawn), ("--csv", csv)), (model, *(laws or ())))
        mechanism = read_model(model, set_, laws)
        from ..live.sliders import asked_slides
        from ..study.waterfall import waterfall as computed

        (slide,) = asked_slides(mechanism, [over], "--over")
        given: dict[str, Any] = {
            "count": count,
            "turns": turns,
            "last": last,
            "series": of or (),
            "outputs": outputs,
            "highest": highest,
            "window": window,
        }
        size, ends = quantity_at("--step", step), (slide.values[0], slide.values[-1])
        found = carried_out(
            place, quiet, "runs", lambda told: computed(mechanism, slide.paths[0], *ends, step=size, file=place, progress=told, **given)
        )
    if hertz:
        with writing(str(drawn)):
            from ..plots.files import saved_in_style

            saved_in_style(lambda: found.plot(hertz=True), drawn)
    drawn_and_told(found, place, None if hertz else drawn, csv, quiet)
