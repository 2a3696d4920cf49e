"""Contacts at a step: where journal and bearing stand, whether a contact begins, and the force that answers (paper Eq. 18-33).

A journal meets the bearing around it, a round beside it, or a straight line (the wall of a guide, met by the corners of a block).

Damping and friction are stiff: both act on the velocity at t_n, which a central difference does not know yet, so each joint solves for its
force in closed form. Joints that share a body are visited in turn, from the last step's forces.
"""

from .arrays import JC, C, H, P, Y
from .central_difference import larger
from .constraint import hold, respond
from .geometry import arm, eccentricity, normal_force, onset_speed, seldom
from .topology import LINE, ROUND

contact_law = friction_law = film_law = None  # written by source.py for the laws at hand


def velocities(S, I, p, h):
    """Velocities at t_n of the particles in clearance joints under the forces so far."""
    for q in range(I[H.jointed_count]):
        i = I[I[H.jointed] + q]
        im = S[i + P.inverse_mass]
        S[i + P.vu] = p * (S[i + P.u] + h * (im * S[i + P.fx]))
        S[i + P.vv] = p * (S[i + P.v] + h * (im * S[i + P.fy]))
        S[i + P.vw] = p * (S[i + P.w] + h * (S[i + P.inverse_inertia] * S[i + P.mz]))


def press(S, j, b, k, normal, friction):
    """Adds a normal and a friction force of joint j to the forces on its two particles."""
    nx = S[j + C.nx]
    ny = S[j + C.ny]
    px = -normal * nx - friction * ny
    py = friction * nx - normal * ny
    S[k + P.fx] += px
    S[k + P.fy] += py
    S[k + P.mz] += friction * S[j + C.jt] - normal * S[j + C.jn]
    S[b + P.fx] -= px
    S[b + P.fy] -= py
    S[b + P.mz] -= friction * S[j + C.bt] - normal * S[j + C.bn]


def expected(S, i, p, h):
    """Velocity at t_n of a particle under the last step's acceleration."""
    turning = S[i + P.inverse_inertia] > 0.0
    w = p * (S[i + P.w] + h * S[i + P.aw]) if turning else S[i + P.w]
    return p * (S[i + P.u] + h * S[i + P.ax]), p * (S[i + P.v] + h * S[i + P.ay]), w


def land(S, j, b, k, depth, start, p, h):
    """A contact begins: its speed is located inside the step and held until the two part."""
    dt = S[Y.step]
    bu, bv, bw = expected(S, b, p, h)
    ku, kv, kw = expected(S, k, p, h)
    rate = S[j + C.nx] * (ku - bu) + S[j + C.ny] * (kv - bv) + S[j + C.jn] * kw - S[j + C.bn] * bw
    located = rate if start else onset_speed(depth, S[j + C.penetration], rate, dt)
    slow = located < S[j + C.floor]
    S[j + C.slowness] = 1.0 / (S[j + C.floor] if slow else located)
    S[j + C.onsets] += 1.0
    S[j + C.grazing] += 1.0 if slow else 0.0
    S[j + C.deep] += 1.0 if depth > S[j + C.landing] else 0.0
    S[j + C.deepest] = larger(S[j + C.deepest], depth)
    S[j + C.fastest] = larger(S[j + C.fastest], located)
    S[j + C.contact_steps] -= 1.0


