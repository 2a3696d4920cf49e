"""Ideal joints (paper Eq. 14-17, generalised): reactions that keep what is joined joined, one row for each constraint.

For two particles alone the block of a revolute is (1/m_B + 1/m_J) and its solution is Eq. 16 with external forces. Equal accelerations alone
let positions drift, so the reaction at t_n is the one that closes the joint at t_(n+1) (SHAKE: Ryckaert, Ciccotti and Berendsen 1977). Where
bodies carry several joints the rows couple; they are factored along the profile of the joint graph, never as a matrix of the mechanism.

A row has a direction n and a lever on each body: its rate is n (v_k - v_b) + jk w_k - jb w_b, less jc w_c where a third body carries gears. A joint
holds a place, a turn or both: a revolute has a row for x and one for y, a slider one across its guide and one for the turn, a weld all three, a pin
on a path one across it, a massless link one along it, gears and prescribed angles one for the turn with n = 0.
"""

from .arrays import CONSTRAINT, CONSTRAINT_INDEX, CONTACT, COUPLE_INDEX, DRIVEN, DRIVEN_INDEX, FUNCTION, HEADER, JOINT, JOINT_INDEX, PARTICLE
from .central_difference import larger
from .elementary import sincos, small_turn
from .frame import chord
from .geometry import arm
from .path import from_path
from .topology import ALONG, APART, FREE, GEARED, NOWHERE, ON_PATH, PINNED

SINGULAR = 64.0  # pivot in squared turns of a step (of what it was before elimination) below which its correction is damped: eight steps away
COARSE = 1e-3  # the largest such pivot


def row(S, q, nx, ny, jb, jk):
    """Direction and levers of a constraint."""
    S[q + CONSTRAINT.nx] = nx
    S[q + CONSTRAINT.ny] = ny
    S[q + CONSTRAINT.jb] = jb
    S[q + CONSTRAINT.jk] = jk


def lever(rx, ry, nx, ny):
    """Moment of a unit force along n at (rx, ry)."""
    return rx * ny - ry * nx


def placed(S, place, piece, pieces, c, s, dx, dy, ex, ey):
    """What a row along or across a guide, from a path or along a massless link measures (m), and its direction in space.

    (ex, ey) is the journal's pin seen from the bearing's, in space; (c, s) the direction of the bearing's body, (dx, dy) that of the guide in it.
    """
    if place == ON_PATH:
        measured, nx, ny = from_path(S, piece, pieces, c * ex + s * ey, c * ey - s * ex)
        nx, ny = arm(c, s, nx, ny)
    elif place == APART:
        measured, _, nx, ny = chord(ex, ey)
    else:
        ux, uy = arm(c, s, dx, dy)
        nx = ux if place == ALONG else -uy
        ny = uy if place == ALONG else ux
        measured = ex * nx + ey * ny
    return measured, nx, ny


def relative_turn(bearing, journal, ratio, carrier):
    """What a row of the turn measures (rad): (journal - carrier) - ratio (bearing - carrier), Willis' formula."""
    return (journal - ratio * bearing) - (1.0 - ratio) * carrier


def levers(S, I):
    """Directions and levers of all constraints at t_n."""
    for m in range(I[HEADER.joint_count]):
        r = I[HEADER.joint] + JOINT_INDEX.SIZE * m
        i = I[r + JOINT_INDEX.row]
        b = I[r + JOINT_INDEX.bearing]
        k = I[r + JOINT_INDEX.journal]
        q = I[r + JOINT_INDEX.first]
        place = I[r + JOINT_INDEX.place]
        turn = I[r + JOINT_INDEX.turn]
        if place != NOWHERE:
            bx, by = arm(S[b + PARTICLE.c], S[b + PARTICLE.s], S[i + JOINT.bearing_x], S[i + JOINT.bearing_y])
            kx, ky = arm(S[k + PARTICLE.c], S[k + PARTICLE.s], S[i + JOINT.journal_x], S[i + JOINT.journal_y])
            if place == PINNED:
                row(S, q, 1.0, 0.0, -by, -ky)
                row(S, q + CONSTRAINT.SIZE, 0.0, 1.0, bx, kx)
            else:
                rx = (S[k + PARTICLE.x] + kx) - S[b + PARTICLE.x]
                ry = (S[k + PARTICLE.y] + ky) - S[b + PARTICLE.y]
                _, nx, ny = placed(
                    S, place, I[r + JOINT_INDEX.piece], I[r + JOINT_INDEX.pieces], S[b + PARTICLE.c], S[b + PARTICLE.s],
                    S[i + JOINT.direction_x], S[i + JOINT.direction_y], rx - bx, ry - by,
                )  # fmt: skip
                row(S, q, nx, ny, lever(rx, ry, nx, ny), lever(kx, ky, nx, ny))
        if turn != FREE:
            q = q + CONSTRAINT.SIZE * (I[r + JOINT_INDEX.rows] - 1)
            row(S, q, 0.0, 0.0, S[i + JOINT.ratio] if turn == GEARED else 1.0, 1.0)
            if I[r + JOINT_INDEX.carrier] != 0:
                S[q + CONSTRAINT.jc] = 1.0 - S[i + JOINT.ratio]


