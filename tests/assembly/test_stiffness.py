"""Stiffness of elements: what bounds the step, loads the start, makes fictitious masses and stores energy
asks the step's own element.
"""

import math

import numpy as np
import pytest

from support import go
from vfife.assembly.assemble import assemble
from vfife.assembly.stability import element_stiffness
from vfife.kernels import frame
from vfife.laws import Material
from vfife.measures.energy import strain
from vfife.model.bodies import Section
from vfife.model.mechanism import Mechanism
from vfife.solvers.relaxation import demands

STEEL = Material(youngs_modulus=200e9, poissons_ratio=0.3, density=7850.0)
SECTION = Section.rectangle(0.02, 0.02)
EA, EI = 200e9 * SECTION.area, 200e9 * SECTION.second_moment


def turning(release: str = "none", elements: int = 2) -> Mechanism:
    """A rod of 0.8 m hung from a point, which the weight bends while it falls."""
    m = Mechanism("rod", gravity=(0.0, -9.81))
    m.point("O", 0.0, 0.0)
    m.link(
        "rod",
        length=0.8,
        elements=elements,
        model="elastic",
        section=SECTION,
        material=STEEL,
        release=release,
    )
    m.revolute("A", "ground.O", "rod.start")
    return m


@pytest.mark.parametrize("release", ["none", "start", "end", "both"])
def test_stiffness_of_an_element(release):
    """EA/l, 12 EI/l^3, 4 EI/l and 2 EI/l; with one end released 3 EI/l^3 and 3 EI/l; with both, a bar."""
    a = assemble(turning(release, 1))
    k = element_stiffness(a.layout, a.state, a.topology)
    size = 0.8
    across, own, other = {
        "none": (12.0, (4.0, 4.0), 2.0),
        "start": (3.0, (0.0, 3.0), 0.0),
        "end": (3.0, (3.0, 0.0), 0.0),
        "both": (0.0, (0.0, 0.0), 0.0),
    }[release]
    assert k.axial == pytest.approx([EA / size], rel=1e-6)
    assert k.transverse == pytest.approx([across * EI / size**3], rel=1e-6)
    assert k.moment[0] == pytest.approx(np.multiply(own, EI / size), rel=1e-6)
    assert k.coupling == pytest.approx([other * EI / size], rel=1e-6)


def test_end_rotations_undo_bending():
    """Moments of given rotations, and back; l/6EI (2 m1 - m2) is the matrix's inverse."""
    moments = frame.bending(0.01, -0.03, 1.25, 0.0, 0.0, EI)
    assert frame.end_rotations(*moments, 1.25, EI) == pytest.approx((0.01, -0.03), rel=1e-12)
    assert frame.end_rotations(1.0, 0.0, 1.25, EI) == pytest.approx(
        (0.8 / (3.0 * EI), -0.8 / (6.0 * EI)), rel=1e-12
    )


def readings() -> dict[str, float]:
    """Bound of the step, deflection at the start (m), fictitious inertia, and strain energy (J)."""
    a = assemble(turning())
    mid = a.bodies["rod"].particles[1]
    x, y = (a.state[a.layout[f"particle_{axis}"]] for axis in "xy")
    end = a.bodies["rod"].particles[-1]
    chord = math.hypot(x[end], y[end])
    return {
        "bound": min(value for name, value in a.choice.limits if "bending" in name),
        "deflection": float((x[mid] * y[end] - y[mid] * x[end]) / chord),
        "inertia": float(demands(a, a.state, 0.0, np.zeros(0))[1].max()),
        "energy": float(strain(go(turning(), 1e-6, duration=1e-5, outputs=1))[0]),
    }


def test_there_is_one_text(monkeypatch):
    """Bending twice as stiff: the bound falls by root 2, deflection and energy of the start by 2, fictitious
    inertia doubles.
    """
    before, bending = readings(), frame.bending
    monkeypatch.setattr(
        frame, "bending", lambda t1, t2, ila, m1, m2, ei: bending(t1, t2, ila, m1, m2, 2.0 * ei)
    )
    after = readings()
    assert before["deflection"] != 0.0 and before["energy"] > 0.0
    ratios = {name: after[name] / before[name] for name in before}
    assert ratios == pytest.approx(
        {"bound": 0.5**0.5, "deflection": 0.5, "inertia": 2.0, "energy": 0.5}, rel=1e-3
    )
