"""Arguments and options that several commands share, and what becomes of them."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

if TYPE_CHECKING:
    from ..fields import Value
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


def option(name: str, held: Value, text: Any) -> Any:
    """The value of an option by a field, a bare number being in SI units. Raises ValueError where the field does not take it."""
    from ..errors import Fault

    try:
        return held.take(text, written=True)
    except Fault as fault:
        raise ValueError(str(Fault(f"{name} {text}", fault.what, "", fault.limit, fault.remedy))) from None


def positive(name: str, text: str, unit: str) -> float:
    """A quantity above zero given as an option."""
    from ..fields import Measure

    found: float = option(name, Measure(unit, above=0.0), text)
    return found


def with_options(mechanism: Mechanism, **options: Any) -> Mechanism:
    """The mechanism with the settings of a run that were given as options, so that its model file tells what was run; None: not given."""
    from ..solvers.arguments import SHARED, RunArguments

    given = {name: text for name, text in options.items() if text is not None}
    if {"turns", "duration"} <= given.keys():
        raise ValueError("--turns and --duration exclude each other; give one of them")
    if str(given.get("companions", "")).isdecimal():
        given["companions"] = int(given["companions"])
    return RunArguments(**{name: option(f"--{name}", SHARED[name], text) for name, text in given.items()}).in_settings(mechanism)
