"""Contacts at a step: where journal and bearing stand, whether a contact begins, and the force that answers
(paper Eq. 18-33).

A journal meets the bearing around it, a round beside it, a straight line (the wall of a guide, met by the
corners of a block), or the wall of a slot along a path, the one on its side.

Damping and friction are stiff: both act on the velocity at t_n, which a central difference does not know yet,
so each joint solves for its force in closed form. Joints that share a body are visited in turn, from the last
step's forces.

Names: S is the state and I the topology (:mod:`~vfife.kernels.arrays`); r is a contact's record in I; of rows
in S, j is that of the joint, b and k those of the particles of its bearing and its journal, i that of any
particle. n points from bearing to journal, t is n turned anticlockwise: (nx, ny) and (-ny, nx). jn, jt and
bn, bt are the levers (m) of forces along n and t about journal and bearing. A force F_N, F_T acts as -F_N n +
F_T t on the journal. gn, gt, gm: velocity along n per F_N, along t per F_T, and along t per F_N, first as
inverse masses (1/kg), then times h (m/s/N).

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
    sliding_rate,
    solve_simultaneous,
    update_velocities,
)
from .film import eliminate_film, film_coefficients, film_force
from .geometry import arm, eccentricity, in_slot, normal_force, onset_speed, unlikely
from .tabled import tabled_law, turned_slowness
from .topology import LINE, ROUND, SLOT
from .wear import profile_geometry, rub

STICKS = 1e-9  # share of a free velocity that a set-valued law leaves to rounding

# Written by the compiler (compiler/trace/source.py) for the laws of a mechanism.
WRITTEN: Any = None
contact_law = friction_law = friction_regime = WRITTEN


def predict_velocities(S, I, central: Central):
    """Velocities at t_n of the particles in clearance joints under the forces so far."""
    for q in range(I[HEADER.jointed], I[HEADER.jointed_end]):
        i = I[q]
        im = central.h * S[i + PARTICLE.inverse_mass]
        S[i + PARTICLE.vu] = central.p * (S[i + PARTICLE.u] + im * S[i + PARTICLE.fx])
        S[i + PARTICLE.vv] = central.p * (S[i + PARTICLE.v] + im * S[i + PARTICLE.fy])
        S[i + PARTICLE.vw] = central.p * (
            S[i + PARTICLE.w] + (central.h * S[i + PARTICLE.inverse_inertia]) * S[i + PARTICLE.mz]
        )


def expected_velocity(S, i, central: Central):
    """Velocity at t_n of a particle under the last step's acceleration."""
    h, _, _, p = central
    turning = S[i + PARTICLE.inverse_inertia] > 0.0
    w = p * (S[i + PARTICLE.w] + h * S[i + PARTICLE.aw]) if turning else S[i + PARTICLE.w]
    return (
        p * (S[i + PARTICLE.u] + h * S[i + PARTICLE.ax]),
        p * (S[i + PARTICLE.v] + h * S[i + PARTICLE.ay]),
        w,
    )


def expected_rate(S, j, b, k, central: Central):
    """Rate of the penetration (m/s) at t_n under the last step's accelerations."""
    bu, bv, bw = expected_velocity(S, b, central)
    ku, kv, kw = expected_velocity(S, k, central)
    return (
        S[j + CONTACT.nx] * (ku - bu)
        + S[j + CONTACT.ny] * (kv - bv)
        + S[j + CONTACT.jn] * kw
        - S[j + CONTACT.bn] * bw
    )


def onset(S, I, r, depth, start, stretch, central: Central):
    """A contact begins: locate its speed inside the step, which is held until the surfaces part, and count
    it.

    ``depth`` is the penetration (m) now; CONTACT.penetration is still that of the step before, and
    :func:`~vfife.kernels.geometry.onset_speed` takes zero as what lies between them.
    """
    j = I[r + CONTACT_INDEX.row]
    dt = S[SYSTEM.step]
    rate = stretch * expected_rate(S, j, I[r + CONTACT_INDEX.bearing], I[r + CONTACT_INDEX.journal], central)
    located = rate if start else onset_speed(depth, S[j + CONTACT.penetration], rate, dt)
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
    """Elastic force (N) and damping coefficient (N s/m) of a contact, by its law's function or its table."""
    j = I[r + CONTACT_INDEX.row]
    if I[r + CONTACT_INDEX.knots] != 0:
        rate = stretch * expected_rate(
            S, j, I[r + CONTACT_INDEX.bearing], I[r + CONTACT_INDEX.journal], central
        )
        turned = turned_slowness(slowness, S[j + CONTACT.slots], rate)
        elastic, damping = tabled_law(S, I[r + CONTACT_INDEX.knot], I[r + CONTACT_INDEX.knots], depth, turned)
    else:
        elastic, damping = contact_law(I[r + CONTACT_INDEX.contact], depth, slowness, S, j + CONTACT.slots)
    return elastic, damping


