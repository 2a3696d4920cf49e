"""Forecasts count the work that is then done; too much of it has to be confirmed; what Ctrl-C leaves is
handed over.
"""

from __future__ import annotations

import dataclasses
import math
import time
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from typer.testing import CliRunner

import vfife
from identification.test_identification import BOUNDS, QUICK, oscillator, swing, written
from studies.studies import BASE, Closed
from tribology.test_wear import GIVEN, loose_pin
from vfife import gallery
from vfife.assembly.assemble import assemble
from vfife.cli.app import app
from vfife.cli.commands.compare import FIGURES, ComparisonJob
from vfife.cli.job import CommandJob
from vfife.errors import ModelError
from vfife.job import cost
from vfife.job.cost import CHUNK_STEPS, START, Forecast, Stream, cores, timed_step
from vfife.job.job import Job, job_of
from vfife.modelfile.parameter import numbers
from vfife.simulation.simulate import prepare, run_prepared
from vfife.solvers import transient
from vfife.solvers.arguments import RunArguments
from vfife.solvers.status import Progress
from vfife.store.runfile import RunFile
from vfife.studies import forecast
from vfife.studies.engine import study_engine
from vfife.studies.methods import derivatives
from vfife.studies.methods.derivable import matching
from vfife.studies.methods.derivatives import without_points
from vfife.tribology.simulate_wear import WearSimulation

PLAY = {"play": {"path": "joint.C.clearance", "fit": "H8/f7", "diameter": "20 mm"}}
FITS: dict[str, Any] = {
    "cost": {"play": {"IT6": 9, "IT7": 5, "IT8": 3, "IT9": 2}},
    "limit": {"C.force.max": "0.34 N"},
}
BY = 3.0  # factor between a forecast and the work that is done


class Recorder(Job):
    """Keeps the forecast of a job, and its last progress."""

    forecast: Forecast
    last: Progress

    def __init__(self) -> None:
        super().__init__("test", None, True, lambda progress: setattr(self, "last", progress))

    def begin(self, forecast: Forecast) -> None:
        self.forecast = forecast


@pytest.fixture
def closed(monkeypatch: pytest.MonkeyPatch) -> Closed:
    found = Closed()
    monkeypatch.setattr(study_engine, "run_cases", found)
    monkeypatch.setattr(forecast, "WORTH", math.inf)  # no case is run for a forecast
    return found


def test_cases_of_a_study_and_of_what_was_added_to_it(closed: Closed, tmp_path: Path) -> None:
    model, job = vfife.load_model(BASE), Recorder()
    vary: dict[str, Any] = {"joint.C.clearance": ["0.1 mm", "0.2 mm"]}
    vfife.study(model, vary, "C.force.max", turns=2, file=tmp_path / "s.study", progress=job)
    assert job.forecast.count == len(closed.computed) == 2 and job.last.done == job.last.steps == 2
    vary["joint.C.clearance"].append("0.3 mm")
    vfife.study(model, vary, "C.force.max", turns=2, file=tmp_path / "s.study", progress=job, force=True)
    assert job.forecast.count == 3 and job.forecast.done == 0
    vfife.study(model, vary, "C.force.max", turns=2, file=tmp_path / "s.study", progress=job)
    assert (job.forecast.count, job.forecast.done) == (0, 3) and "nothing is left" in job.forecast.remarks[0]


def test_machines_of_an_allocation(closed: Closed) -> None:
    job = Recorder()
    vfife.studies.allocate(
        vfife.load_model(BASE),
        PLAY,
        "C.force.max",
        turns=2,
        allocation={"measure": "C.force.max", "share": 0.9},
        progress=job,
        **FITS,
    )
    assert 1.0 / BY < job.forecast.count / len(closed.computed) < BY, (
        job.forecast.count,
        len(closed.computed),
    )


def test_runs_of_a_fit(tmp_path: Path) -> None:
    t, job = np.linspace(0.0, 1.0, 120), Recorder()
    vfife.fit(oscillator(), written(tmp_path / "s.csv", t, swing(t)), BOUNDS, progress=job, **QUICK)  # type: ignore[arg-type]
    made = int(job.last.text.split()[0])
    assert 1.0 / BY < job.forecast.count / made < BY, (job.forecast.count, made)


