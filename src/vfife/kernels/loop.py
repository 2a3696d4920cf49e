"""The data-driven step: any mechanism, compiled once, the topology read from integer tables.

``generate.py`` writes the same step out for one topology; the two must agree to the bit, so each sum here has one fixed order. The step n:
drift to t_n, forces from positions, joints, accelerations, kick to t_(n+1/2). Velocities at half steps are algebraically the paper's Eq. 3-5.
"""

from .arrays import JB, JC, JD, JE, JF, JL, JR, B, C, D, E, F, H, L, P, R, Y
from .drive import polynomial
from .elementary import sincos
from .frame import axial, bending, bending_released, chord, nodal_force, step_turn, turn
from .ideal import ahead, close, factor, fill, hold, levers, recall, respond
from .pin import arm, eccentricity, normal_force, onset_speed, seldom
from .step import chord_acceleration, coefficients, driven_reaction, larger

contact_law = friction_law = None  # written by source.py for the laws at hand


def functions(S, T, I, shift, time, after):
    """Functions of time at t_n, and their value at t_(n+1)."""
    for m in range(I[H.function_count]):
        f = I[I[H.function] + JF.SIZE * m]
        start = shift + I[I[H.function] + JF.SIZE * m + 1]
        value, rate, second = polynomial(T, start, time)
        S[f + F.value] = value
        S[f + F.rate] = rate
        S[f + F.acceleration] = second
        S[f + F.next] = polynomial(T, start, after)[0]


def drift(S, I, time, d):
    """Positions at t_n: free particles by their half-step velocity, driven ones as prescribed; then directions."""
    for q in range(I[H.free_count]):
        i = I[I[H.free] + q]
        S[i + P.x] += d * S[i + P.u]
        S[i + P.y] += d * S[i + P.v]
        S[i + P.theta] += d * S[i + P.w]
    for m in range(I[H.driven_count]):
        r = I[H.driven] + JD.SIZE * m
        k = I[r + JD.row]
        i = I[r + JD.body]
        f = I[r + JD.function]
        if f == 0:
            S[i + P.theta] = S[k + D.angle] + S[k + D.speed] * time
            S[i + P.w] = S[k + D.speed]
            S[i + P.aw] = 0.0
        else:
            S[i + P.theta] = S[f + F.value]
            S[i + P.w] = S[f + F.rate]
            S[i + P.aw] = S[f + F.acceleration]
        S[i + P.vw] = S[i + P.w]
    for q in range(I[H.trig_count]):
        i = I[I[H.trig] + q]
        S[i + P.s], S[i + P.c] = sincos(S[i + P.theta])


def loads(S, I):
    """External forces at t_n."""
    for m in range(I[H.particle_count]):
        i = I[I[H.particle] + m]
        S[i + P.fx] = S[i + P.load_x]
        S[i + P.fy] = S[i + P.load_y]
        S[i + P.mz] = S[i + P.load_m]
    for m in range(I[H.load_count]):
        k = I[I[H.load] + JL.SIZE * m]
        i = I[I[H.load] + JL.SIZE * m + 1]
        value = S[I[I[H.load] + JL.SIZE * m + 2] + F.value]
        rx, ry = arm(S[i + P.c], S[i + P.s], S[k + L.x], S[k + L.y])
        px = value * S[k + L.fx]
        py = value * S[k + L.fy]
        S[i + P.fx] += px
        S[i + P.fy] += py
        S[i + P.mz] += rx * py - ry * px + value * S[k + L.m]


