"""A design answer: the numbers of its three parts, joints that have none, limits, and an interruption."""

import dataclasses
import math
import time
from functools import cache
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

import vfife
from vfife.assessment import design_work as module
from vfife.assessment import sample
from vfife.assessment.answer import LIFE
from vfife.errors import ModelError, VfifeError
from vfife.job.amounts import span
from vfife.job.cost import Forecast
from vfife.job.job import Interrupted, Job, PartJob
from vfife.modelfile import loads
from vfife.report.amounts import prefixed
from vfife.report.cautions import law_cautions
from vfife.report.design import document, life_range, life_sentence, row, turns_words, value_cautions
from vfife.results.derivatives import Effect
from vfife.solvers.arguments import Arguments
from vfife.solvers.status import Progress
from vfife.studies import allocate
from vfife.studies.methods.allocation import machine_counts, most_machines
from vfife.tribology.wear_state import clearances, sharpness

WEAR = {"wear": 1e-15, "wear_turns": 1e5}
BRIEF = {"share": 0.5, "turns": 1}


def loose_pin() -> vfife.Mechanism:
    return vfife.gallery.slider_crank_loose_pin(friction=0.05, clearance=2e-4, restitution=0.5)


@cache
def answer():
    return vfife.design(loose_pin(), **BRIEF, **WEAR)


@pytest.mark.slow("derivatives, machines and wear")
def test_the_parts_have_the_values_that_they_have_alone() -> None:
    from vfife.studies.engine.cases import run_cases
    from vfife.studies.spec.plan import CaseSpec

    found, model = answer(), loose_pin()
    (joint,) = found.joints
    alone = vfife.sensitivity(model, [found.measure], ["joint.pin.clearance"], turns=1)
    assert found.sensitivity.effect(found.measure, "joint.pin.clearance") == alone.effect(
        found.measure, "joint.pin.clearance"
    )
    assert joint.growth == pytest.approx(10e-6)
    spec = CaseSpec((found.measure,), 1, last=1)
    machines = [{"joint.pin.clearance": clearance} for clearance in (2e-4, 2e-4 + 10e-6)]
    forces = {k: outcome.values[found.measure] for k, outcome in run_cases(model, machines, spec)}
    change = 100.0 * (forces[1] / forces[0] - 1.0)
    width = max(joint.effect.high - joint.effect.low, 0.05 * abs(change))
    assert joint.effect.low - width <= change <= joint.effect.high + width
    assert found.limit == pytest.approx(1.1 * found.nominal)
    worn = vfife.wear(module.with_wear(model, 1e-15, "design()"), 1e5, clearance=LIFE * 2e-4)
    rate = (worn.clearance[-1, 0] - worn.clearance[-2, 0]) / (worn.turns[-1] - worn.turns[-2])
    assert joint.life.turns == pytest.approx(worn.turns[-1] + (4e-4 - worn.clearance[-1, 0]) / rate)
    error = max(worn.step_difference) + worn.spread.max()
    assert (
        joint.life.span[0] == pytest.approx(joint.life.unsmoothed / (1.0 + error)) and not joint.life.reached
    )
    assert (
        joint.life.span[1] == pytest.approx(joint.life.uniform / (1.0 - error)) and not joint.life.determined
    )
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
    assert f"after {life_range(found.joints[0].life)} turns" in life
    assert turns_words(found.joints[0].life.turns) in life
    assert "pin" in repr(found) and "<table>" in found._repr_html_()


def test_machines_within_the_limits_of_fits_keep_the_clearance_of_joints_without_fit() -> None:
    """Machines that rank the clearances vary all of them, also that of a joint without fit."""
    from vfife.assessment.answer import Design
    from vfife.assessment.sample import MachineSample
    from vfife.report.fits import machine_words

    clearances = np.array([[1e-5, 5e-5], [2e-5, 3e-5]])
    sample = MachineSample(("pin", "guide"), clearances, np.array([1.0, 9.0]))
    corners = MachineSample(("pin",), clearances[:, :1], np.array([1.0, 2.0]))
    pin = SimpleNamespace(name="pin", limits=(1e-5, 3e-5), clearance=1e-5)
    guide = SimpleNamespace(name="guide", limits=None, clearance=4e-5)
    within, even = Design._within_limits.fget, Design.even_machines.fget
    found = SimpleNamespace(
        corners=corners, sample=sample, joints=[pin, guide], inside=None, around=None, even_machines=[]
    )
    assert even(found) == [] and within(found) == [corners]
    assert machine_words(found) == "2 machines with the clearance at a limit; all with 40 µm in guide"
    guide.limits = (2e-5, 6e-5)
    found.even_machines = even(found)
    (inner, _) = within(found)
    assert inner.values.tolist() == [1.0, 9.0] and "all with" not in machine_words(found)


