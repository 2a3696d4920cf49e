"""Independent integration of pinned rigid bodies: Lagrange's equations of the first kind, by an explicit
Runge-Kutta of order 8.

Shares no code with the kernels: constraints by their Jacobian, [M G^T; G 0][a; l] = [F; -dG/dt v], to a
relative tolerance of 1e-12.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Forces = Callable[[float, Array, Array], Array]


@dataclass(frozen=True)
class Pin:
    """Point ``p`` (m, from the centre of mass) of body ``a`` on point ``q`` of body ``b``; -1 is the
    ground.
    """

    a: int
    p: tuple[float, float]
    b: int
    q: tuple[float, float]


def integrate(
    mass: Sequence[float],
    inertia: Sequence[float],
    pins: Sequence[Pin],
    forces: Forces,
    start: Array,
    speed: Array,
    times: Array,
) -> Array:
    """Positions and velocities at the times, shape (times, 2, bodies, 3), from a closed start."""
    from scipy.integrate import solve_ivp

    n = len(mass)
    weight = np.array([[m, m, i] for m, i in zip(mass, inertia, strict=True)]).ravel()

    def rates(time: float, state: Array) -> Array:
        q, v = state[: 3 * n].reshape(n, 3), state[3 * n :].reshape(n, 3)
        matrix = np.zeros((3 * n + 2 * len(pins),) * 2)
        matrix[: 3 * n, : 3 * n] = np.diag(weight)
        right = np.zeros(len(matrix))
        right[: 3 * n] = forces(time, q, v).ravel()
        for k, pin in enumerate(pins):
            row = 3 * n + 2 * k
            for body, (x, y), sign in ((pin.a, pin.p, 1.0), (pin.b, pin.q, -1.0)):
                if body < 0:
                    continue
                c, s = np.cos(q[body, 2]), np.sin(q[body, 2])
                rx, ry, w = c * x - s * y, s * x + c * y, v[body, 2]
                matrix[row : row + 2, 3 * body : 3 * body + 3] = sign * np.array(
                    [[1.0, 0.0, -ry], [0.0, 1.0, rx]]
                )
                right[row : row + 2] += sign * w * w * np.array([rx, ry])
        matrix[: 3 * n, 3 * n :] = matrix[3 * n :, : 3 * n].T
        return np.concatenate([state[3 * n :], np.linalg.solve(matrix, right)[: 3 * n]])

    solution = solve_ivp(
        rates,
        (0.0, float(times[-1])),
        np.concatenate([start.ravel(), speed.ravel()]),
        method="DOP853",
        t_eval=times,
        rtol=1e-12,
        atol=1e-13,
    )
    if not solution.success:
        raise RuntimeError(f"the independent integration failed: {solution.message}")
    return np.asarray(solution.y.T.reshape(len(times), 2, n, 3))


def solved(rates: Callable[[float, Array], Array], start: Sequence[float], times: Array) -> Array:
    """Solution of an ordinary differential equation at the times, shape (times, unknowns)."""
    from scipy.integrate import solve_ivp

    solution = solve_ivp(
        rates,
        (0.0, float(times[-1])),
        np.array(start, dtype=float),
        method="DOP853",
        t_eval=times,
        rtol=1e-12,
        atol=1e-14,
    )
    if not solution.success:
        raise RuntimeError(f"the independent integration failed: {solution.message}")
    return np.asarray(solution.y.T)
