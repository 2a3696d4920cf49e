"""Every friction law that is registered: found and not listed."""

import dataclasses
import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from support import EPS, often
from vfife.laws import Ambrosio, FrictionLaw, Frictionless, Pair

LAWS = sorted(FrictionLaw.registry.values(), key=lambda law: law.name)
PAIR = Pair(0.01, 2e-4, 0.02)
DT = 1e-6

each_law = pytest.mark.parametrize("law", LAWS, ids=lambda law: law.name)
numbers = {
    "normal": st.floats(1e-3, 1e6) | st.just(0.0),
    "free": st.floats(-50.0, 50.0) | st.floats(-1e-2, 1e-2) | st.just(0.0),
    "mobility": st.floats(1e-9, 1e-3) | st.just(0.0),
}
RANGES = {
    "(m)": st.floats(-1e-5, 1e-5),
    "(m/s)": st.floats(-10.0, 10.0) | st.floats(-1e-3, 1e-3),
    "(1)": st.floats(0.0, 1.0),
}


def shaped(values):
    """Memory as a law takes it: 0 for none, a number for one, a tuple for more."""
    return 0.0 if not values else values[0] if len(values) == 1 else tuple(values)


def nothing(law):
    """The memory of a contact that begins."""
    return shaped([0.0] * len(law.memory))


def remembered(law):
    """Any memory, by the units of what is remembered."""
    return st.tuples(*(RANGES[name[name.rindex("(") :]] for name in law.memory)).map(shaped)


def mirrored(law, memory):
    """What has a direction, turned round; a pure number has none."""
    return shaped(
        [
            part if name.endswith("(1)") else -part
            for name, part in zip(law.memory, parts(memory), strict=False)
        ]
    )


def parts(memory):
    return memory if isinstance(memory, tuple) else (memory,)


def dry(law):
    """The law without what grows with the velocity."""
    fields = {field.name: field.metadata["low"] for field in dataclasses.fields(law)}
    return law(**{name: 0.0 for name in ("viscous", "bristle_damping") if fields.get(name) == 0.0})


def top(law):
    """Largest friction coefficient: the static one where there is one."""
    return max(getattr(law, "static_coefficient", 0.0), getattr(law, "coefficient", 0.0))


def test_there_are_laws():
    given = {
        "ambrosio",
        "none",
        "coulomb",
        "karnopp",
        "stribeck",
        "dahl",
        "lugre",
        "brown-mcphee",
        "threlfall",
        "bengisu-akay",
        "gonthier",
    }
    assert given <= set(FrictionLaw.registry)


@each_law
def test_says_where_it_comes_from(law):
    assert law.name and law.formula and law.formula.startswith("F =")
    assert law.source and (law.source == "definition" or any(c.isdigit() for c in law.source)), (
        "name authors and year"
    )


@each_law
def test_every_field_has_a_unit_and_a_meaning(law):
    for field in dataclasses.fields(law):
        assert field.metadata.get("unit") and field.metadata.get("meaning"), field.name
    assert all(name.endswith(tuple(RANGES)) for name in law.memory), "what is remembered has a unit"


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
def test_static_friction_is_no_weaker_than_kinetic(law):
    if hasattr(law(), "static_coefficient"):
        with pytest.raises(ValueError, match="Raise the one or lower the other"):
            law(coefficient=0.3, static_coefficient=0.2)


# ------------------------------------------------------------------------------------------------------- any
# state, one step


@each_law
@settings(deadline=None, max_examples=often(300))
@given(**numbers)
def test_opposes_the_sliding_that_is_left(law, normal, free, mobility):
    """Power -F v is never negative, v the velocity that the force itself causes: it does not turn the sliding
    round. (Nothing remembered: a bristle that was bent before may push.)
    """
    force, after = law.force(normal, free, mobility, nothing(law), DT, law().parameters(PAIR))
    assert math.isfinite(force) and all(map(math.isfinite, parts(after)))
    sliding = free + mobility * force
    assert -force * sliding >= -64 * EPS * (abs(force) * (abs(free) + mobility * abs(force)))
    assert abs(sliding) <= abs(free) * (1 + 64 * EPS)


