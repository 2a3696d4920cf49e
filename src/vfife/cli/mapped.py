"""Figures, tables and words of maps, sections, basins and waterfalls."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import typer

from .signals import NOW
from .terminal import answer, print_line, tell, writing


def drawn_and_told(
    found: Any, place: Path, drawn: Path | None, csv: Path | None, quiet: bool, *, whole: bool = True, plot: Mapping[str, Any] | None = None
) -> None:
    """Draws it, as ``plot`` says, writes its table, and says what it is; where it is not ``whole``, nobody waits for the rest."""
    if drawn is not None:
        with writing(str(drawn)):
            from ..plots.style import saved

            saved(found.plot(**plot or {}), drawn)
    if csv is not None:
        with writing(str(csv)):
            found.write_csv(csv)
    done, of_all, what = counted(found)
    if not quiet:
        from ..report.maps import document

        answer(document(found))
        print_line(", ".join(str(path) for path in (place, drawn, csv) if path is not None))
    if whole and done < of_all:
        tell("interrupted", f"{NOW.by}: {done:,} of {of_all:,} {what} are complete and kept in {place}; the same command goes on.")
        raise typer.Exit(NOW.code)


def counted(found: Any) -> tuple[int, int, str]:
    """How much of it is done, of how much."""
    from ..study.maps.basins import Basins
    from ..study.maps.sections import PoincareSection

    if isinstance(found, PoincareSection):
        return found.done, found.asked.turns - found.asked.dropped, "turns"
    if isinstance(found, Basins):
        return found.done, found.asked.count, "starts"
    return found.done, len(found.asked.values), "values"
