"""Identification: numbers of closed forms come back from noisy curves, errors are those of theory, and what
data cannot tell is told.
"""

import dataclasses
import json
import math
import shutil

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from typer.testing import CliRunner

import vfife
from rigs import EXAMPLES, synthetic
from vfife import Mechanism
from vfife.cli.app import app
from vfife.errors import ModelError, VfifeError
from vfife.identification.batched_queries import Evaluations, Query
from vfife.identification.fit_task import FitTask, plan_fit
from vfife.identification.lawfit import fit_law
from vfife.identification.other_minima import CONCENTRATED, concentration
from vfife.identification.parameters import FitParameter
from vfife.identification.step_uncertainty import autocorrelation, confidence_of
from vfife.job.activity import ACTIVITY
from vfife.modelfile import dump
from vfife.results.fit import FitFile

MASS, STIFFNESS, DAMPING, REST = 2.0, 500.0, 5.0, 0.1
BOUNDS = {"spring.k.stiffness": ("200 N/m", "1000 N/m"), "spring.k.damping": (0.5, 20.0)}
QUICK = {"screened": 8, "starts": 1, "derivatives": "differences", "step": "1 ms"}


def oscillator(**spring: float) -> Mechanism:
    """A mass on a spring with a damper, let go 10 mm from its rest."""
    m = Mechanism("oscillator", gravity=(0.0, 0.0))
    m.point("O", 0.0, 0.0)
    m.point_mass("b", mass=MASS, position=(REST + 0.01, 0.0))
    m.spring(
        "k", "ground.O", "b.center", **{"stiffness": 800.0, "damping": 3.0, "free_length": REST, **spring}
    )
    return m


def swing(t: np.ndarray) -> np.ndarray:
    """Its place, in closed form."""
    d = 0.5 * DAMPING / MASS
    w = math.sqrt(STIFFNESS / MASS - d * d)
    return REST + 0.01 * np.exp(-d * t) * (np.cos(w * t) + d / w * np.sin(w * t))


def written(path, t, x, head="time (s), b.x (m)", noise=0.02, seed=1):
    """A file of measured values."""
    x = x + noise * x.std() * np.random.default_rng(seed).standard_normal(len(x))
    path.write_text(head + "\n" + "\n".join(f"{a:.9g}, {b:.9g}" for a, b in zip(t, x, strict=True)) + "\n")
    return path


@pytest.fixture(scope="module")
def found(tmp_path_factory):
    """A fit to a closed form with 2 % noise, through a trigger that came late, in millimetres and
    milliseconds.
    """
    t = np.linspace(0.0, 1.2, 240)
    path = written(
        tmp_path_factory.mktemp("fit") / "swing.csv", 1e3 * t, 1e3 * swing(t + 0.031), "time (ms), b.x [mm]"
    )
    return vfife.fit(oscillator(), path, BOUNDS, offset="0..60 ms", **QUICK)


def test_a_closed_form_comes_back(found):
    assert found["spring.k.stiffness"].value == pytest.approx(STIFFNESS, rel=5e-3)
    assert found["spring.k.damping"].value == pytest.approx(DAMPING, rel=2e-2)
    assert found.offset == pytest.approx(0.031, abs=2e-4) and found.status == "complete"
    assert found.share == pytest.approx(0.02, rel=0.15), "what is left is the noise"
    assert found.undetermined == [] and abs(found.autocorrelation) < 0.2


def test_its_errors_are_those_of_the_closed_form(found):
    """s^2 (J^T J)^-1 with J of the formula itself, the offset among its unknowns."""
    t = np.linspace(0.0, 1.2, 240)

    def form(k, c, late):
        d = 0.5 * c / MASS
        w = math.sqrt(k / MASS - d * d)
        return 0.01 * np.exp(-d * (t + late)) * (np.cos(w * (t + late)) + d / w * np.sin(w * (t + late)))

    at = np.array([STIFFNESS, DAMPING, 0.031])
    rows = [(form(*(at + h)) - form(*(at - h))) / (2.0 * h.sum()) for h in np.diag(1e-5 * at)]
    covariance = np.linalg.inv(np.array(rows) @ np.array(rows).T) * (0.02 * swing(t + 0.031).std()) ** 2
    errors = np.sqrt(np.diag(covariance))
    mine = [found["spring.k.stiffness"].error, found["spring.k.damping"].error, found.offset_error]
    assert mine == pytest.approx(errors.tolist(), rel=0.25), (
        "widened or not by what residuals happen to follow each other"
    )
    assert found.correlation[0, 1] == pytest.approx(covariance[0, 1] / errors[0] / errors[1], abs=0.1)
    one = found["spring.k.stiffness"]
    assert (
        one.high - one.value == pytest.approx(1.97 * one.error, rel=5e-3) and one.low < STIFFNESS < one.high
    )