def test_machines_near_the_largest_lie_within_the_limits_and_roughness_is_told_from_a_slope() -> None:
    from vfife.assessment.sample import MachineSample, clearances_around, sampled_clearances

    limits = {"E": (1e-5, 6.2e-5), "F": (1e-5, 6.2e-5)}
    rows = clearances_around({"F": 6e-5, "E": 3e-5}, limits)
    assert rows.shape == (8, 2) and (np.abs(rows - [3e-5, 6e-5]) <= 0.125 * 5.2e-5 + 1e-12).all()
    assert rows.min() >= 1e-5 and rows.max() <= 6.2e-5 and np.ptp(rows, axis=0).min() > 5e-6
    places = sampled_clearances(limits)
    noise = np.random.default_rng(1).uniform(0.01, 0.04, len(places))
    assert MachineSample(("E", "F"), places, places @ [300.0, 500.0]).jump == 0.0
    assert MachineSample(("E", "F"), places, noise).jump == pytest.approx(0.03 / math.sqrt(6.0), rel=0.3)


def test_the_largest_value_is_that_of_a_sample_and_how_many_may_exceed_it_is_said() -> None:
    """Of 59 machines none exceeds it: at most 5 % of all do, with 95 % confidence."""
    from vfife.assessment.sample import MachineSample
    from vfife.report.fits import bound_sentence

    def said(count: int, last: float = 1.0) -> str:
        values = np.append(np.ones(count - 1), last) if count else np.empty(0)
        even = [MachineSample(("pin",), np.full((count, 1), 1e-5), values)] if count else []
        found = {"values_within_limits": np.array([1.0, 2.0]), "limit": 3.0, "nominal": 1.0, "ideal": None}
        found |= {"allocation": None, "unit": "N", "default_limit": False, "even_machines": even}
        return bound_sentence(SimpleNamespace(**found))

    assert "more than 2 N: at most 5.0 % of machines" in said(59) and "95 % confidence" in said(59)
    assert "at most 25.9 % of machines" in said(10)
    for text in (said(0), said(59, math.nan)):
        assert (
            text
            == "Other clearances within these limits may give more than 2 N: in how many is not estimated."
        )


def test_finer_grades_are_no_remedy_where_all_machines_exceed_the_limit() -> None:
    from vfife.assessment.sample import MachineSample
    from vfife.report.fits import fit_remedy

    sample = MachineSample(("pin",), np.full((2, 1), 1e-5), np.array([2.0, 3.0]))
    found = {"limit": 1.0, "nominal": 2.0, "ideal": None, "allocation": None, "unit": "N", "ranks": {}}
    found |= {"default_limit": False, "values_within_limits": [], "sample": sample, "letters": {}}
    said = fit_remedy(SimpleNamespace(**found))
    assert "all 2 machines" in said and "with 2 N or more" in said and "finer" not in said
    assert "finer grades" in fit_remedy(SimpleNamespace(**found | {"limit": 2.5}))


def test_a_rough_measure_near_its_limit_may_exceed_it_in_more_machines() -> None:
    from vfife.report.fits import jump_sentence

    given = {"values_within_limits": np.array([0.01, 0.038]), "limit": 0.04, "nominal": 0.02, "ideal": None}
    given |= {"allocation": None, "unit": "m/s", "default_limit": False}
    for jump, said in ((0.012, True), (0.001, False), (0.0, False)):
        text = jump_sentence(SimpleNamespace(**given, jump=jump))
        assert bool(text) == said and ("a larger share" in text) == said


@pytest.mark.slow("the same answer")
def test_the_answer_says_how_machines_are_distributed_and_what_happens_at_the_limits() -> None:
    from vfife.studies.engine.cases import run_cases
    from vfife.studies.spec.plan import CaseSpec

    found = answer()
    spec = CaseSpec((found.measure,), 1, last=1)
    ends = [{"joint.pin.clearance": limit} for limit in found.joints[0].limits]
    forces = {k: outcome.values[found.measure] for k, outcome in run_cases(loose_pin(), ends, spec)}
    around, found = found.around, dataclasses.replace(found, around=None)
    limits = found.joints[0].limits
    assert around.count == 16 and limits[0] <= around.clearances.min() <= around.clearances.max() <= limits[1]
    near = document(dataclasses.replace(found, around=around)).data["conclusion"][1]
    assert "16 near the machine with the largest value" in near and "may give more" in near
    alone = dataclasses.replace(found, sample=None)
    assert alone.values_within_limits == pytest.approx([forces[0], forces[1]], rel=1e-12)
    assert found.values_within_limits[-2:].tolist() == alone.values_within_limits.tolist()
    text, whole = (document(one).data["conclusion"][1] for one in (alone, found))
    assert (
        "normally distributed about the middle of their tolerance zones, with the limits at 3 stand" in text
    )
    assert "(2 machines with the clearance at a limit)" in text and "none of these 2 machines exceed" in text
    inner = int(found.sample.within({"pin": found.joints[0].limits}).sum())
    assert f"({inner} machines evenly distributed, 2 with the clearance at a limit)" in whole
    corners = dataclasses.replace(found.corners, values=found.corners.values * [1.0, 2.0])
    text = document(dataclasses.replace(alone, corners=corners)).data["conclusion"][1]
    assert "1 of these 2 machines exceeds the limit" in text
    # The machine with the largest value is named, and a run with its clearances has its value.
    largest = max(forces, key=lambda k: forces[k])
    assert alone.clearances_of_largest == {"pin": pytest.approx(found.joints[0].limits[largest])}
    every = [*found.sample.values[found.sample.within({"pin": found.joints[0].limits})], *forces.values()]
    size = found.clearances_of_largest["pin"]
    spot = [{"joint.pin.clearance": size}]
    ((_, outcome),) = run_cases(loose_pin(), spot, spec)
    assert outcome.values[found.measure] == pytest.approx(max(every), rel=1e-9)
    assert f"It is largest with {prefixed(size, 'm')} in pin. Machines have no cautions about" in whole
    page = document(found, "my pump.toml")
    command = f"vfife run 'my pump.toml' --turns 1 --set 'joint.pin.clearance={1e6 * size:.6g} um'"
    assert any(text.startswith(command) for text in page.parts[0].parts[-1].parts[0].texts)
    assert page.data["within_limits"]["largest_clearances"] == found.clearances_of_largest


