"""The command line. Commands load what they need when they run, so that ``vfife --help`` is quick."""

from __future__ import annotations

from typing import Annotated, Any

import typer
from typer.core import TyperGroup

from .. import __version__
from .animate import animate
from .check import check
from .compare import compare
from .ended import export, info
from .fitted import fit
from .impacts import impacts
from .laws import laws
from .live import live
from .map import map_
from .materials import materials
from .modes import modes
from .new import new
from .paper import paper
from .plainly import Command, Plainly, UsageError
from .plot import plot
from .report import report
from .resume import resume
from .run import run
from .schema import schema
from .searched import optimise
from .sensitivity import sensitivity
from .signals import NOW, Signals
from .spectrum import spectrum
from .study import study
from .terminal import BAD_INPUT, fail, failed
from .verify import verify
from .waterfall import waterfall
from .wear import wear


class Group(Plainly, TyperGroup):
    """The commands; a signal ends each of them with a sentence."""

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


for command in (
    new,
    run,
    resume,
    check,
    modes,
    compare,
    sensitivity,
    fit,
    info,
    impacts,
    optimise,
    waterfall,
    plot,
    spectrum,
    animate,
    report,
    live,
    export,
    laws,
    materials,
    schema,
    paper,
    verify,
    wear,
):
    app.command(cls=Command)(command)
app.add_typer(map_, name="map")
app.add_typer(study, name="study")
