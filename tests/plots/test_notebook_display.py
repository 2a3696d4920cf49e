"""A notebook's display of a result computes the forces of a figure once, however many joints there are."""

from __future__ import annotations

from typing import Any

import pytest

import vfife
from vfife import gallery
from vfife.plots import curves
from vfife.solvers.record import Record


def test_forces_are_computed_once_for_a_figure(monkeypatch: pytest.MonkeyPatch) -> None:
    result = vfife.simulate(gallery.jansen_leg(), turns=1.0, outputs=60, companions=0)
    count, joint_force = [0], curves.joint_force

    def counted(record: Record) -> Any:
        count[0] += 1
        return joint_force(record)

    monkeypatch.setattr(curves, "joint_force", counted)
    text = result._repr_html_()
    assert len(result.data.joint) == 10 and text.count("<img") == 2
    assert count[0] <= 4, "at most twice to see whether there are forces, and for the run and the ideal one"
