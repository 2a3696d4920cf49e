"""Contacts in clearance joints: geometry, onset, and the contact force at t_n (paper Eq. 18-33).

A journal touches the bearing around it, a round beside it, a straight line (the wall of a guide, touched by
the corners of a block), or the nearer wall of a slot along a path.

Damping and friction are stiff: both depend on the velocity at t_n, which a central difference computes only
after the forces. Each joint therefore solves for its force in closed form. Joints that share a body are
solved one after the other, starting from the forces of the last step.

Names: S is the state and I the topology (:mod:`~vfife.kernels.arrays`). r is the record of a contact in I.
j, b, k and i are rows in S: of the joint, of the particle of its bearing, of the particle of its journal, and
of any particle. n points from bearing to journal; t is n turned anticlockwise, so n = (nx, ny) and
t = (-ny, nx). jn, jt and bn, bt are the levers (m) of forces along n and t about the particles of journal and
bearing. The force on the journal is -F_N n + F_T t. gn, gt and gm are mobilities: the change of velocity
along n per F_N, along t per F_T, and along t per F_N; first as inverse masses (1/kg), then multiplied by h
(m/s/N).

Order of a step, in :func:`~vfife.kernels.step.joints`: :func:`contact_geometry`; then ideal joints, whose
reactions depend on the forces put in place there; :func:`predict_velocities`; :func:`solve_contacts`;
:func:`guide_forces`; then ideal joints are closed again where a contact moved them.
"""

from typing import Any

from .arrays import CONTACT, CONTACT_INDEX, GUIDE, GUIDE_INDEX, HEADER, PARTICLE, SYSTEM, WEAR
from .central_difference import Central, larger
from .constraint import Row, apply_response, bodies, joint_compliance
from .contact_forces import (
    apply_contact_force,
    approach_rate,
    eliminate_film,
    film_coefficients,
    film_force,
    sliding_rate,
    solve_simultaneous,
    update_velocities,
)
from .geometry import arm, eccentricity, in_slot, normal_force, onset_speed, unlikely
from .tabled import tabled_law, turned_slowness
from .topology import LINE, ROUND, SLOT
from .wear import profile_geometry, rub

# A set-valued law that sticks leaves zero velocity up to rounding: less than this share of the velocity that
# there would be without friction counts as zero.
STICKS = 1e-9

# Written by the compiler (compiler/trace/source.py) for the laws of a mechanism.
WRITTEN: Any = None
contact_law = friction_law = friction_regime = WRITTEN


def predict_velocities(S, I, central: Central):
    """Store the velocities at t_n (m/s, rad/s) of the particles in clearance joints under the forces so far.

    Solving a contact updates them, so that the next contact on the same body starts from what the one before
    has changed.
    """
    for q in range(I[HEADER.jointed], I[HEADER.jointed_end]):
        i = I[q]
        im = central.h * S[i + PARTICLE.inverse_mass]
        S[i + PARTICLE.vu] = central.p * (S[i + PARTICLE.u] + im * S[i + PARTICLE.fx])
        S[i + PARTICLE.vv] = central.p * (S[i + PARTICLE.v] + im * S[i + PARTICLE.fy])
        S[i + PARTICLE.vw] = central.p * (
            S[i + PARTICLE.w] + (central.h * S[i + PARTICLE.inverse_inertia]) * S[i + PARTICLE.mz]
        )


def expected_velocity(S, i, central: Central):
    """Return the velocity (m/s, m/s, rad/s) at t_n of a particle if it keeps the acceleration of t_(n-1).

    A driven particle turns at its prescribed speed, which is that of t_n already.
    """
    h, _, _, p = central
    turning = S[i + PARTICLE.inverse_inertia] > 0.0
    w = p * (S[i + PARTICLE.w] + h * S[i + PARTICLE.aw]) if turning else S[i + PARTICLE.w]
    return (
        p * (S[i + PARTICLE.u] + h * S[i + PARTICLE.ax]),
        p * (S[i + PARTICLE.v] + h * S[i + PARTICLE.ay]),
        w,
    )


def expected_rate(S, j, b, k, central: Central):
    """Return the rate of the penetration (m/s) at t_n if both bodies keep the accelerations of t_(n-1)."""
    bu, bv, bw = expected_velocity(S, b, central)
    ku, kv, kw = expected_velocity(S, k, central)
    return (
        S[j + CONTACT.nx] * (ku - bu)
        + S[j + CONTACT.ny] * (kv - bv)
        + S[j + CONTACT.jn] * kw
        - S[j + CONTACT.bn] * bw
    )