def test_blocks_of_wear() -> None:
    job = Recorder()
    found = vfife.wear(loose_pin(), 4e6, progress=job, **GIVEN)
    blocks = found.simulated / (GIVEN["block"] + GIVEN["settle"])
    assert 1.0 / BY < job.forecast.count / blocks < BY, (job.forecast.count, blocks)
    assert job.last.done == job.last.steps == 4e6


def test_a_run_is_forecast_with_its_file_and_its_measures(tmp_path: Path) -> None:
    """Ranges of companions take several times as long as the steps of a short step loop; a forecast without
    them was less than a half of the work.
    """
    job, mechanism = Recorder(), gallery.piston_slap()
    prepared = prepare(mechanism, RunArguments(turns=20.0, step=1.5e-6), False, job=job)
    stepping = cost.run_cost(prepared.assembly, companions=prepared.companions)
    assert prepared.companions and stepping.measuring > stepping.seconds
    assert job.forecast.seconds == pytest.approx(stepping.seconds + stepping.measuring, rel=0.5)
    began = time.process_time()
    with RunFile.create(tmp_path / "run.sqlite", prepared.run_meta) as file:
        run_prepared(prepared, file=file).finish(file)
    taken = time.process_time() - began
    assert taken > 2.0 * stepping.seconds
    assert 1.0 / BY < job.forecast.seconds / taken < BY, (job.forecast.seconds, taken)
    alone = cost.run_cost(prepared.assembly)
    assert 0.0 < alone.measuring < stepping.measuring


@pytest.mark.parametrize("name", ["four_bar_case_c", "slider_crank_loose_pin", "quick_return"])
def test_a_run_file_lies_below_the_upper_end_of_its_forecast(name: str, tmp_path: Path) -> None:
    """Case c halves its step; the last has no contact, so no companions either."""
    forecasts: list[Forecast] = []

    class Record(Job):
        def begin(self, forecast: Forecast) -> None:
            forecasts.append(forecast)

    job, path = Record("test", None, True, lambda progress: None), tmp_path / "run.sqlite"
    machine = vfife.load_model(Path(__file__).parents[2] / "examples" / f"{name}.toml")
    vfife.simulate(machine, file=path, progress=job)
    (needed,) = (forecast for forecast in forecasts if forecast.disk)
    assert path.stat().st_size < needed.most_disk <= 2.0 * needed.disk
    low, _, high = needed.disk_words.partition(" to ")
    assert f", {low} to {high} in {path}" in needed.sentence(path) and low != high


@pytest.mark.parametrize(
    ("factors", "halved"), [("[0, 1, 0, -1, 0, 1]", False), ("[1, 1, 1, 1, 1, 1]", True)]
)
def test_a_smooth_run_whose_automatic_step_may_be_halved_tells_what_that_costs(
    factors: str, halved: bool
) -> None:
    """A force that is there at once sends waves through the frame, which the first step does not resolve."""
    path = Path(vfife.__file__).parent / "modelfile" / "templates" / "frame.toml"
    model, begun = vfife.load_model(path, set=[("load.push.factors", factors), ("run.duration", "2 s")]), []

    class Record(Job):
        def begin(self, forecast: Forecast) -> None:
            begun.append((forecast, time.process_time()))

    result = vfife.simulate(model, progress=Record("test", None, True, lambda progress: None))
    taken = time.process_time() - begun[0][1]
    needed, assembly = begun[0][0], result.record.assembly
    price = cost.run_cost(assemble(model, assembly.choice.step), refined=True)
    assert price.halved == 0.0, "a step that is given stays"
    assert needed.spread is not None and "if the step is halved three times" in needed.note
    tried = len(assembly.choice.tried)
    assert (tried > 1) == halved
    price = cost.run_cost(assemble(model), refined=True)
    assert price.spread is not None and price.halvings == "three times"
    assert price.spread[0] <= taken <= (price.halved if halved else price.spread[1])
    assert price.halved == pytest.approx(cost.SMOOTH_TRIES * price.spread[1], rel=0.2)


