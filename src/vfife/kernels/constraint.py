"""Ideal joints (paper Eq. 14-17, generalised): reactions that keep what is joined joined, one row for each constraint.

For two particles alone the block of a revolute is (1/m_B + 1/m_J) and its solution is Eq. 16 with external forces. Equal accelerations alone
let positions drift, so the reaction at t_n is the one that closes the joint at t_(n+1) (SHAKE: Ryckaert, Ciccotti and Berendsen 1977). Where
bodies carry several joints the rows couple; they are factored along the profile of the joint graph, never as a matrix of the mechanism.

A row has a direction n and a lever on each body: its rate is n (v_k - v_b) + jk w_k - jb w_b. Revolutes have a row for x and one for y, a slider
one across its guide and one for the angle, a weld all three, gears and prescribed angles one for the angle with n = 0.
"""

from .arrays import JD, JK, JQ, JR, C, D, F, H, P, Q, R
from .central_difference import larger
from .elementary import sincos, small_turn
from .geometry import arm
from .topology import ANGLE, GEAR, REVOLUTE, SLIDER, TRAVEL, WELD

SINGULAR = 64.0  # pivot in squared turns of a step (of what it was before elimination) below which its correction is damped: eight steps away
COARSE = 1e-3  # the largest such pivot


def row(S, q, nx, ny, jb, jk):
    """Direction and levers of a constraint."""
    S[q + Q.nx] = nx
    S[q + Q.ny] = ny
    S[q + Q.jb] = jb
    S[q + Q.jk] = jk


def levers(S, I):
    """Directions and levers of all constraints at t_n."""
    for m in range(I[H.ideal_count]):
        r = I[H.ideal] + JR.SIZE * m
        i = I[r + JR.row]
        b = I[r + JR.bearing]
        k = I[r + JR.journal]
        q = I[r + JR.first]
        kind = I[r + JR.kind]
        if kind == GEAR:
            row(S, q, 0.0, 0.0, S[i + R.ratio], 1.0)
        elif kind == ANGLE:
            row(S, q, 0.0, 0.0, 1.0, 1.0)
        else:
            bx, by = arm(S[b + P.c], S[b + P.s], S[i + R.bearing_x], S[i + R.bearing_y])
            kx, ky = arm(S[k + P.c], S[k + P.s], S[i + R.journal_x], S[i + R.journal_y])
            if kind == REVOLUTE or kind == WELD:
                row(S, q, 1.0, 0.0, -by, -ky)
                row(S, q + Q.SIZE, 0.0, 1.0, bx, kx)
                if kind == WELD:
                    row(S, q + 2 * Q.SIZE, 0.0, 0.0, 1.0, 1.0)
            else:
                dx, dy = arm(S[b + P.c], S[b + P.s], S[i + R.direction_x], S[i + R.direction_y])
                nx = dx if kind == TRAVEL else -dy
                ny = dy if kind == TRAVEL else dx
                rx = (S[k + P.x] + kx) - S[b + P.x]
                ry = (S[k + P.y] + ky) - S[b + P.y]
                row(S, q, nx, ny, rx * ny - ry * nx, kx * ny - ky * nx)
                if kind == SLIDER:
                    row(S, q + Q.SIZE, 0.0, 0.0, 1.0, 1.0)


def ahead(S, I, after):
    """Position and direction of the driven bodies at t_(n+1)."""
    for m in range(I[H.driven_count]):
        r = I[H.driven] + JD.SIZE * m
        k = I[r + JD.row]
        i = I[r + JD.body]
        f = I[r + JD.function]
        angle = S[k + D.angle] + S[k + D.speed] * after if f == 0 else S[f + F.next]
        S[i + P.xn] = S[i + P.x]
        S[i + P.yn] = S[i + P.y]
        S[i + P.tn] = angle
        S[i + P.sn], S[i + P.cn] = sincos(angle)


def fill(S, I):
    """Lower half of the matrix G M^-1 G^T, summed over the bodies that two constraints share."""
    for q in range(I[H.profile_count]):
        S[I[H.profile] + q] = 0.0
    for m in range(I[H.couple_count]):
        r = I[H.couple] + JK.SIZE * m
        a = I[r + JK.first]
        c = I[r + JK.second]
        body = I[r + JK.body]
        x = I[r + JK.first_lever]
        y = I[r + JK.second_lever]
        im = S[body + P.inverse_mass]
        ii = S[body + P.inverse_inertia]
        sign = 1.0 if I[r + JK.same] != 0 else -1.0
        at = I[r + JK.at]
        if I[r + JK.pins] != 0:  # two revolutes: their four entries at once
            ax = S[x]
            ay = S[x + Q.SIZE]
            cx = sign * ii * S[y]
            cy = sign * ii * S[y + Q.SIZE]
            lower = I[r + JK.lower]
            S[at] += sign * im + ax * cx
            S[lower] += ay * cx
            S[lower + 1] += sign * im + ay * cy
            if a != c:
                S[at + 1] += ax * cy
        else:
            along = S[a + Q.nx] * S[c + Q.nx] + S[a + Q.ny] * S[c + Q.ny]
            S[at] += sign * (im * along + ii * S[x] * S[y])


