"""Reactions at a singular position grow without bound as the step becomes smaller: no number stands for
them.
"""

from __future__ import annotations

import re

import pytest

import vfife
from vfife.report.digits import NOT_DETERMINED, is_undetermined
from vfife.report.overview import certainty, overview
from vfife.report.run import document
from vfife.report.summary import run_summary
from vfife.report.terminal import as_text
from vfife.report.trust import verdict


def three_cranks() -> vfife.Mechanism:
    """Three parallel cranks carry a bar; they pass a change point where they lie along it."""
    m = vfife.Mechanism("parallelogram with three cranks", gravity=(0.0, -9.81))
    angle = 1.0471975511965976
    for k, name in enumerate("abc"):
        m.point(name.upper(), 0.2 * k, 0.0)
        m.link(name, length=0.08, angle=angle, mass=0.3)
    m.rigid_body(
        "bar",
        mass=2.0,
        inertia=0.03,
        center=(0.2, 0.0),
        position=(0.04, 0.069282),
        pins={"p": (0.0, 0.0), "q": (0.2, 0.0), "r": (0.4, 0.0)},
    )
    for name, pin in zip("abc", "pqr", strict=True):
        m.revolute(name.upper(), f"ground.{name.upper()}", f"{name}.start")
        m.revolute(pin.upper(), f"{name}.end", f"bar.{pin}")
    m.drive("a", speed=6.283185307179586)
    return m


@pytest.fixture(scope="module")
def summary():
    return run_summary(vfife.simulate(three_cranks(), turns=1, outputs=360))


def test_no_number_stands_for_a_reaction_without_bound(summary) -> None:
    assert summary["ranges"]["A.force.max"]["high"] > 1e12  # as data it stays what the steps gave
    assert is_undetermined(summary, "A.force.max") and is_undetermined(summary, "a.torque.max")
    assert not is_undetermined(summary, "ground.shaking_force.max")
    assert certainty(summary) == verdict(summary) and f"force.max is {NOT_DETERMINED}" in verdict(summary)
    assert "Quote these ranges" not in certainty(summary)
    for text in (as_text(overview(summary)), as_text(document(summary))):
        assert f"torque {NOT_DETERMINED}" in text
        assert not re.search(r"(\d,\d{3},\d{3},\d{3}|GN)", text) and "largest torque 30 N m" not in text
        assert text.count(NOT_DETERMINED) > 6


def test_a_wide_range_of_a_sensitive_run_is_a_range(summary) -> None:
    """Zero to a thousand times the value is wide, but it is what the steps gave."""
    wide = {"high": 1e3 * summary["measures"]["A.force.max"], "low": 0.0}
    changed = summary | {
        "ranges": summary["ranges"] | {"A.force.max": summary["ranges"]["A.force.max"] | wide}
    }
    assert not is_undetermined(changed, "A.force.max")
