"""Constraints of ideal joints: their directions and levers, and the forces and velocities that reactions
cause (paper Eq. 14-17, generalised).

For two single particles the matrix of a revolute is (1/m_B + 1/m_J), and its solution is Eq. 16 with external
forces. Equal accelerations alone would let positions drift. The reaction at t_n is therefore the one that
closes the joint at t_(n+1) (SHAKE: Ryckaert, Ciccotti and Berendsen 1977). Where a body carries several
joints their rows couple; the coupled rows are factored along the profile of the joint graph.

A row has a direction n and a lever on each body. Its rate is n (v_k - v_b) + jk w_k - jb w_b, minus jc w_c if
a third body carries gears. A joint holds a place, a turn, or both: a revolute has a row for x and one for y;
a slider one across its guide and one for the turn; a weld all three; a pin on a path one across it; a
massless link one along it; gears and prescribed angles one for the turn, with n = 0.

Names here, in :mod:`~vfife.kernels.closing` and in :mod:`~vfife.kernels.factors`: r is a record in I, of a
joint or a constraint. j, q, b, k, c and i are rows in S: of a joint, of a constraint, of the particles of
bearing and journal, of the carrier of gears (0 for none), and of any particle. y is the first row of a
right-hand side.
"""

from typing import NamedTuple

from .arrays import CONSTRAINT, CONSTRAINT_INDEX, HEADER, JOINT, JOINT_INDEX, PARTICLE
from .central_difference import larger
from .factors import solve
from .frame import chord
from .geometry import arm, from_path
from .topology import ALONG_LINE, FREE, GEARED, ON_PATH, PINNED, SPACED, UNPLACED


class Row(NamedTuple):
    """Direction (1) and levers (m) of a constraint, of a contact's n or t, or of a spring's axis, on bearing
    and journal, or first and second body.
    """

    nx: float
    ny: float
    jb: float
    jk: float


def bodies(I, r):
    """Return the first three entries of record r: the rows in S of the contact, joint or constraint, of its
    bearing's particle and of its journal's.
    """
    return I[r + JOINT_INDEX.row], I[r + JOINT_INDEX.bearing], I[r + JOINT_INDEX.journal]


def set_row(S, q, nx, ny, jb, jk):
    """Store direction and levers of constraint q, or their change in a step (q + TURN), with a zero lever on
    a carrier of gears.
    """
    S[q + CONSTRAINT.nx] = nx
    S[q + CONSTRAINT.ny] = ny
    S[q + CONSTRAINT.jb] = jb
    S[q + CONSTRAINT.jk] = jk
    S[q + CONSTRAINT.jc] = 0.0


def lever(rx, ry, nx, ny):
    """Return the moment (m) of a unit force along n at (rx, ry)."""
    return rx * ny - ry * nx


class Guide(NamedTuple):
    """The line that holds a pin: the kind of place, the first row and the number of a path's pieces, and the
    direction of a guide in the bearing's body.
    """

    place: int
    piece: int
    pieces: int
    dx: float
    dy: float


def guide_of(S, I, r) -> Guide:
    """Return the guide of joint r."""
    j = I[r + JOINT_INDEX.row]
    return Guide(
        I[r + JOINT_INDEX.place], I[r + JOINT_INDEX.piece], I[r + JOINT_INDEX.pieces],
        S[j + JOINT.direction_x], S[j + JOINT.direction_y]
    )  # fmt: skip


def guide_row(S, guide: Guide, c, s, ex, ey):
    """Return the quantity (m) that the row of a guide, a path or a massless link measures, and the row's
    direction in space: the distance across or along a guide, the distance from a path, or a link's length.

    (ex, ey) is the journal's pin seen from the bearing's, in space (m); (c, s) are the direction cosines of
    the bearing's body.
    """
    if guide.place == ON_PATH:
        measured, nx, ny = from_path(S, guide.piece, guide.pieces, c * ex + s * ey, c * ey - s * ex)
        nx, ny = arm(c, s, nx, ny)
    elif guide.place == SPACED:
        measured, _, nx, ny = chord(ex, ey)
    else:
        ux, uy = arm(c, s, guide.dx, guide.dy)
        nx = ux if guide.place == ALONG_LINE else -uy
        ny = uy if guide.place == ALONG_LINE else ux
        measured = ex * nx + ey * ny
    return measured, nx, ny


def relative_turn(bearing, journal, ratio, carrier):
    """Return the angle (rad) that a row of a turn measures: (journal - carrier) - ratio (bearing - carrier),
    the formula of Willis for epicyclic gears. A ratio of 1 drops the carrier.
    """
    return (journal - ratio * bearing) - (1.0 - ratio) * carrier


