"""Rigid bodies in the plane under constraints, forces and contacts, integrated by DOP853. It shares nothing
with the package but SI units.

Places are complex numbers, a body's motion is (x, y, angle) of its centre of mass, body 0 is the ground. Of
each constraint three things are written down: what it keeps zero, its gradient, and what its second
derivative has beyond the gradient times the accelerations. Accelerations are those of Gauss' principle:
nearest to what the forces alone would give, in the metric of the masses, among those that the constraints
allow. A constraint more than needed changes nothing of that. Contacts begin and end at roots that the
integrator locates.
"""

from __future__ import annotations

import cmath
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from scipy.integrate import solve_ivp

Array = np.ndarray
Law = Callable[[float], tuple[float, float, float]]  # value, rate and second derivative over time
SMALLEST_SINGULAR = 1e-8  # of the largest: what is below is redundant
STEADY = 0.3  # of what it was at the start: below, a mechanism comes to where it locks or branches
FASTEST = 60.0  # m/s or rad/s


class Unfit(Exception):
    """The motion leads to where equations say nothing of how it goes on."""


def dot(a: complex, b: complex) -> float:
    return a.real * b.real + a.imag * b.imag


def fixed(value: float) -> Law:
    return lambda t: (value, 0.0, 0.0)


@dataclass
class Now:
    """Bodies at an instant: centres, angles, their rates."""

    q: Array
    v: Array

    def __post_init__(self) -> None:
        self.z = [complex(x, y) for x, y, _ in self.q.tolist()]
        self.turn = [cmath.rect(1.0, a) for a in self.q[:, 2].tolist()]
        self.u = [complex(x, y) for x, y, _ in self.v.tolist()]
        self.w = self.v[:, 2].tolist()

    def point(self, body: int, at: complex) -> tuple[complex, complex, complex, complex]:
        """Arm, place, velocity and what the acceleration is when the body's own is zero, of a point of a
        body.
        """
        arm = at * self.turn[body]
        return arm, self.z[body] + arm, self.u[body] + 1j * self.w[body] * arm, -(self.w[body] ** 2) * arm


Row = tuple[
    dict[int, tuple[float, float, float]], float, float
]  # gradient by body, the rate it must have, and the second derivative


@dataclass
class Pin:
    """Two points in one place."""

    name: str
    a: int
    at: complex
    b: int
    bt: complex

    def rows(self, s: Now, t: float) -> list[Row]:
        arm, _, _, bias = s.point(self.a, self.at)
        brm, _, _, bbias = s.point(self.b, self.bt)
        rows = []
        for n in (1.0 + 0.0j, 1.0j):
            rows.append(
                (
                    {
                        self.a: (-n.real, -n.imag, -dot(n, 1j * arm)),
                        self.b: (n.real, n.imag, dot(n, 1j * brm)),
                    },
                    0.0,
                    -dot(n, bbias - bias),
                )
            )
        return rows


@dataclass
class Guide:
    """How far a point of b is from a line through a point of a, or, with ``normal`` along the line, how far
    along it.
    """

    name: str
    a: int
    at: complex
    b: int
    bt: complex
    normal: complex  # in the frame of a
    law: Law = field(default_factory=lambda: fixed(0.0))

    def rows(self, s: Now, t: float) -> list[Row]:
        arm, p, u, bias = s.point(self.a, self.at)
        brm, q, v, bbias = s.point(self.b, self.bt)
        n, w, d = self.normal * s.turn[self.a], s.w[self.a], q - p
        on_a = (-n.real, -n.imag, -dot(n, 1j * arm) + dot(1j * n, d))
        on_b = (n.real, n.imag, dot(n, 1j * brm))
        beyond = dot(n, bbias - bias) + 2.0 * dot(1j * w * n, v - u) - w * w * dot(n, d)
        _, rate, second = self.law(t)
        return [({self.a: on_a, self.b: on_b}, rate, second - beyond)]


@dataclass
class Turn:
    """The angle of b less ``ratio`` times that of a."""

    name: str
    a: int
    b: int
    ratio: float = 1.0
    law: Law = field(default_factory=lambda: fixed(0.0))

    def rows(self, s: Now, t: float) -> list[Row]:
        _, rate, second = self.law(t)
        return [({self.a: (0.0, 0.0, -self.ratio), self.b: (0.0, 0.0, 1.0)}, rate, second)]


