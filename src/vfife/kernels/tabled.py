"""A contact law as a table: a loading and an unloading branch over the penetration, in cubic pieces.

The force is the mean of both branches plus a factor times half of their difference. The factor is 1 while the
surfaces approach and -1 while they separate. Below a share of the impact speed, the transition, it is
proportional to the rate. The solution of :func:`~vfife.kernels.geometry.normal_force` needs a force that is
linear in the rate, so the factor is written as slowness times rate. Equal branches make an elastic law.
"""

from .arrays import KNOT


def turned_slowness(slowness, inverse_transition, rate):
    """Return the slowness (s/m) that, times the rate, is the factor of half the branches' difference.

    It is 1/|rate| for the expected ``rate`` (m/s), so that the factor is 1 or -1, but at most 1/(transition
    times impact speed), where the surfaces turn. ``inverse_transition`` is the inverse of that share (1).
    """
    slow = slowness * inverse_transition
    ratio = slow * abs(rate)
    return slow / (ratio if ratio > 1.0 else 1.0)


def tabled_law(S, first, count, depth, slowness):
    """Return elastic force (N) and damping coefficient (N s/m) at a penetration ``depth`` (m) from the
    ``count`` pieces that begin at row ``first``; the first begins at 0, the last has no end.
    """
    # Every piece is compared and the last one that begins before ``depth`` remains: a search would branch.
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