def elements(S, I, renew):
    """Element forces from the reversed rigid-body motion; the reference is renewed where a path unit ends."""
    own = I[H.path_unit] == 1
    for m in range(I[H.element_count]):
        r = I[H.element] + JE.SIZE * m
        e = I[r + JE.row]
        i = I[r + JE.first]
        j = I[r + JE.second]
        length, inverse, c, s = chord(S[j + P.x] - S[i + P.x], S[j + P.y] - S[i + P.y])
        ila = S[e + E.reference_inverse_length]
        na = S[e + E.axial_force] if own else S[e + E.reference_axial_force]
        n = axial(length, S[e + E.reference_length], ila, na, S[e + E.axial_stiffness])
        release = I[r + JE.release]
        m1 = 0.0
        m2 = 0.0
        if release != 3:
            ei = S[e + E.bending_stiffness]
            m1a = S[e + E.moment_1] if own else S[e + E.reference_moment_1]
            m2a = S[e + E.moment_2] if own else S[e + E.reference_moment_2]
            ca = S[e + E.reference_cosine]
            sa = S[e + E.reference_sine]
            rigid = step_turn(c, s, ca, sa) if own else turn(c, s, ca, sa)
            theta_1 = S[i + P.theta] - S[e + E.reference_theta_1] - rigid
            theta_2 = S[j + P.theta] - S[e + E.reference_theta_2] - rigid
            if release == 0:
                m1, m2 = bending(theta_1, theta_2, ila, m1a, m2a, ei)
            elif release == 1:
                m2 = bending_released(theta_2, ila, m2a, ei)
            else:
                m1 = bending_released(theta_1, ila, m1a, ei)
        px, py = nodal_force(c, s, inverse, n, m1, m2)
        S[i + P.fx] += px
        S[i + P.fy] += py
        S[i + P.mz] -= m1
        S[j + P.fx] -= px
        S[j + P.fy] -= py
        S[j + P.mz] -= m2
        S[e + E.axial_force] = n
        S[e + E.moment_1] = m1
        S[e + E.moment_2] = m2
        if renew:
            S[e + E.reference_length] = length
            S[e + E.reference_inverse_length] = inverse
            S[e + E.reference_cosine] = c
            S[e + E.reference_sine] = s
            S[e + E.reference_theta_1] = S[i + P.theta]
            S[e + E.reference_theta_2] = S[j + P.theta]
            if not own:
                S[e + E.reference_axial_force] = n
                S[e + E.reference_moment_1] = m1
                S[e + E.reference_moment_2] = m2


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
        depth, nx, ny = eccentricity(ex, ey, S[j + C.size])
        overlap = S[j + C.arm_overlap] * depth
        S[j + C.nx] = nx
        S[j + C.ny] = ny
        S[j + C.jn] = kx * ny - ky * nx
        S[j + C.bn] = bx * ny - by * nx
        S[j + C.jt] = kx * nx + ky * ny + (S[j + C.arm_journal] - overlap)
        S[j + C.bt] = bx * nx + by * ny + (S[j + C.arm_bearing] + overlap)
        touching = depth > 0.0
        if seldom(touching and S[j + C.slowness] <= 0.0):
            land(S, j, b, k, depth, start, p, h)
        slowness = S[j + C.slowness] if touching else 0.0
        S[j + C.penetration] = depth
        S[j + C.slowness] = slowness
        S[j + C.contact_steps] += 1.0 if touching else 0.0
        S[j + C.elastic], S[j + C.damping_coefficient] = contact_law(
            I[r + JC.contact], depth if touching else 0.0, slowness, S, j + C.contact
        )
        S[j + C.normal] = 0.0
        S[j + C.friction] = 0.0
        if I[r + JC.shared] != 0:
            S[j + C.normal] = S[j + C.normal_force] if touching else 0.0
            S[j + C.friction] = S[j + C.friction_force] if touching else 0.0
            press(S, j, b, k, S[j + C.normal], S[j + C.friction])


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


