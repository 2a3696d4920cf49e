"""The list of all commands, made from the command line itself: purpose, arguments, options and defaults.
``make texts`` writes it into the page.
"""

from __future__ import annotations

import re
from typing import Any

from tables import cell, framed, grid

PAGE = "commands"
OPTION = re.compile(r"(?<![\w`-])(--[a-z][a-z-]*)")  # in a sentence, where dashes would become typographic
HIDDEN = ("help",)  # options that every command has


def commands() -> dict[str, Any]:
    """Return all commands by the words that call them, in the order of the help; groups come first."""
    from typer.main import get_command

    from vfife.cli.app import app

    found: dict[str, Any] = {}

    def collect(words: str, group: Any) -> None:
        for name, command in dict(group.commands).items():
            found[f"{words} {name}"] = command
            if hasattr(command, "commands"):
                collect(f"{words} {name}", command)

    collect("vfife", get_command(app))
    return found


def section(words: str, command: Any, level: int) -> str:
    """Return the section of one command, in Markdown."""
    parameters = [one for one in command.params if one.name not in HIDDEN]
    rows = [
        (name(one), cell(plain(getattr(one, "help", None) or "")), default(one))
        for one in parameters
        if name(one)
    ]
    parts = [f"{'#' * level} {words}", plain(command.help or "")]
    if rows and not hasattr(command, "commands"):
        parts.append(grid(("argument or option", "meaning", "default"), rows))
    return "\n\n".join(part for part in parts if part)


def name(parameter: Any) -> str:
    """Return how an argument or option is typed."""
    options = getattr(parameter, "opts", [])
    shown = parameter.metavar or ("" if getattr(parameter, "is_flag", False) else str(parameter.name).upper())
    if not options or not options[0].startswith("-"):
        return f"`{parameter.metavar or str(parameter.name).upper()}`"
    value = f" {shown}" if shown and not getattr(parameter, "is_flag", False) else ""
    words = [*sorted(options, key=len, reverse=True), *getattr(parameter, "secondary_opts", [])]
    return f"`{', '.join(words)}{value}`"


def default(parameter: Any) -> str:
    """Return the default of an option, where it has one worth showing."""
    value = parameter.default
    if getattr(parameter, "secondary_opts", []) and value is True:
        return f"`{parameter.opts[0]}`"
    if getattr(parameter, "required", False):
        return "required"
    if callable(value) or value in (None, False, (), [], "") or str(value).startswith("Sentinel"):
        return ""
    return f"`{value}`"


def plain(text: str) -> str:
    """Return a text of the help as one paragraph a line."""
    paragraphs = re.split(r"\n\s*\n", text.replace("\b", "").strip())
    return "\n\n".join(OPTION.sub(r"`\1`", " ".join(one.split())) for one in paragraphs)


def purposes() -> str:
    """Return the table of purposes with the commands of each."""
    from vfife.cli import registry

    rows = [
        f"| **{purpose}** | {', '.join(f'`vfife {name}` {entry.aim}' for name, entry in group.items())} |"
        for purpose, group in registry.PURPOSES.items()
    ]
    return "\n".join(["| purpose | commands |", "|---|---|", *rows])


def page() -> str:
    """Return the sections of all commands."""
    return "\n\n".join(
        section(words, command, 2 + (len(words.split()) > 2)) for words, command in commands().items()
    )


def fill(app: Any, docname: str, source: list[str]) -> None:
    """Put the tables of the page into frames before it is read."""
    if docname == PAGE:
        source[0] = framed(source[0])


def setup(app: Any) -> dict[str, bool]:
    app.connect("source-read", fill)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
