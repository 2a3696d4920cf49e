"""``vfife help``: search commands, options, laws, measures, keys and pages by a word."""

from __future__ import annotations

import difflib
from collections.abc import Sequence
from typing import TYPE_CHECKING

from ..options import JsonOptions, argument
from ..registry import PURPOSES
from ..terminal import answer, command, fail
from ..topics import search, tokens, vocabulary

if TYPE_CHECKING:
    from ...report.document import Document, Table
    from ..topics import Topic

KINDS = ("command", "option", "measure", "key of a model", "law", "page")  # in the order of an answer
MOST = 6  # topics of each kind in an answer


class HelpOptions(JsonOptions):
    """Options of ``vfife help``."""

    words: list[str] | None = argument("What to search for; without it, all purposes.", "[WORD]...", None)


def help_(options: HelpOptions) -> None:
    """Search commands, options, laws, measures, keys of a model file and documentation by a word."""
    from ...report.document import Document

    text = " ".join(options.words or ())
    if not text:
        data = {
            purpose: {name: one.aim for name, one in group.items()} for purpose, group in PURPOSES.items()
        }
        answer(Document([purposes()], data=data), options.as_json)
        return
    if hits := search(text):
        answer(document(text, hits), options.as_json)
        return
    words = vocabulary()
    near = [one for token in tokens(text) for one in difflib.get_close_matches(token, words, 3, 0.6)]
    if not options.as_json:
        answer(Document([purposes()]))
    advice = f"did you mean {' or '.join(near)}?" if near else "the table lists all purposes."
    fail(f"nothing is found by {text!r}; {advice}")


def purposes() -> Table:
    """Return the purposes of all commands in the order of work."""
    from ...report.document import Table

    rows = [
        (purpose if k == 0 else "", f"{command()} {name}", entry.aim)
        for purpose, group in PURPOSES.items()
        for k, (name, entry) in enumerate(group.items())
    ]
    return Table(("purpose", "command", "what for"), rows, names=(0, 1))


def document(text: str, hits: Sequence[Topic]) -> Document:
    """Return a document of the topics that a search found, in a table of each kind."""
    from ...report.document import Document, Paragraph, Table

    tables = []
    for kind in KINDS:
        entries = [topic for topic in hits if topic.kind == kind]
        if not entries:
            continue
        rows = [
            (f"{command()} {one.name}" if kind == "command" else one.name, one.text) for one in entries[:MOST]
        ]
        heading = f"{kind}, {MOST} of {len(entries)}" if len(entries) > MOST else kind
        tables.append(Table((heading, "what it is"), rows, names=(0,)))
    first = next((one.name for one in hits if one.kind == "command"), "")
    hint = [Paragraph(f"Arguments and options: {command()} {first} --help")] if first else []
    data = [{"kind": one.kind, "name": one.name, "text": one.text} for one in hits]
    return Document([*tables, *hint], f"vfife help {text}", data)
