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
from .geometry import unlikely

# second differences of the product of pivots, over itself, that count as a passage: eight steps away from it
NEAR = 32.0
# second differences, of the least that the parabola through the last three products comes to: it passes two
# steps away, or nearer
AT_ALL = 2.0
SINGULAR = 16.0  # share of the pivots there, in squared turns of a step: that of four steps away
LARGEST_SHARE = 1e-2
FLOOR = 1e-8  # share of the pivots where joints are redundant
ROUNDING = 1e-12  # pivot, of what it was before elimination, that is nothing but rounding
TURN = CONSTRAINT.turn_b - CONSTRAINT.jb  # from a lever to its change
LEAST = 1e-9  # pivot, of the diagonal, that is not divided by
# share of the diagonal where joints are redundant: they are so only where they are closed, and there is no
# hurry for them
REDUNDANT = 1e-5


def fill(S, I):
    """Fill the lower half of the matrix G M^-1 G^T, summed over the bodies that two constraints share."""
    for q in range(I[HEADER.profile], I[HEADER.profile] + I[HEADER.profile_count]):
        S[q] = 0.0
    for r in range(I[HEADER.couple], I[HEADER.couple_end], COUPLE_INDEX.SIZE):
        first = I[r + COUPLE_INDEX.first]
        second = I[r + COUPLE_INDEX.second]
        body = I[r + COUPLE_INDEX.body]
        x = I[r + COUPLE_INDEX.first_lever]
        y = I[r + COUPLE_INDEX.second_lever]
        im = S[body + PARTICLE.inverse_mass]
        ii = S[body + PARTICLE.inverse_inertia]
        sign = 1.0 if I[r + COUPLE_INDEX.same] != 0 else -1.0
        at = I[r + COUPLE_INDEX.at]
        if (
            I[r + COUPLE_INDEX.pins] != 0
        ):  # two revolutes: their four entries at once, of directions (1, 0) and (0, 1)
            lower = I[r + COUPLE_INDEX.lower]
            along_x = sign * ii * S[y]
            along_y = sign * ii * S[y + CONSTRAINT.SIZE]
            S[at] += sign * im + S[x] * along_x
            S[lower] += S[x + CONSTRAINT.SIZE] * along_x
            S[lower + 1] += sign * im + S[x + CONSTRAINT.SIZE] * along_y
            if first != second:  # of a joint with itself this entry lies above the diagonal
                S[at + 1] += S[x] * along_y
        else:
            cosine = (
                S[first + CONSTRAINT.nx] * S[second + CONSTRAINT.nx]
                + S[first + CONSTRAINT.ny] * S[second + CONSTRAINT.ny]
            )
            S[at] += sign * (im * cosine + ii * S[x] * S[y])


def first_column(I, r):
    """First column of row r of the matrix that is not zero."""
    return I[I[HEADER.constraint] + CONSTRAINT_INDEX.SIZE * r + CONSTRAINT_INDEX.start]


def column_zero(I, r):
    """Row of the state in which column 0 of row r of the matrix would lie."""
    return I[I[HEADER.constraint] + CONSTRAINT_INDEX.SIZE * r + CONSTRAINT_INDEX.at]


def factor(S, I, share):
    """Factor the matrix into L D L^T along its profile, in place, its diagonal enlarged by ``share``; a pivot
    lost to rounding is left out.

    D is kept as its inverse. Returns the product of the pivots of rows that close loops, over what each was
    before elimination.
    """
    inverse = I[HEADER.inverse]
    stiff = 1.0
    # Row by row (Jennings' skyline scheme): a row has entries from column ``first`` on, and factors fill in
    # nothing before that. ``at`` is where column 0 of the row would lie. The upper half is never stored: the
    # second loop divides by the pivots only after the row's sums are done. A dense matrix would take n^3/6
    # products where a chain of n joints takes 8 n; the topology is known, so that straight-line code has no
    # loop.
    for r in range(I[HEADER.constraint_count]):
        first = first_column(I, r)
        at = column_zero(I, r)
        for c in range(first, r):
            other = column_zero(I, c)
            start = max(first, first_column(I, c))
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
        pivot = 1.0 / left if left > ROUNDING * diagonal else 0.0
        S[inverse + r] = pivot
        if I[I[HEADER.constraint] + CONSTRAINT_INDEX.SIZE * r + CONSTRAINT_INDEX.closing] != 0:
            stiff = stiff * (diagonal * pivot)
    return 1.0 / stiff if stiff > 0.0 else 0.0


def passage(S, I, dt):
    """Share of the pivots by which the fastest turning pinned body is held back near a singular position."""
    spin = 0.0
    for q in range(I[HEADER.pinned], I[HEADER.pinned_end]):
        spin = larger(spin, abs(S[I[q] + PARTICLE.w]))
    share = SINGULAR * (dt * spin) * (dt * spin)
    return share if share < LARGEST_SHARE else LARGEST_SHARE


def equations(S, I, dt, start):
    """Fill and factor the matrix of t_n, damped where the step before saw the mechanism pass a singular
    position: a test that waits for nothing.
    """
    fill(S, I)
    floor = FLOOR if I[HEADER.redundant] != 0 else 0.0
    pivots = factor(S, I, floor)
    S[SYSTEM.share] = 0.0
    if I[HEADER.closing] != 0:
        if unlikely(start):
            S[SYSTEM.pivots] = pivots
            S[SYSTEM.pivots_before] = pivots
        # The parabola through the last three products of pivots: near a passage it is small against its
        # curvature, and its least value, last - slope^2 / (2 bent), is below two second differences. The
        # damping comes a step later, so that factoring waits for no test.
        last = S[SYSTEM.pivots]
        slope = 0.5 * (pivots - S[SYSTEM.pivots_before])
        bent = (pivots - last) - (last - S[SYSTEM.pivots_before])
        S[SYSTEM.pivots_before] = last
        S[SYSTEM.pivots] = pivots
        before = S[SYSTEM.passing]
        S[SYSTEM.passing] = (
            1.0 if NEAR * bent > pivots and 2.0 * bent * (last - AT_ALL * bent) < slope * slope else 0.0
        )
        if unlikely(before > 0.5):
            fill(S, I)
            share = passage(S, I, dt)
            S[SYSTEM.share] = share
            factor(S, I, floor + share)


