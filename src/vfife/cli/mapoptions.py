"""Options that the commands of maps share, and what becomes of their texts."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from .options import positive

if TYPE_CHECKING:
    from ..model.mechanism import Mechanism

Drop = Annotated[
    int | None, typer.Option("--drop", metavar="N", min=0, help="So many of them are not looked at.", show_default="two thirds of them")
]
Of = Annotated[
    list[str] | None,
    typer.Option(
        "--of",
        metavar="SERIES",
        help="What is looked at once a turn.",
        show_default="penetration, force_max of a joint with play; else a place or speed",
    ),
]
Phase = Annotated[float, typer.Option("--phase", metavar="DEG", min=0.0, max=360.0, help="How far beyond its start the crank is looked at.")]
STEP = "Time step; a turn has a whole number of them."
Step = Annotated[
    str | None, typer.Option("--step", metavar="TIME", help=STEP, show_default="the finest that a run finds at the ends and in the middle")
]
Target = Annotated[Path | None, typer.Option("-o", "--output", metavar="FILE.map", help="Where to keep it.", show_default="runs/MODEL.map")]
Figured = Annotated[Path | None, typer.Option("--figure", metavar="FILE.png|svg|pdf", help="The picture.", show_default="FILE.png")]
Csv = Annotated[Path | None, typer.Option("--csv", metavar="FILE.csv", help="All points as a table.", show_default=False)]
Kept = Annotated[Path, typer.Argument(metavar="FILE.map", help="What a map was kept in.", show_default=False)]
Yes = Annotated[bool, typer.Option("--yes", help="Make it whatever it takes: hours, or half the disk.")]


def drop_of(drop: int | None, turns: int, share: float | None = None) -> int:
    """Turns that are not looked at, of so many: a share of them unless said. Raises ValueError where none is left."""
    from ..study.maps.section_series import DROPPED, left_out

    if drop is not None and drop >= turns:
        raise ValueError(f"--drop {drop}: no turn is left to look at of --turns {turns}; allowed: 0 to {turns - 1}, fewer of them are dropped then")
    return left_out(drop, turns, DROPPED if share is None else share)


def quantity_at(option: str, text: str | None) -> float | None:
    """A time that is given as an option."""
    return None if text is None else positive(option, text, "s")


def turning_steps(models: Sequence[Mechanism], step: float | None) -> int:
    """Steps of a turn, as they will be taken; 0 where no crank turns, which is told when a map is begun. Raises ModelError for a step too large."""
    from ..model.functions import turn_of
    from ..study.maps.section_series import step_count

    return 0 if any(turn_of(model) is None for model in models) else step_count(models, step, search=True)


def start_numbers(mechanism: Mechanism, text: str) -> dict[str, float]:
    """Numbers of a start: "own", or PATH=VALUE, PATH=VALUE. Raises ValueError."""
    from ..study.maps.starts import unit_of_start
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


def number_range(mechanism: Mechanism, text: str, starts: bool = False) -> tuple[str, float, float]:
    """A number of the model, or of a start too (``starts``), with its range (SI): PATH=LOW..HIGH. Raises ValueError."""
    from ..study.maps.section_series import unit_at
    from ..study.maps.starts import unit_of_start
    from ..units import ends_of, number

    path, sign, span = (part.strip() for part in text.partition("="))
    ends = ends_of(span)
    if not (sign and path and ends):
        raise ValueError(f"--over {text}: this is not PATH=LOW..HIGH; write it as in --over joint.C.clearance=0.1..1mm")
    try:
        unit = (unit_of_start if starts else unit_at)(mechanism, path)
        low, high = (number(end, unit) for end in ends)
    except ValueError as error:
        raise ValueError(f"--over {text}: {error}") from None
    if not low < high:
        raise ValueError(f"--over {text}: the range is empty; write its lower end first")
    return path, low, high
