"""The way of every command of maps: places, model, question, what it will cost, the map itself, its picture and table, and what is told of it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..results.folder import is_own
from .mapcost import Work, told_of
from .mapped import GO_ON, drawn_and_told
from .options import read_model
from .sensitivity import ENDINGS
from .signals import NOW
from .targets import refuse_inputs
from .terminal import sentences, tell, writing

if TYPE_CHECKING:
    from ..model.mechanism import Mechanism

RUNS = Path("runs")


@dataclass(frozen=True)
class Given:
    """What each of them is given beside its question. ``ending``: of its file's name, after that of the model; ``kind``: of the file."""

    model: Path
    ending: str
    target: Path | None
    figure: Path | None
    csv: Path | None
    set_: list[str] | None
    laws: list[Path] | None
    yes: bool
    quiet: bool
    kind: str = "map"

    @property
    def place(self) -> Path:
        """Where it is kept."""
        return self.target if self.target is not None else RUNS / f"{self.model.stem}{self.ending}"


@dataclass(frozen=True)
class Question:
    """What a command asks of a mechanism: the ``work`` it takes, what ``make`` is called with beside the file, and how it is counted and drawn."""

    work: Work
    counted: str
    make: Callable[..., Any]
    given: Mapping[str, Any]
    drawn: Mapping[str, Any] = field(default_factory=dict)


def answered(given: Given, understood: Callable[[Mechanism], Question]) -> None:
    """Goes through with it; ends with a sentence and an exit code where it cannot be."""
    place = given.place
    with sentences(str(given.model)):
        drawn = places(place, given.figure, given.csv, given.target is None, given.kind)
        refuse_inputs((("-o", place), ("--figure", drawn), ("--csv", given.csv)), (given.model, *(given.laws or ())))
        mechanism = read_model(given.model, given.set_, given.laws)
        asked = understood(mechanism)
    told_of(asked.work, mechanism, place, given.yes, given.quiet)
    with writing(str(place)):
        place.parent.mkdir(parents=True, exist_ok=True) if place.parent == RUNS else None
    NOW.saved = f"What is complete is kept in {place}; {GO_ON} after it."

    def progress(done: int, of_all: int) -> None:
        if not given.quiet and (done == of_all or done % max(1, of_all // 20) == 0):
            tell(given.kind, f"{done:,} of {of_all:,} {asked.counted}", "bold")

    with sentences(str(given.model)), writing(str(place)):
        found = asked.make(mechanism, **asked.given, file=place, progress=progress)
    drawn_and_told(found, place, drawn, given.csv, given.quiet, plot=asked.drawn)


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
