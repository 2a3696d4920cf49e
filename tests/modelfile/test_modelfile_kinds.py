"""Model files of any planar mechanism: what the tables of frames, guides, gears, springs and drivers mean,
and their faults.
"""

from __future__ import annotations

import math
import time

import pytest

from model_texts import PLAYGROUND, faults, only, played
from vfife.laws import Material
from vfife.model import bodies, drivers, joints, springs
from vfife.model.mechanism import Settings
from vfife.modelfile import dump
from vfife.modelfile import loads as read

# ---------------------------------------------------------------------------------------------------- meaning


def test_every_table_means_what_it_says() -> None:
    model = read(PLAYGROUND)
    frame, beam = model.bodies["truss"], model.bodies["beam"]
    assert isinstance(frame, bodies.Frame)
    assert isinstance(beam, bodies.Link)
    assert frame.section == bodies.Section.round(0.01)
    assert frame.members == (
        bodies.Member("A", "B", elements=3),
        bodies.Member("B", "C", section=bodies.Section.square(1e-4), mass=2.0),
        bodies.Member("C", "A"),
    )
    assert (frame.masses, frame.points) == ({"C": 1.0}, {"A": (0.0, 0.0), "B": (1.0, 0.0), "C": (0.0, 1.0)})
    assert beam.via == ((0.5, 0.2),)
    assert beam.section is not None
    assert beam.section.area == pytest.approx(math.pi * (0.01**2 - 0.008**2), rel=1e-14)
    assert beam.section.second_moment == pytest.approx(math.pi / 4 * (0.01**4 - 0.008**4), rel=1e-14)
    assert beam.section.extreme_fibre == 0.01
    assert model.joints["guide"] == joints.Slider(
        name="guide", bearing="ground.P", journal="block.left", direction=(0.0, 1.0)
    )
    assert model.joints["clamp"] == joints.Weld(name="clamp", bearing="ground.Q", journal="beam.start")
    assert model.joints["rail"] == joints.ClearanceSlider(
        name="rail", bearing="ground.P", journal="truss.A", clearance=1e-4, length=0.05, height=0.02
    )
    assert model.joints["cam"] == joints.ExternalContact(
        name="cam", bearing="truss.B", journal="bar.end", journal_radius=0.01
    )
    assert model.gears["wheels"] == joints.Gear(name="wheels", first="arm", second="bar", ratio=-2.5)
    assert model.springs == {
        "coil": springs.Spring(name="coil", first="ground.O", second="block.right", stiffness=2000.0),
        "twist": springs.TorsionalSpring(name="twist", first="arm", second="bar", stiffness=3.0),
        "bump": springs.Stop(
            name="bump", first="ground", second="bar", low=-math.pi / 6, high=math.pi / 6, stiffness=100.0
        ),
        "mount": springs.Bushing(
            name="mount", first="beam.end", second="truss.C", stiffness=(1e6, 1e6, 10.0)
        ),
    }
    assert model.drivers == {
        "lift": drivers.StepTo(slider="guide", travel=0.02, duration=0.1),
        "shake": drivers.Harmonic(
            point="truss.C", direction=(0.0, 1.0), amplitude=1e-3, frequency=50.0, phase=math.pi / 2
        ),
        "motor": drivers.Torque(body="arm", value=(3.0, 0.0), speeds=(0.0, 100 * math.pi)),
    }
    assert model.loads["wind"].follow
    assert read(dump(model)) == model


DRIVERS = {
    "body": ("[driver.arm]", {"body": "arm"}, "angles", '"180 deg"', math.pi),
    "against": (
        '[driver.x]\nbody = "bar"\nagainst = "arm"',
        {"body": "bar", "against": "arm"},
        "angles",
        '"180 deg"',
        math.pi,
    ),
    "slider": ('[driver.x]\nslider = "guide"', {"slider": "guide"}, "travels", '"30 mm"', 0.03),
    "point": (
        '[driver.x]\npoint = "bar.end"\ndirection = [0, 2]',
        {"point": "bar.end", "direction": (0.0, 2.0)},
        "travels",
        '"30 mm"',
        0.03,
    ),
}


