"""``vfife wear``: how joints with play wear over millions of turns."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from ..results.schemas import WEAR
from .job import RUNS, CommandJob, places, refuse_endings
from .map import STEP
from .options import LawsOption, SetOption, positive, read_model
from .run import Quiet, Yes
from .signals import NOW
from .targets import refuse_inputs
from .terminal import counted, grid, output, row, sentences, tell, writing

if TYPE_CHECKING:
    from ..model.mechanism import Mechanism
    from ..study.tribology.wear_state import Worn

MOST_BLOCK, MOST_HARMONICS, MOST_TURNS = 100_000, 32, 1e15
CLEAR = 0.8  # of what the deepest places lost, the least that play may follow unremarked
Model = Annotated[Path, typer.Argument(metavar="MODEL.toml", help="Model file, or a wear file to be shown.", show_default=False)]
Turns = Annotated[float, typer.Option("--turns", metavar="N", min=1, help="Turns of the crank, as in 1e7.", show_default="1e6")]
Block = Annotated[int, typer.Option("--block", metavar="N", min=1, max=MOST_BLOCK, help="Turns that are simulated for a rate.")]
Settle = Annotated[int, typer.Option("--settle", metavar="N", min=1, max=MOST_BLOCK, help="Turns before them that are not looked at.")]
Tolerance = Annotated[float, typer.Option("--tolerance", metavar="SHARE", help="Most error of a jump, as a share of the smallest clearance.")]
Harmonics = Annotated[
    int, typer.Option("--harmonics", metavar="N", min=0, max=MOST_HARMONICS, help="Of the worn profiles that clearances follow; 0: they do not.")
]
Step = Annotated[str | None, typer.Option("--step", metavar="TIME", help=STEP, show_default="automatic")]
Play = Annotated[str | None, typer.Option("--clearance", metavar="LENGTH", help="Play of a joint that ends its life.", show_default=False)]
Force = Annotated[str | None, typer.Option("--force", metavar="FORCE", help="Force of a joint that ends its life.", show_default=False)]
Target = Annotated[Path | None, typer.Option("-o", "--output", metavar="FILE.wear", help="Where to keep it.", show_default="runs/MODEL.wear")]
Figure = Annotated[Path | None, typer.Option("--figure", metavar="FILE.png|svg|pdf", help="The figure.", show_default="FILE-wear.png")]
Table = Annotated[Path | None, typer.Option("--csv", metavar="FILE.csv", help="All depths as a table.", show_default=False)]
Saved = Annotated[Path | None, typer.Option("--worn", metavar="WORN.toml", help="The model as it is worn in the end.", show_default=False)]


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
    """Wear of joints with play over many turns, by Archard's law: blocks of turns that are simulated, and jumps with a known error between them.

    The joints that wear have a table wear in the model. Clearances follow the worn surfaces. After Ctrl-C or a kill the same command goes on.
    """
    kept = WEAR.owns(model)
    place = model if kept else target if target is not None else RUNS / f"{model.stem}.wear"
    job = CommandJob("wear", place, yes=yes, quiet=quiet)
    with sentences(str(model)):
        if not turns <= MOST_TURNS:  # not a bound of the option: its help would be widened by all its zeros
            raise ValueError(f"--turns {turns:g}: more than can be counted; allowed: 1 to {MOST_TURNS:g}")
        drawn = places(place, "wear", figure, csv, target is None and not kept)
        refuse_endings((("--worn", saved, (".toml",)),), in_folder=True)
        targets = (("--figure", drawn), ("--csv", csv), ("--worn", saved), *((("-o", place),) if not kept else ()))
        refuse_inputs(targets, (model, *(laws or ())))
        from ..study.tribology.simulate_wear import load_wear
        from ..study.tribology.simulate_wear import wear as worn_over

        if kept:
            found = load_wear(model)
        else:
            mechanism = read_model(model, set_, laws)
            sizes = [
                None if text is None else positive(option, text, unit)
                for option, text, unit in (("--clearance", clearance, "m"), ("--force", force, "N"), ("--step", step, "s"))
            ]
            with job.at_work(str(model)):
                job.start()
                found = worn_over(
                    mechanism, turns, block=block, settle=settle, tolerance=tolerance, harmonics=harmonics, clearance=sizes[0], force=sizes[1],
                    step=sizes[2], file=place, progress=job,
                )  # fmt: skip
    keep(found, drawn, csv, saved)
    if not quiet:
        show(found, place, drawn)
    if not found.complete and not kept:
        tell("interrupted", f"{NOW.by}: {found.turns[-1]:,.0f} of {turns:,.0f} turns are known and kept in {place}; the same command goes on.")
        raise typer.Exit(NOW.code)


def keep(found: Worn, drawn: Path, csv: Path | None, saved: Path | None) -> None:
    """Figure, table and worn model."""
    with writing(str(drawn)):
        from ..plots.style import saved_in_style

        saved_in_style(found.plot, drawn)
    if csv is not None:
        with writing(str(csv)):
            found.write_csv(csv)
    if saved is not None:
        from ..modelfile.files import save_model

        with sentences(str(saved)):
            save_model(found.mechanism(), saved)


def show(found: Worn, place: Path, drawn: Path) -> None:
    """Depth and volume of each surface, and how they were found."""
    from rich.text import Text

    console = output()
    table = grid(
        "surface",
        "k (1/Pa)",
        "deepest",
        "volume",
        "play",
        "largest force",
        title=f"{found.name}: {found.turns[-1]:,.0f} turns",
        right=(1, 2, 3, 4, 5),
    )
    for surface, depth in zip(found.surfaces, found.depth[-1], strict=True):
        joint = found.joints.index(surface.joint)
        volume = 1e9 * found.volume(surface.joint, surface.side)[-1]
        row(
            table, f"{surface.joint} {surface.side}", f"{surface.k:.3g}", f"{1e6 * depth.max():.4g} µm", f"{volume:.4g} mm³",
            f"{1e6 * found.play[-1, joint]:.4g} µm", f"{found.force[-1, joint]:.4g} N",
        )  # fmt: skip
    console.print(table)
    for sentence in said(found):
        console.print(Text(sentence))
    console.print(Text(f"{place}, {drawn}"))


def said(found: Worn) -> list[str]:
    """How it was found, and what it does not know."""
    asked, mechanism = found.asked, found.mechanism(0)
    frictions = ", ".join(f"{name} {mechanism.contacts[name].friction.name}" for name in found.joints)
    sentences = [
        f"{found.simulated:,.0f} turns were simulated, {asked.settle} of {asked.settle + asked.block} dropped each time, {asked.steps:,} steps a "
        f"turn; friction: {frictions}.{companion(found)}",
        f"{counted(len(found.turns) - 1, 'jump')}, the largest error {1e6 * found.errors.max():.2g} µm, all together "
        f"{1e6 * found.errors.sum():.2g} µm; "
        + (
            f"the turns of a block leave {100.0 * found.spread.max():.2g} % of a rate open."
            if asked.block > 1
            else "what a block of one turn leaves of a rate open is not known."
        ),
    ]
    sentences.extend(named(mechanism, found))
    if asked.harmonics == 0:
        sentences.append("Clearances do not follow what is worn, so depths go with the turns.")
    if found.sharp.max() > 1.0:
        sentences.append(
            "Profiles bend more sharply than the journal, which would rest on the edges of what it wore: depths are more than there would be."
        )
    if 0 < asked.harmonics < MOST_HARMONICS:
        sentences.extend(blurred(found))
    if found.ended:
        sentences.append(
            f"Life: {found.ended['turns']:,.0f} turns, until joint {found.ended['joint']} reaches the limit of its {found.ended['by']}."
        )
    elif asked.clearance is not None or asked.force is not None:
        sentences.append(f"Life: more than {found.turns[-1]:,.0f} turns; no limit was reached{later(found)}.")
    return sentences


def named(mechanism: Mechanism, found: Worn) -> Iterator[str]:
    """Of each surface whose coefficient is that of a named pair, where that is from and how far it is known."""
    from ..laws.wear import OILED, PAIRS, SCATTER

    for one in found.surfaces:
        pair = getattr(mechanism.contacts[one.joint].wear, one.side)
        if isinstance(pair, str):
            number, source = PAIRS[pair]
            yield (
                f"The coefficient of {one.joint} {one.side} is that of {pair}, dry, K = {number:g} ({source}): tests lie within a factor of "
                f"{SCATTER:g}, {one.k / SCATTER:.2g} to {one.k * SCATTER:.2g} 1/Pa, with oil {OILED * one.k:.2g} and less; depths go with it."
            )


def companion(found: Worn) -> str:
    """What the last block again with half the step says."""
    if not found.beside:
        return " No companion with half the step was run: the wear is not complete."
    volume, place = (100.0 * share for share in found.beside)
    return f" With half the step the last block wears {volume:.2g} % of volume more or less, {place:.2g} % of the deepest place."


def blurred(found: Worn) -> Iterator[str]:
    """Of each joint whose play follows much less than its deepest places, since the harmonics of its profiles blur them: both."""
    for k, joint in enumerate(found.joints):
        here = [place for place, one in enumerate(found.surfaces) if one.joint == joint]
        lost = float((found.depth[-1, here] - found.depth[0, here]).max(axis=1).sum())
        more = float(found.play[-1, k] - found.play[0, k])
        if more < CLEAR * lost:
            yield (
                f"The play of {joint} grew by {1e6 * more:.4g} µm where its deepest places lost {1e6 * lost:.4g} µm: "
                f"{found.asked.harmonics} harmonics blur what is narrow; see how far more of them (--harmonics "
                f"{min(2 * found.asked.harmonics, MOST_HARMONICS)}) change it."
            )


def later(found: Worn) -> str:
    """When the first joint would reach the limit of its play at the rate of the last jump; nothing where it has no limit or does not grow."""
    limit = found.asked.clearance
    if limit is None or len(found.turns) < 2:
        return ""
    rate = (found.play[-1] - found.play[-2]) / (found.turns[-1] - found.turns[-2])
    left = [((limit - play) / slope, joint) for play, slope, joint in zip(found.play[-1], rate, found.joints, strict=True) if slope > 0.0]
    if not left:
        return ""
    turns, joint = min(left)
    return f", and as fast as it wears now joint {joint} would come to {1e3 * limit:.4g} mm after some {found.turns[-1] + turns:.2g} turns"
