"""The dataset of a result, its files, its summary and its figures."""

import json
import math
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from rich.console import Console

from support import CRANK_SPEED, SQUARE, four_bar, go, journal_in_bearing
from vfife.errors import RunFileError, VfifeError
from vfife.report.summary import run_summary, show
from vfife.simulation.result import Result
from vfife.simulation.simulate import prepare, simulate
from vfife.solvers.arguments import RunArguments
from vfife.store.runfile import RunFile


@pytest.fixture(scope="module")
def result() -> Result:
    return simulate(four_bar(), turns=2.0, step=2e-6)


@pytest.fixture(scope="module")
def elastic() -> Result:
    return Result(go(four_bar(model="elastic", section=SQUARE, elements=3), 1e-6, turns=0.25))


def test_every_series_has_a_unit_and_a_name(result: Result, elastic: Result) -> None:
    for data in (result.data, elastic.data):
        for name, variable in data.variables.items():
            if variable.dtype.kind != "U":
                assert variable.attrs["units"], name
                assert variable.attrs["long_name"], name
    assert set(elastic.data.element.values) == {
        f"{link}.{k}" for link in ("coupler", "follower") for k in range(3)
    }
    assert list(elastic.data.particle.values[:2]) == ["crank", "coupler.0"]


@pytest.mark.parametrize("turns", [0.02, 1.0])
def test_the_reference_at_constant_speed_is_one_turn_however_short_the_run(turns: float) -> None:
    turn = 2.0 * math.pi / CRANK_SPEED
    arguments = RunArguments(turns=turns, step=2e-6, companions=0)
    begun = prepare(four_bar(), arguments)
    assert begun.assembly.choice.steps * begun.assembly.choice.step == pytest.approx(turns * turn)
    assert begun.reference is not None
    assert begun.reference.time[-1] == pytest.approx(turn)
    assert prepare(four_bar(), arguments, reference=False).reference is None


def test_crank_angle(result: Result) -> None:
    angle = result.data.crank_angle.values
    assert angle[[0, -1]] == pytest.approx([0.0, 0.0]) and angle.min() >= 0.0 and angle.max() < 360.0
    assert result.crank_rotation[-1] == pytest.approx(720.0)


def test_newton_holds_for_the_joint_forces(result: Result) -> None:
    """m a of a body is what its joints press on it: force on the journal, its opposite on the bearing."""
    data = result.data
    for body, plus, minus in (("coupler", "B", "C"), ("crank", "A", "B"), ("follower", "C", "D")):
        mass = result.record.assembly.bodies[body].mass
        for axis in "xy":
            force = data[f"joint_force_{axis}"]
            pressed = force.sel(joint=plus) + (-1.0 if body != "follower" else 1.0) * force.sel(joint=minus)
            if body == "crank":
                ma = -mass * (50.0 * math.pi) ** 2 * data[f"body_{axis}"].sel(body=body)
            else:
                ma = mass * data[f"particle_a{axis}"].sel(particle=body)
            assert pressed.values == pytest.approx(ma.values, abs=1e-9 * float(abs(force).max()))


def test_sizes_agree(result: Result) -> None:
    data = result.data
    size = np.hypot(data.normal_force, data.friction_force)
    assert data.joint_force.sel(joint=list("BCD")).values == pytest.approx(size.values, rel=1e-12)
    away = np.hypot(data.eccentricity_x, data.eccentricity_y).values - 2e-4
    assert data.penetration.values == pytest.approx(away, abs=1e-15)
    assert (data.joint_force_max[1:] >= data.joint_force[1:] * (1.0 - 1e-12)).all()


def test_modes_are_those_of_the_samples_and_onsets(result: Result) -> None:
    data = result.data
    began = data.impacts.diff("time") > 0
    assert ((data.mode[1:] == 1) == began).all()
    assert set(np.unique(data.mode)) == {0, 1, 2}
    assert (data.penetration.values[data.mode.values == 2] > 0.0).all()


@pytest.mark.parametrize("damping", [0.0, 50.0])
def test_velocities_are_those_at_the_output(damping: float) -> None:
    """With an output at every step, the central difference of the positions is the velocity, for links and
    their chords.
    """
    from support import with_settings

    m = with_settings(four_bar(clear="", model="elastic", section=SQUARE, elements=2), damping=damping)
    done = Result(go(m, 1e-6, turns=0.005, outputs=40000))
    data, dt = done.data, 1e-6
    assert len(data.time) == 201
    for place, rate, size in (
        ("particle_x", "particle_u", 50.0),
        ("body_angle", "body_angular_velocity", 200.0),
    ):
        central = (data[place][2:].values - data[place][:-2].values) / (2.0 * dt)
        assert data[rate][1:-1].values == pytest.approx(central, abs=1e-5 * size)
    first = data.particle_v.sel(particle="coupler.1").values[:3]
    assert first[0] == pytest.approx(2.0 * first[1] - first[2], abs=1e-4)


def test_centre_of_mass_of_an_elastic_link(elastic: Result) -> None:
    data = elastic.data
    x = [data.particle_x.sel(particle=f"coupler.{k}") for k in range(4)]
    middle = (0.5 * x[0] + x[1] + x[2] + 0.5 * x[3]) / 3.0
    assert float(abs(data.body_x.sel(body="coupler") - middle).max()) < 1e-15


