"""The mesh of elastic bodies, which no range of a run over time covers."""

from __future__ import annotations

import copy
import dataclasses
from functools import cache
from typing import Any

import pytest

import vfife
from vfife import Mechanism, gallery
from vfife.assembly.assemble import assemble
from vfife.bodies import Section
from vfife.report.check import bodies
from vfife.report.check_page import _bodies
from vfife.report.document import Document
from vfife.report.front import conclusion
from vfife.report.overview import certainty
from vfife.report.pages import run_page
from vfife.report.run import document as long_document
from vfife.report.terminal import as_text

SIZE = 0.02, 0.03  # m: width and height of the section
CLAUSE = "he mesh of rod (4 elements) is not covered: compare "
OPTION = "--set body.rod.elements=8"


def elastic_crank() -> Mechanism:
    """A slider-crank whose rod is elastic and whose piston pin has clearance."""
    m = gallery.slider_crank_loose_pin()
    rod = dataclasses.replace(
        m.bodies["rod"], model="elastic", inertia=None, mass=None, section=Section.rectangle(*SIZE)
    )
    return dataclasses.replace(m, bodies=m.bodies | {"rod": rod})


@cache
def result() -> vfife.Result:
    return vfife.simulate(elastic_crank(), turns=1, companions=1)


def reliable() -> dict[str, Any]:
    """The summary with ranges without width."""
    summary = copy.deepcopy(result().summary)
    summary.pop("start_fall", None)
    for name, bounds in summary["ranges"].items():
        bounds |= {"low": summary["measures"][name], "high": summary["measures"][name]}
    summary["trust"] |= {"sensitive": False}
    return summary | {"turns": {}}


def test_every_answer_of_a_run_with_companions_says_that_the_mesh_is_not_covered() -> None:
    summary = result().summary
    assert summary["trust"]["companions"] and summary["meshes_not_covered"] == {"rod": 4}
    assert f"{CLAUSE}{OPTION}." in certainty(summary)
    assert f"ranges are those of the step; t{CLAUSE}{OPTION}" in as_text(long_document(summary), 300)
    assert any(f"{CLAUSE}twice the elements." in sentence for sentence in conclusion(summary))
    rigid = vfife.simulate(gallery.slider_crank_loose_pin(), turns=1, companions=1).summary
    assert "mesh" not in certainty(rigid) and "meshes_not_covered" not in rigid


def test_the_sentence_that_calls_a_run_reliable_names_the_mesh() -> None:
    first = certainty(reliable()).split(". ")[0]
    assert first.startswith("Reliable numerically: ") and f"with the step; t{CLAUSE}{OPTION}" in first


def test_meshes_that_cannot_be_refined_or_are_many() -> None:
    """A link of two particles is one element by definition."""
    summary = reliable()
    rod = summary["model"]["bodies"].pop("rod")
    summary["model"]["bodies"] |= {"rod": rod | {"model": "two-particle"}}
    assert "mesh" not in certainty(summary)
    summary["model"]["bodies"] |= {"rod": rod | {"model": "frame"}}
    assert f"t{CLAUSE}twice the elements." in certainty(summary)
    summary["model"]["bodies"] |= {"rod": rod, "arm": rod | {"elements": 1}}
    assert "the meshes of rod (4 elements) and arm (1 element) are not covered" in certainty(summary)
    summary["model"]["bodies"] |= {"leg": rod}
    assert "the meshes of 3 elastic bodies are not covered" in certainty(summary)


def test_a_check_states_the_inertia_that_particles_add() -> None:
    """k elements give a rod (m l^2/12)(1 + 2/k^2), and that of its sections."""
    m = elastic_crank()
    rod = m.bodies["rod"]
    share = rod.length**2 / 8.0 / (rod.length**2 + SIZE[1] ** 2)
    entries = bodies(assemble(m))
    (entry,) = (body for body in entries if "inertia_excess" in body)
    assert entry["name"] == "rod" and entry["inertia_excess"] == pytest.approx(share, rel=1e-9)
    said = as_text(Document(list(_bodies(entries, None))), 200)
    assert f"Inertia of particles above that of the elastic body: rod {100.0 * share:.2g} %" in said


def test_a_report_names_no_option_of_the_command_line() -> None:
    page = run_page(result(), {}, None, None)
    assert page.count(f"{CLAUSE}twice the elements") >= 2 and OPTION not in page
