"""A pose of a mechanism that shows every body, where its start hides one behind another."""

from __future__ import annotations

from ..assembly.assemble import assemble
from ..errors import VfifeError
from ..kinematics.initial import ideal_motion
from ..kinematics.start import StartState
from ..model.functions import turn_of
from ..model.mechanism import Mechanism
from ..results.run_data import RunData, standing
from .drawing import least_visible, outlines_of, shows_every_body

PARTS = 36  # of a turn: larger ones can jump to another branch of the ideal motion
SHOWN = 3  # every third part is a pose to choose from


def clear_pose(mechanism: Mechanism) -> tuple[RunData, str]:
    """Return the view of a mechanism in a pose that shows every body, and the words for this pose.

    It is the start if no body hides most of another there, as the rod hides the crank at a dead centre;
    otherwise the pose of the first turn of the ideal motion in which the body that is seen least is seen
    best. Raises AssemblyError.
    """
    start = standing(assemble(mechanism))
    if shows_every_body(start) or turn_of(mechanism) is None:
        return start, "at the start"
    best = max((*_poses_of_a_turn(mechanism), start), key=lambda view: least_visible(outlines_of(view), 0))
    angles, start_angles = best.crank_angle, start.crank_angle
    if best is start or angles is None or start_angles is None:
        return start, "at the start"
    angle, start_angle = round(float(angles[0])) % 360, round(float(start_angles[0])) % 360
    return best, f"with {best.crank} at {angle}° (the start at {start_angle}° hides a body)"


def _poses_of_a_turn(mechanism: Mechanism) -> list[RunData]:
    """Return poses of the ideal motion over the first turn, as far as it can be followed."""
    turn = turn_of(mechanism) or 0.0
    views, position = [], None
    for part in range(1, PARTS):
        try:
            motion = ideal_motion(mechanism, turn * part / PARTS, position)
            position = motion.position
            if part % SHOWN == 0:
                state = StartState(position, motion.velocity, frozenset(mechanism.bodies))
                views.append(standing(assemble(mechanism, start_state=state)))
        except VfifeError:  # a mechanism that locks within its turn has the poses before
            break
    return views