def test_it_is_written_drawn_and_set(found, tmp_path):
    found.write_csv(tmp_path / "curves.csv")
    found.write_json(tmp_path / "fit.json")
    head = (tmp_path / "curves.csv").read_text().splitlines()[0]
    assert head == "time [s],b.x measured [m],b.x model [m]"
    told = json.loads((tmp_path / "fit.json").read_text())
    assert (
        told["parameters"][0]["paths"] == ["spring.k.stiffness"]
        and told["offset"]["unit"] == "s"
        and not math.isnan(told["residual"])
    )
    assert dict(found.set)["spring.k.damping"] == found["spring.k.damping"].value
    assert len(found.plot().axes) == 3 and "oscillator" in repr(found)
    with pytest.raises(KeyError, match="was not identified"):
        found["body.b.mass"]


def test_a_figure_draws_no_limits_of_an_unknown_confidence(found):
    unknown, known = dataclasses.replace(found.values[0], known=False), found.values[1]
    panel = dataclasses.replace(found, values=[unknown, known]).plot().axes[2]
    markers = [line for line in panel.lines if line.get_marker() == "o"]
    bars = [line.get_ydata()[0] for line in panel.lines if line.get_marker() != "o"]
    assert bars == [1] and [line.get_markerfacecolor() == "none" for line in markers] == [True, False]
    assert [text.get_text() for text in panel.texts] == ["not known"]


@pytest.mark.system("a fit of two numbers")
def test_what_acts_as_one_cannot_be_told_apart(tmp_path):
    """Two springs side by side: their sum is known, and what one has more the other has less."""
    m = oscillator(stiffness=300.0, damping=DAMPING)
    m.spring("k2", "ground.O", "b.center", stiffness=150.0, free_length=REST)
    t = np.linspace(0.0, 1.0, 150)
    path = written(tmp_path / "swing.csv", t, swing(t))
    found = vfife.fit(m, path, ["spring.k.stiffness=100..400", "spring.k2.stiffness=100..400"], **QUICK)
    assert sum(value for _, value in found.set) == pytest.approx(STIFFNESS, rel=5e-3)
    assert found.correlation[0, 1] < -0.99
    assert (
        len(found.undetermined) == 1
        and "up with spring.k" in found.undetermined[0]
        and "down" in found.undetermined[0]
    )
    assert not found["spring.k.stiffness"].determined


def test_a_number_without_influence_is_named(tmp_path):
    m = oscillator(stiffness=STIFFNESS)
    m.rigid_body("idle", mass=1.0, inertia=1e-3, position=(1.0, 0.0))
    t = np.linspace(0.0, 1.0, 150)
    found = vfife.fit(
        m,
        written(tmp_path / "swing.csv", t, swing(t)),
        {"spring.k.damping": (1, 9), "body.idle.mass": (0.5, 2)},
        **QUICK,
    )
    assert found["spring.k.damping"].value == pytest.approx(DAMPING, rel=3e-2)
    assert any(one.startswith("body.idle.mass:") for one in found.undetermined)


def test_a_number_that_changes_nothing_at_all_is_told_without_a_division_by_zero():
    """Nothing is known of it: an error beyond all bounds, no NaN, and no warning of numpy (warnings are
    errors here).
    """
    found = confidence_of(
        [np.sin(np.arange(40.0))],
        [FitParameter("a", ("a",), "kg", 1.0, 2.0)],
        np.array([0.5]),
        np.zeros((40, 1)),
        1,
        0.95,
    )
    assert (
        found.errors[0] > 1e6
        and np.isfinite(found.covariance).all()
        and found.correlation[0, 0] == pytest.approx(1.0)
    )


@pytest.mark.parametrize("noise, told", [(0.1, False), (0.5, True)])
def test_what_the_model_misses_is_told_where_it_is_much(tmp_path, noise, told):
    """Noise of half the deviation leaves 1/sqrt(5) of that of the file; the errors alone would look good."""
    t = np.linspace(0.0, 1.0, 150)
    path = written(tmp_path / "swing.csv", t, swing(t), noise=noise)
    found = vfife.fit(
        oscillator(stiffness=STIFFNESS), path, {"spring.k.damping": (1, 9)}, offset=0.0, **QUICK
    )
    assert found.share == pytest.approx(noise / math.hypot(1.0, noise), rel=0.15)
    assert (
        any(f"the model misses the data by {100.0 * found.share:.3g} %" in note for note in found.notes)
        is told
    )


