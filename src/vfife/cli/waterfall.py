"""``vfife waterfall``: spectra of series over a number that changes from run to run, mostly over the speed of the crank."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from .map import places
from .options import LawsOption, ModelArgument, SetOption, positive, read_model
from .run import Quiet
from .signals import NOW
from .terminal import output, sentences, tell, writing

if TYPE_CHECKING:
    from ..study.waterfall import Waterfall

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
Figure = Annotated[Path | None, typer.Option("--figure", metavar="FILE.png|svg|pdf", help="The picture.", show_default="FILE.png")]
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
        drawn = places(place, figure, csv, target is None)
        mechanism = read_model(model, set_, laws)
        from ..live.sliders import asked_slides
        from ..study.waterfall import waterfall as computed

        (slide,) = asked_slides(mechanism, [over], "--over")
        size = None if step is None else positive("--step", step, "s")
        place.parent.mkdir(parents=True, exist_ok=True) if target is None else None
        NOW.saved = f"What is complete is kept in {place}; the same command goes on after it."

        def progress(done: int, of_all: int) -> None:
            if not quiet and (done == of_all or done % max(1, of_all // 20) == 0):
                tell("waterfall", f"{done} of {of_all} runs", "bold")

        with writing(str(place)):
            found = computed(
                mechanism, slide.paths[0], slide.values[0], slide.values[-1], count=count, turns=turns, last=last, series=of or (),
                outputs=outputs, highest=highest, window=window, step=size, file=place, progress=progress,
            )  # fmt: skip
    with writing(str(drawn)):
        from ..plots.files import saved_in_style
        from ..plots.waterfall import drawn as picture

        saved_in_style(lambda: picture(found, hertz), drawn)
    if csv is not None:
        with writing(str(csv)):
            found.write_csv(csv)
    if not quiet:
        show(found, place, drawn)
    if found.done < count:
        tell("interrupted", f"{NOW.by}: {found.done} of {count} runs are complete and kept in {place}; the same command goes on.")
        raise typer.Exit(NOW.code)


def show(found: Waterfall, place: Path, drawn: Path) -> None:
    """What was found, in words."""
    from rich.text import Text

    console, asked = output(), found.asked
    low, high = asked.values[0], asked.values[-1]
    console.print(Text(f"{found.name}: {', '.join(asked.series)} over {asked.path} from {low:g} to {high:g} {asked.unit}, {found.done} runs."))
    console.print(Text(f"{found.words}. Without companions; each run begins at the model's own start."))
    if found.diverged:
        console.print(Text(f"At {', '.join(f'{value:g}' for value in found.diverged)} {asked.unit} the motion diverged."))
    console.print(Text(f"{place}, {drawn}"))