def solve(S, I, y):
    """Solve for the right side in rows y, in place, with the factors of :func:`factor`."""
    forward(S, I, y, 0)
    for r in range(I[HEADER.constraint_count]):
        S[y + r] = S[y + r] * S[I[HEADER.inverse] + r]
    for q in range(I[HEADER.constraint_count]):
        r = I[HEADER.constraint_count] - 1 - q
        at = column_zero(I, r)
        value = S[y + r]
        for c in range(first_column(I, r), r):
            S[y + c] -= S[at + c] * value


def forward(S, I, y, shift):
    """Substitute forward with a lower half that lies ``shift`` rows behind the profile."""
    for r in range(I[HEADER.constraint_count]):
        at = column_zero(I, r) + shift
        value = S[y + r]
        for c in range(first_column(I, r), r):
            value -= S[at + c] * S[y + c]
        S[y + r] = value


def idle_reactions(S, I, y):
    """Store in rows y the part of the reactions that moves nothing, of redundant joints.

    It is (A + f D)^-1 f D times the reactions, with the floor f and the diagonal D: what the floor has added
    to the matrix moves back exactly that.
    """
    for r in range(I[HEADER.constraint_count]):
        q = I[I[HEADER.constraint] + CONSTRAINT_INDEX.SIZE * r + CONSTRAINT_INDEX.row]
        S[y + r] = FLOOR * S[column_zero(I, r) + r] * S[q + CONSTRAINT.force]
    solve(S, I, y)


def fill_turned(S, I):
    """Fill both halves of (G + dG) M^-1 G^T, the upper one ``profile_count`` rows behind the lower one."""
    for q in range(I[HEADER.turned], I[HEADER.turned] + 2 * I[HEADER.profile_count]):
        S[q] = 0.0
    for r in range(I[HEADER.couple], I[HEADER.couple_end], COUPLE_INDEX.SIZE):
        shift = I[HEADER.turned] - I[HEADER.profile]
        at = I[r + COUPLE_INDEX.at] + shift
        add_turned(S, I, r, 0, 0, at)
        if I[r + COUPLE_INDEX.pins] != 0:  # two revolutes: their four entries
            lower = I[r + COUPLE_INDEX.lower] + shift
            add_turned(S, I, r, CONSTRAINT.SIZE, 0, lower)
            add_turned(S, I, r, CONSTRAINT.SIZE, CONSTRAINT.SIZE, lower + 1)
            if I[r + COUPLE_INDEX.first] != I[r + COUPLE_INDEX.second]:
                add_turned(S, I, r, 0, CONSTRAINT.SIZE, at + 1)


def add_turned(S, I, r, on, to, low):
    """Add the body of couple r to two entries: of the rows ``on`` and ``to`` behind its first rows, at
    ``low``, and of the two exchanged.
    """
    a = I[r + COUPLE_INDEX.first] + on
    c = I[r + COUPLE_INDEX.second] + to
    x = I[r + COUPLE_INDEX.first_lever] + on
    y = I[r + COUPLE_INDEX.second_lever] + to
    body = I[r + COUPLE_INDEX.body]
    sign = 1.0 if I[r + COUPLE_INDEX.same] != 0 else -1.0
    im = sign * S[body + PARTICLE.inverse_mass]
    ii = sign * S[body + PARTICLE.inverse_inertia]
    ax = S[a + CONSTRAINT.nx]
    ay = S[a + CONSTRAINT.ny]
    cx = S[c + CONSTRAINT.nx]
    cy = S[c + CONSTRAINT.ny]
    along = ax * cx + ay * cy
    lower = along + (S[a + CONSTRAINT.turn_x] * cx + S[a + CONSTRAINT.turn_y] * cy)
    upper = along + (S[c + CONSTRAINT.turn_x] * ax + S[c + CONSTRAINT.turn_y] * ay)
    high = low + I[HEADER.profile_count]
    S[low] += im * lower + ii * ((S[x] + S[x + TURN]) * S[y])
    S[high] += im * upper + ii * ((S[y] + S[y + TURN]) * S[x])


def factor_turned(S, I, share):
    """Factor the turned matrix into L U in place, L with a unit diagonal; pivots are kept as inverses, 0
    where they are next to nothing.
    """
    shift = I[HEADER.turned] - I[HEADER.profile]
    up = I[HEADER.profile_count]
    inverse = I[HEADER.turned] + 2 * up
    for r in range(I[HEADER.constraint_count]):
        first = first_column(I, r)
        at = column_zero(I, r) + shift
        for c in range(first, r):
            other = column_zero(I, c) + shift
            start = max(first, first_column(I, c))
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
    """Solve for the right side in rows y, in place, with the factors of :func:`factor_turned`."""
    shift = I[HEADER.turned] - I[HEADER.profile]
    up = I[HEADER.profile_count]
    inverse = I[HEADER.turned] + 2 * up
    forward(S, I, y, shift)
    for q in range(I[HEADER.constraint_count]):
        r = I[HEADER.constraint_count] - 1 - q
        at = column_zero(I, r) + shift
        value = S[y + r] * S[inverse + r]
        S[y + r] = value
        for c in range(first_column(I, r), r):
            S[y + c] -= S[at + up + c] * value
