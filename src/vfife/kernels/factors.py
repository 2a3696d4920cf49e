"""The equations of the reactions: the matrix G M^-1 G^T, factored in place along the profile of the joint
graph, and its treatment where it is singular.

**Singular positions.** As the directions of two constraints approach each other, a pivot decreases with the
square of the angle between them. Within a few steps of the singular position it changes by its own size in
each step, and a full correction is unbounded. There all pivots are enlarged by a share of the diagonal
(Levenberg 1944), and inertia carries the mechanism through. A pivot may also be small all the time, in a flat
arch or a light body far from its pin; that needs no damping. The product of the pivots that close loops
separates the two: at a passage, the parabola through its last three values has its minimum near zero and
within the next steps. A tree of bodies closes no loop and has no such pivots.

**Redundant joints.** If rows are linearly dependent, all pivots get a floor, so that the result does not
depend on the order of the rows. The part of the reactions that moves no body is subtracted afterwards: the
remaining solution has least norm, each row weighted by its own diagonal.

**Turned rows.** Forces at t_n act along the rows of t_n, G, but have to close those of t_(n+1), G + dG. The
matrix of Newton's method, (G + dG) M^-1 G^T, is not symmetric. The error of its solution is of second order
in the distance that is still open, for any angle of the step. It has the profile of the symmetric matrix,
once below and once above the diagonal.
"""

from .arrays import CONSTRAINT, CONSTRAINT_INDEX, COUPLE_INDEX, HEADER, PARTICLE, SYSTEM
from .central_difference import larger
from .geometry import unlikely

# A passage through a singular position is detected by the product P of pivots. Near it P = s^2 k^2, k steps
# away from it, with the second difference 2 s^2: their ratio is k^2/2. PASSAGE_RATIO is that
# ratio eight steps away.
PASSAGE_RATIO = 32.0
# The least value of the parabola through the last three products, in second differences: it corresponds to a
# passage at a distance of two steps or less. A larger minimum means that the mechanism turns round before.
CLOSEST = 2.0
# Share of the diagonal that is added there, in squared turns of a step: the pivot four steps away, at most
# LARGEST_SHARE.
SINGULAR = 16.0
LARGEST_SHARE = 1e-2
# Share of the diagonal that is added where joints are redundant.
FLOOR = 1e-8
# A pivot below this share of its value before elimination is rounding, and its row is left out.
ROUNDING = 1e-12
TURN = CONSTRAINT.turn_b - CONSTRAINT.jb  # offset from a lever to its change
# The same limit for the turned matrix, whose pivots may be negative.
LEAST_PIVOT = 1e-9
# Share of the diagonal that is added to the turned matrix where joints are redundant. It is larger than FLOOR
# because turned rows become dependent only as the joints close; that these rows converge slowly does no harm.
REDUNDANT = 1e-5


def fill(S, I):
    """Fill the lower half of the matrix G M^-1 G^T: each couple is two constraints that share a body, and
    adds the product of their rows with that body's inverse mass and inertia.
    """
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
        if I[r + COUPLE_INDEX.pins] != 0:
            # Two revolutes, whose rows have the directions (1, 0) and (0, 1): their four entries at once.
            lower = I[r + COUPLE_INDEX.lower]
            along_x = sign * ii * S[y]
            along_y = sign * ii * S[y + CONSTRAINT.SIZE]
            S[at] += sign * im + S[x] * along_x
            S[lower] += S[x + CONSTRAINT.SIZE] * along_x
            S[lower + 1] += sign * im + S[x + CONSTRAINT.SIZE] * along_y
            if first != second:  # for a joint with itself this entry lies above the diagonal
                S[at + 1] += S[x] * along_y
        else:
            cosine = (
                S[first + CONSTRAINT.nx] * S[second + CONSTRAINT.nx]
                + S[first + CONSTRAINT.ny] * S[second + CONSTRAINT.ny]
            )
            S[at] += sign * (im * cosine + ii * S[x] * S[y])


def first_column(I, r):
    """Return the first column of row r of the matrix that can differ from zero."""
    return I[I[HEADER.constraint] + CONSTRAINT_INDEX.SIZE * r + CONSTRAINT_INDEX.start]


def column_zero(I, r):
    """Return the row of the state in which column 0 of row r of the matrix would lie."""
    return I[I[HEADER.constraint] + CONSTRAINT_INDEX.SIZE * r + CONSTRAINT_INDEX.at]