@pytest.mark.slow("the same answer")
def test_a_fit_at_the_edge_of_the_search_says_so() -> None:
    found = answer()
    (option,) = found.allocation.choice.options
    (options,) = found.allocation.task.options
    coarsest = max(options, key=lambda one: one.clearance.limits[1])
    for chosen in options:
        choice = dataclasses.replace(found.allocation.choice, options=(chosen,))
        other = dataclasses.replace(found, allocation=dataclasses.replace(found.allocation, choice=choice))
        data = document(other).data
        says = "Coarser fits than these were not tried" in data["conclusion"][1]
        assert says == bool(data["coarsest"]) == (chosen == coarsest), chosen
    assert len(options) > 1 and option in options


def test_machines_of_the_sample_count_where_all_their_clearances_lie_within_the_limits() -> None:
    import numpy as np

    from vfife.assessment.sample import MachineSample, corner_clearances, corner_count

    clearances = np.array([[1.0, 5.0], [2.0, 5.0], [2.0, 9.0]])
    sample = MachineSample(("a", "b"), clearances, np.array([1.0, 2.0, 3.0]))
    assert sample.within({"a": (1.5, 3.0)}).tolist() == [False, True, True]
    assert sample.within({"a": (1.5, 3.0), "b": (4.0, 6.0)}).tolist() == [False, True, False]
    limits = dict.fromkeys("abcd", (1.0, 2.0))
    assert corner_clearances(limits).tolist() == [[1.0] * 4, [2.0] * 4] and corner_count(4) == 2
    few = {name: limits[name] for name in "abc"}
    assert len({tuple(row) for row in corner_clearances(few).tolist()}) == corner_count(3) == 8


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
    stub(monkeypatch, "wear", answer().wear)  # before the others: the answer is computed once, by all parts
    stub(monkeypatch, "sensitivity", VfifeError("the run diverged"))
    found = vfife.design(loose_pin(), **BRIEF, **WEAR)
    assert found.missing == {"sensitivity": "the run diverged"}  # the limit is that of the nominal machine
    assert found.complete and found.joints[0].life == answer().joints[0].life
    assert found.joints[0].fit == answer().joints[0].fit
    cautions = " ".join(document(found).parts[0].parts[-2].parts[0].texts)
    assert "Derivatives do not confirm these effects: the run diverged." in cautions


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
    found = caught.value.result
    (joint,) = found.joints
    assert joint.life.span is None and not joint.life.determined
    # The table has the range of the conclusion, which is what the model permits.
    life = part.life("pin", joint.life.clearance)
    shown = life_range(dataclasses.replace(found, wear=answer().wear).joints[0].life._replace(
        span=(life.shortest, life.longest)
    ))  # fmt: skip
    assert row(found, joint)[-1] == shown and f"after {shown} turns" in life_sentence(found)
    bullets = " ".join(document(found).parts[0].parts[-2].parts[0].texts)
    assert "The life of pin lacks scatter over turns and the error of the time step" in bullets


