"""A design answer: the numbers of its three parts, joints that have none, limits, and an interruption."""

import dataclasses
import math
from functools import cache

import pytest

import vfife
from vfife.assessment import design_work as module
from vfife.assessment.answer import LIFE
from vfife.errors import ModelError, VfifeError
from vfife.job.cost import Forecast
from vfife.job.job import Interrupted, Job, PartJob
from vfife.report.design import document, turns_words
from vfife.solvers.status import Progress
from vfife.studies import allocate

WEAR = {"wear": 1e-15, "wear_turns": 1e5}
BRIEF = {"share": 0.5, "turns": 1}


def loose_pin() -> vfife.Mechanism:
    return vfife.gallery.slider_crank_loose_pin(friction=0.05, clearance=2e-4, restitution=0.5)


@cache
def answer():
    return vfife.design(loose_pin(), **BRIEF, **WEAR)


@pytest.mark.slow("derivatives, machines and wear")
def test_the_parts_have_the_values_that_they_have_alone() -> None:
    found, model = answer(), loose_pin()
    (joint,) = found.joints
    alone = vfife.sensitivity(model, [found.measure], ["joint.pin.clearance"], turns=1)
    effect = alone.effect(found.measure, "joint.pin.clearance")
    assert joint.growth == pytest.approx(10e-6) and joint.effect.kind == effect.kind
    assert joint.effect[2:] == pytest.approx([5.0 * number for number in effect[2:]])  # 5 % of 0.2 mm
    assert found.limit == pytest.approx(1.1 * alone.measures[found.measure])
    worn = vfife.wear(module.with_wear(model, 1e-15), 1e5, clearance=LIFE * 2e-4)
    rate = (worn.clearance[-1, 0] - worn.clearance[-2, 0]) / (worn.turns[-1] - worn.turns[-2])
    assert joint.life.turns == pytest.approx(worn.turns[-1] + (4e-4 - worn.clearance[-1, 0]) / rate)
    error = max(worn.step_difference) + worn.spread.max()
    assert joint.life.span[0] == pytest.approx(joint.life.turns / (1.0 + error)) and not joint.life.reached
    vary = {"pin": {"path": "joint.pin.clearance", "fit": found.letters["pin"], "diameter": 0.02}}
    aim = {"measure": found.measure, "share": 0.5}
    fits = allocate(
        model, vary, [found.measure], turns=1, allocation=aim, limit={found.measure: found.limit},
        cost={"pin": module.RELATIVE_COST},
    )  # fmt: skip
    assert found.allocation.quantile == fits.quantile and joint.fit == fits.fits["pin"]
    assert joint.limits == pytest.approx(fits.choice.options[0].clearance.limits)


@pytest.mark.slow("the same answer")
def test_the_page_has_a_conclusion_of_three_sentences_and_a_row_for_each_joint() -> None:
    found = answer()
    data = document(found).data
    assert data["joints"]["pin"]["life"]["hours"] == pytest.approx(
        found.joints[0].life.turns * found.turn / 3600.0
    )
    effect, fits, life = data["conclusion"]
    assert "the largest force on pin" in effect and found.joints[0].fit in fits and "955 rpm" in life
    assert turns_words(found.joints[0].life.turns) in life
    assert "pin" in repr(found) and "<table>" in found._repr_html_()


def test_a_model_without_clearance_or_crank_is_refused() -> None:
    with pytest.raises(ModelError, match="no joint has clearance"):
        vfife.design(vfife.gallery.four_bar_ideal())
    model = loose_pin()
    model.drivers.clear()
    with pytest.raises(ModelError, match="no crank turns"):
        vfife.design(model)


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"of": "pin.fource.max"}, "pin.force.max"),
        ({"limit": "2 m"}, "limit"),
        ({"wear": "cheese on steel"}, "wear"),
        ({"cost": {"IT70": "x"}}, "cost"),
        ({"share": 2.0}, "share"),
    ],
)
def test_arguments_are_refused_before_anything_is_computed(given, words) -> None:
    with pytest.raises(ModelError, match=words):
        vfife.design(loose_pin(), **given)


def stub(monkeypatch, name, result):
    def compute(*_, progress, **__):
        progress(Progress(1, 2, 1.0))
        if isinstance(result, BaseException):
            raise result
        return result

    monkeypatch.setattr(module, name, compute)


@pytest.mark.slow("the answer of a part")
def test_a_part_that_fails_is_named_and_the_others_are_there(monkeypatch) -> None:
    stub(monkeypatch, "sensitivity", VfifeError("the run diverged"))
    stub(monkeypatch, "wear", answer().wear)
    found = vfife.design(loose_pin(), **BRIEF, **WEAR)
    assert found.missing == {
        "sensitivity": "the run diverged",
        "fits": "the value of pin.force.max is not known; give it a limit",
    }
    assert found.complete and found.joints[0].life == answer().joints[0].life and found.joints[0].fit is None
    assert "not known: the run diverged." in document(found).data["conclusion"][0]


