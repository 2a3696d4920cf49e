"""A study file is understood by the model it is of, and everything that is wrong with it is told at once,
with its place.
"""

from __future__ import annotations

import math
import tomllib
from pathlib import Path

import numpy as np
import pytest

from schemas import complaints
from studies.studies import ASKED, BASE
from vfife.errors import ModelError
from vfife.studies.spec.plan import Plan
from vfife.studies.spec.study_file import StudyTables, study_schema

HEAD = f'model = "{BASE.as_posix()}"\nmeasures = "C.force.max"\n'


def plan_of(text: str, tmp_path: Path) -> Plan:
    path = tmp_path / "s.toml"
    path.write_text(text)
    return StudyTables.load(path).plan()


def faults_of(text: str, tmp_path: Path) -> list[str]:
    with pytest.raises(ModelError) as caught:
        plan_of(text, tmp_path)
    assert str(tmp_path / "s.toml") in str(caught.value)
    return [str(fault) for fault in caught.value.faults]


def test_a_grid_has_every_value_with_every_other_in_si_units(tmp_path: Path) -> None:
    plan = plan_of(ASKED, tmp_path)
    assert plan.cases == tuple((c, v) for c in (1e-4, 2e-4, 3e-4) for v in (100.0, 200.0))
    assert plan.numbers()[0] == {"joint.C.clearance": 1e-4, "driver.crank.speed": 100.0}


def test_tied_numbers_move_together_and_joints_go_by_their_bodies(tmp_path: Path) -> None:
    text = (
        HEAD + '[vary.mass]\npath = ["body.coupler.mass", "body.follower.mass"]\nvalues = ["2 kg", "3 kg"]\n'
    )
    text += (
        '[vary.c]\npath = "joint.follower-coupler.clearance"\nfrom = "10 um"\nto = "1000 um"\ncount ='
        ' 3\nspacing = "logarithmic"\n'
    )
    plan = plan_of(text, tmp_path)
    assert plan.numbers()[3] == {
        "body.coupler.mass": 3.0,
        "body.follower.mass": 3.0,
        "joint.C.clearance": 1e-5,
    }
    values = plan.parameters[1].values
    assert values is not None
    assert np.allclose(np.asarray(values, dtype=float), [1e-5, 1e-4, 1e-3], rtol=1e-14)


def test_a_list_goes_row_by_row(tmp_path: Path) -> None:
    text = (
        HEAD + 'method = "list"\n[vary]\n"joint.C.clearance" = [1e-4, 2e-4]\n"driver.crank.speed" = ["10 Hz",'
        " 30]\n"
    )
    assert "[vary.driver.crank.speed] values[0]" in faults_of(text, tmp_path)[0]
    plan = plan_of(text.replace('"10 Hz"', '"600 rpm"'), tmp_path)
    assert plan.cases == ((1e-4, 600.0 * 2.0 * math.pi / 60.0), (2e-4, 30.0))
    twice = text.replace('"10 Hz", 30]', "30, 30]")
    assert plan_of(twice, tmp_path).cases == ((1e-4, 30.0), (2e-4, 30.0))
    assert "the same case twice" in faults_of(twice.replace("2e-4", "1e-4"), tmp_path)[0]


def test_a_table_whose_key_is_a_path_needs_none(tmp_path: Path) -> None:
    table = 'from = "0.1 mm"\nto = "0.3 mm"\ncount = 3\n'
    text = HEAD + '[vary."joint.C.clearance"]\n' + table
    plan = plan_of(text, tmp_path)
    assert plan.cases == ((1e-4,), (pytest.approx(2e-4),), (pytest.approx(3e-4),))
    schema = study_schema()
    assert not list(complaints(tomllib.loads(text), schema, schema))
    text = HEAD + "[vary.play]\n" + table
    assert "[vary.play] path: this key is missing" in faults_of(text, tmp_path)[0]
    assert list(complaints(tomllib.loads(text), schema, schema))


@pytest.mark.parametrize("method", ["latin", "sobol", "random"])
def test_samples_are_combined_with_what_has_values(method: str, tmp_path: Path) -> None:
    text = (
        HEAD
        + f'method = "{method}"\ncount = 16\n[vary.speed]\npath = "driver.crank.speed"\nvalues = [100, 200]\n'
    )
    text += '[vary.play]\npath = "joint.C.clearance"\nfit = "H8/f7"\ndiameter = "20 mm"\n'
    text += '[vary.friction]\npath = "joint.C.friction.coefficient"\nmean = 0.1\ndeviation = 0.05\nfrom = 0\n'
    plan = plan_of(text, tmp_path)
    assert len(plan.cases) == 32
    speed, play, friction = np.array(plan.cases).T
    assert set(speed) == {100.0, 200.0}
    assert 1e-5 <= play.min() < play.max() <= 37e-6, "half of 20 and 74 µm of the diameters, ISO 286-1"
    assert friction.min() >= 0.0
    assert np.array_equal(play[:16], play[16:])
    assert plan_of(text, tmp_path).cases == plan.cases
    assert plan_of(text.replace("count = 16", "count = 16\nseed = 2"), tmp_path).cases != plan.cases


