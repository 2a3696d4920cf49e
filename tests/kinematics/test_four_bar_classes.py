"""Grashof's classes, checked by turning the links, and the sentences of the check."""

import math
import random

import pytest

from vfife.kinematics.initial import ideal_motion
from vfife.kinematics.mobility import classified, grashof
from vfife.model.mechanism import Mechanism
from vfife.report.freedom import freedom_words


@pytest.mark.parametrize(
    ("lengths", "said"),
    [
        ((0.15, 0.40, 0.26, 0.46), "double crank"),
        ((0.40, 0.10, 0.35, 0.30), "crank-rocker"),
        ((0.40, 0.30, 0.35, 0.10), "crank-rocker"),
        ((0.40, 0.30, 0.10, 0.35), "double rocker"),
        ((0.60, 0.30, 0.20, 0.35), "triple rocker"),
        ((0.30, 0.20, 0.30, 0.20), "parallelogram"),
        ((0.30, 0.30, 0.20, 0.20), "deltoid"),
        ((0.40, 0.10, 0.35, 0.15), "change-point"),
    ],
)
def test_classes(lengths, said):
    assert said in classified(*lengths)
    assert classified(*(1e3 * length for length in lengths)) == classified(*lengths)


def test_a_class_says_which_grounded_links_turn_fully():
    """A grounded link turns fully if the gap between its tip and the other foot stays within what the other
    two can reach.
    """
    assembled = 0
    for seed in range(200):
        draw = random.Random(seed)
        ground, first, coupler, second = (draw.uniform(0.1, 1.0) for _ in range(4))
        if 2.0 * max(ground, first, coupler, second) > ground + first + coupler + second:
            continue  # it cannot be assembled
        pairs = ((first, second), (second, first))
        turns = [
            abs(coupler - other) < abs(ground - link) and ground + link < coupler + other
            for link, other in pairs
        ]
        name = classified(ground, first, coupler, second).split(" (")[0].split(",")[0]
        assert sum(turns) == {"double crank": 2, "crank-rocker": 1}.get(name, 0), f"seed {seed}"
        assembled += 1
    assert assembled > 100


def four_bar(ground, first, coupler, second):
    m = Mechanism("four-bar")
    m.point("A", 0.0, 0.0)
    m.point("D", ground, 0.0)
    m.link("crank", length=first, mass=1.0)
    m.link("coupler", length=coupler, mass=1.0)
    m.link("follower", length=second, mass=1.0)
    m.revolute("A", "ground.A", "crank.start")
    m.revolute("B", "coupler.start", "crank.end")
    m.clearance_joint("C", "coupler.end", "follower.end", clearance=1e-4, bearing_radius=0.01)
    m.revolute("D", "follower.start", "ground.D")
    return m


def test_a_four_bar_is_found_with_its_lengths():
    assert (
        grashof(four_bar(0.15, 0.4, 0.26, 0.46))
        == "double crank (drag link), a Grashof four-bar: ground 150 mm, crank 400 mm, coupler 260 mm,"
        " follower 460 mm"
    )
    m = four_bar(0.15, 0.4, 0.26, 0.46)
    del m.joints["C"]
    assert grashof(m) is None


def test_the_check_tells_a_change_point():
    flat = ideal_motion(four_bar(0.3, 0.2, 0.3, 0.2)).mobility
    said = " ".join(freedom_words({**vars(flat), "four_bar": "parallelogram", "shared": []}))
    assert "singular position" in said
    assert flat.singular
    m = four_bar(0.3, 0.2, 0.3, 0.2)
    for name in ("crank", "follower"):
        object.__setattr__(m.bodies[name], "angle", math.radians(40.0))
    away = ideal_motion(m).mobility
    assert away.singular == ()
    assert "singular" not in " ".join(freedom_words({**vars(away), "four_bar": None, "shared": []}))