def ahead(S, I, after):
    """Position and direction of the driven bodies at t_(n+1)."""
    for m in range(I[HEADER.driven_count]):
        r = I[HEADER.driven] + DRIVEN_INDEX.SIZE * m
        k = I[r + DRIVEN_INDEX.row]
        i = I[r + DRIVEN_INDEX.body]
        f = I[r + DRIVEN_INDEX.function]
        angle = S[k + DRIVEN.angle] + S[k + DRIVEN.speed] * after if f == 0 else S[f + FUNCTION.next]
        S[i + PARTICLE.xn] = S[i + PARTICLE.x]
        S[i + PARTICLE.yn] = S[i + PARTICLE.y]
        S[i + PARTICLE.tn] = angle
        S[i + PARTICLE.sn], S[i + PARTICLE.cn] = sincos(angle)


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


def singular(S, I, dt):
    """Pivot, of what it was before elimination, below which a position counts as singular for the fastest turning pinned body."""
    spin = 0.0
    for q in range(I[HEADER.pinned_count]):
        spin = larger(spin, abs(S[I[I[HEADER.pinned] + q] + PARTICLE.w]))
    share = SINGULAR * (dt * spin) * (dt * spin)
    return share if share < COARSE else COARSE


def factor(S, I, y, dt):
    """L D L^T of the matrix along its profile, in place, with the forward substitution of y on the way.

    A pivot lost to rounding (a redundant joint) is left out. Within some steps of a singular position, where the directions of two constraints
    become one, the pivot goes as the square of the angle that is left and changes by as much as itself in a step, so what a whole correction
    does is unbounded: there it is damped as in a least squares solution (Levenberg 1944), and inertia carries the mechanism through.
    """
    inverse = I[HEADER.inverse]
    share = singular(S, I, dt)
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


def pull(S, q, b, k, force):
    """Adds a reaction along constraint q: on the journal's body, and its opposite on the bearing's."""
    S[q + CONSTRAINT.force] += force
    px = force * S[q + CONSTRAINT.nx]
    py = force * S[q + CONSTRAINT.ny]
    S[k + PARTICLE.fx] += px
    S[k + PARTICLE.fy] += py
    S[k + PARTICLE.mz] += force * S[q + CONSTRAINT.jk]
    S[b + PARTICLE.fx] -= px
    S[b + PARTICLE.fy] -= py
    S[b + PARTICLE.mz] -= force * S[q + CONSTRAINT.jb]


def carry(S, q, c, force):
    """The moment of a reaction along constraint q on the body c that carries its gears."""
    S[c + PARTICLE.mz] -= force * S[q + CONSTRAINT.jc]


def hang(S, q, b, k, fx, fy):
    """The same for the two constraints of a revolute, rows q and the next."""
    S[q + CONSTRAINT.force] += fx
    S[q + CONSTRAINT.SIZE + CONSTRAINT.force] += fy
    S[k + PARTICLE.fx] += fx
    S[k + PARTICLE.fy] += fy
    S[k + PARTICLE.mz] += S[q + CONSTRAINT.jk] * fx + S[q + CONSTRAINT.SIZE + CONSTRAINT.jk] * fy
    S[b + PARTICLE.fx] -= fx
    S[b + PARTICLE.fy] -= fy
    S[b + PARTICLE.mz] -= S[q + CONSTRAINT.jb] * fx + S[q + CONSTRAINT.SIZE + CONSTRAINT.jb] * fy


