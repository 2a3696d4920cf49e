"""Contacts in the answer of a run: how many of which kind, which never touch, and which the law decides."""

from __future__ import annotations

import copy
from functools import cache
from typing import Any

import pytest

import vfife
from vfife import gallery, modelfile
from vfife.errors import VfifeError
from vfife.report.document import Bullets, Document
from vfife.report.overview import certainty, contact_counts
from vfife.report.pages import run_page
from vfife.report.terminal import as_text
from vfife.studies.methods.compare import chosen_joints

MODEL = """
name = "block over a floor, between stops"
gravity = ["3 m/s^2", "{gravity} m/s^2"]
[run]
duration = "0.2 s"
[ground]
left = ["-30 mm", 0]
right = ["30 mm", 0]
floor = [0, "-10.5 mm"]
[body.block]
mass = "2 kg"
inertia = "2e-3 kg m^2"
position = [0, 0]
[body.block.pins]
pin = [0, 0]
[joint.floor]
kind = "contact"
bearing = "ground.floor"
journal = "block.pin"
journal_radius = "10 mm"
direction = [1, 0]
contact = {{ law = "kelvin-voigt", stiffness = "1e6 N/m", damping_coefficient = "500 N s/m" }}
[joint.right]
kind = "contact"
bearing = "ground.right"
journal = "block.pin"
journal_radius = "10 mm"
direction = [0, 1]
contact = {{ law = "lankarani-nikravesh", stiffness = "1e8 N/m^1.5", restitution = 0.6 }}
"""


@cache
def result(gravity: float) -> vfife.Result:
    return vfife.simulate(modelfile.loads(MODEL.format(gravity=gravity)))


def test_a_contact_that_never_touches_is_named_with_likely_causes() -> None:
    (caution,) = (text for text in result(9.81).summary["warnings"] if "never touched" in text)
    assert caution.startswith("Joint floor:") and "gravity" in caution and "wrong sign" in caution
    assert not any("never touched" in text for text in result(-9.81).summary["warnings"])


def test_stops_and_floors_are_counted_apart_from_joints_with_clearance() -> None:
    """Laws of pins with clearance are compared, and others refused by the same name."""
    summary = result(-9.81).summary
    assert " · 2 external contacts · " in str(result(-9.81)).splitlines()[0]
    mixed = summary | {"joints": summary["joints"] | {"pin": {"clearance": 1e-4}}}
    assert contact_counts(mixed) == "1 joint with clearance, 2 external contacts"
    assert contact_counts(summary | {"joints": {"pin": {}}}) == "no clearance"
    with pytest.raises(VfifeError, match=r"the contacts here are floor \(contact\), right \(contact\)"):
        chosen_joints(result(-9.81).record.assembly.mechanism, None)


@cache
def four_bar() -> vfife.Result:
    return vfife.simulate(gallery.four_bar_case_c(), turns=1.0, step=2e-6, companions=3)


def certain_summary(**changes: Any) -> dict[str, Any]:
    """Return the summary of a run whose ranges have no width, with changes."""
    summary = copy.deepcopy(four_bar().summary) | changes
    for name, bounds in summary["ranges"].items():
        bounds["low"] = bounds["high"] = summary["measures"][name]
    return summary


def test_the_first_line_says_against_what_a_run_is_reliable() -> None:
    line = certainty(certain_summary())
    assert line.startswith("Reliable numerically: forces and torques change by at most 0.01 % with the step.")
    assert "contact law" not in line


def test_the_first_line_names_the_forces_that_the_law_decides() -> None:
    """Numbers are those of the cautions as they are listed."""
    warnings = ["The first.", "Joint B: mostly damping.", "Joints C, D: the landing."]
    summary = certain_summary(warnings=warnings, law_dependent={"B": 1})
    alone = "The force of B depends more on the contact law than on the step: see caution 2."
    assert alone in certainty(summary)
    summary["law_dependent"] = {"C": 2, "D": 2, "B": 1}
    assert "The forces of C, D, B depend" in certainty(summary)
    assert "see cautions 2 and 3." in certainty(summary)
    summary["warnings"] = ["One.", "Two.", "Three.", "Four.", *warnings]
    summary["law_dependent"] = {"B": 5}
    assert "see caution 6 (--long)." in certainty(summary), "one screen lists four"
    assert "law" not in certainty(summary | {"status": "diverged"})


def test_a_page_numbers_its_cautions_as_its_conclusion_does() -> None:
    page = run_page(result(9.81), {}, None, None)
    cautions = page[page.index('<section id="cautions">') :]
    listed = cautions[cautions.index("<ol>") : cautions.index("</ol>")]
    assert "never touched" in listed
    assert as_text(Document([Bullets(["one", "two"], ordered=True)])) == "1. one\n2. two"
