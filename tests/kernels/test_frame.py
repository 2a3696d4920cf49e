"""The plane frame element: rigid motion, stiffness, releases, equilibrium and path units, against matrix
structural analysis.
"""

import itertools
import math

import numpy as np
import pytest

from support import EPS
from vfife.compiler.trace.tables import tables
from vfife.kernels import step as loop
from vfife.kernels.arrays import HEADER
from vfife.kernels.topology import Topology

LENGTH, EA, EI = 0.7, 2.07e8, 1.7e4
RELEASED = {"none": 0, "start": 1, "end": 2, "both": 3}


class Element:
    """One element between two particles, stepped by the data-driven loop's own function, run
    as plain Python.
    """

    def __init__(
        self,
        release: str = "none",
        path_unit: int = 1,
        ends=((0.3, -0.2), (0.3 + LENGTH, -0.2)),
        theta=(0.0, 0.0),
    ) -> None:
        topology = Topology(
            particles=3,
            free=(1, 2),
            frame_nodes=((1, 2),),
            frame_release=(RELEASED[release],),
            path_unit=path_unit,
        )
        integers, self.layout, rows = tables(topology)
        self.I = [int(value) for value in integers]
        self.S = np.zeros(rows)
        self.path_unit, self.taken = path_unit, 0
        chord = np.subtract(ends[1], ends[0])
        length = math.hypot(*chord)
        for name, value in {
            "reference_length": length, "reference_inverse_length": 1.0 / length,
            "reference_cosine": chord[0] / length, "reference_sine": chord[1] / length,
            "reference_theta_1": theta[0], "reference_theta_2": theta[1],
            "frame_axial_stiffness": EA, "frame_bending_stiffness": EI,
        }.items():  # fmt: skip
            self.S[self.layout[name]] = value

    def force(self, first, second) -> np.ndarray:
        """Forces and moments (6) of the element on its particles, put to (x, y, theta) each;
        one step more.
        """
        for axis, values in zip(("x", "y", "theta"), zip(first, second, strict=True), strict=True):
            self.S[self.layout[f"particle_{axis}"][1:]] = values
        for name in ("fx", "fy", "mz"):
            self.S[self.layout[name]] = 0.0
        loop.elements(
            self.S, self.I, self.I[HEADER.frame], self.I[HEADER.frame_end], self.taken % self.path_unit == 0
        )
        self.taken += 1
        return np.array([self.S[self.layout[name]][node] for node in (1, 2) for name in ("fx", "fy", "mz")])

    def inside(self) -> np.ndarray:
        """Axial force and end moments."""
        return np.array(
            [self.S[self.layout[f"frame_{name}"]][0] for name in ("axial_force", "moment_1", "moment_2")]
        )


def moved(points, turn: float, shift) -> list[tuple[float, float, float]]:
    """Points (x, y, theta) turned about the origin and shifted."""
    c, s = math.cos(turn), math.sin(turn)
    return [(c * x - s * y + shift[0], s * x + c * y + shift[1], theta + turn) for x, y, theta in points]


def beam_matrix(release: str) -> np.ndarray:
    """Textbook stiffness of a plane frame member along x; released rotations condensed out (Schur
    complement).
    """
    l, k = LENGTH, np.zeros((6, 6))
    k[np.ix_([0, 3], [0, 3])] = EA / l * np.array([[1, -1], [-1, 1]])
    k[np.ix_([1, 2, 4, 5], [1, 2, 4, 5])] = (
        EI
        / l**3
        * np.array(
            [
                [12, 6 * l, -12, 6 * l],
                [6 * l, 4 * l * l, -6 * l, 2 * l * l],
                [-12, -6 * l, 12, -6 * l],
                [6 * l, 2 * l * l, -6 * l, 4 * l * l],
            ]
        )
    )
    out = [5 - 3 * (name == "start") for name in ("start", "end") if release in (name, "both")]
    for row in out:
        k = k - np.outer(k[:, row], k[row]) / k[row, row] if k[row, row] else k
    return k


@pytest.mark.parametrize("release", RELEASED)
@pytest.mark.parametrize("angle", [0.0, 0.9, -2.4])
def test_small_deformation_gives_the_beam_matrix(release, angle):
    """Every column, in any direction, to the second order that the difference of two opposite displacements
    leaves.
    """
    c, s = math.cos(angle), math.sin(angle)
    turn = np.kron(np.eye(2), [[c, s, 0], [-s, c, 0], [0, 0, 1]])
    expected = turn.T @ beam_matrix(release) @ turn
    small = 1e-6
    found = np.zeros((6, 6))
    for column in range(6):
        for sign in (1.0, -1.0):
            ends = ((0.1, 0.2), (0.1 + LENGTH * c, 0.2 + LENGTH * s))
            place = np.array([*ends[0], angle, *ends[1], angle])
            place[column] += sign * small
            found[:, column] -= (
                sign
                * Element(release, ends=ends, theta=(angle, angle)).force(place[:3], place[3:])
                / (2 * small)
            )
    assert found == pytest.approx(expected, rel=2e-9, abs=2e-9 * EA / LENGTH)


def test_a_cantilever_released_at_its_tip_bends_with_three_ei_over_l():
    """An end rotation theta against a pin: 3EI/l theta, and 3EI/l^2 theta across (not Eq. 12b with a zero
    struck in).
    """
    theta = 1e-3
    force = Element("start", ends=((0, 0), (LENGTH, 0))).force((0, 0, 0), (LENGTH, 0, theta))
    assert force[5] == pytest.approx(-3 * EI / LENGTH * theta, rel=1e-12)
    assert force[1] == pytest.approx(-3 * EI / LENGTH**2 * theta, rel=1e-12)
    assert force[2] == 0.0


