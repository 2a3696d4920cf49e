"""Signed stress, where it is, and deflection of elastic links, against the textbook's beams."""

import math

import numpy as np
import pytest

from support import go
from vfife.assembly.assemble import assemble
from vfife.measures.catalogue import measures
from vfife.measures.elastic import (
    element_places,
    elongation,
    end_deflection,
    fibres,
    largest_deflection,
    stress,
)
from vfife.model.bodies import Frame, Member, Section
from vfife.model.loads import PointForce
from vfife.model.mechanism import Mechanism, Settings
from vfife.solvers.statics import equilibrium

LENGTH, SECTION, YOUNG = 0.8, Section.rectangle(0.02, 0.01), 207e9
MODULUS = SECTION.second_moment / 0.005


def beam(elements: int = 8, angle: float = 0.3) -> Mechanism:
    """A clamped beam that lies at an angle, at rest."""
    m = Mechanism("beam", settings=Settings(analysis="static", residual=1e-9, kinetic_energy=1e-16))
    m.point("O", 0.1, 0.2)
    m.link("beam", length=LENGTH, model="elastic", elements=elements, section=SECTION, angle=angle)
    m.weld("clamp", "ground.O", "beam.start")
    return m


def pulled(along_it: float, across: float, moment: float = 0.0, angle: float = 0.3, elements: int = 8):
    m = beam(elements, angle)
    c, s = math.cos(angle), math.sin(angle)
    force = (along_it * c - across * s, along_it * s + across * c)
    m.loads["tip"] = PointForce(name="tip", at="beam.end", force=force, moment=moment)
    return equilibrium(assemble(m))


def test_a_cantilever_under_a_force_across_its_tip() -> None:
    """F l^3/(3 E I) at the tip, F l e/I at the clamp, and F l^3/(9 sqrt(3)) ... off the chord: w(x) = F x
    (l^2 - x^2)/(6 E I).
    """
    force, rigidity = 1.0, YOUNG * SECTION.second_moment
    record = pulled(0.0, force)
    assert end_deflection(record, "beam")[-1] == pytest.approx(force * LENGTH**3 / (3 * rigidity), rel=1e-5)
    places = np.linspace(0.0, LENGTH, 17)
    from_tip = LENGTH - places
    exact = -force * from_tip * (LENGTH**2 - from_tip**2) / (6 * rigidity)
    assert largest_deflection(record, "beam")[-1] == pytest.approx(exact.min(), rel=1e-4)
    tension, compression = fibres(record)
    assert tension[-1, 0, 0] == pytest.approx(force * LENGTH / MODULUS, rel=1e-5)
    assert compression[-1, 0, 0] == pytest.approx(-force * LENGTH / MODULUS, rel=1e-5)
    assert np.abs(tension[-1, -1, 1]) < 1e-3 * tension[-1, 0, 0]


def test_the_sign_of_pull_and_push() -> None:
    for force in (100.0, -100.0):
        record = pulled(force, 0.0)
        tension, compression = fibres(record)
        np.testing.assert_allclose(tension[-1], force / SECTION.area, rtol=1e-6)
        np.testing.assert_allclose(compression[-1], force / SECTION.area, rtol=1e-6)
        np.testing.assert_allclose(stress(record)[-1], abs(force) / SECTION.area, rtol=1e-6)
        assert elongation(record, "beam")[-1] == pytest.approx(
            force * LENGTH / (YOUNG * SECTION.area), rel=1e-5
        )


def test_the_place_of_the_largest_stress() -> None:
    """A swinging clamped beam is bent most at its clamp."""
    m = beam(8)
    m.settings = Settings(duration=2e-3)
    m.gravity = (0.0, -9.81)
    record = go(m, 2e-6, outputs=200)
    found = measures(record)
    assert found["beam.stress.place"] == 0.0
    assert found["beam.tension.max"] == fibres(record)[0].max() > 0.0
    assert found["beam.compression.max"] == -fibres(record)[1].min() > 0.0
    assert found["beam.deflection.max"] == np.abs(largest_deflection(record, "beam")).max() > 0.0
    np.testing.assert_allclose(
        element_places(record), np.column_stack([np.arange(8), np.arange(1, 9)]) * 0.1, rtol=1e-12
    )


def test_places_of_a_frame_count_along_its_members() -> None:
    m = Mechanism("bent", settings=Settings(duration=1e-4))
    m.point("O", 0.0, 0.0)
    members = (Member(start="a", end="b", elements=2), Member(start="b", end="c", elements=1))
    m.bodies["arm"] = Frame(
        name="arm",
        nodes={"a": (0.0, 0.0), "b": (0.4, 0.0), "c": (0.4, 0.3)},
        members=members,
        section=SECTION,
    )
    m.weld("clamp", "ground.O", "arm.a")
    record = go(m, 1e-6, outputs=2)
    np.testing.assert_allclose(element_places(record), [[0.0, 0.2], [0.2, 0.4], [0.0, 0.3]])


def test_the_middle_of_one_element_bends() -> None:
    """One element under end moments bends by M l^2/(8 E I) off its chord, which its two nodes alone would not
    tell.
    """
    record = pulled(0.0, 0.0, moment=2.0, elements=1)
    exact = -2.0 * LENGTH**2 / (8 * YOUNG * SECTION.second_moment)
    assert largest_deflection(record, "beam")[-1] == pytest.approx(exact, rel=1e-3)
