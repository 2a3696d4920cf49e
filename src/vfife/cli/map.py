"""``vfife map``: a number swept up and down while the motion goes on."""

from __future__ import annotations

from collections import Counter
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from .options import LawsOption, ModelArgument, SetOption, positive, read_model
from .run import Quiet
from .sensitivity import ENDINGS
from .signals import NOW
from .terminal import grid, output, row, sentences, tell, writing

if TYPE_CHECKING:
    from ..study.maps import Bifurcation

MOST_VALUES, MOST_TURNS = 10_000, 1_000_000
OVER = "The number, from and to, as in joint.pin.clearance=0.1..1mm."
Over = Annotated[str, typer.Option("--over", metavar="PATH=LOW..HIGH", help=OVER, show_default=False)]
Count = Annotated[int, typer.Option("--count", metavar="N", min=2, max=MOST_VALUES, help="Values of it, up and down again.")]
Turns = Annotated[int, typer.Option("--turns", metavar="N", min=1, max=MOST_TURNS, help="Turns at each value.")]
Drop = Annotated[int, typer.Option("--drop", metavar="N", min=0, help="So many of them are not looked at.")]
Of = Annotated[
    list[str] | None, typer.Option("--of", metavar="SERIES", help="What is looked at once a turn.", show_default="penetration, force_max")
]
Phase = Annotated[float, typer.Option("--phase", metavar="DEG", min=0.0, max=360.0, help="How far beyond its start the crank is looked at.")]
Step = Annotated[str | None, typer.Option("--step", metavar="TIME", help="Time step.", show_default="the finer automatic one of both ends")]
Target = Annotated[Path | None, typer.Option("-o", "--output", metavar="FILE.map", help="Where to keep it.", show_default="runs/MODEL.map")]
Figure = Annotated[Path | None, typer.Option("--figure", metavar="FILE.png|svg|pdf", help="The diagram.", show_default="FILE.png")]
Table = Annotated[Path | None, typer.Option("--csv", metavar="FILE.csv", help="All points as a table.", show_default=False)]


def map_(
    model: ModelArgument,
    over: Over,
    count: Count = 100,
    turns: Turns = 150,
    drop: Drop = 100,
    of: Of = None,
    phase: Phase = 0.0,
    step: Step = None,
    target: Target = None,
    figure: Figure = None,
    csv: Table = None,
    set_: SetOption = None,
    laws: LawsOption = None,
    quiet: Quiet = False,
) -> None:
    """Bifurcation diagram: a number swept up and down while the motion goes on, looked at once a turn, with the largest Lyapunov exponent.

    The state is carried on from value to value, so that motions which live beside each other are told apart. After Ctrl-C or a kill the same
    command goes on.
    """
    place = target if target is not None else Path("runs") / f"{model.stem}.map"
    with sentences(str(model)):
        drawn = places(place, figure, csv, target is None)
        mechanism = read_model(model, set_, laws)
        from ..live.sliders import asked_slides
        from ..study.maps import bifurcation

        (slide,) = asked_slides(mechanism, [over], "--over")
        size = None if step is None else positive("--step", step, "s")
        place.parent.mkdir(parents=True, exist_ok=True) if target is None else None
        NOW.saved = f"What is complete is kept in {place}; the same command goes on after it."

        def progress(done: int, of_all: int) -> None:
            if not quiet and (done == of_all or done % max(1, of_all // 20) == 0):
                tell("map", f"{done} of {of_all} values", "bold")

        with writing(str(place)):
            found = bifurcation(
                mechanism, slide.paths[0], slide.values[0], slide.values[-1], count=count, turns=turns, dropped=drop, series=of or (),
                phase=phase / 360.0, step=size, file=place, progress=progress,
            )  # fmt: skip
    with writing(str(drawn)):
        from ..plots.bifurcation import diagram
        from ..plots.files import saved_in_style

        saved_in_style(lambda: diagram(found), drawn)
    if csv is not None:
        with writing(str(csv)):
            found.write_csv(csv)
    if not quiet:
        show(found, place, drawn)
    if found.done < count:
        tell("interrupted", f"{NOW.by}: {found.done} of {count} values are complete and kept in {place}; the same command goes on.")
        raise typer.Exit(NOW.code)


def places(place: Path, figure: Path | None, csv: Path | None, own: bool, kind: str = "map") -> Path:
    """Where the diagram goes; ``own``: the folder of the map is made. Raises ValueError for a place that cannot be, or that is of another file."""
    if place.is_dir() or place.suffix.lower() in (*ENDINGS, ".csv"):
        raise ValueError(f"-o {place}: a {kind} file is kept here; name a file that ends otherwise, as in {place.stem or 'model'}.{kind}")
    drawn = figure if figure is not None else place.with_suffix(".png")
    for option, path, endings in (("--figure", drawn, ENDINGS), ("--csv", csv, (".csv",))):
        if path is not None and path.suffix.lower() not in endings:
            raise ValueError(f"{option} {path}: this ends in none of {', '.join(endings)}; name another file")
    for option, path in (("-o", place), ("--figure", drawn), ("--csv", csv)):
        if path is not None and not path.absolute().parent.is_dir() and not (own and path.parent == place.parent):
            raise ValueError(f"{option} {path}: there is no folder {path.absolute().parent}; make it first")
    return drawn


def show(found: Bifurcation, place: Path, drawn: Path) -> None:
    """How many values have which motion."""
    from rich.text import Text

    console = output()
    table = grid("motion", "values on the way up", "on the way down", title=f"{found.name}: {found.asked.path}", right=(1, 2))
    counts = [Counter(kind for kind in kinds if kind) for kinds in found.kinds]
    for kind in dict.fromkeys([*counts[0], *counts[1]]):
        row(table, kind, str(counts[0][kind]), str(counts[1][kind]))
    console.print(table)
    asked = found.asked
    said = f"{asked.turns} turns at each value, {asked.dropped} of them dropped, {asked.steps:,} steps a turn, without companions."
    console.print(Text(f"{said} A period is told within 0.1 % of the range, chaos by an exponent above zero in both halves of the turns."))
    console.print(Text(f"{place}, {drawn}"))
