"""Tolerances, indices, searches and allocations from Python tell what the commands of these names tell;
cases are of closed form.
"""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import pytest

import vfife
from fake_card import FakeDriver, in_this_machine
from studies.studies import BASE, Closed
from vfife.assembly.assemble import assemble
from vfife.errors import DeviceError
from vfife.studies import forecast
from vfife.studies.engine import study_engine
from vfife.studies.spec.distributions import of_fit

FIT = {"path": "joint.C.clearance", "fit": "H8/f7", "diameter": "20 mm"}
SPEED = {"path": "driver.crank.speed", "from": 100, "to": 200}
BOTH = ["C.force.max", "C.impacts"]


@pytest.fixture
def closed(monkeypatch: pytest.MonkeyPatch) -> Closed:
    """C.force.max = v² c, C.impacts = v, and v = 100 where the speed is not varied."""
    found = Closed()
    monkeypatch.setattr(study_engine, "run_cases", found)
    monkeypatch.setattr(forecast, "WORTH", math.inf)  # no case is run for a forecast
    return found


def test_a_tolerance_of_a_study_in_memory_and_of_its_file(closed: Closed, tmp_path: Path) -> None:
    """10⁴ c: the quantiles are those of the fit, and 5 % are beyond its 95 % quantile."""
    limit = {"C.force.max": 1e4 * float(of_fit("H8/f7", 0.02).quantile(0.95))}
    found = vfife.study(
        BASE, {"play": FIT}, BOTH, turns=2, method="random", count=400, file=tmp_path / "s.study"
    )
    force, impacts = vfife.studies.tolerance(found, limit, quantiles=(0.5,))
    assert (
        force.failing is not None
        and force.failing.low <= 0.05 <= force.failing.high
        and impacts.failing is None
    )
    assert (
        force.quantiles[0.5].low
        <= 1e4 * float(of_fit("H8/f7", 0.02).quantile(0.5))
        <= force.quantiles[0.5].high
    )
    assert vfife.studies.tolerance(tmp_path / "s.study", limit, quantiles=(0.5,)) == [force, impacts]
    with pytest.raises(vfife.VfifeError, match="a limit of a measure that is not listed"):
        vfife.studies.tolerance(found, {"D.force.max": 1.0})
    with pytest.raises(ValueError, match="write 99 % as 0.99"):
        vfife.studies.tolerance(found, quantiles=(99.0,))


def test_indices_of_a_number_that_one_parameter_makes(closed: Closed) -> None:
    """C.impacts is the speed alone: all of its variance, and none of it is the clearance's."""
    pytest.importorskip("SALib")
    found = vfife.study(BASE, {"play": FIT, "speed": SPEED}, BOTH, turns=2, method="saltelli", count=64)
    (one,) = vfife.studies.indices(found, "C.impacts")
    assert {row.parameter: row.total for row in one.rows} == {
        "play": 0.0,
        "speed": pytest.approx(1.0, abs=0.15),
    }
    answer = vfife.studies.indices(found)
    frame = answer.to_dataframe()
    assert frame.loc[("C.impacts", "speed"), "total"] == one.rows[1].total and len(frame) == 2 * len(answer)
    text = " ".join(str(answer).split())
    assert "with others" in text and "64 groups are few" in text and "take count = 256 or more" in text
    assert "with others" in answer._repr_html_()
    with pytest.raises(vfife.VfifeError, match="no measure"):
        vfife.studies.indices(found, "C.impact")


def test_an_optimum_is_on_its_limit_and_nothing_is_computed_twice(closed: Closed, tmp_path: Path) -> None:
    """The least of v² c with v ≥ 150 is 150² · 0.1 mm."""
    pytest.importorskip("optuna")
    vary = {"speed": SPEED, "play": {"path": "joint.C.clearance", "values": [1e-4, 2e-4]}}
    asked: dict[str, Any] = {
        "optimise": {"minimise": ["C.force.max"], "cases": 48},
        "limit": {"C.impacts": {"low": 150}},
    }
    heard: list[int] = []
    found = vfife.optimise(
        BASE, vary, BOTH, turns=2, file=tmp_path / "s.study", progress=heard.append, **asked
    )
    (best,) = found.best
    assert best.parameters["play"] == 1e-4 and 149.5 <= float(best.parameters["speed"]) < 160
    assert best.values is not None and best.values["C.force.max"] == pytest.approx(
        1e-4 * float(best.parameters["speed"]) ** 2
    )
    assert len(found.cases) == 48 and len(found.study.done) == len(closed.computed) == heard[-1]
    vfife.optimise(BASE, vary, BOTH, turns=2, file=tmp_path / "s.study", **asked)
    assert len(closed.computed) == heard[-1]
    with pytest.raises(vfife.VfifeError, match="it is not measured"):
        vfife.optimise(BASE, vary, "C.impacts", optimise={"minimise": ["C.force.max"]})