def levers(S, I):
    """Store directions and levers of all constraints at t_n."""
    for r in range(I[HEADER.joint], I[HEADER.joint_end], JOINT_INDEX.SIZE):
        j, b, k = bodies(I, r)
        q = I[r + JOINT_INDEX.first]
        place = I[r + JOINT_INDEX.place]
        turn = I[r + JOINT_INDEX.turn]
        if place != UNPLACED:
            bx, by = arm(S[b + PARTICLE.c], S[b + PARTICLE.s], S[j + JOINT.bearing_x], S[j + JOINT.bearing_y])
            kx, ky = arm(S[k + PARTICLE.c], S[k + PARTICLE.s], S[j + JOINT.journal_x], S[j + JOINT.journal_y])
            if place == PINNED:
                set_row(S, q, 1.0, 0.0, -by, -ky)
                set_row(S, q + CONSTRAINT.SIZE, 0.0, 1.0, bx, kx)
            else:
                # The force of a guide acts at the journal's pin, on both bodies: (rx, ry) is that point seen
                # from the bearing's particle.
                rx = (S[k + PARTICLE.x] + kx) - S[b + PARTICLE.x]
                ry = (S[k + PARTICLE.y] + ky) - S[b + PARTICLE.y]
                _, nx, ny = guide_row(
                    S, guide_of(S, I, r), S[b + PARTICLE.c], S[b + PARTICLE.s], rx - bx, ry - by
                )
                set_row(S, q, nx, ny, lever(rx, ry, nx, ny), lever(kx, ky, nx, ny))
        if turn != FREE:
            q = q + CONSTRAINT.SIZE * (I[r + JOINT_INDEX.rows] - 1)  # the row of the turn is the joint's last
            set_row(S, q, 0.0, 0.0, S[j + JOINT.ratio] if turn == GEARED else 1.0, 1.0)
            if I[r + JOINT_INDEX.carrier] != 0:
                S[q + CONSTRAINT.jc] = 1.0 - S[j + JOINT.ratio]


def apply_reaction(S, I, r, q, at, force):
    """Add a reaction ``force`` (N, N m) along constraint q of record r to the journal's body, its opposite to
    the bearing's, and the moment of gears to their carrier.

    ``at`` is the first of the three rows of a particle to which it is added: PARTICLE.fx for the forces,
    PARTICLE.change_x for the sum of a correction.
    """
    _, b, k = bodies(I, r)
    c = I[r + JOINT_INDEX.carrier]
    px = force * S[q + CONSTRAINT.nx]
    py = force * S[q + CONSTRAINT.ny]
    S[k + at] += px
    S[k + at + 1] += py
    S[k + at + 2] += force * S[q + CONSTRAINT.jk]
    S[b + at] -= px
    S[b + at + 1] -= py
    S[b + at + 2] -= force * S[q + CONSTRAINT.jb]
    if c != 0:
        S[c + at + 2] -= force * S[q + CONSTRAINT.jc]


def clear(S, i):
    """Set a row and the two behind it to zero."""
    S[i] = 0.0
    S[i + 1] = 0.0
    S[i + 2] = 0.0


def reaction(S, I, r):
    """Store force and moment of joint r on the journal at t_n, from its constraints, and update their
    extremes.
    """
    j = I[r + JOINT_INDEX.row]
    q = I[r + JOINT_INDEX.first]
    place = I[r + JOINT_INDEX.place]
    if place == PINNED:
        S[j + JOINT.fx] = S[q + CONSTRAINT.force]
        S[j + JOINT.fy] = S[q + CONSTRAINT.SIZE + CONSTRAINT.force]
    elif place != UNPLACED:
        S[j + JOINT.fx] = S[q + CONSTRAINT.force] * S[q + CONSTRAINT.nx]
        S[j + JOINT.fy] = S[q + CONSTRAINT.force] * S[q + CONSTRAINT.ny]
    if I[r + JOINT_INDEX.turn] != FREE:
        moment = S[q + CONSTRAINT.SIZE * (I[r + JOINT_INDEX.rows] - 1) + CONSTRAINT.force]
        S[j + JOINT.moment] = moment
        S[j + JOINT.moment_max] = larger(S[j + JOINT.moment_max], abs(moment))
    largest = j + JOINT.force_squared_max
    S[largest] = larger(S[largest], S[j + JOINT.fx] * S[j + JOINT.fx] + S[j + JOINT.fy] * S[j + JOINT.fy])