def test_residuals_that_are_large_in_few_places_leave_confidence_unknown(tmp_path):
    """A swing with noise, which is known, and with three blows that the model does not have."""
    t = np.linspace(0.0, 1.0, 300)
    blows = sum(2.0 * np.exp(-(((t - at) / 0.01) ** 2)) for at in (0.2, 0.5, 0.8)) * np.ptp(swing(t)) / 4.0
    for added, known in ((0.0, True), (blows, False)):
        path = written(tmp_path / f"swing-{known}.csv", t, swing(t) + added, noise=0.02)
        found = vfife.fit(
            oscillator(stiffness=STIFFNESS), path, {"spring.k.damping": (1, 9)}, offset=0.0, **QUICK
        )
        assert found["spring.k.damping"].known is known
        assert any("more than noise" in note for note in found.notes) is not known


def test_noise_has_a_concentration_of_one():
    rng = np.random.default_rng(5)
    ratios = [concentration(rng.standard_normal(150)) for _ in range(2000)]
    assert np.mean(ratios) == pytest.approx(1.0, abs=0.02)
    assert max(ratios) < 1.0 + CONCENTRATED / math.sqrt(150.0)
    assert concentration(np.where(np.arange(400) % 20, 1.0, 30.0) * rng.standard_normal(400)) > 1.5


def test_a_microphone_is_only_proportional(tmp_path):
    """Factor and level are found with the rest: the acceleration x'' as volts of some sensor."""
    t = np.linspace(0.0, 1.0, 300)
    x = swing(t)
    volts = 0.4 - 3.0 * np.gradient(np.gradient(swing(np.linspace(-1e-2, 1.01, 10201)), 1e-4), 1e-4)
    path = written(
        tmp_path / "mic.csv", t, np.interp(t, np.linspace(-1e-2, 1.01, 10201), volts), "time, mic (V)"
    )
    found = vfife.fit(oscillator(), path, BOUNDS, columns={"mic": "~b.center.acceleration_x"}, **QUICK)
    assert found["spring.k.stiffness"].value == pytest.approx(STIFFNESS, rel=5e-3)
    assert (found.curves[0].factor, found.curves[0].level) == (
        pytest.approx(-3.0, rel=0.02),
        pytest.approx(0.4, abs=0.05),
    )
    assert float(np.ptp(x)) > 0.0


@pytest.mark.parametrize(("how", "close"), [("envelope", 0.05), ("spectrum", 0.02)])
def test_envelopes_and_spectra_are_compared(tmp_path, how, close):
    t = np.linspace(0.0, 1.5, 300)
    found = vfife.fit(
        oscillator(), written(tmp_path / "s.csv", t, swing(t)), BOUNDS, compare=how, width="0.3 s", **QUICK
    )
    assert found["spring.k.damping"].value == pytest.approx(DAMPING, rel=close) and found.compared == how
    found.write_csv(tmp_path / "curves.csv")
    head, *rows = (tmp_path / "curves.csv").read_text().splitlines()
    peak = found.curves[0].places[np.argmax(found.curves[0].measured)]
    if how == "envelope":
        assert head == "time [s],b.x measured [m],b.x model [m]" and float(
            rows[0].split(",")[0]
        ) == pytest.approx(0.15, abs=0.01)
    else:  # the line nearest to sqrt(k/m) / 2 pi, of those that lie 1/T apart
        assert head == "frequency [Hz],b.x measured [m],b.x model [m]"
        assert peak == pytest.approx(math.sqrt(STIFFNESS / MASS) / 2.0 / math.pi, abs=0.5 / 1.5)
    assert found.plot().axes[0].get_xlabel() == ("time (ms)" if how == "envelope" else "frequency (Hz)")


def test_ctrl_c_tells_the_best_so_far(tmp_path):
    t, seen = np.linspace(0.0, 1.0, 100), []

    def interrupt(progress):
        seen.append(progress)
        if len(seen) == 4:
            raise KeyboardInterrupt

    found = vfife.fit(
        oscillator(), written(tmp_path / "s.csv", t, swing(t)), BOUNDS, progress=interrupt, **QUICK
    )
    assert found.status == "interrupted" and found.evaluations < 60
    assert math.isnan(found["spring.k.damping"].error) and 0.5 <= found["spring.k.damping"].value <= 20.0