def between_stops() -> vfife.Mechanism:
    """A mass on a spring between two stops, whose outputs compress to an eighth."""
    m = vfife.Mechanism("mass between stops")
    mass = m.rigid_body("mass", mass=1.0, inertia=1e-4)
    m.slider("rail", m.point("O", 0.0, 0.0), mass.pin())
    m.spring("spring", m.point("W", -0.3, 0.0), mass.pin(), stiffness=1000.0, damping=2.0, free_length=0.3)
    law = {"law": "kelvin-voigt", "stiffness": 1e5, "damping_coefficient": 20.0}
    for name, side in (("right", 1.0), ("left", -1.0)):
        m.external_contact(
            name, m.point(name, side * 0.015, 0.0), mass.pin(), journal_radius=0.01, direction=(0.0, side),
            contact=law, friction="none",
        )  # fmt: skip
    rotor = m.rigid_body("rotor", mass=0.1, inertia=1e-4, position=(0.5, 0.0))
    m.revolute("shaft", m.point("Q", 0.5, 0.0), rotor.pin())
    m.drive(rotor, speed=32.0)
    m.force(
        "drive", mass.pin(), force=(10.0, 0.0), crank="rotor", expression="cos(angle)", angles=[0, "360 deg"]
    )
    return m


@pytest.mark.parametrize(
    ("make", "turns", "companions"),
    [(between_stops, 300, 0), (gallery.slider_crank_loose_pin, 120, 0), (gallery.four_bar, 60, 3)],
)
def test_a_long_run_lies_between_the_ends_of_its_forecast(
    make: Callable[[], vfife.Mechanism], turns: int, companions: int, tmp_path: Path
) -> None:
    """The first took 266 MB where "1.18 GB to 1.41 GB" were forecast, and 27 s where it was "1 min 01 s"."""
    begun: list[tuple[Forecast, float]] = []

    class Record(Job):
        def begin(self, forecast: Forecast) -> None:
            begun.append((forecast, time.process_time()))

    job, path = Record("test", None, True, lambda progress: None), tmp_path / "run.sqlite"
    vfife.simulate(make(), turns=turns, companions=companions, file=path, progress=job)
    (needed, began) = begun[-1]
    taken = time.process_time() - began
    assert needed.spread is not None
    low, high = needed.spread
    halved = float(needed.note != "") * cost.MOST_TRIES
    assert low <= taken <= max(high, halved * high), (needed.spread, taken)
    assert high <= 5.0 * low, "a range that says something"
    assert needed.disk <= path.stat().st_size <= needed.most_disk, (needed.disk_words, path.stat().st_size)
    assert needed.most_disk <= (4.0 if companions else 2.0) * needed.disk
    assert (
        f": {needed.time_words} on an idle machine" in needed.sentence(path) and " to " in needed.time_words
    )


def test_wear_is_forecast_before_its_first_block(monkeypatch: pytest.MonkeyPatch) -> None:
    """From turns of a runner of its own: what is then simulated has the bits that it has without them. Turns
    with wear are timed, because they take longer.
    """
    events = []
    rate = WearSimulation.rate

    def counted_rate(self: WearSimulation, depth: np.ndarray) -> np.ndarray:
        found = rate(self, depth)
        events.append((self.spec.settle, self.spec.block, found, depth))
        return found

    class Begun(Recorder):
        """Keeps when the forecast came."""

        def begin(self, forecast: Forecast) -> None:
            events.append(forecast)

    monkeypatch.setattr(WearSimulation, "rate", counted_rate)
    found = vfife.wear(loose_pin(), 1e5, progress=Begun(), **GIVEN)
    (settle, block, estimate, unworn), timed, forecast, (*turns, first, _), *others = events
    assert not unworn.any() and timed[:2] == (1, 1) and np.array_equal(timed[3] > 0.0, estimate > 0.0)
    assert (settle, block) == (1, 1) and tuple(turns) == (GIVEN["settle"], GIVEN["block"])
    assert isinstance(forecast, Forecast) and forecast.count > 0 and forecast.seconds > 0.0
    assert estimate.sum() == pytest.approx(first.sum(), rel=0.2)
    assert not [one for one in others if isinstance(one, Forecast)]  # no second line for the same number
    assert np.array_equal(found.rate[0], first)


def test_runs_of_a_comparison() -> None:
    job = Recorder()
    found = vfife.compare(vfife.load_model(BASE), ["pereira", "liu"], turns=0.05, progress=job)
    assert job.forecast.count == len(found.rows) == 2
    assert job.forecast.steps == sum(one.record.assembly.choice.steps for one in found.results) / 2