def compliance(S, I, w, y, b, k, row: Row):
    """Store the response of the mechanism to a unit pair of forces along a row, on body k and its opposite on
    body b: in rows w (PARTICLE.rn or .rt) the velocities of all pinned bodies, in rows from y the reactions.
    """
    # 1. The pair moves its two bodies, as if they were free.
    for q in range(I[HEADER.jointed], I[HEADER.jointed_end]):
        clear(S, I[q] + w)
    S[k + w] = S[k + PARTICLE.inverse_mass] * row.nx
    S[k + w + 1] = S[k + PARTICLE.inverse_mass] * row.ny
    S[k + w + 2] = S[k + PARTICLE.inverse_inertia] * row.jk
    S[b + w] = -S[b + PARTICLE.inverse_mass] * row.nx
    S[b + w + 1] = -S[b + PARTICLE.inverse_mass] * row.ny
    S[b + w + 2] = -S[b + PARTICLE.inverse_inertia] * row.jb
    # 2. That opens constraints; the factors of t_n give the reactions that prevent it.
    for m in range(I[HEADER.constraint_count]):
        r = I[HEADER.constraint] + CONSTRAINT_INDEX.SIZE * m
        q = I[r + CONSTRAINT_INDEX.row]
        bw = I[r + CONSTRAINT_INDEX.bearing] + w
        kw = I[r + CONSTRAINT_INDEX.journal] + w
        nx = S[q + CONSTRAINT.nx]
        ny = S[q + CONSTRAINT.ny]
        on_journal = nx * S[kw] + ny * S[kw + 1] + S[q + CONSTRAINT.jk] * S[kw + 2]
        S[y + m] = on_journal - (nx * S[bw] + ny * S[bw + 1] + S[q + CONSTRAINT.jb] * S[bw + 2])
        c = I[r + CONSTRAINT_INDEX.carrier]
        if c != 0:
            S[y + m] -= S[q + CONSTRAINT.jc] * S[c + w + 2]
    solve(S, I, y)
    # 3. The reactions move all pinned bodies back onto the constraints.
    for m in range(I[HEADER.constraint_count]):
        r = I[HEADER.constraint] + CONSTRAINT_INDEX.SIZE * m
        push_back(S, I, r, w, S[y + m])


def push_back(S, I, r, w, force):
    """Subtract from rows w of the bodies of record r the velocities that a reaction ``force`` along its
    constraint causes.
    """
    q, b, k = bodies(I, r)
    c = I[r + CONSTRAINT_INDEX.carrier]
    gx = force * S[q + CONSTRAINT.nx]
    gy = force * S[q + CONSTRAINT.ny]
    S[k + w] -= S[k + PARTICLE.inverse_mass] * gx
    S[k + w + 1] -= S[k + PARTICLE.inverse_mass] * gy
    S[k + w + 2] -= S[k + PARTICLE.inverse_inertia] * (force * S[q + CONSTRAINT.jk])
    S[b + w] += S[b + PARTICLE.inverse_mass] * gx
    S[b + w + 1] += S[b + PARTICLE.inverse_mass] * gy
    S[b + w + 2] += S[b + PARTICLE.inverse_inertia] * (force * S[q + CONSTRAINT.jb])
    if c != 0:
        S[c + w + 2] += S[c + PARTICLE.inverse_inertia] * (force * S[q + CONSTRAINT.jc])


def joint_compliance(S, I, b, k, normal: Row, tangent: Row):
    """Return the inverse masses (1/kg) along n and t, and their coupling, of a clearance joint whose bodies
    b and k are held by ideal joints.
    """
    compliance(S, I, PARTICLE.rn, I[HEADER.gn], b, k, normal)
    compliance(S, I, PARTICLE.rt, I[HEADER.gt], b, k, tangent)
    nx = normal.nx
    ny = normal.ny
    nu = S[k + PARTICLE.rn] - S[b + PARTICLE.rn]
    nv = S[k + PARTICLE.rn + 1] - S[b + PARTICLE.rn + 1]
    tu = S[k + PARTICLE.rt] - S[b + PARTICLE.rt]
    tv = S[k + PARTICLE.rt + 1] - S[b + PARTICLE.rt + 1]
    gn = nx * nu + ny * nv + normal.jk * S[k + PARTICLE.rn + 2] - normal.jb * S[b + PARTICLE.rn + 2]
    gt = nx * tv - ny * tu + tangent.jk * S[k + PARTICLE.rt + 2] - tangent.jb * S[b + PARTICLE.rt + 2]
    gm = nx * nv - ny * nu + tangent.jk * S[k + PARTICLE.rn + 2] - tangent.jb * S[b + PARTICLE.rn + 2]
    return gn, gt, gm


def apply_response(S, I, h, normal, friction):
    """Change velocities at t_n and reactions by the response to a change of the normal and friction force
    (N), for the clearance joint of the last call of :func:`joint_compliance`.
    """
    for q in range(I[HEADER.jointed], I[HEADER.jointed_end]):
        i = I[q]
        S[i + PARTICLE.vu] += h * (friction * S[i + PARTICLE.rt] - normal * S[i + PARTICLE.rn])
        S[i + PARTICLE.vv] += h * (friction * S[i + PARTICLE.rt + 1] - normal * S[i + PARTICLE.rn + 1])
        S[i + PARTICLE.vw] += h * (friction * S[i + PARTICLE.rt + 2] - normal * S[i + PARTICLE.rn + 2])
    for m in range(I[HEADER.constraint_count]):
        r = I[HEADER.constraint] + CONSTRAINT_INDEX.SIZE * m
        force = normal * S[I[HEADER.gn] + m] - friction * S[I[HEADER.gt] + m]
        q = I[r + CONSTRAINT_INDEX.row]
        S[q + CONSTRAINT.force] += force
        apply_reaction(S, I, r, q, PARTICLE.fx, force)
