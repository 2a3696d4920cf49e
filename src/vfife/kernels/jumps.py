"""Jumps of contact forces at onset and end: how much longer a neighbouring motion feels them.

Only derivatives that follow a small difference evaluate these functions (compiler/trace/jumps.py).
"""

from .arrays import CONTACT, CONTACT_INDEX, SPRING
from .central_difference import Central, larger
from .contact import evaluate_law, expected_rate

# Penetration (m) at which a law is evaluated for its jump: laws are zero at zero itself, and powers of this
# number vanish.
TOUCH = 1e-300


def contact_jump(S, I, r, depth, last_slowness, stretch, central: Central):
    """Return the effect of the penetration on the time at which the force of contact r jumps (N/m), 0 in
    steps without onset or end.

    A motion that is deeper by ddepth meets the surface earlier by ddepth / rate, and feels the force F that
    acts at zero penetration for that much longer: an impulse F ddepth / rate, which is ``gain`` times
    (F / rate) / gain times ddepth. This is the saltation matrix (Aizerman and Gantmacher 1958).
    ``last_slowness`` (s/m) is that after the last step: zero in free flight.
    """
    j = I[r + CONTACT_INDEX.row]
    elastic, damping = evaluate_law(S, I, r, TOUCH, S[j + CONTACT.slowness], stretch, central)
    rate = abs(
        stretch * expected_rate(S, j, I[r + CONTACT_INDEX.bearing], I[r + CONTACT_INDEX.journal], central)
    )
    push = elastic / larger(rate, S[j + CONTACT.floor])
    left = push - damping if push > damping else 0.0
    slope = (push + damping) if depth > 0.0 else left
    changed = (last_slowness <= 0.0) if depth > 0.0 else (last_slowness > 0.0)
    return stretch * slope / central.gain if changed else 0.0


def stop_jump(S, g, x, inverse, central: Central):
    """Return the effect of the angle on the time at which the damper of a stop begins to act (N m/rad), 0 in
    other steps; :func:`contact_jump` explains it.

    The moment jumps by damping times rate, so that the rate cancels. Where the stop is left, the moment is
    zero already. ``x`` (rad) is the angle beyond the limit, ``inverse`` (1/(kg m^2)) the mobility.
    """
    damping = S[g + SPRING.damping + 2]
    began = x != 0.0 and S[g + SPRING.regime] == 0.0
    return damping / ((1.0 + central.p * central.h * inverse * damping) * central.gain) if began else 0.0


def stop_share(S, g, x, moment, rate, central: Central):
    """Return the share of a step (1) by which a stop begins to push earlier, or ends later, than its steps
    show, 0 in steps without begin or end.

    The moment of a step acts from half a step before it to half a step after it, but begins when the limit is
    passed, and ends when spring and damper would pull (``moment``, N m), after they pushed in the last step.
    The motion hardly shows this share, because the moment is small there. The stiffness acts on a small
    difference in full.
    """
    last = S[g + SPRING.resistance + 2]
    began = x != 0.0 and S[g + SPRING.regime] == 0.0
    ends = moment * x <= 0.0 and last * x > 0.0
    since = abs(x) / larger(abs(rate) * central.gain, abs(x))
    return since - 0.5 if began else last / (last - moment) - 0.5 if ends else 0.0
