"""A contact law as a table: loading and unloading over the penetration, as pieces of cubics.

The force is the mean of both branches and half of what they are apart times a factor, which is 1 while the
surfaces approach, -1 while they part, and passes from one to the other with the rate where that is less than
a share of the impact speed. Where a table's branches are apart by nothing its force is elastic.
"""

from .arrays import KNOT


def turned_slowness(slowness, inverse_transition, rate):
    """The slowness (s/m) that makes half of the branches' distance times it and the rate the force beyond
    their mean.

    1/|rate| while the surfaces approach or part, and no more than that of the ``transition``, a share of the
    impact speed 1/slowness, where they turn. The rate is the one expected; the force is solved for the rate
    that results.
    """
    slow = slowness * inverse_transition
    over = slow * abs(rate)
    return slow / (over if over > 1.0 else 1.0)


def tabled_law(S, first, count, depth, slowness):
    """Elastic force (N) and damping coefficient (N s/m) at a penetration (m); the first piece begins at 0,
    the last goes on for ever.
    """
    begin = S[first + KNOT.begin]
    m0 = S[first + KNOT.mean]
    m1 = S[first + KNOT.mean + 1]
    m2 = S[first + KNOT.mean + 2]
    m3 = S[first + KNOT.mean + 3]
    h0 = S[first + KNOT.half]
    h1 = S[first + KNOT.half + 1]
    h2 = S[first + KNOT.half + 2]
    h3 = S[first + KNOT.half + 3]
    for q in range(1, count):
        i = first + KNOT.SIZE * q
        past = depth >= S[i + KNOT.begin]
        begin = S[i + KNOT.begin] if past else begin
        m0 = S[i + KNOT.mean] if past else m0
        m1 = S[i + KNOT.mean + 1] if past else m1
        m2 = S[i + KNOT.mean + 2] if past else m2
        m3 = S[i + KNOT.mean + 3] if past else m3
        h0 = S[i + KNOT.half] if past else h0
        h1 = S[i + KNOT.half + 1] if past else h1
        h2 = S[i + KNOT.half + 2] if past else h2
        h3 = S[i + KNOT.half + 3] if past else h3
    x = depth - begin
    return m0 + x * (m1 + x * (m2 + x * m3)), slowness * (h0 + x * (h1 + x * (h2 + x * h3)))
