"""Model files: whatever is wrong is told at once, each fault as a sentence with its place."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from model_texts import FOUR_BAR, faults, only, with_lines
from vfife.errors import ModelError
from vfife.modelfile import load
from vfife.modelfile import loads as read

# ----------------------------------------------------------------------------------------------------- faults

WRONG = """
name = 3
colour = "red"
gravity = [1]
[run]
turns = "2 kg"
duration = 1
step = -1
outputs = true
[ground]
A = [0, 0]
[body.crank]
length = "0 m"
mass = -2
[body.coupler]
model = "elastik"
length = nan
mass = 1
lenght = 3
[body.follower]
model = "elastic"
length = 1
elements = 0
[body.plate]
mass = 1
inertia = -3
[joint.A]
bearing = "grund.A"
journal = "crank.begin"
[joint.C]
kind = "clearance"
bearing = "ground.A"
journal = "coupler.start"
clearance = "12 mm"
bearing_radius = "10 mm"
contact = { law = "periera" }
friction = { law = "ambrosio", v0 = 1, coefficent = 3 }
[driver.follower]
speed = "25 Hz"
[load.push]
at = "crank.end"
force = [1, "2 kg"]
"""

EXPECTED = [
    ("name", "= 3", "a text"),
    ("colour", "unknown key"),
    ("gravity[1]", "missing"),
    ("[run] turns", "a mass", "a number without a unit"),
    ("[run] duration", "exclude"),
    ("[run] step", "negative", "above 0 s"),
    ("[run] outputs", "true or false", "a whole number"),
    ("[body.crank] length", "above 0 m"),
    ("[body.crank] mass", "-2", "negative", "at least 0 kg"),
    ("[body.coupler] model", "elastik", 'Did you mean "elastic"?'),
    ("[body.coupler] length", "nan", "not a finite number"),
    ("[body.coupler] lenght", 'Did you mean "length"'),
    ("[body.follower] elements", "too small", "from 1 to 100000"),
    ("[body.follower] section", "missing"),
    ("[body.plate] inertia", "negative", "at least 0 kg m^2"),
    ("[joint.A] bearing", "grund", 'Did you mean "ground.A"?'),
    ("[joint.A] journal", "no pin 'begin'", "crank."),
    ("[joint.C] clearance", "12 mm", "below bearing_radius = 0.01 m", "as large as the bearing"),
    ("[joint.C.contact] law", "periera", 'Did you mean "pereira"?'),
    ("[joint.C.friction] v1", "above v0 = 1 m/s"),
    ("[joint.C.friction] coefficent", 'Did you mean "coefficient"?'),
    ("[driver.follower] speed", "25 Hz", "a frequency", "an angular velocity", 'Write "1500 rpm" if turns'),
    ("[load.push] force[1]", "a mass", "a force"),
]


def test_all_faults_of_a_file_are_told_at_once(tmp_path: Path) -> None:
    path = tmp_path / "wrong.toml"
    path.write_text(WRONG, encoding="utf-8")
    with pytest.raises(ModelError) as caught:
        load(path)
    told = str(caught.value).splitlines()
    assert told[0] == f"{path} has {len(EXPECTED)} faults:"
    assert all(str(path) in line for line in told)
    for words in EXPECTED:
        found = [
            line
            for line in told[1:]
            if re.search(rf"{path}, (line \d+, )?{re.escape(words[0])}", line)
            and all(word in line for word in words)
        ]
        assert len(found) == 1, (words, told)
    assert len(caught.value.faults) == len(EXPECTED)


# What is replaced in the four-bar by what, where the fault is, and words of it.
ONE_FAULT = {
    "no such body": ('journal = "crank.start"', 'journal = "crnk.start"', "[joint.A] journal", "crank.start"),
    "no such point": ('bearing = "ground.A"', 'bearing = "ground.B"', "[joint.A] bearing", "no point 'B'"),
    "no pin": ('journal = "crank.start"', 'journal = "crank"', "[joint.A] journal", "crank.start"),
    "same body": ('journal = "coupler.start"', 'journal = "crank.start"', "[joint.B] journal", "same body"),
    "clearance": ('clearance = "0.2 mm"', "clearance = 0", "[joint.C] clearance", "above 0 m"),
    "no radius": ('bearing_radius = "10 mm"', "", "[joint.C] bearing_radius", "missing"),
    "kind": ('kind = "clearance"', "", "[joint.C] kind", 'kind = "clearance"'),
    "kind misspelt": (
        'kind = "clearance"',
        'kind = "clearence"',
        "[joint.C] kind",
        'Did you mean "clearance"?',
    ),
    "kind ideal": (
        'bearing = "crank.end"',
        'bearing = "crank.end"\nclearance = 1e-4\nkind = "ideal"',
        "[joint.B]",
        "ideal joint",
    ),
    "restitution": (
        "restitution = 0.5",
        "restitution = 0",
        "[joint.C.contact] restitution",
        "above 0 and at most 1",
    ),
    "restitution 2": (
        "restitution = 0.5",
        "restitution = 1.01",
        "[joint.C.contact] restitution",
        "too large",
    ),
    "law key": ("restitution = 0.5", "stiffness = 1", "[joint.C.contact] stiffness", "another law"),
    "ramp": ('v1 = "0.1 m/s"', 'v1 = "10 mm/s"', "[joint.C.friction] v1", "above v0"),
    "elements": ("mass = 2.028", "mass = 1\nelements = 3", "[body.coupler] elements", "elastic"),
    "many elements": (
        "mass = 2.028",
        'model = "elastic"\nsection = { round = 1 }\nelements = 1000000',
        "[body.coupler] elements",
        "from 1 to 100000",
    ),
    "inertia": ("mass = 2.028", 'mass = 1\ninertia = "-1 kg m^2"', "[body.coupler] inertia", "negative"),
    "inertia of a bar": (
        "mass = 2.028",
        'model = "two-particle"\ninertia = 1\nsection = { round = 1 }',
        "[body.coupler] inertia",
        "rigid",
    ),
    "pins of an elastic link": (
        "mass = 2.028",
        'model = "elastic"\nsection = { round = 1 }\npins = { P = [0, 0] }',
        "[body.coupler] pins",
        "does not use this",
    ),
    "no mass": ("mass = 2.028", "", "[body.coupler] mass", "section"),
    "section": ("mass = 2.028", "section = { area = 1 }", "[body.coupler] section", "not complete"),
    "two sections": (
        "mass = 2.028",
        "section = { square = 1, round = 1 }",
        "[body.coupler] section",
        "more than once",
    ),
    "pin twice": (
        "mass = 2.028",
        "mass = 1\npins = { start = [0, 0] }",
        "[body.coupler.pins] start",
        "already",
    ),
    "material": (
        "mass = 2.028",
        'mass = 1\nmaterial = "stel"',
        "[body.coupler] material",
        'Did you mean "steel"?',
    ),
    "velocity": ('mass = "3.12 kg"', "mass = 1\nvelocity = [1, 0, 0]", "[body.crank] velocity", "driver"),
    "unit": ("length = 0.26", 'length = "0.26 s"', "[body.coupler] length", "a time"),
    "unknown unit": ("length = 0.26", 'length = "260 mmm"', "[body.coupler] length", 'did you mean "mm"'),
    "no length": ("length = 0.26", "", "[body.coupler] length", "missing"),
    "a driver too many": ('speed = "1500 rpm"', "speed = 1\ntorque = 1", "[driver.crank]", "exclude"),
    "a driver without": ('speed = "1500 rpm"', "ramp = 1", "[driver.crank]", "is missing"),
    "lists": ('speed = "1500 rpm"', "times = [0, 1]\nangles = [0]", "[driver.crank] angles", "2 values"),
    "order": (
        'speed = "1500 rpm"',
        "times = [0, 1, 1]\nangles = [0, 1, 2]",
        "[driver.crank] times",
        "ascend",
    ),
    "ramp and table": (
        'speed = "1500 rpm"',
        "ramp = 1\ntimes = [0, 1]\nangles = [0, 1]",
        "[driver.crank] ramp",
        "speed",
    ),
    "two lengths of a run": ("turns = 2", "turns = 2\nduration = 1", "[run] duration", "exclude"),
    "turns of nothing": ('[driver.crank]\nspeed = "1500 rpm"', "", "[run] turns", "nothing is driven"),
    "journals": (
        "turns = 2",
        'turns = 2\n[start]\njournals = "centered"',
        "[start] journals",
        'Did you mean "centred"?',
    ),
    "scalar for a table": ("[body.crank]", "[body]\nhelper = 3\n[body.crank]", "[body] helper", "a table"),
    "name": ("[body.crank]", '[body."a.b"]\nlength = 1\nmass = 1\n[body.crank]', "[body]", "part of a path"),
    "ground": (
        "[body.crank]",
        "[body.ground]\nlength = 1\nmass = 1\n[body.crank]",
        "[body] ground",
        "reserved for the fixed frame",
    ),
    "a date": ("length = 0.26", "length = 1979-05-27", "[body.coupler] length", "a date"),
}


@pytest.mark.parametrize("case", ONE_FAULT)
def test_one_fault_is_told_once_with_its_place(case: str) -> None:
    old, new, where, words = ONE_FAULT[case]
    told = only(with_lines(replace=(old, new)))
    assert told.startswith(where), told
    assert words in told, told


@pytest.mark.parametrize(
    ("lines", "where", "words"),
    [
        ('[load.a]\nat = "ground.A"', "[load.a] at", "ground"),
        ('[load.a]\nat = "coupler.mid"', "[load.a] at", "no pin 'mid'"),
        ('[load.a]\nat = "coupler.end"\ntimes = [0, 1]', "[load.a] factors", "go together"),
        ("[driver.rod]\nspeed = 1", "[driver.rod]", "no body 'rod'"),
        ("[driver.coupler]\nspeed = 1", "[driver.coupler]", "here: none"),
        (
            '[joint.A2]\nbearing = "crank.start"\njournal = "ground.A"',
            "[joint.A2]",
            "joint A connects the same two pins",
        ),
        ("[material.wood]\ndensity = 500\npoissons_ratio = 0.3", "[material.wood] youngs_modulus", "missing"),
        ('[body.p]\nmodel = "particle"\nmass = 1\nlength = 2', "[body.p] length", "no such key"),
        (
            '[body.p]\nmodel = "rigid"\nmass = 1\npins = {P = [0, 0]}',
            "[body.p] inertia",
            "a link has a length",
        ),
    ],
)
def test_more_faults(lines: str, where: str, words: str) -> None:
    told = [line for line in faults(with_lines(lines)) if line.startswith(where)]
    assert len(told) == 1
    assert words in told[0]


def test_a_driven_link_must_not_be_released_where_it_is_turned() -> None:
    bar = 'model = "two-particle"\nsection = { square = 1e-3 }\n'
    for release in ("start", "both"):
        told = only(with_lines(replace=('mass = "3.12 kg"', bar + f'release = "{release}"')))
        assert told.startswith("[body.crank] release")
    read(with_lines(replace=('mass = "3.12 kg"', bar + 'release = "end"')))


def test_a_law_that_makes_no_sense_of_the_surfaces_is_told() -> None:
    """Pereira's exponent is no real number for clearances below 1 micrometre."""
    told = only(FOUR_BAR, [("joint.C.clearance", "0.5 um")])
    assert told.startswith("[joint.C] contact")
    assert "pereira" in told


