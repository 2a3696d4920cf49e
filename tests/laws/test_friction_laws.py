"""Every friction law that is registered: found and not listed."""

import dataclasses
import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from support import EPS
from vfife.laws import Ambrosio, FrictionLaw, Frictionless, Pair

LAWS = sorted(FrictionLaw.registry.values(), key=lambda law: law.name)
PAIR = Pair(0.01, 2e-4, 0.02)
DT = 1e-6

each_law = pytest.mark.parametrize("law", LAWS, ids=lambda law: law.name)
numbers = {
    "normal": st.floats(1e-3, 1e6) | st.just(0.0), "free": st.floats(-50.0, 50.0) | st.floats(-1e-2, 1e-2) | st.just(0.0),
    "mobility": st.floats(1e-9, 1e-3) | st.just(0.0), "memory": st.floats(-1e-5, 1e-5),
}  # fmt: skip


def test_there_are_laws():
    assert {"ambrosio", "none"} <= set(FrictionLaw.registry)


@each_law
def test_says_where_it_comes_from(law):
    assert law.name and law.formula and law.formula.startswith("F =")
    assert law.source and (law.source == "definition" or any(c.isdigit() for c in law.source)), "name authors and year"


@each_law
def test_every_field_has_a_unit_and_a_meaning(law):
    for field in dataclasses.fields(law):
        assert field.metadata.get("unit") and field.metadata.get("meaning"), field.name


@each_law
def test_slots_name_the_parameters(law):
    p = law().parameters(PAIR)
    assert len(p) == len(law.slots) == len(set(law.slots))
    assert all(isinstance(value, float) and math.isfinite(value) for value in p)
    assert set(law().derived(PAIR)) == set(law.slots)


@each_law
def test_is_a_frozen_value(law):
    assert law() == law() and hash(law()) == hash(law())


@each_law
@settings(deadline=None, max_examples=300)
@given(**{name: strategy for name, strategy in numbers.items() if name != "memory"})
def test_opposes_the_sliding_that_is_left(law, normal, free, mobility):
    """Power -F v is never negative, v the velocity that the force itself causes: it does not turn the sliding round. (Nothing remembered:
    a bristle that was bent before may push.)"""
    force, after = law.force(normal, free, mobility, 0.0, DT, law().parameters(PAIR))
    assert math.isfinite(force) and math.isfinite(after)
    sliding = free + mobility * force
    assert -force * sliding >= -8 * EPS * (abs(force) * (abs(free) + mobility * abs(force)))
    assert abs(sliding) <= abs(free) * (1 + 4 * EPS)


@each_law
@settings(deadline=None, max_examples=200)
@given(**numbers)
def test_is_bounded_by_its_coefficient(law, normal, free, mobility, memory):
    if not hasattr(law(), "coefficient"):
        assert not dataclasses.fields(law), "a law with another bound needs a test of its own"
    force, _ = law.force(normal, free, mobility, memory, DT, law().parameters(PAIR))
    assert abs(force) <= getattr(law(), "coefficient", 0.0) * normal * (1 + 2 * EPS)


@each_law
@settings(deadline=None, max_examples=200)
@given(**numbers)
def test_the_other_way_is_the_mirror_image(law, normal, free, mobility, memory):
    """To the bit: a mirrored mechanism makes the mirrored motion."""
    p = law().parameters(PAIR)
    force, after = law.force(normal, free, mobility, memory, DT, p)
    mirrored, mirrored_after = law.force(normal, -free, mobility, -memory, DT, p)
    assert (mirrored, mirrored_after) == (-force, -after)


@each_law
def test_nothing_without_a_normal_force(law):
    assert law.force(0.0, 3.0, 1e-6, 0.0, DT, law().parameters(PAIR))[0] == 0.0


@each_law
def test_rubs_less_where_it_can_move_what_it_rubs(law):
    """The larger the mobility, the smaller the force, and continuously so."""
    p = law().parameters(PAIR)
    forces = [abs(law.force(1e4, 0.008, 10.0**e, 0.0, DT, p)[0]) for e in (-12, -9, -8, -7, -6, -5)]
    assert forces == sorted(forces, reverse=True)
    if law is not Frictionless:
        assert forces[0] > 1.5 * forces[-1] > 0.0


# ---------------------------------------------------------------------------------------------------------------- Ambrosio


def ambrosio(velocity: float, normal: float, coefficient: float, v0: float, v1: float) -> float:
    """Eq. 32-33 as printed: F_T = -c_f c_d F_N sign(v_T)."""
    speed = abs(velocity)
    share = 0.0 if speed < v0 else 1.0 if speed > v1 else (speed - v0) / (v1 - v0)
    return -coefficient * share * normal * math.copysign(1.0, velocity)


@settings(deadline=None, max_examples=500)
@given(
    coefficient=st.floats(1e-6, 1.0) | st.just(0.0), v0=st.floats(0.0, 0.1), ramp=st.floats(1e-4, 1.0),
    normal=numbers["normal"], free=numbers["free"], mobility=numbers["mobility"],
)  # fmt: skip
def test_ambrosio_solves_its_own_relation(coefficient, v0, ramp, normal, free, mobility):
    """The force put back: at the velocity it causes, the printed law gives the same force."""
    law = Ambrosio(coefficient, v0, v0 + ramp)
    p = law.parameters(PAIR)
    force, _ = law.force(normal, free, mobility, 0.0, DT, p)
    sliding = free + mobility * force
    slope = coefficient * normal / p[2]
    rounding = 8 * EPS * (coefficient * normal + slope * (abs(free) + mobility * abs(force) + v0 + ramp))
    assert force == pytest.approx(ambrosio(sliding, normal, *dataclasses.astuple(law)), rel=0, abs=rounding)


@pytest.mark.parametrize(("speed", "share"), [(0.0, 0.0), (0.9e-4, 0.0), (1e-4, 0.0), (5.05e-3, 0.5), (1e-2, 1.0), (3.0, 1.0)])
def test_ambrosio_at_marked_speeds(speed, share):
    """No force below v_0, half of it in the middle of the ramp, all of it from v_1: nothing is moved (mobility 0)."""
    for sign in (1.0, -1.0):
        force, _ = Ambrosio.force(2000.0, sign * speed, 0.0, 0.0, DT, Ambrosio(0.1, 1e-4, 1e-2).parameters(PAIR))
        assert force == pytest.approx(-sign * 200.0 * share, rel=1e-12)


def test_ambrosio_slows_down_to_the_ramp_and_not_below():
    """A very mobile contact: the force takes away all sliding but v_0, and never pushes back."""
    law = Ambrosio(0.1, 1e-4, 1e-2)
    force, _ = law.force(1e6, 0.5, 1.0, 0.0, DT, law.parameters(PAIR))
    assert 0.5 + force == pytest.approx(1e-4, rel=2e-2) and force < 0.0


def test_no_friction_is_none():
    assert Frictionless.force(1e5, 1.0, 1e-6, 0.25, DT, ()) == (0.0, 0.25)