@pytest.mark.system("breaks a fit off several times")
def test_a_fit_goes_on_where_it_was_broken_off(tmp_path):
    """To the bit, wherever that was; what is asked anew has the points in common, and another question is
    refused.
    """
    t, file = np.linspace(0.0, 1.0, 100), tmp_path / "a.fit"
    path = written(tmp_path / "s.csv", t, swing(t))
    given = {**QUICK, "starts": 2}
    whole = vfife.fit(oscillator(), path, BOUNDS, **given)
    kept = []
    for stop in (1, 4):  # after the first points, and in the searches
        calls = iter(range(stop))

        def interrupt(progress, calls=calls):
            if next(calls, None) is None:
                raise KeyboardInterrupt

        part = vfife.fit(oscillator(), path, BOUNDS, **given, file=file, progress=interrupt)
        assert part.status == "interrupted" and math.isnan(part["spring.k.damping"].error)
        with FitFile.open(file) as one:
            kept.append(len(one.keys("looks")))
    assert kept == sorted(set(kept)), "each goes further than the one before"
    found = vfife.fit(oscillator(), path, BOUNDS, **given, file=file)
    assert (found.set, found.starts, found.evaluations) == (whole.set, whole.starts, whole.evaluations)
    assert [(one.error, one.low, one.high) for one in found.values] == [
        (one.error, one.low, one.high) for one in whole.values
    ]
    again, read = (
        vfife.fit(oscillator(), path, BOUNDS, **given, file=file),
        vfife.identification.load_fit(file),
    )
    assert again.json() == read.json() == found.json() and np.array_equal(
        read.curves[0].model, whole.curves[0].model
    )
    with FitFile.open(file) as one:
        before = len(one.keys("looks"))
    more = vfife.fit(oscillator(), path, BOUNDS, **{**given, "screened": 12}, file=file)
    with FitFile.open(file) as one:
        assert before < len(one.keys("looks")) and more.status == "complete"
    with pytest.raises(VfifeError, match="there is a fit file here with another specification"):
        vfife.fit(oscillator(), path, {"spring.k.damping": (1, 9)}, **given, file=file)
    with pytest.raises(VfifeError, match="is the results of a fit, not a run; show them with vfife fit"):
        vfife.load_result(file)


def test_points_and_the_mark_of_the_best_are_written_together(tmp_path):
    """A process that ends while it marks the best point leaves none of the points either."""

    class Killed(FitFile):
        def insert(self, table, *values):
            if values[0] == "best":
                raise KeyboardInterrupt
            super().insert(table, *values)

    FitFile.create(tmp_path / "a.fit", {"fit": {}}).close()
    path = written(tmp_path / "s.csv", np.linspace(0.0, 1.2, 240), swing(np.linspace(0.0, 1.2, 240)))
    task = plan_fit(oscillator(), path, BOUNDS, step="1 ms")
    with Killed.write(tmp_path / "a.fit") as file:
        evaluations = Evaluations(task.evaluated, task.parameters, file)
        with pytest.raises(KeyboardInterrupt):
            evaluations([Query((0.5,) * len(task.parameters))])
    with FitFile.open(tmp_path / "a.fit") as file:
        assert not file.keys("looks") and not file.keys("found") and not file.damage


def test_more_effort_never_gives_a_worse_point_than_the_file_has(tmp_path):
    """A search from the stiffness of the model ends in a wrong minimum; a fit before it found the right one
    in the file. The answer is that one, and both searches count. It is the same after an interruption.
    """
    t, file, copy = np.linspace(0.0, 1.2, 240), tmp_path / "a.fit", tmp_path / "b.fit"
    path = written(tmp_path / "s.csv", t, swing(t))
    model, given = oscillator(stiffness=3000.0), {"derivatives": "differences", "step": "1 ms", "starts": 1}
    bounds, poor = {"spring.k.stiffness": (200.0, 4000.0)}, {**given, "screened": 1, "restarts": 0}
    wrong = vfife.fit(model, path, bounds, **poor)
    right = vfife.fit(model, path, bounds, **given, screened=32, file=file)
    assert right["spring.k.stiffness"].value == pytest.approx(STIFFNESS, rel=0.02)
    assert wrong["spring.k.stiffness"].value > 1.5 * STIFFNESS and wrong.share > 2.0 * right.share
    shutil.copy(file, copy)
    more = vfife.fit(model, path, bounds, **poor, file=file)
    assert (more.set, more.share) == (right.set, right.share)
    assert more.starts == sorted([*wrong.starts, *right.starts])
    calls = iter(range(2))

    def interrupt(progress):
        if next(calls, None) is None:
            raise KeyboardInterrupt

    part = vfife.fit(model, path, bounds, **poor, file=copy, progress=interrupt)
    assert part.status == "interrupted" and part.set == right.set
    again = vfife.fit(model, path, bounds, **poor, file=copy)
    assert {**again.json(), "seconds": 0.0} == {**more.json(), "seconds": 0.0}


