"""Mechanisms that cannot be, or cannot be meant: a sentence with names and a remedy, exit code 2, soon;
Python hears the same in a ValueError.
"""

from __future__ import annotations

import json
import math
import time
from collections.abc import Callable
from pathlib import Path

import pytest

import vfife
from vfife.assembly.assemble import assemble
from vfife.model.drivers import Ramp
from vfife.model.joints import ClearanceRevolute
from vfife.model.mechanism import Mechanism
from vfife.model.validation import validate
from vfife.simulation.start import assembled_at

CRANK = """name = "slider-crank"
[run]
turns = 1
[ground]
O = [0, 0]
[body.crank]
length = 0.05
mass = 0.3
[body.rod]
length = 0.12
mass = 0.21
[body.block]
mass = 0.14
inertia = 1e-4
position = [0.17, 0]
[joint.O]
bearing = "ground.O"
journal = "crank.start"
[joint.P]
bearing = "crank.end"
journal = "rod.start"
[joint.W]
bearing = "rod.end"
journal = "block.center"
[joint.G]
kind = "slider"
bearing = "ground.O"
journal = "block.center"
[driver.crank]
speed = 100
"""
BALL = """name = "ball"
gravity = [0, -9.81]
[run]
duration = 0.05
[ground]
O = [0, 0]
[body.ball]
mass = 1
inertia = 0.01
"""
ROUND = '[joint.c]\nkind = "contact"\nbearing = "ground.O"\njournal = "ball.center"\njournal_radius = 0.5\n'
PISTON = '[driver.piston]\nslider = "G"\namplitude = 0.01\nfrequency = 5\n'
ELASTIC = '[body.rod]\nmodel = "elastic"\nrelease = "start"\nsection = { square = 1e-4 }\n'

# The text, and what the sentence has to name.
BROKEN = {
    "crank and piston driven": (CRANK + PISTON, ["the drive of crank", "the drive of piston", "remove one"]),
    "crank and rod driven": (
        CRANK + '[driver.rod]\nagainst = "crank"\nspeed = 3\n',
        ["crank", "rod", "remove one"],
    ),
    "driven dead centre": (
        CRANK.replace("[driver.crank]\nspeed = 100\n", PISTON).replace("turns", "duration"),
        ["dead centre", "another angle"],
    ),
    "guide of no length": (
        CRANK.replace('kind = "slider"', 'kind = "slider"\ndirection = [0, 0]'),
        ["[joint.G] direction", "no length"],
    ),
    "one pair twice": (
        CRANK + '[joint.Q]\nbearing = "rod.start"\njournal = "crank.end"\n',
        ["[joint.Q]", "joint P", "Remove"],
    ),
    "out of reach": (
        CRANK.replace("O = [0, 0]", "O = [0, 0]\nU = [0, 0.5]").replace(
            '"slider"\nbearing = "ground.O"', '"slider"\nbearing = "ground.U"'
        ),
        ["joints stay open", "mm", "check their lengths"],
    ),
    "gear that holds": (
        CRANK + '[gear.g]\nfirst = "crank"\nsecond = "rod"\nratio = -1\n',
        ["g", "the drive of crank", "remove one"],
    ),
    "gear on a block": (
        CRANK + '[gear.g]\nfirst = "block"\nsecond = "crank"\nratio = -1\n',
        ["G, g", "remove one"],
    ),
    "more elements than a machine bears": (
        BALL
        + "".join(
            f'[body.rod{k}]\nmodel = "elastic"\nlength = 1\nelements = 90000\nsection = {{ round = 0.04 }}\n'
            for k in range(3)
        ),
        ["270,000 elements in all bodies together", "at most 200,000"],
    ),
    "name with dots": (CRANK.replace("body.rod", 'body."a.b"'), ['"a.b"', "without dots"]),
    "name of line breaks": (BALL.replace("body.ball", 'body."a\\nb"'), ["printable"]),
    "a million elements": (
        CRANK.replace(
            "[body.rod]\n", '[body.rod]\nmodel = "elastic"\nelements = 1000000\nsection = { square = 1e-4 }\n'
        ),
        ["[body.rod] elements", "1000000", "100000"],
    ),
    "no mass": (BALL.replace("mass = 1", "mass = 0"), ["[body.ball] mass", "has no mass", "Give it a mass"]),
    "no inertia": (
        BALL.replace("inertia = 0.01", "inertia = 0"),
        ["[body.ball]", "neither inertia nor", "Give it an inertia"],
    ),
    "negative clearance": (
        CRANK.replace(
            "[joint.P]\n", '[joint.P]\nkind = "clearance"\nclearance = -1e-4\nbearing_radius = 0.01\n'
        ),
        ["[joint.P] clearance", "-0.0001", "above 0"],
    ),
    "journal as large as its bearing": (
        CRANK.replace(
            "[joint.P]\n", '[joint.P]\nkind = "clearance"\nclearance = 0.02\nbearing_radius = 0.01\n'
        ),
        ["[joint.P] clearance", "bearing_radius", "units"],
    ),
    "corners larger than the block": (
        CRANK.replace(
            'kind = "slider"',
            'kind = "clearance-slider"\nclearance = 1e-4\nlength = 0.04\nheight = 0.02\n'
            "corner_radius = 0.011",
        ),
        ["[joint.G] corner_radius", "0.01 m", "smaller"],
    ),
    "deep in a wall": (BALL + ROUND, ["joint 'c'", "ball.center", "0.5 m deep", "position"]),
    "behind a wall": (
        BALL.replace("[body.ball]", "[body.ball]\nposition = [0, -3]") + ROUND,
        ["joint 'c'", "3.5 m deep", "side of the surface"],
    ),
    "one round in another": (BALL + ROUND + "bearing_radius = 0.5\n", ["joint 'c'", "1 m deep"]),
    "couple on a particle": (
        BALL.replace("inertia = 0.01", 'model = "particle"') + "[driver.ball]\ntorque = 3\n",
        ["driver 'ball'", "'ball', a particle without inertia", "give it an inertia"],
    ),
    "gear on a released end": (
        CRANK.replace("[body.rod]\n", ELASTIC) + '[gear.g]\nfirst = "rod"\nsecond = "crank"\nratio = 2\n',
        ["gear 'g'", "'rod'", "released", "remove the release"],
    ),
    "speed beyond numbers": (
        CRANK.replace("speed = 100", "speed = 1e200"),
        ["[driver.crank] speed", "too large for any mechanism", "unit"],
    ),
    "gravity beyond numbers": (
        BALL.replace("-9.81", "-1e200"),
        ["gravity", "too large for any mechanism", "unit"],
    ),
    "step beyond numbers": (
        BALL.replace("duration = 0.05", "duration = 1\nstep = 1e-300"),
        ["1e-300", "[run] step", "too small for any"],
    ),
    "mass below numbers": (
        BALL.replace("mass = 1\n", "mass = 1e-300\n"),
        ["[body.ball] mass", "too small for any mechanism", "1e-18 kg"],
    ),
    "inertia below numbers": (
        BALL.replace("inertia = 0.01", "inertia = 1e-300"),
        ["[body.ball] inertia", "too small for any mechanism"],
    ),
    "stiffness beyond numbers": (
        BALL.replace("[body.ball]\n", "[body.ball]\npins = { p = [0, 1] }\n")
        + '[spring.s]\nfirst = "ground.O"\nsecond = "ball.p"\nstiffness = 1e300\n',
        ["[spring.s] stiffness", "too large for any mechanism", "unit"],
    ),
    "turns of a crank at rest": (CRANK.replace("speed = 100", "speed = 0"), ["no crank", "duration"]),
}


