"""`vfife info`, `plot` and `export` on a run that came to its end."""

import json
import sqlite3
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import xarray

import vfife


@pytest.mark.parametrize("form", ["folder", "file"])
def test_info(command: Callable, case_c_run: Path, form: str) -> None:
    done = command("info", case_c_run if form == "folder" else case_c_run / "run.sqlite")
    assert done.exit_code == 0, done.stderr
    for word in ("four-bar, case c", "complete", "with clearance", f"vfife {vfife.__version__}"):
        assert word in done.stdout
    assert "C.force.max" not in done.stdout and "Measure" not in done.stdout
    done = command("info", case_c_run, "--measures")
    assert "C.force.max = " in done.stdout and "lankarani-nikravesh" in done.stdout


def test_info_as_an_object(command: Callable, case_c_run: Path) -> None:
    said = json.loads(command("info", case_c_run, "--json").stdout)
    assert said["steps"] == said["steps_planned"] == vfife.Result.load(case_c_run).record.steps[-1]
    assert said["outputs"] == 721
    assert said["summary"]["measures"]["C.force.max"] > 0.0


@pytest.mark.slow("draws a run in several formats")
def test_plot(command: Callable, case_c_run: Path) -> None:
    done = command("plot", case_c_run, "-o", "drawn")
    assert done.exit_code == 0, done.stderr
    named = [Path(line) for line in done.stdout.split("\n") if line]
    assert len(named) >= 3
    assert all(path.parent.name == "drawn" and path.stat().st_size > 5000 for path in named)


def test_export(command: Callable, case_c_run: Path) -> None:
    assert command("export", case_c_run, "out.nc").exit_code == 0
    with xarray.open_dataset("out.nc", engine="h5netcdf") as data:
        assert data.sizes["time"] == 721
        assert all("units" in variable.attrs for variable in data.data_vars.values())
    before = Path("out.nc").stat().st_mtime_ns
    again = command("export", case_c_run, "out.nc")
    assert again.exit_code == 2
    assert "--force" in again.stderr
    assert Path("out.nc").stat().st_mtime_ns == before
    assert command("export", case_c_run, "out.nc", "--force").exit_code == 0
    assert Path("out.nc").stat().st_mtime_ns > before


@pytest.mark.system("loads libraries of other formats")
def test_export_in_other_formats(command: Callable, case_c_run: Path) -> None:
    for target, more in (
        ("out.csv", ()),
        ("out.mat", ()),
        ("forces.svg", ()),
        ("mine.png", ("--figure", "orbits")),
        ("out.xlsx", ()),
    ):
        done = command("export", case_c_run, target, *more)
        assert done.exit_code == 0 and target in done.stdout and Path(target).stat().st_size > 5000
    for target, said in (("out.docx", ".csv, .xlsx, .nc"), ("force.svg", 'mean "forces"')):
        done = command("export", case_c_run, target)
        assert done.exit_code == 2 and said in done.stderr and not Path(target).exists()


def test_export_to_nowhere(command: Callable, case_c_run: Path, tmp_path: Path) -> None:
    for target in (tmp_path, tmp_path / "no such folder" / "out.nc"):
        assert command("export", case_c_run, target).exit_code == 2
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("statement", ["data = zeroblob(40)", "seal = zeroblob(16)", "steps = zeroblob(8)"])
def test_lost_first_blocks_lose_themselves_and_no_more(
    command: Callable, pendulum: Path, statement: str
) -> None:
    """The first output, from which energies count, and what the run says of itself are there a second time:
    the rest is as it was.
    """
    assert command("run", pendulum, "-o", "out", "--quiet").exit_code == 0
    whole = vfife.load_result("out")
    with sqlite3.connect("out/run.sqlite") as connection:
        connection.execute(f"UPDATE history SET {statement} WHERE chunk < 2")
        connection.execute("UPDATE meta SET seal = x'00' WHERE key IN ('model', 'kept', 'choice')")
    told, exported = command("info", "out"), command("export", "out", "out.nc")
    assert told.exit_code == exported.exit_code == 0, (told.stderr, exported.stderr)
    result = vfife.load_result("out")
    kept = np.searchsorted(whole.time, result.time)
    assert (
        result.record.damaged_parts
        and result.record.damaged_parts[0] in told.stdout
        and result.record.damaged_parts[0] in exported.stderr
        and "this run file is damaged" in told.stderr
        and "but the file is damaged" in " ".join(told.stdout.split())
    )
    assert kept[0] == 0 and 1 <= len(kept) < len(whole.time)
    assert (result.record.rows == whole.record.rows[kept]).all() and (
        result.ledger.residual == whole.ledger.residual[kept]
    ).all()


def test_a_model_file_that_is_not_that_of_the_run_is_mentioned(command: Callable, pendulum: Path) -> None:
    """Half of it, as after a full disk, or a changed number; the run file has the model that ran."""
    assert command("run", pendulum, "-o", "out", "--quiet").exit_code == 0
    sound = command("info", "out")
    assert "model.toml in this folder" not in sound.stdout and not sound.stderr
    text = Path("out/model.toml").read_text(encoding="utf-8")
    Path("out/model.toml").write_text(text[: len(text) // 2], encoding="utf-8")
    told = command("info", "out")
    assert "model.toml in this folder is not the model of this run" in " ".join(told.stdout.split())
    assert json.loads(command("info", "out", "--json").stdout)["other_model"] is True
    Path("out/model.toml").unlink()
    assert "model.toml in this folder" not in command("info", "out").stdout
