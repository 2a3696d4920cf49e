"""The equations of the reactions: G M^-1 G^T along the profile of the joint graph, factored in place, and
what is done where it is singular.

**Singular positions.** Where the directions of two constraints become one, a pivot goes as the square of the
angle that is left, and within some steps of there it changes by as much as itself in a step: what a whole
correction does is unbounded. There all pivots get a share more (Levenberg 1944), and inertia carries the
mechanism through. A pivot may also be small and stay so, in a flat arch or a light body far off its pin; that
is no passage. What becomes small is told from what is small by the product of the pivots that close loops:
the parabola through its last three values has its least value near zero, and soon. A tree of bodies has no
such pivots.

**Redundant joints.** With rows that depend on one another all pivots have a floor, so that the order of the
rows does not matter, and the part of the reactions that moves nothing is taken off again: what is left is
their solution of least norm, each row weighed by its own diagonal.

**Turned rows.** The forces of t_n act along the rows of t_n, G, and close those of t_(n+1), G + dG: (G + dG)
M^-1 G^T, the matrix of Newton's method, is not symmetric, and its error is of second order in what is still
open, whatever the angle of the step. It has the profile of the symmetric one, once below and once above the
diagonal.
"""

from .arrays import CONSTRAINT, CONSTRAINT_INDEX, COUPLE_INDEX, HEADER, PARTICLE, SYSTEM
from .central_difference import larger
from .geometry import seldom

# second differences of the product of pivots, over itself, that count as a passage: eight steps away from it
NEAR = 32.0
# second differences, of the least that the parabola through the last three products comes to: it passes two
# steps away, or nearer
AT_ALL = 2.0
SINGULAR = 16.0  # share of the pivots there, in squared turns of a step: that of four steps away
COARSE = 1e-2  # the largest such share
FLOOR = 1e-8  # share of the pivots where joints are redundant
LOST = 1e-12  # pivot, of what it was before elimination, that is nothing but rounding
TURNED = CONSTRAINT.turn_b - CONSTRAINT.jb  # from a lever to its change
LEAST = 1e-9  # pivot, of the diagonal, that is not divided by
# share of the diagonal where joints are redundant: they are so only where they are closed, and there is no
# hurry for them
REDUNDANT = 1e-5


def fill(S, I):
    """Lower half of the matrix G M^-1 G^T, summed over the bodies that two constraints share."""
    for q in range(I[HEADER.profile_count]):
        S[I[HEADER.profile] + q] = 0.0
    for m in range(I[HEADER.couple_count]):
        r = I[HEADER.couple] + COUPLE_INDEX.SIZE * m
        a = I[r + COUPLE_INDEX.first]
        c = I[r + COUPLE_INDEX.second]
        body = I[r + COUPLE_INDEX.body]
        x = I[r + COUPLE_INDEX.first_lever]
        y = I[r + COUPLE_INDEX.second_lever]
        im = S[body + PARTICLE.inverse_mass]
        ii = S[body + PARTICLE.inverse_inertia]
        sign = 1.0 if I[r + COUPLE_INDEX.same] != 0 else -1.0
        at = I[r + COUPLE_INDEX.at]
        if I[r + COUPLE_INDEX.pins] != 0:  # two revolutes: their four entries at once
            ax = S[x]
            ay = S[x + CONSTRAINT.SIZE]
            cx = sign * ii * S[y]
            cy = sign * ii * S[y + CONSTRAINT.SIZE]
            lower = I[r + COUPLE_INDEX.lower]
            S[at] += sign * im + ax * cx
            S[lower] += ay * cx
            S[lower + 1] += sign * im + ay * cy
            if a != c:
                S[at + 1] += ax * cy
        else:
            along = S[a + CONSTRAINT.nx] * S[c + CONSTRAINT.nx] + S[a + CONSTRAINT.ny] * S[c + CONSTRAINT.ny]
            S[at] += sign * (im * along + ii * S[x] * S[y])


def factor(S, I, share):
    """L D L^T of the matrix along its profile, in place, its diagonal enlarged by ``share``; a pivot lost to
    rounding is left out.

    Returned: the product of the pivots of rows that close loops, over what each was before elimination.
    """
    inverse = I[HEADER.inverse]
    stiff = 1.0
    # Row by row (Jennings' skyline scheme): a row has entries from column ``first`` on, and factors fill in
    # nothing before that. ``at`` is where
    # column 0 of the row would lie. The upper half is never stored: the second loop divides by the pivots
    # only after the row's sums are done.
    for r in range(I[HEADER.constraint_count]):
        first = I[I[HEADER.constraint] + CONSTRAINT_INDEX.SIZE * r + CONSTRAINT_INDEX.start]
        at = I[I[HEADER.constraint] + CONSTRAINT_INDEX.SIZE * r + CONSTRAINT_INDEX.at]
        for c in range(first, r):
            other = I[I[HEADER.constraint] + CONSTRAINT_INDEX.SIZE * c + CONSTRAINT_INDEX.at]
            start = max(first, I[I[HEADER.constraint] + CONSTRAINT_INDEX.SIZE * c + CONSTRAINT_INDEX.start])
            value = S[at + c]
            for q in range(start, c):
                value -= S[at + q] * S[other + q]
            S[at + c] = value
        diagonal = S[at + r]
        left = diagonal + share * diagonal
        for c in range(first, r):
            value = S[at + c]
            ratio = value * S[inverse + c]
            left -= value * ratio
            S[at + c] = ratio
        one = 1.0 / left if left > LOST * diagonal else 0.0
        S[inverse + r] = one
        if I[I[HEADER.constraint] + CONSTRAINT_INDEX.SIZE * r + CONSTRAINT_INDEX.closing] != 0:
            stiff = stiff * (diagonal * one)
    return 1.0 / stiff if stiff > 0.0 else 0.0


