"""The inferred set by a program of another kind, ``rigid_bars.py``: what it gives is kept here, and
`make verify` computes it anew.
"""

import pytest

from vfife_validation.paper.context import Context
from vfife_validation.paper.influence import Case, influences

IDEAL_FORCE, IDEAL_ALPHA = 89430.6, 22816.05  # N, rad/s^2: method.md, section 2
# By clearance (m), with the best set: largest force of joint 2 (N) and acceleration of the follower (rad/s^2)
# in the fourth turn, RK4 at 1 us.
THEIRS = {
    1e-4: (96856.04994, 25489.59740),
    2e-4: (106161.38140, 29268.60815),
    5e-4: (168567.87987, 48381.79104),
}


@pytest.mark.parametrize(("clearance", "points"), [(1e-4, 0.01), (2e-4, 0.01), (5e-4, 0.2)])
def test_another_program_gives_the_same_influence(clearance, points):
    """Both local influence parameters of the best set, in percentage points (at 0.5 mm it is still settling
    then).
    """
    ours = influences([Case(Context().parameters, clearance)], outputs=20)[0].lips
    force, alpha = THEIRS[clearance]
    theirs = 100 * (force / IDEAL_FORCE - 1), 100 * (alpha / IDEAL_ALPHA - 1)
    assert ours == pytest.approx(theirs, abs=points)


@pytest.mark.verify
@pytest.mark.parametrize("clearance", THEIRS)
def test_these_are_the_other_program_s_numbers(clearance):
    """With the set as it is stored today; compiling the program takes some seconds."""
    from paper.rigid_bars import CRANK_SPEED, law, start, turns_of

    p = Context().parameters
    assert Case(p, clearance).speed == CRANK_SPEED
    largest = turns_of(4, 40_000, p.crank_angle, start(p.crank_angle, p.below), law(p, clearance))[-1]
    assert largest == pytest.approx(THEIRS[clearance], rel=1e-7)