def onset(S, I, r, depth, start, stretch, central: Central):
    """Begin a contact: locate the impact speed inside the step, hold it until the surfaces part, and count
    the contact.

    ``depth`` is the penetration (m) at t_n; CONTACT.penetration is still that of t_(n-1).
    :func:`~vfife.kernels.geometry.onset_speed` computes the speed where the penetration passes zero between
    the two.
    """
    j = I[r + CONTACT_INDEX.row]
    dt = S[SYSTEM.step]
    rate = stretch * expected_rate(S, j, I[r + CONTACT_INDEX.bearing], I[r + CONTACT_INDEX.journal], central)
    # At the start there is no penetration before from which to interpolate.
    located = rate if start else onset_speed(depth, S[j + CONTACT.penetration], rate, dt)
    # Damping is proportional to rate / impact speed and explodes for contacts that begin with almost no
    # speed. The floor of the joint bounds it; ``grazing`` counts how often it was needed.
    slow = located < S[j + CONTACT.floor]
    S[j + CONTACT.slowness] = 1.0 / (S[j + CONTACT.floor] if slow else located)
    S[j + CONTACT.onsets] += 1.0
    S[j + CONTACT.grazing] += 1.0 if slow else 0.0
    S[j + CONTACT.deep] += 1.0 if depth > S[j + CONTACT.landing] else 0.0
    S[j + CONTACT.deepest] = larger(S[j + CONTACT.deepest], depth)
    S[j + CONTACT.fastest] = larger(S[j + CONTACT.fastest], located)
    S[j + CONTACT.approach] += located
    S[j + CONTACT.duration] -= dt  # detect_contact adds it: the first step of a contact is not counted
    S[SYSTEM.event] = 1.0


def evaluate_law(S, I, r, depth, slowness, stretch, central: Central):
    """Return elastic force (N) and damping coefficient (N s/m) of contact r from its law's function or its
    table, at penetration ``depth`` (m) and ``slowness`` = 1/impact speed (s/m).
    """
    j = I[r + CONTACT_INDEX.row]
    if I[r + CONTACT_INDEX.knots] != 0:
        # A table has a loading and an unloading branch. Which one holds depends on the sign of the rate,
        # which is not solved yet: the expected rate decides.
        rate = stretch * expected_rate(
            S, j, I[r + CONTACT_INDEX.bearing], I[r + CONTACT_INDEX.journal], central
        )
        turned = turned_slowness(slowness, S[j + CONTACT.slots], rate)
        elastic, damping = tabled_law(S, I[r + CONTACT_INDEX.knot], I[r + CONTACT_INDEX.knots], depth, turned)
    else:
        elastic, damping = contact_law(I[r + CONTACT_INDEX.contact], depth, slowness, S, j + CONTACT.slots)
    return elastic, damping


def measure_gap(S, I, r, ex, ey):
    """Return signed penetration (m), normal, and two corrections of the bearing's levers (m) of contact r.

    (ex, ey) is the journal's centre seen from the bearing's pin (m). In a round bearing this vector is
    parallel to n, and the levers follow from the pin. On a line or in a slot the journal's centre also moves
    along t, by ``tangential_offset``, and its coordinate along n exceeds the distance from the slot's middle
    by ``normal_offset``: the force acts there, which changes its levers about the bearing's particle.
    """
    j = I[r + CONTACT_INDEX.row]
    b = I[r + CONTACT_INDEX.bearing]
    kind = I[r + CONTACT_INDEX.kind]
    tangential_offset = 0.0
    normal_offset = 0.0
    if kind == LINE:
        nx, ny = arm(S[b + PARTICLE.c], S[b + PARTICLE.s], S[j + CONTACT.line_x], S[j + CONTACT.line_y])
        depth = (nx * ex + ny * ey) - S[j + CONTACT.size]
        tangential_offset = nx * ey - ny * ex
    elif kind == SLOT:
        away, nx, ny = in_slot(
            S,
            I[r + CONTACT_INDEX.piece],
            I[r + CONTACT_INDEX.pieces],
            S[b + PARTICLE.c],
            S[b + PARTICLE.s],
            ex,
            ey,
        )
        depth = away - S[j + CONTACT.size]
        tangential_offset = nx * ey - ny * ex
        normal_offset = (nx * ex + ny * ey) - away
    else:
        depth, nx, ny = eccentricity(ex, ey, S[j + CONTACT.size])
        if kind == ROUND:
            # Two rounds touch when their centres come near, a journal touches its bearing when they part:
            # depth and normal change their signs.
            depth = -depth
            nx = -nx
            ny = -ny
    return depth, nx, ny, tangential_offset, normal_offset


