"""The equations of the reactions with the rows turned to t_(n+1): Newton's method for the joints of a step.

The forces of t_n act along the rows of t_n, G, and close those of t_(n+1), G + dG: (G + dG) M^-1 G^T is not symmetric, and its error is of second
order in what is still open, whatever the angle of the step. It has the profile of the symmetric one, once below and once above the diagonal.
"""

from .arrays import CONSTRAINT, CONSTRAINT_INDEX, COUPLE_INDEX, HEADER, PARTICLE

TURNED = CONSTRAINT.turn_b - CONSTRAINT.jb  # from a lever to its change
LEAST = 1e-9  # pivot, of the diagonal, that is not divided by
REDUNDANT = 1e-5  # share of the diagonal where joints are redundant: they are so only where they are closed, and there is no hurry for them


def entry(S, a, c, x, y):
    """What a body of unit mass and one of unit inertia add where row a stands with the turned row c, and the reverse; levers in rows x and y."""
    ax = S[a + CONSTRAINT.nx]
    ay = S[a + CONSTRAINT.ny]
    cx = S[c + CONSTRAINT.nx]
    cy = S[c + CONSTRAINT.ny]
    along = ax * cx + ay * cy
    below = along + (S[a + CONSTRAINT.turn_x] * cx + S[a + CONSTRAINT.turn_y] * cy)
    above = along + (S[c + CONSTRAINT.turn_x] * ax + S[c + CONSTRAINT.turn_y] * ay)
    return below, above, (S[x] + S[x + TURNED]) * S[y], (S[y] + S[y + TURNED]) * S[x]


def meet(S, I, a, c, x, y, im, ii, at):
    """Adds a body to the two entries of a pair of rows; the entry of the lower half lies ``at`` rows from the profile's begin."""
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
            meet(S, I, a + CONSTRAINT.SIZE, c + CONSTRAINT.SIZE, x + CONSTRAINT.SIZE, y + CONSTRAINT.SIZE, im, ii, lower + 1)
            if a != c:
                meet(S, I, a, c + CONSTRAINT.SIZE, x, y + CONSTRAINT.SIZE, im, ii, at + 1)


def halves(S, I, share):
    """L U of the matrix in place, L with a unit diagonal; pivots are kept as inverses, 0 where they are next to nothing."""
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