def test_cases_of_a_search_run_on_a_card(tmp_path: Path) -> None:
    """Where there is one they are what they are on the processor, to the bit; where there is none that is
    told, and nothing is begun.
    """
    pytest.importorskip("optuna")
    asked: dict[str, Any] = {
        "turns": 1,
        "step": 8e-6,
        "optimise": {"minimise": ["C.force.max"], "cases": 4, "batch": 4, "refine": 0},
    }
    asked |= {
        "model": vfife.load_model(BASE),
        "vary": {"play": {"path": "joint.C.clearance", "from": 1e-4, "to": 3e-4}},
        "measures": ["C.force.max"],
    }
    with (
        in_this_machine(FakeDriver(None, cuInit=100)),
        pytest.raises(DeviceError, match="the driver sees no card"),
    ):
        vfife.optimise(**asked, file=tmp_path / "s.study", device="cuda")
    with pytest.raises(ValueError, match="cluster local and device cuda exclude each other"):
        vfife.optimise(**asked, file=tmp_path / "s.study", device="cuda", cluster="local")
    assert not list(tmp_path.iterdir())
    with in_this_machine(
        FakeDriver(assemble(asked["model"], 8e-6, turns=1.0, force_step=True).topology)
    ) as driver:
        found = vfife.optimise(**asked, device="cuda")
    assert driver.threads and not driver.given
    own = vfife.optimise(**asked)
    assert [one.values for one in found.cases] == [one.values for one in own.cases] and len(found.cases) == 4


def test_the_cheapest_fit_that_keeps_a_limit(closed: Closed) -> None:
    """The 99 % quantile of 10⁴ c is 0.309 N with H8/f7 and 0.347 N with the next cheaper fit."""
    found = vfife.studies.allocate(
        vfife.load_model(BASE), {"play": FIT}, "C.force.max", turns=2, limit={"C.force.max": "0.34 N"},
        cost={"play": {"IT6": 9, "IT7": 5, "IT8": 3, "IT9": 2}},
        allocation={"measure": "C.force.max", "count": 473},
    )  # fmt: skip
    assert (found.fits, found.cost, found.machines) == ({"play": "H8/f7"}, 8.0, 473)
    assert [fits["play"] for fits, _ in found.rejected] == ["H9/f9", "H9/f8", "H8/f8"]
    assert found.quantile is not None and found.quantile.value <= 0.34 and math.isfinite(found.quantile.low)
    with pytest.raises(vfife.VfifeError, match="this table is missing"):
        vfife.studies.allocate(BASE, {"play": FIT}, "C.force.max")


def test_ctrl_c_ends_a_search_and_keeps_what_ended(
    closed: Closed, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    pytest.importorskip("optuna")
    (tmp_path / "s.toml").write_text(
        f'model = "{BASE.as_posix()}"\nmeasures = ["C.force.max"]\nturns = 2\n[vary.play]\npath ='
        ' "joint.C.clearance"\nfrom = 1e-4\nto = 2e-4\n[optimise]\nminimise = ["C.force.max"]\ncases ='
        " 32\nrefine = 0\n"
    )

    def broken(*words: Any, **more: Any) -> Any:
        if len(closed.computed) >= 16:
            raise KeyboardInterrupt
        yield from closed(*words, **more)

    monkeypatch.setattr(study_engine, "run_cases", broken)
    with pytest.raises(KeyboardInterrupt):
        vfife.optimise(tmp_path / "s.toml", file=tmp_path / "s.study")
    monkeypatch.setattr(study_engine, "run_cases", closed)
    assert len(vfife.studies.load_study(tmp_path / "s.study").done) == 16
    assert (
        len(vfife.optimise(tmp_path / "s.toml", file=tmp_path / "s.study").cases)
        == 32
        == len(closed.computed)
    )
