"""Part of a run in a file: some series, some turns, and the last turn over the angle of the crank."""

from __future__ import annotations

import csv
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import scipy.io
import xarray
from typer.testing import CliRunner

import vfife
from vfife.cli.app import app
from vfife.job.cost import export_forecast
from vfife.results.selection import selection
from vfife.results.series import columns

OUTPUTS = 12
EVERY = slice(None)


@cache
def result() -> vfife.Result:
    """Three turns of 12 outputs, whose crank begins at 180 degrees; no test changes it."""
    machine = vfife.gallery.compressor()
    return vfife.simulate(machine, turns=3, outputs=OUTPUTS, companions=0, reference=False)


def read(path: Path) -> tuple[list[str], np.ndarray]:
    """Heads and numbers of a table."""
    with path.open(newline="") as stream:
        heads, *rows = csv.reader(stream)
    return heads, np.array(rows, dtype=float)


@pytest.mark.parametrize(
    ("turns", "outputs"),
    [
        (None, EVERY),
        (2, slice(12, 25)),
        ("2", slice(12, 25)),
        ("2..3", slice(12, 37)),
        ((1, 2), slice(0, 25)),
        ("last", slice(24, 37)),
    ],
)
def test_turns_are_outputs_with_both_ends(turns: object, outputs: slice, tmp_path: Path) -> None:
    result().export(tmp_path / "a.csv", channels="small-end.force", turns=turns)  # type: ignore[arg-type]
    heads, rows = read(tmp_path / "a.csv")
    assert heads == ["time [s]", "crank_angle [deg]", "small-end.force [N]"]
    force = result().data.joint_force.sel(joint="small-end").values
    assert np.array_equal(rows[:, 0], result().time[outputs]) and np.array_equal(rows[:, 2], force[outputs])


def test_the_last_turn_over_the_angle_has_each_angle_once(tmp_path: Path) -> None:
    result().export(tmp_path / "a.csv", channels=["*.force"], by_angle=True)
    heads, rows = read(tmp_path / "a.csv")
    assert heads[:2] == ["crank_angle [deg]", "time [s]"]
    assert heads[2:] == [f"{name}.force [N]" for name in ("main", "big-end", "small-end", "cylinder")]
    assert rows[:, 0] == pytest.approx(30.0 * np.arange(OUTPUTS), abs=1e-6)
    order = [24 + (k + 6 - 1) % OUTPUTS + 1 for k in range(OUTPUTS)]  # angle 0 is half a turn after the start
    assert np.array_equal(rows[:, 1], result().time[order])
    force = result().data.joint_force.sel(joint="cylinder").values
    assert np.array_equal(rows[:, 5], force[order])


def test_names_patterns_and_joints_select_series() -> None:
    def names(*channels: str) -> list[str]:
        return [column.name for column in selection(result(), channels).columns()][2:]

    assert names("main.force", "rod.angular_velocity") == names("main.force,rod.angular_velocity")
    assert names("main.force", "rod.angular_velocity") == ["main.force", "rod.angular_velocity"]
    assert names("rod.angular_velocity", "main.force") == ["rod.angular_velocity", "main.force"]
    every = [column.name for column in columns(result())]
    assert names("rod") == [name for name in every if name.startswith("rod.")] != []
    assert "cylinder.1.penetration" in names("cylinder")
    assert names("*.force_?") == [name for name in every if name.endswith((".force_x", ".force_y"))]
    assert names() == every[2:]


def test_other_formats_have_the_same_part(tmp_path: Path) -> None:
    part = {"channels": "small-end.force", "turns": 2}
    for ending in ("nc", "mat", "xlsx"):
        result().export(tmp_path / f"a.{ending}", **part)
    force = result().data.joint_force.sel(joint="small-end").values[12:25]
    with xarray.open_dataset(tmp_path / "a.nc", engine="h5netcdf") as data:
        assert list(data.data_vars) == ["joint_force"]
        assert np.array_equal(data.joint_force.sel(joint="small-end"), force)
    data = scipy.io.loadmat(tmp_path / "a.mat", simplify_cells=True)["result"]
    assert np.array_equal(data["small_end"]["force"], force) and set(data) == {
        "time",
        "crank_angle",
        "small_end",
    }