def singular(S, I, dt):
    """Pivot, of what it was before elimination, below which a position counts as singular for the fastest turning pinned body."""
    spin = 0.0
    for q in range(I[H.pinned_count]):
        spin = larger(spin, abs(S[I[I[H.pinned] + q] + P.w]))
    share = SINGULAR * (dt * spin) * (dt * spin)
    return share if share < COARSE else COARSE


def factor(S, I, y, dt):
    """L D L^T of the matrix along its profile, in place, with the forward substitution of y on the way.

    A pivot lost to rounding (a redundant joint) is left out. Within some steps of a singular position, where the directions of two constraints
    become one, the pivot goes as the square of the angle that is left and changes by as much as itself in a step, so what a whole correction
    does is unbounded: there it is damped as in a least squares solution (Levenberg 1944), and inertia carries the mechanism through.
    """
    inverse = I[H.inverse]
    share = singular(S, I, dt)
    for r in range(I[H.row_count]):
        first = I[I[H.row] + JQ.SIZE * r + JQ.start]
        at = I[I[H.row] + JQ.SIZE * r + JQ.at]
        for c in range(first, r):
            other = I[I[H.row] + JQ.SIZE * c + JQ.at]
            start = max(first, I[I[H.row] + JQ.SIZE * c + JQ.start])
            value = S[at + c]
            for q in range(start, c):
                value -= S[at + q] * S[other + q]
            S[at + c] = value
        diagonal = S[at + r]
        left = diagonal
        wanted = S[y + r]
        for c in range(first, r):
            value = S[at + c]
            ratio = value * S[inverse + c]
            left -= value * ratio
            wanted -= ratio * S[y + c]
            S[at + c] = ratio
        least = share * diagonal
        S[inverse + r] = left / (left * left + least * least + 1e-300) if left > 1e-12 * diagonal else 0.0
        S[y + r] = wanted


def forward(S, I, y):
    """Forward substitution with the factors in place."""
    for r in range(I[H.row_count]):
        at = I[I[H.row] + JQ.SIZE * r + JQ.at]
        value = S[y + r]
        for c in range(I[I[H.row] + JQ.SIZE * r + JQ.start], r):
            value -= S[at + c] * S[y + c]
        S[y + r] = value


def backward(S, I, y):
    """Division by D and backward substitution."""
    for r in range(I[H.row_count]):
        S[y + r] = S[y + r] * S[I[H.inverse] + r]
    for q in range(I[H.row_count]):
        r = I[H.row_count] - 1 - q
        at = I[I[H.row] + JQ.SIZE * r + JQ.at]
        value = S[y + r]
        for c in range(I[I[H.row] + JQ.SIZE * r + JQ.start], r):
            S[y + c] -= S[at + c] * value


def pull(S, q, b, k, force):
    """Adds a reaction along constraint q: on the journal's body, and its opposite on the bearing's."""
    S[q + Q.force] += force
    px = force * S[q + Q.nx]
    py = force * S[q + Q.ny]
    S[k + P.fx] += px
    S[k + P.fy] += py
    S[k + P.mz] += force * S[q + Q.jk]
    S[b + P.fx] -= px
    S[b + P.fy] -= py
    S[b + P.mz] -= force * S[q + Q.jb]


def hang(S, q, b, k, fx, fy):
    """The same for the two constraints of a revolute, rows q and the next."""
    S[q + Q.force] += fx
    S[q + Q.SIZE + Q.force] += fy
    S[k + P.fx] += fx
    S[k + P.fy] += fy
    S[k + P.mz] += S[q + Q.jk] * fx + S[q + Q.SIZE + Q.jk] * fy
    S[b + P.fx] -= fx
    S[b + P.fy] -= fy
    S[b + P.mz] -= S[q + Q.jb] * fx + S[q + Q.SIZE + Q.jb] * fy


def guess(S, q):
    """Reaction that goes on as it did: with it the first correction closes the joints to third order in the step."""
    force = S[q + Q.force]
    before = S[q + Q.before]
    S[q + Q.before] = force
    S[q + Q.force] = 0.0
    return force + (force - before) if before != 0.0 else force