@pytest.mark.parametrize("case", DRIVERS)
def test_units_of_a_driver_are_those_of_what_it_drives(case: str) -> None:
    head, target, places, written, size = DRIVERS[case]
    lift = PLAYGROUND[PLAYGROUND.index("[driver.lift]") : PLAYGROUND.index("[load.wind]")]

    def driver(keys: str) -> drivers.Driver:
        (made,) = read(played((lift, f"{head}\n{keys}\n"))).drivers.values()
        return made

    assert driver(f"speed = {written[:-1]}/s{written[-1]}") == drivers.ConstantSpeed(**target, speed=size)
    assert driver(f'speed = {written[:-1]}/s{written[-1]}\nramp = "20 ms"') == drivers.Ramp(
        **target, speed=size, duration=0.02
    )
    assert driver(f"travel = {written}\nduration = 2\nbegin = 1") == drivers.StepTo(
        **target, travel=size, duration=2.0, begin=1.0
    )
    assert driver(f'amplitude = {written}\nfrequency = "50 Hz"') == drivers.Harmonic(
        **target, amplitude=size, frequency=50.0
    )
    assert driver(f"times = [0, 1]\n{places} = [0, {written}]") == drivers.AngleTable(
        **target, times=(0.0, 1.0), values=(0.0, size)
    )
    if case == "slider":
        return
    effort = "force" if case == "point" else "torque"
    assert driver(f"{effort} = 3") == drivers.Torque(**target, value=3.0)
    for over, more, noun in (
        ("times", "2", "times"),
        (places, written, "angles"),
        ("speeds", f"{written[:-1]}/s{written[-1]}", "speeds"),
    ):
        last = 2.0 if over == "times" else size
        made = driver(f"{effort} = [0, 3]\n{over} = [0, {more}]")
        assert made == drivers.Torque(**target, value=(0.0, 3.0), **{noun: (0.0, last)})  # type: ignore[arg-type]


def test_a_static_analysis_has_its_keys() -> None:
    lines = (
        'analysis = "static"\nload_factors = [0.5, 1]\nresidual = 1e-8\nkinetic_energy = 1e-9\niterations'
        " = 500"
    )
    model = read(
        played(
            ("duration = 1", lines),
            ("torque = [3, 0]\n", "torque = 3\n"),
            ('speeds = ["0 rpm", "3000 rpm"]', ""),
        )
    )
    expected = Settings(
        analysis="static", load_factors=(0.5, 1.0), residual=1e-8, kinetic_energy=1e-9, iterations=500
    )
    assert model.settings == expected


def test_members_have_materials_and_paths() -> None:
    text = played(('{ start = "C", end = "A" }', '{ start = "C", end = "A", material = "wood" }'))
    text += "[material.wood]\nyoungs_modulus = 1e10\npoissons_ratio = 0.3\ndensity = 500\n"
    model = read(
        text,
        [
            ("body.truss.members.2.elements", 7),
            ("body.truss.nodes.B", "[2, 0]"),
            ("spring.coil.stiffness", "5 N/mm"),
        ],
    )
    frame = model.bodies["truss"]
    assert isinstance(frame, bodies.Frame)
    assert frame.members[2] == bodies.Member(
        "C", "A", elements=7, material=Material("wood", 1e10, 0.3, 500.0)
    )
    assert frame.nodes["B"] == (2.0, 0.0)
    assert model.springs["coil"].stiffness == 5000.0


def test_setting_a_kind_drops_what_the_new_kind_has_no_use_for() -> None:
    model = read(
        PLAYGROUND,
        [("joint.rail.kind", "slider"), ("joint.guide.kind", "ideal"), ("joint.cam.kind", "weld")] + NO_LIFT,
    )
    assert model.joints["rail"] == joints.Slider(name="rail", bearing="ground.P", journal="truss.A")
    assert isinstance(model.joints["cam"], joints.Weld)


NO_LIFT = [("driver.lift", {"body": "arm", "torque": 1})]

