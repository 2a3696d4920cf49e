"""What the commands of maps have in common: options, places, progress, and what is told of what they find."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, TypeVar

import typer

from ..results.folder import is_own
from .options import positive
from .sensitivity import ENDINGS
from .signals import NOW
from .terminal import grid, output, row, tell, writing

if TYPE_CHECKING:
    from ..model.mechanism import Mechanism
    from ..study.basins import Basins
    from ..study.diagram import Bifurcation
    from ..study.sections import PoincareSection
    from ..study.waterfall import Fallen, Waterfall

Found = TypeVar("Found")
Drop = Annotated[int, typer.Option("--drop", metavar="N", min=0, help="So many of them are not looked at.")]
Of = Annotated[
    list[str] | None, typer.Option("--of", metavar="SERIES", help="What is looked at once a turn.", show_default="penetration, force_max")
]
Phase = Annotated[float, typer.Option("--phase", metavar="DEG", min=0.0, max=360.0, help="How far beyond its start the crank is looked at.")]
STEP = "Time step; a turn has a whole number of them."
Step = Annotated[str | None, typer.Option("--step", metavar="TIME", help=STEP, show_default="the finer automatic one of both ends")]
Target = Annotated[Path | None, typer.Option("-o", "--output", metavar="FILE.map", help="Where to keep it.", show_default="runs/MODEL.map")]
Figured = Annotated[Path | None, typer.Option("--figure", metavar="FILE.png|svg|pdf", help="The picture.", show_default="FILE.png")]
Csv = Annotated[Path | None, typer.Option("--csv", metavar="FILE.csv", help="All points as a table.", show_default=False)]
Kept = Annotated[Path, typer.Argument(metavar="FILE.map", help="What a map was kept in.", show_default=False)]
Yes = Annotated[bool, typer.Option("--yes", help="Make it whatever it takes: hours, or half the disk.")]
GO_ON = "the same command goes on"


def places(place: Path, figure: Path | None, csv: Path | None, own: bool, kind: str = "map") -> Path:
    """Where the picture goes; ``own``: the folder of the map is made. Raises ValueError for a place that cannot be, or that is of another file."""
    if place.is_dir() or place.suffix.lower() in (*ENDINGS, ".csv"):
        raise ValueError(f"-o {place}: a {kind} file is kept here; name a file that ends otherwise, as in {place.stem or 'model'}.{kind}")
    own_name = place.with_suffix(".png") if kind == "map" else place.with_name(f"{place.stem}-{kind}.png")  # each kind its own: a model has several
    drawn = figure if figure is not None else own_name
    for option, path, endings in (("--figure", drawn, ENDINGS), ("--csv", csv, (".csv",))):
        if path is not None and path.suffix.lower() not in endings:
            raise ValueError(f"{option} {path}: this ends in none of {', '.join(endings)}; name another file")
    if figure is None and drawn.is_file() and not is_own(drawn, None):
        raise ValueError(f"{drawn}: a picture that vfife did not draw is where one would be drawn; name another place with --figure")
    for option, path in (("-o", place), ("--figure", drawn), ("--csv", csv)):
        if path is not None and not path.absolute().parent.is_dir() and not (own and path.parent == place.parent):
            raise ValueError(f"{option} {path}: there is no folder {path.absolute().parent}; make it first")
    return drawn


def quantity_at(option: str, text: str | None) -> float | None:
    """A time that is given as an option."""
    return None if text is None else positive(option, text, "s")


def start_numbers(mechanism: Mechanism, text: str) -> dict[str, float]:
    """Numbers of a start: "own", or PATH=VALUE, PATH=VALUE. Raises ValueError."""
    from ..study.starts import unit_of_start
    from ..units import number

    found: dict[str, float] = {}
    for item in [] if text.strip() == "own" else text.split(","):
        path, sign, value = (part.strip() for part in item.partition("="))
        if not (sign and path and value):
            raise ValueError(f'--start {text}: this is neither own nor PATH=VALUE; write it as in --start "start.crank=90deg, start.pin.x=0.1mm"')
        try:
            found[path] = number(value, unit_of_start(mechanism, path))
        except ValueError as error:
            raise ValueError(f"--start {item.strip()}: {error}") from None
    return found


def start_range(mechanism: Mechanism, text: str) -> tuple[str, float, float]:
    """A number of a start or of the model with its range: PATH=LOW..HIGH. Raises ValueError."""
    from ..live.sliders import NUMBER, bare
    from ..study.starts import unit_of_start
    from ..units import number

    path, sign, span = (part.strip() for part in text.partition("="))
    low, dots, high = (part.strip() for part in span.partition(".."))
    if not (sign and dots and path and low and high):
        raise ValueError(f"--over {text}: this is not PATH=LOW..HIGH; write it as in --over start.pin.x=-0.2..0.2mm")
    try:
        unit = unit_of_start(mechanism, path)
        ends = number(f"{low} {NUMBER.sub('', high)}" if bare(low) else low, unit), number(high, unit)
    except ValueError as error:
        raise ValueError(f"--over {text}: {error}") from None
    if not ends[0] < ends[1]:
        raise ValueError(f"--over {text}: the range is empty; write its lower end first")
    return path, *ends


def carried_out(place: Path, quiet: bool, what: str, make: Callable[[Callable[[int, int], None]], Found]) -> Found:
    """Makes a map, with lines on how far it is."""
    place.parent.mkdir(parents=True, exist_ok=True) if place.parent == Path("runs") else None
    NOW.saved = f"What is complete is kept in {place}; {GO_ON} after it."

    def progress(done: int, of_all: int) -> None:
        if not quiet and (done == of_all or done % max(1, of_all // 20) == 0):
            tell("waterfall" if place.suffix == ".waterfall" else "map", f"{done:,} of {of_all:,} {what}", "bold")

    with writing(str(place)):
        return make(progress)


def drawn_and_told(found: Any, place: Path, drawn: Path | None, csv: Path | None, quiet: bool, whole: bool = True) -> None:
    """Draws it, writes its table, and says what it is; where it is not ``whole``, nobody waits for the rest."""
    if drawn is not None:
        with writing(str(drawn)):
            from ..plots.files import saved_in_style

            saved_in_style(found.plot, drawn)
    if csv is not None:
        with writing(str(csv)):
            found.write_csv(csv)
    done, of_all, what = counted(found)
    if not quiet:
        teller_of(found)(found)
        print_line(", ".join(str(path) for path in (place, drawn, csv) if path is not None))
    if whole and done < of_all:
        tell("interrupted", f"{NOW.by}: {done:,} of {of_all:,} {what} are complete and kept in {place}; {GO_ON}.")
        raise typer.Exit(NOW.code)


def counted(found: Any) -> tuple[int, int, str]:
    """How much of it is done, of how much."""
    from ..study.basins import Basins
    from ..study.sections import PoincareSection

    if isinstance(found, PoincareSection):
        return found.done, found.asked.turns - found.asked.dropped, "turns"
    if isinstance(found, Basins):
        return found.done, found.asked.count, "starts"
    return found.done, len(found.asked.values), "values"


def teller_of(found: Any) -> Callable[[Any], None]:
    """What tells of it."""
    from ..study.basins import Basins
    from ..study.sections import PoincareSection
    from ..study.waterfall import Waterfall

    tellers: dict[type, Callable[[Any], None]] = {PoincareSection: tell_section, Basins: tell_basins, Waterfall: tell_waterfall}
    return next((tell for kind, tell in tellers.items() if isinstance(found, kind)), tell_diagram)


def print_line(text: str) -> None:
    """A line on standard output."""
    from rich.text import Text

    output().print(Text(text))


def tell_diagram(found: Bifurcation) -> None:
    """How many values have which motion."""
    console, asked = output(), found.asked
    heads = ("values on the way up", "on the way down") if not asked.starts else asked.ways
    table = grid("motion", *heads, title=f"{found.name}: {asked.path}", right=tuple(range(1, len(heads) + 1)))
    counts = [Counter(kind for kind in kinds if kind) for kinds in found.kinds]
    for kind in dict.fromkeys(kind for one in counts for kind in one):
        row(table, kind, *(str(one[kind]) for one in counts))
    console.print(table)
    print_line(f"{asked.turns} turns at each value, {asked.dropped} of them dropped, {asked.steps:,} steps a turn; {found.laws}.")
    print_line("A period is told within 0.1 % of the range, chaos where a small difference grows more than e-fold in each half of the turns.")
    print_line(f"Companions: {found.told or 'none.'}")


def tell_basins(found: Basins) -> None:
    """How many starts come to which motion."""
    console, asked = output(), found.asked
    table = grid("motion", "starts", "share", title=f"{found.name}: {asked.paths[0]}, {asked.paths[1]}", right=(1, 2))
    for one in found.attractors:
        row(table, one.kind, f"{len(one.members):,}", f"{100.0 * len(one.members) / max(len(found.verdicts), 1):.3g} %")
    console.print(table)
    none = found.done - len(found.verdicts)
    left = f" {none:,} of the grid are no start, a journal being outside its bearing." if none else ""
    print_line(f"{asked.turns} turns of each start, {asked.dropped} of them dropped, {asked.steps:,} steps a turn; {found.laws}.{left}")
    print_line("A period is told within 0.1 % of the range; periodic motions are one where their points are within 1 % of that of all.")
    print_line(f"Companions: {found.told or 'none.'}")


def tell_section(found: PoincareSection) -> None:
    """What a motion is, and what says so."""
    asked, verdict = found.asked, found.verdict
    print_line(f"{found.name}: {verdict.kind}")
    print_line(f"{verdict.evidence[:1].upper()}{verdict.evidence[1:]}.")
    for name, one in found.struck.items():
        fastest = f", the fastest at {one['speed'].max():.4g} m/s" if len(one["speed"]) else ""
        count = len(one["speed"])
        print_line(f"{name}: {count:,} contact{'' if count == 1 else 's'} began{fastest}.")
    print_line(f"{found.done:,} turns after {asked.dropped:,} that were dropped, {asked.steps:,} steps a turn; {found.laws}.")


def turning(asked: Fallen) -> str:
    """Speeds as the axis of the figure has them, in brackets; nothing of other numbers."""
    low, high = (30.0 / math.pi * asked.values[end] for end in (0, -1))
    return f" ({low:.4g} to {high:.4g} rpm)" if asked.unit == "rad/s" else ""


def tell_waterfall(found: Waterfall) -> None:
    """What was swept, and how it was transformed."""
    asked = found.asked
    print_line(
        f"{found.name}: {', '.join(asked.series)} over {asked.path} from {asked.values[0]:g} to {asked.values[-1]:g} {asked.unit}{turning(asked)}"
    )
    print_line(f"{found.done:,} runs. {found.words}. Without companions; each run begins at the model's own start.")
    if found.diverged:
        print_line(f"At {', '.join(f'{value:g}' for value in found.diverged)} {asked.unit} the motion diverged.")