def meet(S, I, start, p, h):
    """Geometry, onset and law of every clearance joint; the last step's forces of joints that share a body."""
    for m in range(I[H.clearance_count]):
        r = I[H.clearance] + JC.SIZE * m
        j = I[r + JC.row]
        b = I[r + JC.bearing]
        k = I[r + JC.journal]
        bx, by = arm(S[b + P.c], S[b + P.s], S[j + C.bearing_x], S[j + C.bearing_y])
        kx, ky = arm(S[k + P.c], S[k + P.s], S[j + C.journal_x], S[j + C.journal_y])
        ex = (S[k + P.x] + kx) - (S[b + P.x] + bx)
        ey = (S[k + P.y] + ky) - (S[b + P.y] + by)
        kind = I[r + JC.kind]
        along = 0.0
        if kind == LINE:
            nx, ny = arm(S[b + P.c], S[b + P.s], S[j + C.line_x], S[j + C.line_y])
            depth = (nx * ex + ny * ey) - S[j + C.size]
            along = nx * ey - ny * ex
        else:
            depth, nx, ny = eccentricity(ex, ey, S[j + C.size])
            if kind == ROUND:
                depth = -depth
                nx = -nx
                ny = -ny
        overlap = S[j + C.arm_overlap] * depth
        S[j + C.nx] = nx
        S[j + C.ny] = ny
        S[j + C.jn] = kx * ny - ky * nx
        S[j + C.bn] = bx * ny - by * nx - along
        S[j + C.jt] = kx * nx + ky * ny + (S[j + C.arm_journal] - overlap)
        S[j + C.bt] = bx * nx + by * ny + (S[j + C.arm_bearing] + overlap)
        touching = depth > 0.0
        if seldom(touching and S[j + C.slowness] <= 0.0):
            land(S, j, b, k, depth, start, p, h)
        slowness = S[j + C.slowness] if touching else 0.0
        S[j + C.penetration] = depth
        S[j + C.slowness] = slowness
        S[j + C.contact_steps] += 1.0 if touching else 0.0
        S[j + C.elastic], S[j + C.damping_coefficient] = contact_law(I[r + JC.contact], depth if touching else 0.0, slowness, S, j + C.contact)
        S[j + C.normal] = 0.0
        S[j + C.friction] = 0.0
        if I[r + JC.film] != 0:
            wet(S, I[r + JC.contact], j, b, k, h)
            if I[r + JC.shared] != 0:
                S[j + C.normal] = S[j + C.normal_force]
                S[j + C.friction] = S[j + C.friction_force]
                press(S, j, b, k, S[j + C.normal], S[j + C.friction])
        elif I[r + JC.shared] != 0:
            S[j + C.normal] = S[j + C.normal_force] if touching else 0.0
            S[j + C.friction] = S[j + C.friction_force] if touching else 0.0
            press(S, j, b, k, S[j + C.normal], S[j + C.friction])


def wet(S, contact, j, b, k, h):
    """A film between the surfaces: forces at rest and their dependence on the velocities at t_n, of which only the sense is taken beforehand.

    What runs into the film is e (w_J + w_B) - 2 v_t, v_t along t between the centres; friction has no arms in a joint with a film.
    """
    nx = S[j + C.nx]
    ny = S[j + C.ny]
    bw = S[b + P.w]
    kw = S[k + P.w]
    slide = nx * (S[k + P.v] - S[b + P.v]) - ny * (S[k + P.u] - S[b + P.u]) + S[j + C.jt] * kw - S[j + C.bt] * bw
    turning = (S[j + C.penetration] + S[j + C.size]) * (kw + bw)
    sense = 1.0 if turning > 2.0 * slide else -1.0
    radial, across, damping, along, cross = film_law(contact, S[j + C.penetration], turning, sense, S, j + C.contact)
    S[j + C.film_radial] = radial
    S[j + C.film_across] = across
    S[j + C.damping_coefficient] += damping
    S[j + C.film_damping] = along
    S[j + C.film_cross] = cross


def soaked(S, j, slip, gt):
    """Normal force at rest (N) and damping coefficient (N s/m) of a joint with a film, its force along t eliminated from the two equations.

    F_N = radial + D_n v_n - X v_t and F_T = across + X v_n - D_t v_t, with v_t = slip + gt F_T; X^2 < D_n D_t keeps the damping positive.
    """
    share = 1.0 / (1.0 + gt * S[j + C.film_damping])
    cross = S[j + C.film_cross]
    push = S[j + C.elastic] + S[j + C.film_radial] - cross * share * (slip + gt * S[j + C.film_across])
    return push, S[j + C.damping_coefficient] - cross * cross * gt * share


def carried(S, j, rate, slip, gt):
    """Force of the film along t (N) for the rate along n that was solved."""
    return (S[j + C.film_across] + S[j + C.film_cross] * rate - S[j + C.film_damping] * slip) / (1.0 + gt * S[j + C.film_damping])


def mobilities(S, I, j, b, k, constrained):
    """Inverse masses of joint j along n and t and their coupling (1/kg), of the two bodies alone or with what is pinned to them."""
    jn = S[j + C.jn]
    jt = S[j + C.jt]
    bn = S[j + C.bn]
    bt = S[j + C.bt]
    if constrained != 0:
        gn, gt, gm = respond(S, I, j, b, k)
    else:
        both = S[k + P.inverse_mass] + S[b + P.inverse_mass]
        ik = S[k + P.inverse_inertia]
        ib = S[b + P.inverse_inertia]
        gn = both + jn * jn * ik + bn * bn * ib
        gt = both + jt * jt * ik + bt * bt * ib
        gm = jn * jt * ik + bn * bt * ib
    return gn, gt, gm


def onward(S, i, b, k):
    """Velocity at t_(n+1/2) of a particle under the forces so far, as ``kick`` will make it; a driven one turns as prescribed."""
    im = S[i + P.inverse_mass]
    ii = S[i + P.inverse_inertia]
    w = b * S[i + P.w] + k * (ii * S[i + P.mz]) if ii > 0.0 else S[i + P.w] + 0.5 * S[Y.step] * S[i + P.aw]
    return b * S[i + P.u] + k * (im * S[i + P.fx]), b * S[i + P.v] + k * (im * S[i + P.fy]), w