def guess(S, q):
    """Reaction that goes on as it did: with it the first correction closes the joints to third order in the step."""
    force = S[q + CONSTRAINT.force]
    before = S[q + CONSTRAINT.before]
    S[q + CONSTRAINT.before] = force
    S[q + CONSTRAINT.force] = 0.0
    return force + (force - before) if before != 0.0 else force


def warm_start(S, I):
    """Reactions to start from."""
    for m in range(I[HEADER.joint_count]):
        r = I[HEADER.joint] + JOINT_INDEX.SIZE * m
        b = I[r + JOINT_INDEX.bearing]
        k = I[r + JOINT_INDEX.journal]
        q = I[r + JOINT_INDEX.first]
        if I[r + JOINT_INDEX.place] == PINNED and I[r + JOINT_INDEX.turn] == FREE:
            fx = guess(S, q)
            fy = guess(S, q + CONSTRAINT.SIZE)
            hang(S, q, b, k, fx, fy)
        else:
            for c in range(I[r + JOINT_INDEX.rows]):
                force = guess(S, q + c * CONSTRAINT.SIZE)
                pull(S, q + c * CONSTRAINT.SIZE, b, k, force)
                if I[r + JOINT_INDEX.carrier] != 0:
                    carry(S, q + c * CONSTRAINT.SIZE, I[r + JOINT_INDEX.carrier], force)


def predict(S, I, dt, b, k):
    """Positions and directions at t_(n+1) of the pinned bodies under the forces so far."""
    for q in range(I[HEADER.pinned_count]):
        i = I[I[HEADER.pinned] + q]
        im = S[i + PARTICLE.inverse_mass]
        S[i + PARTICLE.xn] = S[i + PARTICLE.x] + dt * (b * S[i + PARTICLE.u] + k * (im * S[i + PARTICLE.fx]))
        S[i + PARTICLE.yn] = S[i + PARTICLE.y] + dt * (b * S[i + PARTICLE.v] + k * (im * S[i + PARTICLE.fy]))
        angle = dt * (b * S[i + PARTICLE.w] + k * (S[i + PARTICLE.inverse_inertia] * S[i + PARTICLE.mz]))
        S[i + PARTICLE.tn] = S[i + PARTICLE.theta] + angle
        S[i + PARTICLE.cn], S[i + PARTICLE.sn] = small_turn(S[i + PARTICLE.c], S[i + PARTICLE.s], angle)


def residual(S, I):
    """What is missing in each constraint at t_(n+1)."""
    for m in range(I[HEADER.joint_count]):
        r = I[HEADER.joint] + JOINT_INDEX.SIZE * m
        i = I[r + JOINT_INDEX.row]
        p = I[r + JOINT_INDEX.bearing]
        q = I[r + JOINT_INDEX.journal]
        y = I[r + JOINT_INDEX.y]
        f = I[r + JOINT_INDEX.function]
        place = I[r + JOINT_INDEX.place]
        turn = I[r + JOINT_INDEX.turn]
        aim = S[i + JOINT.offset]
        if f != 0:
            aim += S[f + FUNCTION.next]
        if place != NOWHERE:
            bx, by = arm(S[p + PARTICLE.cn], S[p + PARTICLE.sn], S[i + JOINT.bearing_x], S[i + JOINT.bearing_y])
            kx, ky = arm(S[q + PARTICLE.cn], S[q + PARTICLE.sn], S[i + JOINT.journal_x], S[i + JOINT.journal_y])
            ex = (S[q + PARTICLE.xn] + kx) - (S[p + PARTICLE.xn] + bx)
            ey = (S[q + PARTICLE.yn] + ky) - (S[p + PARTICLE.yn] + by)
            if place == PINNED:
                S[y] = ex
                S[y + 1] = ey
            else:
                measured, _, _ = placed(
                    S, place, I[r + JOINT_INDEX.piece], I[r + JOINT_INDEX.pieces], S[p + PARTICLE.cn], S[p + PARTICLE.sn],
                    S[i + JOINT.direction_x], S[i + JOINT.direction_y], ex, ey,
                )  # fmt: skip
                S[y] = measured - aim if place == ALONG or place == APART else measured
        if turn != FREE:
            y = y + (I[r + JOINT_INDEX.rows] - 1)
            ratio = S[i + JOINT.ratio] if turn == GEARED else 1.0
            c = I[r + JOINT_INDEX.carrier]
            S[y] = relative_turn(S[p + PARTICLE.tn], S[q + PARTICLE.tn], ratio, S[c + PARTICLE.tn] if c != 0 else 0.0) - aim