def contact_geometry(S, I, start, central: Central):
    """Store geometry and law of every clearance joint, begin and end contacts, and apply the last step's
    forces where joints share a body.
    """
    for r in range(I[HEADER.contact], I[HEADER.contact_end], CONTACT_INDEX.SIZE):
        depth, stretch = locate_contact(S, I, r)
        detect_contact(S, I, r, depth, start, stretch, central)
        put_last_forces(S, I, r, central.h)


def locate_contact(S, I, r):
    """Store normal and levers of contact r; return its penetration (m) and the stretch of a worn surface: the
    length of the penetration's gradient, 1 where nothing is worn.
    """
    j, b, k = bodies(I, r)
    bx, by = arm(S[b + PARTICLE.c], S[b + PARTICLE.s], S[j + CONTACT.bearing_x], S[j + CONTACT.bearing_y])
    kx, ky = arm(S[k + PARTICLE.c], S[k + PARTICLE.s], S[j + CONTACT.journal_x], S[j + CONTACT.journal_y])
    ex = (S[k + PARTICLE.x] + kx) - (S[b + PARTICLE.x] + bx)
    ey = (S[k + PARTICLE.y] + ky) - (S[b + PARTICLE.y] + by)
    depth, nx, ny, tangential_offset, normal_offset = measure_gap(S, I, r, ex, ey)
    w = I[r + CONTACT_INDEX.wear]
    if w != 0:
        S[w + WEAR.nx] = nx
        S[w + WEAR.ny] = ny
    stretch = 1.0
    turns = 0.0
    journal_wear = 0.0
    if I[r + CONTACT_INDEX.bearing_count] + I[r + CONTACT_INDEX.journal_count] != 0:
        # A worn surface shifts the place of contact, and the law sees the penetration stretched along the
        # normal.
        depth, nx, ny, tangential_offset, turns, stretch = profile_geometry(S, I, r, depth, nx, ny)
        journal_wear = S[w + WEAR.journal] if I[r + CONTACT_INDEX.journal_count] != 0 else 0.0
        normal_offset = (nx * ex + ny * ey) - (depth + S[j + CONTACT.size]) - journal_wear
    # Friction acts at the surface, a radius from the pin's centre, which the penetration shifts by a share
    # (arm_overlap) of itself.
    overlap = S[j + CONTACT.arm_overlap] * depth
    S[j + CONTACT.nx] = nx
    S[j + CONTACT.ny] = ny
    S[j + CONTACT.jn] = kx * ny - ky * nx + turns
    S[j + CONTACT.bn] = bx * ny - by * nx - tangential_offset
    S[j + CONTACT.jt] = kx * nx + ky * ny + (S[j + CONTACT.arm_journal] - overlap) - journal_wear
    S[j + CONTACT.bt] = bx * nx + by * ny + (S[j + CONTACT.arm_bearing] + overlap) + normal_offset
    return depth, stretch


