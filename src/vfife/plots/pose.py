"""A pose of a mechanism that shows every body, where its start hides one behind another."""

from __future__ import annotations

import numpy as np

from ..assembly.assemble import assemble
from ..assembly.possible import outlook
from ..errors import VfifeError
from ..kinematics.start import StartState
from ..model.mechanism import Mechanism
from ..results.run_data import RunData, standing
from .drawing import least_visible, outlines_of, shows_every_body

SHOWN = 3  # every third position of the turn that a check follows is a pose to choose from: each 30 degrees


def clear_pose(mechanism: Mechanism) -> tuple[RunData, str]:
    """Return the view of a mechanism in a pose that shows every body, and the words for this pose.

    It is the start if no body hides most of another there, as the rod hides the crank at a dead centre, or if
    no turn of the crank is known; otherwise the pose of that turn in which the body that is seen least is
    seen best. Raises AssemblyError.
    """
    start = standing(assemble(mechanism))
    if shows_every_body(start):
        return start, "at the start"
    best = max((*_poses_of_a_turn(mechanism), start), key=lambda view: least_visible(outlines_of(view), 0))
    angles, start_angles = best.crank_angle, start.crank_angle
    if best is start or angles is None or start_angles is None:
        return start, "at the start"
    angle, start_angle = round(float(angles[0])) % 360, round(float(start_angles[0])) % 360
    return best, f"with {best.crank} at {angle}° (the start at {start_angle}° hides a body)"


def _poses_of_a_turn(mechanism: Mechanism) -> list[RunData]:
    """Return poses of a turn of the ideal mechanism; none where no turn is known."""
    try:
        ideal = outlook(mechanism)
    except VfifeError:  # it jams: the start can still be drawn
        return []
    if ideal.turn is None or ideal.motion is None:
        return []
    # A turn is solved for the mirror image where the mechanism has the other hand.
    positions = ideal.turn.positions * np.array([1.0, ideal.motion.hand, ideal.motion.hand])
    bodies = frozenset(mechanism.bodies)
    states = [StartState(position, np.zeros_like(position), bodies) for position in positions[SHOWN:-1:SHOWN]]
    return [standing(assemble(mechanism, start_state=state)) for state in states]