def slip_after(S, j, bearing, journal, b, k):
    """Sliding velocity of joint j at t_(n+1/2) under the forces so far."""
    bu, bv, bw = onward(S, bearing, b, k)
    ku, kv, kw = onward(S, journal, b, k)
    return S[j + C.nx] * (kv - bv) - S[j + C.ny] * (ku - bu) + S[j + C.jt] * kw - S[j + C.bt] * bw


def answer(S, I, span, central):
    """Normal and friction force of every clearance joint at t_n, each solved in closed form, in turn where joints share a body.

    Most friction laws are solved with the velocity at t_n. A set-valued one must make the half-step velocity zero to stick: at t_n it would
    only turn that round, and the body would tremble. ``ahead`` marks such a joint.
    """
    half, decay, gain, p = central
    h = p * half
    for m in range(I[H.clearance_count]):
        r = I[H.clearance] + JC.SIZE * m
        j = I[r + JC.row]
        b = I[r + JC.bearing]
        k = I[r + JC.journal]
        nx = S[j + C.nx]
        ny = S[j + C.ny]
        gn, gt, gm = mobilities(S, I, j, b, k, I[r + JC.constrained])
        ahead_t = gain * gt
        ahead_m = gain * gm
        gn = h * gn
        gt = h * gt
        gm = h * gm
        ru = S[k + P.vu] - S[b + P.vu]
        rv = S[k + P.vv] - S[b + P.vv]
        rate = nx * ru + ny * rv + S[j + C.jn] * S[k + P.vw] - S[j + C.bn] * S[b + P.vw]
        slip = nx * rv - ny * ru + S[j + C.jt] * S[k + P.vw] - S[j + C.bt] * S[b + P.vw]
        push = S[j + C.elastic]
        resisting = S[j + C.damping_coefficient]
        if I[r + JC.film] != 0:
            push, resisting = soaked(S, j, slip - gt * S[j + C.friction], gt)
        normal, rate = normal_force(push, resisting, rate + gn * S[j + C.normal], gn)
        more = normal - S[j + C.normal]
        loose = slip - gm * more - gt * S[j + C.friction]
        dry = normal
        across = 0.0
        if I[r + JC.film] != 0:
            across = carried(S, j, rate, loose, gt)
            loose += gt * across
            dry = S[j + C.elastic] if S[j + C.elastic] < normal else normal
        free = loose
        mobility = gt
        if I[r + JC.ahead] != 0:
            free = slip_after(S, j, b, k, decay, gain) - ahead_m * more - ahead_t * (S[j + C.friction] - across)
            mobility = ahead_t
        friction = friction_law(I[r + JC.friction], dry, free, mobility, S[Y.step], S, j + C.friction_slots, j + C.memory)
        slip = loose + gt * friction
        tangential = friction + across
        press(S, j, b, k, more, tangential - S[j + C.friction])
        if I[r + JC.constrained] != 0:
            hold(S, I, h, more, tangential - S[j + C.friction])
        elif I[r + JC.shared] != 0:
            shove(S, j, b, k, h, more, tangential - S[j + C.friction])
        S[j + C.normal_force] = normal
        S[j + C.friction_force] = tangential
        lost = (normal - S[j + C.elastic]) * rate - across * slip
        rubbed = -friction * slip
        S[j + C.damping_power] = lost
        S[j + C.friction_power] = rubbed
        S[j + C.damping_work] += span * lost
        S[j + C.friction_work] += span * rubbed
        square = normal * normal + tangential * tangential
        at = j + C.force_squared_max
        S[at] = larger(S[at], square)
        at = j + C.penetration_max
        S[at] = larger(S[at], S[j + C.penetration])


def shove(S, j, b, k, h, normal, friction):
    """Velocities at t_n of the two bodies of joint j under a change of its force."""
    nx = S[j + C.nx]
    ny = S[j + C.ny]
    px = -normal * nx - friction * ny
    py = friction * nx - normal * ny
    hk = h * S[k + P.inverse_mass]
    hb = h * S[b + P.inverse_mass]
    S[k + P.vu] += hk * px
    S[k + P.vv] += hk * py
    S[k + P.vw] += h * S[k + P.inverse_inertia] * (friction * S[j + C.jt] - normal * S[j + C.jn])
    S[b + P.vu] -= hb * px
    S[b + P.vv] -= hb * py
    S[b + P.vw] -= h * S[b + P.inverse_inertia] * (friction * S[j + C.bt] - normal * S[j + C.bn])