@pytest.mark.parametrize("case", BROKEN)
def test_broken_mechanisms_are_told(command: Callable, case: str) -> None:
    text, words = BROKEN[case]
    Path("model.toml").write_text(text)
    began = time.perf_counter()
    done = command("check", "model.toml", "--json")
    spent = time.perf_counter() - began
    assert done.exit_code == 2, (done.exit_code, done.stdout, done.stderr, done.exception)
    said = json.loads(done.stdout)
    assert (
        said["status"] == "refused"
        and said["faults"]
        and "Traceback" not in done.stderr
        and "Warning" not in done.stderr
    )
    for word in ("model.toml", *words):
        assert word in done.stderr
    assert spent < 5.0  # 2 s on a machine that does nothing else
    with pytest.raises(ValueError, match=".{20}"):
        vfife.simulate(vfife.load_model("model.toml"))


def test_what_falls_freely_is_told_by_its_degrees_of_freedom(command: Callable) -> None:
    Path("model.toml").write_text(BALL)
    done = command("check", "model.toml")
    assert done.exit_code == 0 and "Degrees of freedom with ideal joints: 3." in done.stdout


@pytest.mark.parametrize(("analysis", "words"), [("static", ["3 free motions", "Add a joint"])])
def test_equilibrium_of_what_nothing_holds(command: Callable, analysis: str, words: list[str]) -> None:
    Path("model.toml").write_text(BALL.replace("duration = 0.05", f'analysis = "{analysis}"'))
    done = command("run", "model.toml", "--quiet")
    assert done.exit_code == 3 and "Traceback" not in done.stderr
    for word in words:
        assert word in done.stderr


@pytest.mark.system("bisects lengths of a mechanism that jams")
def test_crank_that_cannot_turn_round_is_told_why(command: Callable) -> None:
    """Its rod is shorter than the crank: at the start all is well, and nothing is run."""
    Path("model.toml").write_text(CRANK.replace("length = 0.12", "length = 0.04").replace("0.17", "0.09"))
    done = command("run", "model.toml", "--quiet")
    assert (
        done.exit_code == 2
        and "jams at crank angle 53.1°" in done.stderr
        and "at least 50 mm (now 40 mm)" in done.stderr
    )


