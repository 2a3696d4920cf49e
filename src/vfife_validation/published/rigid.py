"""The slider-crank with a loose guide as rigid bodies with rigid contacts, by a program of its own.

Moreau's time stepping: velocities and impulses of a step solve M (u - v) = h f + W p with Newton's law of
impact W u + e W v >= 0 and Coulomb's friction at each of the four corners that touch, by projected
Gauss-Seidel. Coordinates are the angles of crank, rod and block. It shares nothing with vfife.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
CRANK, ROD = 0.153, 0.306  # m
CRANK_MASS, ROD_MASS, BLOCK_MASS = 0.038, 0.038, 0.076  # kg
CRANK_INERTIA, ROD_INERTIA, BLOCK_INERTIA = 7.4e-5, 5.9e-4, 2.7e-6  # kg m2, about centres of mass
HALF_LENGTH, HALF_HEIGHT, CLEARANCE = 0.05, 0.025, 0.001  # m
G, RESTITUTION, FRICTION = 9.81, 0.4, 0.01
START = (150.0, -75.0, 0.0)  # rad/s
COUPLED = (0.5 * ROD_MASS + BLOCK_MASS) * CRANK * ROD
OF_CRANK = CRANK_INERTIA + (0.25 * CRANK_MASS + ROD_MASS + BLOCK_MASS) * CRANK**2
OF_ROD = ROD_INERTIA + (0.25 * ROD_MASS + BLOCK_MASS) * ROD**2
TOLERANCE, SWEEPS = 1e-13, 200  # N s; of Gauss-Seidel
PASSES = 4  # of a step without contacts


def energy(angles: Array, rates: Array) -> Array:
    """Return kinetic and potential energy (J) for angles (rad) and rates (rad/s) of shape (times, 3)."""
    a, b, (u, v, w) = angles[:, 0], angles[:, 1], rates.T
    kinetic = (
        0.5 * (OF_CRANK * u * u + OF_ROD * v * v + BLOCK_INERTIA * w * w) + COUPLED * np.cos(b - a) * u * v
    )
    height = (0.5 * CRANK_MASS + ROD_MASS + BLOCK_MASS) * CRANK * np.sin(a)
    return np.asarray(kinetic + G * (height + (0.5 * ROD_MASS + BLOCK_MASS) * ROD * np.sin(b)))


def inverse_mass(a: float, b: float) -> Array:
    """Return the inverse of the mass matrix for the angles (rad) of crank and rod."""
    c = COUPLED * math.cos(b - a)
    determinant = OF_CRANK * OF_ROD - c * c
    result = np.zeros((3, 3))
    result[:2, :2] = np.array([[OF_ROD, -c], [-c, OF_CRANK]]) / determinant
    result[2, 2] = 1.0 / BLOCK_INERTIA
    return result


def force(a: float, b: float, rates: Array) -> Array:
    """Return generalised forces (N m) of inertia and weight."""
    s, (u, v, _) = COUPLED * math.sin(a - b), rates
    weight = (0.5 * CRANK_MASS + ROD_MASS + BLOCK_MASS) * G * CRANK * math.cos(a)
    return np.array(
        [-s * v * v - weight, s * u * u - (0.5 * ROD_MASS + BLOCK_MASS) * G * ROD * math.cos(b), 0.0]
    )


def contacts(q: Array) -> list[tuple[Array, Array]]:
    """Return the directions of normal and tangent of the corners that touch a wall, as rows of W."""
    a, b, c = q.tolist()
    y = CRANK * math.sin(a) + ROD * math.sin(b)
    across = np.array([CRANK * math.cos(a), ROD * math.cos(b), 0.0])
    tangents = np.array([-CRANK * math.sin(a), -ROD * math.sin(b), 0.0])
    rows = []
    for side in (1.0, -1.0):
        for end in (-HALF_LENGTH, HALF_LENGTH):
            rise = end * math.sin(c) + side * HALF_HEIGHT * math.cos(c)
            reach = end * math.cos(c) - side * HALF_HEIGHT * math.sin(c)
            if HALF_HEIGHT + CLEARANCE - side * (y + rise) <= 0.0:
                turn = np.array([0.0, 0.0, 1.0])
                rows.append((-side * (across + reach * turn), tangents - rise * turn))
    return rows


def impulses(mobility: Array, rows: list[tuple[Array, Array]], former: Array, free: Array) -> Array:
    """Return the rates (rad/s) after a step in which corners touch."""
    rates = free.copy()
    pushes, rubs = [0.0] * len(rows), [0.0] * len(rows)
    for _ in range(SWEEPS):
        change = 0.0
        for k, (normal, tangent) in enumerate(rows):
            across, sliding = mobility @ normal, mobility @ tangent
            impulse = pushes[k] - (normal @ rates + RESTITUTION * (normal @ former)) / (normal @ across)
            push = max(0.0, float(impulse))
            rates += across * (push - pushes[k])
            change, pushes[k] = max(change, abs(push - pushes[k])), push
            limit = FRICTION * push
            rub = min(max(rubs[k] - float(tangent @ rates) / float(tangent @ sliding), -limit), limit)
            rates += sliding * (rub - rubs[k])
            rubs[k] = rub
        if change < TOLERANCE:
            break
    return rates


def flight(angles: Array, rates: Array, step: float, place: float) -> tuple[Array, Array]:
    """Return the inverse of the mass matrix and the rates (rad/s) after a step without contacts.

    Forces are means of both ends of the step. The mass matrix is that of ``place``, 0.5 for the middle of
    the step and 1 for its end; only the middle keeps the energy to second order.
    """
    former_force, next_rates = force(float(angles[0]), float(angles[1]), rates), rates
    for _ in range(PASSES):
        change = 0.5 * step * (rates + next_rates)
        a, b = (angles + place * change)[:2].tolist()
        mobility = inverse_mass(a, b)
        a, b = (angles + change)[:2].tolist()
        next_rates = rates + 0.5 * step * mobility @ (former_force + force(a, b, next_rates))
    return mobility, next_rates


def motion(duration: float, step: float, place: float = 0.5) -> tuple[Array, Array, Array]:
    """Return times (s), angles (rad) and rates (rad/s), the latter two of shape (times, 3)."""
    angles, rates = np.zeros(3), np.array(START)
    count = round(duration / step)
    all_angles, all_rates = np.zeros((count + 1, 3)), np.zeros((count + 1, 3))
    all_rates[0] = rates
    for k in range(count):
        mobility, free = flight(angles, rates, step, place)
        rows = contacts(angles + 0.5 * step * rates)
        next_rates = impulses(mobility, rows, rates, free) if rows else free
        angles, rates = angles + 0.5 * step * (rates + next_rates), next_rates
        all_angles[k + 1], all_rates[k + 1] = angles, rates
    times: Array = np.asarray(step * np.arange(count + 1), dtype=np.float64)
    return times, all_angles, all_rates
