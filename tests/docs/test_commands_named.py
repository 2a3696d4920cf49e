"""README and the first page name every command, so that who has only them finds it."""

import re
from pathlib import Path

import pytest
from typer.main import get_command

from vfife.cli.app import app

ROOT = Path(__file__).resolve().parents[2]
COMMANDS = get_command(app).commands


@pytest.mark.parametrize("page", ["README.md", "docs/index.md"])
def test_every_command_is_named(page):
    text = (ROOT / page).read_text(encoding="utf-8")
    assert [name for name in COMMANDS if not re.search(rf"vfife {name}\b", text)] == []


def test_no_command_is_named_that_there_is_not():
    text = "".join((ROOT / page).read_text(encoding="utf-8") for page in ("README.md", "docs/index.md"))
    named = set(re.findall(r"(?:^|`)vfife ([a-z]+)", text, re.MULTILINE))
    assert named <= set(COMMANDS) and len(named) > 20