@each_law
@settings(deadline=None, max_examples=often(200))
@given(data=st.data(), **numbers)
def test_is_bounded_by_its_coefficient(law, data, normal, free, mobility):
    """By the static one where there is one; a bristle may be bent further only if it was before."""
    memory = data.draw(remembered(law))
    dried = dry(law)
    assert hasattr(dried, "coefficient") or not dataclasses.fields(law), (
        "a law with another bound needs a test of its own"
    )
    force, after = law.force(normal, free, mobility, memory, DT, dried.parameters(PAIR))
    bent = abs(parts(memory)[0]) * getattr(dried, "bristle_stiffness", 0.0)
    assert abs(force) <= max(top(dried), bent) * normal * (1 + 64 * EPS)
    assert all(map(math.isfinite, parts(after)))


@each_law
@settings(deadline=None, max_examples=often(200))
@given(data=st.data(), **numbers)
def test_the_other_way_is_the_mirror_image(law, data, normal, free, mobility):
    """To the bit: a mirrored mechanism makes the mirrored motion."""
    p, memory = law().parameters(PAIR), data.draw(remembered(law))
    force, after = law.force(normal, free, mobility, memory, DT, p)
    other, other_after = law.force(normal, -free, mobility, mirrored(law, memory), DT, p)
    assert (other, other_after) == (-force, mirrored(law, after))


@each_law
@settings(deadline=None, max_examples=50)
@given(data=st.data(), free=numbers["free"], mobility=numbers["mobility"])
def test_nothing_without_a_normal_force(law, data, free, mobility):
    force, after = law.force(0.0, free, mobility, data.draw(remembered(law)), DT, law().parameters(PAIR))
    assert force == 0.0 and all(map(math.isfinite, parts(after)))


@each_law
def test_leaves_less_sliding_where_it_can_move_what_it_rubs(law):
    """The larger the mobility, the less sliding is left, and nothing jumps but to rest."""
    p = law().parameters(PAIR)
    mobilities = [10.0 ** (0.02 * e) for e in range(-600, 1)]
    left = [0.008 + m * law.force(1e4, 0.008, m, nothing(law), DT, p)[0] for m in mobilities]
    assert left == sorted(left, reverse=True)
    if law is Frictionless:
        assert set(left) == {0.008}
    else:
        assert left[0] > 1.5 * left[-1] >= 0.0


# -------------------------------------------------------------------------------------------------- in motion


def run(law, velocity, normal=1000.0, dt=DT):
    """Forces of a prescribed motion (nothing gives way) from a memory of nothing."""
    p, memory, forces = law.parameters(PAIR), nothing(law), []
    for v in velocity:
        force, memory = law.force(normal, v, 0.0, memory, dt, p)
        forces.append(force)
    return forces


def steady(law, v):
    """Force per normal force in steady sliding at v > 0, written anew from the publications."""

    def stribeck(shape):
        return law.coefficient + (law.static_coefficient - law.coefficient) * math.exp(
            -((v / law.stribeck_speed) ** shape)
        )

    match type(law).name:
        case "none":
            return 0.0
        case "coulomb" | "dahl":
            return law.coefficient
        case "ambrosio":
            return law.coefficient * min(max((v - law.v0) / (law.v1 - law.v0), 0.0), 1.0)
        case "karnopp":
            return law.coefficient if v > law.band else law.static_coefficient
        case "stribeck":
            return stribeck(law.shape) + law.viscous * v
        case "lugre":
            return stribeck(2.0) + law.viscous * v
        case "brown-mcphee":
            x = v / law.transition_speed
            return (
                law.coefficient * math.tanh(4 * x)
                + (law.static_coefficient - law.coefficient) * x / (x * x / 4 + 0.75) ** 2
            )
        case "threlfall":
            return (
                law.coefficient * (1 - math.exp(-3 * v / law.v1)) / (1 - math.exp(-3))
                if v <= law.v1
                else law.coefficient
            )
        case "bengisu-akay":
            kinetic, static = law.coefficient, law.static_coefficient
            return (
                static - static / law.v0**2 * (v - law.v0) ** 2
                if v <= law.v0
                else kinetic + (static - kinetic) * math.exp(-law.decay * (v - law.v0))
            )
        case "gonthier":
            s = math.exp(-((v / law.stribeck_speed) ** 2))
            bristles = law.coefficient - s * law.bristle_damping * v / math.expm1(
                -((v / law.stribeck_speed) ** 2)
            )
            return (
                min(bristles, law.coefficient + (law.static_coefficient - law.coefficient) * s)
                + law.viscous * v
            )
    pytest.fail(f"{type(law).name}: write down its curve in steady sliding here", pytrace=False)