@pytest.mark.slow("the answer of a part")
def test_ctrl_c_leaves_the_parts_that_are_complete(monkeypatch) -> None:
    stub(monkeypatch, "sensitivity", answer().sensitivity)
    stub(monkeypatch, "allocate", KeyboardInterrupt())
    with pytest.raises(Interrupted) as caught:
        vfife.design(loose_pin(), **BRIEF, **WEAR)
    found = caught.value.result
    assert found.missing == {"fits": module.INTERRUPTED, "life": module.INTERRUPTED}
    assert found.joints[0].effect == answer().joints[0].effect
    data = document(found).data
    assert data["status"] == "interrupted" and data["joints"]["pin"]["life"] is None


@pytest.mark.slow("the answer of a part")
def test_a_wear_that_was_interrupted_has_no_range(monkeypatch) -> None:
    part = dataclasses.replace(answer().wear, step_difference=())
    stub(monkeypatch, "sensitivity", answer().sensitivity)
    stub(monkeypatch, "allocate", answer().allocation)
    stub(monkeypatch, "wear", part)
    with pytest.raises(Interrupted) as caught:
        vfife.design(loose_pin(), **BRIEF, **WEAR)
    assert caught.value.result.joints[0].life.span is None


@pytest.mark.slow("the answer of a part")
def test_a_life_of_a_pair_of_materials_has_the_scatter_of_its_tests() -> None:
    found = answer()
    wear = dataclasses.replace(
        found.wear,
        spec=dataclasses.replace(
            found.wear.spec,
            model=vfife.Mechanism.to_toml(module.with_wear(loose_pin(), "tool steel on tool steel")),
        ),
    )
    plain, pair = (dataclasses.replace(found, wear=one).joints[0].life for one in (found.wear, wear))
    assert pair.turns == plain.turns and pair.span == pytest.approx(
        (plain.span[0] / 10.0, plain.span[1] * 10)
    )


def test_letters_are_those_of_the_nearest_running_fit() -> None:
    model = vfife.gallery.compressor()
    fits = {name: module.nearest_fit(model, name) for name in model.contacts}
    assert fits == {"big-end": "H7/f7", "small-end": "H7/g7", "cylinder": "H7/e7"}
    large = dataclasses.replace(model.joints["big-end"], bearing_radius=1.0)
    model.joints["big-end"] = large
    assert module.nearest_fit(model, "big-end") == ""


def test_a_part_shows_its_progress_as_that_of_the_whole_and_refuses_hours() -> None:
    shown: list[Progress] = []
    part = PartJob(Job("design", None, False, shown.append), "fits", (0.25, 0.75))
    part(Progress(1, 2, 3.0))
    assert shown[0].share == pytest.approx(0.5) and shown[0].text == "fits: 1 of 2 steps"
    with pytest.raises(VfifeError, match=r"--yes"):
        part.begin(Forecast("block", seconds=1e5))
    PartJob(Job("design", None, True, shown.append), "fits", (0.0, 1.0)).begin(Forecast("block", seconds=1e5))


def test_a_clearance_is_reached_between_points_or_beyond_the_last() -> None:
    class Points:
        joints = ("pin",)

    from vfife.tribology.wear_state import Worn

    def turns_to(clearance, column):
        import numpy as np

        worn = Points()
        worn.turns, worn.clearance = np.array([0.0, 10.0, 30.0]), np.array(column)[:, None]
        return Worn.turns_to(worn, "pin", clearance)

    assert turns_to(3.0, [1.0, 2.0, 4.0]) == pytest.approx(20.0)
    assert turns_to(5.0, [1.0, 2.0, 4.0]) == pytest.approx(40.0)
    assert turns_to(1.0, [1.0, 2.0, 4.0]) == 0.0
    assert turns_to(5.0, [1.0, 4.0, 4.0]) == math.inf


def test_numbers_of_turns_have_two_digits() -> None:
    assert [turns_words(value) for value in (14_394_181.0, 83.4, 12_345.0, 3.2e9)] == [
        "14 million", "83", "12,000", "3.2 thousand million",
    ]  # fmt: skip


def test_a_model_without_wear_names_the_table_to_add_and_no_command_that_would_fail(monkeypatch) -> None:
    """``vfife wear`` refuses a model in which no joint has a coefficient."""
    stub(monkeypatch, "sensitivity", VfifeError("the run diverged"))
    data = document(vfife.design(loose_pin(), **BRIEF))
    steps = " ".join(data.parts[0].parts[-1].parts[0].texts)
    assert "below [joint.pin]" in steps and "vfife wear" not in steps and "--wear 1e-15" in steps
    assert data.data["conclusion"][2] == (
        "How long the joints last is not estimated: no joint of the model has a coefficient of wear."
    )


@pytest.mark.slow("the same answer")
def test_without_a_choice_of_fits_no_machines_are_counted() -> None:
    found = answer()
    none = dataclasses.replace(found, allocation=dataclasses.replace(found.allocation, choice=None))
    for one, counted in ((found, True), (none, False)):
        texts = " ".join(document(one).parts[0].parts[-2].parts[0].texts)
        assert ("machines exceed the limit" in texts) == counted
    assert "allow finer grades (--cost)" in document(none).data["conclusion"][1]