# ----------------------------------------------------------------------------------------------------- faults

# What is replaced by what, where the one fault is, and words of it.
ONE_FAULT = {
    "guide of no length": (
        "direction = [0, 1]\n[joint.clamp]",
        "direction = [0, 0]\n[joint.clamp]",
        "[joint.guide] direction",
        "no length",
    ),
    "driver of no direction": (
        "direction = [0, 1]\namplitude",
        "direction = [0, 0]\namplitude",
        "[driver.shake] direction",
        "no length",
    ),
    "two pins": (
        "[joint.guide]",
        '[joint.b]\nbearing = "bar.end"\njournal = "arm.end"\n'
        '[joint.c]\nbearing = "bar.end"\njournal = "arm.end"\n[joint.guide]',
        "[joint.b]",
        "joints elbow and b both hold arm and bar: together they weld",
    ),
    "turning": (
        "direction = [0, 1]\n[joint.clamp]",
        'turning = "yes"\n[joint.clamp]',
        "[joint.guide] turning",
        "true or false",
    ),
    "key of another kind": (
        'kind = "weld"',
        'kind = "weld"\ndirection = [1, 0]',
        "[joint.clamp] direction",
        'Set kind = "slider"',
    ),
    "clearance of a slider": (
        'kind = "slider"',
        'kind = "slider"\nclearance = 1e-4',
        "[joint.guide] clearance",
        'Set kind = "clearance-slider" (or clearance, ',
    ),
    "kind": ('kind = "weld"', 'kind = "wield"', "[joint.clamp] kind", 'Did you mean "weld"?'),
    "block": (
        'height = "20 mm"',
        'height = "1 mm"',
        "[joint.rail] corner_radius",
        "do not fit on a block of 0.05 m by 0.001 m",
    ),
    "no height": ('height = "20 mm"', "", "[joint.rail] height", "missing"),
    "round with a direction": (
        'journal_radius = "10 mm"',
        "journal_radius = 1\nbearing_radius = 2\ndirection = [0, 1]",
        "[joint.cam] direction",
        "a round has no direction",
    ),
    "ratio": ("ratio = -2.5", "ratio = 0", "[gear.wheels] ratio", "would not turn at all"),
    "gear of one": (
        'second = "bar"\nratio',
        'second = "arm"\nratio',
        "[gear.wheels] second",
        "arm with itself",
    ),
    "gear to the ground": (
        'second = "bar"\nratio',
        'second = "ground"\nratio',
        "[gear.wheels]",
        "holds the body",
    ),
    "gear of pins": (
        'second = "bar"\nratio',
        'second = "bar.end"\nratio',
        "[gear.wheels] second",
        'Name the body alone: "bar"',
    ),
    "gear of a stranger": (
        'second = "bar"\nratio',
        'second = "baar"\nratio',
        "[gear.wheels] second",
        'Did you mean "bar"',
    ),
    "second gear": (
        "[spring.coil]",
        '[gear.more]\nfirst = "bar"\nsecond = "arm"\nratio = 1\n[spring.coil]',
        "[gear.more]",
        "gear wheels couples",
    ),
    "spring of nothing": ('stiffness = "2 N/mm"', "", "[spring.coil]", "neither a stiffness nor a damping"),
    "twist of nothing": (
        'stiffness = "3 N m/rad"',
        "stiffness = 0",
        "[spring.twist]",
        "neither a stiffness nor a damping",
    ),
    "bushing of nothing": (
        'stiffness = ["1 kN/mm", 1e6, "10 N m/rad"]',
        "stiffness = [0, 0, 0]",
        "[spring.mount]",
        "neither",
    ),
    "stiffness unit": (
        'stiffness = "3 N m/rad"',
        'stiffness = "3 N/m"',
        "[spring.twist] stiffness",
        "a torsional stiffness",
    ),
    "spring to a stranger": (
        'second = "block.right"',
        'second = "block.rigt"',
        "[spring.coil] second",
        'Did you mean "block.right"',
    ),
    "spring on one body": (
        'first = "ground.O"\nsecond = "block',
        'first = "block.left"\nsecond = "block',
        "[spring.coil] second",
        "both ends are on 'block'",
    ),
    "stop of pins": (
        'first = "ground"\nsecond = "bar"',
        'first = "ground"\nsecond = "bar.end"',
        "[spring.bump] second",
        "body alone",
    ),
    "stop": ('low = "-30 deg"', 'low = "30 deg"', "[spring.bump] low", "no room between the limits"),
    "stop of no stiffness": ("stiffness = 100", "", "[spring.bump] stiffness", "missing"),
    "spring kind": ('kind = "stop"', 'kind = "stopp"', "[spring.bump]", 'Did you mean "stop"?'),
    "slider driver": ('slider = "guide"', 'slider = "gide"', "[driver.lift] slider", 'Did you mean "guide"?'),
    "driver of a pivot": ('slider = "guide"', 'slider = "pivot"', "[driver.lift] slider", "of kind ideal"),
    "force on a slider": (
        'travel = "20 mm"\nduration = "0.1 s"',
        "force = 3",
        "[driver.lift] force",
        "acts on a point",
    ),
    "driven pin": ('point = "truss.C"', 'point = "truss.D"', "[driver.shake] point", "no pin 'D'"),
    "driven ground": (
        'point = "truss.C"',
        'point = "ground.O"',
        "[driver.shake] point",
        "the ground moves nothing",
    ),
    "driver of a stranger": ('body = "arm"', 'body = "arn"', "[driver.motor] body", 'or "arm"?'),
    "against a stranger": (
        'body = "arm"',
        'body = "arm"\nagainst = "bra"',
        "[driver.motor] against",
        '"bar"',
    ),
    "against itself": ('body = "arm"', 'body = "arm"\nagainst = "arm"', "[driver.motor] against", "itself"),
    "travel unit": ('travel = "20 mm"', 'travel = "20 deg"', "[driver.lift] travel", "a length"),
    "travel at once": ('duration = "0.1 s"', "", "[driver.lift] duration", "travel needs a duration"),
    "phase of a travel": (
        'duration = "0.1 s"',
        'duration = "0.1 s"\nphase = 1',
        "[driver.lift] phase",
        "goes with amplitude, not with travel",
    ),
    "motor of two curves": (
        "torque = [3, 0]",
        "torque = [3, 0]\ntimes = [0, 1]",
        "[driver.motor] speeds",
        "one of times and speeds",
    ),
    "motor's curve": ('["0 rpm", "3000 rpm"]', '["3000 rpm", "0 rpm"]', "[driver.motor] speeds", "ascend"),
    "two drivers of a slider": (
        "[driver.motor]",
        '[driver.two]\nslider = "guide"\nspeed = 1\n[driver.motor]',
        "[driver.two]",
        "driver lift drives the slider guide",
    ),
    "two drivers of a body": (
        "[driver.motor]",
        '[driver.arm]\nspeed = 1\n[driver.two]\nbody = "arm"\nspeed = 2\n[driver.motor]',
        "[driver.two]",
        "driver arm drives arm",
    ),
    "two drivers of a pin": (
        "[driver.motor]",
        '[driver.two]\npoint = "truss.C"\ndirection = [0, -3]\nspeed = 1\n[driver.motor]',
        "[driver.two]",
        "driver shake moves truss.C",
    ),
    "driver of a held body": (
        "[driver.motor]",
        "[driver.block]\nspeed = 1\n[driver.motor]",
        "[driver.block]",
        "the slider guide keeps the angle",
    ),
    "load on the ground": ('at = "beam.end"', 'at = "ground.O"', "[load.wind] at", "follows the ground"),
    "follow": ("follow = true", "follow = 1", "[load.wind] follow", "true or false"),
    "tube": (
        'tube = ["20 mm", "16 mm"]',
        'tube = ["16 mm", "20 mm"]',
        "[body.beam.section] tube",
        "no wall is left",
    ),
    "fibre": (
        'tube = ["20 mm", "16 mm"]',
        "area = 1e-4, second_moment = 1e-8, extreme_fibre = 1e-3",
        "[body.beam.section] extreme_fibre",
        "at least sqrt",
    ),
    "fibre of a shape": (
        'tube = ["20 mm", "16 mm"]',
        "round = 0.1, extreme_fibre = 0.05",
        "[body.beam.section] extreme_fibre",
        "knows",
    ),
    "two shapes": (
        'tube = ["20 mm", "16 mm"]',
        "tube = [2, 1], round = 1",
        "[body.beam] section",
        "more than once",
    ),
    "via": (
        "via = [[0.5, 0.2]]",
        "via = [[0.5, 0.2], [0.5, 0.2]]",
        "[body.beam] via",
        "via[0] and via[1] coincide",
    ),
    "via at the end": (
        "via = [[0.5, 0.2]]",
        "via = [[1, 0]]",
        "[body.beam] via",
        "via[0] and the end coincide",
    ),
    "few elements": ("elements = 4", "elements = 1", "[body.beam] elements", "1 element for 2 pieces"),
    "flywheel": ("mass = 2\n", 'mass = 2\nend_inertia = "-1 kg m^2"\n', "[body.arm] end_inertia", "negative"),
    "node": ('end = "C", section', 'end = "CC", section', "[body.truss] members[1].end", 'Did you mean "C"?'),
    "node of a mass": ("masses = { C = 1 }", "masses = { K = 1 }", "[body.truss.masses] K", "no node 'K'"),
    "no section": (
        'section = { round = "10 mm" }\nmembers',
        "members",
        "[body.truss] members[0].section",
        "neither the member nor the frame",
    ),
    "long member": (
        "elements = 3",
        "elements = 1000000",
        "[body.truss] members[0].elements",
        "from 1 to 100000",
    ),
    "material of a member": (
        "elements = 3",
        'material = "stel"',
        "[body.truss] members[0].material",
        '"steel"',
    ),
    "pointless": (
        '{ start = "C", end = "A" }',
        '{ start = "C", end = "C" }',
        "[body.truss] members[2]",
        "starts and ends at one node",
    ),
    "no length": (
        "C = [0, 1] }",
        "C = [0, 0] }",
        "[body.truss] members[2]",
        "nodes C and A, which are in one place",
    ),
    "double": (
        '{ start = "C", end = "A" }',
        '{ start = "B", end = "A" }',
        "[body.truss] members[2]",
        "members[0] joins B and A already",
    ),
    "disconnected": (
        "C = [0, 1] }",
        "C = [0, 1], D = [2, 2], E = [3, 3] }",
        "[body.truss] nodes",
        "from A to D, E",
    ),
    "no members": ("nodes = { A", "members2 = []\nnodes = { A", "[body.truss] members2", '"members"'),
    "static for a time": (
        "duration = 1",
        'duration = 1\nanalysis = "static"',
        "[run] duration",
        "takes no time",
    ),
    "dynamic factors": (
        "duration = 1",
        "duration = 1\nload_factors = [1]",
        "[run] load_factors",
        'analysis = "static"',
    ),
    "large residual": ("duration = 1", "duration = 1\nresidual = 2", "[run] residual", "at most 0.1"),
    "analysis": ("duration = 1", 'duration = 1\nanalysis = "statics"', "[run] analysis", '"static"'),
    "kind of a spring left out": ('kind = "stop"', "", "[spring.bump] kind", 'Add kind = "stop"'),
    "name of a driver": ("[driver.motor]", '[driver."a.b"]', "[driver]", "part of a path"),
    "name of a spring": ("[spring.coil]", '[spring." coil"]', "[spring]", "part of a path"),
    "name of a node": ("C = [0, 1] }", '"C\\n" = [0, 1] }', "[body.truss.nodes]", "part of a path"),
    "schema as a key": ('name = "everything"', '"$schema" = "x"', "$schema", "#:schema PATH"),
}