def detect_contact(S, I, r, depth, start, stretch, central: Central):
    """Begin or end a contact by its penetration (m), and evaluate its law.

    A contact begins when the penetration becomes positive and ends when it is zero or negative. Two rows of
    the state show a contact: CONTACT.slowness is positive in contact and zero otherwise, and
    CONTACT.penetration is positive in contact only. The penetration decides whether there is a force; it is
    also tested in ``put_last_forces``, ``contact_forces.solve_simultaneous``, ``solvers/statics.py`` and
    ``measures/`` (forces, contacts), which a limit other than zero concerns, too. The slowness decides
    whether the next touch is an onset. Tests: ``tests/kernels/test_onset_rule.py``.
    """
    j = I[r + CONTACT_INDEX.row]
    touching = depth > 0.0
    # Onset and end of a contact are events: the step is taken again in parts, so that the impact speed is
    # located within an eighth of it.
    if unlikely(touching and S[j + CONTACT.slowness] <= 0.0):
        onset(S, I, r, depth, start, stretch, central)
    if unlikely(depth <= 0.0 and S[j + CONTACT.slowness] > 0.0):
        S[SYSTEM.event] = 1.0
        S[j + CONTACT.slowness] = 0.0
    slowness = S[j + CONTACT.slowness]
    S[j + CONTACT.penetration] = depth
    S[j + CONTACT.duration] += S[SYSTEM.step] if touching else 0.0
    # The law is evaluated in free flight, too, at zero: a branch would differ from lane to lane.
    elastic, damping = evaluate_law(S, I, r, depth if touching else 0.0, slowness, stretch, central)
    if I[r + CONTACT_INDEX.bearing_count] + I[r + CONTACT_INDEX.journal_count] != 0:
        # The force on the bodies is F grad(delta), and the rate that the law sees is grad(delta) v: each
        # brings a factor of the gradient's length, so that the damping coefficient has it twice.
        elastic *= stretch
        damping *= stretch * stretch
    S[j + CONTACT.elastic] = contact_with_jump(elastic, S, I, r, depth, stretch, central)
    S[j + CONTACT.damping_coefficient] = damping


def contact_with_jump(elastic, S, I, r, depth, stretch, central: Central):
    """Return the elastic force (N) of contact r unchanged.

    Derivatives that follow a small difference replace this function (compiler/trace/jumps.py): there the
    slope of the force gets :func:`~vfife.kernels.jumps.contact_jump` times the slope of the penetration.
    """
    return elastic


def put_last_forces(S, I, r, h):
    """Apply the last step's force of contact r if the contact shares a body with others and touches now;
    otherwise start from zero.

    :func:`solve_contacts` then corrects these forces one by one, a sweep of Gauss and Seidel. Starting from
    the last forces, one sweep suffices because the change in a step is small; starting from zero, the first
    of two joints on a body would not feel the second.
    """
    j, b, k = bodies(I, r)
    touching = S[j + CONTACT.penetration] > 0.0
    S[j + CONTACT.normal] = 0.0
    S[j + CONTACT.friction] = 0.0
    if I[r + CONTACT_INDEX.film] != 0:
        film_coefficients(S, I[r + CONTACT_INDEX.contact], j, b, k)
        if I[r + CONTACT_INDEX.shared] != 0:  # a film acts while the surfaces are apart, too
            S[j + CONTACT.normal] = S[j + CONTACT.normal_force]
            S[j + CONTACT.friction] = S[j + CONTACT.friction_force]
            apply_contact_force(S, j, b, k, S[j + CONTACT.normal], S[j + CONTACT.friction])
    elif I[r + CONTACT_INDEX.shared] != 0:
        S[j + CONTACT.normal] = S[j + CONTACT.normal_force] if touching else 0.0
        S[j + CONTACT.friction] = S[j + CONTACT.friction_force] if touching else 0.0
        apply_contact_force(S, j, b, k, S[j + CONTACT.normal], S[j + CONTACT.friction])


def mobilities(S, I, r):
    """Return the inverse masses (1/kg) of contact r along n and along t, and their coupling: of its two
    bodies alone or, where ideal joints hold them, together with all that is pinned to them.
    """
    j, b, k = bodies(I, r)
    jn = S[j + CONTACT.jn]
    jt = S[j + CONTACT.jt]
    bn = S[j + CONTACT.bn]
    bt = S[j + CONTACT.bt]
    if I[r + CONTACT_INDEX.constrained] != 0:
        normal = Row(S[j + CONTACT.nx], S[j + CONTACT.ny], bn, jn)
        tangent = Row(-S[j + CONTACT.ny], S[j + CONTACT.nx], bt, jt)
        gn, gt, gm = joint_compliance(S, I, b, k, normal, tangent)
    else:
        inverse_mass = S[k + PARTICLE.inverse_mass] + S[b + PARTICLE.inverse_mass]
        ik = S[k + PARTICLE.inverse_inertia]
        ib = S[b + PARTICLE.inverse_inertia]
        gn = inverse_mass + jn * jn * ik + bn * bn * ib
        gt = inverse_mass + jt * jt * ik + bt * bt * ib
        gm = jn * jt * ik + bn * bt * ib
    return gn, gt, gm


