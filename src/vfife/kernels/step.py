"""The step: from the state after step n - 1 to that after step n, for any mechanism.

This text is compiled once as the data-driven loop, which reads the topology from integer tables. The compiler
also traces it for one topology and writes straight-line code. Both must agree to the bit, so each sum has one
fixed order.

Step n: drift to t_n with the velocities of t_(n-1/2); forces from positions; joints, which solve for the
forces that depend on velocities at t_n; accelerations; kick to t_(n+1/2). The velocities at half steps are
algebraically equivalent to the paper's Eq. 3-5 and lose fewer digits than the difference of two positions.

Names: S is the state, I the topology, T the tables of functions; r is a record in I; i and j are rows in S of
particles, f of a function, e of an element, ``row`` of anything else.
"""

from .arrays import (
    ACTUATOR,
    BODY,
    BODY_INDEX,
    CONSTRAINT,
    DRIVEN,
    DRIVEN_INDEX,
    FRAME,
    FRAME_INDEX,
    FUNCTION,
    FUNCTION_INDEX,
    HEADER,
    JOINT_INDEX,
    LOAD,
    LOAD_INDEX,
    PARTICLE,
    PLAIN,
    SYSTEM,
    TILE_INDEX,
    UNIT,
)
from .central_difference import Central, chord_acceleration, coefficients, larger, undamped
from .closing import begin, close, hold
from .constraint import reaction
from .contact import contact_geometry, guide_forces, predict_velocities, solve_contacts
from .elementary import sincos
from .frame import axial, bending, bending_released, chord, nodal_force, step_turn, turn
from .geometry import arm, unlikely
from .polynomial import polynomial
from .spring import springs
from .topology import CURRENT, SLIDING, TIME, TRAVEL, TURNED


def travel(S, i, j, f, dt):
    """Return the travel (m) at t_n of a pin of body j from a pin of body i, along a direction fixed in body
    i, and its rate (m/s); function f gives pins and direction.
    """
    # Functions are evaluated before the bodies move (they may drive them): the drift of this step is
    # anticipated here, and velocities are those expected from the last acceleration.
    si, ci = sincos(S[i + PARTICLE.theta] + dt * S[i + PARTICLE.w])
    sj, cj = sincos(S[j + PARTICLE.theta] + dt * S[j + PARTICLE.w])
    gx, gy = arm(ci, si, S[f + FUNCTION.along_x], S[f + FUNCTION.along_y])
    rix, riy = arm(ci, si, S[f + FUNCTION.first_x], S[f + FUNCTION.first_y])
    rjx, rjy = arm(cj, sj, S[f + FUNCTION.second_x], S[f + FUNCTION.second_y])
    dx = (S[j + PARTICLE.x] + dt * S[j + PARTICLE.u] + rjx) - (
        S[i + PARTICLE.x] + dt * S[i + PARTICLE.u] + rix
    )
    dy = (S[j + PARTICLE.y] + dt * S[j + PARTICLE.v] + rjy) - (
        S[i + PARTICLE.y] + dt * S[i + PARTICLE.v] + riy
    )
    wi = S[i + PARTICLE.w] + 0.5 * dt * S[i + PARTICLE.aw]
    wj = S[j + PARTICLE.w] + 0.5 * dt * S[j + PARTICLE.aw]
    u = (S[j + PARTICLE.u] + 0.5 * dt * S[j + PARTICLE.ax] - wj * rjy) - (
        S[i + PARTICLE.u] + 0.5 * dt * S[i + PARTICLE.ax] - wi * riy
    )
    v = (S[j + PARTICLE.v] + 0.5 * dt * S[j + PARTICLE.ay] + wj * rjx) - (
        S[i + PARTICLE.v] + 0.5 * dt * S[i + PARTICLE.ay] + wi * rix
    )
    return gx * dx + gy * dy, gx * u + gy * v + wi * (gx * dy - gy * dx)


