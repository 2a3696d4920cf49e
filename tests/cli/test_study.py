"""`vfife study`: from a study file to one file, which is shown, exported and added to; what goes wrong is a
sentence and an exit code.
"""

from __future__ import annotations

import csv
import json
import math
import sqlite3
from collections.abc import Callable
from pathlib import Path
from typing import Any
from zipfile import ZipFile

import numpy as np
import pytest

from fake_card import FakeDriver, in_this_machine
from studies.studies import ASKED, Closed
from vfife.results.study import Study
from vfife.store.lock import Lock
from vfife.studies import forecast
from vfife.studies import study_work as studies
from vfife.studies.engine import cluster, study_engine

Command = Callable[..., Any]
SEARCHED = """
method = "search"
[vary.play]
path = "joint.C.clearance"
from = "0.1 mm"
to = "0.3 mm"
[optimise]
minimise = ["C.force.max"]
cases = 4
"""


@pytest.fixture
def closed(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Closed:
    found = Closed()
    monkeypatch.setattr(study_engine, "run_cases", found)
    monkeypatch.setattr(forecast, "SAMPLE_CASES", 2)  # cases that are assembled to tell what all will cost
    monkeypatch.setattr(forecast, "WORTH", math.inf)  # and none of them are run for it
    (tmp_path / "s.toml").write_text(ASKED)
    return found


def test_the_same_command_goes_on_and_computes_nothing_twice(command: Command, closed: Closed) -> None:
    done = command("study", "s.toml")
    assert done.exit_code == 0, done.stderr
    assert "forecast: 6 cases, about " in done.stderr and "kB in runs/s.study" in done.stderr
    assert "C.impacts: counted over the whole case, its start included." in done.stdout
    assert "Turns were not compared" in done.stdout
    assert "play" in done.stdout and "0.1 mm to 0.3 mm" in done.stdout and "12 N" in done.stdout
    assert len(closed.computed) == 6
    assert command("study", "run", "s.toml", "-q").exit_code == 0
    assert len(closed.computed) == 6
    told = json.loads(command("study", "show", "runs/s.study", "--json", "--cases").stdout)
    assert told["status"] == "complete"
    assert "C.impacts: counted over the whole case, its start included." in told["remarks"]
    assert told["measures"]["C.force.max"]["largest"] == 200.0**2 * 3e-4
    assert told["measures"]["C.force.max"]["largest_at"] == {"play": 3e-4, "speed": 200.0}
    former = json.loads(command("study", "show", "runs/s.study", "--json", "--members").stdout)["members"]
    assert [{"member": one["case"], **one} for one in told["cases"]] == former, "as version 0.2 has them"
    assert [one["C.force.max"] for one in told["cases"]] == Study.open("runs/s.study").values(
        "C.force.max"
    ).tolist()


def test_values_points_and_what_was_broken_off_are_added(
    command: Command, closed: Closed, monkeypatch: pytest.MonkeyPatch
) -> None:
    command("study", "s.toml", "-o", "x.study", "-q")
    closed.computed.clear()
    assert command("study", "add", "x.study", "play=0.4 mm, 0.1 mm", "-q").exit_code == 0
    assert [one["joint.C.clearance"] for one in closed.computed] == [4e-4, 4e-4]
    assert command("study", "add", "x.study", "--point", "play=1 mm,speed=50 rad/s", "-q").exit_code == 0
    assert closed.computed[2:] == [{"joint.C.clearance": 1e-3, "driver.crank.speed": 50.0}]
    assert Study.open("x.study").data["C.force.max"].dims == ("case",), "one point beside a grid"
    assert command("study", "resume", "x.study", "-q").exit_code == 0
    assert len(closed.computed) == 3
    assert command("study", "add", "x.study", "speed=150", "-q").exit_code == 0
    assert len(closed.computed) == 7


def test_what_is_added_is_read_under_the_lock(
    command: Command, closed: Closed, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Two that add at once: the second is refused before it has read what the first is about to change."""
    command("study", "s.toml", "-o", "x.study", "-q")
    with studies.study_lock(Path("x.study")):
        read: list[object] = []
        monkeypatch.setattr(study_engine, "extended_plan", lambda *given: read.append(given))
        done = command("study", "add", "x.study", "play=0.5 mm")
    assert done.exit_code == 2 and not read and "writes this study" in done.stderr


def test_a_study_of_another_text_of_the_step_is_not_added_to(
    command: Command, closed: Closed, monkeypatch: pytest.MonkeyPatch
) -> None:
    command("study", "s.toml", "-o", "x.study", "-q")
    monkeypatch.setattr(study_engine, "sources_of_the_step", lambda: b"another text")
    for words in (("add", "x.study", "play=0.4 mm"), ("resume", "x.study")):
        done = command("study", *words)
        assert (done.exit_code, "whose steps differ" in done.stderr) == (2, True), done.stderr
    assert len(closed.computed) == 6 == len(Study.open("x.study").cases)


def test_samples_are_added_to_a_sequence(command: Command, closed: Closed, tmp_path: Path) -> None:
    lines = ASKED.replace("count = 2\n", "").replace("turns = 2", 'turns = 2\nmethod = "sobol"\ncount = 4')
    (tmp_path / "s.toml").write_text(lines)
    command("study", "s.toml", "-o", "x.study", "-q")
    first = Study.open("x.study").data
    assert first["C.force.max"].dims == ("play", "sample") and first.speed.dims == ("sample",)
    assert command("study", "add", "x.study", "--count", "8", "-q").exit_code == 0
    assert len(closed.computed) == 24
    assert np.array_equal(Study.open("x.study").data.speed.values[:4], first.speed.values)
    done = command("study", "add", "x.study", "speed=150")
    assert (done.exit_code, "samples are taken of speed" in done.stderr) == (2, True)


def test_a_case_that_fails_is_told_and_exit_code_3(command: Command, closed: Closed) -> None:
    closed.fails = 2e-4
    done = command("study", "s.toml", "-o", "x.study")
    assert done.exit_code == 3
    assert "2 of 6 cases gave no measures; the first: diverged after 7 steps" in done.stderr
    assert "study resume --retry x.study repeats them" in " ".join(done.stderr.split())
    closed.computed.clear()
    assert command("study", "resume", "x.study").exit_code == 3 and closed.computed == []
    closed.fails = None
    assert command("study", "resume", "x.study", "--retry").exit_code == 0 and len(closed.computed) == 2
    assert "nothing is left" not in done.stderr
    closed.fails = 2e-4
    done = command("study", "s.toml", "-o", "y.study")
    assert "case 2: play 0.2 mm, speed 100 rad/s: diverged after 7 steps" in done.stdout


def test_exports_have_the_numbers_to_the_bit(command: Command, closed: Closed, tmp_path: Path) -> None:
    import xarray

    closed.without = 1e-4
    command("study", "s.toml", "-o", "x.study", "-q")
    found = Study.open("x.study")
    for name, *options in (("out.csv",), ("out.nc",), ("out.xlsx",), ("commas.csv", "--decimal", "comma")):
        done = command("study", "export", "x.study", name, *options)
        assert done.exit_code == 0, done.stderr
    with (tmp_path / "out.csv").open() as stream:
        rows = list(csv.DictReader(stream))
    assert [float(row["C.force.max [N]"]) for row in rows] == found.values("C.force.max").tolist()
    assert [1e-3 * float(row["play [mm]"]) for row in rows] == found.points()[:, 0].tolist()
    # These cases have no repeated sample: the errors are not estimated.
    heads = list(rows[0])
    assert heads[heads.index("C.force.max [N]") + 1] == "C.force.max.error [N]"
    assert {row["C.force.max.error [N]"] for row in rows} == {""}
    assert (rows[0]["C.impacts"], rows[0]["reason"]) == ("", "it has no measure C.impacts")
    with (tmp_path / "commas.csv").open(encoding="utf-8-sig") as stream:
        commas = list(csv.DictReader(stream, delimiter=";"))
    # Both have the units of the study file; those with decimal points have all digits.
    assert list(commas[0]) == list(rows[0])
    assert [float(row["play [mm]"].replace(",", ".")) for row in commas] == pytest.approx(
        [float(row["play [mm]"]) for row in rows], rel=5e-7
    )
    assert [float(row["C.force.max [N]"].replace(",", ".")) for row in commas] == pytest.approx(
        [float(row["C.force.max [N]"]) for row in rows], rel=5e-7
    )
    assert "xl/worksheets/sheet2.xml" in ZipFile(tmp_path / "out.xlsx").namelist()
    with xarray.open_dataset(tmp_path / "out.nc", engine="h5netcdf") as data:
        assert data.identical(found.data.load()) or np.array_equal(
            data["C.force.max"], found.data["C.force.max"]
        )
        assert (
            data["C.force.max"].attrs["units"] == "N" and data.play.attrs["long_name"] == "joint.C.clearance"
        )
    assert command("study", "export", "x.study", "out.csv").exit_code == 2
    assert (
        "there are .csv, .xlsx, .nc and .parquet" in command("study", "export", "x.study", "out.doc").stderr
    )
    parquet = pytest.importorskip("pyarrow.parquet")
    assert command("study", "export", "x.study", "out.parquet").exit_code == 0
    table = parquet.read_table(tmp_path / "out.parquet")
    assert table["C.force.max"].to_numpy().tolist() == found.values("C.force.max").tolist()
    assert table["C.impacts"].null_count == 2
    assert table.schema.field("speed").metadata[b"units"] == b"rad/s"


def test_bad_input_is_a_sentence_and_exit_code_2(command: Command, closed: Closed, tmp_path: Path) -> None:
    (tmp_path / "bad.toml").write_text(ASKED.replace("joint.C.clearance", "joint.C.clearence"))
    (tmp_path / "other.study").write_text("a letter")
    cases = {
        ("study", "bad.toml"): 'Did you mean "joint.C.clearance"',
        ("study", "missing.toml"): "it cannot be read",
        ("study", "show", "missing.study"): "there is no study file of this name",
        ("study", "s.toml", "-o", "other.study", "--force"): "is not a study file; choose another name",
        ("study", "show", "other.study"): "this is not a study file",
        ("study", "s.toml", "-o", "nowhere/x.study"): "-o nowhere/x.study: there is no folder",
        ("study", "shwo", "x.study"): "No such command 'shwo'",
    }
    for words, says in cases.items():
        done = command(*words)
        assert (done.exit_code, says in done.stderr) == (2, True), (words, done.stderr)
    command("study", "s.toml", "-o", "x.study", "-q")
    assert (
        "is the results of a study, not a run; show them with vfife study show"
        in command("info", "x.study").stderr
    )
    assert "is the results of a study, not a study; show them" in command("study", "x.study").stderr
    assert "nothing is left to compute: all 6 cases" in command("study", "resume", "x.study").stderr
    for word, says in (
        ("plya=1", 'did you mean "play"'),
        ("play=1 s", "this is a time"),
        ("play", "this is not NAME=VALUE"),
    ):
        done = command("study", "add", "x.study", word)
        assert (done.exit_code, says in done.stderr) == (2, True), done.stderr
    with Lock(tmp_path, "x.study.lock", "this study"):
        done = command("study", "s.toml", "-o", "x.study", "-q")
    assert (done.exit_code, "writes this study; wait until it has ended" in done.stderr) == (2, True)
    assert len(Study.open("x.study").done) == 6


def test_a_study_gives_way_only_to_one_that_can_begin(
    command: Command, closed: Closed, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(cluster, "ANSWER", 0.2)
    command("study", "s.toml", "-o", "x.study", "-q")
    for words in (("study",), ("optimise",)):
        if words == ("optimise",):
            (tmp_path / "s.toml").write_text(ASKED.split("[vary")[0] + SEARCHED)
        done = command(*words, "s.toml", "-o", "x.study", "--force", "--cluster", "nowhere:0")
        assert (done.exit_code, "no scheduler answers" in done.stderr) == (2, True), done.stderr
        assert len(Study.open("x.study").done) == 6


def test_a_damaged_study_is_called_one_and_gives_way_where_that_is_asked_for(
    command: Command, closed: Closed, tmp_path: Path
) -> None:
    command("study", "s.toml", "-o", "x.study", "-q")
    (tmp_path / "x.study").write_bytes((tmp_path / "x.study").read_bytes()[:3000])
    for words in (("study", "show", "x.study"), ("study", "s.toml", "-o", "x.study")):
        done = command(*words)
        assert (
            done.exit_code == 2
            and "this study file is damaged" in done.stderr
            and "make the study again" in done.stderr
        ), done.stderr
    done = command("study", "s.toml", "-o", "x.study", "--force")
    assert (done.exit_code, "forecast: 6 cases," in done.stderr) == (0, True), done.stderr
    again = command("study", "s.toml", "-o", "x.study", "--force")
    assert "forecast: 6 cases," in again.stderr and "already" not in again.stderr, (
        "all of them are computed anew"
    )


def test_a_study_whose_cases_are_all_damaged_is_shown(
    command: Command, closed: Closed, tmp_path: Path
) -> None:
    command("study", "s.toml", "-o", "x.study", "-q")
    with sqlite3.connect(tmp_path / "x.study") as file:
        file.execute("UPDATE members SET hash = 'none'")
    done = command("study", "show", "x.study", "--cases")
    assert done.exit_code == 0, done.exception
    assert "this study file is damaged: 6 cases are damaged" in done.stderr and "0 cases" in done.stdout
    command("study", "export", "x.study", "x.csv")
    assert (tmp_path / "x.csv").read_text().startswith("case,play [mm],speed [rad/s],"), (
        "the names of columns stay"
    )


def test_one_is_not_said_to_be_many(command: Command, closed: Closed, tmp_path: Path) -> None:
    (tmp_path / "s.toml").write_text(
        ASKED.split("turns")[0] + 'turns = 1\n[vary]\n"joint.C.clearance" = [1e-4]\n'
    )
    done = command("study", "s.toml")
    assert (
        "forecast: 1 case, about" in done.stderr
        and ": 1 case, 1 complete" in done.stdout
        and "1 turn;" in done.stdout
    ), done.stdout


def test_figures_have_a_folder_of_their_own(command: Command, closed: Closed) -> None:
    command("study", "s.toml", "-o", "x.study", "-q")
    done = command("study", "plot", "x.study", "-o", "s.toml")
    assert (done.exit_code, "File exists. Name another place" in done.stderr) == (2, True), done.stderr


def test_a_card_that_is_not_there_is_told_before_anything_is_begun(command: Command, closed: Closed) -> None:
    with in_this_machine(FakeDriver(None, cuInit=100)):
        for words in (("study", "s.toml"), ("study", "run", "s.toml", "-o", "x.study")):
            done = command(*words, "--device", "cuda")
            assert (done.exit_code, "the driver sees no card" in done.stderr) == (2, True), done.stderr
    done = command("study", "s.toml", "--device", "gpu")
    assert (done.exit_code, 'device gpu: there is no such device; there is "cuda"' in done.stderr) == (
        2,
        True,
    ), done.stderr
    done = command("study", "s.toml", "--device", "cuda", "--cluster", "local")
    assert (done.exit_code, "cluster local and device cuda exclude each other" in done.stderr) == (2, True), (
        done.stderr
    )
    assert not Path("runs").exists() and not Path("x.study").exists()


def test_a_study_of_hours_is_refused_with_its_numbers_unless_it_is_meant(
    command: Command, closed: Closed, tmp_path: Path
) -> None:
    (tmp_path / "s.toml").write_text(ASKED.replace("turns = 2", "turns = 500000"))
    done = command("study", "s.toml", "-o", "x.study")
    assert done.exit_code == 2
    assert "for 6 cases of" in done.stderr and "add --yes to confirm" in done.stderr
    assert not Path("x.study").exists()
    assert command("study", "s.toml", "-o", "x.study", "--yes", "-q").exit_code == 0


def test_cases_of_other_kinds_are_grouped_and_told(command: Command, closed: Closed, tmp_path: Path) -> None:
    (tmp_path / "s.toml").write_text(
        ASKED + '[vary.law]\npath = "joint.C.contact.law"\nvalues = ["lankarani-nikravesh", "flores"]\n'
    )
    done = command("study", "s.toml", "-o", "x.study")
    assert done.exit_code == 0, done.stderr
    assert "cases of 2 kinds are run group by group" in done.stderr
    assert "joint.C.contact.law = flores: 6" in done.stderr


@pytest.mark.usefixtures("unrendered")
def test_figures_and_a_report_are_written(command: Command, closed: Closed) -> None:
    command("study", "s.toml", "-o", "x.study", "-q")
    done = command(
        "study", "plot", "x.study", "--figure", "curves", "--measure", "C.force.max", "--kind", "svg"
    )
    assert (done.exit_code, done.stdout.split()) == (0, ["x-figures/curves.svg"]), done.stderr
    assert "did you mean" in command("study", "plot", "x.study", "--figure", "curvs").stderr
    done = command("report", "x.study", "--no-live")
    assert done.exit_code == 0, done.stderr
    page = Path("x-report.html").read_text()
    assert "6 cases: 6 complete" in page and "12\u00a0N" in page and "<iframe" not in page
    assert command("report", "x.study").exit_code == 2, "a file that is there stays"


def test_measures_of_the_whole_run_are_told_beside_the_turns_that_are_chosen(
    command: Command, closed: Closed, tmp_path: Path
) -> None:
    for last, told in ((1, False), (2, True)):
        (tmp_path / "s.toml").write_text(ASKED.replace("turns = 2", f"turns = 2\nlast = {last}"))
        said = " ".join(command("study", "s.toml", "--force").stderr.split())
        assert (
            "note: C.impacts is of the whole run, from its first turn on; last = 2 does not change that, but"
            ' counts = "last" does.' in said
        ) is told, said
    (tmp_path / "s.toml").write_text(ASKED.replace("turns = 2", 'turns = 2\ncounts = "last"'))
    done = command("study", "s.toml", "--force")
    shown = " ".join(done.stdout.split())
    assert "C.impacts: counted over the last turn of each case." in shown and "start included" not in shown
    (tmp_path / "s.toml").write_text(ASKED.replace("turns = 2", 'duration = "0.01 s"\ncounts = "last"'))
    assert "a case with a duration has no turns" in command("study", "s.toml", "--force").stderr
    (tmp_path / "s.toml").write_text(
        ASKED.replace('"C.impacts"', '"C.impacts", "C.approach_speed.max"').replace(
            "turns = 2", "turns = 2\nlast = 2"
        )
    )
    assert (
        "C.impacts, C.approach_speed.max are of the whole run" in command("study", "s.toml", "--force").stderr
    )


NAMES = {  # text of ASKED that is misspelt, as what, and where it is reported with the nearest name
    "limit": ('\n[limit]\n"C.force.maxx" = "1 kN"\n', '"C.force.max"'),
    "allocation": ('\n[allocation]\nmeasure = "C.force.mx"\n', '"C.force.max"'),
    "minimise": ('\n[optimise]\nminimise = ["C.forc.max"]\n', '"C.force.max"'),
    "maximise": ('\n[optimise]\nmaximise = ["C.forc.max"]\n', '"C.force.max"'),
    "cost": ("\n[cost.pley]\nIT7 = 5\n", '"play"'),
    "set": ('\n[set]\n"joint.C.clearence" = "0.1 mm"\n', '"joint.C.clearance"'),
    "vary": ('\n[vary.other]\npath = "joint.C.frictoin"\nvalues = [1]\n', '"joint.C.friction"'),
    "point": ("\n[[point]]\npley = 1\n", '"play"'),
    "table": ('\n[limits]\n"C.force.max" = "1 kN"\n', '"limit"'),
}


@pytest.mark.parametrize("name", NAMES)
def test_a_misspelt_name_is_refused_before_any_case(
    name: str, command: Command, closed: Closed, tmp_path: Path
) -> None:
    text, nearest = NAMES[name]
    (tmp_path / "s.toml").write_text(ASKED + text)
    done = command("study", "s.toml")
    assert done.exit_code == 2 and not closed.computed, done.stdout
    assert f"Did you mean {nearest}" in done.stderr, done.stderr
    assert not (tmp_path / "runs" / "s.study").exists()