@dataclass
class Touch:
    """A round of radius ``r`` on b at ``bt`` that meets a bearing around it, a round beside it or a straight
    line of a.

    Lankarani and Nikravesh's force, and a friction that grows from v0 to v1, at a point in the middle of the
    overlap.
    """

    name: str
    kind: str  # bearing, round or line
    a: int
    at: complex
    b: int
    bt: complex
    r: float
    other: float  # radius of the bearing or of the other round
    stiffness: float
    restitution: float
    friction: tuple[float, float, float]  # coefficient, v0, v1
    normal: complex = 0.0j  # into the material of a line, in the frame of a
    speed: float = 0.0  # at which the contact began; none where it has not

    def seen(self, s: Now) -> tuple[float, complex, float]:
        """Depth, the direction in which the journal goes in, and the rate."""
        _, p, u, _ = s.point(self.a, self.at)
        _, q, v, _ = s.point(self.b, self.bt)
        d = q - p
        if self.kind == "line":
            n = self.normal * s.turn[self.a]
            depth, rate = dot(n, d) + self.r, dot(n, v - u) + dot(1j * s.w[self.a] * n, d)
            return depth, n, rate
        e = abs(d)
        sign = 1.0 if self.kind == "bearing" else -1.0
        n = sign * d / (e or 1.0)
        return (
            sign * e - (self.other - self.r if self.kind == "bearing" else -self.other - self.r),
            n,
            dot(n, v - u),
        )

    def force(self, s: Now) -> tuple[complex, complex, float]:
        """Force on the journal's body, where it acts, and its normal part."""
        depth, n, rate = self.seen(s)
        _, q, _, _ = s.point(self.b, self.bt)
        where = q + n * (self.r - 0.5 * depth)
        if self.speed <= 0.0 or depth <= 0.0:
            return 0.0j, where, 0.0
        push = max(
            self.stiffness * depth**1.5 * (1.0 + 0.75 * (1.0 - self.restitution**2) * rate / self.speed), 0.0
        )
        t = 1j * n
        slip = dot(
            t,
            s.u[self.b]
            + 1j * s.w[self.b] * (where - s.z[self.b])
            - s.u[self.a]
            - 1j * s.w[self.a] * (where - s.z[self.a]),
        )
        coefficient, v0, v1 = self.friction
        share = min(max((abs(slip) - v0) / (v1 - v0), 0.0), 1.0)
        return -push * n - math.copysign(coefficient * share * push, slip) * t, where, push


Force = Callable[[float, Now, Array], None]  # adds to the forces (bodies, 3)


