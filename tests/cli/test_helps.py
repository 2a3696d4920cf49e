"""Help texts are printed as they were written: brackets in them would be markup, and vanish."""

from __future__ import annotations

import pytest
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


@pytest.mark.parametrize(
    ("words", "expected"),
    [
        (["map", "MODEL.toml"], "as in joint.pin.clearance=0.1..1mm"),
        (["waterfall", "MODEL.toml"], "as in driver.crank.speed=500..3000rpm"),
        (["report"], "Run folder, or the run file in it."),
    ],
)
def test_what_is_missing_is_named_with_its_meaning(command, words, expected) -> None:
    done = command(*words)
    assert done.exit_code == 2
    assert expected in " ".join(done.stderr.replace("│", " ").split()), done.stderr
