"""``vfife sensitivity``: table, figure, JSON and CSV; sentences for what it cannot do."""

import json
import math
import os
import subprocess
import sys
from pathlib import Path

import pytest

import vfife
from vfife.cli.values import separated
from vfife.job.job import Interrupted
from vfife.studies.methods import derivable, derivatives

EXAMPLES = Path(__file__).resolve().parents[2] / "examples"
CRANK = EXAMPLES / "slider_crank.toml"


@pytest.mark.slow("displaced runs")
def test_a_table_ranks_the_numbers_that_matter(command, tmp_path):
    done = command(
        "sensitivity",
        CRANK,
        "--of",
        "pin.force.max",
        "-n",
        2,
        "--turns",
        1,
        "--figure",
        "t.svg",
        "--csv",
        "all.csv",
        "--quiet",
    )
    assert done.exit_code == 0, done.stderr
    assert (tmp_path / "t.svg").read_text().startswith("<?xml")
    done = command("sensitivity", CRANK, "--of", "pin.force.max", "-n", 2, "--turns", 1)
    lines = [line.split() for line in done.stdout.splitlines() if line.strip().startswith(("pin", "body"))]
    assert [line[-2:] for line in lines] == [["driver.crank.speed", "+2"], ["body.crank.length", "+1.29"]]
    rows = json.loads(command("sensitivity", CRANK, "--of", "pin.force.max", "--turns", 1, "--json").stdout)[
        "rows"
    ]
    assert len(rows) + 1 == len((tmp_path / "all.csv").read_text().splitlines())
    assert {"measure": "pin.force.max", "number": "driver.crank.speed"}.items() <= rows[0].items()


def test_measures_and_numbers_are_repeated_or_have_commas():
    """As the laws of compare; a comma in a function or in a name of the model separates nothing."""
    mechanism = vfife.load_model(CRANK)
    assert separated(["a.force.max, b.force.max", "c.*"], mechanism) == ["a.force.max", "b.force.max", "c.*"]
    assert separated(["max(A.force,B.force),rms(C.force)"], mechanism) == [
        "max(A.force,B.force)",
        "rms(C.force)",
    ]
    assert separated(None, mechanism) == []
    named = vfife.Mechanism("named")
    named.link("a,b", length=1.0, mass=1.0)
    assert separated(["a,b.force.max"], named) == ["a,b.force.max"]


def test_a_list_with_commas_is_that_of_repeated_options(command, monkeypatch):
    """The same table, of which nothing has to be checked for this."""

    def interrupt(*_, **__):
        raise KeyboardInterrupt

    monkeypatch.setattr(derivatives, "finite_changes", interrupt)
    head, tail = ("sensitivity", CRANK, "--turns", 1), ("--json", "--quiet")
    listed = command(*head, "--of", "pin.force.max,O.force.max", "--to", "driver.*,body.crank.length", *tail)
    names = (
        ("--of", "pin.force.max"),
        ("--of", "O.force.max"),
        ("--to", "driver.*"),
        ("--to", "body.crank.length"),
    )
    repeated = command(*head, *(word for pair in names for word in pair), *tail)
    rows = json.loads(listed.stdout)["rows"]
    assert {row["measure"] for row in rows} == {"pin.force.max", "O.force.max"}
    assert rows == json.loads(repeated.stdout)["rows"]


@pytest.mark.parametrize(("where", "count"), [("finite_changes", 2), ("record_pairs", 0)])
def test_what_is_there_is_shown_after_ctrl_c(command, monkeypatch, where, count):
    """In Python it is the result of the exception."""

    def interrupt(*_, **__):
        raise KeyboardInterrupt

    monkeypatch.setattr(derivatives, where, interrupt)
    done = command(
        "sensitivity",
        CRANK,
        "--of",
        "pin.force.max",
        "--turns",
        1,
        "--to",
        "driver.*",
        "--to",
        "body.crank.length",
        "--json",
    )
    data = json.loads(done.stdout)
    assert done.exit_code == 130 and (data["status"], len(data["rows"])) == ("interrupted", count), (
        done.stderr
    )
    assert f"derivatives by {count} numbers are available, none of them checked" in done.stderr
    with pytest.raises(Interrupted) as interrupted:
        vfife.sensitivity(
            vfife.load_model(CRANK), ["pin.force.max"], ["driver.*", "body.crank.length"], turns=1
        )
    found = interrupted.value.result
    assert not found.complete and len(found.derivatives) == count
    assert all(math.isfinite(found.elasticity("pin.force.max", one.path)) for one in found.derivatives)


