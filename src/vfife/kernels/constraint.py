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

Names, here, in :mod:`~vfife.kernels.closing` and in :mod:`~vfife.kernels.factors`: r is a record in I, of a
joint or a constraint; of rows in S, j is that of a joint, q that of a constraint, b and k those of the
particles of bearing and journal, c that of the carrier of gears (0 for none), i that of any particle; y is
the first row of a right side.
"""

from typing import NamedTuple

from .arrays import CONSTRAINT, CONSTRAINT_INDEX, HEADER, JOINT, JOINT_INDEX, PARTICLE
from .central_difference import larger
from .factors import solve
from .frame import chord
from .geometry import arm, from_path
from .topology import ALONG, FREE, GEARED, NOWHERE, ON_PATH, PINNED, SPACED


class Row(NamedTuple):
    """Direction (1) and levers (m) of a constraint, of a contact's n or t, or of a spring's axis, on bearing
    and journal, or first and second body.
    """

    nx: float
    ny: float
    jb: float
    jk: float


def bodies(I, r):
    """Row of a contact, a joint or a constraint, and those of its bearing's and its journal's particle, which
    begin its record r.
    """
    return I[r + JOINT_INDEX.row], I[r + JOINT_INDEX.bearing], I[r + JOINT_INDEX.journal]


def set_row(S, q, nx, ny, jb, jk):
    """Store direction and levers of constraint q, or of its change (q + TURN); the lever of gears on their
    carrier is zero.
    """
    S[q + CONSTRAINT.nx] = nx
    S[q + CONSTRAINT.ny] = ny
    S[q + CONSTRAINT.jb] = jb
    S[q + CONSTRAINT.jk] = jk
    S[q + CONSTRAINT.jc] = 0.0


def lever(rx, ry, nx, ny):
    """Moment of a unit force along n at (rx, ry)."""
    return rx * ny - ry * nx


class Guide(NamedTuple):
    """What holds a pin along one line: the kind of place, first row and number of the pieces of a path,
    direction of a guide in the bearing's body.
    """

    place: int
    piece: int
    pieces: int
    dx: float
    dy: float


def guide_of(S, I, r) -> Guide:
    """The guide of joint r."""
    j = I[r + JOINT_INDEX.row]
    return Guide(
        I[r + JOINT_INDEX.place], I[r + JOINT_INDEX.piece], I[r + JOINT_INDEX.pieces],
        S[j + JOINT.direction_x], S[j + JOINT.direction_y]
    )  # fmt: skip


def guide_row(S, guide: Guide, c, s, ex, ey):
    """What a row along or across a guide, from a path or along a massless link measures (m), and its
    direction in space.

    (ex, ey) is the journal's pin seen from the bearing's, in space; (c, s) the direction of the bearing's
    body.
    """
    if guide.place == ON_PATH:
        measured, nx, ny = from_path(S, guide.piece, guide.pieces, c * ex + s * ey, c * ey - s * ex)
        nx, ny = arm(c, s, nx, ny)
    elif guide.place == SPACED:
        measured, _, nx, ny = chord(ex, ey)
    else:
        ux, uy = arm(c, s, guide.dx, guide.dy)
        nx = ux if guide.place == ALONG else -uy
        ny = uy if guide.place == ALONG else ux
        measured = ex * nx + ey * ny
    return measured, nx, ny


def relative_turn(bearing, journal, ratio, carrier):
    """What a row of the turn measures (rad): (journal - carrier) - ratio (bearing - carrier), Willis'
    formula.
    """
    return (journal - ratio * bearing) - (1.0 - ratio) * carrier


def levers(S, I):
    """Store directions and levers of all constraints at t_n."""
    for r in range(I[HEADER.joint], I[HEADER.joint_end], JOINT_INDEX.SIZE):
        j, b, k = bodies(I, r)
        q = I[r + JOINT_INDEX.first]
        place = I[r + JOINT_INDEX.place]
        turn = I[r + JOINT_INDEX.turn]
        if place != NOWHERE:
            bx, by = arm(S[b + PARTICLE.c], S[b + PARTICLE.s], S[j + JOINT.bearing_x], S[j + JOINT.bearing_y])
            kx, ky = arm(S[k + PARTICLE.c], S[k + PARTICLE.s], S[j + JOINT.journal_x], S[j + JOINT.journal_y])
            if place == PINNED:
                set_row(S, q, 1.0, 0.0, -by, -ky)
                set_row(S, q + CONSTRAINT.SIZE, 0.0, 1.0, bx, kx)
            else:
                # The force of a guide acts at the journal's pin: on the bearing's body too, whose lever is
                # that of this place.
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
    """Add a reaction along constraint q of record r: to the journal's body, its opposite to the bearing's,
    the moment of gears to their carrier's.

    ``at`` is the field of a particle's first row: PARTICLE.fx of the forces, PARTICLE.change_x of what a
    correction adds to them.
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
    elif place != NOWHERE:
        S[j + JOINT.fx] = S[q + CONSTRAINT.force] * S[q + CONSTRAINT.nx]
        S[j + JOINT.fy] = S[q + CONSTRAINT.force] * S[q + CONSTRAINT.ny]
    if I[r + JOINT_INDEX.turn] != FREE:
        moment = S[q + CONSTRAINT.SIZE * (I[r + JOINT_INDEX.rows] - 1) + CONSTRAINT.force]
        S[j + JOINT.moment] = moment
        S[j + JOINT.moment_max] = larger(S[j + JOINT.moment_max], abs(moment))
    largest = j + JOINT.force_squared_max
    S[largest] = larger(S[largest], S[j + JOINT.fx] * S[j + JOINT.fx] + S[j + JOINT.fy] * S[j + JOINT.fy])


def compliance(S, I, w, y, b, k, row: Row):
    """Store in rows w (PARTICLE.rn or .rt) of all pinned bodies their velocities per unit of a force pair
    along a row: on body k, its opposite on b.

    The pair alone moves b and k. Rows from y get the reactions that hold all joints against that, per unit of
    the pair: what it opens in each constraint, solved with the factors of t_n; they move the bodies back.
    """
    for q in range(I[HEADER.jointed], I[HEADER.jointed_end]):
        clear(S, I[q] + w)
    S[k + w] = S[k + PARTICLE.inverse_mass] * row.nx
    S[k + w + 1] = S[k + PARTICLE.inverse_mass] * row.ny
    S[k + w + 2] = S[k + PARTICLE.inverse_inertia] * row.jk
    S[b + w] = -S[b + PARTICLE.inverse_mass] * row.nx
    S[b + w + 1] = -S[b + PARTICLE.inverse_mass] * row.ny
    S[b + w + 2] = -S[b + PARTICLE.inverse_inertia] * row.jb
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
    for m in range(I[HEADER.constraint_count]):
        r = I[HEADER.constraint] + CONSTRAINT_INDEX.SIZE * m
        push_back(S, I, r, w, S[y + m])


def push_back(S, I, r, w, force):
    """Take the velocities of a reaction along the constraint of record r off rows w of its bodies."""
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
    """Inverse masses (1/kg) of a clearance joint between bodies b and k along n and t, and their coupling,
    where its bodies hang in ideal joints.
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
    """Change velocities at t_n and reactions by a change (N) of the force in the clearance joint of the last
    :func:`joint_compliance`.
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