def half_step_velocity(S, i, central: Central):
    """Return the velocity (m/s, m/s, rad/s) at t_(n+1/2) of a particle under the forces so far: what
    :func:`~vfife.kernels.step.kick` will store. A driven particle turns as prescribed.
    """
    _, decay, gain, _ = central
    im = S[i + PARTICLE.inverse_mass]
    ii = S[i + PARTICLE.inverse_inertia]
    w = (
        decay * S[i + PARTICLE.w] + gain * (ii * S[i + PARTICLE.mz])
        if ii > 0.0
        else S[i + PARTICLE.w] + 0.5 * S[SYSTEM.step] * S[i + PARTICLE.aw]
    )
    return (
        decay * S[i + PARTICLE.u] + gain * (im * S[i + PARTICLE.fx]),
        decay * S[i + PARTICLE.v] + gain * (im * S[i + PARTICLE.fy]),
        w,
    )


def half_step_slip(S, j, b, k, central: Central):
    """Return the sliding velocity (m/s) of joint j at t_(n+1/2) under the forces so far."""
    bu, bv, bw = half_step_velocity(S, b, central)
    ku, kv, kw = half_step_velocity(S, k, central)
    return (
        S[j + CONTACT.nx] * (kv - bv)
        - S[j + CONTACT.ny] * (ku - bu)
        + S[j + CONTACT.jt] * kw
        - S[j + CONTACT.bt] * bw
    )


def solve_contacts(S, I, span, central: Central):
    """Solve normal and friction force of every clearance joint at t_n in closed form, one joint after the
    other.

    ``span`` (s) is the time over which the powers of this step are integrated: the step, or half of it at
    the start.
    """
    h = central.p * central.h
    if I[HEADER.simultaneous] != 0:
        solve_simultaneous(S, I, h)
    for r in range(I[HEADER.contact], I[HEADER.contact_end], CONTACT_INDEX.SIZE):
        solve_contact(S, I, r, h, span, central)


def solve_contact(S, I, r, h, span, central: Central):
    """Solve the normal force of contact r, then its friction force, and apply the changes of both.

    The normal force follows from the penetration rate under all forces so far. Its change also moves the
    surfaces along t, by the coupling gm. Friction then follows from the sliding velocity that there would be
    without friction. Friction does not act back on the normal force within the step: its effect on the rate,
    through the arms, is that of the last step. Solving both together would be exact, but needs the
    derivative of the friction law by the normal force, which laws do not provide.

    Most friction laws are solved for the velocity at t_n. A set-valued law sticks only if the half-step
    velocity becomes zero: making the velocity at t_n zero would reverse the half-step velocity in each step,
    and the body would tremble. ``implicit_half_step`` marks such a joint.
    """
    j, b, k = bodies(I, r)
    gn, gt, gm = mobilities(S, I, r)
    gt_half_step = central.gain * gt
    gm_half_step = central.gain * gm
    gn = h * gn
    gt = h * gt
    gm = h * gm
    # 1. The normal force. The rate contains this contact's own starting force, which is taken out (+ gn F).
    rate = approach_rate(S, j, b, k)
    slip = sliding_rate(S, j, b, k)
    push = S[j + CONTACT.elastic]
    resisting = S[j + CONTACT.damping_coefficient]
    if I[r + CONTACT_INDEX.film] != 0:
        push, resisting = eliminate_film(S, j, slip - gt * S[j + CONTACT.friction], gt)
    if I[r + CONTACT_INDEX.simultaneous] != 0:
        normal = S[j + CONTACT.normal]
    else:
        normal, rate = normal_force(push, resisting, rate + gn * S[j + CONTACT.normal], gn)
    change = normal - S[j + CONTACT.normal]
    # 2. Friction, from the slip under the new normal force and without the friction applied so far.
    loose = slip - gm * change - gt * S[j + CONTACT.friction]
    dry = normal
    across = 0.0
    if I[r + CONTACT_INDEX.film] != 0:
        # The film's force along t is no friction. Only the elastic part of F_N presses solid surfaces.
        across = film_force(S, j, rate, loose, gt)
        loose += gt * across
        dry = S[j + CONTACT.elastic] if S[j + CONTACT.elastic] < normal else normal
    free = loose
    mobility = gt
    if I[r + CONTACT_INDEX.implicit_half_step] != 0:
        free = (
            half_step_slip(S, j, b, k, central)
            - gm_half_step * change
            - gt_half_step * (S[j + CONTACT.friction] - across)
        )
        mobility = gt_half_step
    friction = friction_law(
        I[r + CONTACT_INDEX.friction],
        dry,
        free,
        mobility,
        S[SYSTEM.step],
        S,
        j + CONTACT.friction_slots,
        j + CONTACT.memory,
    )
    if I[r + CONTACT_INDEX.kinked] != 0:
        change_regime(S, I, r, free, free + mobility * friction, normal)
    # 3. Apply the changes, and account for what is dissipated at the slip that is left at t_n.
    slip = loose + gt * friction
    tangential = friction + across
    apply_force_change(S, I, r, h, change, tangential - S[j + CONTACT.friction])
    S[j + CONTACT.normal_force] = normal
    S[j + CONTACT.friction_force] = tangential
    account(S, j, span, (normal - S[j + CONTACT.elastic]) * rate - across * slip, -friction * slip)
    if I[r + CONTACT_INDEX.wear] != 0:
        rub(S, I[r + CONTACT_INDEX.wear], j, span, slip)


