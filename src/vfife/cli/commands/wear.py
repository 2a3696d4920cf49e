"""``vfife wear``: how joints with play wear over millions of turns."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from ...store.schemas import WEAR
from ..job import RUNS, CommandJob, places, refuse_endings
from ..options import LawsOption, SetOption, positive, read_model, refuse_inputs
from ..signals import NOW
from ..terminal import answer, print_line, sentences, tell, writing
from .map import STEP
from .run import Quiet, Yes

if TYPE_CHECKING:
    from ...tribology.wear_state import Worn

MOST_BLOCK, MOST_HARMONICS, MOST_TURNS = 100_000, 32, 1e15
Model = Annotated[
    Path,
    typer.Argument(metavar="MODEL.toml", help="Model file, or a wear file to be shown.", show_default=False),
]
Turns = Annotated[
    float,
    typer.Option("--turns", metavar="N", min=1, help="Turns of the crank, as in 1e7.", show_default="1e6"),
]
Block = Annotated[
    int,
    typer.Option("--block", metavar="N", min=1, max=MOST_BLOCK, help="Turns that are simulated for a rate."),
]
Settle = Annotated[
    int,
    typer.Option(
        "--settle", metavar="N", min=1, max=MOST_BLOCK, help="Turns before them that are not looked at."
    ),
]
Tolerance = Annotated[
    float,
    typer.Option(
        "--tolerance", metavar="SHARE", help="Most error of a jump, as a share of the smallest clearance."
    ),
]
Harmonics = Annotated[
    int,
    typer.Option(
        "--harmonics",
        metavar="N",
        min=0,
        max=MOST_HARMONICS,
        help="Of the worn profiles that clearances follow; 0: they do not.",
    ),
]
Step = Annotated[str | None, typer.Option("--step", metavar="TIME", help=STEP, show_default="automatic")]
Play = Annotated[
    str | None,
    typer.Option(
        "--clearance", metavar="LENGTH", help="Play of a joint that ends its life.", show_default=False
    ),
]
Force = Annotated[
    str | None,
    typer.Option("--force", metavar="FORCE", help="Force of a joint that ends its life.", show_default=False),
]
Target = Annotated[
    Path | None,
    typer.Option(
        "-o", "--output", metavar="FILE.wear", help="Where to keep it.", show_default="runs/MODEL.wear"
    ),
]
Figure = Annotated[
    Path | None,
    typer.Option("--figure", metavar="FILE.png|svg|pdf", help="The figure.", show_default="FILE-wear.png"),
]
Table = Annotated[
    Path | None, typer.Option("--csv", metavar="FILE.csv", help="All depths as a table.", show_default=False)
]
Saved = Annotated[
    Path | None,
    typer.Option(
        "--worn", metavar="WORN.toml", help="The model as it is worn in the end.", show_default=False
    ),
]


def wear(
    model: Model,
    turns: Turns = 1e6,
    block: Block = 4,
    settle: Settle = 4,
    tolerance: Tolerance = 0.01,
    harmonics: Harmonics = 8,
    clearance: Play = None,
    force: Force = None,
    step: Step = None,
    target: Target = None,
    figure: Figure = None,
    csv: Table = None,
    saved: Saved = None,
    set_: SetOption = None,
    laws: LawsOption = None,
    yes: Yes = False,
    quiet: Quiet = False,
) -> None:
    """Wear of joints with play over many turns, by Archard's law: blocks of turns that are simulated, and
    jumps with a known error between them.

    The joints that wear have a table wear in the model. Clearances follow the worn surfaces. After Ctrl-C or
    a kill the same command goes on.
    """
    kept = WEAR.owns(model)
    place = model if kept else target if target is not None else RUNS / f"{model.stem}.wear"
    job = CommandJob("wear", place, yes=yes, quiet=quiet)
    with sentences(str(model)):
        if not turns <= MOST_TURNS:  # not a bound of the option: its help would be widened by all its zeros
            raise ValueError(f"--turns {turns:g}: more than can be counted; allowed: 1 to {MOST_TURNS:g}")
        drawn = places(place, "wear", figure, csv, target is None and not kept)
        refuse_endings((("--worn", saved, (".toml",)),), in_folder=True)
        targets = (
            ("--figure", drawn),
            ("--csv", csv),
            ("--worn", saved),
            *((("-o", place),) if not kept else ()),
        )
        refuse_inputs(targets, (model, *(laws or ())))
        from ...tribology.simulate_wear import load_wear
        from ...tribology.simulate_wear import wear as worn_over

        if kept:
            found = load_wear(model)
        else:
            mechanism = read_model(model, set_, laws)
            sizes = [
                None if text is None else positive(option, text, unit)
                for option, text, unit in (
                    ("--clearance", clearance, "m"),
                    ("--force", force, "N"),
                    ("--step", step, "s"),
                )
            ]
            with job.at_work(str(model)):
                job.start()
                found = worn_over(
                    mechanism, turns, block=block, settle=settle, tolerance=tolerance, harmonics=harmonics, clearance=sizes[0], force=sizes[1],
                    step=sizes[2], file=place, progress=job,
                )  # fmt: skip
    keep(found, drawn, csv, saved)
    if not quiet:
        from ...report.wear import document

        answer(document(found))
        print_line(f"{place}, {drawn}")
    if not found.complete and not kept:
        tell(
            "interrupted",
            f"{NOW.by}: {found.turns[-1]:,.0f} of {turns:,.0f} turns are known and kept in {place}; the same"
            " command goes on.",
        )
        raise typer.Exit(NOW.code)


def keep(found: Worn, drawn: Path, csv: Path | None, saved: Path | None) -> None:
    """Figure, table and worn model."""
    with writing(str(drawn)):
        from ...plots.style import saved as written

        written(found.plot(), drawn)
    if csv is not None:
        with writing(str(csv)):
            found.write_csv(csv)
    if saved is not None:
        from ...modelfile.files import save_model

        with sentences(str(saved)):
            save_model(found.mechanism(), saved)