def answer(S, I, span, h):
    """Normal and friction force of every clearance joint at t_n, each solved in closed form, in turn where joints share a body."""
    for m in range(I[H.clearance_count]):
        r = I[H.clearance] + JC.SIZE * m
        j = I[r + JC.row]
        b = I[r + JC.bearing]
        k = I[r + JC.journal]
        nx = S[j + C.nx]
        ny = S[j + C.ny]
        gn, gt, gm = mobilities(S, I, j, b, k, I[r + JC.constrained])
        gn = h * gn
        gt = h * gt
        gm = h * gm
        ru = S[k + P.vu] - S[b + P.vu]
        rv = S[k + P.vv] - S[b + P.vv]
        rate = nx * ru + ny * rv + S[j + C.jn] * S[k + P.vw] - S[j + C.bn] * S[b + P.vw]
        slip = nx * rv - ny * ru + S[j + C.jt] * S[k + P.vw] - S[j + C.bt] * S[b + P.vw]
        normal, rate = normal_force(S[j + C.elastic], S[j + C.damping_coefficient], rate + gn * S[j + C.normal], gn)
        more = normal - S[j + C.normal]
        loose = slip - gm * more - gt * S[j + C.friction]
        friction, memory = friction_law(
            I[r + JC.friction],
            normal,
            loose,
            gt,
            S[j + C.memory],
            S[Y.step],
            S,
            j + C.friction_slots,
        )
        slip = loose + gt * friction
        press(S, j, b, k, more, friction - S[j + C.friction])
        if I[r + JC.constrained] != 0:
            hold(S, I, h, more, friction - S[j + C.friction])
        elif I[r + JC.shared] != 0:
            shove(S, j, b, k, h, more, friction - S[j + C.friction])
        S[j + C.normal_force] = normal
        S[j + C.friction_force] = friction
        S[j + C.memory] = memory
        lost = (normal - S[j + C.elastic]) * rate
        rubbed = -friction * slip
        S[j + C.damping_power] = lost
        S[j + C.friction_power] = rubbed
        S[j + C.damping_work] += span * lost
        S[j + C.friction_work] += span * rubbed
        square = normal * normal + friction * friction
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


def kick(S, I, span, h, b, k, p):
    """Accelerations at t_n and velocities at t_(n+1/2); power of damping and of time-dependent loads at t_n."""
    lost = 0.0
    zeta = S[Y.damping]
    damped = I[H.damped] != 0
    moved = damped or I[H.load_count] > 0
    for q in range(I[H.free_count]):
        i = I[I[H.free] + q]
        im = S[i + P.inverse_mass]
        ii = S[i + P.inverse_inertia]
        ax = im * S[i + P.fx]
        ay = im * S[i + P.fy]
        aw = ii * S[i + P.mz]
        u = S[i + P.u]
        v = S[i + P.v]
        w = S[i + P.w]
        if moved:
            un = p * (u + h * ax)
            vn = p * (v + h * ay)
            wn = p * (w + h * aw)
            S[i + P.vu] = un
            S[i + P.vv] = vn
            S[i + P.vw] = wn
            if damped:
                lost += zeta * ((un * un + vn * vn) / im + (wn * wn / ii if ii > 0.0 else 0.0))
        S[i + P.ax] = ax
        S[i + P.ay] = ay
        S[i + P.aw] = aw
        S[i + P.u] = b * u + k * ax
        S[i + P.v] = b * v + k * ay
        S[i + P.w] = b * w + k * aw
    if damped:
        S[Y.damping_work] += span * lost
        S[Y.damping_power] = lost
    if I[H.load_count] > 0:
        power = 0.0
        for m in range(I[H.load_count]):
            g = I[I[H.load] + JL.SIZE * m]
            i = I[I[H.load] + JL.SIZE * m + 1]
            value = S[I[I[H.load] + JL.SIZE * m + 2] + F.value]
            rx, ry = arm(S[i + P.c], S[i + P.s], S[g + L.x], S[g + L.y])
            px = S[g + L.fx]
            py = S[g + L.fy]
            turning = rx * py - ry * px + S[g + L.m]
            power += value * (px * S[i + P.vu] + py * S[i + P.vv] + turning * S[i + P.vw])
        S[Y.external_work] += span * power
        S[Y.external_power] = power