@pytest.mark.parametrize(
    ("part", "said"),
    [
        ({"channels": "small-end.forse"}, 'no series "small-end.forse".*did you mean "small-end.force"'),
        ({"turns": "0"}, "this result has turns 1 to 3: write one, as 3, some, as 1..3, or last"),
        ({"turns": "2..4"}, "turns 1 to 3"),
        ({"turns": "3..2"}, "turns 1 to 3"),
        ({"turns": "two"}, "turns 1 to 3"),
        ({"turns": (1, 2, 3)}, "turns 1 to 3"),
        ({"turns": "1..2", "by_angle": True}, "only the outputs of one turn have an order by angle"),
    ],
)
def test_what_there_is_not_is_a_sentence(part: dict, said: str, tmp_path: Path) -> None:
    with pytest.raises(vfife.VfifeError, match=said):
        result().export(tmp_path / "a.csv", **part)
    assert not (tmp_path / "a.csv").exists()


def test_a_run_without_a_crank_has_no_turns(tmp_path: Path) -> None:
    swinging = vfife.simulate(vfife.gallery.double_pendulum(), duration="10 ms", outputs=4, companions=0)
    with pytest.raises(vfife.VfifeError, match="no full turn of a crank"):
        swinging.export(tmp_path / "a.csv", turns="last")


def test_a_figure_has_no_part(tmp_path: Path) -> None:
    with pytest.raises(vfife.VfifeError, match="chosen for data, not for a figure"):
        result().export(tmp_path / "forces.png", turns=1)


def test_the_command_exports_a_part_and_says_what_is_large(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def command(*words: str) -> Any:
        return CliRunner().invoke(app, words)

    monkeypatch.chdir(tmp_path)
    result().save(tmp_path / "run.sqlite")
    done = command("export", ".", "a.csv", "--last", "--channels", "main.force,rod")
    heads, rows = read(tmp_path / "a.csv")
    assert done.exit_code == 0 and "forecast" not in done.stderr
    assert heads[:3] == ["crank_angle [deg]", "time [s]", "main.force [N]"] and len(rows) == OUTPUTS
    assert len(read(tmp_path / "a.csv")[0]) == len(selection(result(), ["main.force", "rod"]).columns())
    assert command("export", ".", "b.csv", "--turns", "2..3", "-o", "c.csv").exit_code == 2
    assert "leave one of them out" in command("export", ".", "b.csv", "--turns", "2", "--last").stderr
    monkeypatch.setattr("vfife.cli.commands.result.LONG_EXPORT", 0.0)
    large = command("export", ".", "b.csv")
    heads, rows = read(tmp_path / "b.csv")
    assert f"forecast: {len(rows)} rows of {len(heads)} columns: " in large.stderr
    advice = "--channels, --turns and --last write less"
    assert large.stderr.count(advice) == 1
    monkeypatch.setattr("vfife.cli.commands.result.LARGE_EXPORT", 1000)
    assert command("export", ".", "d.csv").stderr.count(advice) == 1, "once, before or after"
    monkeypatch.setattr("vfife.cli.commands.result.LONG_EXPORT", 1e9)
    assert command("export", ".", "e.csv").stderr.count(advice) == 1
    assert advice not in command("export", ".", "f.csv", "--last").stderr


@pytest.mark.parametrize("ending", [".csv", ".xlsx", ".mat", ".nc"])
def test_the_forecast_of_an_export_has_the_order_of_its_size(ending: str, tmp_path: Path) -> None:
    path = tmp_path / f"a{ending}"
    machine = vfife.gallery.compressor()
    long = vfife.simulate(machine, turns=2, outputs=720, step="2 us", companions=0, reference=False)
    part = selection(long)
    long.export(path)
    forecast = export_forecast(ending, part.count, len(part.columns(fine=ending in (".mat", ".nc"))))
    assert 0.4 < forecast.disk / path.stat().st_size < 2.5
