"""Line of a study on the cautions that only runs have: it names the case of the largest force."""

from __future__ import annotations

from vfife import gallery, studies
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
    assert f"{LEAD}: vfife run with driver.crank.speed " in lines(study)
    assert "600 rpm has them for the largest C.force.max." in lines(study)


def test_has_no_line_without_contact() -> None:
    model = gallery.load("four_bar_ideal")
    study = studies.study(model, {"driver.crank.speed": ["300 rpm", "600 rpm"]}, ["C.force.max"], turns=1)
    assert study.counts["complete"] == 2
    assert LEAD not in lines(study)
