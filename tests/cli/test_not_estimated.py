"""info and check tell which errors are, or will be, estimated."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import pytest

from vfife import gallery
from vfife.modelfile import dump

WORDS = "not estimated"


def line(said: str, begin: str) -> str:
    return next(line for line in said.splitlines() if begin in line)


def test_info_and_check(command: Callable, tmp_path: Path) -> None:
    model = tmp_path / "yoke.toml"
    model.write_text(dump(gallery.scotch_yoke()))
    command("run", model, "-o", tmp_path / "run", "--quiet")
    said = command("info", tmp_path / "run", "--measures").stdout
    assert " to " in line(said, "crank.torque.max = ") and WORDS not in said
    command("run", model, "-o", tmp_path / "alone", "--companions", "0", "--quiet")
    assert (
        line(command("info", tmp_path / "alone", "--measures").stdout, "crank.torque.max = ")
        .rstrip()
        .endswith(f"({WORDS})")
    )
    assert "half and a quarter of the step with it" in " ".join(command("check", model).stdout.split())
    found = [
        json.loads(command("check", model, "--json", *more).stdout)
        for more in ([], ["--set", "run.companions=0"])
    ]
    assert [one["repeated"] for one in found] == [True, False]
    assert found[0]["estimate"]["seconds"] == pytest.approx(7.0 * found[1]["estimate"]["seconds"])


def test_check_of_a_static_analysis(command: Callable, tmp_path: Path) -> None:
    model = tmp_path / "frame.toml"
    model.write_text(dump(gallery.lee_frame()))
    assert "with the repetitions on other meshes" in " ".join(command("check", model).stdout.split())
    found = [
        json.loads(command("check", model, "--json", *more).stdout)
        for more in ([], ["--set", "run.companions=0"])
    ]
    assert [one["repeated"] for one in found] == [True, False] and found[0]["estimate"][
        "seconds"
    ] > 3.0 * found[1]["estimate"]["seconds"]
    assert "errors of the mesh are not estimated" in " ".join(
        command("check", model, "--set", "run.companions=0").stdout.split()
    )