def close(S, I, dt, b, k, fresh):
    """Corrects the reactions so that the joints are closed at t_(n+1); a ``fresh`` matrix is factored first."""
    y = I[HEADER.y]
    predict(S, I, dt, b, k)
    residual(S, I)
    if fresh:
        factor(S, I, y, dt)
    else:
        forward(S, I, y)
    backward(S, I, y)
    scale = -1.0 / (dt * k)
    for m in range(I[HEADER.joint_count]):
        r = I[HEADER.joint] + JOINT_INDEX.SIZE * m
        b_ = I[r + JOINT_INDEX.bearing]
        k_ = I[r + JOINT_INDEX.journal]
        q = I[r + JOINT_INDEX.first]
        at = I[r + JOINT_INDEX.y]
        if I[r + JOINT_INDEX.place] == PINNED and I[r + JOINT_INDEX.turn] == FREE:
            hang(S, q, b_, k_, scale * S[at], scale * S[at + 1])
        else:
            for c in range(I[r + JOINT_INDEX.rows]):
                pull(S, q + c * CONSTRAINT.SIZE, b_, k_, scale * S[at + c])
                if I[r + JOINT_INDEX.carrier] != 0:
                    carry(S, q + c * CONSTRAINT.SIZE, I[r + JOINT_INDEX.carrier], scale * S[at + c])


def turn_with(S, i, moment):
    """Moment of a joint at t_n, and the largest."""
    S[i + JOINT.moment] = moment
    at = i + JOINT.moment_max
    S[at] = larger(S[at], abs(moment))


def reaction(S, I, r):
    """Force and moment on the journal at t_n, from the constraints of a joint."""
    i = I[r + JOINT_INDEX.row]
    q = I[r + JOINT_INDEX.first]
    place = I[r + JOINT_INDEX.place]
    if place == PINNED:
        S[i + JOINT.fx] = S[q + CONSTRAINT.force]
        S[i + JOINT.fy] = S[q + CONSTRAINT.SIZE + CONSTRAINT.force]
    elif place != NOWHERE:
        S[i + JOINT.fx] = S[q + CONSTRAINT.force] * S[q + CONSTRAINT.nx]
        S[i + JOINT.fy] = S[q + CONSTRAINT.force] * S[q + CONSTRAINT.ny]
    if I[r + JOINT_INDEX.turn] != FREE:
        turn_with(S, i, S[q + CONSTRAINT.SIZE * (I[r + JOINT_INDEX.rows] - 1) + CONSTRAINT.force])


def spread(S, I, w, y, b, k, fx, fy, mk, mb):
    """Velocities (rows from PARTICLE.rn or .rt of each body) per unit of a force pair: f and mk on k, -f and -mb on b, all pinned bodies along."""
    for q in range(I[HEADER.jointed_count]):
        i = I[I[HEADER.jointed] + q]
        S[i + w] = 0.0
        S[i + w + 1] = 0.0
        S[i + w + 2] = 0.0
    S[k + w] = S[k + PARTICLE.inverse_mass] * fx
    S[k + w + 1] = S[k + PARTICLE.inverse_mass] * fy
    S[k + w + 2] = S[k + PARTICLE.inverse_inertia] * mk
    S[b + w] = -S[b + PARTICLE.inverse_mass] * fx
    S[b + w + 1] = -S[b + PARTICLE.inverse_mass] * fy
    S[b + w + 2] = -S[b + PARTICLE.inverse_inertia] * mb
    for m in range(I[HEADER.constraint_count]):
        r = I[HEADER.constraint] + CONSTRAINT_INDEX.SIZE * m
        i = I[r + CONSTRAINT_INDEX.row]
        p = I[r + CONSTRAINT_INDEX.bearing] + w
        q = I[r + CONSTRAINT_INDEX.journal] + w
        nx = S[i + CONSTRAINT.nx]
        ny = S[i + CONSTRAINT.ny]
        S[y + m] = (nx * S[q] + ny * S[q + 1] + S[i + CONSTRAINT.jk] * S[q + 2]) - (nx * S[p] + ny * S[p + 1] + S[i + CONSTRAINT.jb] * S[p + 2])
        c = I[r + CONSTRAINT_INDEX.carrier]
        if c != 0:
            S[y + m] -= S[i + CONSTRAINT.jc] * S[c + w + 2]
    forward(S, I, y)
    backward(S, I, y)
    for m in range(I[HEADER.constraint_count]):
        r = I[HEADER.constraint] + CONSTRAINT_INDEX.SIZE * m
        i = I[r + CONSTRAINT_INDEX.row]
        p = I[r + CONSTRAINT_INDEX.bearing]
        q = I[r + CONSTRAINT_INDEX.journal]
        gx = S[y + m] * S[i + CONSTRAINT.nx]
        gy = S[y + m] * S[i + CONSTRAINT.ny]
        S[q + w] -= S[q + PARTICLE.inverse_mass] * gx
        S[q + w + 1] -= S[q + PARTICLE.inverse_mass] * gy
        S[q + w + 2] -= S[q + PARTICLE.inverse_inertia] * (S[y + m] * S[i + CONSTRAINT.jk])
        S[p + w] += S[p + PARTICLE.inverse_mass] * gx
        S[p + w + 1] += S[p + PARTICLE.inverse_mass] * gy
        S[p + w + 2] += S[p + PARTICLE.inverse_inertia] * (S[y + m] * S[i + CONSTRAINT.jb])
        c = I[r + CONSTRAINT_INDEX.carrier]
        if c != 0:
            S[c + w + 2] += S[c + PARTICLE.inverse_inertia] * (S[y + m] * S[i + CONSTRAINT.jc])


