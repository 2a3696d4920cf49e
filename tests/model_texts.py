"""Texts of model files for the tests, and what is said about them."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from vfife.modelfile import ModelError
from vfife.modelfile import loads as read

EXAMPLES = Path(__file__).resolve().parents[1] / "examples"
FILES = sorted(EXAMPLES.glob("*.toml"))
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
