"""Local influence parameters of the four-bar over its settled turn (Eq. 38-39), for many clearances, speeds
and parameters at once.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache

import numpy as np

from vfife.measures.catalogue import lip
from vfife.solvers.ensemble import EnsembleCase, advance, ensemble, placed

from .mechanisms import FASTEST, Parameters, four_bar

STEP = 1e-6  # s
MOST_TURNS = 12
TOLERANCE = 1e-3  # of the largest value of each quantity, between two turns that count as the same
IDEAL_STEPS = 7200  # steps in a turn of the ideal mechanism
JOINT, BODY = "C", "follower"  # the paper's joint 2, and its follower


@dataclass(frozen=True)
class Case:
    """One simulation: parameters, clearance (m), crank speed (rad/s), step (s), the joints that are loose."""

    parameters: Parameters
    clearance: float
    speed: float = FASTEST
    step: float = STEP
    loose: str = "BCD"


@dataclass(frozen=True)
class Influence:
    """What a settled turn gives: maxima of the force of joint 2 (N) and of the follower's acceleration
    (rad/s^2), those of the ideal mechanism.
    """

    case: Case
    run: EnsembleCase
    force: float
    acceleration: float
    ideal_force: float
    ideal_acceleration: float

    @property
    def lips(self) -> tuple[float, float]:
        """LIP(F) and LIP(a) in per cent."""
        return lip(self.force, self.ideal_force), lip(self.acceleration, self.ideal_acceleration)

    @property
    def keeps_contact(self) -> bool:
        """Whether no joint lost contact in the last turn: every one in contact at its outputs, and no contact
        began.
        """
        last = self.run.last
        onsets = last.block("contact_onsets")
        return bool((onsets[-1] == onsets[0]).all() and (last.block("contact_penetration") > 0.0).all())


def influences(
    cases: Sequence[Case],
    *,
    outputs: int = 720,
    turns: int = MOST_TURNS,
    progress: Callable[[int, int], None] | None = None,
) -> list[Influence]:
    """Run every case until its turns repeat, or for ``turns`` turns."""
    assemblies = [
        placed(four_bar(c.parameters, c.clearance, c.speed, c.loose), c.step, turns, outputs) for c in cases
    ]
    runs = advance(assemblies, tolerance=TOLERANCE, progress=progress)
    return [measured(case, run) for case, run in zip(cases, runs, strict=True)]


def measured(case: Case, run: EnsembleCase) -> Influence:
    """Maxima over the last turn, beside the ideal ones."""
    force, acceleration = maxima(run)
    ideal_force, ideal_acceleration = ideal_maxima(case.parameters.link, case.parameters.below, case.speed)
    return Influence(case, run, force, acceleration, ideal_force, ideal_acceleration)


def maxima(run: EnsembleCase) -> tuple[float, float]:
    """Largest force in joint 2 (N) and acceleration of the follower (rad/s^2) in the last turn."""
    a, turns = run.assembly, run.turns
    kind, names = ("contact", a.contacts) if JOINT in a.contacts else ("joint", a.ideals)
    squared = turns.block(f"{kind}_force_squared_max")[-1, names.index(JOINT)]
    return math.sqrt(squared), float(turns.block("body_alpha_max")[-1, a.bodies[BODY].row])


@cache
def ideal(link: str, is_below: bool, speed: float, outputs: int = 720) -> EnsembleCase:
    """Run a turn of the ideal mechanism, whose links are rigid with their lumped masses."""
    mechanism = four_bar(Parameters(link=link, below=is_below), 1e-4, speed).ideal()
    return ensemble([mechanism], step=2.0 * np.pi / speed / IDEAL_STEPS, turns=1, outputs=outputs)[0]


@cache
def ideal_maxima(link: str, is_below: bool, speed: float) -> tuple[float, float]:
    """Largest force of joint 2 (N) and acceleration of the follower (rad/s^2) with ideal joints."""
    return maxima(ideal(link, is_below, speed))
