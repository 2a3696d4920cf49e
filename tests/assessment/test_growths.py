"""The effect of a larger clearance is that of machines that have it, not that of a derivative."""

import dataclasses
import math
from collections.abc import Callable
from types import SimpleNamespace

import numpy as np
import pytest

import vfife
from vfife.assessment import sample
from vfife.assessment.answer import Design, JointDesign, effects_agree, path_of
from vfife.assessment.ranking import Rank
from vfife.assessment.sample import MachineSample, growth_effects, with_growths
from vfife.job.cost import Forecast
from vfife.report.design import clearance_sentence, document, row
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


def dip(clearance: float, _step: float | None = None) -> float:
    """A force that falls by 1 % with 1 % more clearance, and rises by 5 % with the growth of 5 %."""
    share = clearance / CLEARANCE - 1.0
    return 1000.0 * (1.0 - 1.5 * share + 50.0 * share * share)


def test_a_measure_that_falls_first_and_rises_with_the_whole_growth_has_the_effect_of_the_growth(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    effect = effect_of(monkeypatch, dip)
    assert dip(1.01 * CLEARANCE) < dip(CLEARANCE)
    assert effect.kind == "change" and effect.value == pytest.approx(5.0, rel=1e-2)
    assert effect.low <= 100.0 * (dip(1.05 * CLEARANCE) / 1000.0 - 1.0) <= effect.high


def test_the_range_covers_the_steps_and_a_sign_that_depends_on_them_is_not_known(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    def stepped(clearance: float, step: float | None) -> float:
        return 1000.0 + (clearance / CLEARANCE - 1.0) * (1000.0 if step is None else 400.0)

    effect = effect_of(monkeypatch, stepped)
    assert effect.low == pytest.approx(2.0, rel=1e-3) and effect.high == pytest.approx(5.0, rel=1e-3)

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


def test_the_forecast_counts_the_machines_with_growths() -> None:
    plain = Forecast("run", seconds=10.0, ends=(5.0, 20.0))
    both = with_growths(plain, 2, 1.0)
    more = both.seconds - 10.0
    assert more == pytest.approx(3 * 2 * (1.0 + 1.25)) and both.ends == pytest.approx(
        (5.0 + more, 20.0 + more)
    )
    assert with_growths(dataclasses.replace(plain, ends=None), 2, 1.0).ends is None
