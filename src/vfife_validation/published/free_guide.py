"""The slider-crank of Flores, Leine and Glocker (2010): a free crank, a block with clearance in its guide."""

from __future__ import annotations

import math
from collections.abc import Mapping
from functools import cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

import vfife
from vfife import gallery
from vfife.modelfile.parameter import with_values
from vfife.report.document import Table

from ..paper.contents import Chart, Item, Line, Panel, Parameter, Verdict
from . import rigid

Array = NDArray[np.float64]
BODIES = ("crank", "rod", "block")
SPAN, STEP, STEP_OF_SICONOS = 0.2, 5e-5, 1e-4  # s; of the program for rigid contacts
END = 1.0  # place of the mass matrix within a step of Siconos
TURN = 2.0 * math.pi
# Numbers of the reference files of the Siconos examples, with direct and with combined projection, steps of
# 0.1 ms: time (s), turns of the crank, total energy (J) of the angles and rates there.
SICONOS = (
    (0.0, (0.0, 0.0), (7.496, 7.496)),
    (0.05, (0.77043, 0.77041), (7.674, 7.669)),
    (0.10, (1.49164, 1.49087), (7.978, 7.960)),
    (0.15, (2.23201, 2.23084), (8.279, 8.253)),
    (0.20, (3.05433, 3.04972), (8.593, 8.540)),
)
# Energy (J) that the steps with and without impulses of the same files add.
IMPULSIVE, FREE = (-0.414, -0.211), (1.511, 1.256)
# One step without impulses of the file with direct projection, from 0.1990 s on: turns of the crank, angle of
# the rod (rad), rates (rad/s), at both ends.
BEGIN = (3.033936661311471, -0.1084435855345397, 138.1298868395437, -66.37469990780977)
FINISH = (3.036118183026361, -0.1150136814191145, 136.0082168863396, -65.0272177836997)
VARIANTS: dict[str, tuple[str, tuple[float, ...], str]] = {
    "restitution": ("joint.guide.contact.restitution", (0.2, 0.6), "1"),
    "friction": ("joint.guide.friction.coefficient", (0.001, 0.02), "1"),
    "clearance": ("joint.guide.clearance", (0.0005, 0.002), "m"),
    "modulus of the walls, which are rigid there": ("material.wall.youngs_modulus", (20.7e9, 2070e9), "Pa"),
}


class Motion(NamedTuple):
    """Times (s), angles (rad) and rates (rad/s) of crank, rod and block, the latter of shape (times, 3)."""

    times: Array
    angles: Array
    rates: Array

    @property
    def turns(self) -> Array:
        """Turns of the crank."""
        return self.angles[:, 0] / TURN

    def time_of(self, turns: float) -> float:
        """Return the time (s) at which the crank has made so many turns."""
        return float(np.interp(turns, self.turns, self.times))

    @property
    def energy(self) -> Array:
        """Kinetic and potential energy (J)."""
        return rigid.energy(self.angles, self.rates)


def simulate(changes: Mapping[str, float] | None = None, ideal: bool = False) -> Motion:
    """Run the model, with numbers at some paths, or with an ideal guide."""
    model = with_values(gallery.slider_crank_free(), dict(changes or {}))
    if ideal:
        model = model.ideal()
    result = vfife.simulate(model, companions=0)
    angles, rates = (
        np.stack([np.asarray(result.series[f"{body}.{quantity}"]) for body in BODIES], axis=1)
        for quantity in ("angle", "angular_velocity")
    )
    return Motion(np.asarray(result.time), angles, rates)


@cache
def rigid_motion(step: float = STEP, place: float = 0.5) -> Motion:
    """Compute the motion with rigid contacts by Moreau's time stepping; ``place`` of the mass matrix in a
    step.
    """
    return Motion(*rigid.motion(SPAN, step, place))


