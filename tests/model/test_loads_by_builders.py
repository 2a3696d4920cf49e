"""Loads and drivers that a script adds: quantities as texts, faults at once, the nouns that a
model file has.
"""

import math

import pytest

import vfife
from vfife.errors import ModelError
from vfife.model.drivers import AngleTable, Harmonic, Ramp, StepTo, Torque
from vfife.model.loads import GuideForce, PointForce
from vfife.model.mechanism import Mechanism
from vfife.model.validation import validate
from vfife.modelfile import dump, loads


def crank() -> Mechanism:
    """A driven crank that moves a block along a guide."""
    m = Mechanism("crank")
    m.point("O", 0, 0)
    m.link("crank", length="50 mm", mass="0.5 kg")
    m.link("rod", length="200 mm", mass="0.4 kg")
    m.point_mass("piston", mass="0.6 kg", inertia="1e-3 kg m^2", position=("250 mm", 0))
    m.revolute("A", "ground.O", "crank.start")
    m.revolute("B", "crank.end", "rod.start")
    m.revolute("C", "rod.end", "piston.center")
    m.slider("guide", "ground.O", "piston.center")
    return m


def test_loads_are_the_nouns_of_a_file():
    m = crank()
    m.drive("crank", speed="600 rpm")
    m.force("push", "rod.end", force=("1 kN", 0), angles=["0 deg", "180 deg", "360 deg"], factors=[0, 1, 0])
    m.moment(
        "twist", "rod.end", moment="2 N m", times=["0 s", "10 ms"], factors=[0, 1], interpolation="linear"
    )
    m.guide_force(
        "gas", "guide", pressure=["1 bar", "5 bar"], travels=["150 mm", "250 mm"], bore="50 mm", reverse=True
    )
    assert m.loads == {
        "push": PointForce(
            name="push",
            at="rod.end",
            force=(1000.0, 0.0),
            angles=m.loads["push"].angles,
            factors=(0.0, 1.0, 0.0),
        ),
        "twist": PointForce(
            name="twist",
            at="rod.end",
            moment=2.0,
            times=(0.0, 0.01),
            factors=(0.0, 1.0),
            interpolation="linear",
        ),
        "gas": GuideForce(
            name="gas", slider="guide", pressure=(1e5, 5e5), travels=(0.15, 0.25), bore=0.05, reverse=True
        ),
    }
    assert m.loads["push"].repeats
    assert [(one.words, one.place) for one in m.loads.values()] == [
        ("force 1000 N, by angle, repeated", "rod.end"), ("moment 2 N m, by time", "rod.end"),
        ("pressure on a bore of 0.05 m, up to 981.748 N along the guide, by travel", "guide"),
    ]  # fmt: skip
    validate(m)
    assert loads(dump(m)).loads == m.loads


@pytest.mark.parametrize(
    ("builder", "given", "wanted"),
    [
        ("ramp", {"body": "crank", "speed": "600 rpm", "duration": "50 ms"}, Ramp),
        ("step_to", {"slider": "guide", "travel": "-20 mm", "duration": "50 ms"}, StepTo),
        ("harmonic", {"slider": "guide", "amplitude": "5 mm", "frequency": "3 Hz"}, Harmonic),
        ("motion", {"body": "crank", "times": [0, "1 s"], "values": [0, "90 deg"]}, AngleTable),
        ("torque", {"body": "crank", "value": ["3 N m", 0], "speeds": [0, "3000 rpm"]}, Torque),
    ],
)
def test_drivers_take_what_they_drive(builder, given, wanted):
    m = crank()
    made = getattr(m, builder)(**given)
    assert isinstance(made, wanted) and m.drivers == {given.get("body") or given["slider"]: made}
    validate(m)
    assert loads(dump(m)).drivers == m.drivers


def test_a_mistake_is_told_at_once():
    m = crank()
    for call, what in (
        (lambda: m.guide_force("gas", "guide", pressure="1 bar"), "bore, which is missing"),
        (lambda: m.guide_force("gas", "guide", pressure="1 mm", bore="50 mm"), "a pressure"),
        (lambda: m.force("push", "rod.end", force=(1, 0), times=[0, 1], factors=[0, 1, 2]), "2 values"),
        (lambda: m.force("push", "rod.ende", force=(1, 0)), "no pin"),
        (lambda: m.torque("crank", value=[1, 2], speeds=[2, 1]), "must ascend"),
        (lambda: m.moment("twist", "rod.end", momnet="2 N m"), "did you mean|Did you mean"),
    ):
        with pytest.raises(ModelError, match=what) as told:
            call()
        assert "the size of the load is missing" not in str(told.value)
    assert m.loads == {} and m.drivers == {}
    assert vfife.loads.GuideForce is GuideForce


@pytest.mark.parametrize("expression", ["sin(angle)", "cos(angle - pi/2)", "sin(2*angle) + 1e-6*cos(angle)"])
def test_a_sine_repeats_with_each_turn(expression):
    """Its ends are zero but for rounding, which is no part of its amplitude."""
    m = crank()
    m.drive("crank", speed="600 rpm")
    m.moment("sine", "rod.end", moment="2 N m", expression=expression, crank="crank")
    assert m.loads["sine"].repeats and not m.loads["sine"].cautions()
    m.moment("same", "rod.end", moment="2 N m", expression=expression, crank="crank", repeat=True)
    m.moment(
        "table", "rod.end", moment="2 N m", crank="crank", angles=[k / 36 * 2.0 * math.pi for k in range(37)],
        factors=[math.sin(k / 36 * 2.0 * math.pi) for k in range(37)],
    )  # fmt: skip
    validate(m)
    assert m.loads["table"].repeats
    m.moment("ramp", "rod.end", moment="2 N m", expression="angle", crank="crank")
    assert not m.loads["ramp"].repeats and "keeps its last value" in m.loads["ramp"].cautions()[0]