def passage(S, I, dt):
    """Share of the pivots by which the fastest turning pinned body is held back near a singular position."""
    spin = 0.0
    for q in range(I[HEADER.pinned_count]):
        spin = larger(spin, abs(S[I[I[HEADER.pinned] + q] + PARTICLE.w]))
    share = SINGULAR * (dt * spin) * (dt * spin)
    return share if share < COARSE else COARSE


def equations(S, I, dt, start):
    """The matrix of t_n and its factors, damped where the step before saw the mechanism pass a singular
    position: a test that waits for nothing.
    """
    fill(S, I)
    floor = FLOOR if I[HEADER.redundant] != 0 else 0.0
    pivots = factor(S, I, floor)
    S[SYSTEM.share] = 0.0
    if I[HEADER.closing] != 0:
        if seldom(start):
            S[SYSTEM.pivots] = pivots
            S[SYSTEM.pivots_before] = pivots
        # The parabola through the last three products of pivots: near a passage it is small against its
        # curvature, and its least value,
        # last - slope^2 / (2 bent), is below two second differences. The damping comes a step later, so that
        # factoring waits for no test.
        last = S[SYSTEM.pivots]
        slope = 0.5 * (pivots - S[SYSTEM.pivots_before])
        bent = (pivots - last) - (last - S[SYSTEM.pivots_before])
        S[SYSTEM.pivots_before] = last
        S[SYSTEM.pivots] = pivots
        before = S[SYSTEM.passing]
        S[SYSTEM.passing] = (
            1.0 if NEAR * bent > pivots and 2.0 * bent * (last - AT_ALL * bent) < slope * slope else 0.0
        )
        if seldom(before > 0.5):
            fill(S, I)
            share = passage(S, I, dt)
            S[SYSTEM.share] = share
            factor(S, I, floor + share)


def forward(S, I, y):
    """Forward substitution with the factors in place."""
    for r in range(I[HEADER.constraint_count]):
        at = I[I[HEADER.constraint] + CONSTRAINT_INDEX.SIZE * r + CONSTRAINT_INDEX.at]
        value = S[y + r]
        for c in range(I[I[HEADER.constraint] + CONSTRAINT_INDEX.SIZE * r + CONSTRAINT_INDEX.start], r):
            value -= S[at + c] * S[y + c]
        S[y + r] = value


def backward(S, I, y):
    """Division by D and backward substitution."""
    for r in range(I[HEADER.constraint_count]):
        S[y + r] = S[y + r] * S[I[HEADER.inverse] + r]
    for q in range(I[HEADER.constraint_count]):
        r = I[HEADER.constraint_count] - 1 - q
        at = I[I[HEADER.constraint] + CONSTRAINT_INDEX.SIZE * r + CONSTRAINT_INDEX.at]
        value = S[y + r]
        for c in range(I[I[HEADER.constraint] + CONSTRAINT_INDEX.SIZE * r + CONSTRAINT_INDEX.start], r):
            S[y + c] -= S[at + c] * value


def solve(S, I, y):
    """Solution with the factors in place."""
    forward(S, I, y)
    backward(S, I, y)


def idle(S, I, y):
    """Part of the reactions that moves nothing, of redundant joints: (A + f D)^-1 f D times what they are,
    with the floor f and the diagonal D.
    """
    for r in range(I[HEADER.constraint_count]):
        at = I[I[HEADER.constraint] + CONSTRAINT_INDEX.SIZE * r + CONSTRAINT_INDEX.at]
        q = I[I[HEADER.constraint] + CONSTRAINT_INDEX.SIZE * r + CONSTRAINT_INDEX.row]
        S[y + r] = FLOOR * S[at + r] * S[q + CONSTRAINT.force]
    solve(S, I, y)


def entry(S, a, c, x, y):
    """What a body of unit mass and one of unit inertia add where row a stands with the turned row c, and the
    reverse; levers in rows x and y.
    """
    ax = S[a + CONSTRAINT.nx]
    ay = S[a + CONSTRAINT.ny]
    cx = S[c + CONSTRAINT.nx]
    cy = S[c + CONSTRAINT.ny]
    along = ax * cx + ay * cy
    below = along + (S[a + CONSTRAINT.turn_x] * cx + S[a + CONSTRAINT.turn_y] * cy)
    above = along + (S[c + CONSTRAINT.turn_x] * ax + S[c + CONSTRAINT.turn_y] * ay)
    return below, above, (S[x] + S[x + TURNED]) * S[y], (S[y] + S[y + TURNED]) * S[x]