def flight_error(place: float) -> float:
    """Return the error of the crank's rate (1) after the step of Siconos, over the change of this rate, with
    the mass matrix of a ``place`` in the step.
    """
    (turns, rod, *first), (_, _, *last) = BEGIN, FINISH
    angles, rates = np.array([TURN * turns, rod, 0.0]), np.array([*first, 0.0])
    _, next_rates = rigid.flight(angles, rates, STEP_OF_SICONOS, place)
    return abs(float(next_rates[0]) - last[0]) / abs(last[0] - first[0])


def verdicts(ours: Motion, rigid_bodies: Motion, ideal: Motion) -> list[Verdict]:
    """Judge the motion against the published numbers and against rigid contacts."""
    turns, lower, upper = float(ours.turns[-1]), min(SICONOS[-1][1]), max(SICONOS[-1][1])
    deviations = [abs(ours.time_of(k) / rigid_bodies.time_of(k) - 1.0) for k in (1, 2)]
    ends, rigid_ends = (
        " and ".join(f"{1e3 * motion.time_of(k):.2f}" for k in (1, 2)) for motion in (ours, rigid_bodies)
    )
    change = turns / float(ideal.turns[-1]) - 1.0
    return [
        Verdict(
            "clearance influences the dynamic response (abstract): turns in 0.2 s change by more than 1 %",
            abs(change) > 0.01,
            f"{turns:.3f} turns with clearance, {ideal.turns[-1]:.3f} without: {100 * change:+.1f} %",
        ),
        Verdict(
            "the crank makes 3.05 turns in 0.2 s, as in the reference files of Siconos, within 1 %",
            bool(0.99 * lower <= turns <= 1.01 * upper),
            f"{turns:.3f} turns here, {lower:.3f} to {upper:.3f} there",
        ),
        Verdict(
            "a separate time-stepping program with rigid contacts has our motion within 0.1 %",
            max(deviations) <= 1e-3, f"turns end at {ends} ms, with rigid contacts at {rigid_ends} ms",
        ),
        *energy_verdicts(ours),
    ]  # fmt: skip


def energy_verdicts(ours: Motion) -> list[Verdict]:
    """Judge whether energy only falls, and what raises it in the reference files of Siconos."""
    gain = [100.0 * (energy / SICONOS[0][2][k] - 1.0) for k, energy in enumerate(SICONOS[-1][2])]
    first, last = ours.energy[[0, -1]].tolist()
    copies = {step: rigid_motion(step, END) for step in (STEP_OF_SICONOS, STEP)}
    copy, finer = copies[STEP_OF_SICONOS], copies[STEP]
    turns = sum(SICONOS[-1][1]) / 2.0
    middle, end = flight_error(0.5), flight_error(END)
    return [
        Verdict(
            "contacts with restitution 0.4 and friction dissipate energy, in the reference files of"
            " Siconos too",
            max(IMPULSIVE) < 0.0,
            f"there steps with impulses dissipate {-IMPULSIVE[0]} J (direct projection) and {-IMPULSIVE[1]} J"
            f" (combined); here {first:.3f} J become {last:.3f} J",
        ),
        Verdict(
            "without impulses the energy stays, in the reference files of Siconos too",
            max(FREE) < 0.01 * first,
            f"there steps without impulses add {FREE[0]} and {FREE[1]} J, in the end {min(gain):.1f} to"
            f" {max(gain):.1f} %",
        ),
        Verdict(
            "their motion has the mass matrix of the end of each step, and this adds the energy",
            abs(copy.turns[-1] / turns - 1.0) < 0.01 and end < 0.1 * middle,
            f"our time stepping with it and their step makes {copy.turns[-1]:.3f} turns and ends with"
            f" {copy.energy[-1]:.2f} J (there {SICONOS[-1][2][1]:.2f}, {SICONOS[-1][2][0]:.2f} J), with half"
            f" the step {finer.turns[-1]:.3f} turns and {finer.energy[-1]:.2f} J; one of their steps without"
            f" impulses is reproduced within {100 * end:.2f} % of its change, with the mass matrix of the"
            f" middle within {100 * middle:.1f} %",
        ),
    ]