@pytest.mark.slow("the answer of a part")
def test_a_life_of_a_pair_of_materials_has_the_scatter_of_its_tests() -> None:
    found = answer()
    wear = dataclasses.replace(
        found.wear,
        spec=dataclasses.replace(
            found.wear.spec,
            model=vfife.Mechanism.to_toml(
                module.with_wear(loose_pin(), "tool steel on tool steel", "design()")
            ),
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
    assert "below [joint.pin]" in steps and "vfife wear" not in steps and "--wear 8e-17" in steps
    assert "with oil" in steps and "1e-15" not in steps
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


@pytest.mark.slow("machines for the fits")
def test_a_measure_without_derivatives_ranks_clearances_by_the_machines_of_the_fits() -> None:
    """Knocks are counted over a run and have no derivatives; the page answers all the same, and recommends no
    command that fails. Progress counts the machines that rank.
    """
    model, shown = vfife.gallery.compressor(), list[tuple[float, str]]()
    found = vfife.design(
        model, "small-end.approach_speed.max", limit="0.25 m/s", **BRIEF,
        progress=lambda share, text: shown.append((share, text)),
    )  # fmt: skip
    ranking = [(share, text) for share, text in shown if text.startswith("ranks: ")]
    assert len(ranking) == 65 and "64 of 64 machines" in ranking[-1][1]
    assert ranking == sorted(ranking, key=lambda entry: entry[0]) and ranking[-1][0] > ranking[1][0]
    assert "has no derivatives" in found.missing["sensitivity"] and "fits" not in found.missing
    assert set(found.ranks) == set(found.letters)
    for joint in found.joints:
        assert -1.0 <= joint.rank.low <= joint.rank.value <= joint.rank.high <= 1.0
    inside = found.sample.within({joint.name: joint.limits for joint in found.joints})
    values = [
        *found.sample.values[inside],
        *(found.inside.values if found.inside else ()),
        *found.around.values,
        *found.corners.values,
    ]
    assert found.values_within_limits == pytest.approx([value for value in values if math.isfinite(value)])
    page = document(found, "k.toml")
    assert "machines, whose clearances vary from the finest to the coarsest fit, it lies" in str(page)
    assert "Effects are linear" not in str(page) and "small-end.force.max has it" in str(page)
    assert "rank correlation" in page.data["conclusion"][0] and "fits nothing" not in str(page)
    assert "vfife sensitivity" not in " ".join(page.parts[0].parts[-1].parts[0].texts)
    assert page.data["joints"]["small-end"]["rank"]["value"] == found.ranks["small-end"].value


def test_partial_ranks_find_the_column_that_decides_and_cover_the_others() -> None:
    import numpy as np

    from vfife.assessment.ranking import partial_ranks

    random = np.random.default_rng(3)
    covered = np.zeros(3)
    for _ in range(200):
        points = random.random((80, 3))
        points[:, 2] += 0.8 * points[:, 0]  # correlated with what decides, without an effect of its own
        found = partial_ranks(points, np.exp(3.0 * points[:, 0]) + 2.0 * random.random(80))
        assert found[0].low > 0.5
        covered += [one.low <= 0.0 <= one.high for one in found]
    assert covered[0] == 0 and min(covered[1:]) > 180
    points[:, 1] = 1.0
    values = points[:, 0].copy()
    values[:10] = math.nan
    constant, few = partial_ranks(points, values), partial_ranks(points[:20], values[:20])
    assert constant[1] is None and constant[0].value == pytest.approx(1.0) and few == [None] * 3


def test_measures_of_geared_machines_are_of_whole_cycles() -> None:
    model = vfife.gallery.slider_crank_loose_pin()
    model.point("M", -0.2, 0.0)
    model.rigid_body("motor", mass=1.0, inertia=1e-3)
    model.revolute("M", "ground.M", "motor.center")
    model.gear("box", "motor", "crank", ratio=-1.0 / 3.0)
    model.drivers.clear()
    model.drive("motor", speed=100.0)
    for turns, averaged in ((3, 1), (4, 3), (8, 3), (13, 6)):
        part = module.DesignWork(model, None, {**BRIEF_OPTIONS, "turns": turns})
        assert part.averaged == averaged, "the first turn has the fall of the journals"


@pytest.mark.slow("the same answer")
def test_the_nominal_machine_is_measured_as_the_machines_of_the_fits() -> None:
    from vfife.studies.engine.cases import run_cases
    from vfife.studies.spec.plan import CaseSpec

    work = module.DesignWork(vfife.gallery.compressor(), None, {**BRIEF_OPTIONS, "turns": 5})
    assert work.tables(1.0)["last"] == work.averaged == 2
    work.run_nominal()
    spec = CaseSpec((work.measure,), 5, last=2)
    ((_, outcome),) = run_cases(work.mechanism, [{}], spec)
    low, high = work.nominal_range
    assert low <= work.nominal <= high and work.limit == pytest.approx(1.1 * work.nominal)
    assert low - 1e-3 * low < outcome.values[work.measure] < high + 1e-3 * high


@pytest.mark.slow("a design with its fits")
def test_fits_that_were_chosen_survive_an_interruption_of_the_machines_within_their_limits(
    monkeypatch,
) -> None:
    stub(monkeypatch, "sensitivity", answer().sensitivity)
    stub(monkeypatch, "allocate", answer().allocation)

    def interrupted(limits):
        raise KeyboardInterrupt

    monkeypatch.setattr(module, "corner_clearances", interrupted)
    with pytest.raises(Interrupted) as caught:
        vfife.design(loose_pin(), **BRIEF, **WEAR)
    found = caught.value.result
    assert found.missing == {"limits": module.INTERRUPTED, "life": module.INTERRUPTED}
    assert found.joints[0].fit == answer().joints[0].fit and not len(found.values_within_limits)
    text = str(document(found).parts[0].parts[0])
    assert "parts are missing: lives and machines within the limits of the fits" in text


def test_a_ranking_alone_costs_no_derivatives_where_no_effect_is_known(monkeypatch) -> None:
    """Effects of larger clearances disagree on the sign, so that derivatives have nothing to check."""
    model = loose_pin()
    unknown = {"joint.pin.clearance": Effect("joint.pin.clearance", "unknown", 0.1, -0.2, 0.3)}
    monkeypatch.setattr(module, "growth_effects", lambda *_: unknown)
    stub(monkeypatch, "sensitivity", AssertionError("derivatives were computed"))
    found = vfife.design(model, **BRIEF, ranking=True)
    assert found.complete and found.sample.count == module.MACHINES
    assert found.missing == {"fits": module.RANKING, "life": module.RANKING}
    low, high = found.sample.span
    assert high > 1.01 * low  # so that the sentence must not say that the clearance does not matter
    first = document(found).data["conclusion"][0]
    assert "matters most" in first or "visibly" in first


def test_the_forecast_times_machines_with_different_clearances(monkeypatch) -> None:
    """Machines that hardly differ take the same way through each step: half the time, with five pins."""
    runs = []
    run_cases = sample.run_cases

    def recorded(mechanism, machines, spec):
        runs.append((list(machines), spec.turns))
        return run_cases(mechanism, machines, spec)

    monkeypatch.setattr(sample, "run_cases", recorded)
    monkeypatch.setattr(sample, "timed", lambda work: (work(), 16.0)[1])
    work = module.DesignWork(vfife.gallery.compressor(), None, {**BRIEF_OPTIONS, "turns": 5})
    work.machine_seconds = work.timed_machine()
    assert work.machine_seconds == pytest.approx(16.0 / 8 * 5 / module.cores())
    (_, compiled), (machines, turns) = runs
    assert len(machines) == 8 and turns == compiled == 1
    for path in machines[0]:
        values = [machine[path] for machine in machines]
        assert max(values) > 1.2 * min(values), path
    work.nominal, work.nominal_range = 1.0, (0.9, 1.1)  # sensitive, so that machines rank
    assert work.forecast()["ranks"].seconds == pytest.approx(64 * work.machine_seconds)


BRIEF_OPTIONS = {"limit": None, "share": 0.5, "cost": None, "wear": None, "clearance": None}


@pytest.mark.slow("the same answer")
def test_the_sentence_and_the_caution_on_lives_say_the_same() -> None:
    found = answer()
    assert not found.wears_by_pair
    page = document(found)
    assert "if the wear coefficient is exact" in page.data["conclusion"][2]
    cautions = " ".join(page.parts[0].parts[-2].parts[0].texts)
    assert "not the coefficient" in cautions and "factor of ten" not in cautions


def test_a_line_of_progress_does_not_go_backward_where_a_search_needs_more_cases(monkeypatch) -> None:
    from vfife.job.progress import Counter, ProgressLine

    line, counter = ProgressLine(quiet=True), Counter("cases", 0.0)
    shares = []
    for done, total in ((1, 10), (9, 10), (11, 20), (12, 20)):
        line(counter(done, total))
        shares.append(line.share)
    assert shares == [0.1, 0.9, 0.9, 0.9] and "more than the 10 of the forecast" in line.last
    assert line.last.startswith("12 of 20 cases")  # a share of the forecast would mean nothing
    line(Progress(9, 10, 1.0))  # a run that is followed by other work
    line(Progress(1, 100, 1.0, "1 of 100 runs"))
    assert line.share == 0.01
    shown: list[Progress] = []
    part = PartJob(Job("design", None, False, shown.append), "fits", (0.0, 1.0))
    for done, total in ((9, 10), (11, 20), (19, 20)):
        part(Progress(done, total, 1.0, "cases"))
    assert [one.share for one in shown] == pytest.approx([0.9, 0.9, 0.95])
    part(Progress(20, 24, 1.0, "20 of 24 cases", beyond_forecast=True))
    line(shown[-1])
    assert line.last == "fits: 20 of 24 cases"


def test_the_progress_of_a_search_moves_beyond_its_forecast() -> None:
    """It may need many times as many machines: the bar does not stand at the end of its part."""
    shown: list[Progress] = []
    part = PartJob(Job("design", None, False, shown.append), "fits", (0.5, 1.0), limit=1600)
    for done, total in ((100, 200), (400, 420), (900, 920), (1600, 1600)):
        part(Progress(done, total, 1.0, "cases", total > 200))
    assert [one.share for one in shown] == pytest.approx([0.625, 0.75, 0.875, 1.0])


def test_the_cases_of_a_search_are_within_a_forecast_that_covers_its_dearest_case() -> None:
    """The first line has the time of all machines that a search may need, so it does not pass its forecast
    before these.
    """
    shown: list[Progress] = []
    part = PartJob(Job("design", None, False, shown.append), "fits", (0.0, 1.0), limit=1600)
    for done, total in ((100, 179), (349, 352), (1600, 1700)):
        part.count(done, total, "cases")
    first, further, beyond = shown
    assert first.text.endswith("1,600 at most") and not first.beyond_forecast
    assert "349 of 352 cases" in further.text and further.text.endswith("1,600 at most")
    assert not further.beyond_forecast
    assert beyond.beyond_forecast and "more than the 1,600 of the forecast" in beyond.text


def test_the_first_line_has_the_time_of_the_dearest_case() -> None:
    """All choices close to the limit, the step halved, and ranks, which a sensitive motion needs."""
    part = work(three_loose_pins(), cost=GRADES, turns=10)
    part.nominal, part.nominal_range, part.machine_seconds = 1.0, (1.0, 1.0), 2.0
    forecasts = part.forecast()
    least, largest = machine_counts(part.allotment[1])
    most = most_machines(part.allotment[1])
    assert forecasts["fits"].ends == (2.0 * least, 2.0 * most) and least < largest < most
    assert forecasts["fits"].ends[0] < forecasts["fits"].seconds < forecasts["fits"].ends[1]
    total = module.total_forecast(forecasts, "", ranking=100.0)
    assert total.ends is not None and total.ends[1] == pytest.approx(
        100.0 + sum(forecast.longest for forecast in forecasts.values())
    )
    said = total.sentence(None)
    assert f"{span(total.ends[0])} to {span(total.ends[1])} in the cheapest and the dearest case" in said
    assert f"{most:,} ({span(2.0 * most)}) at most" in total.parts[-1]


@pytest.mark.slow("the same answer")
def test_no_effect_is_known_where_no_derivative_was_computed() -> None:
    found = answer()
    measure = found.measure
    nothing = dataclasses.replace(found.sensitivity, derivatives=[], doubtful=frozenset({measure}))
    (joint,) = dataclasses.replace(found, sensitivity=nothing).joints
    assert found.joints[0].effect is not None and joint.effect is None


def grooved(found, deep: float):
    """The answer with a groove of one place in 360 in its bearing, ``deep`` clearances deep at the end."""
    wear = found.wear
    depth = wear.depth.copy()
    depth[:, 0, 0] += deep * wear.surfaces[0].clearance * wear.turns / wear.turns[-1]
    clearance = np.array([clearances(wear.surfaces, one, wear.spec.harmonics) for one in depth])
    sharp = np.array([sharpness(wear.surfaces, one, wear.spec.harmonics) for one in depth])
    worn = dataclasses.replace(wear, depth=depth, clearance=clearance, sharp=sharp)
    return dataclasses.replace(found, wear=worn)


@pytest.mark.slow("the same answer")
def test_the_range_of_a_life_that_the_model_does_not_determine_reaches_to_wear_spread_evenly() -> None:
    """By hand: depths of a place and of the mean grow by the same share of the last jump."""
    found = grooved(answer(), 3.0)
    (joint,), wear, clearance = found.joints, found.wear, answer().joints[0].clearance
    mean = wear.depth.mean(axis=2).sum(axis=1)
    rate = (mean[-1] - mean[-2]) / (wear.turns[-1] - wear.turns[-2])
    even = wear.turns[-1] + (clearance - mean[-1]) / rate
    deepest = wear.depth.max(axis=2).sum(axis=1)
    assert joint.life.uniform == pytest.approx(even) and not joint.life.determined
    assert joint.life.unsmoothed == pytest.approx(np.interp(clearance, deepest, wear.turns))
    assert joint.life.span[0] <= joint.life.unsmoothed < joint.life.turns < even <= joint.life.span[1]
    assert "not determined" in row(found, joint) and life_range(joint.life) in row(found, joint)


@pytest.mark.slow("the same answer")
def test_the_page_says_as_wear_does_that_a_groove_is_deeper_than_the_clearance_and_narrow() -> None:
    from vfife.report.wear import document as worn

    found = grooved(answer(), 3.0)
    for page in (" ".join(document(found).data["conclusion"]), found._repr_html_()):
        said = " ".join(page.split())
        assert "groove in pin" in said and "no smoothed clearance describes that joint" in said
        assert "narrower than the journal, which would rest on their edges" in said
        assert "The model determines no more than this range" in said
    spec = dataclasses.replace(found.wear.spec, clearance=found.joints[0].life.clearance)
    wear = worn(dataclasses.replace(found.wear, spec=spec))
    assert "narrower than the journal, which would rest on their edges" in str(wear.parts)
    assert "The model determines no more than this range" in str(wear.parts)
    assert "groove" not in life_sentence(determined(answer()))


def determined(found):
    """The answer with even wear of its surfaces."""
    wear = found.wear
    depth = wear.depth.mean(axis=2, keepdims=True) + 0.0 * wear.depth
    clearance = wear.surfaces[0].clearance + depth[:, :, :1].sum(axis=1)
    return dataclasses.replace(found, wear=dataclasses.replace(wear, depth=depth, clearance=clearance))


@pytest.mark.slow("the same answer")
def test_a_life_that_the_model_determines_has_the_range_of_the_step() -> None:
    found = determined(answer())
    (joint,) = found.joints
    error = max(found.wear.step_difference) + found.wear.spread.max()
    assert joint.life.determined and joint.life.turns == pytest.approx(joint.life.uniform)
    assert joint.life.span == pytest.approx((joint.life.turns / (1 + error), joint.life.turns / (1 - error)))
    assert turns_words(joint.life.turns) in row(found, joint)


@pytest.mark.slow("the same answer")
def test_which_joint_wears_first_is_not_determined_where_the_ranges_of_lives_differ() -> None:
    from vfife.report.design_words import first_joints

    life = answer().joints[0].life
    narrow, broad = life._replace(turns=2e6, span=(1e5, 9e6)), life._replace(turns=1e6, span=(2e5, 3e6))
    assert first_joints([(2e6, "A", narrow), (1e6, "B", broad)]) == ["A", "B"]
    late = narrow._replace(span=(3e5, 9e6))
    assert first_joints([(2e6, "A", late), (1e6, "B", broad)]) == ["B"]


GRADES = {"IT6": 4.0, "IT7": 2.5, "IT8": 1.6, "IT9": 1.0}  # seven fits for each joint, 343 choices for three


def three_loose_pins() -> vfife.Mechanism:
    """A four-bar linkage with clearance in three joints of 16 mm."""
    loose = {"kind": "clearance", "clearance": 2e-5, "bearing_radius": 8e-3, "axial_length": 2e-2}
    contact = 'contact = { law = "lankarani-nikravesh", restitution = 0.5 }'
    table = "\n".join(f"{key} = {value!r}".replace("'", '"') for key, value in loose.items())
    joints = {"A": ("ground.A", "crank.start"), "B": ("crank.end", "coupler.start")}
    joints |= {"C": ("coupler.end", "rocker.end"), "D": ("ground.D", "rocker.start")}
    return loads(
        "[ground]\nA = [0, 0]\nD = [0.3, 0]\n"
        '[run]\nturns = 1\n[driver.crank]\nspeed = "60 rpm"\n'
        + "".join(
            f'[body.{name}]\nlength = {length}\nmass = 0.5\nangle = "{angle} deg"\n'
            for name, length, angle in (("crank", 0.1, 90), ("coupler", 0.25, 30), ("rocker", 0.22, 90))
        )
        + "".join(
            f'[joint.{name}]\nbearing = "{bearing}"\njournal = "{journal}"\n'
            + (f"{table}\n{contact}\n" if name != "A" else "")
            for name, (bearing, journal) in joints.items()
        )
    )


def work(model: vfife.Mechanism, of: str | None = None, **options) -> module.DesignWork:
    given = {"share": 0.95, "turns": 1, "limit": None, "cost": None, "wear": None, "clearance": None}
    return module.DesignWork(model, of, given | {"wear_turns": 1e6} | options)


def test_many_joints_get_fits_joint_by_joint_and_some_or_the_same_if_asked() -> None:
    model = three_loose_pins()
    assert work(model).search == "all" and work(model, cost=GRADES).search == "descent"
    assert work(model, cost=GRADES, same_fit=True).search == "same"
    part = work(model, cost=GRADES, joints=["D", "B"])
    assert list(part.letters) == ["B", "D"] and part.search == "all"
    assert set(part.tables(1.0)["vary"]) == {"B", "D"}
    with pytest.raises(ModelError, match="did you mean|B, C, D"):
        work(model, joints=["E"])


@pytest.mark.system("machines for ranks and fits; compares times")
def test_a_descent_ranks_clearances_first_and_its_forecast_counts_every_part() -> None:
    """A forecast without a part was five times too short; other work on the processors doubles its time."""
    model, forecasts = three_loose_pins(), list[Forecast]()

    class Recorder(Job):
        def begin(self, forecast: Forecast) -> None:
            forecasts.append(forecast)
            self.start = time.process_time()

    job = Recorder("design", None, True, lambda state: None)
    found = vfife.design(
        model, "D.approach_speed.max", share=0.9, turns=2, cost=GRADES, limit="20 mm/s", progress=job
    )
    taken = time.process_time() - job.start
    assert found.search == "descent" and set(found.ranks) == {"B", "C", "D"}
    assert found.sample.count == 64 and found.sample.span[0] < found.sample.span[1]
    order = [parameter.name for parameter in found.allocation.task.parameters]
    assert order == sorted(order, key=lambda name: abs(found.ranks[name].value))
    assert 0.25 < forecasts[0].seconds * forecasts[0].threads / taken < 4.0, (forecasts[0].seconds, taken)
    page = document(found)
    assert "343 choices of fits were tried" in " ".join(page.parts[0].parts[-2].parts[0].texts)
    assert "rank correlation over 64 machines" in page.data["conclusion"][0]


def test_a_sensitive_motion_has_no_derivatives_and_costs_none() -> None:
    part = work(three_loose_pins())
    part.nominal, part.nominal_range, part.machine_seconds = 1.0, (0.999, 1.001), 0.01
    assert "sensitivity" in part.forecast() and "ranks" not in part.forecast()
    part.nominal_range = (0.9, 1.1)
    assert "sensitivity" not in part.forecast() and part.forecast()["ranks"].count == 64
    with pytest.raises(VfifeError, match=r"sensitive: machines .* differ by 20 % in B.force.max"):
        part.sensitivities(Job("design", None, True, print))


def test_a_design_of_hours_names_what_shortens_it_most_with_its_time() -> None:
    part = work(three_loose_pins(), cost=GRADES, turns=10)
    part.nominal, part.nominal_range, part.machine_seconds = 1.0, (0.9, 1.1), 60.0
    forecasts = part.forecast()
    text = module.total_forecast(forecasts, part.remedy(forecasts)).remedy
    assert text.startswith("choose --turns 2: ") and "--same-fit: " in text and "--cost IT7=1" in text
    part.machine_seconds = 0.01
    assert part.remedy(part.forecast()) == "ask for fewer turns"


@pytest.mark.slow("the same answer")
def test_the_table_of_wear_to_add_has_the_coefficients_that_were_simulated(monkeypatch) -> None:
    stub(monkeypatch, "sensitivity", answer().sensitivity)
    stub(monkeypatch, "allocate", answer().allocation)
    found = vfife.design(loose_pin(), **BRIEF, wear=3e-16, wear_turns=1e4)
    steps = " ".join(document(found).parts[0].parts[-1].parts[0].texts)
    assert 'bearing = "3e-16 1/Pa"' in steps and "1e-15" not in steps


PRESS = Path(__file__).parents[2] / "examples" / "six_bar_press.toml"


def loose_press(clearance: str = "25 um") -> vfife.Mechanism:
    """The press of the examples with its lines of clearance and of the work; its model asks for one turn."""
    text = PRESS.read_text("utf-8").replace("#~ ", "").replace('"25 um"', f'"{clearance}"')
    return loads(text, set=[("driver.crank.speed", "90 rpm")])


@pytest.mark.slow("machines of a press")
def test_a_design_for_knocks_leaves_out_the_fall_of_the_journals_at_the_start() -> None:
    """At the ends of H7/f7 the start has 33 and 57 mm/s and the turns 14 and 31: these fits keep 40 mm/s in
    every turn.
    """
    model, measure = loose_press(), "F.approach_speed.max"
    part = work(model, measure, turns=None, limit="40 mm/s")
    assert model.settings.turns == 1 and (part.turns, part.averaged) == (2, 1)
    part.run_nominal()
    job = Job("design", None, True, lambda _: None)
    knocks = part.run_machines(["E", "F"], np.array([[10e-6, 10e-6], [31e-6, 31e-6]]), job).values
    for clearance, knock in zip(("25 um", "31 um"), (part.nominal, knocks[1]), strict=True):
        run = vfife.simulate(loose_press(clearance), turns=2, companions=0, reference=False)
        assert run.measures[measure] > 0.05 and run.summary["knocks"]["F"]["speed"] < 0.035
        assert knock == pytest.approx(run.summary["knocks"]["F"]["speed"], rel=1e-3), clearance
    assert 0.0 < knocks[0] < part.nominal
    plan, task = part.read("40 mm/s")
    assert plan.spec.of_case() == part.spec() and part.spec().counts == "last"
    assert task.bound.high == pytest.approx(0.04)


@pytest.mark.slow("the same answer")
def test_the_page_says_over_which_turns_knocks_are_counted() -> None:
    force = answer()
    assert "the first turn of each machine, which begins with the start" in str(document(force))
    for measure, turns, averaged, text in (
        ("pin.approach_speed.max", 2, 1, "is that of turn 2 of the 2 turns of each machine: contacts at"),
        (
            "pin.impacts",
            6,
            3,
            "is that of turns 4 to 6 of the 6 turns of each machine: contacts at the start",
        ),
        ("pin.landing_depth.max", 2, 1, "is that of all 2 turns of each machine, the fall of the journals"),
        ("pin.force.max", 2, 1, ""),
    ):
        found = dataclasses.replace(force, measure=measure, turns=turns, averaged=averaged)
        page = document(found)
        assert len(page.data["conclusion"]) == 3 + bool(text) and text in page.data["conclusion"][-1]
        assert "which begins with the start" not in str(page)
        assert ('counts = "last"' in str(page)) == (measure != "pin.force.max" and "depth" not in measure)


def test_a_design_takes_a_second_turn_for_contacts_only() -> None:
    model = loose_pin()
    assert work(model, "pin.approach_speed.max").turns == work(model, "pin.impacts").turns == 2
    assert work(model, "pin.force.max").turns == work(model, "pin.landing_depth.max").turns == 1
    assert work(model, "pin.approach_speed.max", turns=5).turns == 5


def test_a_measure_of_corners_is_named_for_each() -> None:
    with pytest.raises(
        ModelError, match=r"each corner: cylinder\.1\.approach_speed\.max, cylinder\.2\..*4\."
    ):
        vfife.design(vfife.gallery.compressor(), "cylinder.approach_speed.max", turns=2)


def test_a_run_of_the_model_shows_whether_the_contact_law_decides_a_force() -> None:
    """Knocks make the largest force of the loose pin. Knocks themselves have the facts of their laws."""
    prepared = module.prepare(loose_pin(), Arguments("design").run(turns=2))
    text = sample.law_caution(prepared, "pin.force.max")
    assert text in law_cautions(vfife.simulate(loose_pin(), turns=2)).texts
    assert sample.law_caution(prepared, "pin.approach_speed.max") is None
    prepared = module.prepare(vfife.gallery.compressor(), Arguments("design").run(turns=2))
    assert sample.law_caution(prepared, "small-end.force.max") == ""


@pytest.mark.slow("the same answer")
def test_the_page_has_what_that_run_shows() -> None:
    def texts(caution: str | None) -> list[str]:
        return list(value_cautions(dataclasses.replace(answer(), law_caution=caution)))

    assert answer().law_caution and f"In a run of the model: {answer().law_caution}" in texts(
        answer().law_caution
    )
    assert any("no caution says" in text for text in texts(""))
    assert not any("In a run of the model" in text for text in texts(None))