@pytest.mark.system("displaced runs of a chaotic motion")
def test_measures_that_depend_on_the_time_step_are_marked(command, tmp_path):
    """In the table, the figure, JSON and a sentence."""
    asked = (
        "--of",
        "coupler.angular_acceleration.max",
        "--to",
        "body.*.mass",
        "--step",
        "8 us",
        "--turns",
        1,
    )
    words = ("sensitivity", EXAMPLES / "four_bar_case_c.toml", *asked)
    done = command(*words, "--figure", "t.svg")
    assert done.exit_code == 0
    assert "are meaningless, and none was computed" in done.stderr
    assert "--companions 0 computes" in " ".join(done.stderr.split())
    assert "forecast: a run of " in done.stderr and "numbers, each checked by finite changes" in done.stderr
    lines = [line.split() for line in done.stdout.splitlines() if line.strip()]
    assert any((line[0], line[-1]) == ("coupler.angular_acceleration.max", "?") for line in lines)
    assert "depends" in (tmp_path / "t.svg").read_text() and "on the time step" in done.stdout
    rows = json.loads(command(*words, "--json").stdout)["rows"]
    assert [(row["measure"], row["number"], row["kind"]) for row in rows] == [(asked[1], None, "unknown")]
    assert rows[0]["meaningless"] and rows[0]["derivative"] is None and rows[0]["value"] > 0.0
    forced = json.loads(command(*words, "--companions", 0, "--json").stdout)["rows"]
    assert {row["number"] for row in forced} == {"body.coupler.mass", "body.follower.mass"}
    assert all(math.isfinite(row["derivative"]) for row in forced)


def test_no_derivative_is_computed_where_runs_with_other_steps_disagree_on_all_measures(monkeypatch):
    """One measure on which they agree is enough to compute all."""
    mechanism, measures = vfife.load_model(CRANK), ["pin.force.max", "O.force.max"]

    def compute(*_, **__):
        raise RuntimeError("computed")

    monkeypatch.setattr(derivatives, "finite_changes", compute)
    monkeypatch.setattr(derivable, "doubtful", lambda _, names, __: frozenset(names))
    answer = vfife.sensitivity(mechanism, measures, ["driver.*"], turns=1)
    assert answer.undetermined and answer.complete and answer.doubtful == frozenset(measures)
    assert {(row["measure"], row["number"]) for row in answer.rows()} == {(name, None) for name in measures}
    monkeypatch.setattr(derivable, "doubtful", lambda *_: frozenset(measures[:1]))
    with pytest.raises(RuntimeError, match="computed"):
        vfife.sensitivity(mechanism, measures, ["driver.*"], turns=1)


def test_measures_are_of_the_part_that_the_run_states(command, tmp_path):
    """Without a crank of constant speed they are of the whole run, as those of ``vfife run`` and ``vfife
    info``.
    """
    gears = EXAMPLES / "gear_train.toml"
    words = ("sensitivity", gears, "--of", "motor.angular_acceleration.max", "--to", "driver.curve.torque.0")
    done = command(*words)
    assert done.exit_code == 0 and "Measures belong to the whole run, in SI units." in done.stdout
    part = json.loads(command(*words, "--json").stdout)["part"]
    run = json.loads(command("run", gears, "-o", "gears", "--json", "--quiet").stdout)
    assert part == run["part"] == "whole run"
    crank = command("sensitivity", CRANK, "--of", "pin.force.max", "--to", "driver.*", "--turns", 1, "--json")
    assert json.loads(crank.stdout)["part"] == "last turn"


def test_measures_that_are_rounding_are_left_out_and_told(command):
    """A guide carries no moment where the only pin and the middle of the block's mass are on its line, and
    what it guides does not turn.
    """
    done = command(
        "sensitivity",
        CRANK,
        "--turns",
        1,
        "--of",
        "*.moment.max",
        "--of",
        "*.torque.max",
        "--of",
        "block.*",
        "--to",
        "body.*.mass",
    )
    assert done.exit_code == 0
    assert "the largest value of their unit: block.angular_acceleration.max, guide.moment.max" in " ".join(
        done.stderr.split()
    )
    assert {line.split()[0] for line in done.stdout.splitlines() if ".max" in line} == {"crank.torque.max"}


