"""Mistakes that people make in scripts: each is told in words, none passes in silence, and none is an
accident of ours.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

import pint
import pytest

import vfife
from vfife.errors import ModelError

EXAMPLES = Path(__file__).resolve().parents[2] / "examples"


def machine() -> vfife.Mechanism:
    """A pendulum on a pivot."""
    m = vfife.Mechanism("machine", gravity=(0.0, -9.81))
    m.point("O", 0.0, 0.0)
    m.link("rod", length="300 mm", mass="0.5 kg")
    m.revolute("pivot", "ground.O", "rod.start")
    return m


@cache
def result() -> vfife.Result:
    """A short run of it, which no test changes."""
    return vfife.simulate(machine(), duration=1e-3, outputs=4, loop="data-driven", companions=0)


def set_gravity() -> Any:
    """Gravity as a number."""
    m = machine()
    m.gravity = 9.81  # type: ignore[assignment]
    return m.check()


def forgotten_pivot() -> Any:
    """A joint to a body that nobody made."""
    m = machine()
    m.revolute("elbow", "rod.end", "crank.start")
    return vfife.simulate(m, duration=1e-3)


MISTAKES: dict[str, tuple[Callable[[], Any], tuple[str, ...]]] = {
    "a misspelt keyword": (
        lambda: machine().link("bar", lenght=0.1, mass=1.0),
        ("[body.bar] lenght", "no such keyword", 'mean "length"'),
    ),
    "a keyword left out": (
        lambda: machine().rigid_body("plate", mass=1.0),
        ("[body.plate] inertia", "is missing", "inertia=..."),
    ),
    "a name that is None": (lambda: machine().link(None, length=1.0), ("None: this is not a name", "a text")),
    "an empty name": (lambda: machine().link("", length=1.0, mass=1.0), ('the name "" cannot be part',)),
    "a number for a list": (set_gravity, ("gravity = 9.81", "a list of 2 values")),
    "a surplus value": (
        lambda: vfife.simulate(machine(), 3),
        ("simulate(), argument 2 = 3", "only mechanism may be given without a name"),
    ),
    "a parameter that a law has not": (
        lambda: vfife.laws.KelvinVoigt(stiffness=1e8, damping=2e3),
        ("KelvinVoigt(), damping", 'mean "damping_coefficient"'),
    ),
    "a figure that is None": (lambda: result().plot(None), ("there is no figure None",)),  # type: ignore[arg-type]
    "a figure in a list": (lambda: result().plot(["orbits"]), ("no figure", 'mean "orbits"')),  # type: ignore[arg-type]
    "a spectrum of None": (lambda: result().spectrum(None), ("no series None",)),  # type: ignore[arg-type]
    "a file that is None": (lambda: result().export(None), ("export(), path = None",)),  # type: ignore[arg-type]
    "a file that is a number": (lambda: vfife.load_result(3), ("path = 3: this is a whole number",)),  # type: ignore[arg-type]
    "a model file that is None": (
        lambda: vfife.save_model(machine(), None),  # type: ignore[arg-type]
        ("save_model(), path = None",),
    ),
    "a run file called a table": (lambda: result().save("a.csv"), ("save() writes a run file", "export()")),
    "a path that is None": (
        lambda: vfife.bifurcation(machine(), None, 1, 2),  # type: ignore[arg-type]
        ("bifurcation(), path = None",),
    ),
    "data that are None": (lambda: vfife.fit(machine(), None, {}), ("fit(), data = None",)),  # type: ignore[arg-type]
    "patterns that are None": (
        lambda: vfife.sensitivity(machine(), None, None),  # type: ignore[arg-type]
        ("sensitivity(), to = None",),
    ),
    "a section of None": (
        lambda: vfife.dynamics.poincare_section(None),  # type: ignore[arg-type]
        ("poincare_section(), mechanism = None",),
    ),
    "a design of None": (lambda: vfife.design(None), ("design(), mechanism = None",)),  # type: ignore[arg-type]
    "a unit in capitals": (
        lambda: machine().drive("rod", speed="300 RPM"),
        ('unit "RPM" is unknown', 'mean "rpm"'),
    ),
    "a quantity of pint": (
        lambda: machine().link("bar", length=0.1, mass=pint.UnitRegistry().Quantity(1.0, "g")),
        ("this is a Quantity", '.to("kg").magnitude'),
    ),
    "a mass for a length": (
        lambda: machine().link("bar", length="3 kg", mass=1.0),
        ("[body.bar] length", "this is a mass", "a length"),
    ),
    "a length below zero": (
        lambda: machine().link("bar", length=-0.1, mass=1.0),
        ("[body.bar] length = -0.1", "negative", "above 0 m"),
    ),
    "millimetres as metres": (
        lambda: machine().clearance_joint("C", "rod.end", "ground.O", clearance=0.2, bearing_radius="10 mm"),
        ("[joint.C] clearance = 0.2", "the journal vanishes", "check the units"),
    ),
    "a misspelt law": (
        lambda: machine().clearance_joint(
            "C", "rod.end", "ground.O", clearance="0.2 mm", bearing_radius="10 mm", contact="hertzz"
        ),
        ("[joint.C.contact] law", "there is no contact law of this name", 'mean "hertz"'),
    ),
    "a law that was not made": (
        lambda: machine().clearance_joint(
            "C",
            "rod.end",
            "ground.O",
            clearance="0.2 mm",
            bearing_radius="10 mm",
            friction=vfife.laws.Coulomb,
        ),
        ("[joint.C] friction = Coulomb", "the law's class", "write Coulomb()"),
    ),
    "a misspelt pin": (
        lambda: machine().revolute("elbow", "rod.nd", "ground.O"),
        ("[joint.elbow] bearing", "rod has no pin", 'mean "rod.end"'),
    ),
    "a body without its pin": (
        lambda: machine().revolute("elbow", "rod", "ground.O"),
        ("[joint.elbow] bearing", "the pin is missing", "rod.end"),
    ),
    "a name given twice": (
        lambda: machine().link("rod", length=0.1, mass=1.0),
        ("[body.rod]", 'called "rod" already', "another name"),
    ),
    "a misspelt material": (
        lambda: machine().link("bar", length=0.1, mass=1.0, material="stel"),
        ("material", "no material", 'mean "steel"'),
    ),
    "gravity as a number": (set_gravity, ("gravity = 9.81", "this is a number", "a list")),
    "a body that nobody made": (forgotten_pivot, ("[joint.elbow] journal", "there is no body 'crank'")),
    "a file instead of a mechanism": (
        lambda: vfife.simulate("machine.toml"),
        ("mechanism", "a text", "vfife.load(path)"),
    ),  # type: ignore[arg-type]
    "turns and a duration": (
        lambda: vfife.simulate(machine(), turns=1, duration=1),
        ("turns", "exclude each other", "leave out one"),
    ),
    "turns where nothing turns": (
        lambda: vfife.simulate(machine(), turns=1),
        ("turns = 1", "no crank", "duration"),
    ),
    "a misspelt setting": (lambda: vfife.Settings(turn=2), ("[run] turn", "no such keyword", 'mean "turns"')),  # type: ignore[call-arg]
    "a misspelt path": (
        lambda: vfife.load(EXAMPLES / "slider_crank.toml", {"run.turn": 2}),
        ("run.turn", "no 'turn' in run", "run.turns"),
    ),
    "a file that is not there": (
        lambda: vfife.load("nowhere.toml"),
        ("nowhere.toml", "cannot be read", "check the name"),
    ),
    "a misspelt figure": (lambda: result().plot("force"), ("no figure", 'mean "forces"')),
    "names in a list": (lambda: result().to_dataframe(["pivot"]), ("is a list", "one by one")),  # type: ignore[arg-type]
    "a torque where a speed is": (
        lambda: machine().drive("rod", torque=1.0),
        ("no such keyword", "use torque() for it"),
    ),  # type: ignore[call-arg]
    "a kind of a model file": (
        lambda: machine().spring("s", "ground.O", "rod.start", kind="bushing", stiffness=1.0),
        ("no such keyword", "Use bushing() for it"),
    ),
    "wear without turns": (lambda: vfife.wear(machine()), ("wear(), turns", "this argument is missing")),  # type: ignore[call-arg]
    "a misspelt keyword of wear": (
        lambda: vfife.wear(machine(), 10, blok=3),  # type: ignore[call-arg]
        ("no such keyword", 'mean "block"'),
    ),
    "a body where nothing is set": (
        lambda: vfife.Simulation(machine()).set("rod", 1.0),
        ("no such input", "add a torque", "steered="),
    ),
    "a unit spelt wrong": (
        lambda: machine().link("bar", length="3 milimeter", mass=1.0),
        ("this is a text whose unit", 'mean "millimeter"'),
    ),
    "a step too long": (
        lambda: vfife.simulate(vfife.gallery.slider_crank(), turns=1, step=1.0),
        ("too large", "force_step=True"),
    ),
    "a misspelt joint of a result": (lambda: result().joint("pivott"), ("no joint", 'mean "pivot"')),
    "a folder that is not there": (
        lambda: result().export("nowhere/out.csv"),
        ("no folder", "nowhere", "make it first"),
    ),
    "a misspelt law to compare": (
        lambda: vfife.compare(vfife.gallery.journal_in_bearing(), contact=["hertzz"]),
        ("no contact law", 'mean "hertz"'),
    ),
    "a format that is not written": (lambda: result().export("out.xls"), ("out.xls", ".csv", ".parquet")),
}


def test_there_are_fifteen_and_more() -> None:
    assert len(MISTAKES) >= 15


@pytest.mark.parametrize("mistake", MISTAKES)
def test_a_mistake_is_told_in_words(mistake: str) -> None:
    make, words = MISTAKES[mistake]
    with pytest.raises(vfife.VfifeError) as told:
        make()
    said = str(told.value)
    assert all(word.lower() in said.lower() for word in words), said
    assert "Traceback" not in said and "NoneType" not in said and len(said) < 700


def test_a_misspelt_keyword_is_a_type_error_too() -> None:
    with pytest.raises(TypeError):
        machine().link("bar", lenght=0.1)  # type: ignore[call-arg]


def test_a_misspelt_measure_is_a_key_error_that_reads_as_a_sentence() -> None:
    with pytest.raises(KeyError) as told:
        result().measures["pivot.force.mx"]
    assert str(told.value) == str(told.value).strip("'\"") and 'did you mean "pivot.force.max"' in str(
        told.value
    )
    assert result().measures.get("pivot.force.mx") is None and "pivot.force.mx" not in result().measures


def test_a_pin_is_driven_by_a_builder_and_nothing_drives_two_things() -> None:
    """What drives a pin is called after it, without its dot, and no driver is of a body and of a pin."""
    m = vfife.Mechanism("carriage")
    m.rigid_body("carriage", mass=1.0, inertia=1e-3, pins={"p": (0.0, 0.0)})
    m.harmonic(point="carriage.p", amplitude=0.02, frequency=20.0)
    assert list(m.drivers) == ["carriage p"] and m.drivers["carriage p"].point == "carriage.p"
    two = vfife.Mechanism("two")
    two.rigid_body("carriage", mass=1.0, inertia=1e-3, pins={"p": (0.0, 0.0)})
    two.harmonic("none", point="carriage.p", amplitude=0.02, frequency=20.0)
    with pytest.raises(vfife.VfifeError, match="it drives a body and a point. Name one of them") as told:
        vfife.simulate(two, duration=0.01)
    assert "no body 'none'. In a script the first argument is the driven body" in str(told.value)
    assert "the driver of a point takes its name from the point" in str(told.value)
    two.drivers["none"] = dataclasses.replace(two.drivers["none"], body="carriage")
    with pytest.raises(vfife.VfifeError, match="Name one of them, or write a driver for each"):
        vfife.simulate(two, duration=0.01)


@pytest.mark.parametrize("gravity", [-9.81, (0.0, -9.81, 0.0), [-9.81]])
def test_gravity_that_is_no_pair_is_refused_at_once(gravity: Any) -> None:
    """Not by the first call that needs the whole mechanism."""
    with pytest.raises(ModelError, match=r"Mechanism\(\), gravity.*(a list of 2 values|2 values|missing)"):
        vfife.Mechanism("machine", gravity=gravity)
    assert vfife.Mechanism("machine", gravity=(0.0, -9.81)).gravity == (0.0, -9.81)