def test_a_comparison_is_forecast_with_halved_steps_and_measures(tmp_path: Path) -> None:
    """The steps of the first try, without measures, were a sixth of the work."""
    job, model = Recorder(), gallery.compressor()

    def compared(folder: Path) -> float:
        began = time.process_time()
        folder.mkdir()
        vfife.compare(model, ["hertz", "gonthier"], companions=3, turns=2, progress=job, folder=folder)
        return time.process_time() - began

    compared(tmp_path / "compiled")
    taken, ends = compared(tmp_path / "again"), job.forecast.ends
    assert ends is not None and ends[0] < job.forecast.seconds < ends[1]
    assert 1.0 / BY < job.forecast.seconds / taken < BY, (job.forecast.seconds, taken)
    assert "as the automatic step is halved or not" in job.forecast.note and job.forecast.threads == 1
    vfife.compare(model, ["hertz", "gonthier"], companions=3, turns=2, step=1e-6, progress=job)
    assert job.forecast.ends is None


def test_a_command_that_compares_forecasts_its_start_and_its_figures(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    told = list[Forecast]()
    monkeypatch.setattr(CommandJob, "begin", lambda self, forecast: told.append(forecast))
    for figures in (True, False):
        options = SimpleNamespace(figures=figures, quiet=True)
        ComparisonJob(tmp_path / "x", "", options).begin(Forecast("run", seconds=2.0))  # type: ignore[arg-type]
    assert [one.seconds for one in told] == pytest.approx([2.0 + START + FIGURES, 2.0 + START])


def test_a_step_is_timed_by_few_steps_however_far_apart_outputs_are(monkeypatch: pytest.MonkeyPatch) -> None:
    made, advance = list[int](), transient.run

    def counted(assembly: Any, **more: Any) -> Any:
        made.append(assembly.choice.steps)
        return advance(assembly, **more)

    monkeypatch.setattr(cost, "run", counted)
    long = assemble(vfife.load_model(BASE), turns=1e6, outputs=1)
    assert 1e-9 < timed_step(long) < 1e-4 and max(made) <= 2 * CHUNK_STEPS < long.choice.steps
    assert Stream(0.03, 0.1).seconds(100) == pytest.approx(100 * max(0.03, 0.13 / cores()))


LONG: dict[str, Callable[..., Any]] = {
    "simulate": lambda model, **more: vfife.simulate(model, turns=2e8, reference=False, **more),
    "study": lambda model, **more: vfife.study(
        model, {"joint.C.clearance": [1e-6 * k for k in range(1, 41)]}, "C.force.max", turns=10**6, **more
    ),
    "compare": lambda model, **more: vfife.compare(model, ["pereira"], turns=2e7, **more),
    "poincare_section": lambda model, **more: vfife.dynamics.poincare_section(
        model, turns=2 * 10**8, step=1e-5, **more
    ),
    "waterfall": lambda model, **more: vfife.dynamics.waterfall(
        model, "driver.crank.speed", 100.0, 200.0, turns=2 * 10**7, step=1e-5, **more
    ),
}


@pytest.mark.parametrize("name", LONG)
def test_hours_of_work_are_confirmed_in_python(name: str) -> None:
    with pytest.raises(
        ModelError, match=r"it takes about (\d+ h|[\d,]+ days).*Add confirm=True to confirm"
    ) as refused:
        LONG[name](vfife.load_model(BASE))
    assert str(refused.value).startswith(f"{name}()")


def test_a_job_hands_progress_to_the_call_of_a_script() -> None:
    heard = list[tuple[int, int]]()
    with job_of("study", None, False, print, lambda one: heard.append((one.done, one.steps))) as job:
        job.begin(Forecast("case", 3, 1000, 2.0))
        job.count(2, 3, "cases")
    assert heard == [(2, 3)] and job_of("study", None, False, job) is job
    with pytest.raises(ModelError, match="this cannot be called"):
        job_of("study", None, False, 5)
    with pytest.raises(ModelError, match="this is not a truth value"):
        job_of("study", None, 1, None)  # type: ignore[arg-type]
    much = dataclasses.replace(Forecast("case", 10**6, 1e6, 1e5), remedy="ask for fewer")
    with pytest.raises(ModelError, match="27 h 46 min"):
        Job("study", None, False, None).begin(much)
    Job("study", None, True, None).begin(much)


def test_a_search_that_is_interrupted_leaves_its_study(
    closed: Closed, monkeypatch: pytest.MonkeyPatch
) -> None:
    def broken(*args: Any, **named: Any) -> Any:
        for k, one in enumerate(closed(*args, **named)):
            if k == 5:
                raise KeyboardInterrupt
            yield one

    monkeypatch.setattr(study_engine, "run_cases", broken)
    with pytest.raises(vfife.Interrupted) as interrupted:
        vfife.studies.allocate(
            vfife.load_model(BASE),
            PLAY,
            "C.force.max",
            turns=2,
            allocation={"measure": "C.force.max", "share": 0.9},
            **FITS,
        )
    assert isinstance(interrupted.value, KeyboardInterrupt) and len(interrupted.value.result.outcomes) == 5


def test_derivatives_of_a_run_whose_step_was_halved_have_a_forecast_of_their_own(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """They take as many steps as the run in the end, and report each run."""
    forecasts, texts = list[Forecast](), list[str]()

    def halved(prepared: Any, progress: Any) -> Any:
        step = 0.5 * prepared.assembly.choice.step
        return run_prepared(prepare(model, RunArguments(turns=0.02, step=step)), progress=progress)

    monkeypatch.setattr(derivatives, "run_prepared", halved)

    class Both(Job):
        def begin(self, forecast: Forecast) -> None:
            forecasts.append(forecast)

    job = Both("test", None, True, lambda progress: texts.append(progress.text))
    model = vfife.gallery.compressor()
    vfife.sensitivity(model, ["*.force.max"], ["joint.big-end.clearance"], turns=0.02, progress=job)
    first, last = (int(one.work.split()[3].replace(",", "")) for one in forecasts)
    assert last == 2 * first
    assert texts[-1].startswith("24 of 24 runs")  # four step sizes: the derivative, the run, four changes


def test_derivatives_leave_points_of_tables_out_unless_they_are_named() -> None:
    model = vfife.gallery.compressor()
    chosen = without_points(numbers(model))
    assert "load.gas.bore" in chosen and "body.piston.position.0" in chosen and "gravity.0" in chosen
    assert not [path for path in chosen if path.startswith(("load.gas.pressure", "load.gas.travels"))]
    assert matching("to", ["load.gas.*"], numbers(model)).keys() > {"load.gas.pressure.3", "load.gas.bore"}


@pytest.mark.parametrize("name", ["williams_toggle", "lee_frame", "elastica_circle"])
def test_iterations_of_statics_are_forecast_within_their_order(name: str) -> None:
    """By the elements and the slenderness of the largest body; the sentence of ``vfife check`` says so."""
    path = Path(__file__).parents[2] / "examples" / f"{name}.toml"
    result = vfife.simulate(vfife.load_model(path), companions=0)
    made = result.measures["iterations"] / result.record.assembly.choice.outputs
    assert 0.15 < cost.expected_iterations(result.record.assembly) / made < 4.0
    said = " ".join(CliRunner().invoke(app, ["check", str(path)]).stdout.split())
    assert "a fifth or five times as long is possible" in said


def test_the_forecast_of_wear_has_the_time_of_worn_surfaces(monkeypatch: pytest.MonkeyPatch) -> None:
    """Turns without wear take less: their time was a third too short for a press with five pins."""
    from vfife.tribology import simulate_wear

    monkeypatch.setattr(simulate_wear, "timed", lambda work: (work(), 6.0)[1])
    monkeypatch.setattr(WearSimulation, "rate", lambda self, depth: np.full_like(depth, 1e-12))
    found = simulate_wear.wear_forecast(loose_pin(), 1e4, clearance=1.0)
    assert found.seconds == pytest.approx(3.0 * found.count * 8)


def test_the_second_forecast_of_sensitivities_lies_in_the_range_of_the_first(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """After a run whose automatic step was halved, derivatives take that step: nothing is halved again."""
    forecasts = list[cost.Forecast]()
    monkeypatch.setattr(Job, "begin", lambda self, forecast: forecasts.append(forecast))
    monkeypatch.setattr("vfife.studies.methods.derivatives.differentiate", lambda *of: of)
    vfife.sensitivity(gallery.slider_crank_loose_pin(), None, ["joint.*"], turns=1)
    first, second = forecasts
    assert first.ends is not None and second.ends is None and second.note == ""
    assert second.seconds < first.ends[1]
