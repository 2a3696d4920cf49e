"""The four-bar of the paper by a program of another kind: rigid bars, RK4 with onsets located by bisection,
laws from the equations in print.

It shares nothing with the package but the set's numbers. Eq. 26-27 (enhanced law, mm and MPa), Eq. 32-33
(friction at the centres), Table 1.
"""

import math

import numba
import numpy as np

GROUND, CRANK, COUPLER, FOLLOWER = 0.150, 0.400, 0.260, 0.460  # m
M2, M3 = 2.028, 3.588  # kg
CRANK_SPEED = 50 * math.pi


@numba.njit
def joints(t, angle, s):
    """Eccentricity and its rate at the three joints, shape (3, 4): x, y, u, v."""
    e = np.zeros((3, 4))
    phi = angle + CRANK_SPEED * t
    cb, sb = CRANK * math.cos(phi), CRANK * math.sin(phi)
    c2, s2, c3, s3 = (
        0.5 * COUPLER * math.cos(s[2]),
        0.5 * COUPLER * math.sin(s[2]),
        0.5 * FOLLOWER * math.cos(s[5]),
        0.5 * FOLLOWER * math.sin(s[5]),
    )
    w2, w3 = s[8], s[11]
    e[0, 0], e[0, 1], e[0, 2], e[0, 3] = (
        s[0] - c2 - cb,
        s[1] - s2 - sb,
        s[6] + w2 * s2 + CRANK_SPEED * sb,
        s[7] - w2 * c2 - CRANK_SPEED * cb,
    )
    e[1, 0], e[1, 1], e[1, 2], e[1, 3] = (
        s[3] + c3 - s[0] - c2,
        s[4] + s3 - s[1] - s2,
        s[9] - w3 * s3 - s[6] + w2 * s2,
        s[10] + w3 * c3 - s[7] - w2 * c2,
    )
    e[2, 0], e[2, 1], e[2, 2], e[2, 3] = s[3] - c3 - GROUND, s[4] - s3, s[9] + w3 * s3, s[10] - w3 * c3
    return e


@numba.njit
def forces(e, slowness, p):
    """Force on each journal, shape (3, 2)."""
    clearance, stiffness, n, chi, friction, v0, v1 = p
    f = np.zeros((3, 2))
    for j in range(3):
        size = math.hypot(e[j, 0], e[j, 1])
        depth = size - clearance
        if slowness[j] > 0.0 and depth > 0.0:
            nx, ny = e[j, 0] / size, e[j, 1] / size
            rate, slide = e[j, 2] * nx + e[j, 3] * ny, e[j, 3] * nx - e[j, 2] * ny
            normal = max(0.0, stiffness * depth**n * (1.0 + chi * rate * slowness[j]))
            share = min(1.0, max(0.0, (abs(slide) - v0) / (v1 - v0)))
            tangential = -friction * share * normal * np.sign(slide)
            f[j, 0], f[j, 1] = -normal * nx - tangential * ny, -normal * ny + tangential * nx
    return f


@numba.njit
def rate_of(t, angle, s, slowness, p):
    """Time derivative of the state: centres and angles of coupler and follower, then their velocities."""
    f = forces(joints(t, angle, s), slowness, p)
    d = np.zeros(12)
    for k in range(6):
        d[k] = s[6 + k]
    c2, s2, c3, s3 = (
        0.5 * COUPLER * math.cos(s[2]),
        0.5 * COUPLER * math.sin(s[2]),
        0.5 * FOLLOWER * math.cos(s[5]),
        0.5 * FOLLOWER * math.sin(s[5]),
    )
    i2, i3 = M2 * COUPLER**2 / 4.0, M3 * FOLLOWER**2 / 4.0  # half of the mass at each end
    d[6], d[7] = (f[0, 0] - f[1, 0]) / M2, (f[0, 1] - f[1, 1]) / M2
    d[8] = (-c2 * (f[0, 1] + f[1, 1]) + s2 * (f[0, 0] + f[1, 0])) / i2
    d[9], d[10] = (f[1, 0] + f[2, 0]) / M3, (f[1, 1] + f[2, 1]) / M3
    d[11] = (c3 * (f[1, 1] - f[2, 1]) - s3 * (f[1, 0] - f[2, 0])) / i3
    return d


@numba.njit
def moved(s, h, d):
    """s + h d, number by number, which compiles in a tenth of the time of a sum of arrays."""
    to = np.empty(12)
    for k in range(12):
        to[k] = s[k] + h * d[k]
    return to


