"""The effect of a larger clearance is that of machines that have it, not that of a derivative."""

import dataclasses
import json
import math
from collections.abc import Callable
from shlex import split
from types import SimpleNamespace

import numpy as np
import pytest

import vfife
from vfife.assessment import sample
from vfife.assessment.answer import (
    Design,
    JointDesign,
    default_limit,
    effects_agree,
    missing_limit,
    path_of,
    refuse_unlikely,
)
from vfife.assessment.ranking import Rank
from vfife.assessment.sample import MachineSample, growth_effects, with_growths
from vfife.errors import ModelError
from vfife.gallery import path
from vfife.job.cost import Forecast
from vfife.measures.catalogue import is_coordinate
from vfife.modelfile import loads
from vfife.report.design import clearance_sentence, document, next_steps, request, row
from vfife.report.design_words import quantity_of
from vfife.report.fits import fit_sentence
from vfife.results.derivatives import Derivative, Effect, Sensitivity
from vfife.studies.engine.outcome import Outcome
from vfife.studies.spec.plan import CaseSpec

MEASURE, CLEARANCE = "pin.force.max", 2e-4
PATH = path_of("pin")
SPEC = CaseSpec((MEASURE,), 2)
Response = Callable[[float, float | None], float]


def model() -> vfife.Mechanism:
    return vfife.gallery.slider_crank_loose_pin(friction=0.05, clearance=CLEARANCE, restitution=0.5)


def effect_of(monkeypatch: pytest.MonkeyPatch, response: Response) -> Effect:
    """The effect of a growth on a measure that depends on clearance and step (None: automatic) as told."""

    def machines(_mechanism, numbers, spec):
        for k, clearances in enumerate(numbers):
            value = response(clearances[PATH], spec.step)
            found = {} if math.isnan(value) else {MEASURE: value}
            yield k, Outcome(values=found, turns=2, step=1e-5, steps=2 * 7200)

    monkeypatch.setattr(sample, "run_cases", machines)
    job = SimpleNamespace(count=lambda *_, **__: None)
    return growth_effects(model(), {PATH: CLEARANCE}, SPEC, job)[PATH]


def wave(height: float) -> Response:
    """A force that rises by 5 % with the growth of 10 µm, with a wave of this height (N) and 13 µm."""

    def response(clearance: float, _step: float | None = None) -> float:
        grown = (clearance - CLEARANCE) / 1e-5
        return 1000.0 + 50.0 * grown + height * math.sin(2.0 * math.pi * (grown - 0.2) / 1.3)

    return response


def test_the_range_of_an_effect_covers_neighbouring_clearances(monkeypatch: pytest.MonkeyPatch) -> None:
    """A wave in the measure widens the range; if it hides the trend, the effect is not known."""
    straight = effect_of(monkeypatch, wave(0.0))
    assert straight.kind == "change" and 5.0 <= straight.low < straight.high < 5.3
    wavy, response = effect_of(monkeypatch, wave(20.0)), wave(20.0)
    assert wavy.kind == "change" and wavy.high - wavy.low > 2.0
    for part in (-10.0, -5.0, 0.0):  # µm from the clearance of the model
        start = CLEARANCE + 1e-6 * part
        change = 100.0 * (response(start + 1e-5) / response(start) - 1.0)
        assert wavy.low - 1e-9 <= change <= wavy.high + 1e-9
    assert effect_of(monkeypatch, wave(60.0)).kind == "unknown"


