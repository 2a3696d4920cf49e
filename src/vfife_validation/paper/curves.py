"""Curves of the last turn of a run over the crank angle: forces, accelerations, journal paths."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from vfife.measures import forces, motion
from vfife.solvers.ensemble import EnsembleCase
from vfife.solvers.record import Record

from .contents import Line, Panel, Style
from .influence import BODY, JOINT

Array = NDArray[np.float64]


def crank_angle(record: Record) -> tuple[Array, NDArray[np.intp]]:
    """Crank angle within a turn (degrees), -180 to 180, and the order of the outputs that it puts them in;
    the first output is left out.

    The largest accelerations and forces come near 0, so the turn is not cut there.
    """
    angle = np.degrees(record.block("particle_theta")[1:, record.assembly.topology.driven[0]])
    reduced = np.mod(angle + 180.0 + 1e-6, 360.0) - 180.0 - 1e-6
    order = np.argsort(reduced, kind="stable")
    return reduced[order], order + 1


def force(run: EnsembleCase, joint: str = JOINT) -> tuple[Array, Array]:
    """Crank angle (degrees) and the largest force (N) of a joint in each output interval."""
    angle, order = crank_angle(run.last)
    column = list(forces.joint_rows(run.last)).index(joint)
    return angle, forces.joint_force_max(run.last)[order, column]


def acceleration(run: EnsembleCase, body: str = BODY) -> tuple[Array, Array]:
    """Crank angle (degrees) and angular acceleration (rad/s^2) of a body."""
    angle, order = crank_angle(run.last)
    return angle, run.last.block("body_alpha")[order, run.assembly.bodies[body].row]


def velocity(run: EnsembleCase, body: str = BODY) -> tuple[Array, Array]:
    """Crank angle (degrees) and angular velocity (rad/s) of a body."""
    angle, order = crank_angle(run.last)
    return (
        angle,
        motion.body_motion(run.last)["angular_velocity"][order, list(run.assembly.bodies).index(body)],
    )


def penetration(run: EnsembleCase, joint: str = JOINT) -> tuple[Array, Array]:
    """Crank angle (degrees) and signed penetration (m) of a clearance joint."""
    angle, order = crank_angle(run.last)
    return angle, run.last.block("contact_penetration")[order, run.assembly.contacts.index(joint)]


def ripples(values: Array, floor: float = 0.01) -> int:
    """How often a curve of one turn turns round by more than ``floor`` of its largest absolute value: peaks
    and troughs together.
    """
    limit = floor * float(np.abs(values).max())
    count, direction, extreme = 0, 0.0, float(values[0])
    for value in values[1:]:
        step = float(value) - extreme
        if direction == 0.0:
            if abs(step) > limit:
                direction, extreme = math.copysign(1.0, step), float(value)
        elif step * direction >= 0.0:
            extreme = float(value)
        elif abs(step) > limit:
            count, direction, extreme = count + 1, -direction, float(value)
    return count


def path_panel(run: EnsembleCase, joint: str, title: str) -> Panel:
    """Plot the journal's path relative to its bearing over the last turn (mm), with the circle of the
    clearance.
    """
    record = run.last
    k = record.assembly.contacts.index(joint)
    clearance = record.assembly.mechanism.clearances[joint].clearance
    x, y = 1e3 * forces.eccentricity(record)[:, k].T
    turn = np.linspace(0.0, 2.0 * np.pi, 181)
    circle = Line(
        1e3 * clearance * np.cos(turn), 1e3 * clearance * np.sin(turn), "circle of radius c", "circle"
    )
    return Panel(title, "x (mm)", "y (mm)", [circle, Line(x, y, "journal centre, one turn")], equal=True)


def compared_with_ideal(
    curve: tuple[Array, Array], reference: tuple[Array, Array], factor: float, title: str, quantity: str
) -> Panel:
    """Plot a curve with clearance over the ideal curve."""
    lines = [
        Line(reference[0], factor * reference[1], "ideal joints", "ideal"),
        Line(curve[0], factor * curve[1], "with clearance", "main"),
    ]
    return Panel(title, "crank angle (degrees)", quantity, lines)


def over_angle(curve: tuple[Array, Array], factor: float, label: str, style: Style) -> Line:
    """Return a line over the crank angle."""
    return Line(curve[0], factor * curve[1], label, style)
