"""The page of commands names every command by its purpose and describes all of them; no page invents one. The
lists that a page holds are those of the package.
"""

import importlib
import re
import runpy
from pathlib import Path

import pytest
from typer.main import get_command

from vfife.cli.app import app

ROOT = Path(__file__).resolve().parents[2]
COMMANDS = get_command(app).commands
PAGES = ("README.md", "docs/index.md", "docs/commands.md")


@pytest.fixture
def reference(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.syspath_prepend(str(ROOT / "docs" / "extensions"))
    return importlib.import_module("command_reference")


def test_every_command_has_a_purpose(reference):
    """The page takes its table of purposes from the groups of the help."""
    table = reference.purposes()
    assert [name for name in COMMANDS if len(re.findall(rf"`vfife {name}`", table)) != 1] == []


def test_no_command_is_named_that_there_is_not(reference):
    text = "".join((ROOT / page).read_text(encoding="utf-8") for page in PAGES) + reference.purposes()
    code = re.findall(r"```(?:sh|console)\n.*?```|`[^`\n]+`", text, re.S)
    named = set(re.findall(r"\bvfife ([a-z]+)", "\n".join(code)))
    assert named <= set(COMMANDS) and len(named) > 20


def test_every_command_and_option_is_described(reference):
    page = reference.page()
    assert "### vfife study tolerance" in page
    for words, command in reference.commands().items():
        text = page.partition(f"# {words}\n")[2].partition("\n## ")[0]
        assert text, words
        if not hasattr(command, "commands"):
            options = [one for parameter in command.params for one in getattr(parameter, "opts", [])]
            missing = [one for one in options if one.startswith("--") and one != "--help" and one not in text]
            assert missing == [], words


@pytest.mark.parametrize("name", ["commands.md", "model-reference.md"])
def test_the_lists_in_a_checkout_are_those_of_the_package(name, reference, monkeypatch):
    """A reader of the repository sees the list itself, and the pages are built from it."""
    monkeypatch.setattr("sys.argv", ["texts.py"])
    pages = runpy.run_path(str(ROOT / ".ci" / "texts.py"))["lists"]()
    text = (ROOT / "docs" / name).read_text(encoding="utf-8")
    assert text == pages[ROOT / "docs" / name], "run: python .ci/texts.py lists"
    assert not re.search(r"@[A-Z]+@", text) and text.count("\n| `") > 100
    framed = importlib.import_module("tables").framed(text)
    assert (
        framed.count("::::{container} keys\n| ") == len(re.findall(r"^\| (?:key|argument)", text, re.M)) > 20
    )
    assert framed.replace("::::{container} keys\n", "").replace("::::\n", "") == text