def meet(S, I, a, c, x, y, im, ii, at):
    """Adds a body to the two entries of a pair of rows; the entry of the lower half lies ``at`` rows from the
    profile's begin.
    """
    below, above, under, over = entry(S, a, c, x, y)
    low = I[HEADER.turned] + at
    high = low + I[HEADER.profile_count]
    S[low] += im * below + ii * under
    S[high] += im * above + ii * over


def fill_turned(S, I):
    """Both halves of (G + dG) M^-1 G^T."""
    for q in range(2 * I[HEADER.profile_count]):
        S[I[HEADER.turned] + q] = 0.0
    for m in range(I[HEADER.couple_count]):
        r = I[HEADER.couple] + COUPLE_INDEX.SIZE * m
        a = I[r + COUPLE_INDEX.first]
        c = I[r + COUPLE_INDEX.second]
        body = I[r + COUPLE_INDEX.body]
        x = I[r + COUPLE_INDEX.first_lever]
        y = I[r + COUPLE_INDEX.second_lever]
        sign = 1.0 if I[r + COUPLE_INDEX.same] != 0 else -1.0
        im = sign * S[body + PARTICLE.inverse_mass]
        ii = sign * S[body + PARTICLE.inverse_inertia]
        at = I[r + COUPLE_INDEX.at] - I[HEADER.profile]
        meet(S, I, a, c, x, y, im, ii, at)
        if I[r + COUPLE_INDEX.pins] != 0:  # two revolutes: their four entries
            lower = I[r + COUPLE_INDEX.lower] - I[HEADER.profile]
            meet(S, I, a + CONSTRAINT.SIZE, c, x + CONSTRAINT.SIZE, y, im, ii, lower)
            meet(
                S,
                I,
                a + CONSTRAINT.SIZE,
                c + CONSTRAINT.SIZE,
                x + CONSTRAINT.SIZE,
                y + CONSTRAINT.SIZE,
                im,
                ii,
                lower + 1,
            )
            if a != c:
                meet(S, I, a, c + CONSTRAINT.SIZE, x, y + CONSTRAINT.SIZE, im, ii, at + 1)


def halves(S, I, share):
    """L U of the matrix in place, L with a unit diagonal; pivots are kept as inverses, 0 where they are next
    to nothing.
    """
    shift = I[HEADER.turned] - I[HEADER.profile]
    up = I[HEADER.profile_count]
    inverse = I[HEADER.turned] + 2 * up
    for r in range(I[HEADER.constraint_count]):
        first = I[I[HEADER.constraint] + CONSTRAINT_INDEX.SIZE * r + CONSTRAINT_INDEX.start]
        at = I[I[HEADER.constraint] + CONSTRAINT_INDEX.SIZE * r + CONSTRAINT_INDEX.at] + shift
        for c in range(first, r):
            other = I[I[HEADER.constraint] + CONSTRAINT_INDEX.SIZE * c + CONSTRAINT_INDEX.at] + shift
            start = max(first, I[I[HEADER.constraint] + CONSTRAINT_INDEX.SIZE * c + CONSTRAINT_INDEX.start])
            low = S[at + c]
            high = S[at + up + c]
            for q in range(start, c):
                low -= S[at + q] * S[other + up + q]
                high -= S[other + q] * S[at + up + q]
            S[at + c] = low * S[inverse + c]
            S[at + up + c] = high
        diagonal = S[at + r]
        left = diagonal + share * diagonal
        for c in range(first, r):
            left -= S[at + c] * S[at + up + c]
        S[inverse + r] = 1.0 / left if abs(left) > LEAST * diagonal else 0.0


def solve_turned(S, I, y):
    """Solution with the halves in place."""
    shift = I[HEADER.turned] - I[HEADER.profile]
    up = I[HEADER.profile_count]
    inverse = I[HEADER.turned] + 2 * up
    for r in range(I[HEADER.constraint_count]):
        at = I[I[HEADER.constraint] + CONSTRAINT_INDEX.SIZE * r + CONSTRAINT_INDEX.at] + shift
        value = S[y + r]
        for c in range(I[I[HEADER.constraint] + CONSTRAINT_INDEX.SIZE * r + CONSTRAINT_INDEX.start], r):
            value -= S[at + c] * S[y + c]
        S[y + r] = value
    for q in range(I[HEADER.constraint_count]):
        r = I[HEADER.constraint_count] - 1 - q
        at = I[I[HEADER.constraint] + CONSTRAINT_INDEX.SIZE * r + CONSTRAINT_INDEX.at] + shift
        value = S[y + r] * S[inverse + r]
        S[y + r] = value
        for c in range(I[I[HEADER.constraint] + CONSTRAINT_INDEX.SIZE * r + CONSTRAINT_INDEX.start], r):
            S[y + c] -= S[at + up + c] * value