def apply_force_change(S, I, r, h, normal, tangential):
    """Apply changes of the normal and tangential force (N) of contact r to its bodies, and to the velocities
    of those that other joints feel within the step.
    """
    j, b, k = bodies(I, r)
    apply_contact_force(S, j, b, k, normal, tangential)
    if I[r + CONTACT_INDEX.constrained] != 0:
        apply_response(S, I, h, normal, tangential)
    elif I[r + CONTACT_INDEX.shared] != 0:
        update_velocities(S, j, b, k, h, normal, tangential)


def account(S, j, span, damping_power, friction_power):
    """Store the powers (W) of damping and friction of joint j, add them times ``span`` (s) to their works,
    and update its extremes.
    """
    normal = S[j + CONTACT.normal_force]
    tangential = S[j + CONTACT.friction_force]
    S[j + CONTACT.damping_power] = damping_power
    S[j + CONTACT.friction_power] = friction_power
    S[j + CONTACT.damping_work] += span * damping_power
    S[j + CONTACT.friction_work] += span * friction_power
    largest = j + CONTACT.force_squared_max
    S[largest] = larger(S[largest], normal * normal + tangential * tangential)
    S[j + CONTACT.penetration_max] = larger(S[j + CONTACT.penetration_max], S[j + CONTACT.penetration])


def guide_forces(S, I):
    """Update the largest force of each block in a guide with clearance: the sum of its corners' forces
    -F_N n + F_T t, whose maximum does not follow from the maxima of the corners.
    """
    for r in range(I[HEADER.guide], I[HEADER.guide_end], GUIDE_INDEX.SIZE):
        fx = 0.0
        fy = 0.0
        for j in range(I[r + GUIDE_INDEX.corners], I[r + GUIDE_INDEX.corners_end], CONTACT.SIZE):
            nx = S[j + CONTACT.nx]
            ny = S[j + CONTACT.ny]
            fx -= S[j + CONTACT.normal_force] * nx + S[j + CONTACT.friction_force] * ny
            fy += S[j + CONTACT.friction_force] * nx - S[j + CONTACT.normal_force] * ny
        largest = I[r + GUIDE_INDEX.row] + GUIDE.force_squared_max
        S[largest] = larger(S[largest], fx * fx + fy * fy)


def change_regime(S, I, r, free, sliding, normal):
    """Report an event if the friction law has entered another smooth part of its curve since the last step.

    ``free`` and ``sliding`` (m/s) are the sliding velocities without and with friction. A set-valued law
    sticks at zero up to rounding: less than STICKS times the free velocity counts as sticking.
    """
    j = I[r + CONTACT_INDEX.row]
    if I[r + CONTACT_INDEX.implicit_half_step] != 0:
        sliding = sliding if abs(sliding) > STICKS * abs(free) else 0.0
    regime = friction_regime(I[r + CONTACT_INDEX.friction], sliding, S, j + CONTACT.friction_slots)
    if unlikely(normal > 0.0 and regime != S[j + CONTACT.regime]):
        S[SYSTEM.event] = 1.0
        S[j + CONTACT.regime] = regime