@pytest.mark.parametrize("case", ONE_FAULT)
def test_a_fault_is_told_with_its_place_and_remedy(case: str) -> None:
    old, new, where, words = ONE_FAULT[case]
    began = time.process_time()
    told = faults(played((old, new)))
    assert time.process_time() - began < 2.0
    found = [line for line in told if line.startswith(where) and words in line]
    assert len(found) == 1, told
    # One mistake may make others visible; where it does not, nothing else is told.
    more = {
        "no section": 2,
        "two pins": 3,
        "node": 1,
        "name of a node": 6,
        "large residual": 2,
        "static for a time": 2,
        "pointless": 1,
        "disconnected": 1,
        "gear of one": 1,
    }
    assert len(told) <= more.get(case, 1), told


def test_speeds_have_no_meaning_in_a_static_analysis() -> None:
    told = faults(
        played(
            ("duration = 1", 'analysis = "static"\nturns = 3'),
            ('travel = "20 mm"', "speed = 1"),
            ('duration = "0.1 s"', 'ramp = "0.1 s"'),
        )
    )
    places = sorted(line.partition(" = ")[0] for line in told)
    assert places == sorted(["[run] turns", "[driver.lift] speed", "[driver.motor] speeds"])
    assert any("load factors take the place of time" in line for line in told)


