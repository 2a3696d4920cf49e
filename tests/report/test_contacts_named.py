"""Contacts in the answer of a run: how many of which kind, which never touch, and which the law decides."""

from __future__ import annotations

import copy
from functools import cache
from typing import Any

import pytest

import vfife
from vfife import gallery, modelfile
from vfife.errors import VfifeError
from vfife.measures.landings import overlaps
from vfife.report.document import Bullets, Document
from vfife.report.overview import certainty, contact_counts, overview
from vfife.report.pages import run_page
from vfife.report.run_tables import NONE_BEGAN, knock_texts, mean_text
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
    """Return the summary of a run whose ranges have no width, without cautions on laws and without the fall
    at its start, with changes.
    """
    no_laws = {key: {} for key in ("law_dependent", "law_shocks", "law_loads")}
    summary = copy.deepcopy(four_bar().summary) | no_laws | changes
    summary.pop("start_fall", None)
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


def test_powers_have_their_ranges_on_one_screen() -> None:
    summary = certain_summary(not_estimated=[], about_zero={})
    name = "crank.power.mean"
    summary["measures"][name] = 865.0
    summary["ranges"][name] |= {"low": 864.2, "high": 866.4, "lowest": 865.0, "highest": 865.0}
    assert mean_text(summary, name, "W", 1e-4) == "864 to 867 W"
    assert mean_text(summary, name, "W", 0.1) == "865 W"
    assert mean_text(summary | {"not_estimated": [name]}, name, "W", 1e-4).endswith("(not estimated)")
    assert "mean power 864 to 867 W" in " ".join(as_text(overview(summary)).split())
    torque = "crank.torque.mean"
    summary["measures"][torque] = 0.1261
    summary["ranges"][torque] |= {"low": 0.0295, "high": 0.2709, "lowest": 0.1261, "highest": 0.1261}
    assert "mean torque 29 to 280 mN m" in " ".join(as_text(overview(summary)).split())


def test_a_contact_that_began_before_the_turns_of_the_table_is_no_plain_none() -> None:
    summary = certain_summary()
    for name in summary["knocks"]:
        summary["knocks"][name] |= {"count": 0, "speed": 0.0, "hardest": False, "overlap": name == "B"}
    assert knock_texts(summary, "B")[0] == NONE_BEGAN and knock_texts(summary, "C")[0] == "none"


def test_a_contact_overlaps_if_it_is_closed_at_an_output_and_open_later() -> None:
    """The block falls on the floor and rebounds."""
    record = result(-9.81).record
    depths = record.block("contact_penetration")[:, 0]
    closed = int((depths > 0.0).argmax())
    assert overlaps(record, 0, closed) == bool((depths[closed:] <= 0.0).any())
    assert not overlaps(record, 0, 0)
