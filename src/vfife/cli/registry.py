"""The commands by name, each loaded and made when it is asked for; arguments that need no checking are taken
as they are typed.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, MutableMapping
from importlib import import_module
from pathlib import Path
from typing import Any

import typer
from typer import BadParameter
from typer.core import TyperCommand
from typer.main import get_group

from .signals import ASKED
from .terminal import BAD_INPUT, failed

NUMBERS = {
    int: re.compile(r"[+-]?[0-9]{1,15}"),
    float: re.compile(r"[+-]?[0-9]{1,15}(\.[0-9]{1,30})?([eE][+-]?[0-9]{1,2})?"),
}
UsageError: type[Exception] = BadParameter.__bases__[0]  # newer versions of typer have a click of their own


class Plainly:
    """A command, or a group of them, whose plain arguments are taken as they are."""

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        """Reads the arguments."""
        ASKED.as_json, ASKED.printed = "--json" in args, False
        take_plainly(self.get_params(ctx))  # type: ignore[attr-defined]
        try:
            return super().parse_args(ctx, args)  # type: ignore[misc, no-any-return]
        except UsageError as error:
            failed(str(getattr(error, "message", error)), BAD_INPUT)
            raise


class Command(Plainly, TyperCommand):
    """A command."""


def take_plainly(parameters: Iterable[Any]) -> None:
    """Puts a :class:`Plain` reader before that of each parameter; older versions of typer have none and need
    none.
    """
    for parameter in parameters:
        if not isinstance(getattr(parameter, "get_runtime_param", Plain), Plain | type):
            parameter.get_runtime_param = Plain(parameter)


class Plain:
    """Stands for the reader of one parameter, and makes it where it is needed."""

    def __init__(self, parameter: Any) -> None:
        self.parameter, self.checking = parameter, parameter.get_runtime_param

    def __call__(self) -> Plain:
        return self

    def coerce(self, value: Any, param: Any, ctx: Any) -> Any:
        """The value of an argument as the command receives it. Raises what typer raises for one that does not
        fit.
        """
        kind = getattr(self.parameter.type_descriptor, "annotation", None)
        if value is None:
            return () if param.multiple or param.nargs == -1 else None
        if kind in (str, Path) and isinstance(value, str):
            return kind(value)
        if isinstance(kind, type) and type(value) is kind:
            return value
        if (
            kind in NUMBERS
            and isinstance(value, str)
            and NUMBERS[kind].fullmatch(value)
            and self.within(kind(value))
        ):
            return kind(value)
        return self.checking().coerce(value, param=param, ctx=ctx)

    def within(self, number: float) -> bool:
        """Whether a number is between the limits that the parameter says."""
        given = getattr(self.parameter.type_descriptor, "parameter_info", None)
        least, most = getattr(given, "min", None), getattr(given, "max", None)
        return (least is None or least <= number) and (most is None or number <= most)

    def __getattr__(self, name: str) -> Any:
        return getattr(self.checking(), name)


# Name, in the order of the help: the file of this folder that it is in, and what it is called there.
COMMANDS = {
    "new": ("new", "new"),
    "run": ("run", "run"),
    "resume": ("run", "resume"),
    "check": ("check", "check"),
    "modes": ("vibration", "modes"),
    "compare": ("compare", "compare"),
    "sensitivity": ("sensitivity", "sensitivity"),
    "fit": ("fit", "fit"),
    "info": ("result", "info"),
    "impacts": ("result", "impacts"),
    "optimise": ("optimise", "optimise"),
    "waterfall": ("waterfall", "waterfall"),
    "plot": ("result", "plot"),
    "spectrum": ("vibration", "spectrum"),
    "animate": ("result", "animate"),
    "report": ("result", "report"),
    "live": ("live", "live"),
    "export": ("result", "export"),
    "laws": ("laws", "laws"),
    "materials": ("laws", "materials"),
    "schema": ("new", "schema"),
    "paper": ("paper", "paper"),
    "verify": ("verify", "verify"),
    "wear": ("wear", "wear"),
    "map": ("map", "map_"),
    "study": ("study", "study"),
}


class Named(MutableMapping[str, Any]):
    """The commands as typer keeps them, each made when it is first looked up; their names are known without."""

    def __init__(self) -> None:
        self.made: dict[str, Any] = dict.fromkeys(COMMANDS)

    def __getitem__(self, name: str) -> Any:
        if self.made[name] is None:
            self.made[name] = made(name)
        return self.made[name]

    def __setitem__(self, name: str, command: Any) -> None:
        self.made[name] = command

    def __delitem__(self, name: str) -> None:
        del self.made[name]

    def __contains__(self, name: object) -> bool:
        return name in self.made

    def __iter__(self) -> Iterator[str]:
        return iter(self.made)

    def __len__(self) -> int:
        return len(self.made)


def made(name: str) -> Any:
    """One command, or group of commands, as typer makes it from its function."""
    file, called = COMMANDS[name]
    found = getattr(import_module(f".commands.{file}", __package__), called)
    alone = typer.Typer()
    if isinstance(found, typer.Typer):
        alone.add_typer(found, name=name)
    else:
        alone.command(name, cls=Command)(found)
    return get_group(alone).commands[name]