@pytest.mark.system("starts processes with other libraries")
@pytest.mark.parametrize("kernel", ["Haswell", "Nehalem", "SkylakeX"])
def test_rounding_decides_no_exit_code(kernel):
    """The moment of that guide is 1e-45 N m or exactly 0, which the linear algebra of the machine decides; a
    run leaves out the latter.
    """
    words = [
        sys.executable,
        "-m",
        "vfife",
        "sensitivity",
        str(CRANK),
        "--turns",
        "1",
        "--of",
        "*.moment.max",
        "--to",
        "body.*.mass",
    ]
    done = subprocess.run(
        words,
        capture_output=True,
        text=True,
        env={**os.environ, "OPENBLAS_CORETYPE": kernel},
        check=False,
        timeout=300,
    )
    assert done.returncode == 0, done.stderr
    assert "rounding errors relative to the largest value of their unit: guide.moment.max" in " ".join(
        done.stderr.split()
    )


@pytest.mark.system("displaced runs of a chaotic motion")
def test_a_change_stands_where_the_derivative_does_not_describe_it(command):
    """The largest gas force is at a point of the table of pressures: more there makes it larger, less lets
    another point be the largest.
    """
    words = (
        "sensitivity",
        EXAMPLES / "compressor.toml",
        "--of",
        "small-end.force.max",
        "--to",
        "load.gas.pressure.1[23]",
        "--turns",
        1,
    )
    done = command(*words)
    assert done.exit_code == 0, done.stderr
    lines = [line.split() for line in done.stdout.splitlines() if "load.gas" in line]
    star, low, to, high = lines[0][-4:]
    assert (star, to) == ("*", "to") and float(low) < 0.8 < float(high)
    assert lines[1][1] == "?"
    assert "* change for 1 %" in done.stdout and "? sign or order of magnitude not known" in done.stdout
    rows = json.loads(command(*words, "--json").stdout)["rows"]
    assert {row["number"][-2:]: (row["kind"], row["meaningless"]) for row in rows} == {
        "12": ("change", True),
        "13": ("unknown", True),
    }
    assert all(row["change_from"] <= row["change"] <= row["change_to"] for row in rows)


@pytest.mark.system("displaced runs of a chaotic motion")
def test_wide_ranges_have_a_note(command):
    """A step at which reversals of friction are over before they are seen: also one displaced run alone has a
    range from other step sizes.
    """
    words = (
        "sensitivity",
        EXAMPLES / "four_bar_case_c.toml",
        "--of",
        "C.force.max",
        "--to",
        "body.*.mass",
        "--turns",
        1,
    )
    for more in ((), ("--runs", 1)):
        done = command(*words, *more)
        assert done.exit_code == 0 and "of the largest wide (C.force.max)" in " ".join(done.stderr.split())
    done = command(*words, "--runs", 9)
    assert done.exit_code == 2 and "from 1 to 8" in done.stderr


def test_a_step_that_is_too_large_may_be_forced(command):
    words = (
        "sensitivity",
        EXAMPLES / "four_bar_case_c.toml",
        "--of",
        "C.force.max",
        "--to",
        "body.*.mass",
        "--turns",
        0.1,
        "--step",
        "21.5 us",
    )
    done = command(*words)
    assert done.exit_code == 2 and "--force-step" in done.stderr
    assert command(*words, "--force-step").exit_code == 0


def test_what_takes_hours_is_refused_without_yes(command):
    done = command("sensitivity", CRANK, "--turns", 1_000_000)
    assert done.exit_code == 2 and "add --yes" in done.stderr and "Nothing was started" in done.stderr


def test_faults_are_sentences(command, tmp_path):
    for words, said in (
        (("--of", "pin.forc.max"), 'Did you mean "pin.force.max"'),
        (("--figure", "t.gif"), ".png"),
        (("--csv", tmp_path / "no" / "all.csv"), "there is no folder"),
        (("--step", "-1 us"), "above 0"),
    ):
        done = command("sensitivity", CRANK, *words)
        assert done.exit_code == 2 and said in " ".join(done.stderr.split()), done.stderr
        assert "Traceback" not in done.stderr
    done = command("sensitivity", EXAMPLES / "lee_frame.toml")
    assert done.exit_code == 2 and "static" in done.stderr


@pytest.mark.system("displaced runs of a free motion")
def test_a_model_without_a_driver_has_the_largest_that_there_are(command):
    done = command(
        "sensitivity", EXAMPLES / "block_on_incline.toml", "--duration", "10 ms", "--companions", 0, "--json"
    )
    assert done.exit_code == 0, done.stderr
    assert {
        row["measure"].rpartition(".")[0].rpartition(".")[2] for row in json.loads(done.stdout)["rows"]
    } <= {"force", "angular_acceleration"}
    done = command("sensitivity", EXAMPLES / "block_on_incline.toml", "--companions", "\N{SUPERSCRIPT TWO}")
    assert done.exit_code == 2 and "0 to 7" in done.stderr
