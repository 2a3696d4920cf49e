"""Runs of hours or of most of the memory are refused in Python as on the command line, before anything is
stepped.
"""

from pathlib import Path

import pytest

import vfife
from vfife.assembly.assemble import assemble
from vfife.errors import ModelError
from vfife.job.cost import run_cost
from vfife.simulation import simulate as simulation

CASE = Path(__file__).parents[2] / "examples" / "four_bar_case_c.toml"


def never(*args, **named):
    raise AssertionError("it was stepped")


def test_a_run_of_hours_is_refused_unless_it_is_meant(monkeypatch):
    """Two hours of a four-bar took 24 GB until the system killed the process."""
    monkeypatch.setattr(simulation, "run", never)
    monkeypatch.setattr("vfife.files.free_bytes", lambda place: 10**10)
    model = vfife.load_model(CASE)
    with pytest.raises(ModelError, match=r"takes about .* GB on a disk that has .*confirm=True"):
        vfife.simulate(model, duration="2 h", reference=False)
    with pytest.raises(AssertionError, match="it was stepped"):
        vfife.simulate(model, duration="2 h", reference=False, confirm=True)


def test_rows_that_memory_cannot_hold_lie_on_the_disk(monkeypatch, tmp_path):
    """Outputs of a run without a file count as bytes on the disk where they are many."""
    monkeypatch.setattr(simulation, "run", never)
    monkeypatch.setattr("vfife.job.cost.physical_memory", lambda: 10**9)
    model, options = (
        vfife.load_model(CASE),
        {"turns": 2, "outputs": 1_000_000, "step": "20 ns", "reference": False},
    )
    with pytest.raises(AssertionError, match="it was stepped"):
        vfife.simulate(model, **options)
    monkeypatch.setattr("vfife.files.free_bytes", lambda place: 10**9)
    with pytest.raises(ModelError, match="on a disk that has 1 GB left"):
        vfife.simulate(model, **options)


def test_an_ideal_reference_that_takes_hours_is_refused_before_it_is_run(monkeypatch):
    monkeypatch.setattr(simulation, "run", never)
    monkeypatch.setattr("vfife.job.cost.LONG", 1e-9)
    monkeypatch.setattr(simulation, "BRIEF", 0.0)
    with pytest.raises(ModelError, match="confirm=True"):
        vfife.simulate(vfife.load_model(CASE), turns=1)


def test_a_smooth_run_counts_what_repeats_it(monkeypatch):
    """Its estimate takes four times as long as the run itself."""
    monkeypatch.setattr(simulation, "run", never)
    model = vfife.load_model(CASE.with_name("four_bar_ideal.toml"))
    cost = run_cost(assemble(model, turns=1.0))
    monkeypatch.setattr("vfife.job.cost.LONG", 2.0 * cost.seconds + cost.measuring)
    with pytest.raises(ModelError, match="confirm=True"):
        vfife.simulate(model, turns=1, reference=False)
    with pytest.raises(AssertionError, match="it was stepped"):
        vfife.simulate(model, turns=1, reference=False, companions=0)