def test_netcdf_gives_it_back(result: Result, tmp_path: Path) -> None:
    import xarray

    result.to_netcdf(tmp_path / "out.nc")
    with xarray.open_dataset(tmp_path / "out.nc", engine="h5netcdf") as data:
        assert data.identical(result.data)
        assert "Lankarani" in data.attrs["laws"]


def test_a_run_file_gives_it_back_to_the_bit(result: Result, tmp_path: Path) -> None:
    result.save(tmp_path / "run.sqlite")
    for given in (tmp_path, tmp_path / "run.sqlite"):
        again = Result.load(given)
        assert again.data.identical(result.data)
        assert again.measures == result.measures
        assert again.summary == result.summary
    result.save(tmp_path / "run.sqlite")
    assert [path.name for path in tmp_path.iterdir()] == ["run.sqlite"]


def test_a_law_that_is_not_there_is_told(result: Result, tmp_path: Path) -> None:
    result.save(tmp_path / "run.sqlite")
    with RunFile.write(tmp_path / "run.sqlite") as file:
        file.put({"model": file.meta["model"].replace("lankarani-nikravesh", "mine")})
    with pytest.raises(RunFileError, match="law of your own"):
        Result.load(tmp_path)


def test_summary_is_for_scripts(result: Result) -> None:
    told = run_summary(result)
    assert json.loads(json.dumps(told, allow_nan=False)) == told
    assert {"status", "step", "steps", "wall_s", "ns_per_step", "energy_error", "measures"} <= set(told)
    assert told["steps"] == 40000
    assert told["joints"]["C"]["ideal_force.max"] == pytest.approx(65338.1, rel=1e-3)
    assert told["lip"]["C.force"] == told["measures"]["C.force.lip"]
    assert told["laws"]["C"]["contact"]["derived"]["stiffness"] == "6.6e+10"
    (warning,) = told["warnings"]  # the paper's forces press these journals in by more than their clearance
    assert (
        warning.startswith("Beyond what joints are built for")
        and "are more than a clearance of 200 µm" in warning
    )
    assert told["remarks"] == [
        "B, C, D: impacts of up to 2.69 m/s, the law being quasi-static up to 51.5 mm/s, as usual in machines"
    ]


def test_summary_is_for_people(result: Result) -> None:
    console = Console(width=120, record=True, file=open("/dev/null", "w"))  # noqa: SIM115
    show(console, result)
    text = console.export_text()
    for part in (
        "four-bar",
        "crank: rigid, driven",
        "40,000 steps of 2 µs",
        "ledger closes to",
        "LIP(F)",
        "LIP(a)",
    ):
        assert part in text


def test_deep_landings_are_a_warning_with_a_remedy() -> None:
    coarse = Result(go(journal_in_bearing(landing_depth=1e-9), 1.3e-6, duration=1e-3))
    assert coarse.summary["joints"]["J"]["deep_landings"] == 1.0
    (warning,) = coarse.summary["warnings"]
    assert "Joint J: 1 of 1 first contacts landed deeper than 0.001 µm" in warning
    assert "halve the step (6.5e-07 s)" in warning


def test_repr_says_what_there_is(result: Result) -> None:
    assert repr(result).startswith("<Result of 'four-bar': complete, 2 turns, 40000 steps of 2e-06 s")
    assert result.step == 2e-6
    assert repr(result.record).startswith("<Record of 'four-bar': complete, ")
    assert repr(result.record.assembly).startswith("<Assembly of 'four-bar': ")
    shown = (result.record, result.record.assembly, result.around(), result.spectrum("C.force"))
    assert max(len(repr(value)) for value in shown) < 400


@pytest.mark.system("draws every figure of a run")
def test_figures(result: Result, elastic: Result, tmp_path: Path) -> None:
    from vfife.plots import save

    figures = result.plot()
    assert list(figures) == ["mechanism", "orbits", "forces", "moments", "accelerations"]
    lines = {line.get_label(): line for line in figures["accelerations"].axes[1].lines}
    angle, ideal = lines["ideal joints"].get_data()
    assert [angle.min(), angle.max()] == pytest.approx([0.0, 360.0], abs=0.6)
    assert np.nanmax(np.abs(ideal)) == pytest.approx(22.816, rel=1e-3)  # 10^3 rad/s^2
    assert all(path.stat().st_size > 10000 for path in save(figures, tmp_path / "figures"))
    assert set(elastic.plot()) == set(figures)


def test_figures_without_a_crank() -> None:
    result = Result(go(journal_in_bearing(), 1e-6, duration=1e-3))
    assert list(result.plot()) == ["mechanism", "orbits", "forces"]
    assert list(result.plot("orbits", "forces", "mechanism")) == ["mechanism", "orbits", "forces"]
    with pytest.raises(VfifeError, match='there is no figure "orbit": did you mean "orbits"'):
        result.plot("orbit")


@pytest.mark.system("starts a process")
def test_numbers_and_files_load_neither_xarray_nor_matplotlib(result: Result, tmp_path: Path) -> None:
    result.save(tmp_path / "run.sqlite")
    code = (
        "import sys; from vfife.simulation.result import Result; from vfife.report.summary import "
        "run_summary\n"
        f"result = Result.load({str(tmp_path)!r}); run_summary(result); result.measures; result.channels\n"
        "print(sorted({'xarray', 'matplotlib', 'numba', 'pandas', 'scipy'} & set(sys.modules)))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"