@pytest.mark.parametrize(
    ("text", "line", "column", "words"),
    [
        ("a = [1,\n b]", 2, 2, ""),
        ("[run]\nturns = 2 turns\n", 2, 11, "turns = 2 turns"),
        ("a = 1\na = 2", 2, 6, "once"),
        ('a = "x\n', 1, 7, "quote"),
    ],
)
def test_syntax_faults_have_line_and_column(text: str, line: int, column: int, words: str) -> None:
    told = only(text)
    assert told.startswith(f"line {line}, column {column}"), told
    assert words in told


def test_files_that_cannot_be_read(tmp_path: Path) -> None:
    with pytest.raises(ModelError, match=r"none\.toml, file: it cannot be read"):
        load(tmp_path / "none.toml")
    with pytest.raises(ModelError, match="is a folder, not a model; name a file"):
        load(tmp_path)
    (tmp_path / "latin.toml").write_bytes(b'name = "J\xe9r\xf4me"')
    with pytest.raises(ModelError, match="byte 9: the text is not UTF-8"):
        load(tmp_path / "latin.toml")
    (tmp_path / "bom.toml").write_bytes(b"\xef\xbb\xbf" + FOUR_BAR.encode())
    assert load(tmp_path / "bom.toml") == read(FOUR_BAR)


@pytest.mark.parametrize(
    "text",
    [
        "a = " + "[" * 100_000,
        "a = " + "9" * 5_000,
        "a." * 3_000 + "a = 1",
        "[body.x]\n" + "a." * 3_000 + "a = 1",
        "[joint.x.contact]\n" + "a." * 3_000 + "a = 1",
        "[body.x]\nlength = " + "9" * 400,
        "[[body]]\n[[joint]]\n[[run]]\n[[ground]]",
        "body = []\njoint = 1\nrun = true\nground = ''\ndriver = 1979-05-27\nload = nan\nmaterial = inf",
    ],
    ids=["lists", "digits", "keys", "keys of a body", "keys of a law", "large", "arrays", "scalars"],
)
def test_hostile_files_are_model_errors(text: str) -> None:
    with pytest.raises(ModelError):
        read(text, [("run.turns", "1"), ("joint.x.kind", "ideal"), ("nonsense", 1), ("ground.A.0", 1)])
