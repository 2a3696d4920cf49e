"""The commands by name. Only the one that is asked for is loaded and made; a help, which tells of all, makes all."""

from __future__ import annotations

from collections.abc import Iterator, MutableMapping
from importlib import import_module
from typing import Any

import typer
from typer.main import get_group

from .plainly import Command

# Name, in the order of the help: the file of this folder that it is in, and what it is called there.
COMMANDS = {
    "new": ("new", "new"),
    "run": ("run", "run"),
    "resume": ("run", "resume"),
    "check": ("check", "check"),
    "modes": ("modes", "modes"),
    "compare": ("compare", "compare"),
    "sensitivity": ("sensitivity", "sensitivity"),
    "fit": ("fitted", "fit"),
    "info": ("ended", "info"),
    "impacts": ("impacts", "impacts"),
    "optimise": ("searched", "optimise"),
    "waterfall": ("waterfall", "waterfall"),
    "plot": ("plot", "plot"),
    "spectrum": ("spectrum", "spectrum"),
    "animate": ("animate", "animate"),
    "report": ("report", "report"),
    "live": ("live", "live"),
    "export": ("ended", "export"),
    "laws": ("laws", "laws"),
    "materials": ("materials", "materials"),
    "schema": ("schema", "schema"),
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
    found = getattr(import_module(f".{file}", __package__), called)
    alone = typer.Typer()
    if isinstance(found, typer.Typer):
        alone.add_typer(found, name=name)
    else:
        alone.command(name, cls=Command)(found)
    return get_group(alone).commands[name]