def argument(S, kind, i, j, f, time, dt):
    """Return the argument of function f at t_n: time (s), the angle of body j from body i (rad), their
    relative speed (rad/s), the travel of a pin (m), or its rate (m/s).

    ``dt`` (s) is the step that leads to t_n, 0 at the start. Speeds at t_n are those expected from the last
    acceleration. A function of travel may differ between the way out and the way back: its table then holds
    the way back first and the way out a gap later, with a kink between them.
    """
    x = time
    if kind == TURNED:
        x = (S[j + PARTICLE.theta] + dt * S[j + PARTICLE.w]) - (
            S[i + PARTICLE.theta] + dt * S[i + PARTICLE.w]
        )
    elif kind == TRAVEL or kind == SLIDING:
        at, rate = travel(S, i, j, f, dt)
        x = rate if kind == SLIDING else at - (S[f + FUNCTION.gap] if rate < 0.0 else 0.0)
    elif kind != TIME:
        x = (S[j + PARTICLE.w] + 0.5 * dt * S[j + PARTICLE.aw]) - (
            S[i + PARTICLE.w] + 0.5 * dt * S[i + PARTICLE.aw]
        )
    return x


def functions(S, T, I, n):
    """Evaluate all functions at t_n, with their first two derivatives and number of kinks passed.

    Functions of time are also evaluated at t_(n+1), because joints are closed there; of other arguments the
    value of t_n stands in.
    """
    time = (n + S[SYSTEM.shift]) * S[SYSTEM.step]
    next_time = (n + 1 + S[SYSTEM.shift]) * S[SYSTEM.step]
    dt = 0.0 if n == 0 else S[SYSTEM.step]  # the step that leads to t_n
    for r in range(I[HEADER.function], I[HEADER.function_end], FUNCTION_INDEX.SIZE):
        f = I[r + FUNCTION_INDEX.row]
        start = I[r + FUNCTION_INDEX.table]
        kind = I[r + FUNCTION_INDEX.argument]
        i = I[r + FUNCTION_INDEX.first]
        j = I[r + FUNCTION_INDEX.second]
        value, rate, second, kinks = polynomial(T, start, argument(S, kind, i, j, f, time, dt))
        S[f + FUNCTION.value] = value
        S[f + FUNCTION.rate] = rate
        S[f + FUNCTION.acceleration] = second
        S[f + FUNCTION.kinks] = kinks
        S[f + FUNCTION.next] = polynomial(T, start, next_time)[0] if kind == TIME else value


def pass_kinks(S, I):
    """Report an event if a function has passed a kink since the last step."""
    for r in range(I[HEADER.function], I[HEADER.function_end], FUNCTION_INDEX.SIZE):
        f = I[r + FUNCTION_INDEX.row]
        if unlikely(S[f + FUNCTION.kinks] != S[f + FUNCTION.passed]):
            S[SYSTEM.event] = 1.0
            S[f + FUNCTION.passed] = S[f + FUNCTION.kinks]


def drift(S, i, d):
    """Move a free particle by its half-step velocity over d (s), and set its force to its constant load."""
    S[i + PARTICLE.x] += d * S[i + PARTICLE.u]
    S[i + PARTICLE.y] += d * S[i + PARTICLE.v]
    S[i + PARTICLE.theta] += d * S[i + PARTICLE.w]
    S[i + PARTICLE.fx] = S[i + PARTICLE.load_x]
    S[i + PARTICLE.fy] = S[i + PARTICLE.load_y]
    S[i + PARTICLE.mz] = S[i + PARTICLE.load_m]


def move(S, I, time, d):
    """Move bound particles to ``time`` (s): free ones drift over d (s), driven ones turn as prescribed; then
    store sine and cosine of those that turn an arm.
    """
    for q in range(I[HEADER.bound], I[HEADER.bound_end]):
        drift(S, I[q], d)
    for r in range(I[HEADER.driven], I[HEADER.driven_end], DRIVEN_INDEX.SIZE):
        row = I[r + DRIVEN_INDEX.row]
        i = I[r + DRIVEN_INDEX.body]
        f = I[r + DRIVEN_INDEX.function]
        if f == 0:
            S[i + PARTICLE.theta] = S[row + DRIVEN.angle] + S[row + DRIVEN.speed] * time
            S[i + PARTICLE.w] = S[row + DRIVEN.speed]
            S[i + PARTICLE.aw] = 0.0
        else:
            S[i + PARTICLE.theta] = S[f + FUNCTION.value]
            S[i + PARTICLE.w] = S[f + FUNCTION.rate]
            S[i + PARTICLE.aw] = S[f + FUNCTION.acceleration]
        S[i + PARTICLE.vw] = S[i + PARTICLE.w]
        S[i + PARTICLE.fx] = S[i + PARTICLE.load_x]
        S[i + PARTICLE.fy] = S[i + PARTICLE.load_y]
        S[i + PARTICLE.mz] = S[i + PARTICLE.load_m]
    for q in range(I[HEADER.trig], I[HEADER.trig_end]):
        i = I[q]
        S[i + PARTICLE.s], S[i + PARTICLE.c] = sincos(S[i + PARTICLE.theta])


