"""The command line. A command is loaded when it is called, and loads its packages when it runs."""

from __future__ import annotations

import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Annotated, Any

import typer
from typer.core import TyperGroup

from .. import __version__
from .registry import CommandTable, FastParsing, UsageError
from .signals import ENDING, Signals
from .terminal import BAD_INPUT, fail, print_fault, tell


@contextmanager
def warnings_as_sentences() -> Iterator[None]:
    """Print warnings about damaged files as sentences on standard error, each once."""
    with warnings.catch_warnings():
        shown = warnings.showwarning

        def show(message: Warning | str, category: type[Warning], *place: Any, **options: Any) -> None:
            if category.__name__ == "DamageWarning":  # its module would make every command start later
                tell("warning", str(message))
            else:
                shown(message, category, *place, **options)

        warnings.showwarning = show
        yield


class Group(FastParsing, TyperGroup):
    """The group of all commands; a signal ends a command with a sentence."""

    def __init__(self, **settings: Any) -> None:
        super().__init__(**settings)
        self.commands = CommandTable()

    def list_commands(self, ctx: Any) -> list[str]:
        """Return the names of the commands without loading any."""
        return list(self.commands)

    def invoke(self, ctx: Any) -> Any:
        """Run the command."""
        with Signals(), warnings_as_sentences():
            try:
                return super().invoke(ctx)
            except KeyboardInterrupt:
                fail(f"{ENDING.by}. {ENDING.saved}", ENDING.code, word="interrupted")
            except UsageError as error:
                print_fault(str(getattr(error, "message", error)), BAD_INPUT)
                raise


app = typer.Typer(
    name="vfife",
    cls=Group,
    help="Simulate planar mechanisms whose joints have clearance.",
    epilog=(
        "Start with: vfife new, vfife check MODEL.toml, vfife run MODEL.toml. Every command has its own"
        " --help."
    ),
    add_completion=False,
    no_args_is_help=True,
    pretty_exceptions_enable=False,
)


def show_version(value: bool) -> None:
    """Print the version and exit."""
    if value:
        typer.echo(f"vfife {__version__}")
        raise typer.Exit


@app.callback()
def root(
    version: Annotated[
        bool,
        typer.Option("--version", callback=show_version, is_eager=True, help="Print the version and exit."),
    ] = False,
) -> None:
    """Planar mechanisms whose joints have clearance."""
