"""The data-driven step: any mechanism, compiled once, the topology read from integer tables.

``generate.py`` writes the same step out for one topology; the two must agree to the bit, so each sum here has one fixed order. The step n:
drift to t_n, forces from positions, joints, accelerations, kick to t_(n+1/2). Velocities at half steps are algebraically the paper's Eq. 3-5.
"""

from .arrays import JB, JD, JE, JF, JL, JR, JT, PLAIN, B, D, E, F, H, L, P, Q, R, U, Y
from .central_difference import chord_acceleration, coefficients, driven_reaction, larger
from .constraint import ahead, close, fill, levers, reaction, recall
from .contact import answer, meet, velocities
from .elementary import sincos
from .frame import axial, bending, bending_released, chord, nodal_force, step_turn, turn
from .geometry import arm
from .polynomial import polynomial
from .spring import springs
from .topology import TIME, TURNED


def functions(S, T, I, shift, time, after, dt):
    """Functions at t_n, and their value at t_(n+1): of time, of the angle between two bodies, or of their relative speed.

    ``dt`` is the step that leads to t_n, 0 at the start. The speed at t_n is expected from the last step's acceleration.
    """
    for m in range(I[H.function_count]):
        r = I[H.function] + JF.SIZE * m
        f = I[r + JF.row]
        start = shift + I[r + JF.table]
        argument = I[r + JF.argument]
        i = I[r + JF.first]
        j = I[r + JF.second]
        x = time
        if argument == TURNED:
            x = (S[j + P.theta] + dt * S[j + P.w]) - (S[i + P.theta] + dt * S[i + P.w])
        elif argument != TIME:
            x = (S[j + P.w] + 0.5 * dt * S[j + P.aw]) - (S[i + P.w] + 0.5 * dt * S[i + P.aw])
        value, rate, second = polynomial(T, start, x)
        S[f + F.value] = value
        S[f + F.rate] = rate
        S[f + F.acceleration] = second
        S[f + F.next] = polynomial(T, start, after)[0] if argument == TIME else value


def drift(S, i, d):
    """Position of a free particle at t_n by its half-step velocity; its force starts with its constant load."""
    S[i + P.x] += d * S[i + P.u]
    S[i + P.y] += d * S[i + P.v]
    S[i + P.theta] += d * S[i + P.w]
    S[i + P.fx] = S[i + P.load_x]
    S[i + P.fy] = S[i + P.load_y]
    S[i + P.mz] = S[i + P.load_m]


def move(S, I, time, d):
    """Bound particles at t_n: free ones drift, driven ones go as prescribed; then directions."""
    for q in range(I[H.bound_count]):
        drift(S, I[I[H.bound] + q], d)
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
        S[i + P.fx] = S[i + P.load_x]
        S[i + P.fy] = S[i + P.load_y]
        S[i + P.mz] = S[i + P.load_m]
    for q in range(I[H.trig_count]):
        i = I[I[H.trig] + q]
        S[i + P.s], S[i + P.c] = sincos(S[i + P.theta])


def loads(S, I):
    """Loads over time, speed or angle, at t_n."""
    for m in range(I[H.load_count]):
        r = I[H.load] + JL.SIZE * m
        k = I[r + JL.row]
        i = I[r + JL.body]
        value = S[I[r + JL.function] + F.value]
        rx, ry = arm(S[i + P.c], S[i + P.s], S[k + L.x], S[k + L.y])
        px = value * S[k + L.fx]
        py = value * S[k + L.fy]
        if I[r + JL.follow] != 0:
            px, py = arm(S[i + P.c], S[i + P.s], px, py)
        S[i + P.fx] += px
        S[i + P.fy] += py
        S[i + P.mz] += rx * py - ry * px + value * S[k + L.m]


def elements(S, I, first, last, renew):
    """Element forces from the reversed rigid-body motion; the reference is renewed where a path unit ends."""
    own = I[H.path_unit] == 1
    for m in range(first, last):
        r = I[H.element] + JE.SIZE * m
        e = I[r + JE.row]
        i = I[r + JE.first]
        j = I[r + JE.second]
        a = I[r + JE.unit]
        length, inverse, c, s = chord(S[j + P.x] - S[i + P.x], S[j + P.y] - S[i + P.y])
        ila = S[e + E.reference_inverse_length]
        na = S[e + E.axial_force] if own else S[a + U.reference_axial_force]
        n = axial(length, S[e + E.reference_length], ila, na, S[e + E.axial_stiffness])
        release = I[r + JE.release]
        m1 = 0.0
        m2 = 0.0
        if release != 3:
            ei = S[e + E.bending_stiffness]
            m1a = S[e + E.moment_1] if own else S[a + U.reference_moment_1]
            m2a = S[e + E.moment_2] if own else S[a + U.reference_moment_2]
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
                S[a + U.reference_axial_force] = n
                S[a + U.reference_moment_1] = m1
                S[a + U.reference_moment_2] = m2