@dataclass
class System:
    """Bodies and what acts on them; the first is the ground."""

    mass: list[tuple[float, float]] = field(default_factory=lambda: [(1.0, 1.0)])
    q: list[tuple[float, float, float]] = field(default_factory=lambda: [(0.0, 0.0, 0.0)])
    constraints: list[Any] = field(default_factory=list)
    forces: list[Force] = field(default_factory=list)
    touches: list[Touch] = field(default_factory=list)
    breaks: list[float] = field(default_factory=list)  # times at which a law of motion is less smooth
    longest: float = 5e-4  # s of a step where something may touch
    regular: float = 0.0  # smallest singular value of what is not redundant, at the start

    @property
    def root(self) -> Array:
        """Square roots of the masses of the free coordinates."""
        return np.sqrt(np.array([(m, m, j) for m, j in self.mass[1:]])).ravel()

    def gradient(self, s: Now, t: float) -> tuple[Array, Array, Array, list[str]]:
        """Rows over the free coordinates, the rates and second derivatives that they must have, and whose
        they are.
        """
        rows, rate, second, whose = [], [], [], []
        for one in self.constraints:
            for by_body, first, then in one.rows(s, t):
                row = [0.0] * (3 * len(self.mass))
                for body, (x, y, turn) in by_body.items():
                    row[3 * body] += x
                    row[3 * body + 1] += y
                    row[3 * body + 2] += turn
                rows.append(row[3:])
                rate.append(first)
                second.append(then)
                whose.append(one.name)
        return np.array(rows).reshape(-1, 3 * (len(self.mass) - 1)), np.array(rate), np.array(second), whose

    def moved(self, t: float, q: Array, v: Array, root: Array) -> tuple[Array, Array, Array, list[str], Now]:
        """What ``root`` makes of the accelerations, its part that the constraints give, their scaled
        gradient, and whose its rows are.
        """
        s = self._now(np.concatenate([q.ravel(), v.ravel()]), len(q))
        force = np.zeros((len(self.mass), 3))
        for one in self.forces:
            one(t, s, force)
        for touch in self.touches:
            f, where, _ = touch.force(s)
            pushed(force, s, touch.b, where, f)
            pushed(force, s, touch.a, where, -f)
        g, _, second, whose = self.gradient(s, t)
        free = force[1:].ravel() / root
        if not len(g):
            return free, np.zeros_like(free), g, whose, s
        scaled = g / root
        held, _, rank, sizes = np.linalg.lstsq(scaled, second - scaled @ free, rcond=SMALLEST_SINGULAR)
        self.regular = self.regular or float(sizes[rank - 1])
        if sizes[rank - 1] < STEADY * self.regular or np.abs(v).max() > FASTEST:
            raise Unfit
        return free + held, held, scaled, whose, s

    def solved(self, t: float, q: Array, v: Array) -> tuple[Array, Array, dict[str, Array], Now]:
        """Accelerations, the forces of the constraints on the free coordinates, and the multipliers of each
        constraint.
        """
        root = self.root
        moved, held, scaled, whose, s = self.moved(t, q, v, root)
        multipliers = np.linalg.lstsq(scaled.T, held, rcond=SMALLEST_SINGULAR)[0] if whose else ()
        found: dict[str, list[float]] = {}
        for name, value in zip(whose, multipliers, strict=True):
            found.setdefault(name, []).append(float(value))
        return (
            (moved / root).reshape(-1, 3),
            (held * root).reshape(-1, 3),
            {k: np.array(x) for k, x in found.items()},
            s,
        )

    def projected(self, v: Array, t: float = 0.0) -> Array:
        """The velocities nearest to ``v``, in the metric of the masses, that the constraints allow."""
        s = Now(np.array(self.q), np.vstack([np.zeros(3), v]))
        root, (g, rate, _, _) = self.root, self.gradient(s, t)
        wish = v.ravel() * root
        if len(g):
            wish = wish + np.linalg.lstsq(g / root, rate - (g / root) @ wish, rcond=SMALLEST_SINGULAR)[0]
        return (wish / root).reshape(-1, 3)

    def freedom(self) -> tuple[int, int]:
        """Degrees of freedom and redundant rows at the start."""
        g = self.gradient(Now(np.array(self.q), np.zeros((len(self.q), 3))), 0.0)[0]
        rank = int(np.linalg.matrix_rank(g / self.root, tol=1e-7)) if len(g) else 0
        return 3 * (len(self.q) - 1) - rank, len(g) - rank

    def advance(self, v: Array, times: Sequence[float], tight: float = 1e-10) -> list[tuple[Array, Array]]:
        """Positions and velocities of the free bodies at the times, from the start with velocities ``v``."""
        n, t = len(self.mass) - 1, 0.0
        y = np.concatenate([np.array(self.q)[1:].ravel(), v.ravel()])
        longest = self.longest if self.touches else np.inf  # a longer one could pass over a contact
        stops = sorted({*times, *(b for b in self.breaks if b < max(times))})
        found, root = {}, self.root

        def rates(t: float, y: Array) -> Array:
            return np.concatenate(
                [
                    y[3 * n :],
                    self.moved(t, y[: 3 * n].reshape(-1, 3), y[3 * n :].reshape(-1, 3), root)[0] / root,
                ]
            )

        def crossing(touch: Touch) -> Callable[[float, Array], float]:
            def depth(t: float, y: Array) -> float:
                return touch.seen(self._now(y, n))[0]

            depth.terminal, depth.direction = True, -1.0 if touch.speed > 0.0 else 1.0  # type: ignore[attr-defined]
            return depth

        for stop in stops:
            while t < stop:
                events = [crossing(touch) for touch in self.touches]
                done = solve_ivp(
                    rates,
                    (t, stop),
                    y,
                    method="DOP853",
                    rtol=tight,
                    atol=tight,
                    events=events or None,
                    max_step=longest,
                )
                t, y = float(done.t[-1]), done.y[:, -1]
                for touch, hits in zip(self.touches, done.t_events or (), strict=True):
                    if len(hits):
                        touch.speed = 0.0 if touch.speed > 0.0 else max(touch.seen(self._now(y, n))[2], 1e-3)
            found[stop] = y[: 3 * n].reshape(-1, 3).copy(), y[3 * n :].reshape(-1, 3).copy()
        return [found[one] for one in times]

    @staticmethod
    def _now(y: Array, n: int) -> Now:
        whole = np.zeros((2, n + 1, 3))
        whole[:, 1:] = y.reshape(2, n, 3)
        return Now(*whole)


