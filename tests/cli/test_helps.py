"""Help texts are printed as they were written: brackets in them would be markup, and vanish."""

from __future__ import annotations

import typer
from rich.text import Text

from vfife.cli.app import app


def test_no_word_of_a_help_is_taken_for_markup() -> None:
    every, left = [], [typer.main.get_command(app)]
    while left:
        one = left.pop()
        left += getattr(one, "commands", {}).values()
        every += [
            (one.name, text)
            for text in (one.help, *(getattr(two, "help", None) for two in one.params))
            if text
        ]
    assert len(every) > 200
    assert [(name, text) for name, text in every if Text.from_markup(text).plain != text] == []