def load(S, row, i, follow, value):
    """Return the force (N, N) and the moment about particle i (N m) of the load in row ``row``, for a
    ``value`` of its function; the force turns with the body if ``follow`` is not 0.
    """
    c = S[i + PARTICLE.c]
    s = S[i + PARTICLE.s]
    rx, ry = arm(c, s, S[row + LOAD.x], S[row + LOAD.y])
    px = value * S[row + LOAD.fx]
    py = value * S[row + LOAD.fy]
    if follow != 0:
        px, py = arm(c, s, px, py)
    return px, py, rx * py - ry * px + value * S[row + LOAD.m]


def loads(S, I):
    """Add the loads at t_n that depend on time, speed, angle or travel to the forces."""
    for r in range(I[HEADER.load], I[HEADER.load_end], LOAD_INDEX.SIZE):
        i = I[r + LOAD_INDEX.body]
        value = S[I[r + LOAD_INDEX.function] + FUNCTION.value]
        px, py, moment = load(S, I[r + LOAD_INDEX.row], i, I[r + LOAD_INDEX.follow], value)
        S[i + PARTICLE.fx] += px
        S[i + PARTICLE.fy] += py
        S[i + PARTICLE.mz] += moment


def elements(S, I, first, end, renew):
    """Add the internal forces of elements by the reversed rigid-body motion (paper Eq. 6-13); if ``renew``,
    make the present configuration the reference of a new path unit.

    ``first`` and ``end`` are records in I. The stiffness refers to the element's length at the reference, as
    in the paper, or to its length without forces. If a path unit is one step long, the forces at its start
    are those of the last step: they share the rows of the present forces.
    """
    single = I[HEADER.path_unit] == 1
    for r in range(first, end, FRAME_INDEX.SIZE):
        e = I[r + FRAME_INDEX.row]
        i = I[r + FRAME_INDEX.first]
        j = I[r + FRAME_INDEX.second]
        a = I[r + FRAME_INDEX.unit]
        length, inverse, c, s = chord(
            S[j + PARTICLE.x] - S[i + PARTICLE.x], S[j + PARTICLE.y] - S[i + PARTICLE.y]
        )
        ila = S[e + FRAME.reference_inverse_length]
        na = S[e + FRAME.axial_force] if single else S[a + UNIT.reference_axial_force]
        n = axial(length, S[e + FRAME.reference_length], ila, na, S[e + FRAME.axial_stiffness])
        m1, m2 = end_moments(S, I, r, c, s, single)
        px, py = nodal_force(c, s, inverse, n, m1, m2)
        S[i + PARTICLE.fx] += px
        S[i + PARTICLE.fy] += py
        S[i + PARTICLE.mz] -= m1
        S[j + PARTICLE.fx] -= px
        S[j + PARTICLE.fy] -= py
        S[j + PARTICLE.mz] -= m2
        S[e + FRAME.axial_force] = n
        S[e + FRAME.moment_1] = m1
        S[e + FRAME.moment_2] = m2
        if renew:
            S[e + FRAME.reference_length] = length
            if I[r + FRAME_INDEX.strain] == CURRENT:
                S[e + FRAME.reference_inverse_length] = inverse
            S[e + FRAME.reference_cosine] = c
            S[e + FRAME.reference_sine] = s
            S[e + FRAME.reference_theta_1] = S[i + PARTICLE.theta]
            S[e + FRAME.reference_theta_2] = S[j + PARTICLE.theta]
            if not single:
                S[a + UNIT.reference_axial_force] = n
                S[a + UNIT.reference_moment_1] = m1
                S[a + UNIT.reference_moment_2] = m2