@numba.njit
def rk4(t, h, angle, s, slowness, p):
    a = rate_of(t, angle, s, slowness, p)
    b = rate_of(t + 0.5 * h, angle, moved(s, 0.5 * h, a), slowness, p)
    c = rate_of(t + 0.5 * h, angle, moved(s, 0.5 * h, b), slowness, p)
    d = rate_of(t + h, angle, moved(s, h, c), slowness, p)
    return moved(moved(moved(moved(s, h / 6.0, a), h / 3.0, b), h / 3.0, c), h / 6.0, d)


@numba.njit
def landed(t, angle, s, slowness, p):
    """The joint without contact that lies deepest in its wall, or -1."""
    e, deepest, which = joints(t, angle, s), 0.0, -1
    for j in range(3):
        depth = math.hypot(e[j, 0], e[j, 1]) - p[0]
        if slowness[j] == 0.0 and depth > deepest:
            deepest, which = depth, j
    return which


@numba.njit
def turns_of(count, steps, angle, s, p):
    """Largest force of joint 2 and acceleration of the follower in each turn."""
    h, slowness, largest = 2.0 * math.pi / CRANK_SPEED / steps, np.zeros(3), np.zeros((count, 2))
    for k in range(count * steps):
        t, end = k * h, (k + 1) * h
        while end - t > 1e-15:
            left = end - t
            after = rk4(t, left, angle, s, slowness, p)
            if landed(end, angle, after, slowness, p) >= 0:  # bisection for the first landing
                low, high = 0.0, left
                for _ in range(60):
                    middle = 0.5 * (low + high)
                    inside = (
                        landed(t + middle, angle, rk4(t, middle, angle, s, slowness, p), slowness, p) >= 0
                    )
                    low, high = (low, middle) if inside else (middle, high)
                left, after = high, rk4(t, high, angle, s, slowness, p)
                j = landed(t + left, angle, after, slowness, p)
                e = joints(t + left, angle, after)[j]
                slowness[j] = 1.0 / max(1e-3, (e[0] * e[2] + e[1] * e[3]) / math.hypot(e[0], e[1]))
            t, s = t + left, after
            e = joints(t, angle, s)
            for j in range(3):
                if math.hypot(e[j, 0], e[j, 1]) < p[0] - 1e-13:
                    slowness[j] = 0.0
        f = forces(joints(end, angle, s), slowness, p)[1]
        row = largest[k // steps]
        row[0] = max(row[0], math.hypot(f[0], f[1]))
        row[1] = max(row[1], abs(rate_of(end, angle, s, slowness, p)[11]))
    return largest


def start(angle, below):
    """Closed positions and ideal velocities, journals centred: circles of coupler and follower intersected,
    then two linear equations.
    """
    b = CRANK * np.array([math.cos(angle), math.sin(angle)])
    pivot = np.array([GROUND, 0.0])
    apart = np.linalg.norm(pivot - b)
    bend = math.acos((COUPLER**2 + apart**2 - FOLLOWER**2) / (2 * COUPLER * apart))
    toward = math.atan2(pivot[1] - b[1], pivot[0] - b[0])
    theta = toward + (bend if below else -bend)
    c = b + COUPLER * np.array([math.cos(theta), math.sin(theta)])
    phi = math.atan2(c[1], c[0] - GROUND)
    across = [
        length * np.array([-math.sin(a), math.cos(a)]) for length, a in ((COUPLER, theta), (FOLLOWER, phi))
    ]
    moving = CRANK_SPEED * np.array([-b[1], b[0]])
    w2, w3 = np.linalg.solve(np.column_stack([across[0], -across[1]]), -moving)
    v2, v3 = moving + 0.5 * w2 * across[0], 0.5 * w3 * across[1]
    return np.array([*(0.5 * (b + c)), theta, *(0.5 * (pivot + c)), phi, *v2, w2, *v3, w3])


def law(p, clearance):
    """Clearance (m), stiffness (N/m^n), n, damping factor, friction and its two speeds, from Eq. 26-28 in mm
    and MPa.
    """
    gap = 1e3 * clearance
    y = 1.51 * math.log(1000 * gap) ** -0.151 if gap < 0.34954 else 0.0151 * gap + 1.151
    n = y * gap**-0.005
    modulus = 207e3 / (2 * (1 - 0.3**2))  # MPa
    stiffness = (0.965 * gap + 0.0965) * 1e3 * p.axial_length * modulus / gap * 10 ** (3 * n)
    return clearance, stiffness, n, 0.75 * (1 - p.contact.restitution**2), p.friction, p.v0, p.v1
