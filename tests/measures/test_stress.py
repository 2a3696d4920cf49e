"""Stress in the outermost fibres against the beam's closed form."""

import numpy as np
import pytest

import vfife
from vfife.model.bodies import Section
from vfife.model.loads import PointForce
from vfife.model.mechanism import Mechanism, Settings

LENGTH, FORCE = 0.5, 20.0


def cantilever(section: Section) -> Mechanism:
    """Clamped at its start, a force across its end and one along it."""
    m = Mechanism("cantilever", settings=Settings(analysis="static"))
    m.point("A", 0.0, 0.0)
    m.link("beam", length=LENGTH, model="elastic", elements=8, section=section)
    m.weld("clamp", "ground.A", "beam.start")
    m.loads["F"] = PointForce(name="F", at="beam.end", force=(10.0, -FORCE))
    return m


@pytest.mark.parametrize(
    "section", [Section.rectangle(0.01, 0.02), Section.tube(0.02, 0.012), Section.round(0.02)]
)
def test_at_the_clamp(section):
    """|N|/A + F L e/I, both small enough that the end hardly moves."""
    found = vfife.simulate(cantilever(section)).data["element_stress"].isel(time=-1).values
    expected = 10.0 / section.area + FORCE * LENGTH * section.extreme_fibre / section.second_moment
    assert found[0] == pytest.approx(expected, rel=2e-3)
    assert np.all(np.diff(found) < 0.0)


def test_not_without_the_fibre():
    """Area and second moment alone do not tell it."""
    assert "element_stress" not in vfife.simulate(cantilever(Section(2e-4, 6e-9))).data