def observe(S, I, span):
    """What the driver does and how the bodies turn at t_n."""
    for m in range(I[H.driven_count]):
        k = I[I[H.driven] + JD.SIZE * m + JD.row]
        i = I[I[H.driven] + JD.SIZE * m + JD.body]
        w = S[i + P.w]
        torque, rx, ry = driven_reaction(
            S[i + P.c], S[i + P.s], w, S[i + P.aw], S[i + P.fx], S[i + P.fy], S[i + P.mz],
            S[k + D.inertia], S[k + D.moment_x], S[k + D.moment_y],
            S[k + D.weight_x], S[k + D.weight_y],
        )  # fmt: skip
        power = torque * w
        S[k + D.work] += span * power
        S[k + D.power] = power
        S[k + D.torque] = torque
        S[k + D.fx] = rx
        S[k + D.fy] = ry
        at = k + D.force_squared_max
        S[at] = larger(S[at], rx * rx + ry * ry)
        at = k + D.torque_max
        S[at] = larger(S[at], abs(torque))
    for m in range(I[H.ideal_count]):
        i = I[I[H.ideal] + JR.SIZE * m]
        at = i + R.force_squared_max
        S[at] = larger(S[at], S[i + R.fx] * S[i + R.fx] + S[i + R.fy] * S[i + R.fy])
    for m in range(I[H.body_count]):
        r = I[H.body] + JB.SIZE * m
        k = I[r + JB.row]
        i = I[r + JB.first]
        j = I[r + JB.second]
        e = I[r + JB.element]
        alpha = S[i + P.aw]
        if i != j:
            dx = S[j + P.x] - S[i + P.x]
            dy = S[j + P.y] - S[i + P.y]
            inverse = S[e + E.reference_inverse_length]
            if e == 0:
                inverse = chord(dx, dy)[1]
            alpha = chord_acceleration(dx, dy, S[j + P.ax] - S[i + P.ax], S[j + P.ay] - S[i + P.ay], inverse)
        S[k + B.alpha] = alpha
        at = k + B.alpha_max
        S[at] = larger(S[at], abs(alpha))


def joints(S, I, n, start, span, central):
    """All joints at t_n: clearances met, ideal reactions, then both again with what each does to the other."""
    dt = S[Y.step]
    h, b, k, p = central
    if I[H.clearance_count] > 0:
        meet(S, I, start, p, h)
    if I[H.ideal_count] > 0:
        levers(S, I)
        ahead(S, I, (n + 1) * dt)
        fill(S, I)
        factor(S, I)
        recall(S, I)
        close(S, I, dt, b, k)
    if I[H.clearance_count] > 0:
        velocities(S, I, p, h)
        answer(S, I, span, p * h)
    if I[H.close_again] != 0:
        close(S, I, dt, b, k)


def step(S, I, n, start):
    """One step: everything it needs and leaves is in S; functions of time are there already."""
    dt = S[Y.step]
    if I[H.damped] != 0:
        h, b, k, p = coefficients(start, dt, S[Y.damping])
    else:
        h, b, k, p = 0.0 if start else 0.5 * dt, 1.0, 0.5 * dt if start else dt, 1.0
    span = 0.5 * dt if start else dt
    drift(S, I, n * dt, 0.0 if start else dt)
    loads(S, I)
    elements(S, I, n % I[H.path_unit] == 0)
    joints(S, I, n, start, span, (h, b, k, p))
    kick(S, I, span, h, b, k, p)
    observe(S, I, span)


def advance(S, T, I, wide, rows, lanes, n0, count, out, kept, extremes):
    """Lane by lane: fills ``out[m, :, lane]`` with the rows ``kept`` after ``count`` steps more; ``extremes`` start anew before them.

    ``wide`` holds the states, rows by lanes; S is scratch for one of them. T holds the tables of all lanes, one after the other.
    """
    for w in range(lanes):
        shift = w * (len(T) // lanes)
        for q in range(rows):
            S[q] = wide[q * lanes + w]
        for m in range(out.shape[0]):
            for q in extremes:
                S[q] = 0.0
            for n in range(n0 + m * count, n0 + (m + 1) * count):
                functions(S, T, I, shift, n * S[Y.step], (n + 1) * S[Y.step])
                step(S, I, n, n == 0)
            for q in range(out.shape[1]):
                out[m, q, w] = S[kept[q]]
        for q in range(rows):
            wide[q * lanes + w] = S[q]