def end_moments(S, I, r, c, s, single):
    """Return the moments (N m) at both ends of element r, whose chord has the direction (c, s).

    ``release`` has bit 1 for a released first end and bit 2 for a released second end; a released end has no
    moment.
    """
    e = I[r + FRAME_INDEX.row]
    a = I[r + FRAME_INDEX.unit]
    release = I[r + FRAME_INDEX.release]
    m1 = 0.0
    m2 = 0.0
    if release != 3:
        ila = S[e + FRAME.reference_inverse_length]
        ei = S[e + FRAME.bending_stiffness]
        m1a = S[e + FRAME.moment_1] if single else S[a + UNIT.reference_moment_1]
        m2a = S[e + FRAME.moment_2] if single else S[a + UNIT.reference_moment_2]
        ca = S[e + FRAME.reference_cosine]
        sa = S[e + FRAME.reference_sine]
        rigid = step_turn(c, s, ca, sa) if single else turn(c, s, ca, sa)
        theta_1 = S[I[r + FRAME_INDEX.first] + PARTICLE.theta] - S[e + FRAME.reference_theta_1] - rigid
        theta_2 = S[I[r + FRAME_INDEX.second] + PARTICLE.theta] - S[e + FRAME.reference_theta_2] - rigid
        if release == 0:
            m1, m2 = bending(theta_1, theta_2, ila, m1a, m2a, ei)
        elif release == 1:
            m2 = bending_released(theta_2, ila, m2a, ei)
        else:
            m1 = bending_released(theta_1, ila, m1a, ei)
    return m1, m2


def kick(S, i, central: Central):
    """Store the acceleration at t_n and the velocity at t_(n+1/2) of a free particle; return its velocity at
    t_n (m/s, m/s, rad/s).
    """
    h, decay, gain, p = central
    im = S[i + PARTICLE.inverse_mass]
    ii = S[i + PARTICLE.inverse_inertia]
    ax = im * S[i + PARTICLE.fx]
    ay = im * S[i + PARTICLE.fy]
    aw = ii * S[i + PARTICLE.mz]
    u = S[i + PARTICLE.u]
    v = S[i + PARTICLE.v]
    w = S[i + PARTICLE.w]
    un = p * (u + h * ax)
    vn = p * (v + h * ay)
    wn = p * (w + h * aw)
    S[i + PARTICLE.ax] = ax
    S[i + PARTICLE.ay] = ay
    S[i + PARTICLE.aw] = aw
    S[i + PARTICLE.u] = decay * u + gain * ax
    S[i + PARTICLE.v] = decay * v + gain * ay
    S[i + PARTICLE.w] = decay * w + gain * aw
    return un, vn, wn


def damping_power(S, i, zeta, u, v, w):
    """Return the power (W) that mass-proportional damping takes from particle i at the velocities of t_n."""
    ii = S[i + PARTICLE.inverse_inertia]
    return zeta * ((u * u + v * v) / S[i + PARTICLE.inverse_mass] + (w * w / ii if ii > 0.0 else 0.0))


def tiles(S, I, renew, d, central: Central):
    """Step all elements tile by tile: drift the plain particles that a tile needs, add its elements' forces,
    and kick the particles that no later tile needs, while all of them are in the cache.

    Three passes, over particles, elements and particles again, would load each record several times. The
    ranges are made in :func:`vfife.compiler.trace.tables.tiles`.
    """
    damping = 0.0
    zeta = S[SYSTEM.damping]
    damped = I[HEADER.damped] != 0
    for r in range(I[HEADER.tile], I[HEADER.tile_end], TILE_INDEX.SIZE):
        for i in range(I[r + TILE_INDEX.drift], I[r + TILE_INDEX.drift_end], PLAIN):
            drift(S, i, d)
        frames = I[HEADER.frame]
        elements(
            S,
            I,
            frames + FRAME_INDEX.SIZE * I[r + TILE_INDEX.frame],
            frames + FRAME_INDEX.SIZE * I[r + TILE_INDEX.frame_end],
            renew,
        )
        for i in range(I[r + TILE_INDEX.kick], I[r + TILE_INDEX.kick_end], PLAIN):
            un, vn, wn = kick(S, i, central)
            if damped:
                damping += damping_power(S, i, zeta, un, vn, wn)
    if damped:
        S[SYSTEM.damping_power] = damping


