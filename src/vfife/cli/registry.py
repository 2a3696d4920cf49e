"""Commands by name, loaded when called; arguments that need no conversion are passed as typed."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, MutableMapping
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from typing import Any

import typer
from typer import BadParameter
from typer.core import TyperCommand, TyperGroup
from typer.main import get_group

from .options import Options, typer_function
from .signals import JSON
from .terminal import BAD_INPUT, print_fault

NUMBERS = {
    int: re.compile(r"[+-]?[0-9]{1,15}"),
    float: re.compile(r"[+-]?[0-9]{1,15}(\.[0-9]{1,30})?([eE][+-]?[0-9]{1,2})?"),
}
UsageError: type[Exception] = BadParameter.__bases__[0]  # newer versions of typer have a click of their own

# Commands of one run, and what to do with several.
ONE_RUN = {
    "report": "; a report is of one run. vfife plot RUN RUN overlays runs, vfife info RUN RUN compares them",
    "animate": "; a film is of one run. vfife plot RUN RUN overlays runs",
}
# Options that replace a file in other commands.
LIMITS = {
    "wear": (
        "'--force' requires",
        " It is the joint force that ends the life, as in --force '2 kN'. A wear file is continued, not"
        " replaced: name another one with -o.",
    )
}


class FastParsing:
    """Base of commands and groups that pass plain arguments as typed."""

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        """Parse the arguments."""
        JSON.wanted, JSON.printed = "--json" in args, False
        defer_readers(self.get_params(ctx))  # type: ignore[attr-defined]
        try:
            return super().parse_args(ctx, args)  # type: ignore[misc, no-any-return]
        except UsageError as error:
            parameter: Any = getattr(error, "param", None)
            if type(error).__name__ == "MissingParameter" and hasattr(error, "message"):
                error.message = getattr(parameter, "help", "") or ""  # follows the name of what is missing
            options = {name for option in self.get_params(ctx) for name in option.opts}  # type: ignore[attr-defined]
            if "unexpected extra argument" in str(getattr(error, "message", "")):
                remedy = "; name a series with --of" if "--of" in options else ONE_RUN.get(ctx.info_name, "")
                error.message += remedy  # type: ignore[attr-defined]
            option, remedy = LIMITS.get(str(ctx.info_name), ("", ""))
            if option and option in str(getattr(error, "message", "")):
                error.message += remedy  # type: ignore[attr-defined]
            print_fault(str(getattr(error, "format_message", error.__str__)()), BAD_INPUT)
            raise


class Command(FastParsing, TyperCommand):
    """A command."""


class DefaultGroup(FastParsing, TyperGroup):
    """A group of commands whose ``default`` may be left out: it is used for a word that is no command but may
    be a file.
    """

    default: str

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        """Insert the default command before a file; a word that cannot be a file is an unknown command."""
        word = args[0] if args else "--help"
        is_file = word.startswith("-") or Path(word).suffix or Path(word).exists()
        if word not in self.commands and word != "--help" and is_file:
            args = [self.default, *args]
        return super().parse_args(ctx, args)


def defer_readers(parameters: Iterable[Any]) -> None:
    """Put a :class:`DeferredReader` before the reader of each parameter; older versions of typer have none
    and need none.
    """
    for parameter in parameters:
        if not isinstance(getattr(parameter, "get_runtime_param", DeferredReader), DeferredReader | type):
            parameter.get_runtime_param = DeferredReader(parameter)


class DeferredReader:
    """Reads plain values of one parameter, and makes typer's own reader, which is slow to load, only for
    others.
    """

    def __init__(self, parameter: Any) -> None:
        self.parameter, self.reader = parameter, parameter.get_runtime_param

    def __call__(self) -> DeferredReader:
        """Return the reader itself, as the call of a class returns a reader."""
        return self

    def coerce(self, value: Any, param: Any, ctx: Any) -> Any:
        """Return the value of an argument as the command receives it. Raises what typer raises for an invalid
        one.
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
            and self.allows(kind(value))
        ):
            return kind(value)
        return self.reader().coerce(value, param=param, ctx=ctx)

    def allows(self, number: float) -> bool:
        """Return whether a number is within the limits of the parameter."""
        limits = getattr(self.parameter.type_descriptor, "parameter_info", None)
        smallest, largest = getattr(limits, "min", None), getattr(limits, "max", None)
        return (smallest is None or smallest <= number) and (largest is None or number <= largest)

    def __getattr__(self, name: str) -> Any:
        return getattr(self.reader(), name)


@dataclass(frozen=True)
class Entry:
    """A command in the table: its options in ``arguments``, or its group there, what it is for, and words
    that users search for (``vfife help WORD``).
    """

    options: str
    aim: str
    words: str = ""