def test_beams_and_frames_may_be_held_twice() -> None:
    """Two pins between bodies that do not deform weld them; a beam or a portal frame on two hinges is what it
    is.
    """
    portal = (
        '[joint.h1]\nbearing = "ground.O"\njournal = "truss.B"\n[joint.h2]\nbearing = "ground.P"\njournal ='
        ' "truss.C"\n[gear.wheels]'
    )
    read(played(("[gear.wheels]", portal)))
    beam = '[joint.h1]\nbearing = "ground.O"\njournal = "beam.end"\n[gear.wheels]'
    read(played(("[gear.wheels]", beam)))
    held = "[joint.h1]\nbearing = 'ground.P'\njournal = 'arm.end'\n[gear.wheels]"
    assert "pivot and h1 both hold arm and ground" in only(played(("[gear.wheels]", held)))


def test_two_drivers_of_geared_bodies_fight() -> None:
    lines = (
        '[driver.arm]\nspeed = 1\n[joint.more]\nbearing = "ground.Q"\njournal ='
        ' "bar.end"\n[driver.bar]\nspeed = 2\n[driver.lift]'
    )
    told = faults(played(("[driver.lift]", lines)))
    assert any("drivers arm and bar turn both bodies" in line for line in told), told


# ------------------------------------------------------------------------------------------------------ large
# models


