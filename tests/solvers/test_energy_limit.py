"""A run whose energy is not accounted for is stopped, and said to be; one that hangs still is not."""

from __future__ import annotations

import dataclasses
import json
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

import vfife
from support import bits, journal_in_bearing, with_settings
from vfife.cli.app import app
from vfife.errors import ResumeError
from vfife.measures.energy import drifting, ledger
from vfife.measures.trust import finer
from vfife.report.divergence import energy_cause
from vfife.solvers import interrupts, transient
from vfife.solvers.record import places
from vfife.solvers.transient import run

COARSE = {
    "step": 3e-5,
    "duration": 5e-2,
    "force_step": True,
    "companions": 0,
    "reference": False,
}  # 22 % of the energy come from nowhere


def test_ten_percent_stop_a_run_and_the_limit_is_settable() -> None:
    result = vfife.simulate(journal_in_bearing(), **COARSE)
    assert result.record.status == "energy" and 0.2 < result.ledger.error < 0.3
    assert "do not use these numbers" in result.summary["warnings"][0]
    for limit, status in ((0.2, "energy"), (0.25, "complete")):
        assert (
            vfife.simulate(with_settings(journal_in_bearing(), energy_limit=limit), **COARSE).record.status
            == status
        )
    fine = vfife.simulate(journal_in_bearing(), **{**COARSE, "step": 1e-5})
    assert fine.record.status == "complete" and any(
        "ledger is open by 1.6 %" in one for one in fine.summary["warnings"]
    )


def test_it_does_not_wait_for_the_end(monkeypatch: pytest.MonkeyPatch) -> None:
    """Energy that comes from nowhere and stays: a work that the ledger has and nothing has done."""
    record = vfife.simulate(journal_in_bearing(), step=1e-6, duration=1e-2, companions=0, outputs=200).record
    assert not drifting(record.assembly, record.row_numbers, record.steps, record.rows)
    rows = record.rows.copy()
    rows[-30:, places(record.row_numbers, record.assembly.layout["external_work"])] += (
        0.2 * ledger(record).largest
    )
    assert drifting(record.assembly, record.row_numbers, record.steps, rows)
    assert not drifting(
        record.assembly, record.row_numbers, record.steps[:-25], rows[:-25]
    )  # of the last outputs only some are off
    monkeypatch.setattr(transient, "JUDGE_SECONDS", 0.0)
    looked: list[int] = []

    def judge(steps: np.ndarray, rows: np.ndarray) -> bool:
        looked.append(int(steps[-1]))
        return steps[0] == 0 and (bits(rows[0]) == bits(record.rows[0])).all() and steps[-1] > 2000

    monkeypatch.setattr(
        interrupts.ChunkSize, "steps", property(lambda self: 500, lambda self, value: None), raising=False
    )
    stopped = run(record.assembly, judge=judge)
    assert stopped.status == "energy" and stopped.steps[-1] == looked[-1] < 10_000
    assert (bits(stopped.rows) == bits(record.rows[: len(stopped.rows)])).all()


def test_exit_code_and_words(tmp_path: Path) -> None:
    model = tmp_path / "m.toml"
    vfife.save_model(journal_in_bearing(), model)
    words = [
        "run",
        str(model),
        "--step",
        "3e-5",
        "--duration",
        "0.05",
        "--force-step",
        "--companions",
        "0",
        "-o",
        str(tmp_path / "r"),
        "--json",
    ]
    done = CliRunner().invoke(app, words)
    assert (
        done.exit_code == 4
        and json.loads(done.stdout)["status"] == "energy"
        and json.loads(done.stdout)["faults"]
    )
    assert "--step 1.5e-05" in done.stderr and "energy_limit" in done.stderr
    assert vfife.load_result(tmp_path / "r").record.status == "energy"
    with pytest.raises(ResumeError, match="this run failed"):
        vfife.resume(tmp_path / "r")


def test_what_hangs_still_has_no_energy_to_be_judged_by() -> None:
    m = vfife.Mechanism("still", gravity=(0.0, -9.81))
    m.point("O", 0.0, 0.0)
    m.link("rod", length=1.0, mass=2.0, angle=-1.5707963267948966)
    m.revolute("J", "ground.O", "rod.start")
    assert vfife.simulate(m, duration=0.1).record.status == "complete"


def rubber(strain: str, young: float) -> vfife.Mechanism:
    """A rope of rubber that falls and is stretched to several times its length."""
    m = vfife.load_model(Path(__file__).parents[2] / "examples" / "elastic_pendulum.toml")
    return dataclasses.replace(
        m, bodies={"rod": dataclasses.replace(m.bodies["rod"], strain=strain, stiffness_factor=young)}
    )


@pytest.mark.parametrize(("strain", "asks"), [("current", False), ("reference", True)])
def test_a_floor_that_is_the_methods_own_asks_for_no_smaller_step(strain: str, asks: bool) -> None:
    """Moments of elements of the present length belong to no energy; with the reference length the ledger
    closes as the square of the step.
    """
    model, options = rubber(strain, 1e-2), {"duration": 0.3, "reference": False, "outputs": 15}
    (said,) = (
        one for one in vfife.simulate(model, step=0.02, **options).summary["warnings"] if "ledger" in one
    )
    assert ("smaller step" in said) == asks and ("more elements" in said) != asks
    stopped = vfife.simulate(with_settings(model, energy_limit=1e-3), step=0.02, **options)
    assert stopped.record.status == "energy"
    assert ("smaller step" in energy_cause(stopped)) == asks and (
        "more elements" in energy_cause(stopped)
    ) != asks
    coarse, fine = (vfife.simulate(model, step=step, **options).ledger.error for step in (0.005, 0.00125))
    assert (coarse / fine == pytest.approx(16.0, rel=0.02)) == asks and (fine > 0.5 * coarse) != asks


def test_no_step_is_halved_for_a_floor_that_none_lowers() -> None:
    """Where moments belong to no energy the ledger does not set an automatic step; elsewhere it does."""
    runs = []
    for strain in ("current", "reference"):
        model = with_settings(rubber(strain, 1e-2), energy_limit=1e-3, tolerance=1.0)
        record = vfife.simulate(model, step=0.02, duration=0.3, outputs=15, reference=False).record
        choice = dataclasses.replace(record.assembly.choice, automatic=True)
        runs.append(dataclasses.replace(record, assembly=dataclasses.replace(record.assembly, choice=choice)))
    assert [finer(record) is not None for record in runs] == [False, True]
