"""Readers of records that a test writes: turns laid over each other, reductions, spectra, flags, sentences
about files.
"""

from __future__ import annotations

import math
import sqlite3

import numpy as np
import pytest

import vfife
from made_records import made_record
from support import four_bar
from vfife.errors import VfifeError
from vfife.results.channels import channels, entities
from vfife.results.run_data import Reductions, RunData, turn_of
from vfife.results.series import joined
from vfife.results.spectra import PARTS, sampled
from vfife.store.connections import unwritten
from vfife.store.run_reader import missing
from vfife.store.runfile import RunFile

SPEED, OUTPUTS, TURNS = 100.0, 40, 12
TURN = math.tau / SPEED
STEP = TURN / (4 * OUTPUTS)


def made(turns: int = TURNS, rounding: float = 0.0, **blocks):
    """A crank that turns evenly, four steps between outputs, its angle but for a rounding error (rad)."""
    steps = np.arange(0, turns * OUTPUTS + 1) * 4
    angle = SPEED * STEP * steps + rounding
    blocks = {"driven_torque": np.sin(angle), **blocks, "particle_theta": angle}
    return made_record(four_bar("", speed=SPEED), blocks, steps, turns=turns, step=STEP, outputs=OUTPUTS)


@pytest.mark.parametrize("rounding", [-1e-9, 0.0, 1e-9])
def test_a_whole_turn_of_the_crank_is_0_whatever_its_rounding(rounding: float) -> None:
    """An output that rounding puts just before a whole turn lies at 0, where its turn ends."""
    record = made(rounding=rounding)
    found = RunData(record).turns
    assert (
        found.turn.values.tolist() == list(range(TURNS - 7, TURNS + 1)) or found.turn.values[0] <= TURNS - 7
    )
    assert found.crank_angle.values == pytest.approx(360.0 / OUTPUTS * np.arange(OUTPUTS), abs=1e-6)
    first = int(found.turn.values[0])
    assert found.time.values[0, 1] == pytest.approx(
        (first - 1) * TURN + TURN / OUTPUTS
    ) and found.time.values[-1, 0] == pytest.approx(TURNS * TURN)
    with pytest.raises(VfifeError, match="no turns to lay over each other"):
        _ = RunData(
            made_record(four_bar("", speed=SPEED), {}, np.arange(10) * 4, turns=1, step=STEP, outputs=OUTPUTS)
        ).turns


def test_reductions_are_over_the_last_turn_of_a_longer_record() -> None:
    record = made(turns=3)
    assert turn_of(record) == 2 * OUTPUTS
    found = Reductions(
        ["max(crank.torque)", "mean(crank.torque)", "rms(crank.torque)", "range(no.such)", "C.force.max"]
    ).compute([record])
    assert found == {
        "max(crank.torque)": pytest.approx(1.0),
        "mean(crank.torque)": pytest.approx(0.0, abs=1e-9),
        "rms(crank.torque)": pytest.approx(math.sqrt(0.5), rel=1e-9),
    }
    two = made_record(
        four_bar("", speed=SPEED), {"driven_torque": [1.0, 3.0]}, [0, 4], turns=1, step=STEP, outputs=OUTPUTS
    )
    assert Reductions(["mean(crank.torque)"]).compute([two]) == {"mean(crank.torque)": 2.0}
    start = made_record(four_bar("", speed=SPEED), {}, [0], turns=1, step=STEP, outputs=OUTPUTS)
    assert Reductions(["max(crank.torque)"]).compute([start]) == {}
    assert joined([np.array([1.0, 2.0]), np.array([2.0, 3.0])]).tolist() == [1.0, 2.0, 3.0]


def test_a_series_is_sampled_after_the_start() -> None:
    view = RunData(made(turns=3))
    one = sampled(view, "crank.torque")
    assert len(one.values) == 3 * OUTPUTS and one.label["turn"] == pytest.approx(TURN)
    assert (one.spacing, one.label["start"]) == pytest.approx((4 * STEP, 4 * STEP))
    assert one.values == pytest.approx(np.sin(SPEED * 4 * STEP * np.arange(1, 3 * OUTPUTS + 1)), abs=1e-9)
    assert (one.length(None, 2.0), one.length(TURN, None), one.length(None, None)) == (
        2 * OUTPUTS,
        OUTPUTS,
        None,
    )
    for said, what in (((0.1, 1.0), "not both"), ((None, 0.0), "above 0"), ((None, math.inf), "above 0")):
        with pytest.raises(VfifeError, match=what):
            one.length(*said)
    uneven = made(turns=3)
    uneven.steps = uneven.steps.copy()
    uneven.steps[2:] += 4
    with pytest.raises(VfifeError, match="at even times"):
        sampled(RunData(uneven), "crank.torque")


