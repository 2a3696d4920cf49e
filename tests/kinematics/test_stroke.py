"""Strokes of sliders against closed forms, and loads over travel or angle that do not fit a turn."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import pytest

import vfife
from vfife import gallery
from vfife.assembly.possible import outlook
from vfife.kinematics.batch import Batch
from vfife.kinematics.stroke import strokes
from vfife.kinematics.table_peak import table_peak

CRANK, ROD = 0.019, 0.095


def slider_crank(
    angle: float, offset: float = 0.0, direction: tuple[float, float] = (1.0, 0.0), speed: float = 100.0
):
    m = vfife.Mechanism("slider-crank")
    m.point("O", 0.0, 0.0)
    m.point("rail", 0.0, offset)
    crank = m.link("crank", length=CRANK, mass=1.0, angle=angle)
    rod = m.link("rod", length=ROD, mass=0.2)
    m.rigid_body("block", mass=0.2, inertia=1e-4, position=(0.1, offset))
    m.revolute("main", "ground.O", crank.start)
    m.revolute("big", crank.end, rod.start)
    m.revolute("small", rod.end, "block.center")
    m.slider("guide", "ground.rail", "block.center", direction=direction)
    m.drive(crank, speed=speed)
    return m


@pytest.mark.parametrize("angle", [0.0, 2.0, -2.0])
@pytest.mark.parametrize("offset", [0.0, 0.01, -0.01])
def test_a_stroke_ends_where_crank_and_rod_are_in_line(angle: float, offset: float) -> None:
    """The dead centres: ((l + r)^2 - e^2)^(1/2) and ((l - r)^2 - e^2)^(1/2)."""
    m = slider_crank(angle, offset)
    answer = outlook(m)
    assert answer.motion is not None and answer.turn is not None
    [low], [high] = strokes(Batch([m]), [answer.motion], [answer.turn], "guide")
    ends = (math.sqrt((ROD + sign * CRANK) ** 2 - offset**2) for sign in (-1.0, 1.0))
    # The positions of a turn are 10 degrees apart: the nearest is up to 0.4 % of the crank's radius inside.
    assert (low, high) == pytest.approx(tuple(ends), abs=1e-5 * CRANK)
    reverse = slider_crank(angle, offset, (-2.0, 0.0))
    answer = outlook(reverse)
    [least], [greatest] = strokes(Batch([reverse]), [answer.motion], [answer.turn], "guide")
    assert (least, greatest) == pytest.approx((-high, -low), abs=1e-9)


def cautions(m: vfife.Mechanism) -> list[str]:
    return [note for note in m.check().notes if note.startswith(("The load", "The table"))]


def test_a_diagram_for_another_stroke_is_cautioned_about() -> None:
    m = gallery.compressor()
    assert not cautions(m)
    short = replace(m, bodies={**m.bodies, "crank": replace(m.bodies["crank"], length=0.019)})
    [note] = cautions(short)
    assert "The load gas jumps where cylinder reverses: at -4" in note
    assert "from -42 to -4 mm of the table" in note


@pytest.mark.parametrize(
    ("release", "jump"),
    [
        (0.1150, ""),
        (0.1155, ""),
        (0.1157, ""),
        (0.1165, "at 115.7 mm from -8000 to 0"),
        (None, "at 115.7 mm"),
    ],
)
def test_a_reversal_between_two_positions_of_a_turn_is_met(release: float | None, jump: str) -> None:
    """The ram of the press reverses at 115.717 mm, at a crank angle of 334.90 degrees; the nearest of 36
    positions is at 115.2 mm. A table is cautioned about where it jumps there, and nowhere else.
    """
    m = gallery.six_bar_press()
    table = {"travels": [-0.1, 0.06, 0.061, 0.12], "force": [0.0, 0.0, -8e3, -8e3]}
    if release is not None:
        table = {
            "travels": [-0.1, 0.06, 0.061, release - 2e-4, release, 0.12],
            "force": [0.0, 0.0, -8e3, -8e3, 0.0, 0.0],
        }
    table["force_back"] = [0.0] * len(table["travels"])
    m.guide_force("work", "guide", **table)
    notes = [note for note in cautions(m) if "where guide reverses" in note]
    assert len(notes) == bool(jump)
    assert all(jump in note and "from -94.53 to 115.7 mm" in note for note in notes)


@pytest.mark.parametrize(
    ("last", "value", "repeat", "said"),
    [
        (360.0, 8.0, None, ""),
        (355.0, 8.0, None, "covers 0° to 355° of the crank and keeps its last value"),
        (355.0, 8.0, False, ""),
        (355.0, 8.0, True, "repeats every 355° of the crank, not with each turn: let it end at 360°"),
        (360.0, 7.9, None, "its ends differ, 8 and 7.9, and keeps its last value"),
        (715.0, 8.0, None, "let it end at 720°"),
        (90.0, 8.0, None, ""),
        (180.0, 8.0, True, ""),
    ],
)
def test_a_table_that_ends_before_the_turn_is_cautioned_about(
    last: float, value: float, repeat: bool | None, said: str
) -> None:
    m = slider_crank(0.0)
    angles = [math.radians(degrees) for degrees in (0.0, 0.5 * last, last)]
    m.guide_force("gas", "guide", crank="crank", angles=angles, force=[8.0, 1.0, value], repeat=repeat)
    notes = cautions(m)
    assert len(notes) == bool(said) and all(said in note for note in notes)


def test_strokes_of_a_batch_are_those_of_each_case() -> None:
    machines = [slider_crank(2.0, offset) for offset in (0.008, 0.01, 0.012)]
    answers = [outlook(m) for m in machines]
    motions, turns = [answer.motion for answer in answers], [answer.turn for answer in answers]
    lows, highs = strokes(Batch(machines), motions, turns, "guide")
    assert len(set(lows)) == len(machines)
    for k, m in enumerate(machines):
        assert strokes(Batch([m]), motions[k : k + 1], turns[k : k + 1], "guide") == ([lows[k]], [highs[k]])


@pytest.mark.parametrize("speed", [100.0, -100.0])
@pytest.mark.parametrize("start", [0.3, -2.0])
@pytest.mark.parametrize(
    ("peak", "reverse", "centre", "lag"),
    [
        (350.0, True, "top dead centre", -10.0),
        (20.0, True, "top dead centre", 20.0),
        (170.0, True, "bottom dead centre", -10.0),
        (170.0, False, "top dead centre", -10.0),
    ],
)
def test_the_peak_of_a_diagram_is_placed_against_the_dead_centres(
    speed: float, start: float, peak: float, reverse: bool, centre: str, lag: float
) -> None:
    """In line, crank and rod are at 0 and 180 degrees; the head is where the gas pushes the piston away."""
    m = slider_crank(start, speed=speed)
    angles = [math.radians(degrees) for degrees in (0.0, peak, 360.0)]
    bar = [1e5, 11e5, 1e5]
    m.guide_force("gas", "guide", angles=angles, pressure=bar, bore=0.05, ambient=1e5, reverse=reverse)
    answer = outlook(m)
    found = table_peak(m, answer.motion, answer.turn, m.loads["gas"])
    assert found is not None
    assert (found.centre, found.value) == (centre, pytest.approx(11e5))
    assert (found.place, found.lag) == pytest.approx((peak, math.copysign(1.0, speed) * lag), abs=0.05)
    notes = [note for note in answer.notes if "zero_angle" in note]
    assert len(notes) == (centre == "bottom dead centre")


@pytest.mark.parametrize(
    ("degrees", "bar", "has_note"),
    [
        ((0, 240, 270, 300, 330, 360), (1, 1, 11, 8, 1, 1), True),  # of a cylinder whose crank began at 90
        ((0, 240, 270, 300, 330, 360), (1, 1, 11, 10, 10, 1), False),  # a valve that opens early
        ((0, 290, 320, 330, 340, 360), (1, 1, 11, 1, 1, 1), False),
    ],
)
def test_a_pressure_that_is_low_at_the_least_volume_has_a_caution(degrees, bar, has_note: bool) -> None:
    """The head is at 0 degrees."""
    m = slider_crank(0.3)
    table = {"angles": [math.radians(place) for place in degrees], "pressure": [1e5 * value for value in bar]}
    m.guide_force("gas", "guide", bore=0.05, ambient=1e5, reverse=True, **table)
    notes = [note for note in outlook(m).notes if "low where the volume is least" in note]
    assert len(notes) == has_note and all("peak at 270°, 90° before top" in note for note in notes)


def test_a_shift_of_the_table_moves_its_dead_centre() -> None:
    m = slider_crank(0.3)
    angles = [math.radians(degrees) for degrees in (0.0, 178.0, 360.0)]
    load = {"angles": angles, "pressure": [1e5, 9e5, 1e5], "bore": 0.05, "reverse": True}
    m.guide_force("gas", "guide", zero_angle=math.pi, **load)
    answer = outlook(m)
    found = table_peak(m, answer.motion, answer.turn, m.loads["gas"])
    assert found.words == "peak at 178°, 2° before top dead centre (180°)"
    assert not [note for note in answer.notes if "zero_angle" in note]


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({}, ""),
        ({"reverse": False}, "Is reverse wrong"),
        ({"pressure": ["8 bar", "1 bar"]}, "Is reverse wrong, or the table turned?"),
        ({"zero_travel": "77 mm"}, "moves from 0 to 46 mm of the table, which covers -46 to 0 mm"),
        ({"zero_travel": 0}, "moves from 77 to 123 mm of the table"),
    ],
)
def test_a_pressure_over_travel_that_pushes_to_its_peak_or_is_not_reached_is_cautioned_about(
    changes: dict[str, Any], words: str
) -> None:
    m = gallery.compressor()
    m.loads.clear()
    load = {"pressure": ["1 bar", "8 bar"], "reverse": True, "zero_travel": "123 mm"} | changes
    m.guide_force("gas", "cylinder", travels=["-46 mm", "0 mm"], bore="65 mm", ambient="1 bar", **load)
    notes = [note for note in outlook(m).notes if "load gas" in note]
    assert len(notes) == bool(words) and all(words in note for note in notes), notes


@pytest.mark.parametrize(("longer", "has_note"), [(0.0, False), (1e-4, False), (2e-3, True), (-2e-3, True)])
def test_a_gas_of_another_rod_has_a_caution_with_the_travel_of_its_own(longer: float, has_note: bool) -> None:
    """The dead centre moves by the change of the rod's length, and with it zero_travel."""

    def gas(zero: float) -> list[str]:
        m = slider_crank(0.3)
        m.bodies["rod"] = replace(m.bodies["rod"], length=ROD + longer)
        m.guide_force(
            "gas", "guide", pressure=[8e5, 3e5, 1e5], travels=[-2 * CRANK, -CRANK, 0.0], bore="50 mm",
            reverse=True, zero_travel=zero,
        )  # fmt: skip
        return [text for text in m.check().notes if "another stroke or link" in text]

    place = ROD - CRANK
    wrong, right = gas(place + 2 * CRANK), gas(place + longer + 2 * CRANK)
    assert bool(wrong) == has_note and not right
    if has_note:
        assert f"zero_travel = '{1e3 * (place + longer + 2 * CRANK):.6g} mm'" in wrong[0]
