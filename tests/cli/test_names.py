"""Names are text everywhere: on the console, in figures, in files, whatever signs they are made of."""

import json
from collections.abc import Callable
from pathlib import Path

import pytest

from cli.test_hostile import CRANK

NAMES = {"joint.P": "[/]", "joint.W": r"$\frac{1$", "joint.O": "[bold]x", "body.rod": "<b>&%s{0}", "body.block": "$_$^"}


def renamed() -> str:
    text = CRANK.replace('name = "slider-crank"', r"name = '[/] $\frac{1$ <b> 100 %'")
    for table, name in NAMES.items():
        kind, _, old = table.partition(".")
        text = text.replace(f"[{table}]", f"[{kind}.'{name}']")
        if kind == "body":
            text = text.replace(f'"{old}.', f'"{name}.')
    return text


@pytest.mark.parametrize("clear", [False, True])
def test_names_are_text(command: Callable, clear: bool) -> None:
    text = renamed()
    if clear:
        text = text.replace("[joint.'[/]']\n", "[joint.'[/]']\nkind = 'clearance'\nclearance = 1e-4\nbearing_radius = 0.01\n")
    Path("model.toml").write_text(text)
    for words in (["check", "model.toml"], ["run", "model.toml", "-o", "out", "--figures"], ["info", "out"], ["export", "out", "out.nc"]):
        done = command(*words)
        assert done.exit_code == 0, (words, done.stderr, done.exception)
        for name in ("[/]", r"$\frac{1$"):
            assert name in done.stdout or words[0] == "export"
    assert len(list(Path("out/figures").glob("*.png"))) >= 2
    assert r"$\frac{1$.force.max" in json.loads(Path("out/summary.json").read_text())["measures"]