def test_the_range_covers_the_steps_and_a_sign_that_depends_on_them_is_not_known(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    def stepped(clearance: float, step: float | None) -> float:
        return math.exp((clearance / CLEARANCE - 1.0) * (1.0 if step is None else 0.4))

    effect = effect_of(monkeypatch, stepped)
    assert effect.low == pytest.approx(100.0 * math.expm1(0.02), rel=1e-3)
    assert effect.high == pytest.approx(100.0 * math.expm1(0.05), rel=1e-3)

    def reversed_by_step(clearance: float, step: float | None) -> float:
        return 1000.0 + (clearance / CLEARANCE - 1.0) * (1000.0 if step is None else -400.0)

    assert effect_of(monkeypatch, reversed_by_step).kind == "unknown"
    assert effect_of(monkeypatch, lambda clearance, _: math.nan).kind == "unknown"
    failing = effect_of(monkeypatch, lambda clearance, _: math.nan if clearance > 2.05e-4 else 1.0)
    assert failing.kind == "unknown"


def sensitivity(slope: float) -> Sensitivity:
    """A sensitivity of the measure, with a derivative that holds, in per cent for 1 %."""
    number = slope * 1000.0 / CLEARANCE
    derivative = Derivative(
        PATH, CLEARANCE, {MEASURE: number}, {MEASURE: (number, number)}, kinds={MEASURE: "derivative"}
    )
    return Sensitivity("rig", {MEASURE: 1000.0}, [derivative])


def test_clearances_are_ranked_where_a_small_change_has_the_other_sign() -> None:
    growths = {PATH: Effect(PATH, "change", 5.0, 4.9, 5.1)}
    assert effects_agree(sensitivity(1.0), MEASURE, growths)
    assert not effects_agree(sensitivity(-1.0), MEASURE, growths)
    assert not effects_agree(sensitivity(1.0), MEASURE, {PATH: growths[PATH]._replace(kind="unknown")})
    doubtful = dataclasses.replace(sensitivity(1.0), doubtful=frozenset({MEASURE}))
    assert not effects_agree(doubtful, MEASURE, growths)


FITS = [((30e-6, 104e-6), "30 to 104 µm"), ((10e-6, 41.5e-6), "10 to 41.5 µm"), ((0.0, 15e-6), "0 to 15 µm")]


@pytest.mark.parametrize(("limits", "text"), FITS)
def test_limits_of_a_fit_are_those_of_the_tables_without_rounding(limits, text: str) -> None:
    found = design(5.0)
    joint: JointDesign = dataclasses.replace(found.joints[0], fit="H9/e9", limits=limits)
    assert text in row(found, joint)


def design(effect: float, slope: float = 1.0) -> Design:
    """A design answer with an effect and machines in which the force grows with the clearance."""
    clearances = sample.sampled_clearances({"pin": (1e-4, 3e-4)})
    machines = MachineSample(("pin",), clearances, clearances[:, 0])
    return Design(
        model(), MEASURE, None, False, 0.95, {}, sensitivity=sensitivity(slope), nominal=1000.0,
        missing={"fits": "none", "life": "none"}, sample=machines,
        growths={PATH: Effect(PATH, "change", effect, effect - 0.1, effect + 0.1)},
    )  # fmt: skip


def test_the_sentence_has_the_computed_effect_whatever_the_derivative() -> None:
    text = clearance_sentence(design(5.0, slope=-1.0))
    assert "The clearance of pin matters most: 10 µm more changes" in text
    assert "by +5.0 % (4.9 % to 5.1 %)" in text
    assert "linear" not in str(document(design(5.0)).data) and not row(design(5.0), design(5.0).joints[0])[5]


def test_where_no_clearance_changes_the_measure_by_more_than_a_hundredth_none_matters(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Over the tolerance of its fit, or with the larger clearance where it has no fit; machines within the
    limits of the fits differ by no more.
    """
    said = (
        "The clearance of pin does not matter for the largest force on pin (1 kN): it changes it by at most"
    )
    text = clearance_sentence(design(0.6))
    assert text == f"{said} 0.70 % with the larger clearance of the table."
    assert "matters most: 10 µm more" in clearance_sentence(design(1.0))
    (pin,) = design(0.6).joints

    def fitted(width: float, *others: JointDesign) -> str:
        joint = dataclasses.replace(pin, fit="H7/f7", limits=(1e-4, 1e-4 + width))
        monkeypatch.setattr(Design, "joints", (joint, *others))
        return clearance_sentence(design(0.6))

    assert fitted(8e-6) == f"{said} 0.70 % over the tolerance of its fit."
    assert fitted(14e-6) == f"{said} 0.98 % over the tolerance of its fit."
    assert "pin matters most" in fitted(20e-6)
    loose = dataclasses.replace(
        pin, name="wheel", rank=None, effect=Effect(PATH, "change", -0.09, -0.1, -0.08)
    )
    text = fitted(8e-6, loose)
    assert text.startswith(
        "None of the clearances matters for the largest force on pin (1 kN): each changes it"
    )
    assert text.endswith("0.70 % over the tolerance of its fit or with the larger clearance of the table.")
    large = dataclasses.replace(loose, effect=Effect(PATH, "change", -2.0, -2.1, -1.9))
    assert "The clearance of wheel matters most" in fitted(8e-6, large)
    monkeypatch.setattr(Design, "values_within_limits", np.array([1000.0, 1011.0]))
    assert "pin matters most" in fitted(8e-6)
    monkeypatch.setattr(Design, "values_within_limits", np.array([1000.0, 1009.0]))
    assert "does not matter" in fitted(8e-6)


def test_a_rank_correlation_of_the_other_sign_is_said_and_no_clearance_matters_most() -> None:
    found = design(-5.0)
    assert found.ranks["pin"].low > 0.0
    text = clearance_sentence(found)
    assert "matters most:" not in text and "10 µm more clearance of pin changes" in text
    assert "rank correlation with pin has the other sign" in text
    assert row(found, found.joints[0])[5].startswith("+")  # the rank correlation is shown
    invisible = Rank(0.1, -0.2, 0.4)
    joint: JointDesign = dataclasses.replace(found.joints[0], rank=invisible)
    assert row(found, joint)[5] == "+0.10"


def test_an_effect_whose_sign_is_not_known_has_its_range_and_may_not_matter() -> None:
    """Neighbours disagree on the sign: the table has their range, and a small one is no effect."""
    unknown = Effect(PATH, "unknown", 0.1, -0.3, 0.5)
    found = dataclasses.replace(design(5.0), growths={PATH: unknown}, sample=None)
    assert row(found, found.joints[0])[2:5] == ("+10 µm", "not known", "-0.3 % to 0.5 %")
    assert "does not matter" in clearance_sentence(found) and "at most 0.50 %" in clearance_sentence(found)
    wide = dataclasses.replace(found, growths={PATH: unknown._replace(low=-3.0)})
    assert "No clearance has a known effect" in clearance_sentence(wide)
    failed = dataclasses.replace(found, growths={PATH: unknown._replace(low=math.nan, high=math.nan)})
    assert row(failed, failed.joints[0])[3:5] == ("not known", "")
    assert "No clearance has a known effect" in clearance_sentence(failed)


def test_the_forecast_counts_the_machines_with_growths() -> None:
    plain = Forecast("run", seconds=10.0, ends=(5.0, 20.0))
    both = with_growths(plain, 2, 1.0)
    more = both.seconds - 10.0
    assert more == pytest.approx((1 + 2 * 8) * (1.0 + 1.25)) and both.ends == pytest.approx(
        (5.0 + more, 20.0 + more)
    )
    assert with_growths(dataclasses.replace(plain, ends=None), 2, 1.0).ends is None


# ------------------------------------------------------------------ measures whose zero is arbitrary


def press(shift_mm: float) -> vfife.Mechanism:
    """The press of the starter with its clearances and its work; the zero of its guide moved along it."""
    text = path("six_bar_press").read_text(encoding="utf-8").replace("#~ ", "")
    guide = 'guide = ["700 mm", "-220 mm"]'
    assert text.count(guide) == 1 and "25 um" in text and "[load.work]" in text
    text = text.replace(guide, f'guide = ["{700.0 + shift_mm:.9g} mm", "-220 mm"]')
    assert text.count('"60 rpm"') == 1
    # A turn of fewer steps; the ram takes up the same clearances.
    text = text.replace('"60 rpm"', '"240 rpm"')
    travels = (-100, 60, 70, 100, 110, 120)
    old, new = (
        "travels = " + json.dumps([f"{x - shift:.9g} mm" for x in travels]) for shift in (0.0, shift_mm)
    )
    assert text.count(old) == 1
    return loads(text.replace(old, new))


@pytest.mark.slow("machines with larger clearances and fits of a press, twice")
def test_a_zero_elsewhere_changes_no_verdict_on_a_position() -> None:
    """Effects, digits and fits are the same with the zero at the guide and at the dead centre."""
    answers = []
    for shift in (0.0, 115.768):
        limit = f"{115.79 - shift:.6g} mm"
        found = vfife.design(
            press(shift), "guide.position.high", limit=limit, share=0.5, cost={"IT7": 2.5, "IT9": 1.0}
        )
        effects = {joint.name: joint.effect for joint in found.joints}
        assert 9e-6 < effects["E"].low < effects["E"].high < 11e-6  # one to one
        difference = found.value - found.ideal
        # Two clearances of 25 um, depths of contact, and what inertia adds at this speed (1 um at 60 rpm).
        assert difference == pytest.approx(55.8e-6, rel=0.02) and not found.sensitive
        sentence = clearance_sentence(found)
        assert sentence.startswith("The clearances of E and F matter most, about equally: 10 µm more of ")
        assert "%" not in sentence and " by +10" in sentence
        shown = row(found, found.joints[0])[3:5]
        assert all(cell.endswith("µm") for cell in shown)
        limited = fit_sentence(found)
        assert f"to {limit.replace('0.022 mm', '22 µm')} in 50 %" in limited
        reached = found.allocation.quantile.value
        assert reached < found.limit and quantity_of(found, reached) != quantity_of(found, found.limit)
        answers.append((found.allocation.fits, [difference, *(effect.value for effect in effects.values())]))
    (fits, effects), (shifted_fits, shifted_effects) = answers
    assert shifted_fits == fits and shifted_effects == pytest.approx(effects, rel=1e-3)


def position(nominal: float, ideal: float | None, change: float, **options) -> Design:
    """A design answer for the place of a piston whose clearance of 200 µm changes it."""
    return Design(
        model(), "guide.position.high", None, False, 0.95, {}, nominal=nominal, ideal=ideal,
        missing={"fits": "none", "life": "none"},
        growths={PATH: Effect(PATH, "change", change, change - 1e-9, change + 1e-9)}, **options,
    )  # fmt: skip


def test_a_position_is_judged_by_its_difference_from_the_ideal_mechanism() -> None:
    for zero in (-0.3, 0.0, 1e-4, 0.3):
        found = position(zero + 2e-4, zero, 9e-6)
        assert "The clearance of pin matters most: 10 µm more" in clearance_sentence(found)
        assert "by +9 µm (8.999 to 9.001 µm)" in clearance_sentence(found)
        assert row(found, found.joints[0])[3:5] == ("+9 µm", "8.999 to 9.001 µm")
        quiet = clearance_sentence(position(zero + 2e-4, zero, 1.5e-6))
        assert "does not matter" in quiet and "at most 1.6 µm with" in quiet
        scattered = (zero + 1.95e-4, zero + 2.05e-4)
        assert position(zero + 2e-4, zero, 9e-6, nominal_range=scattered).sensitive
        assert not position(zero + 2e-4, zero, 9e-6, nominal_range=(zero + 2e-4, zero + 2.01e-4)).sensitive
    # A coordinate that clearances do not change at all.
    assert "does not matter" in clearance_sentence(position(0.3, 0.3, 1.5e-9))
    assert "matters most" in clearance_sentence(position(0.3, None, 9e-6))
    data = document(position(0.3002, 0.3, 9e-6)).data
    assert data["effect_unit"] == "m" and data["ideal"] == 0.3
    assert document(design(5.0)).data["effect_unit"] == "%"


def test_a_force_has_its_effect_in_per_cent_and_in_its_unit() -> None:
    assert row(design(5.0), design(5.0).joints[0])[3] == "+5.0 %, +50 N"
    text = clearance_sentence(design(5.0))
    assert text.endswith("by +5.0 % (4.9 % to 5.1 %), +50 N at clearances of 190 to 210 µm.")


def test_effects_of_positions_are_differences_also_of_machines(monkeypatch: pytest.MonkeyPatch) -> None:
    def machines(_mechanism, numbers, spec):
        for k, clearances in enumerate(numbers):
            values = {"guide.position.high": 1e-9 + 0.5 * clearances[PATH]}
            yield k, Outcome(values=values, turns=2, step=1e-5, steps=2 * 7200)

    monkeypatch.setattr(sample, "run_cases", machines)
    job = SimpleNamespace(count=lambda *_, **__: None)
    spec = CaseSpec(("guide.position.high",), 2)
    effect = growth_effects(model(), {PATH: CLEARANCE}, spec, job)[PATH]
    assert effect.value == pytest.approx(5e-6, rel=1e-3)


def test_the_default_limit_of_a_position_is_a_tenth_of_its_difference_above() -> None:
    def limit(nominal: float, ideal: float | None, measure: str = "guide.position.high") -> float | None:
        return default_limit(measure, model(), nominal, ideal)

    assert limit(1000.0, None, MEASURE) == pytest.approx(1100.0) and limit(-1.0, None, MEASURE) is None
    for zero in (-0.3, 0.0, 0.3):
        assert limit(zero + 2e-4, zero) == pytest.approx(zero + 2.2e-4, abs=1e-12)
        assert limit(zero - 2e-4, zero) is None and limit(zero + 1e-9, zero) is None
    assert limit(0.3, None) is None
    assert '--limit "300.2 mm"' in missing_limit("guide.position.high", 0.3, 2e-4)
    assert '--limit "2.5 rad"' in missing_limit("max(rocker.angle)", 2.4, 0.1)
    assert "is unknown" in missing_limit(MEASURE, None, 0.0)
    found = dataclasses.replace(position(0.3002, 0.3, 9e-6), limit=0.30022, default_limit=True)
    (line,) = [text for name, text in request(found) if name == "Limit"]
    assert line.endswith("a tenth of the difference from the ideal mechanism above the value of the model")


def test_a_bare_limit_of_a_position_is_refused_where_its_unit_is_missing_not_by_its_zero() -> None:
    refuse_unlikely("0.0007", "guide.position.high", 1e-7)
    refuse_unlikely("0.11579", "guide.position.high", 0.11577)
    with pytest.raises(ModelError, match="a unit is probably missing"):
        refuse_unlikely("115.79", "guide.position.high", 0.11577)


def test_clearances_with_equal_effects_matter_equally(monkeypatch: pytest.MonkeyPatch) -> None:
    (pin,) = design(5.0).joints

    def sentence_with(other: Effect) -> str:
        joints = (pin, dataclasses.replace(pin, name="wheel", effect=other))
        monkeypatch.setattr(Design, "joints", joints)
        return clearance_sentence(design(5.0))

    assert "The clearances of pin and wheel matter most, about equally: 10 µm more of pin" in sentence_with(
        Effect(PATH, "change", 4.85, 4.8, 4.9)
    )
    assert "The clearance of pin matters most: " in sentence_with(Effect(PATH, "change", 4.0, 3.9, 4.1))


def test_commands_of_a_page_survive_a_shell() -> None:
    def commands(found: Design, file: str) -> list[str]:
        return [line for line in next_steps(found, file) if line.startswith("vfife sensitivity")]

    (line,) = commands(design(5.0), "my press.toml")
    assert split(line.partition("   (")[0]) == ["vfife", "sensitivity", "my press.toml", "--of", MEASURE]
    angle = dataclasses.replace(position(2.5, 2.4, 0.01), measure="max(rocker.angle)")
    assert not commands(angle, "press.toml")  # which has no derivatives
    assert 'measures = ["max(rocker.angle)"]' in " ".join(next_steps(angle, "press.toml"))
    assert angle.unit == "rad"


def test_measures_whose_zero_is_arbitrary() -> None:
    coordinates = (
        "guide.position.high", "guide.position.low", "max(rocker.angle)", "mean(ram.x)", "min(guide.position)"
    )  # fmt: skip
    others = (
        MEASURE, "range(rocker.angle)", "max(E.eccentricity_x)", "max(rocker.angular_velocity)",
        "max(E.force)", "E.penetration.max",
    )  # fmt: skip
    assert all(map(is_coordinate, coordinates)) and not any(map(is_coordinate, others))