def test_words_and_whole_numbers_vary_as_well(tmp_path: Path) -> None:
    text = (
        HEAD
        + '[vary]\n"joint.C.contact.restitution" = [0.5, 0.9]\n"joint.C.friction_moment" = ["mid-overlap",'
        ' "surface"]\n'
    )
    text += '"run.outputs" = [360, 720]\n'
    plan = plan_of(text, tmp_path)
    assert plan.cases[0] == (0.5, "mid-overlap", 360.0)
    assert len(plan.cases) == 8


def test_points_are_added_one_by_one(tmp_path: Path) -> None:
    plan = plan_of(
        ASKED + '[[point]]\nplay = "1 mm"\nspeed = "1 rad/s"\n[[point]]\nplay = 1e-4\nspeed = 100\n', tmp_path
    )
    assert plan.cases[6:] == ((1e-3, 1.0),), "one that is in the grid already is no second case"


def test_all_faults_at_once_with_their_places(tmp_path: Path) -> None:
    text = (
        ASKED.replace("turns = 2", "turns = 0\nmethd = 1")
        .replace("joint.C.clearance", "joint.C.clearence")
        .replace('"C.impacts"', '"C.impcts"')
    )
    text = text.replace('"200 rad/s"', '"200 N"')
    told = faults_of(text + '[vary.more]\npath = "driver.crank.speed"\nvalues = [1, 1]\n', tmp_path)
    wanted = {
        "turns": "too small",
        "methd": 'Did you mean "method"?',
        "[vary.play] path": 'Did you mean "joint.C.clearance"',
        "measures[1]": 'Did you mean "C.impacts"',
        "[vary.speed] to": "an angular velocity",
        "[vary.more] path": "driver.crank.speed is varied by speed already",
        "[vary.more] values[1]": "the same value twice",
    }
    for where, what in wanted.items():
        assert any(one.startswith(where) and what in one for one in told), (where, what, told)
    assert len(told) == len(wanted)


def test_a_measure_that_another_part_has_is_not_taken_for_one_of_this(tmp_path: Path) -> None:
    """A link that rubs nowhere has no impacts and no penetration, as joints with clearance have them."""
    told = faults_of(ASKED.replace('"C.impacts"', '"crank.impacts", "C.penetration.max"'), tmp_path)
    assert len(told) == 1 and told[0].startswith("measures[1]") and "there is no such measure" in told[0], (
        told
    )


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("", "nothing is varied"),
        ('[vary.x]\npath = "joint.C.clearance"\n', "its values are missing"),
        ('[vary.x]\npath = "joint.C.clearance"\nvalues = [1e-4]\nmean = 1e-4\n', "exclude each other"),
        ('[vary.x]\npath = "joint.C.clearance"\nfrom = 1e-4\n', "[vary.x] to: this key is missing"),
        ('[vary.x]\npath = "joint.C.clearance"\nfrom = 2e-4\nto = 1e-4\ncount = 3\n', "not above from"),
        ('[vary.x]\npath = "joint.C.clearance"\nfrom = 1e-4\nto = 2e-4\n', "a grid takes values"),
        ('[vary.x]\npath = "joint.C"\nvalues = [1]\n', "a table, not a number"),
        ('[vary.x]\npath = "run.turns"\nvalues = [1]\n', "the study file sets this"),
        ('[vary.x]\npath = "joint.B.clearance"\nvalues = [1e-4]\n', "of a kind that has no such number"),
        (
            '[vary.x]\npath = ["joint.C.clearance", "body.coupler.mass"]\nvalues = [1]\n',
            "numbers of different kinds",
        ),
        ('[vary.x]\npath = "joint.C.clearance"\nvalues = ["1 s"]\n', "length"),
        ('[vary.x]\npath = "joint.C.clearance"\nvalues = [-1e-4]\n', "this is negative"),
        (
            (
                'method = "sobol"\ncount = 8\n[vary.x]\npath = "joint.C.clearance"\nfit = "H8/s7"\ndiameter ='
                ' "20 mm"\n'
            ),
            "[vary.x] fit",
        ),
        (
            (
                'method = "sobol"\ncount = 8\n[vary.x]\npath = "body.coupler.mass"\nfit = "H8/f7"\ndiameter ='
                ' "20 mm"\n'
            ),
            "a fit gives a clearance",
        ),
        (
            (
                'method = "sobol"\ncount = 64\n[vary.x]\npath = "joint.C.clearance"\nmean = 1e-4\ndeviation ='
                " 1e-4\n"
            ),
            "beyond the limits",
        ),
        (
            'method = "sobol"\n[vary.x]\npath = "joint.C.clearance"\nfrom = 1e-5\nto = 1e-4\n',
            "count: this key is missing",
        ),
        (
            '[vary.x]\npath = "joint.C.clearance"\nvalues = [1e-4]\n[[point]]\ny = 1\n',
            "there is no such parameter",
        ),
        (
            'last = 20\n[vary.x]\npath = "joint.C.clearance"\nvalues = [1e-4]\n',
            "more turns than a case makes",
        ),
        (
            'step = "1 ms"\n[vary.x]\npath = "joint.C.clearance"\nvalues = [1e-4]\n',
            "step = 0.001 s: too large for the model",
        ),
        (
            '[set]\n"joint.Q.clearance" = 1\n[vary.x]\npath = "joint.C.clearance"\nvalues = [1e-4]\n',
            "there is no joint 'Q'",
        ),
    ],
)
def test_bad_input_is_a_sentence(text: str, says: str, tmp_path: Path) -> None:
    told = faults_of(HEAD + text, tmp_path)
    assert any(says in one for one in told), told


