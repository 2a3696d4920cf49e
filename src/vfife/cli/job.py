"""Jobs of the command line: a forecast on standard error, ``--yes`` where it is much, a progress line, and
words for what a signal leaves.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

from .. import files
from ..job.amounts import span
from ..job.job import Job
from ..job.progress import ProgressLine
from ..store.folder import is_own
from .signals import NOW
from .terminal import STORAGE, fail, sentences, tell, writing

if TYPE_CHECKING:
    from ..job.cost import Forecast
    from ..store.lock import Lock

RUNS = Path("runs")
FIGURES = (".png", ".svg", ".pdf")
LONG_LOOK = 60.0  # s of a forecast from which on a first look is named


class CommandJob(Job):
    """A job that a command began: ``what`` it makes ("map") in the file or folder ``target``. ``first_look``:
    options with which the same takes less time; not ``announced``: a forecast is reported only where the job
    ends because of it.
    """

    def __init__(
        self,
        what: str,
        target: Path,
        *,
        yes: bool = False,
        quiet: bool = False,
        first_look: str = "",
        announced: bool = True,
        saved: str = "",
    ) -> None:
        self.bars, self.begun = ProgressLine(quiet), False
        super().__init__(what, target, yes, self.bars)
        self.target, self.quiet, self.first_look, self.announced = target, quiet, first_look, announced
        self.saved = saved or f"What is complete is kept in {target}; the same command goes on after it."

    def begin(self, forecast: Forecast) -> None:
        """Report a forecast; end the command where the disk has no room, or where it takes much and nobody
        said ``--yes``.
        """
        if excess := forecast.excess(self.target):
            free = files.free_bytes(self.target)
            if free is not None and forecast.disk > free:
                size = f"some {forecast.disk:,.0f} bytes for {forecast.amount}, and {free:,} are free there"
                remedy = (
                    f"{forecast.less}, or name a place on another disk. Nothing was begun, and nothing is"
                    " touched."
                )
                fail(f"{self.target}: this {self.caller} takes {size}; {remedy}", STORAGE)
            if not self.confirm:
                what = f"this {self.caller} takes {excess} for {forecast.amount}"
                fail(f"{what}; add --yes if that is meant, or {forecast.less}. Nothing was begun.")
        if not self.announced:
            return
        if not self.quiet and forecast.count:
            tell("forecast", forecast.sentence(self.target), "bold")
            for part in forecast.parts:
                tell("forecast", part, "bold")
            if forecast.seconds > LONG_LOOK and forecast.first_look < forecast.seconds:
                tell(
                    "note",
                    f"for a first look: {self.first_look} -o first{self.target.suffix}, some"
                    f" {span(forecast.first_look)}.",
                )
        for remark in forecast.remarks if not self.quiet else ():
            tell("note", remark)
        self.start()

    def hold(self, lock: Lock) -> None:
        """Release the lock even where a signal ends the process at once."""
        NOW.last.append(lock.release)

    def start(self) -> None:
        """Begin the work: its folder is made, and a signal leaves what is complete from now on."""
        if self.target.parent == RUNS:
            RUNS.mkdir(exist_ok=True)
        NOW.saved = self.saved
        if not self.begun:
            self.begun = True
            self.bars.__enter__()

    def end(self, kind: type[BaseException] | None = None) -> None:
        """End the progress line."""
        if self.begun:
            self.begun = False
            self.bars.__exit__(kind)

    @contextmanager
    def at_work(self, name: str, kept: str = "") -> Iterator[None]:
        """While the work goes on: an end with a sentence and an exit code where it cannot; ``name``: what
        faults are about; ``kept``: what a full disk leaves.
        """
        with sentences(name), writing(str(self.target), kept):
            try:
                yield
            except BaseException as error:
                self.end(type(error))
                raise
            self.end()


def places(place: Path, kind: str, figure: Path | None, csv: Path | None, own_folder: bool) -> Path:
    """Where the figure of a file of a ``kind`` goes; ``own_folder``: the folder of the file is made.

    Raises ValueError for a place that cannot be, or that is of another file.
    """
    if place.is_dir() or place.suffix.lower() in (*FIGURES, ".csv"):
        raise ValueError(
            f"-o {place}: a {kind} file is kept here; name a file that ends otherwise, as in"
            f" {place.stem or 'model'}.{kind}"
        )
    own = (
        place.with_suffix(".png") if kind == "map" else place.with_name(f"{place.stem}-{kind}.png")
    )  # a model has files of several kinds
    drawn = figure if figure is not None else own
    refuse_endings((("--figure", drawn, FIGURES), ("--csv", csv, (".csv",))))
    if figure is None and drawn.is_file() and not is_own(drawn, None):
        raise ValueError(
            f"{drawn}: a picture that vfife did not draw is where one would be drawn; name another place with"
            " --figure"
        )
    for option, path in (("-o", place), ("--figure", drawn), ("--csv", csv)):
        if (
            path is not None
            and not path.absolute().parent.is_dir()
            and not (own_folder and path.parent == place.parent)
        ):
            raise ValueError(f"{option} {path}: there is no folder {path.absolute().parent}; make it first")
    return drawn


def refuse_endings(
    targets: tuple[tuple[str, Path | None, tuple[str, ...]], ...], in_folder: bool = False
) -> None:
    """Raise ValueError for a file (option, path, endings that it may have) of another ending; ``in_folder``:
    or in a folder that is not there.
    """
    for option, path, endings in targets:
        if path is None or (
            path.suffix.lower() in endings and not (in_folder and not path.absolute().parent.is_dir())
        ):
            continue
        if in_folder:
            raise ValueError(
                f"{option} {path}: this is no file ending in {' or '.join(endings)}, in a folder that is"
                " there; name one"
            )
        raise ValueError(f"{option} {path}: this ends in none of {', '.join(endings)}; name another file")