def test_errors_of_a_straight_line_are_the_textbooks():
    """y = a + b x: the standard errors of least squares in closed form, and limits by Student's t."""
    x = np.linspace(0.0, 1.0, 12)
    left = np.array([0.1, -0.2, 0.15, 0.0, -0.1, 0.2, -0.15, 0.05, 0.1, -0.2, 0.1, -0.05])
    rows = np.stack([np.ones(12), x], axis=1)
    left -= rows @ np.linalg.lstsq(rows, left, rcond=None)[0]
    sought = [FitParameter(name, (name,), "1", 0.0, 1.0) for name in "ab"]
    told = confidence_of([left], sought, np.array([0.5, 0.5]), rows, 2, 0.95)
    s = math.sqrt((left**2).sum() / 10)
    follow = autocorrelation([left])
    assert follow == 0.0, "they alternate, which narrows nothing"
    spread = ((x - x.mean()) ** 2).sum()
    assert told.errors == pytest.approx(
        [s * math.sqrt(1.0 / 12 + x.mean() ** 2 / spread), s / math.sqrt(spread)], rel=1e-10
    )
    assert told.limits[1][1] - 0.5 == pytest.approx(2.228139 * told.errors[1], rel=1e-6)
    assert told.correlation[0, 1] == pytest.approx(-x.mean() / math.sqrt((x**2).mean()), rel=1e-10)


# ------------------------------------------------------------------------------------------------------- laws


def test_a_power_law_comes_back_from_its_curve(tmp_path):
    d = np.linspace(1e-6, 1e-4, 80)
    path = tmp_path / "press.csv"
    noise = 1.0 + 0.02 * np.random.default_rng(3).standard_normal(len(d))
    path.write_text(
        "penetration (um), force (kN)\n"
        + "\n".join(f"{1e6 * a},{6.6e7 * a**1.4 * b}" for a, b in zip(d, noise, strict=True))
    )
    found = fit_law("impact", path)
    assert (
        found["exponent"].value == pytest.approx(1.4, abs=3.0 * found["exponent"].error)
        and found["exponent"].error < 0.02
    )
    assert found["stiffness"].value == pytest.approx(6.6e10, rel=0.15) and found.correlation[0, 1] > 0.99, (
        "they are told together only"
    )
    fixed = fit_law("impact", path, {"exponent": 1.4})
    assert fixed["stiffness"].value == pytest.approx(6.6e10, rel=0.01)