def measure_gap(S, I, r, ex, ey):
    """Signed penetration (m) and normal of contact r, the journal's centre being (ex, ey) from the bearing's
    pin, and by how much the levers of the normal and of the friction force on the bearing differ from those
    of a journal in a round one (m).
    """
    j = I[r + CONTACT_INDEX.row]
    b = I[r + CONTACT_INDEX.bearing]
    kind = I[r + CONTACT_INDEX.kind]
    along = 0.0
    beyond = 0.0
    if kind == LINE:
        nx, ny = arm(S[b + PARTICLE.c], S[b + PARTICLE.s], S[j + CONTACT.line_x], S[j + CONTACT.line_y])
        depth = (nx * ex + ny * ey) - S[j + CONTACT.size]
        along = nx * ey - ny * ex
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
        along = nx * ey - ny * ex
        beyond = (nx * ex + ny * ey) - away
    else:
        depth, nx, ny = eccentricity(ex, ey, S[j + CONTACT.size])
        if kind == ROUND:
            # Two rounds touch when their centres come near, a journal touches its bearing when they part:
            # depth and normal change their signs.
            depth = -depth
            nx = -nx
            ny = -ny
    return depth, nx, ny, along, beyond


def contact_geometry(S, I, start, central: Central):
    """Geometry, onset and law of every clearance joint; put the last step's forces of joints that share a
    body in place.
    """
    for r in range(I[HEADER.contact], I[HEADER.contact_end], CONTACT_INDEX.SIZE):
        depth, stretch = locate_contact(S, I, r)
        detect_contact(S, I, r, depth, start, stretch, central)
        put_last_forces(S, I, r, central.h)


def locate_contact(S, I, r):
    """Store normal and levers of contact r; return its penetration (m) and by how much a worn surface
    stretches that (1 where none is worn).
    """
    j, b, k = bodies(I, r)
    bx, by = arm(S[b + PARTICLE.c], S[b + PARTICLE.s], S[j + CONTACT.bearing_x], S[j + CONTACT.bearing_y])
    kx, ky = arm(S[k + PARTICLE.c], S[k + PARTICLE.s], S[j + CONTACT.journal_x], S[j + CONTACT.journal_y])
    ex = (S[k + PARTICLE.x] + kx) - (S[b + PARTICLE.x] + bx)
    ey = (S[k + PARTICLE.y] + ky) - (S[b + PARTICLE.y] + by)
    depth, nx, ny, along, beyond = measure_gap(S, I, r, ex, ey)
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
        depth, nx, ny, along, turns, stretch = profile_geometry(S, I, r, depth, nx, ny)
        journal_wear = S[w + WEAR.journal] if I[r + CONTACT_INDEX.journal_count] != 0 else 0.0
        beyond = (nx * ex + ny * ey) - (depth + S[j + CONTACT.size]) - journal_wear
    # Friction acts at the surface, a radius from the pin's centre, which the penetration shifts by a share
    # (arm_overlap) of itself.
    overlap = S[j + CONTACT.arm_overlap] * depth
    S[j + CONTACT.nx] = nx
    S[j + CONTACT.ny] = ny
    S[j + CONTACT.jn] = kx * ny - ky * nx + turns
    S[j + CONTACT.bn] = bx * ny - by * nx - along
    S[j + CONTACT.jt] = kx * nx + ky * ny + (S[j + CONTACT.arm_journal] - overlap) - journal_wear
    S[j + CONTACT.bt] = bx * nx + by * ny + (S[j + CONTACT.arm_bearing] + overlap) + beyond
    return depth, stretch


