"""Ideal joints (paper Eq. 14-17, generalised): reactions that keep what is joined joined, one row for each
constraint.

For two particles alone the block of a revolute is (1/m_B + 1/m_J) and its solution is Eq. 16 with external
forces. Equal accelerations alone let positions drift, so the reaction at t_n is the one that closes the joint
at t_(n+1) (SHAKE: Ryckaert, Ciccotti and Berendsen 1977). Where bodies carry several joints the rows couple;
they are factored along the profile of the joint graph, never as a matrix of the mechanism.

A row has a direction n and a lever on each body: its rate is n (v_k - v_b) + jk w_k - jb w_b, less jc w_c
where a third body carries gears. A joint holds a place, a turn or both: a revolute has a row for x and one
for y, a slider one across its guide and one for the turn, a weld all three, a pin on a path one across it, a
massless link one along it, gears and prescribed angles one for the turn with n = 0.
"""

from .arrays import CONSTRAINT, CONSTRAINT_INDEX, CONTACT, HEADER, JOINT, JOINT_INDEX, PARTICLE
from .central_difference import larger
from .factors import solve
from .frame import chord
from .geometry import arm, from_path
from .topology import ALONG, APART, FREE, GEARED, NOWHERE, ON_PATH, PINNED


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
    """What a row along or across a guide, from a path or along a massless link measures (m), and its
    direction in space.

    (ex, ey) is the journal's pin seen from the bearing's, in space; (c, s) the direction of the bearing's
    body, (dx, dy) that of the guide in it.
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
    """What a row of the turn measures (rad): (journal - carrier) - ratio (bearing - carrier), Willis'
    formula.
    """
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


def gear_reaction(S, q, c, force):
    """The moment of a reaction along constraint q on the body c that carries its gears."""
    S[c + PARTICLE.mz] -= force * S[q + CONSTRAINT.jc]


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
    """Velocities (rows from PARTICLE.rn or .rt of each body) per unit of a force pair: f and mk on k, -f and
    -mb on b, all pinned bodies along.
    """
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
        S[y + m] = (nx * S[q] + ny * S[q + 1] + S[i + CONSTRAINT.jk] * S[q + 2]) - (
            nx * S[p] + ny * S[p + 1] + S[i + CONSTRAINT.jb] * S[p + 2]
        )
        c = I[r + CONSTRAINT_INDEX.carrier]
        if c != 0:
            S[y + m] -= S[i + CONSTRAINT.jc] * S[c + w + 2]
    solve(S, I, y)
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
    """Inverse masses (1/kg) of clearance joint j along n and t, and their coupling, where its bodies hang in
    ideal joints.
    """
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
    """Velocities at t_n and reactions after a change of the force in the clearance joint of the last
    :func:`joint_compliance`.
    """
    for q in range(I[HEADER.jointed_count]):
        i = I[I[HEADER.jointed] + q]
        S[i + PARTICLE.vu] += h * (friction * S[i + PARTICLE.rt] - normal * S[i + PARTICLE.rn])
        S[i + PARTICLE.vv] += h * (friction * S[i + PARTICLE.rt + 1] - normal * S[i + PARTICLE.rn + 1])
        S[i + PARTICLE.vw] += h * (friction * S[i + PARTICLE.rt + 2] - normal * S[i + PARTICLE.rn + 2])
    for m in range(I[HEADER.constraint_count]):
        r = I[HEADER.constraint] + CONSTRAINT_INDEX.SIZE * m
        force = normal * S[I[HEADER.gn] + m] - friction * S[I[HEADER.gt] + m]
        pull(
            S,
            I[r + CONSTRAINT_INDEX.row],
            I[r + CONSTRAINT_INDEX.bearing],
            I[r + CONSTRAINT_INDEX.journal],
            force,
        )
        if I[r + CONSTRAINT_INDEX.carrier] != 0:
            gear_reaction(S, I[r + CONSTRAINT_INDEX.row], I[r + CONSTRAINT_INDEX.carrier], force)