def test_absurd_studies_are_refused_with_the_numbers_before_any_case_is_made(tmp_path: Path) -> None:
    text = HEAD + "".join(
        f'[vary.{name}]\npath = "{path}"\nfrom = 1\nto = 2\ncount = 100000\n'
        for name, path in (("a", "body.coupler.mass"), ("b", "body.follower.mass"), ("c", "body.crank.mass"))
    )
    (told,) = faults_of(text, tmp_path)
    assert "100,000 x 100,000 x 100,000 = 1,000,000,000,000,000 cases" in told
    assert "1,000,000" in told


def test_faults_of_the_model_are_told_with_those_of_the_study(tmp_path: Path) -> None:
    (tmp_path / "bad.toml").write_text(BASE.read_text().replace('length = "0.260 m"', 'length = "0.260 kg"'))
    told = faults_of(
        'model = "bad.toml"\nmeasures = []\nturn = 1\n[vary.x]\npath = "joint.C.clearance"\nvalues = [1]\n',
        tmp_path,
    )
    assert any("a model bad.toml, [body.coupler] length" in one for one in told)
    assert any(one.startswith("turn") for one in told)
    assert any("measures" in one for one in told)


def test_channels_are_reduced_by_their_names(tmp_path: Path) -> None:
    plan = plan_of(ASKED.replace('"C.impacts"', '"mean(C.force)", "range(follower.angle)"'), tmp_path)
    assert plan.spec.measures == ("C.force.max", "mean(C.force)", "range(follower.angle)")
    assert (
        "there is no such channel" in faults_of(ASKED.replace('"C.impacts"', '"mean(C.fource)"'), tmp_path)[0]
    )


@pytest.mark.parametrize(
    ("tolerance", "low", "high"),
    [('"0.1 mm"', 259.9, 260.1), ('["-0.02 mm", "0.05 mm"]', 259.98, 260.05), ('"h7"', 260.0 - 0.052, 260.0)],
)
def test_sizes_with_tolerances(tolerance: str, low: float, high: float, tmp_path: Path) -> None:
    """IT7 of 250 to 315 mm is 52 µm, ISO 286-1."""
    text = (
        HEAD + 'method = "random"\ncount = 500\n[vary.x]\npath = "body.coupler.length"\nnominal = "260'
        f' mm"\ntolerance = {tolerance}\n'
    )
    values = 1e3 * np.array(plan_of(text, tmp_path).cases, dtype=float)
    assert low <= values.min() < values.max() <= high
    assert abs(values.mean() - 0.5 * (low + high)) < 0.02 * (high - low)
    assert "IT99" in faults_of(text.replace(tolerance, '"h99"'), tmp_path)[0]


@pytest.mark.parametrize("path", sorted((BASE.parent / "studies").glob("*.toml")), ids=lambda path: path.stem)
def test_examples_are_studies_and_fit_the_schema(path: Path) -> None:
    assert len(StudyTables.load(path).plan().cases) >= 100
    schema = study_schema()
    raw = tomllib.loads(path.read_text("utf-8"))
    assert list(complaints(raw, schema, schema)) == []
    assert list(complaints({**raw, "turns": "ten", "colour": 1}, schema, schema)) != []
    for key in ("model", "measures", "vary"):
        assert (
            list(complaints({name: value for name, value in raw.items() if name != key}, schema, schema))
            != []
        )