def pushed(force: Array, s: Now, body: int, where: complex, f: complex) -> None:
    """Adds a force at a place to the forces on a body."""
    arm = where - s.z[body]
    force[body] += f.real, f.imag, arm.real * f.imag - arm.imag * f.real


def weight(masses: Sequence[tuple[float, float]], g: complex) -> Force:
    def add(t: float, s: Now, force: Array) -> None:
        for body in range(1, len(masses)):
            force[body] += masses[body][0] * g.real, masses[body][0] * g.imag, 0.0

    return add


def spring(a: int, at: complex, b: int, bt: complex, stiffness: float, damping: float, free: float) -> Force:
    def add(t: float, s: Now, force: Array) -> None:
        (_, p, u, _), (_, q, v, _) = s.point(a, at), s.point(b, bt)
        length = abs(q - p)
        e = (q - p) / length
        f = (stiffness * (length - free) + damping * dot(e, v - u)) * e
        pushed(force, s, a, p, f)
        pushed(force, s, b, q, -f)

    return add


def coil(a: int, b: int, stiffness: float, damping: float, free: float) -> Force:
    def add(t: float, s: Now, force: Array) -> None:
        m = -stiffness * (s.q[b, 2] - s.q[a, 2] - free) - damping * (s.w[b] - s.w[a])
        force[b, 2] += m
        force[a, 2] -= m

    return add


def rubber(
    a: int,
    at: complex,
    b: int,
    bt: complex,
    stiffness: Sequence[float],
    damping: Sequence[float],
    free: float,
) -> Force:
    """Stiff along and across the axes of a, about the free angle; the force acts where the pin of b is."""

    def add(t: float, s: Now, force: Array) -> None:
        (_, p, u, _), (_, q, v, _) = s.point(a, at), s.point(b, bt)
        frame, d = s.turn[a], q - p
        apart = d * frame.conjugate()
        rate = (v - u - 1j * s.w[a] * d) * frame.conjugate()
        f = (
            -complex(
                stiffness[0] * apart.real + damping[0] * rate.real,
                stiffness[1] * apart.imag + damping[1] * rate.imag,
            )
            * frame
        )
        pushed(force, s, b, q, f)
        pushed(force, s, a, q, -f)
        m = -stiffness[2] * (s.q[b, 2] - s.q[a, 2] - free) - damping[2] * (s.w[b] - s.w[a])
        force[b, 2] += m
        force[a, 2] -= m

    return add


def load(body: int, at: complex, f: complex, moment: float, follow: bool) -> Force:
    def add(t: float, s: Now, force: Array) -> None:
        pushed(force, s, body, s.point(body, at)[1], f * s.turn[body] if follow else f)
        force[body, 2] += moment

    return add


def motor(body: int, stall: float, fastest: float) -> Force:
    """A torque that falls in a line from rest to a fastest speed, and stays as it is beyond either."""

    def add(t: float, s: Now, force: Array) -> None:
        force[body, 2] += stall * (1.0 - min(max(s.w[body] / fastest, 0.0), 1.0))

    return add
