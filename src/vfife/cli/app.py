"""The command line. A command is loaded when it is named, and loads what it needs when it runs."""

from __future__ import annotations

from typing import Annotated, Any

import typer
from typer.core import TyperGroup

from .. import __version__
from .commands import Named
from .plainly import Plainly, UsageError
from .signals import NOW, Signals
from .terminal import BAD_INPUT, fail, failed


class Group(Plainly, TyperGroup):
    """The commands; a signal ends each of them with a sentence."""

    def __init__(self, **given: Any) -> None:
        super().__init__(**given)
        self.commands = Named()

    def list_commands(self, ctx: Any) -> list[str]:
        """Their names, for which none is made."""
        return list(self.commands)

    def invoke(self, ctx: Any) -> Any:
        """Runs the command that is named."""
        with Signals():
            try:
                return super().invoke(ctx)
            except KeyboardInterrupt:
                fail(f"{NOW.by}. {NOW.saved}", NOW.code, word="interrupted")
            except UsageError as error:
                failed(str(getattr(error, "message", error)), BAD_INPUT)
                raise


app = typer.Typer(
    name="vfife",
    cls=Group,
    help="Planar mechanisms whose pins have play.",
    epilog="Start with: vfife new, vfife check MODEL.toml, vfife run MODEL.toml. Every command has its own --help.",
    add_completion=False,
    no_args_is_help=True,
    pretty_exceptions_enable=False,
)


def show_version(wanted: bool) -> None:
    """Prints the version and ends."""
    if wanted:
        typer.echo(f"vfife {__version__}")
        raise typer.Exit


@app.callback()
def root(
    version: Annotated[bool, typer.Option("--version", callback=show_version, is_eager=True, help="Print the version and end.")] = False,
) -> None:
    """Planar mechanisms whose pins have play."""