def test_a_loop_tells_the_restitution(tmp_path):
    """Hunt and Crossley's F = K d^1.5 [1 + 3/2 (1 - e) d'/v], integrated by scipy, with e = 0.7."""
    stiffness, given, speed = 1e10, 0.7, 0.8
    force = lambda d, v: stiffness * max(d, 0.0) ** 1.5 * (1.0 + 1.5 * (1.0 - given) * v / speed)  # noqa: E731
    parted = lambda _, y: y[0] if y[1] < 0.0 else 1.0  # noqa: E731
    parted.terminal = True
    run = solve_ivp(
        lambda _, y: (y[1], -force(*y)),
        (0.0, 1.0),
        (0.0, speed),
        events=parted,
        rtol=1e-9,
        atol=1e-12,
        max_step=2e-5,
    )
    rows = [(d, force(d, v)) for d, v in run.y.T if d > 0.0]
    path = tmp_path / "loop.csv"
    path.write_text(
        "penetration [m], force [N]\n"
        + "\n".join(f"{d:.9g}, {f:.9g}" for d, f in rows[:: max(1, len(rows) // 40)])
    )
    found = fit_law("hunt-crossley", path)
    assert found["restitution"].value == pytest.approx(given, abs=5e-3) and found[
        "stiffness"
    ].value == pytest.approx(stiffness, rel=5e-3)
    assert [one.channel for one in found.curves] == ["loading", "unloading"] and found.share < 0.01


@pytest.mark.parametrize(
    ("law", "text", "what"),
    [
        ("hertzz", "penetration,force", 'did you mean "hertz"'),
        ("table", "penetration,force", "takes measured points as they are"),
        ("pereira", "penetration,force", "no parameter that this curve determines"),
        ("hertz", "depth,force", "a column is missing"),
        ("hertz", "penetration (N),force", "its unit is that of"),
    ],
)
def test_laws_that_cannot_be_fitted_are_told(tmp_path, law, text, what):
    path = tmp_path / "c.csv"
    path.write_text(text + "\n" + "\n".join(f"{k}e-6,{k * k}" for k in range(1, 20)))
    with pytest.raises(VfifeError) as told:
        fit_law(law, path)
    assert what in str(told.value), str(told.value)


# ----------------------------------------------------------------------------------------------------- faults

LINES = "\n".join(f"{0.01 * k:.3f}, {0.11 - 1e-4 * k:.5f}" for k in range(20))
FAULTS = {
    "no file": (None, BOUNDS, {}, "it cannot be read"),
    "no time": ("when, b.x\n" + LINES, BOUNDS, {}, "no column of times or angles"),
    "no channel": ("time, q\n" + LINES, BOUNDS, {}, "no column is a channel of the mechanism"),
    "a misspelt channel": ("time, bx\n" + LINES, BOUNDS, {}, 'as channels are: bx (did you mean "b.x"'),
    "a column that is not there": (
        "time, b.x\n" + LINES,
        BOUNDS,
        {"columns": ["b.y"]},
        'there is no such column. Did you mean "b.x"',
    ),
    "a channel that is not there": (
        "time, acc\n" + LINES,
        BOUNDS,
        {"columns": ["acc=b.speeed"]},
        "the mechanism has no such channel",
    ),
    "a unit": ("time, b.x (kN)\n" + LINES, BOUNDS, {}, "its unit is that of a force"),
    "not a number": (
        "time, b.x\n" + LINES.replace("0.10950", "nan"),
        BOUNDS,
        {},
        'line 7, column 2 (b.x) = "nan": this is not a finite number',
    ),
    "a gap": (
        "time, b.x\n" + LINES.replace("0.10950", " "),
        BOUNDS,
        {},
        "line 7, column 2 (b.x): there is no value",
    ),
    "a comma": (
        "time; b.x\n" + LINES.replace(",", ";").replace("0.10950", "0,1095"),
        BOUNDS,
        {},
        "this is a text with a comma",
    ),
    "back in time": ("time, b.x\n" + LINES.replace("0.050", "0.150"), BOUNDS, {}, "it is not after line 7"),
    "too few": ("time, b.x\n" + LINES[:80], BOUNDS, {}, "rows of numbers"),
    "too few for so many": (
        "time, b.x\n" + "\n".join(LINES.splitlines()[:8]),
        BOUNDS,
        {},
        "8 values are too few for 3 unknown numbers",
    ),
    "flat": ("time, b.x\n" + "\n".join(f"{k}, 1" for k in range(20)), BOUNDS, {}, "every value is the same"),
    "by an angle": ("angle (deg), b.x\n" + LINES, BOUNDS, {}, "no driver turns one"),
    "a path": ("time, b.x\n" + LINES, {"spring.k.stifness": (1, 2)}, {}, 'Did you mean "spring.k.stiffness"'),
    "no bounds": ("time, b.x\n" + LINES, ["spring.k.stiffness=3"], {}, "two bounds are needed"),
    "bounds that descend": (
        "time, b.x\n" + LINES,
        ["spring.k.stiffness=3..2"],
        {},
        "the bounds do not ascend",
    ),
    "a bound beyond": ("time, b.x\n" + LINES, {"body.b.mass": (-1, 2)}, {}, "its bound:"),
    "a bound's unit": ("time, b.x\n" + LINES, ["body.b.mass=1..2 mm"], {}, "its bound:"),
    "twice": (
        "time, b.x\n" + LINES,
        ["body.b.mass=1..2", "body.*.mass=1..3"],
        {},
        "is identified by body.b.mass already",
    ),
    "nothing": ("time, b.x\n" + LINES, [], {}, "there is no parameter to identify"),
    "free without turns": ("time, b.x\n" + LINES, BOUNDS, {"offset": "free"}, "no crank turns"),
    "an offset": ("time, b.x\n" + LINES, BOUNDS, {"offset": "2 mm"}, "offset"),
    "a word": ("time, b.x\n" + LINES, BOUNDS, {"compare": "shape"}, '"curve"'),
    "before the start": (
        "time, b.x\n" + LINES,
        BOUNDS,
        {"offset": "-5..5 ms"},
        "the first sample lies before the run begins",
    ),
    "no window": (
        "time, b.x\n" + LINES,
        BOUNDS,
        {"compare": "envelope", "width": "0 ms"},
        "width = 0 s: zero or negative",
    ),
    "a window beyond the data": (
        "time, b.x\n" + LINES,
        BOUNDS,
        {"compare": "envelope", "width": 1.0},
        "width = 1 s: too large; allowed: above 0 and at",
    ),
    "a step back": (
        "time, b.x\n" + LINES,
        BOUNDS,
        {"step": "-1 us"},
        "step = -1e-06 s: zero or negative; allowed: above 0 s",
    ),
    "a weight": (
        "time, b.x\n" + LINES,
        BOUNDS,
        {"weights": {"b.y": 2.0}},
        "no such column among those that are used",
    ),
}


@pytest.mark.parametrize("name", FAULTS)
def test_what_cannot_be_fitted_is_told(tmp_path, name):
    text, parameters, options, what = FAULTS[name]
    path = tmp_path / "data.csv"
    if text is not None:
        path.write_text(text)
    with pytest.raises(VfifeError) as told:
        vfife.fit(oscillator(), path, parameters, **{**QUICK, **options})
    assert what in str(told.value), str(told.value)
    assert isinstance(told.value, ModelError)


def test_all_faults_of_a_file_are_told_at_once(tmp_path):
    """Cells, lines and units of all columns; of many of a kind the first ten and a count."""
    rows = [[f"{0.01 * k:.3f}", f"{0.11 - 1e-4 * k:.5f}", "1"] for k in range(60)]
    for k in range(5, 35):
        rows[k][1] = "x"
    rows[3][0], rows[40][0], rows[50] = "0.005", "", ["1", "2"]
    path = tmp_path / "data.csv"
    path.write_text("time, b.x, b.y (kg)\n" + "\n".join(",".join(row) for row in rows))
    with pytest.raises(ModelError) as told:
        vfife.fit(oscillator(), path, BOUNDS, **QUICK)
    said = [str(one) for one in told.value.faults]
    assert said[0].startswith("line 52: it has 2 values") and "its unit is that of a mass" in said[1]
    cells = [one for one in said if "this is not a number" in one]
    assert (
        len(cells) == 10
        and cells[0].startswith('line 7, column 2 (b.x) = "x"')
        and "file: 21 more cells are not numbers." in said
    )
    assert any(
        one.startswith("line 5, column time = 0.005 after 0.02: it is not after line 4") for one in said
    )
    assert any(one.startswith("column b.y (kg): every value is the same") for one in said) and len(said) == 15


def test_decimal_commas_between_semicolons_are_read(tmp_path):
    """As spreadsheets of many countries write them; the same table with points gives the same numbers."""
    from vfife.identification.measurements import measured

    text = "time; b.x\n" + LINES.replace(",", ";")
    for name, one in (("points.csv", text), ("commas.csv", text.replace("b.x", "b:x").replace(".", ","))):
        (tmp_path / name).write_text(one.replace("b:x", "b.x"))
    points, commas = (measured(tmp_path / name, {"b.x": "m"}) for name in ("points.csv", "commas.csv"))
    assert "," in (tmp_path / "commas.csv").read_text()
    assert np.array_equal(points.curves[0].values, commas.curves[0].values)


def test_the_command_says_what_it_does_before_the_forecast(tmp_path, monkeypatch):
    """Assembling compiles for a minute where the cache is empty, and nothing else was shown than its name."""
    texts = []

    def forecast(*_):
        texts.append(ACTIVITY.text)
        raise VfifeError("enough")

    monkeypatch.setattr(FitTask, "forecast", forecast)
    t = np.linspace(0.0, 1.0, 120)
    path, model = written(tmp_path / "s.csv", t, swing(t)), tmp_path / "m.toml"
    model.write_text(dump(oscillator()))
    target = ["-o", str(tmp_path / "s.fit")]
    CliRunner().invoke(app, ["fit", str(model), str(path), "-p", "spring.k.damping=0.5..20", *target])
    assert texts == ["reading the data, assembling the model and forecasting the fit"]


def test_the_command_finds_writes_and_says_so(tmp_path):
    t = np.linspace(0.0, 1.0, 120)
    path, model, out = written(tmp_path / "s.csv", t, swing(t)), tmp_path / "m.toml", tmp_path / "fitted.toml"
    model.write_text(dump(oscillator()))
    options = [
        "-p",
        "spring.k.stiffness=0.2..1 kN/m",
        "-p",
        "spring.k.damping=0.5..20",
        "--screened",
        "8",
        "--starts",
        "1",
        "--step",
        "1 ms",
    ]
    more = [
        "--derivatives",
        "differences",
        "--csv",
        str(tmp_path / "c.csv"),
        "--fitted",
        str(out),
        "-o",
        str(tmp_path / "s.fit"),
    ]
    answer = CliRunner().invoke(app, ["fit", str(model), str(path), *options, *more])
    assert answer.exit_code == 0, answer.output
    assert "forecast: about 96 runs of 1,000 steps" in answer.stderr
    assert "48 to 725 runs by how the searches go, at most" in answer.stderr
    assert "spring.k.damping" in answer.output and "95 % confidence" in answer.output
    assert (
        vfife.load(out).springs["k"].stiffness == pytest.approx(STIFFNESS, rel=1e-2)
        and (tmp_path / "c.csv").exists()
    )
    shown = CliRunner().invoke(app, ["fit", str(tmp_path / "s.fit"), "--json"])
    assert (
        shown.exit_code == 0
        and json.loads(shown.stdout)["parameters"][0]["value"] == vfife.load(out).springs["k"].stiffness
    )
    refused = {
        "there is such a file": ["--fitted", str(out)],
        "with the identified values, use --fitted w.toml": ["-o", "w.toml"],
        "with another specification; name another file, or remove this one": [
            *options[2:],
            "-o",
            str(tmp_path / "s.fit"),
        ],
        "is not a fit file; choose another name": ["-o", __file__],
        "steps; add --yes to confirm, or give fewer points": [
            *options[:-1],
            "10 ps",
            "-o",
            str(tmp_path / "h.fit"),
        ],
    }
    for what, words in refused.items():
        answer = CliRunner().invoke(app, ["fit", str(model), str(path), *words])
        assert answer.exit_code == 2 and what in answer.output, answer.output
    assert not (tmp_path / "h.fit").exists()
    alone = {
        "-o, --force: a fit file alone is shown as it is": [tmp_path / "s.fit", "--force", "-o", "t.fit"],
        "not a fit plan; run it with vfife run": [model],
        "there is no such file; name a file that vfife fit wrote": [tmp_path / "none.fit"],
        "--width: it is the window of an envelope": [model, path, *options, "--width", "1 ms"],
    }
    for what, words in alone.items():
        answer = CliRunner().invoke(app, ["fit", *map(str, words)])
        assert answer.exit_code == 2 and what in " ".join(answer.output.split()), answer.output
    told = CliRunner().invoke(app, ["fit", str(model), str(tmp_path / "t.csv"), *options])
    assert told.exit_code == 2 and 'Did you mean "s.csv"' in told.output


@pytest.mark.system("a fit of hundreds of runs")
def test_the_papers_four_bar_gives_three_numbers_back(tmp_path):
    """Two clearances and the drive speed from a force, a torque and an acceleration with 2 % noise, measured
    at another step, from somewhere in a turn on. The full one, in wide bounds, is in tests/verification.
    """
    truth = {"joint.B.clearance": 2.3e-4, "joint.C.clearance": 1.7e-4, "driver.crank.speed": 152.0}
    base = vfife.load(EXAMPLES / "four_bar.toml")
    path = synthetic(tmp_path / "rig.csv", base, truth, 1.1e-6, turns=(2.37, 3.4), every=4, seed=5)
    bounds = {
        "joint.B.clearance": ("0.15 mm", "0.3 mm"),
        "joint.C.clearance": ("0.1 mm", "0.25 mm"),
        "driver.crank.speed": (145.0, 165.0),
    }
    found = vfife.fit(
        base, path, bounds, step=1.4e-6, skip=1, screened=8, starts=1, derivatives="differences"
    )
    for name, value in truth.items():
        assert found[name].value == pytest.approx(value, rel=0.03), name
    assert found.share < 0.03 and found.undetermined == []