def test_a_spectrogram_has_sixteen_windows_side_by_side_unless_said() -> None:
    found = vfife.dynamics.spectrogram(np.sin(np.arange(1600.0)), 1e-3, start=5.0)
    assert found.length == 1600 // PARTS == 100
    assert found.times[0] == pytest.approx(5.0 + 0.0495) and found.times[1] - found.times[0] == pytest.approx(
        0.025
    )


def test_the_crank_is_the_first_driven_body_and_modes_have_their_numbers() -> None:
    view = RunData(made(turns=1))
    assert (
        view.crank == "crank"
        and view.crank_angle is not None
        and view.crank_angle[-1] == pytest.approx(0.0)
        and view.crank_rotation is not None
        and view.crank_rotation[-1] == pytest.approx(360.0)
    )
    loose = RunData(made_record(four_bar(), {}, np.arange(5), turns=1, step=1e-7))
    mode = loose.data["mode"]
    assert (
        mode.attrs["flag_values"].tolist() == [0, 1, 2]
        and mode.attrs["flag_meanings"].split()[2] == "continuous_contact"
    )


def test_data_hold_the_model_unless_it_is_too_long(monkeypatch: pytest.MonkeyPatch) -> None:
    """HDF5 takes no attribute beyond 64 KiB."""
    found = RunData(made(turns=1))
    assert found.attributes["model_file"].startswith("#") or "[body.crank]" in found.attributes["model_file"]
    monkeypatch.setattr("vfife.results.run_data.LONGEST_ATTRIBUTE", 100)
    assert "model_file" not in found.attributes


def test_particles_are_named_after_their_bodies_and_the_ground_is_none() -> None:
    record = made(turns=1)
    assert entities(record)["particle"] == ["crank", "coupler", "follower"]
    theta = channels(record, RunData(record).ledger)["particle_theta"]
    assert theta.values.shape == (OUTPUTS + 1, 3)
    assert theta.values[:, 0] == pytest.approx(SPEED * STEP * 4 * np.arange(OUTPUTS + 1))


def test_forces_of_joints_have_their_size_and_directions() -> None:
    """(3, -4) N in every ideal joint of a crank at rest: 5 N, of the pivot too."""
    steps = np.arange(3) * 4
    blocks = {"joint_fx": np.full(3, 3.0), "joint_fy": np.full(3, -4.0), "joint_moment": np.full(3, 0.5)}
    found = channels(
        record := made_record(four_bar("", speed=SPEED), blocks, steps, turns=1, step=STEP),
        RunData(record).ledger,
    )
    k = entities(record)["joint"].index("C")
    numbers = [
        float(found[f"joint_{name}"].values[1, k]) for name in ("force", "force_x", "force_y", "moment")
    ]
    assert numbers == [5.0, 3.0, -4.0, 0.5]


def test_rows_of_tables_are_sealed_and_counted(tmp_path) -> None:
    with RunFile.create(tmp_path / "one.sqlite") as file:
        with file.transaction():
            file.insert("events", 1, 7, "now", "it began")
        assert file.size == 8 + 8 + 3 + 8
        row = file.row("events", 1)
        assert row is not None and row.values == (1, 7, "now", "it began") and row["text"] == "it began"
        assert file.row("events", 2) is None
        with sqlite3.connect(file.path) as connection:
            connection.execute("UPDATE events SET step = 8")
        assert file.row("events", 1) is None, "its seal is that of another row"
        assert file.has("events") and not file.has("none")


def test_sentences_about_files_that_cannot_be_written() -> None:
    assert "bytes were to be written" not in unwritten("/nowhere/run.sqlite", "disk I/O error")
    assert "1,234 bytes were to be written, " in unwritten("/nowhere/run.sqlite", "disk I/O error", 1234)
    assert "you may not write" in unwritten("/nowhere/run.sqlite", "attempt to write a readonly database")
    assert (missing(3, 4), missing(3, 5)) == ("output 3", "outputs 3 to 4")