@each_law
def test_its_curve_in_steady_sliding(law, subtests):
    """Against the closed form, both ways; bristles have come to rest long before the twelve steps of 10 s
    end.
    """
    for v in [1e-5, 3e-4, 1e-3, 2.7e-3, 0.02, 0.5, 9.0]:
        with subtests.test(v=v):
            fields = {field.name for field in dataclasses.fields(law)}
            values = {"viscous": 0.07, "shape": 1.3} if "shape" in fields else {}
            for sign in (1.0, -1.0):
                force = run(law(**values), [sign * v] * 12, normal=250.0, dt=10.0)[-1]
                assert force == pytest.approx(-sign * 250.0 * steady(law(**values), v), rel=1e-11)


@each_law
def test_dissipates_over_a_closed_cycle(law, subtests):
    """To and fro, from cycle to cycle, from motions within the bristles to long slides."""
    for amplitude in [1e-6, 1e-4, 0.3]:
        with subtests.test(amplitude=amplitude):
            per_cycle, dt = 400, 1e-4
            velocity = [
                amplitude * 2 * math.pi / (per_cycle * dt) * math.cos(2 * math.pi * (k + 0.5) / per_cycle)
                for k in range(4 * per_cycle)
            ]
            forces = run(dry(law), velocity, dt=dt)
            lost = [-force * v * dt for force, v in zip(forces, velocity, strict=True)]
            for cycle in range(1, 4):
                work = sum(lost[cycle * per_cycle : (cycle + 1) * per_cycle])
                assert work >= 0.0
                if law is not Frictionless and amplitude > 1e-3:
                    assert work == pytest.approx(4 * amplitude * 1000.0 * 0.1, rel=0.01)


# --------------------------------------------------------------------------------------------------- Ambrosio


def ambrosio(velocity: float, normal: float, coefficient: float, v0: float, v1: float) -> float:
    """Eq. 32-33 as printed: F_T = -c_f c_d F_N sign(v_T)."""
    speed = abs(velocity)
    share = 0.0 if speed < v0 else 1.0 if speed > v1 else (speed - v0) / (v1 - v0)
    return -coefficient * share * normal * math.copysign(1.0, velocity)


@settings(deadline=None, max_examples=often(500))
@given(
    coefficient=st.floats(1e-6, 1.0) | st.just(0.0), v0=st.floats(0.0, 0.1), ramp=st.floats(1e-4, 1.0),
    normal=numbers["normal"], free=numbers["free"], mobility=numbers["mobility"],
)  # fmt: skip
def test_ambrosio_solves_its_own_relation(coefficient, v0, ramp, normal, free, mobility):
    """The force put back: at the velocity it causes, the printed law gives the same force."""
    law = Ambrosio(coefficient=coefficient, v0=v0, v1=v0 + ramp)
    p = law.parameters(PAIR)
    force, _ = law.force(normal, free, mobility, 0.0, DT, p)
    sliding = free + mobility * force
    slope = coefficient * normal / p[2]
    rounding = 8 * EPS * (coefficient * normal + slope * (abs(free) + mobility * abs(force) + v0 + ramp))
    assert force == pytest.approx(ambrosio(sliding, normal, *dataclasses.astuple(law)), rel=0, abs=rounding)


@pytest.mark.parametrize(
    ("speed", "share"), [(0.0, 0.0), (0.9e-4, 0.0), (1e-4, 0.0), (5.05e-3, 0.5), (1e-2, 1.0), (3.0, 1.0)]
)
def test_ambrosio_at_marked_speeds(speed, share):
    """No force below v_0, half of it in the middle of the ramp, all of it from v_1: nothing is moved
    (mobility 0).
    """
    for sign in (1.0, -1.0):
        force, _ = Ambrosio.force(
            2000.0, sign * speed, 0.0, 0.0, DT, Ambrosio(coefficient=0.1, v0=1e-4, v1=1e-2).parameters(PAIR)
        )
        assert force == pytest.approx(-sign * 200.0 * share, rel=1e-12)


def test_ambrosio_slows_down_to_the_ramp_and_not_below():
    """A very mobile contact: the force takes away all sliding but v_0, and never pushes back."""
    law = Ambrosio(coefficient=0.1, v0=1e-4, v1=1e-2)
    force, _ = law.force(1e6, 0.5, 1.0, 0.0, DT, law.parameters(PAIR))
    assert 0.5 + force == pytest.approx(1e-4, rel=2e-2) and force < 0.0


def test_no_friction_is_none():
    assert Frictionless.force(1e5, 1.0, 1e-6, 0.25, DT, ()) == (0.0, 0.25)
