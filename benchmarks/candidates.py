"""Which script of which other program runs at which step, and what right means: found by a scan, November
2026.

MuJoCo's semi-implicit Euler is cheaper at equal accuracy than its RK4, Exudyn's velocity Verlet than its RK44
and its midpoint rule. Case c has a near-grazing impact, and whether a step takes it to the right branch is
partly chance: on GRID a program may be right at every step and on a finer one not. Exudyn's Verlet is wrong
at 5e-7 and 4e-7 s (4.1, 4.0 %) and is credited with one right step all the same. FINE of case c has 116 steps
up to 5 us, and 48 up to 12.5 us; STRICT is MuJoCo's largest from which on all of them are right. So it is
wrong at 2.78 us in case b (1.1 %), though right at 3.2 us; case a is smooth, and its 280 steps a turn are
right with all finer ones. Exudyn's quickest there take 4.1 ms and more.
"""

from __future__ import annotations

from dataclasses import dataclass

TOLERANCE = {"a": 0.01, "b": 0.01, "c": 0.02}
# Largest follower acceleration (rad/s^2) and force of joint 2 (N) in the second turn. b, c:
# peers/reference.py (RK4,
# located onsets, 3.2 million steps; an independent event-located integration agrees to 5e-7 in the force of
# c);
# impacts at joints 1, 2, 3: 0, 5, 0 and 4, 7, 5. a: the closed form of peers/common.py.
REFERENCE = {"a": (22816.05, 65338.09), "b": (29201.05, 65794.78), "c": (38153.31, 68842.16)}
CONTACT = (
    1.6e-5,
    1.25e-5,
    1e-5,
    8e-6,
    5e-6,
    4e-6,
    3.2e-6,
    2.5e-6,
    2e-6,
    1.6e-6,
    1.25e-6,
    1e-6,
    8e-7,
    5e-7,
    4e-7,
)
GRID = {
    "a": (8e-4, 5e-4, 4e-4, 3.2e-4, 2.5e-4, 2e-4, 1.6e-4, 1.25e-4, 1e-4, 5e-5, 2e-5, 1e-5),
    "b": CONTACT,
    "c": CONTACT,
}
FINE = {
    "a": tuple(0.04 / n for n in (*range(100, 400, 10), *range(400, 4001, 100))),
    "b": tuple(0.04 / n for n in (*range(2400, 8000, 100), *range(8000, 100_001, 1600))),
    "c": tuple(0.04 / n for n in (*range(3200, 8000, 100), *range(8000, 100_001, 800))),
}


@dataclass(frozen=True)
class Candidate:
    """A script at a step (s; SciPy: relative tolerance); ``decides``: whether the ratio counts it."""

    name: str
    script: str
    step: float
    arguments: tuple[str, ...]
    decides: bool = True

    @property
    def command(self) -> tuple[str, ...]:
        """Arguments of the script, the case apart."""
        return (*self.arguments, "--dt", repr(self.step))


def mujoco(step: float, route: str) -> Candidate:
    """MuJoCo, the contact law as a compiled callback, the ideal joint as an equality constraint."""
    return Candidate("mujoco", "mujoco_peer.py", step, ("--route", route, "--integ", "Euler"))


def exudyn(step: float, route: str) -> Candidate:
    """Exudyn, its native contact of a sphere in a hollow sphere; the ideal case by its implicit solver."""
    return Candidate("exudyn", "exudyn_peer.py", step, ("--route", route))


def scipy(rtol: float) -> Candidate:
    """SciPy's DOP853 with events and a right-hand side compiled by numba."""
    return Candidate("scipy", "scipy_user.py", rtol, ("--route", "numba"), decides=False)


CANDIDATES = {
    "a": (mujoco(1.25e-4, "connect"), exudyn(4e-4, "implicit"), scipy(1e-5)),
    "b": (mujoco(3.2e-6, "cfunc"), exudyn(1.6e-6, "verlet"), scipy(1e-6)),
    "c": (mujoco(1.25e-6, "cfunc"), exudyn(8e-7, "verlet"), scipy(1e-8)),
}
STRICT = {"a": mujoco(0.04 / 280, "connect"), "b": mujoco(2.5e-6, "cfunc"), "c": mujoco(5e-7, "cfunc")}