@pytest.mark.parametrize(("release", "path_unit"), list(itertools.product(RELEASED, (1, 5))))
def test_a_rigid_motion_however_large_makes_no_force(release, path_unit):
    """Three turns and a hundred metres in 4000 steps; a path unit of five turns by 0.024 rad. What is left is
    rounding.
    """
    e = Element(release, path_unit)
    start = [(0.3, -0.2, 0.0), (0.3 + LENGTH, -0.2, 0.0)]
    for share in np.linspace(0.0, 1.0, 4001):
        force = e.force(*moved(start, 6 * math.pi * share, (100 * share, -30 * share**2)))
    axial, *moments = np.abs(e.inside() / [EA, EI / LENGTH, EI / LENGTH])
    assert (
        axial < 130 * EPS / LENGTH
    )  # a place at 100 m is rounded so; increments of length add up to the length there is
    assert max(moments) < 1e-12  # what the series of a unit's turn leaves out, 4000 times
    assert np.abs(force[:2]).max() < EA * 260 * EPS / LENGTH


@pytest.mark.parametrize("path_unit", [1, 4])
def test_a_stressed_element_keeps_its_forces_while_it_turns(path_unit):
    """The forces turn with the element: two and a half turns, then a quarter against the start."""
    e = Element(path_unit=path_unit, ends=((0.0, 0.0), (LENGTH, 0.0)))
    bent = [(0.0, 0.0, 2e-4), (LENGTH * (1 + 3e-5), 1e-5, -1e-4)]
    first = e.force(*bent)
    for _ in range(path_unit):
        before = e.force(*bent)
    assert before == pytest.approx(first, rel=1e-12) and abs(before[0]) > 1e3 and abs(before[2]) > 1.0
    for share in np.linspace(0.0, 1.0, 3001):
        after = e.force(*moved(bent, 5.25 * math.pi * share, (share, 2 * share)))
    c, s = math.cos(5.25 * math.pi), math.sin(5.25 * math.pi)
    turn = np.kron(np.eye(2), [[c, -s, 0], [s, c, 0], [0, 0, 1]])
    assert after == pytest.approx(turn @ before, rel=0, abs=1e-11 * np.abs(before).max())


@pytest.mark.parametrize("release", RELEASED)
def test_nodal_forces_are_in_equilibrium(release):
    """Force and moment about any point add up to nothing, deformed as much as one likes."""
    rng = np.random.default_rng(11)
    e = Element(release, ends=((0.0, 0.0), (LENGTH, 0.0)))
    first, second = np.zeros(3), np.array([LENGTH, 0.0, 0.0])
    for _ in range(200):
        first = first + rng.normal(0, 3e-3, 3)
        second = second + rng.normal(0, 3e-3, 3)
        f = e.force(first, second)
        size = np.abs(f).max()
        assert size > 1e4
        assert f[0] + f[3] == 0.0 and f[1] + f[4] == 0.0
        moment = f[2] + f[5] + first[0] * f[1] - first[1] * f[0] + second[0] * f[4] - second[1] * f[3]
        assert abs(moment) < 1e-14 * size
        released = {"none": (), "start": (2,), "end": (5,), "both": (2, 5)}[release]
        assert all(f[k] == 0.0 for k in released)


def stretched(units: int, path_unit: int) -> float:
    """Axial force of an element stretched by a half, evenly over so many path units."""
    e = Element("both", path_unit, ends=((0.0, 0.0), (LENGTH, 0.0)))
    for share in np.linspace(0.0, 1.0, units * path_unit + 1):
        e.force((0.0, 0.0, 0.0), (LENGTH * (1.0 + 0.5 * share), 0.0, 0.0))
    return e.inside()[0]


def test_a_large_stretch_adds_up_to_the_logarithmic_strain():
    """Increments EA dl/l over path units: EA ln(l1/l0), with a first-order error of EA/2 (1/l0 - 1/l1) times
    the length of a unit.
    """
    exact = EA * math.log(1.5)
    for units in (50, 100, 200):
        error = stretched(units, 1) - exact
        assert error == pytest.approx(EA / 2 * (1 - 1 / 1.5) * 0.5 / units, rel=0.02)


def test_the_length_of_a_path_unit_counts_not_its_steps():
    assert stretched(50, 4) == pytest.approx(stretched(50, 1), rel=1e-12)
    assert abs(stretched(200, 1) / stretched(50, 4) - 1) > 1e-3


def test_within_a_path_unit_the_force_depends_on_the_position_alone():
    """Out and back inside one unit of many steps: the force returns to the bit. Over units of one step half
    the sum of (dl/l)^2 is left.
    """
    place = [LENGTH * (1 + 1e-3 * math.sin(0.1 * k)) for k in range(63)]
    held, renewed = (
        Element("both", 1000, ends=((0.0, 0.0), (LENGTH, 0.0))),
        Element("both", 1, ends=((0.0, 0.0), (LENGTH, 0.0))),
    )
    for e in (held, renewed):
        for x in [*place, LENGTH]:
            e.force((0.0, 0.0, 0.0), (x, 0.0, 0.0))
    assert held.inside()[0] == 0.0
    lengths = np.array([LENGTH, *place, LENGTH])
    assert renewed.inside()[0] == pytest.approx(
        EA / 2 * ((np.diff(lengths) / lengths[:-1]) ** 2).sum(), rel=1e-2
    )
