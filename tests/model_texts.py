"""Texts of model files for the tests, and what is said about them."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from vfife.errors import ModelError
from vfife.modelfile import loads as read

EXAMPLES = Path(__file__).resolve().parents[1] / "examples"
FILES = sorted(EXAMPLES.glob("*.toml"))
TEMPLATES = sorted((EXAMPLES.parent / "src" / "vfife" / "modelfile" / "templates").glob("*.toml"))
DEMO = EXAMPLES / "four_bar.toml"

FOUR_BAR = """
name = "four-bar"
[run]
turns = 2
[ground]
A = [0, 0]
D = ["0.15 m", 0]
[body.crank]
length = 0.4
mass = "3.12 kg"
[body.coupler]
length = 0.26
mass = 2.028
angle = "51 deg"
[body.follower]
length = 0.46
mass = 3.588
angle = "26 deg"
[joint.A]
bearing = "ground.A"
journal = "crank.start"
[joint.B]
bearing = "crank.end"
journal = "coupler.start"
[joint.C]
kind = "clearance"
bearing = "coupler.end"
journal = "follower.end"
clearance = "0.2 mm"
bearing_radius = "10 mm"
[joint.C.contact]
law = "pereira"
restitution = 0.5
[joint.C.friction]
law = "ambrosio"
v0 = "0.01 m/s"
v1 = "0.1 m/s"
[joint.D]
bearing = "ground.D"
journal = "follower.start"
[driver.crank]
speed = "1500 rpm"
"""


def with_lines(*lines: str, replace: tuple[str, str] | None = None) -> str:
    """The four-bar with a text replaced, and with more lines at its end."""
    text = FOUR_BAR
    if replace is not None:
        assert replace[0] in text
        text = text.replace(*replace, 1)
    return "\n".join([text, *lines])


def faults(text: str, set: Any = ()) -> list[str]:
    """What is said about a model, one sentence a fault."""
    with pytest.raises(ModelError) as caught:
        read(text, set)
    return [str(fault) for fault in caught.value.faults]


def only(text: str, set: Any = ()) -> str:
    """The one thing that is said."""
    told = faults(text, set)
    assert len(told) == 1, told
    return told[0]


PLAYGROUND = """
name = "everything"
[run]
duration = 1
[ground]
O = [0, 0]
P = [1, 0]
Q = [0, 1]
[body.arm]
length = 1
mass = 2
[body.bar]
length = "0.5 m"
mass = 1
[body.block]
mass = 1
inertia = 0.1
pins = { left = [-0.1, 0], right = [0.1, 0] }
[body.beam]
length = 1
model = "elastic"
elements = 4
section = { tube = ["20 mm", "16 mm"] }
via = [[0.5, 0.2]]
[body.truss]
model = "frame"
section = { round = "10 mm" }
members = [
  { start = "A", end = "B", elements = 3 },
  { start = "B", end = "C", section = { square = "1 cm^2" }, mass = 2 },
  { start = "C", end = "A" },
]
masses = { C = 1 }
nodes = { A = [0, 0], B = [1, 0], C = [0, 1] }
[joint.pivot]
bearing = "ground.O"
journal = "arm.start"
[joint.elbow]
bearing = "arm.end"
journal = "bar.start"
[joint.guide]
kind = "slider"
bearing = "ground.P"
journal = "block.left"
direction = [0, 1]
[joint.clamp]
kind = "weld"
bearing = "ground.Q"
journal = "beam.start"
[joint.rail]
kind = "clearance-slider"
bearing = "ground.P"
journal = "truss.A"
clearance = "0.1 mm"
length = "50 mm"
height = "20 mm"
[joint.cam]
kind = "contact"
bearing = "truss.B"
journal = "bar.end"
journal_radius = "10 mm"
[gear.wheels]
first = "arm"
second = "bar"
ratio = -2.5
[spring.coil]
first = "ground.O"
second = "block.right"
stiffness = "2 N/mm"
[spring.twist]
kind = "torsional"
first = "arm"
second = "bar"
stiffness = "3 N m/rad"
[spring.bump]
kind = "stop"
first = "ground"
second = "bar"
low = "-30 deg"
high = "30 deg"
stiffness = 100
[spring.mount]
kind = "bushing"
first = "beam.end"
second = "truss.C"
stiffness = ["1 kN/mm", 1e6, "10 N m/rad"]
[driver.lift]
slider = "guide"
travel = "20 mm"
duration = "0.1 s"
[driver.shake]
point = "truss.C"
direction = [0, 1]
amplitude = "1 mm"
frequency = "50 Hz"
phase = "90 deg"
[driver.motor]
body = "arm"
torque = [3, 0]
speeds = ["0 rpm", "3000 rpm"]
[load.wind]
at = "beam.end"
force = [10, 0]
follow = true
"""


def played(*changes: tuple[str, str]) -> str:
    """The model of everything with texts replaced."""
    text = PLAYGROUND
    for old, new in changes:
        assert old in text, old
        text = text.replace(old, new, 1)
    return text


# A slider-crank without loads, and the head of one along its guide.
COMPRESSOR = """
[ground]
O = [0, 0]
[body.crank]
length = 0.05
mass = 0.5
[body.rod]
length = 0.2
mass = 0.4
[body.piston]
mass = 0.6
inertia = 1e-3
pins = { origin = [0, 0] }
position = [0.25, 0]
[joint.A]
bearing = "ground.O"
journal = "crank.start"
[joint.B]
bearing = "crank.end"
journal = "rod.start"
[joint.C]
bearing = "rod.end"
journal = "piston.origin"
[joint.guide]
kind = "slider"
bearing = "ground.O"
journal = "piston.origin"
[driver.crank]
speed = "600 rpm"
"""
GAS = '[load.gas]\nkind = "guide"\nslider = "guide"\n'

# A wheel on a fixed pin; ``run`` has its duration, ``driver`` its torque.
FLYWHEEL = """
[run]
{run}
[ground]
O = [0, 0]
[body.wheel]
mass = "5 kg"
inertia = "0.1 kg m^2"
[body.wheel.pins]
c = [0, 0]
[joint.O]
bearing = "ground.O"
journal = "wheel.c"
[driver.wheel]
interpolation = "linear"
{driver}
"""
FALLING = 'torque = [2, 0]\nspeeds = ["0 rad/s", "50 rad/s"]'