def detect_contact(S, I, r, depth, start, stretch, central: Central):
    """Begin or end a contact by its penetration (m), and evaluate its law.

    A contact begins where the penetration is above zero and ends where it is not. Afterwards two rows tell:
    CONTACT.slowness is above zero in contact and zero otherwise, and CONTACT.penetration is above zero in
    contact alone. Others read the penetration for it (``put_last_forces``,
    ``contact_forces.solve_simultaneous``, statics, measures): another limit than zero is a change there, too.
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
    elastic, damping = evaluate_law(S, I, r, depth if touching else 0.0, slowness, stretch, central)
    if I[r + CONTACT_INDEX.bearing_count] + I[r + CONTACT_INDEX.journal_count] != 0:
        elastic *= stretch
        damping *= stretch * stretch
    S[j + CONTACT.elastic] = elastic
    S[j + CONTACT.damping_coefficient] = damping


def put_last_forces(S, I, r, h):
    """Put the last step's force of contact r in place where it shares a body with others and touches now,
    else none.

    Joints that share a body start from these forces, which solve_contacts then corrects one by one (Gauss and
    Seidel). A force that holds already costs nothing; solved from zero each time, the first of two joints
    would not feel the second.
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
    """Inverse masses (1/kg) of contact r along n and t and their coupling, of its two bodies alone or with
    what is pinned to them.
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
        both = S[k + PARTICLE.inverse_mass] + S[b + PARTICLE.inverse_mass]
        ik = S[k + PARTICLE.inverse_inertia]
        ib = S[b + PARTICLE.inverse_inertia]
        gn = both + jn * jn * ik + bn * bn * ib
        gt = both + jt * jt * ik + bt * bt * ib
        gm = jn * jt * ik + bn * bt * ib
    return gn, gt, gm


def half_step_velocity(S, i, central: Central):
    """Velocity at t_(n+1/2) of a particle under the forces so far, as ``kick`` will make it; a driven one
    turns as prescribed.
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
    """Sliding velocity (m/s) of joint j at t_(n+1/2) under the forces so far."""
    bu, bv, bw = half_step_velocity(S, b, central)
    ku, kv, kw = half_step_velocity(S, k, central)
    return (
        S[j + CONTACT.nx] * (kv - bv)
        - S[j + CONTACT.ny] * (ku - bu)
        + S[j + CONTACT.jt] * kw
        - S[j + CONTACT.bt] * bw
    )


def solve_contacts(S, I, span, central: Central):
    """Solve normal and friction force of every clearance joint at t_n in closed form, in turn where joints
    share a body.

    ``span`` (s) is the time over which the powers of this step count.
    """
    h = central.p * central.h
    if I[HEADER.simultaneous] != 0:
        solve_simultaneous(S, I, h)
    for r in range(I[HEADER.contact], I[HEADER.contact_end], CONTACT_INDEX.SIZE):
        solve_contact(S, I, r, h, span, central)


def solve_contact(S, I, r, h, span, central: Central):
    """Solve the normal force of contact r from the rate under all forces so far, then friction from the slip
    that the normal force leaves.

    The change of the normal force moves the surfaces along t as well, by the coupling gm; friction is solved
    from the sliding velocity that would be there without friction. Friction does not feed back on the normal
    force within the step: its push on the rate, through the arms, is that of the step before. One equation
    for both would be exact, and would need a law's slope by the normal force. The changes of both are applied
    to bodies and velocities, so that the next joint sees them.

    Most friction laws are solved with the velocity at t_n. A set-valued one must make the half-step velocity
    zero to stick: at t_n it would only turn that round, and the body would tremble. ``implicit_half_step``
    marks such a joint.
    """
    j, b, k = bodies(I, r)
    gn, gt, gm = mobilities(S, I, r)
    gt_half_step = central.gain * gt
    gm_half_step = central.gain * gm
    gn = h * gn
    gt = h * gt
    gm = h * gm
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
    # What slip the new normal force leaves, without the friction to start from.
    loose = slip - gm * change - gt * S[j + CONTACT.friction]
    dry = normal
    across = 0.0
    if I[r + CONTACT_INDEX.film] != 0:
        # The film's share of the force along t is no friction; the friction law has the elastic part of the
        # normal force alone.
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
    """Store the powers (W) of damping and friction, add their works, and update the extremes of a contact."""
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
    """Update the extremes of blocks in guides with play: the corners' forces -F_N n + F_T t together, which
    no corner alone has.
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
    """Report an event where friction passes a kink of its curve between the free sliding velocity and the one
    that is left (m/s).

    A set-valued law sticks at exactly zero, of which rounding leaves a share STICKS of the free velocity:
    that is no sliding.
    """
    j = I[r + CONTACT_INDEX.row]
    if I[r + CONTACT_INDEX.implicit_half_step] != 0:
        sliding = sliding if abs(sliding) > STICKS * abs(free) else 0.0
    regime = friction_regime(I[r + CONTACT_INDEX.friction], sliding, S, j + CONTACT.friction_slots)
    if unlikely(normal > 0.0 and regime != S[j + CONTACT.regime]):
        S[SYSTEM.event] = 1.0
        S[j + CONTACT.regime] = regime