def settle(S, I, span, central: Central):
    """Kick the bound particles; store the powers (W) at t_n of mass-proportional damping and of variable
    loads, and add them times ``span`` (s) to their works.
    """
    damping = 0.0
    zeta = S[SYSTEM.damping]
    damped = I[HEADER.damped] != 0
    worked = I[HEADER.worked] != 0
    for q in range(I[HEADER.bound], I[HEADER.bound_end]):
        i = I[q]
        un, vn, wn = kick(S, i, central)
        if worked:
            S[i + PARTICLE.vu] = un
            S[i + PARTICLE.vv] = vn
            S[i + PARTICLE.vw] = wn
        if damped:
            damping += damping_power(S, i, zeta, un, vn, wn)
    if damped:
        damping += S[SYSTEM.damping_power]
        S[SYSTEM.damping_work] += span * damping
        S[SYSTEM.damping_power] = damping
    if worked:
        power = external_power(S, I)
        S[SYSTEM.external_work] += span * power
        S[SYSTEM.external_power] = power


def external_power(S, I):
    """Return the power (W) at t_n of variable loads, and of prescribed motions that have no actuator."""
    power = 0.0
    for r in range(I[HEADER.load], I[HEADER.load_end], LOAD_INDEX.SIZE):
        i = I[r + LOAD_INDEX.body]
        value = S[I[r + LOAD_INDEX.function] + FUNCTION.value]
        px, py, moment = load(S, I[r + LOAD_INDEX.row], i, I[r + LOAD_INDEX.follow], 1.0)
        power += value * (px * S[i + PARTICLE.vu] + py * S[i + PARTICLE.vv] + moment * S[i + PARTICLE.vw])
    for r in range(I[HEADER.joint], I[HEADER.joint_end], JOINT_INDEX.SIZE):
        f = I[r + JOINT_INDEX.function]
        if f != 0 and I[r + JOINT_INDEX.actuator] == 0:
            power += S[I[r + JOINT_INDEX.first] + CONSTRAINT.force] * S[f + FUNCTION.rate]
    return power


def observe(S, I, span):
    """Store forces, torques and works of drivers, reactions of ideal joints and angular accelerations of
    bodies at t_n, with their extremes.
    """
    for r in range(I[HEADER.driven], I[HEADER.driven_end], DRIVEN_INDEX.SIZE):
        observe_driver(S, I[r + DRIVEN_INDEX.row], I[r + DRIVEN_INDEX.body], span)
    for r in range(I[HEADER.joint], I[HEADER.joint_end], JOINT_INDEX.SIZE):
        reaction(S, I, r)
        if I[r + JOINT_INDEX.actuator] != 0:
            force = S[I[r + JOINT_INDEX.first] + CONSTRAINT.force]
            rate = S[I[r + JOINT_INDEX.function] + FUNCTION.rate]
            observe_actuator(S, I[r + JOINT_INDEX.actuator], force, rate, span)
    for r in range(I[HEADER.body], I[HEADER.body_end], BODY_INDEX.SIZE):
        row = I[r + BODY_INDEX.row]
        i = I[r + BODY_INDEX.first]
        j = I[r + BODY_INDEX.second]
        e = I[r + BODY_INDEX.frame]
        alpha = S[i + PARTICLE.aw]
        if i != j:
            dx = S[j + PARTICLE.x] - S[i + PARTICLE.x]
            dy = S[j + PARTICLE.y] - S[i + PARTICLE.y]
            inverse = S[e + FRAME.reference_inverse_length]
            if e == 0:
                inverse = chord(dx, dy)[1]
            alpha = chord_acceleration(
                dx,
                dy,
                S[j + PARTICLE.ax] - S[i + PARTICLE.ax],
                S[j + PARTICLE.ay] - S[i + PARTICLE.ay],
                inverse,
            )
        S[row + BODY.alpha] = alpha
        S[row + BODY.alpha_max] = larger(S[row + BODY.alpha_max], abs(alpha))