def recall(S, I):
    """Reactions to start from."""
    for m in range(I[H.ideal_count]):
        r = I[H.ideal] + JR.SIZE * m
        b = I[r + JR.bearing]
        k = I[r + JR.journal]
        q = I[r + JR.first]
        kind = I[r + JR.kind]
        if kind == REVOLUTE:
            fx = guess(S, q)
            fy = guess(S, q + Q.SIZE)
            hang(S, q, b, k, fx, fy)
        else:
            for c in range(I[r + JR.rows]):
                force = guess(S, q + c * Q.SIZE)
                pull(S, q + c * Q.SIZE, b, k, force)


def follow(S, I, dt, b, k):
    """Positions and directions at t_(n+1) of the pinned bodies under the forces so far."""
    for q in range(I[H.pinned_count]):
        i = I[I[H.pinned] + q]
        im = S[i + P.inverse_mass]
        S[i + P.xn] = S[i + P.x] + dt * (b * S[i + P.u] + k * (im * S[i + P.fx]))
        S[i + P.yn] = S[i + P.y] + dt * (b * S[i + P.v] + k * (im * S[i + P.fy]))
        angle = dt * (b * S[i + P.w] + k * (S[i + P.inverse_inertia] * S[i + P.mz]))
        S[i + P.tn] = S[i + P.theta] + angle
        S[i + P.cn], S[i + P.sn] = small_turn(S[i + P.c], S[i + P.s], angle)


def gaps(S, I):
    """What is missing in each constraint at t_(n+1)."""
    for m in range(I[H.ideal_count]):
        r = I[H.ideal] + JR.SIZE * m
        i = I[r + JR.row]
        p = I[r + JR.bearing]
        q = I[r + JR.journal]
        y = I[r + JR.y]
        f = I[r + JR.function]
        kind = I[r + JR.kind]
        aim = S[i + R.offset]
        if f != 0:
            aim += S[f + F.next]
        if kind == GEAR:
            S[y] = (S[q + P.tn] - S[i + R.ratio] * S[p + P.tn]) - aim
        elif kind == ANGLE:
            S[y] = (S[q + P.tn] - S[p + P.tn]) - aim
        else:
            bx, by = arm(S[p + P.cn], S[p + P.sn], S[i + R.bearing_x], S[i + R.bearing_y])
            kx, ky = arm(S[q + P.cn], S[q + P.sn], S[i + R.journal_x], S[i + R.journal_y])
            ex = (S[q + P.xn] + kx) - (S[p + P.xn] + bx)
            ey = (S[q + P.yn] + ky) - (S[p + P.yn] + by)
            if kind == REVOLUTE or kind == WELD:
                S[y] = ex
                S[y + 1] = ey
                if kind == WELD:
                    S[y + 2] = (S[q + P.tn] - S[p + P.tn]) - aim
            else:
                dx, dy = arm(S[p + P.cn], S[p + P.sn], S[i + R.direction_x], S[i + R.direction_y])
                if kind == TRAVEL:
                    S[y] = (ex * dx + ey * dy) - aim
                else:
                    S[y] = ey * dx - ex * dy
                if kind == SLIDER:
                    S[y + 1] = (S[q + P.tn] - S[p + P.tn]) - aim


def close(S, I, dt, b, k, fresh):
    """Corrects the reactions so that the joints are closed at t_(n+1); a ``fresh`` matrix is factored first."""
    y = I[H.y]
    follow(S, I, dt, b, k)
    gaps(S, I)
    if fresh:
        factor(S, I, y, dt)
    else:
        forward(S, I, y)
    backward(S, I, y)
    scale = -1.0 / (dt * k)
    for m in range(I[H.ideal_count]):
        r = I[H.ideal] + JR.SIZE * m
        b_ = I[r + JR.bearing]
        k_ = I[r + JR.journal]
        q = I[r + JR.first]
        at = I[r + JR.y]
        if I[r + JR.kind] == REVOLUTE:
            hang(S, q, b_, k_, scale * S[at], scale * S[at + 1])
        else:
            for c in range(I[r + JR.rows]):
                pull(S, q + c * Q.SIZE, b_, k_, scale * S[at + c])


def turn_with(S, i, moment):
    """Moment of a joint at t_n, and the largest."""
    S[i + R.moment] = moment
    at = i + R.moment_max
    S[at] = larger(S[at], abs(moment))


def reaction(S, I, r):
    """Force and moment on the journal at t_n, from the constraints of a joint."""
    i = I[r + JR.row]
    q = I[r + JR.first]
    kind = I[r + JR.kind]
    force = S[q + Q.force]
    if kind == GEAR or kind == ANGLE:
        turn_with(S, i, force)
    elif kind == REVOLUTE or kind == WELD:
        S[i + R.fx] = force
        S[i + R.fy] = S[q + Q.SIZE + Q.force]
        if kind == WELD:
            turn_with(S, i, S[q + 2 * Q.SIZE + Q.force])
    else:
        S[i + R.fx] = force * S[q + Q.nx]
        S[i + R.fy] = force * S[q + Q.ny]
        if kind == SLIDER:
            turn_with(S, i, S[q + Q.SIZE + Q.force])