def factor(S, I, share):
    """Factor the matrix into L D L^T in place along its profile, with its diagonal enlarged by ``share``.

    D is stored as its inverse, which is zero where a pivot is lost to rounding. Returns the product, over
    the rows that close loops, of pivot over diagonal before elimination: 1 far from a singular position, 0
    in it.
    """
    inverse = I[HEADER.inverse]
    stiff = 1.0
    # Row by row (the skyline scheme of Jennings): a row has entries from column ``first`` on, and elimination
    # fills in nothing before that. ``at`` is where column 0 of the row would lie. The upper half is never
    # stored: the second loop divides by the pivots only after the row's sums are done. A dense matrix would
    # take n^3/6 products where a chain of n joints takes 8 n. Straight-line code has no loop at all, because
    # the topology is known.
    for r in range(I[HEADER.constraint_count]):
        first = first_column(I, r)
        at = column_zero(I, r)
        for c in range(first, r):
            column_start = column_zero(I, c)
            start = max(first, first_column(I, c))
            value = S[at + c]
            for q in range(start, c):
                value -= S[at + q] * S[column_start + q]
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
    """Return the share of the diagonal that is added near a singular position, from the step ``dt`` (s) and
    the fastest turning pinned body: the angle between two constraints changes no faster than it turns.
    """
    spin = 0.0
    for q in range(I[HEADER.pinned], I[HEADER.pinned_end]):
        spin = larger(spin, abs(S[I[q] + PARTICLE.w]))
    share = SINGULAR * (dt * spin) * (dt * spin)
    return share if share < LARGEST_SHARE else LARGEST_SHARE


def equations(S, I, dt, start):
    """Fill and factor the matrix of t_n, damped if the last step has detected a passage through a singular
    position.
    """
    fill(S, I)
    floor = FLOOR if I[HEADER.redundant] != 0 else 0.0
    pivots = factor(S, I, floor)
    S[SYSTEM.share] = 0.0
    if I[HEADER.closing] != 0:
        if unlikely(start):
            S[SYSTEM.pivots] = pivots
            S[SYSTEM.pivots_before] = pivots
        # The parabola through the last three products of pivots. A passage has two marks: the product is
        # small against its second difference ``bent`` (PASSAGE_RATIO), and the parabola's minimum,
        # last - slope^2 / (2 bent), is below CLOSEST second differences. The damping comes one step later,
        # so that the solution of this step does not wait for the test.
        last = S[SYSTEM.pivots]
        slope = 0.5 * (pivots - S[SYSTEM.pivots_before])
        bent = (pivots - last) - (last - S[SYSTEM.pivots_before])
        S[SYSTEM.pivots_before] = last
        S[SYSTEM.pivots] = pivots
        passing = S[SYSTEM.passing]
        S[SYSTEM.passing] = (
            1.0
            if PASSAGE_RATIO * bent > pivots and 2.0 * bent * (last - CLOSEST * bent) < slope * slope
            else 0.0
        )
        if unlikely(passing > 0.5):
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
    """Substitute forward in rows y with a lower half that lies ``shift`` rows behind the profile."""
    for r in range(I[HEADER.constraint_count]):
        at = column_zero(I, r) + shift
        value = S[y + r]
        for c in range(first_column(I, r), r):
            value -= S[at + c] * S[y + c]
        S[y + r] = value


def idle_reactions(S, I, y):
    """Store in rows y the part of redundant reactions that moves no body.

    With the matrix A, its diagonal D and the floor f it is (A + f D)^-1 f D times the reactions: A annuls
    this part, so that f D alone answers to it.
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
    """Add couple r to two entries of the turned matrix: that of the rows ``on`` and ``to`` behind the
    couple's first rows, at ``low``, and its mirror image above the diagonal.
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
    straight = ax * cx + ay * cy
    lower = straight + (S[a + CONSTRAINT.turn_x] * cx + S[a + CONSTRAINT.turn_y] * cy)
    upper = straight + (S[c + CONSTRAINT.turn_x] * ax + S[c + CONSTRAINT.turn_y] * ay)
    high = low + I[HEADER.profile_count]
    S[low] += im * lower + ii * ((S[x] + S[x + TURN]) * S[y])
    S[high] += im * upper + ii * ((S[y] + S[y + TURN]) * S[x])


def factor_turned(S, I, share):
    """Factor the turned matrix into L U in place, L with a unit diagonal. Pivots are stored as inverses, 0
    where they are below LEAST_PIVOT of the diagonal.
    """
    # Both halves of row r are eliminated together: ``low`` is an entry of L in row r, ``high`` the entry of
    # U in column r. Rows are not exchanged: the matrix is the positive definite one of t_n up to the turn of
    # a step, and an exchange would leave the profile and differ from lane to lane.
    shift = I[HEADER.turned] - I[HEADER.profile]
    up = I[HEADER.profile_count]
    inverse = I[HEADER.turned] + 2 * up
    for r in range(I[HEADER.constraint_count]):
        first = first_column(I, r)
        at = column_zero(I, r) + shift
        for c in range(first, r):
            column_start = column_zero(I, c) + shift
            start = max(first, first_column(I, c))
            low = S[at + c]
            high = S[at + up + c]
            for q in range(start, c):
                low -= S[at + q] * S[column_start + up + q]
                high -= S[column_start + q] * S[at + up + q]
            S[at + c] = low * S[inverse + c]
            S[at + up + c] = high
        diagonal = S[at + r]
        left = diagonal + share * diagonal
        for c in range(first, r):
            left -= S[at + c] * S[at + up + c]
        S[inverse + r] = 1.0 / left if abs(left) > LEAST_PIVOT * diagonal else 0.0


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