def height(motion: Motion) -> Array:
    """Return the height of the block's centre above the middle line, over the clearance."""
    y = rigid.CRANK * np.sin(motion.angles[:, 0]) + rigid.ROD * np.sin(motion.angles[:, 1])
    return np.asarray(y / rigid.CLEARANCE)


def influence(ours: Motion) -> Table:
    """How much each number changes the turns within 0.2 s."""
    rows = []
    for name, (path, values, unit) in VARIANTS.items():
        for value in values:
            turns = float(simulate({path: value}).turns[-1])
            rows.append((name, f"{value:g} {unit if unit != '1' else ''}".strip(), f"{turns:.3f}",
                         f"{100.0 * (turns / float(ours.turns[-1]) - 1.0):+.2f} %"))  # fmt: skip
    return Table(
        ("number", "value", "turns in 0.2 s", "change"),
        rows,
        title="How much each number matters",
        numbers=(2, 3),
    )


def chart(ours: Motion, rigid_bodies: Motion) -> Chart:
    """Energy and speed of the crank."""
    times = np.array([time for time, _, _ in SICONOS])
    energies = np.array([max(energy) for _, _, energy in SICONOS])
    early = ours.times <= 0.05
    beginning = rigid_bodies.times <= 0.05
    return Chart(
        "published_guide", "Energy of the mechanism, and height of the block in its guide at the beginning",
        [
            Panel("energy", "time (ms)", "energy (J)", [
                Line(1e3 * ours.times, ours.energy, "vfife"),
                Line(1e3 * rigid_bodies.times, rigid_bodies.energy, "rigid contacts", "second"),
                Line(1e3 * times, energies, "Siconos, projection", "paper", True),
            ]),
            Panel("block between its walls", "time (ms)", "height over clearance", [
                Line(1e3 * ours.times[early], height(ours)[early], "vfife"),
                Line(1e3 * rigid_bodies.times[beginning], height(rigid_bodies)[beginning],
                     "rigid contacts", "second"),
            ]),
        ], 2,
    )  # fmt: skip


def item() -> Item:
    """Report the motion of 0.2 s beside the numbers of Siconos and rigid contacts."""
    ours, rigid_bodies = simulate(), rigid_motion()
    text = (
        "Flores, Leine, Glocker: Multibody System Dynamics 23 (2010) 165, doi 10.1007/s11044-009-9178-y. We"
        " could read the abstract, but not figures and results. Table 1 and two motions of this mechanism"
        " are from the Siconos project (siconos-tutorials, examples/mechanics/SliderCrank).",
        "No motor drives the crank; it starts with 150 rad/s, the rod with -75 rad/s. In the motions of"
        " Siconos the energy grows while no corner touches, most near every whole turn, where the mass matrix"
        " changes fastest. Moving corners back (the projection) changes the energy by less than 0.04 J.",
    )
    parameters = [
        Parameter(
            "lengths, masses, inertias, clearance 1 mm",
            "as in the model file",
            "stated",
            "Table 1, by Siconos",
        ),
        Parameter("restitution 0.4, friction 0.01", "hertz, gonthier-exact; coulomb", "stated", "by Siconos"),
        Parameter("walls", "steel, corners of 0.1 mm radius", "chosen", "contacts are rigid there"),
    ]
    data = {"turns": float(ours.turns[-1]), "rigid_turns": float(rigid_bodies.turns[-1])}
    return Item(
        "loose-guide", "Flores, Leine, Glocker 2010: a block with clearance in its guide", text, parameters,
        [chart(ours, rigid_bodies)], [influence(ours)],
        verdicts(ours, rigid_bodies, simulate(ideal=True)), data,
    )  # fmt: skip