def kick(S, i, h, b, k, p):
    """Acceleration of a free particle at t_n and its velocity at t_(n+1/2); returned: its velocity at t_n."""
    im = S[i + P.inverse_mass]
    ii = S[i + P.inverse_inertia]
    ax = im * S[i + P.fx]
    ay = im * S[i + P.fy]
    aw = ii * S[i + P.mz]
    u = S[i + P.u]
    v = S[i + P.v]
    w = S[i + P.w]
    un = p * (u + h * ax)
    vn = p * (v + h * ay)
    wn = p * (w + h * aw)
    S[i + P.ax] = ax
    S[i + P.ay] = ay
    S[i + P.aw] = aw
    S[i + P.u] = b * u + k * ax
    S[i + P.v] = b * v + k * ay
    S[i + P.w] = b * w + k * aw
    return un, vn, wn


def lost_power(S, i, zeta, u, v, w):
    """Power that mass-proportional damping takes from a particle."""
    ii = S[i + P.inverse_inertia]
    return zeta * ((u * u + v * v) / S[i + P.inverse_mass] + (w * w / ii if ii > 0.0 else 0.0))


def tiles(S, I, renew, d, h, b, k, p):
    """Elements, with the plain particles around them drifting just before and kicked just after, while they are in the cache."""
    lost = 0.0
    zeta = S[Y.damping]
    damped = I[H.damped] != 0
    for m in range(I[H.tile_count]):
        r = I[H.tile] + JT.SIZE * m
        for q in range(I[r + JT.drift], I[r + JT.drift_end]):
            drift(S, I[H.plain] + PLAIN * q, d)
        elements(S, I, I[r + JT.element], I[r + JT.element_end], renew)
        for q in range(I[r + JT.kick], I[r + JT.kick_end]):
            i = I[H.plain] + PLAIN * q
            un, vn, wn = kick(S, i, h, b, k, p)
            if damped:
                lost += lost_power(S, i, zeta, un, vn, wn)
    if damped:
        S[Y.damping_power] = lost


def settle(S, I, span, h, b, k, p):
    """Kick of the bound particles; power of damping, of time-dependent loads and of prescribed travels at t_n."""
    lost = 0.0
    zeta = S[Y.damping]
    damped = I[H.damped] != 0
    worked = I[H.worked] != 0
    for q in range(I[H.bound_count]):
        i = I[I[H.bound] + q]
        un, vn, wn = kick(S, i, h, b, k, p)
        if worked:
            S[i + P.vu] = un
            S[i + P.vv] = vn
            S[i + P.vw] = wn
        if damped:
            lost += lost_power(S, i, zeta, un, vn, wn)
    if damped:
        lost += S[Y.damping_power]
        S[Y.damping_work] += span * lost
        S[Y.damping_power] = lost
    if worked:
        power = outside(S, I)
        S[Y.external_work] += span * power
        S[Y.external_power] = power


def outside(S, I):
    """Power of time-dependent loads and of prescribed travels at t_n."""
    power = 0.0
    for m in range(I[H.load_count]):
        r = I[H.load] + JL.SIZE * m
        g = I[r + JL.row]
        i = I[r + JL.body]
        value = S[I[r + JL.function] + F.value]
        rx, ry = arm(S[i + P.c], S[i + P.s], S[g + L.x], S[g + L.y])
        px = S[g + L.fx]
        py = S[g + L.fy]
        if I[r + JL.follow] != 0:
            px, py = arm(S[i + P.c], S[i + P.s], px, py)
        turning = rx * py - ry * px + S[g + L.m]
        power += value * (px * S[i + P.vu] + py * S[i + P.vv] + turning * S[i + P.vw])
    for m in range(I[H.ideal_count]):
        r = I[H.ideal] + JR.SIZE * m
        f = I[r + JR.function]
        if f != 0:
            power += S[I[r + JR.first] + Q.force] * S[f + F.rate]
    return power


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
        reaction(S, I, I[H.ideal] + JR.SIZE * m)
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
        recall(S, I)
        close(S, I, dt, b, k, True)
    if I[H.clearance_count] > 0:
        velocities(S, I, p, h)
        answer(S, I, span, central)
    if I[H.close_again] != 0 or (start and I[H.ideal_count] > 0):
        close(S, I, dt, b, k, False)


def step(S, I, n, start):
    """One step: everything it needs and leaves is in S; functions of time are there already."""
    dt = S[Y.step]
    if I[H.damped] != 0:
        h, b, k, p = coefficients(start, dt, S[Y.damping])
    else:
        h, b, k, p = 0.0 if start else 0.5 * dt, 1.0, 0.5 * dt if start else dt, 1.0
    span = 0.5 * dt if start else dt
    d = 0.0 if start else dt
    move(S, I, n * dt, d)
    tiles(S, I, n % I[H.path_unit] == 0, d, h, b, k, p)
    loads(S, I)
    springs(S, I, span, p, h)
    joints(S, I, n, start, span, (h, b, k, p))
    settle(S, I, span, h, b, k, p)
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
                functions(S, T, I, shift, n * S[Y.step], (n + 1) * S[Y.step], 0.0 if n == 0 else S[Y.step])
                step(S, I, n, n == 0)
            for q in range(out.shape[1]):
                out[m, q, w] = S[kept[q]]
        for q in range(rows):
            wide[q * lanes + w] = S[q]