def observe_driver(S, row, i, span):
    """Store torque, power and work of the driver in row ``row`` on body i, and the ground's force on that
    body, from the balance of moments and forces.

    The body turns about a fixed pivot, its particle. (rx, ry) is mass times centre of mass seen from there
    (kg m); the acceleration of the centre of mass is alpha x r - w^2 r. What loads and joints contribute to
    the balance is in the particle's force and moment already.
    """
    w = S[i + PARTICLE.w]
    alpha = S[i + PARTICLE.aw]
    rx, ry = arm(S[i + PARTICLE.c], S[i + PARTICLE.s], S[row + DRIVEN.moment_x], S[row + DRIVEN.moment_y])
    ww = w * w
    torque = (
        S[row + DRIVEN.inertia] * alpha
        - S[i + PARTICLE.mz]
        - (rx * S[row + DRIVEN.weight_y] - ry * S[row + DRIVEN.weight_x])
    )
    fx = -alpha * ry - ww * rx - S[i + PARTICLE.fx]
    fy = alpha * rx - ww * ry - S[i + PARTICLE.fy]
    power = torque * w
    S[row + DRIVEN.work] += span * power
    S[row + DRIVEN.power] = power
    S[row + DRIVEN.torque] = torque
    S[row + DRIVEN.fx] = fx
    S[row + DRIVEN.fy] = fy
    S[row + DRIVEN.force_squared_max] = larger(S[row + DRIVEN.force_squared_max], fx * fx + fy * fy)
    S[row + DRIVEN.torque_max] = larger(S[row + DRIVEN.torque_max], abs(torque))


def observe_actuator(S, row, force, rate, span):
    """Store the force (N, N m) of the actuator in row ``row``, its power and its work; ``rate`` (m/s, rad/s)
    is that of the motion that it prescribes.
    """
    power = force * rate
    S[row + ACTUATOR.work] += span * power
    S[row + ACTUATOR.power] = power
    S[row + ACTUATOR.force] = force
    S[row + ACTUATOR.force_max] = larger(S[row + ACTUATOR.force_max], abs(force))


def joints(S, I, start, span, central: Central):
    """Solve all joints at t_n: geometry of contacts, ideal reactions, contact forces, then ideal reactions
    again where contacts have changed them.

    Contact forces depend on the velocities under the reactions, and the reactions on contact forces. An exact
    solution is one nonlinear system with as many unknowns as joints. Here each contact is solved once, with
    the response of all ideal joints to its force (:func:`~vfife.kernels.constraint.joint_compliance`), and
    the second :func:`~vfife.kernels.closing.close` removes what that linear response leaves open.
    """
    if I[HEADER.contact_count] > 0:
        contact_geometry(S, I, start, central)
    if I[HEADER.joint_count] > 0:
        hold(S, I, start, central)
    if I[HEADER.contact_count] > 0:
        predict_velocities(S, I, central)
        solve_contacts(S, I, span, central)
        guide_forces(S, I)
    if I[HEADER.close_again] != 0:
        close(S, I, central)
    if unlikely(start):
        begin(S, I)


def step(S, I, n, start):
    """Take step n; ``start`` marks step 0. The state S holds all that the step reads and writes, and
    :func:`functions` has been called for it.
    """
    dt = S[SYSTEM.step]
    central = coefficients(start, dt, S[SYSTEM.damping]) if I[HEADER.damped] != 0 else undamped(start, dt)
    # Step 0 does not move: it evaluates the forces of the start and kicks over half a step. Works of step n
    # run from t_(n-1/2) to t_(n+1/2).
    span = 0.5 * dt if start else dt
    d = 0.0 if start else dt
    S[SYSTEM.event] = 0.0
    pass_kinks(S, I)
    move(S, I, (n + S[SYSTEM.shift]) * dt, d)
    tiles(S, I, n % max(I[HEADER.path_unit], 1) == 0, d, central)
    loads(S, I)
    springs(S, I, span, central)
    joints(S, I, start, span, central)
    settle(S, I, span, central)
    observe(S, I, span)
