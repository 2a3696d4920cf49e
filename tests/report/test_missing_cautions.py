"""Line of a study on the cautions that only runs have: it names the case of the largest force."""

from __future__ import annotations

import dataclasses
import math

import pytest

import vfife
from vfife import gallery, studies
from vfife.modelfile import dump, loads
from vfife.report.case_cautions import KINDS
from vfife.report.cautions import contact_extremes, excesses
from vfife.report.damping_cautions import damping_cautions, shock_cautions
from vfife.report.fall_cautions import fall_of
from vfife.report.study import document
from vfife.report.terminal import as_text

LEAD = "Cases have no cautions about contact laws, pressures and whirl"


def lines(study: studies.Study) -> str:
    return " ".join(as_text(document(study)).split())


def test_names_the_case_of_the_largest_force() -> None:
    speeds = ["300 rpm", "600 rpm", "450 rpm"]
    measures = ["crank.power.mean", "C.force.max"]
    study = studies.study(gallery.load("four_bar_case_b"), {"driver.crank.speed": speeds}, measures, turns=1)
    forces = study.values("C.force.max").tolist()
    assert max(forces) == forces[1]
    text = lines(study)
    assert "Cautions are those of 3 of 3 cases, each at another step: vfife run with driver" in text
    assert "600 rpm has all of them for the largest C.force.max." in text
    assert LEAD not in text and LEAD in lines(studies.Study(None, study.meta, study.cases, study.outcomes))


@pytest.mark.parametrize("turns, journals", [(1, "centred"), (2, "centred"), (1, "seated")])
def test_a_study_counts_the_cautions_of_its_cases_as_their_runs_have_them(turns: int, journals: str) -> None:
    model = gallery.load("four_bar_case_b")
    model = dataclasses.replace(model, start=dataclasses.replace(model.start, journals=journals))
    speeds = [200.0 * math.pi / 30.0, 1500.0 * math.pi / 30.0]
    study = studies.study(model, {"driver.crank.speed": speeds}, ["C.force.max"], turns=turns)
    shown, data = lines(study), document(study).data
    assert data["examined"] == 2
    kinds = [("fall", fall_of), ("law", damping_or_shock)]
    if turns == 1:  # a run looks for excesses in all of its turns
        kinds.append(("excess", beyond))
    for kind, of_run in kinds:
        expected = []
        for number, speed in enumerate(speeds):
            machine = loads(dump(model), set=[("driver.crank.speed", speed)])
            expected += [number] if of_run(vfife.simulate(machine, turns=turns)) else []
        assert data["cautions"].get(kind, []) == expected
        assert (KINDS[kind] in shown) == bool(expected)
    assert ("fall" in data["cautions"]) == (turns == 1 and journals == "centred")


def damping_or_shock(result: vfife.Result) -> bool:
    """Return whether shocks or damping make the largest force of a joint."""
    return bool(damping_cautions(result) or shock_cautions(result, ()))


def beyond(result: vfife.Result) -> bool:
    """Return whether penetrations or pressures are beyond what joints are built for."""
    return bool(excesses(result, contact_extremes(result.record)))


def test_has_no_line_without_contact() -> None:
    model = gallery.load("four_bar_ideal")
    study = studies.study(model, {"driver.crank.speed": ["300 rpm", "600 rpm"]}, ["C.force.max"], turns=1)
    assert study.counts["complete"] == 2
    assert LEAD not in lines(study)
