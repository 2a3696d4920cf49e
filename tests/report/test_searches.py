"""What answers of searches say about the values of their cases."""

from __future__ import annotations

import pytest

import vfife
from vfife import gallery
from vfife.report.searches import optimum
from vfife.report.terminal import as_text


def test_an_optimum_says_that_its_turns_differ_and_its_errors_are_not_estimated() -> None:
    """Without errors and differences the best value of single turns reads as exact: here turns differ by 3 %
    of the power.
    """
    pytest.importorskip("optuna")
    clearance = {"clearance": {"path": "joint.C.clearance", "from": "0.2455 mm", "to": "0.2456 mm"}}
    aim = {"minimise": ["crank.power.mean"], "cases": 2, "refine": 0}
    answer = vfife.optimise(
        gallery.load("four_bar_case_c"), clearance, ["crank.power.mean"], optimise=aim, turns=4
    )
    document = optimum(answer)
    text = " ".join(as_text(document).split())
    assert "Numerical error of a case: not estimated, because a search repeats no case" in text
    assert "Turns differ: in 2 of 2 cases" in text and "in crank.power.mean by" in text
    assert document.data["errors"] is None