def joint_compliance(S, I, j, b, k):
    """Inverse masses (1/kg) of clearance joint j along n and t, and their coupling, where its bodies hang in ideal joints."""
    nx = S[j + CONTACT.nx]
    ny = S[j + CONTACT.ny]
    jn = S[j + CONTACT.jn]
    jt = S[j + CONTACT.jt]
    bn = S[j + CONTACT.bn]
    bt = S[j + CONTACT.bt]
    spread(S, I, PARTICLE.rn, I[HEADER.gn], b, k, nx, ny, jn, bn)
    spread(S, I, PARTICLE.rt, I[HEADER.gt], b, k, -ny, nx, jt, bt)
    nu = S[k + PARTICLE.rn] - S[b + PARTICLE.rn]
    nv = S[k + PARTICLE.rn + 1] - S[b + PARTICLE.rn + 1]
    tu = S[k + PARTICLE.rt] - S[b + PARTICLE.rt]
    tv = S[k + PARTICLE.rt + 1] - S[b + PARTICLE.rt + 1]
    gn = nx * nu + ny * nv + jn * S[k + PARTICLE.rn + 2] - bn * S[b + PARTICLE.rn + 2]
    gt = nx * tv - ny * tu + jt * S[k + PARTICLE.rt + 2] - bt * S[b + PARTICLE.rt + 2]
    gm = nx * nv - ny * nu + jt * S[k + PARTICLE.rn + 2] - bt * S[b + PARTICLE.rn + 2]
    return gn, gt, gm


def apply_response(S, I, h, normal, friction):
    """Velocities at t_n and reactions after a change of the force in the clearance joint that ``respond`` was last asked about."""
    for q in range(I[HEADER.jointed_count]):
        i = I[I[HEADER.jointed] + q]
        S[i + PARTICLE.vu] += h * (friction * S[i + PARTICLE.rt] - normal * S[i + PARTICLE.rn])
        S[i + PARTICLE.vv] += h * (friction * S[i + PARTICLE.rt + 1] - normal * S[i + PARTICLE.rn + 1])
        S[i + PARTICLE.vw] += h * (friction * S[i + PARTICLE.rt + 2] - normal * S[i + PARTICLE.rn + 2])
    for m in range(I[HEADER.constraint_count]):
        r = I[HEADER.constraint] + CONSTRAINT_INDEX.SIZE * m
        force = normal * S[I[HEADER.gn] + m] - friction * S[I[HEADER.gt] + m]
        pull(S, I[r + CONSTRAINT_INDEX.row], I[r + CONSTRAINT_INDEX.bearing], I[r + CONSTRAINT_INDEX.journal], force)
        if I[r + CONSTRAINT_INDEX.carrier] != 0:
            carry(S, I[r + CONSTRAINT_INDEX.row], I[r + CONSTRAINT_INDEX.carrier], force)
