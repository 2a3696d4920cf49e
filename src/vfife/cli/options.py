"""Arguments and options that several commands share, and what becomes of them."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import typer

if TYPE_CHECKING:
    from ..model.mechanism import Mechanism

ModelArgument = Annotated[Path, typer.Argument(metavar="MODEL.toml", help="Model file.", show_default=False)]
RunArgument = Annotated[Path, typer.Argument(metavar="RUN", help="Run folder, or the run file in it.", show_default=False)]
SetOption = Annotated[
    list[str] | None,
    typer.Option("--set", metavar="PATH=VALUE", help='Set a number of the model by its path, as in joint.C.clearance="0.5 mm".'),
]
LawsOption = Annotated[
    list[Path] | None,
    typer.Option("--laws", metavar="FILE.py", help="Python file with laws of your own, which is run; a model file itself never names code."),
]
ClusterOption = Annotated[
    str | None,
    typer.Option(
        metavar="ADDRESS",
        help="Run members on a cluster of dask.distributed: the address of its scheduler, or local for processes of this machine.",
    ),
]
JsonOption = Annotated[bool, typer.Option("--json", help="Print one JSON value on standard output, and nothing else.")]


def overrides(texts: Iterable[str] | None) -> list[tuple[str, str]]:
    """Paths and values of ``--set``."""
    items = []
    for text in texts or ():
        path, sign, value = text.partition("=")
        if not sign or not path.strip():
            raise ValueError(f'--set {text}: this is not PATH=VALUE; write it as in --set joint.C.clearance="0.5 mm"')
        items.append((path.strip(), value.strip()))
    return items


def take_laws(files: Iterable[Path] | None) -> list[str]:
    """Runs the files of ``--laws``; names of the laws that they define."""
    found: list[str] = []
    for file in dict.fromkeys(files or ()):
        from ..errors import LawError
        from ..laws.user import load_laws

        try:
            found += [law.name for law in load_laws(file)]
        except LawError as error:
            raise ValueError(f"--laws {error}") from None
    return found


def read_model(path: Path, texts: Iterable[str] | None, laws: Iterable[Path] | None = None) -> Mechanism:
    """The mechanism of a model file with what ``--set`` says, the laws of ``--laws`` being known."""
    from ..modelfile import load

    take_laws(laws)
    return load(path, set=overrides(texts))


def positive(option: str, text: str, unit: str) -> float:
    """A quantity above zero given as an option, a bare number being in SI units."""
    from ..errors import Fault
    from ..units import number

    try:
        value = number(text, unit)
    except Fault as error:
        raise ValueError(f"{option} {text}: {error.what}; allowed: {error.limit} ({error.remedy})") from None
    if not (value > 0.0 and math.isfinite(value)):
        raise ValueError(f"{option} {text}: zero or negative; allowed: a quantity above 0 {unit}")
    return value


def with_options(
    mechanism: Mechanism,
    step: str | None,
    turns: float | None,
    duration: str | None,
    outputs: int | None,
    companions: str | None = None,
    settle: str | None = None,
) -> Mechanism:
    """The mechanism with the settings of a run that were given as options, so that its model file tells what was run."""
    settings = mechanism.settings
    if turns is not None and duration is not None:
        raise ValueError("--turns and --duration exclude each other; give one of them")
    if turns is not None:
        if not (turns > 0.0 and math.isfinite(turns)):
            raise ValueError(f"--turns {turns:g}: allowed: a number above 0")
        settings = dataclasses.replace(settings, turns=turns, duration=None)
    if duration is not None:
        settings = dataclasses.replace(settings, turns=None, duration=positive("--duration", duration, "s"))
    if step is not None:
        settings = dataclasses.replace(settings, step="auto" if step == "auto" else positive("--step", step, "s"))
    if outputs is not None:
        settings = dataclasses.replace(settings, outputs=outputs)
    if companions is not None:
        settings = dataclasses.replace(settings, companions=beside(companions))
    if settle is not None:
        if (share := positive("--settle", settle, "1")) > 1.0:
            raise ValueError(f"--settle {settle}: allowed: a share above 0 and up to 1, such as 1%")
        settings = dataclasses.replace(settings, settle=share)
    return dataclasses.replace(mechanism, settings=settings)


def beside(text: str) -> int | Literal["auto"]:
    """The number of companions that ``--companions`` asks for."""
    from ..model.mechanism import MOST_COMPANIONS

    if text == "auto":
        return "auto"
    if text.isdecimal() and int(text) <= MOST_COMPANIONS:
        return int(text)
    raise ValueError(f"--companions {text}: allowed: a whole number from 0 to {MOST_COMPANIONS}, or auto")
