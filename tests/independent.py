"""Calculations that share nothing with the package: circles, Lagrange's equations, a chain of springs,
impacts as events.
"""

import math
from collections.abc import Callable

import numpy as np
from scipy.integrate import solve_ivp


def circles(p: np.ndarray, r: float, q: np.ndarray, s: float, side: float) -> np.ndarray:
    """Intersection of the circles of radius r about p and s about q, to the left (1) or right (-1) of the way
    from p to q.
    """
    along = q - p
    distance = math.hypot(*along)
    x = (distance**2 + r**2 - s**2) / (2.0 * distance)
    u = along / distance
    return p + x * u + side * math.sqrt(r**2 - x**2) * np.array([-u[1], u[0]])


def jansen_foot(angle: float) -> np.ndarray:
    """Foot of Jansen's leg in the unit of the eleven numbers."""
    crank, frame = 15.0 * np.array([math.cos(angle), math.sin(angle)]), np.array([-38.0, -7.8])
    top = circles(crank, 50.0, frame, 41.5, -1.0)
    knee = circles(crank, 61.9, frame, 39.3, 1.0)
    back = circles(frame, 40.1, top, 55.8, 1.0)
    heel = circles(back, 39.4, knee, 36.7, -1.0)
    return circles(heel, 65.7, knee, 49.0, -1.0)


def double_pendulum(
    lengths: tuple[float, float], masses: tuple[float, float], angles: tuple[float, float], until: float
) -> np.ndarray:
    """Angles from the horizontal of two uniform rods let go at rest, after a time."""
    (a, b), (m, n), g = lengths, masses, 9.81

    def rates(t: float, y: np.ndarray) -> list[float]:
        p, q, u, v = y
        off = 0.5 * n * a * b
        matrix = [
            [m * a * a / 3.0 + n * a * a, off * math.cos(p - q)],
            [off * math.cos(p - q), n * b * b / 3.0],
        ]
        right = [
            -off * math.sin(p - q) * v * v - (0.5 * m + n) * g * a * math.cos(p),
            off * math.sin(p - q) * u * u - 0.5 * n * g * b * math.cos(q),
        ]
        return [u, v, *np.linalg.solve(matrix, right)]

    return solve_ivp(rates, (0.0, until), [*angles, 0.0, 0.0], method="DOP853", rtol=1e-11, atol=1e-12).y[
        :2, -1
    ]


def chain_of_springs(pieces: int, until: float) -> np.ndarray:
    """End (m) of a hinged rubber rod let go from the horizontal: masses at the nodes, springs along the
    pieces and against their bending.
    """
    length, diameter, e, density = 1.2, 0.04, 0.7e6, 1100.0
    area, second = math.pi * diameter**2 / 4.0, math.pi * diameter**4 / 64.0
    h = length / pieces
    mass = np.full(pieces + 1, density * area * h)
    mass[-1] *= 0.5

    def rates(t: float, y: np.ndarray) -> np.ndarray:
        x = y[: 2 * pieces + 2].reshape(-1, 2)
        v = y[2 * pieces + 2 :].reshape(-1, 2)
        edge = np.diff(x, axis=0)
        size = np.hypot(*edge.T)
        t1 = edge / size[:, None]
        pull = (e * area * (size / h - 1.0))[:, None] * t1
        turn = np.arctan2(t1[:-1, 0] * t1[1:, 1] - t1[:-1, 1] * t1[1:, 0], (t1[:-1] * t1[1:]).sum(axis=1))
        moment = e * second / h * turn
        across = np.stack([-t1[:, 1], t1[:, 0]], axis=1) / size[:, None]
        force = np.zeros_like(x)
        force[:-1] += pull
        force[1:] -= pull
        # The moment at a node turns the piece before it one way and the piece after it the other.
        couple = np.zeros(pieces)
        couple[:-1] += moment
        couple[1:] -= moment
        force[1:] += couple[:, None] * across
        force[:-1] -= couple[:, None] * across
        rate = force / mass[:, None] + np.array([0.0, -9.81])
        rate[0] = 0.0
        return np.concatenate([v.ravel(), rate.ravel()])

    start = np.zeros((2, pieces + 1, 2))
    start[0, :, 0] = np.linspace(0.0, length, pieces + 1)
    return solve_ivp(rates, (0.0, until), start.ravel(), method="DOP853", rtol=1e-7, atol=1e-9).y[
        2 * pieces : 2 * pieces + 2, -1
    ]


def contact(radius: float, modulus: float = 207e9, poisson: float = 0.3) -> float:
    """Hertz' stiffness (N/m^1.5) of two surfaces of one material and their relative radius (m)."""
    return 4.0 / 3.0 * modulus / (2.0 * (1.0 - poisson**2)) * math.sqrt(radius)


def integrate_impacts(
    motion: Callable, start: list[float], until: float, contacts: int, stiffness: float, restitution: float
) -> float:
    """Largest force of contacts after Lankarani and Nikravesh, each onset and each parting located.

    ``motion(t, q, force)`` gives the rates and asks ``force(k, depth, rate)`` for the force of contact k.
    """
    touching, speeds, seen = [False] * contacts, [1.0] * contacts, [(0.0, 0.0)] * contacts
    largest = 0.0

    def force(k: int, depth: float, rate: float) -> float:
        seen[k] = depth, rate
        if not touching[k] or depth <= 0.0:
            return 0.0
        return max(stiffness * depth**1.5 * (1.0 + 0.75 * (1.0 - restitution**2) * rate / speeds[k]), 0.0)

    def crossing(k: int) -> Callable:
        def event(t: float, q: np.ndarray) -> float:
            motion(t, q, force)
            return seen[k][0]

        event.terminal, event.direction = True, -1.0 if touching[k] else 1.0
        return event

    t, q = 0.0, np.array(start)
    while t < until:
        done = solve_ivp(
            lambda t, q: motion(t, q, force),
            (t, until),
            q,
            rtol=1e-8,
            atol=1e-12,
            max_step=2e-5,
            events=[crossing(k) for k in range(contacts)],
        )
        for at, state in zip(done.t, done.y.T, strict=True):
            motion(at, state, force)
            largest = max([largest, *(force(k, *seen[k]) for k in range(contacts))])
        t, q = done.t[-1], done.y[:, -1]
        motion(t, q, force)
        for k, (depth, rate) in enumerate(seen):
            together = (
                not touching[k] and abs(depth) < 1e-12 and rate > 0.0
            )  # only one of several at the same time is told
            if len(done.t_events[k]) or together:
                touching[k] = not touching[k]
                speeds[k] = max(rate, 1e-3)
    return largest