def pendulum() -> Mechanism:
    m = Mechanism("p", gravity=(0.0, -9.81))
    m.point("O", 0.0, 0.0)
    m.link("rod", length=1.0, mass=2.0, angle=-0.5)
    m.revolute("J", "ground.O", "rod.start")
    return m


NOUNS = {
    "unknown body": (lambda m: m.revolute("K", "ground.O", "rood.start"), "there is no body 'rood'"),
    "unknown pin": (lambda m: m.revolute("K", "ground.O", "rod.stat"), "rod has no pin 'stat'"),
    "gear on nothing": (lambda m: m.gear("g", "rod", "x", ratio=1.0), "there is no body 'x'"),
    "spring to nothing": (lambda m: m.spring("s", "rod.end", "x.y", stiffness=1.0), "there is no body 'x'"),
    "negative damping": (lambda m: m.spring("s", "rod.end", "ground.O", damping=-5.0), "this is negative"),
    "stop the wrong way round": (
        lambda m: m.stop("s", "rod", "ground", low=1.0, high=0.0, stiffness=1.0),
        "no room between the limits",
    ),
    "ramp of no time": (
        lambda m: m.drivers.update(rod=vfife.drivers.Ramp(body="rod", speed=1.0, duration=0.0)),
        "ramp = 0",
    ),
    "uneven table": (
        lambda m: m.drivers.update(rod=vfife.drivers.AngleTable(body="rod", times=(0.0, 1.0), values=(0.0,))),
        "1 for 2 times",
    ),
    "load on nothing": (
        lambda m: m.loads.update(f=vfife.loads.PointForce(name="f", at="x.y")),
        "there is no body 'x'",
    ),
    "unknown model": (lambda m: m.link("b", length=1.0, mass=1.0, model="elstic"), 'Did you mean "elastic"'),
    "no number": (lambda m: m.link("b", length=1.0, mass=math.nan), "not a finite number"),
}


@pytest.mark.parametrize("case", NOUNS)
def test_python_hears_the_sentences_of_files(case: str) -> None:
    change, words = NOUNS[case]
    m = pendulum()
    validate(m)
    with pytest.raises(ValueError) as told:  # by the builder at once, or where nothing is left to be built
        change(m)
        vfife.simulate(m, duration=0.01)
    assert words in str(told.value) and "p" in str(told.value).split(",")[0]


def test_start_given_outside_a_bearing_is_refused() -> None:
    m = pendulum()
    m.joints["J"] = ClearanceRevolute(
        name="J", bearing="ground.O", journal="rod.start", clearance=1e-4, bearing_radius=0.01
    )
    assembled_at(m, start={"rod": (0.0, 5e-5, -0.5)}, duration=0.01)
    with pytest.raises(ValueError, match=r"joint 'J' starts with rod.start 0.1999 m deep in ground.O"):
        assembled_at(m, start={"rod": (0.2, 0.0, -0.5)}, duration=0.01)


def test_a_run_shorter_than_an_output_of_a_slow_crank_lasts_as_long_as_asked() -> None:
    m = pendulum()
    m.link("arm", length=0.1, mass=1.0)
    m.revolute("K", "rod.end", "arm.start")
    m.drive("rod", speed=1e-3)
    choice = assembled_at(m, 1e-4, duration=0.01).choice
    assert choice.steps * choice.step == pytest.approx(0.01, rel=0.02)


def test_a_driver_of_what_is_held() -> None:
    """A wheel geared to a block in a guide, which cannot turn: a ramp from rest is consistent at the start,
    and moves nothing.
    """
    m = Mechanism("held")
    m.point("O", 0.0, 0.0)
    m.rigid_body("wheel", mass=1.0, inertia=0.5)
    m.rigid_body("block", mass=1.0, inertia=0.5)
    m.revolute("A", "ground.O", "wheel.center")
    m.slider("B", "ground.O", "block.center")
    m.gear("G", "wheel", "block", ratio=-1.0)
    m.drivers["wheel"] = Ramp(body="wheel", speed=4.0, duration=0.01)
    with pytest.raises(
        ValueError, match=r"the drivers \(wheel\) prescribe 1 motions, and the joints leave 0 of them free"
    ):
        assemble(m, 1e-4, duration=0.01)


def test_two_materials_of_one_name_run_from_python() -> None:
    """No file can hold them, but nothing is wrong with the mechanism."""
    m = Mechanism("two steels", gravity=(0.0, -9.81))
    m.point("O", 0.0, 0.0)
    for name, modulus in (("first", 2.0e11), ("second", 2.1e11)):
        m.link(name, length=0.2, mass=1.0, material=vfife.Material(youngs_modulus=modulus))
    m.revolute("A", "ground.O", "first.start")
    m.revolute("B", "first.end", "second.start")
    assert vfife.simulate(m, duration=1e-3, reference=False).record.status == "complete"