def grid(bays: int, elements: int) -> str:
    """A frame of a chain of bays, two members each."""
    nodes = ", ".join(f"N{k} = [{k}, {k % 2}]" for k in range(bays + 1))
    members = ",\n".join(
        f'{{ start = "N{k}", end = "N{k + 1}", elements = {elements} }}' for k in range(bays)
    )
    return (
        '[run]\nduration = 1\n[ground]\nO = [0, 0]\n[body.f]\nmodel = "frame"\nsection = { round = 0.1'
        f' }}\nmembers = [{members}]\nnodes = {{ {nodes} }}\n[joint.a]\nkind = "weld"\nbearing ='
        ' "ground.O"\njournal = "f.N0"\n'
    )


def seconds(text: str) -> float:
    began = time.process_time()
    read(text)
    return time.process_time() - began


def test_a_hundred_thousand_elements_load_in_no_time() -> None:
    assert seconds(grid(1000, 100)) < 1.0


def test_the_elements_of_a_frame_are_counted_together() -> None:
    told = only(grid(1000, 101))
    assert told.startswith("[body.f] members")
    assert "101,000 elements" in told
    assert "at most 100,000" in told


def test_many_faults_are_told_soon() -> None:
    """Each of some thousand members names a node that is not there, and each could be a slip of any of some
    thousand names.
    """
    text = grid(3000, 1).replace('end = "N', 'end = "M')
    began = time.process_time()
    told = faults(text)
    assert time.process_time() - began < 2.0
    assert len(told) == 3000