def spread(S, I, w, y, b, k, fx, fy, mk, mb):
    """Velocities (from row P.rn or P.rt of each body) per unit of a force pair: f and mk on k, -f and -mb on b, all pinned bodies along."""
    for q in range(I[H.jointed_count]):
        i = I[I[H.jointed] + q]
        S[i + w] = 0.0
        S[i + w + 1] = 0.0
        S[i + w + 2] = 0.0
    S[k + w] = S[k + P.inverse_mass] * fx
    S[k + w + 1] = S[k + P.inverse_mass] * fy
    S[k + w + 2] = S[k + P.inverse_inertia] * mk
    S[b + w] = -S[b + P.inverse_mass] * fx
    S[b + w + 1] = -S[b + P.inverse_mass] * fy
    S[b + w + 2] = -S[b + P.inverse_inertia] * mb
    for m in range(I[H.row_count]):
        r = I[H.row] + JQ.SIZE * m
        i = I[r + JQ.row]
        p = I[r + JQ.bearing] + w
        q = I[r + JQ.journal] + w
        nx = S[i + Q.nx]
        ny = S[i + Q.ny]
        S[y + m] = (nx * S[q] + ny * S[q + 1] + S[i + Q.jk] * S[q + 2]) - (nx * S[p] + ny * S[p + 1] + S[i + Q.jb] * S[p + 2])
    forward(S, I, y)
    backward(S, I, y)
    for m in range(I[H.row_count]):
        r = I[H.row] + JQ.SIZE * m
        i = I[r + JQ.row]
        p = I[r + JQ.bearing]
        q = I[r + JQ.journal]
        gx = S[y + m] * S[i + Q.nx]
        gy = S[y + m] * S[i + Q.ny]
        S[q + w] -= S[q + P.inverse_mass] * gx
        S[q + w + 1] -= S[q + P.inverse_mass] * gy
        S[q + w + 2] -= S[q + P.inverse_inertia] * (S[y + m] * S[i + Q.jk])
        S[p + w] += S[p + P.inverse_mass] * gx
        S[p + w + 1] += S[p + P.inverse_mass] * gy
        S[p + w + 2] += S[p + P.inverse_inertia] * (S[y + m] * S[i + Q.jb])


def respond(S, I, j, b, k):
    """Inverse masses (1/kg) of clearance joint j along n and t, and their coupling, where its bodies hang in ideal joints."""
    nx = S[j + C.nx]
    ny = S[j + C.ny]
    jn = S[j + C.jn]
    jt = S[j + C.jt]
    bn = S[j + C.bn]
    bt = S[j + C.bt]
    spread(S, I, P.rn, I[H.gn], b, k, nx, ny, jn, bn)
    spread(S, I, P.rt, I[H.gt], b, k, -ny, nx, jt, bt)
    nu = S[k + P.rn] - S[b + P.rn]
    nv = S[k + P.rn + 1] - S[b + P.rn + 1]
    tu = S[k + P.rt] - S[b + P.rt]
    tv = S[k + P.rt + 1] - S[b + P.rt + 1]
    gn = nx * nu + ny * nv + jn * S[k + P.rn + 2] - bn * S[b + P.rn + 2]
    gt = nx * tv - ny * tu + jt * S[k + P.rt + 2] - bt * S[b + P.rt + 2]
    gm = nx * nv - ny * nu + jt * S[k + P.rn + 2] - bt * S[b + P.rn + 2]
    return gn, gt, gm


def hold(S, I, h, normal, friction):
    """Velocities at t_n and reactions after a change of the force in the clearance joint that ``respond`` was last asked about."""
    for q in range(I[H.jointed_count]):
        i = I[I[H.jointed] + q]
        S[i + P.vu] += h * (friction * S[i + P.rt] - normal * S[i + P.rn])
        S[i + P.vv] += h * (friction * S[i + P.rt + 1] - normal * S[i + P.rn + 1])
        S[i + P.vw] += h * (friction * S[i + P.rt + 2] - normal * S[i + P.rn + 2])
    for m in range(I[H.row_count]):
        r = I[H.row] + JQ.SIZE * m
        force = normal * S[I[H.gn] + m] - friction * S[I[H.gt] + m]
        pull(S, I[r + JQ.row], I[r + JQ.bearing], I[r + JQ.journal], force)
