"""``vfife info NEW WORN``: the forces of two runs in one table."""

import json
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from vfife.report.run_file import OVERLAP, _knock_change, _row, change_text, side_by_side
from vfife.report.run_tables import force_text, knock_texts

CRANK = Path(__file__).resolve().parents[2] / "examples" / "slider_crank.toml"
LOOSE = CRANK.with_name("four_bar_case_b.toml")


def summary(value: float, low: float, high: float) -> dict[str, Any]:
    """A summary with one estimated measure."""
    ranges = {"A.force.max": {"low": low, "high": high}}
    return {"measures": {"A.force.max": value}, "ranges": ranges, "not_estimated": [], "about_zero": {}}


def test_two_runs_share_a_table(command: Callable) -> None:
    assert command("run", CRANK, "-o", "new", "--turns", 1, "--quiet").exit_code == 0
    faster = ("--set", 'driver.crank.speed="600 rpm"')
    assert command("run", CRANK, "-o", "fast", "--turns", 1, "--quiet", *faster).exit_code == 0
    data = json.loads(command("info", "new", "fast", "--json").stdout)["runs"]
    old, new = (data[name]["measures"]["pin.force.max"] for name in ("new", "fast"))
    assert old["low"] <= old["value"] <= old["high"]
    assert data["new"]["part"] == "last turn, the 1st"
    done = command("info", "new", "fast")
    assert done.exit_code == 0, done.stderr
    row = next(line.split() for line in done.stdout.splitlines() if line.startswith(" pin "))
    change = 100.0 * (new["value"] / old["value"] - 1.0)
    assert float(row[-2].replace(",", "")) == pytest.approx(change, rel=1e-2)
    assert "vfife plot new fast" in done.stdout
    assert re.search(
        r"Inputs that differ\s+input +new +fast\s+─+\s+crank\.speed +\S+ rpm +600 rpm\s", done.stdout
    )
    changes = json.loads(command("info", "new", "fast", "--json").stdout)["inputs"]
    assert [entry["input"] for entry in changes] == ["crank.speed"] and changes[0]["values"][1] == "600 rpm"
    assert "have the same inputs" in command("info", "new", "new").stdout
    three = command("info", "new", "fast", "new").stdout.splitlines()
    heads = next(line.split() for line in three if line.split()[:2] == ["joint", "new"])
    assert heads in (["joint", "new", "fast", "change"], ["joint", "new", "fast", "change", "new", "change"])
    alone = command("info", "new")
    assert alone.exit_code == 0 and "Run file" in alone.stdout


def test_a_change_from_the_first_run_stands_beside_each_of_three() -> None:
    runs = {
        "new": summary(100.0, 99.9, 100.1), "twice": summary(150.0, 149.9, 150.1),
        "same": summary(100.05, 99.8, 100.3),
    }  # fmt: skip
    rows = _row(runs, "A", "A.force.max", force_text)
    assert len(rows) == 6 and rows[0] == "A"
    assert rows[3].startswith("50") and rows[5] == OVERLAP
    absent = {**runs, "twice": summary(150.0, 149.9, 150.1) | {"measures": {}}}
    cells = _row(absent, "A", "A.force.max", force_text)
    assert cells[2:4] == ("-", "") and cells[5] == OVERLAP


def test_knocks_friction_and_drives_stand_beside_the_forces(command: Callable) -> None:
    """Each cell has the text of the single answer, and the change is that of the measures."""
    for name, speed in (("slow", "1000 rpm"), ("fast", "1500 rpm")):
        options = ("--turns", 1, "--quiet", "--set", f'driver.crank.speed="{speed}"')
        assert command("run", LOOSE, "-o", name, *options).exit_code == 0
    data = json.loads(command("info", "slow", "fast", "--json").stdout)["runs"]
    lines = command("info", "slow", "fast").stdout.splitlines()
    rows = {line[:30].split("  ")[0].strip(): line for line in lines if ", " in line[:30]}
    runs = [json.loads(command("info", name, "--json").stdout)["summary"] for name in data]
    for run, entry in zip(runs, data.values(), strict=True):
        assert knock_texts(run, "C")[0] in rows["C, hardest knock"] and entry["knocks"] == run["knocks"]
        assert force_text(run, "crank.torque.max", "N m") in rows["crank, largest torque"]
        for name in ("C.approach_speed.max", "crank.power.mean", "crank.torque.max"):
            assert entry["measures"][name]["value"] == run["measures"][name]
    assert "-" not in {text.strip() for text in rows["crank, mean power"].split("  ")}
    assert change_text(runs, "crank.torque.max") in rows["crank, largest torque"]


def test_a_knock_without_an_estimate_has_no_change() -> None:
    """Knocks of earlier turns than those of the measures are known by one run alone."""

    def knocking(speed: float, low: float, high: float, hardest: bool) -> dict[str, Any]:
        name = "A.approach_speed.max"
        entry = {"count": 3, "speed": speed, "hardest": hardest}
        run = {"measures": {name: speed, "A.impacts": 3}, "ranges": {name: {"low": low, "high": high}}}
        return run | {"joints": {"A": {}}, "not_estimated": [], "about_zero": {}, "knocks": {"A": entry}}

    runs = [knocking(0.1, 0.099, 0.101, True), knocking(0.2, 0.199, 0.201, True)]
    assert _knock_change(runs, "A") == "98 to 102 %"
    assert _knock_change([runs[0], knocking(0.2, 0.199, 0.201, False)], "A") == ""
    assert _knock_change([knocking(0.0, 0.0, 0.0, True), runs[1]], "A") == ""


def test_options_of_one_run_are_refused_with_several(command: Callable) -> None:
    assert command("run", CRANK, "-o", "new", "--turns", 1, "--quiet").exit_code == 0
    done = command("info", "new", "new", "--long")
    assert done.exit_code == 2 and "--long" in done.stderr and "Traceback" not in done.stderr
    done = command("info", "new", "absent")
    assert done.exit_code == 2 and "absent" in done.stderr


def test_a_change_that_may_be_an_error_of_the_steps_is_none() -> None:
    first = summary(100.0, 99.9, 100.1)
    assert change_text([first, summary(100.05, 99.8, 100.3)], "A.force.max") == OVERLAP
    assert change_text([first, summary(150.0, 149.9, 150.1)], "A.force.max").startswith("50")
    assert " to " in change_text([first, summary(150.0, 140.0, 160.0)], "A.force.max")
    assert (
        change_text([first, summary(0.0, 0.0, 0.0) | {"about_zero": {"A.force.max": 1}}], "A.force.max") == ""
    )


def test_a_static_analysis_is_named() -> None:
    with pytest.raises(ValueError, match="rig is a static analysis") as error:
        side_by_side({"rig": {"run": {"analysis": "static"}}})
    assert "itself" in str(error.value)