# Purposes in the order of work, and the commands of each: the groups of the help and of the documentation.
PURPOSES: dict[str, dict[str, Entry]] = {
    "Write a model": {
        "new": Entry(
            "models.NewOptions", "a model file to start from", "template example gallery start mechanism"
        ),
        "check": Entry(
            "models.CheckOptions",
            "what would run",
            "degrees freedom mobility valid units cost forecast ideal",
        ),
        "schema": Entry("models.SchemaOptions", "completion in an editor", "keys autocomplete vscode"),
        "live": Entry(
            "models.LiveOptions",
            "see and edit the mechanism in the browser",
            "page mouse draw web interactive",
        ),
        "help": Entry(
            "models.HelpOptions", "search commands, options, laws, measures and pages by a word", "find"
        ),
    },
    "Run it": {
        "run": Entry(
            "runs.NewRunOptions",
            "a simulation",
            "simulate solve force torque noise knock blow whirl loss clearance backlash play",
        ),
        "resume": Entry("runs.ResumeOptions", "an interrupted run", "continue restart killed"),
        "compare": Entry("runs.CompareOptions", "several laws", "overlay difference"),
    },
    "Read the result": {
        "info": Entry(
            "runs.InfoOptions", "the answer again", "read result show summary stroke dead centre deviation"
        ),
        "impacts": Entry("runs.ImpactsOptions", "each knock", "noise impact rattle collision rebound hit"),
        "spectrum": Entry(
            "runs.SpectrumOptions", "frequencies and orders", "FFT noise vibration acoustic envelope hertz"
        ),
    },
    "Show it": {
        "plot": Entry("runs.PlotOptions", "figures", "picture image curve png svg two runs overlay compare"),
        "animate": Entry("runs.AnimateOptions", "a film", "film animation video movie mp4 gif"),
        "report": Entry("runs.ReportOptions", "a printable page", "PDF HTML document print manager"),
        "export": Entry(
            "runs.ExportOptions", "data files", "CSV excel spreadsheet matlab netcdf table pandas"
        ),
    },
    "Decide on clearances and fits": {
        "design": Entry(
            "studies.DesignOptions",
            "which clearance matters, which ISO fits keep a limit, how long joints last",
            "clearance tolerance ISO 286 fit life wear limit answer decide machine deviation miss target",
        ),
        "sensitivity": Entry(
            "studies.SensitivityOptions", "which parameter matters", "derivative gradient influence effect"
        ),
        "study": Entry(
            "studies.study",
            "many parameter values, tolerances and fits",
            "sweep parameter speed sobol morris monte carlo scatter DOE batch",
        ),
        "optimise": Entry(
            "studies.OptimiseOptions", "the best values", "optimize minimum pareto best search"
        ),
    },
    "Predict wear": {
        "wear": Entry(
            "analyses.WearOptions", "over millions of turns", "life lifetime archard durability worn abrasion"
        )
    },
    "Find vibrations": {
        "modes": Entry(
            "runs.ModesOptions", "natural frequencies", "frequency eigenfrequency resonance vibration"
        ),
        "waterfall": Entry(
            "analyses.WaterfallOptions",
            "spectra over speed",
            "speed sweep campbell order noise frequency FFT",
        ),
    },
    "Understand the motion": {
        "map": Entry(
            "analyses.map_",
            "bifurcation diagram, Poincaré section, basins",
            "chaos chaotic periodic lyapunov nonlinear strange attractor sweep speed",
        )
    },
    "Match a measurement": {
        "fit": Entry(
            "analyses.FitOptions",
            "parameters from measured curves",
            "identify identification calibrate measurement estimate data",
        )
    },
    "Choose laws and materials": {
        "laws": Entry(
            "models.LawsOptions",
            "contact and friction laws",
            "hertz friction restitution damping lubrication",
        ),
        "materials": Entry(
            "models.MaterialsOptions", "materials by name", "steel bronze modulus hardness density"
        ),
    },
    "Check vfife itself": {
        "verify": Entry(
            "models.VerifyOptions",
            "against published and exact answers, and against measurements",
            "validation verification benchmark trust accuracy experiment",
        ),
        "paper": Entry("models.PaperOptions", "the source publication recomputed", "publication figures"),
    },
}
COMMANDS = {name: entry for group in PURPOSES.values() for name, entry in group.items()}


class CommandTable(MutableMapping[str, Any]):
    """Commands by name, made when first looked up; their names are known without that."""

    def __init__(self) -> None:
        self.commands: dict[str, Any] = dict.fromkeys(COMMANDS)

    def __getitem__(self, name: str) -> Any:
        if self.commands[name] is None:
            self.commands[name] = load_command(name)
        return self.commands[name]

    def __setitem__(self, name: str, command: Any) -> None:
        self.commands[name] = command

    def __delitem__(self, name: str) -> None:
        del self.commands[name]

    def __contains__(self, name: object) -> bool:
        return name in self.commands

    def __iter__(self) -> Iterator[str]:
        return iter(self.commands)

    def __len__(self) -> int:
        return len(self.commands)


def load_command(name: str) -> Any:
    """Return a command, or group of commands, as typer makes it from its function."""
    entry = COMMANDS[name]
    module, _, attribute = entry.options.partition(".")
    options = getattr(import_module(f".arguments.{module}", __package__), attribute)
    purpose = next(purpose for purpose, group in PURPOSES.items() if name in group)
    app = typer.Typer()
    if isinstance(options, typer.Typer):
        app.add_typer(options, name=name, rich_help_panel=purpose)
    else:
        add_command(app, options, name, rich_help_panel=purpose)
    return get_group(app).commands[name]


def add_command(group: typer.Typer, options: type[Options], name: str | None = None, **settings: Any) -> None:
    """Add the command of these options to a group; ``settings`` as in ``typer.Typer.command``."""
    group.command(name, cls=Command, **settings)(typer_function(options))
