"""Mechanisms of uniform rods, closed and driven, for the tests of what moves them."""

from dataclasses import replace

import numpy as np

from rigid import Drive, Pin
from vfife.kinematics.solve import RigidSystem, close

GRAVITY = 9.81


def rods(names, lengths, masses, joints, drives=()):
    """Uniform rods along their own x axis; ends of a joint are given as (body, fraction of half length) or a
    point.
    """
    half = [0.0, *(0.5 * length for length in lengths)]

    def end(body, at):
        return at if body == 0 else (at * half[body], 0.0)

    pins = [
        Pin(name, a, np.array(end(a, at_a)), b, np.array(end(b, at_b))) for name, a, at_a, b, at_b in joints
    ]
    mass = np.array([0.0, *masses])
    inertia = np.array([0.0, *(m * length**2 / 12.0 for m, length in zip(masses, lengths, strict=True))])
    return RigidSystem(("ground", *names), mass, inertia, pins, drives)


def along(*points):
    """Row of a rod from its end points: centre and angle."""
    start, end = np.array(points[0]), np.array(points[1])
    return [*(0.5 * (start + end)), np.arctan2(*(end - start)[::-1])]


def four_bar(ground=0.150, crank=0.400, coupler=0.260, follower=0.460, drives=()):
    return rods(
        ("crank", "coupler", "follower"),
        (crank, coupler, follower),
        (3.120, 2.028, 3.588),
        (
            ("A", 0, (0.0, 0.0), 1, -1.0),
            ("B", 1, 1.0, 2, -1.0),
            ("C", 2, 1.0, 3, 1.0),
            ("D", 3, -1.0, 0, (ground, 0.0)),
        ),
        drives,
    )


def driven(system, angle, speed=0.0, acceleration=0.0, body=1):
    return replace(system, drives=(Drive(body, angle, speed, acceleration),))


def rough_guess(side=1.0):
    b, c, d = (0.4, 0.0), (0.55, side * 0.22), (0.15, 0.0)
    return np.array([[0.0, 0.0, 0.0], along((0.0, 0.0), b), along(b, c), along(d, c)])


def at_angle(angle, side=1.0):
    """Closed drag-link four-bar at a crank angle, its branch followed from crank angle 0 in small steps."""
    position = rough_guess(side)
    for step in np.linspace(0.0, angle, max(2, int(abs(angle) / 0.1) + 2)):
        position = close(driven(four_bar(), step), position).position
    return position


def double_crank(bars=3):
    """Parallel cranks 0.2 m long from (x, 0) carrying one coupler; all cranks at 1.1 rad."""
    feet, angle = (0.0, 0.3, 0.5)[:bars], 1.1
    tip = 0.2 * np.array([np.cos(angle), np.sin(angle)])
    joints = []
    for k, x in enumerate(feet, start=1):
        joints.append((f"A{k}", 0, (x, 0.0), k, -1.0))
        joints.append((f"B{k}", k, 1.0, bars + 1, (x - 0.25) / 0.25))
    names = (*(f"crank {k + 1}" for k in range(bars)), "coupler")
    system = rods(names, (0.2,) * bars + (0.5,), (*(1.0, 1.5, 0.7)[:bars], 2.0), joints)
    rows = [along((x, 0.0), (x + tip[0], tip[1])) for x in feet]
    return system, np.array([[0.0, 0.0, 0.0], *rows, along(tip, (tip[0] + 0.5, tip[1]))]), angle


def weight(system):
    force = np.zeros((len(system.names), 3))
    force[1:, 1] = -GRAVITY * system.mass[1:]
    return force
