"""Reactions of ideal joints at t_n that keep the joints closed at t_(n+1).

**What is solved.** The joints are closed in terms of the displacements of a step, not of the positions at its
end. Displacements (u dt and the turns of arms) are small, and so is their rounding: eps v dt instead of
eps x. Closing positions would turn that rounding into a noise of eps x/dt^2 in the accelerations, which
hides the reactions of a short step. Of the distance that is open at t_n, a step closes the share ``GAIN``
only, so that its rounding is multiplied by that share, too (:func:`residual`).

**Why one correction is not always enough.** The first correction uses the directions of t_n, but its forces
close constraints that have turned by t_(n+1). The error is proportional to the angle of a step; on a body
with radius of gyration k on an arm r it is multiplied by (r/k)^2, and it grows, because the next step has to
make up for it. The turn of the rows is known after the first correction, and with it the error. Coarse steps
correct once or twice more with the same factors. If the error is still not negligible (a fast light body on a
long arm, a link that swings through in a few steps), Newton's method follows with the turned rows. If that
does not close the joints either, the step is taken again in parts.

**Order of a step**, in :func:`hold` and :func:`close`:

1. directions, levers and factors of t_n;
2. reactions extrapolated from the last two steps (:func:`warm_start`);
3. corrections. Each moves the bodies to t_(n+1) under the forces so far (:func:`predict`), measures how far
   that opens the joints (:func:`residual`), solves for the reactions that close them, and adds these to the
   forces (:func:`correct`).

**Three kinds of steps**, fine, coarse and coarsest, follow from ``Topology.coarse`` (``tables.py``).
``HEADER.coarse`` is a flag: steps are coarse or coarsest. ``HEADER.corrections`` is the number of corrections
with the factors of t_n. ``HEADER.newton`` is a flag: steps are coarsest, and the turned rows are always used.

Names as in :mod:`~vfife.kernels.constraint`; ``decay`` and ``gain`` are those of :class:`Central`, not GAIN.
"""

from typing import NamedTuple

from .arrays import (
    CONSTRAINT,
    CONSTRAINT_INDEX,
    DRIVEN,
    DRIVEN_INDEX,
    FUNCTION,
    HEADER,
    JOINT,
    JOINT_INDEX,
    PARTICLE,
    SYSTEM,
)
from .central_difference import Central
from .constraint import (
    apply_reaction,
    bodies,
    clear,
    guide_of,
    guide_row,
    lever,
    levers,
    relative_turn,
    set_row,
)
from .elementary import sincos, turned
from .factors import (
    FLOOR,
    REDUNDANT,
    equations,
    factor,
    factor_turned,
    fill,
    fill_turned,
    idle_reactions,
    solve,
    solve_turned,
)
from .frame import chord
from .geometry import arm, unlikely
from .topology import ALONG_LINE, FREE, GEARED, ON_PATH, PINNED, SPACED, UNPLACED

# Share of the distance that is open at t_n that a step closes, called feedback below. Coarse steps close all
# of it, because rounding over dt^2 is small there.
GAIN = 0.0625
# Distances that a step may leave open without Newton's method, as shares of the mechanism's size
# (SYSTEM.size, the longest arm of an ideal joint): in fine steps; in coarse steps, where errors do not
# accumulate, because each step closes all that is open; and with contacts, whose impacts change the reactions
# from step to step and whose penetrations are much larger.
LEFT = 5e-11
LEFT_COARSE = 5e-10
LEFT_BY_CONTACTS = 1e-8
# Offset in a constraint's record from its direction and levers to their change in a step.
TURN = CONSTRAINT.turn_x - CONSTRAINT.nx
# Distance, as a share of the size, up to which one more correction of Newton's method is trusted: its error
# is of the order of the square. A coarse step with more than that is an event.
TRUSTED_DISTANCE = 1e-6


class Pins(NamedTuple):
    """The two pins of a joint in space (m): the journal's pin seen from the bearing's (ex, ey) and its
    displacement in a step (dx, dy); the journal's arm (kx, ky) and its change in a step (dkx, dky).
    """

    ex: float
    ey: float
    dx: float
    dy: float
    kx: float
    ky: float
    dkx: float
    dky: float


def turn_driven(S, I, dt):
    """Store the prescribed turns of the driven bodies from t_n to t_(n+1) (rad)."""
    for r in range(I[HEADER.driven], I[HEADER.driven_end], DRIVEN_INDEX.SIZE):
        i = I[r + DRIVEN_INDEX.body]
        f = I[r + DRIVEN_INDEX.function]
        angle = (
            S[I[r + DRIVEN_INDEX.row] + DRIVEN.speed] * dt
            if f == 0
            else S[f + FUNCTION.next] - S[f + FUNCTION.value]
        )
        S[i + PARTICLE.step_x] = 0.0
        S[i + PARTICLE.step_y] = 0.0
        S[i + PARTICLE.step_turn] = angle
        S[i + PARTICLE.step_sine], S[i + PARTICLE.step_versine] = turned(angle)


def begin(S, I):
    """Use the reactions of the start for the step before it, which does not exist, so that the first
    extrapolation is constant.
    """
    for r in range(I[HEADER.constraint], I[HEADER.constraint_end], CONSTRAINT_INDEX.SIZE):
        q = I[r + CONSTRAINT_INDEX.row]
        S[q + CONSTRAINT.before] = S[q + CONSTRAINT.force]


def warm_start(S, I):
    """Apply reactions extrapolated linearly through the last two steps: with them the first correction closes
    the joints to third order in the step.

    Starting from zero, or from the last step's reactions, would need one or two corrections more for the
    same.
    """
    for r in range(I[HEADER.joint], I[HEADER.joint_end], JOINT_INDEX.SIZE):
        for m in range(I[r + JOINT_INDEX.rows]):
            q = I[r + JOINT_INDEX.first] + m * CONSTRAINT.SIZE
            last = S[q + CONSTRAINT.force]
            guess = last + (last - S[q + CONSTRAINT.before])
            S[q + CONSTRAINT.before] = last
            S[q + CONSTRAINT.force] = guess
            apply_reaction(S, I, r, q, PARTICLE.fx, guess)


def minimum_norm(S, I):
    """Subtract the part of redundant reactions that moves no body. What remains has least norm and does not
    drift from step to step.
    """
    idle_reactions(S, I, I[HEADER.y])
    for r in range(I[HEADER.joint], I[HEADER.joint_end], JOINT_INDEX.SIZE):
        for m in range(I[r + JOINT_INDEX.rows]):
            q = I[r + JOINT_INDEX.first] + m * CONSTRAINT.SIZE
            idle = S[I[r + JOINT_INDEX.y] + m]
            S[q + CONSTRAINT.force] -= idle
            apply_reaction(S, I, r, q, PARTICLE.fx, -idle)


def predict(S, I, dt, decay, gain):
    """Store displacements and turns (m, rad) from t_n to t_(n+1) of the pinned bodies under the forces so
    far.
    """
    for q in range(I[HEADER.pinned], I[HEADER.pinned_end]):
        i = I[q]
        im = dt * (gain * S[i + PARTICLE.inverse_mass])
        ii = dt * (gain * S[i + PARTICLE.inverse_inertia])
        S[i + PARTICLE.step_x] = dt * decay * S[i + PARTICLE.u] + im * S[i + PARTICLE.fx]
        S[i + PARTICLE.step_y] = dt * decay * S[i + PARTICLE.v] + im * S[i + PARTICLE.fy]
        angle = dt * decay * S[i + PARTICLE.w] + ii * S[i + PARTICLE.mz]
        S[i + PARTICLE.step_turn] = angle
        S[i + PARTICLE.step_sine], S[i + PARTICLE.step_versine] = turned(angle)


def change(S, i, x, y):
    """Return the change (m) from t_n to t_(n+1) of a vector (x, y) that turns with body i, from sine and
    versine (1 - cosine) of the turn: a difference of cosines would lose the digits of a small angle.
    """
    s = S[i + PARTICLE.step_sine]
    v = S[i + PARTICLE.step_versine]
    return -(v * x + s * y), s * x - v * y


def residual(S, I):
    """Store in rows y the distance or angle (m, rad) that each constraint has to be closed by, and the change
    of each row's direction and levers in this step.

    The residual is what the step moves the two pins apart, plus the share ``feedback`` of what is open at t_n
    (Baumgarte's stabilisation, of positions only). Displacements are subtracted first and positions are
    multiplied by the small share, so that rounding of positions hardly enters. A path is the exception: its
    distance at t_(n+1) is the whole residual.
    """
    feedback = 1.0 if I[HEADER.coarse] != 0 else GAIN
    for r in range(I[HEADER.joint], I[HEADER.joint_end], JOINT_INDEX.SIZE):
        f = I[r + JOINT_INDEX.function]
        aim = S[I[r + JOINT_INDEX.row] + JOINT.offset]
        move = 0.0
        if f != 0:
            aim += S[f + FUNCTION.value]
            move = S[f + FUNCTION.next] - S[f + FUNCTION.value]
        if I[r + JOINT_INDEX.place] != UNPLACED:
            place_residual(S, I, r, feedback, aim, move)
        if I[r + JOINT_INDEX.turn] != FREE:
            turn_residual(S, I, r, feedback, aim, move)


def place_residual(S, I, r, feedback, aim, move):
    """Store the residual (m) of the place that joint r holds: two rows of a revolute, else one. ``aim`` (m)
    is the prescribed travel or length at t_n, ``move`` (m) its change in this step.
    """
    j, b, k = bodies(I, r)
    y = I[r + JOINT_INDEX.y]
    q = I[r + JOINT_INDEX.first]
    bx, by = arm(S[b + PARTICLE.c], S[b + PARTICLE.s], S[j + JOINT.bearing_x], S[j + JOINT.bearing_y])
    kx, ky = arm(S[k + PARTICLE.c], S[k + PARTICLE.s], S[j + JOINT.journal_x], S[j + JOINT.journal_y])
    ex = (S[k + PARTICLE.x] + kx) - (S[b + PARTICLE.x] + bx)
    ey = (S[k + PARTICLE.y] + ky) - (S[b + PARTICLE.y] + by)
    dbx, dby = change(S, b, bx, by)
    dkx, dky = change(S, k, kx, ky)
    dx = (S[k + PARTICLE.step_x] - S[b + PARTICLE.step_x]) + (dkx - dbx)
    dy = (S[k + PARTICLE.step_y] - S[b + PARTICLE.step_y]) + (dky - dby)
    if I[r + JOINT_INDEX.place] == PINNED:
        S[y] = dx + feedback * ex
        S[y + 1] = dy + feedback * ey
        set_row(S, q + TURN, 0.0, 0.0, -dby, -dky)
        set_row(S, q + CONSTRAINT.SIZE + TURN, 0.0, 0.0, dbx, dkx)
    else:
        guide_residual(S, I, r, feedback, aim, move, Pins(ex, ey, dx, dy, kx, ky, dkx, dky))


def turn_residual(S, I, r, feedback, aim, move):
    """Store the residual (rad) of the turn that joint r holds, in its last row, whose levers are constant.
    ``aim`` (rad) is the prescribed angle at t_n, ``move`` (rad) its change in this step.
    """
    j, b, k = bodies(I, r)
    c = I[r + JOINT_INDEX.carrier]
    last = I[r + JOINT_INDEX.rows] - 1
    ratio = S[j + JOINT.ratio] if I[r + JOINT_INDEX.turn] == GEARED else 1.0
    open_angle = (
        relative_turn(
            S[b + PARTICLE.theta], S[k + PARTICLE.theta], ratio, S[c + PARTICLE.theta] if c != 0 else 0.0
        )
        - aim
    )
    angle = relative_turn(
        S[b + PARTICLE.step_turn],
        S[k + PARTICLE.step_turn],
        ratio,
        S[c + PARTICLE.step_turn] if c != 0 else 0.0,
    )
    S[I[r + JOINT_INDEX.y] + last] = (angle - move) + feedback * open_angle
    set_row(S, I[r + JOINT_INDEX.first] + CONSTRAINT.SIZE * last + TURN, 0.0, 0.0, 0.0, 0.0)


def guide_residual(S, I, r, feedback, aim, move, pins: Pins):
    """Store the residual (m) of a guide, a path or a massless link. Its direction turns within the step:
    with the bearing's body, along the path, or with the link.
    """
    ex, ey, dx, dy, kx, ky, dkx, dky = pins
    b = I[r + JOINT_INDEX.bearing]
    k = I[r + JOINT_INDEX.journal]
    y = I[r + JOINT_INDEX.y]
    q = I[r + JOINT_INDEX.first]
    place = I[r + JOINT_INDEX.place]
    nx = S[q + CONSTRAINT.nx]
    ny = S[q + CONSTRAINT.ny]
    dnx, dny = change(S, b, nx, ny)
    if place == ON_PATH:
        # The distance from a path is measured at t_(n+1) itself: it has no increment without cancellation,
        # but neither is it large. What is open at t_n is in it, so nothing is fed back.
        dcx, dsx = change(S, b, S[b + PARTICLE.c], S[b + PARTICLE.s])
        measured, mx, my = guide_row(
            S, guide_of(S, I, r), S[b + PARTICLE.c] + dcx, S[b + PARTICLE.s] + dsx, ex + dx, ey + dy
        )
        dnx = mx - nx
        dny = my - ny
        S[y] = measured
    elif place == SPACED:
        # l_(n+1) - l_n = (l_(n+1)^2 - l_n^2)/(l_(n+1) + l_n), where the difference of squares follows from
        # the increments.
        length = ex * nx + ey * ny
        new_length, _, mx, my = chord(ex + dx, ey + dy)
        dnx = mx - nx
        dny = my - ny
        S[y] = (
            ((2.0 * ex + dx) * dx + (2.0 * ey + dy) * dy) / (new_length + length)
            - move
            + feedback * (length - aim)
        )
    else:
        # (e + d) . (n + dn) - e . n without a difference of large numbers.
        distance = ex * nx + ey * ny
        opens = (dx * (nx + dnx) + dy * (ny + dny)) + (ex * dnx + ey * dny)
        if place == ALONG_LINE:
            distance = distance - aim
            opens = opens - move
        S[y] = opens + feedback * distance
    # Change of the levers, for the turned rows: by the product rule, of the point where the force acts (the
    # journal's pin, seen from the bearing's particle and from the journal's) and of the direction.
    rx = (S[k + PARTICLE.x] + kx) - S[b + PARTICLE.x]
    ry = (S[k + PARTICLE.y] + ky) - S[b + PARTICLE.y]
    mx = (S[k + PARTICLE.step_x] - S[b + PARTICLE.step_x]) + dkx
    my = (S[k + PARTICLE.step_y] - S[b + PARTICLE.step_y]) + dky
    jb = lever(rx + mx, ry + my, dnx, dny) + lever(mx, my, nx, ny)
    jk = lever(kx + dkx, ky + dky, dnx, dny) + lever(dkx, dky, nx, ny)
    set_row(S, q + TURN, dnx, dny, jb, jk)


def linearisation_error(S, I, dt, gain):
    """Return the square (m^2) of the distance that the last correction leaves open, because rows turn until
    t_(n+1) and the forces along them do not: the change of each row times the displacements of that
    correction. No position is computed again.
    """
    total = 0.0
    for r in range(I[HEADER.joint], I[HEADER.joint_end], JOINT_INDEX.SIZE):
        if I[r + JOINT_INDEX.place] != UNPLACED:
            bx, by, bw = correction_displacement(S, I[r + JOINT_INDEX.bearing], dt, gain)
            kx, ky, kw = correction_displacement(S, I[r + JOINT_INDEX.journal], dt, gain)
            for m in range(2 if I[r + JOINT_INDEX.place] == PINNED else 1):
                q = I[r + JOINT_INDEX.first] + m * CONSTRAINT.SIZE
                straight = S[q + CONSTRAINT.turn_x] * (kx - bx) + S[q + CONSTRAINT.turn_y] * (ky - by)
                left = straight + (S[q + CONSTRAINT.turn_k] * kw - S[q + CONSTRAINT.turn_b] * bw)
                total += left * left
    return total


def correction_displacement(S, i, dt, gain):
    """Return the displacement (m, m, rad) of body i at t_(n+1) by the last correction."""
    im = dt * (gain * S[i + PARTICLE.inverse_mass])
    ii = dt * (gain * S[i + PARTICLE.inverse_inertia])
    return im * S[i + PARTICLE.change_x], im * S[i + PARTICLE.change_y], ii * S[i + PARTICLE.change_m]


def correct(S, I, dt, gain):
    """Add the corrections in rows y to the reactions and to the bodies' forces."""
    apply_corrections(S, I, dt, gain)
    # Displacements at t_(n+1) are dt gain times accelerations; y holds what has to be closed by forces.
    scale = -1.0 / (dt * gain)
    for r in range(I[HEADER.joint], I[HEADER.joint_end], JOINT_INDEX.SIZE):
        for m in range(I[r + JOINT_INDEX.rows]):
            S[I[r + JOINT_INDEX.first] + m * CONSTRAINT.SIZE + CONSTRAINT.force] += (
                scale * S[I[r + JOINT_INDEX.y] + m]
            )


def apply_corrections(S, I, dt, gain):
    """Add the corrections in rows y to the bodies' forces, and leave the sum of each body in
    PARTICLE.change_x, change_y and change_m.

    The sum of a body is formed first and added once, because linearisation_error needs it separately.
    """
    for r in range(I[HEADER.joint], I[HEADER.joint_end], JOINT_INDEX.SIZE):
        clear(S, I[r + JOINT_INDEX.bearing] + PARTICLE.change_x)
        clear(S, I[r + JOINT_INDEX.journal] + PARTICLE.change_x)
        if I[r + JOINT_INDEX.carrier] != 0:
            clear(S, I[r + JOINT_INDEX.carrier] + PARTICLE.change_x)
    scale = -1.0 / (dt * gain)
    for r in range(I[HEADER.joint], I[HEADER.joint_end], JOINT_INDEX.SIZE):
        for m in range(I[r + JOINT_INDEX.rows]):
            q = I[r + JOINT_INDEX.first] + m * CONSTRAINT.SIZE
            apply_reaction(S, I, r, q, PARTICLE.change_x, scale * S[I[r + JOINT_INDEX.y] + m])
    for q in range(I[HEADER.pinned], I[HEADER.pinned_end]):
        add_change(S, I[q])
    for r in range(I[HEADER.driven], I[HEADER.driven_end], DRIVEN_INDEX.SIZE):
        add_change(S, I[r + DRIVEN_INDEX.body])


def add_change(S, i):
    """Add the corrections of body i to its forces."""
    S[i + PARTICLE.fx] += S[i + PARTICLE.change_x]
    S[i + PARTICLE.fy] += S[i + PARTICLE.change_y]
    S[i + PARTICLE.mz] += S[i + PARTICLE.change_m]


def closure_error(S, I, dt, decay, gain):
    """Store the residual under the forces so far; return the sum of its squares (m^2 and rad^2)."""
    predict(S, I, dt, decay, gain)
    residual(S, I)
    total = 0.0
    for y in range(I[HEADER.y], I[HEADER.y] + I[HEADER.constraint_count]):
        total += S[y] * S[y]
    return total


def newton(S, I, dt, decay, gain):
    """Correct the reactions with the rows turned to t_(n+1); return :func:`closure_error` from before the
    correction.
    """
    total = closure_error(S, I, dt, decay, gain)
    fill_turned(S, I)
    factor_turned(S, I, S[SYSTEM.share] + (REDUNDANT if I[HEADER.redundant] != 0 else 0.0))
    solve_turned(S, I, I[HEADER.y])
    correct(S, I, dt, gain)
    return total


def simplified_newton(S, I, dt, decay, gain):
    """Correct once more with the turned rows and the factors of the last correction; return
    :func:`closure_error` from before this one.
    """
    total = closure_error(S, I, dt, decay, gain)
    solve_turned(S, I, I[HEADER.y])
    correct(S, I, dt, gain)
    return total


def close_by_newton(S, I, dt, decay, gain, limit):
    """Close the joints by two corrections of Newton's method where those so far do not suffice. In a
    coarse or coarsest step, report an event where the first leaves more than the square root of ``limit``
    (m^2) open.
    """
    # Two corrections, each with factors of its own. The second returns the error that the first has left; its
    # own is the square of that.
    newton(S, I, dt, decay, gain)
    left = newton(S, I, dt, decay, gain)
    if I[HEADER.coarse] != 0:
        S[SYSTEM.event] = 1.0 if left > limit else S[SYSTEM.event]


def close(S, I, central: Central):
    """Correct the reactions of all ideal joints so that they are closed at t_(n+1)."""
    # 1. Corrections with the factors of t_n, which are there already: one in fine steps, more in coarse ones.
    # 2. The error of these follows from the turn of the rows (linearisation_error), without computing
    #    positions again. Newton's method, with factors of its own, follows only where the error is not
    #    negligible: an unlikely branch, which the fast step leaves out.
    # 3. In the coarsest steps Newton's method is the rule; its second correction uses the factors of the
    #    first (simplified_newton).
    # All tests compare squares, in (m and rad)^2, because the step would wait for a square root.
    decay = central.decay
    gain = central.gain
    dt = S[SYSTEM.step]
    limit = TRUSTED_DISTANCE * S[SYSTEM.size] * (TRUSTED_DISTANCE * S[SYSTEM.size])
    for _ in range(I[HEADER.corrections]):
        predict(S, I, dt, decay, gain)
        residual(S, I)
        solve(S, I, I[HEADER.y])
        correct(S, I, dt, gain)
    if I[HEADER.newton] == 0:
        left = (
            LEFT_BY_CONTACTS
            if I[HEADER.contact_count] != 0
            else LEFT_COARSE
            if I[HEADER.coarse] != 0
            else LEFT
        )
        tolerance = left * S[SYSTEM.size]
        if unlikely(linearisation_error(S, I, dt, gain) > tolerance * tolerance):
            close_by_newton(S, I, dt, decay, gain, limit)
    else:
        newton(S, I, dt, decay, gain)
        if unlikely(simplified_newton(S, I, dt, decay, gain) > limit):
            close_by_newton(S, I, dt, decay, gain, limit)
    if I[HEADER.redundant] != 0:
        minimum_norm(S, I)


def close_velocities(S, I, dt):
    """Correct the half-step velocities so that the joints are closed after a step of another size ``dt`` (s);
    leave the reactions as they are.
    """
    # A change of the step size keeps positions, but shifts half-step velocities by an error of second order,
    # which opens the joints by one of third order. With all forces set to zero, the corrections are impulses
    # that close the joints. They are no reactions of the mechanism and are not recorded as such.
    for q in range(I[HEADER.trig], I[HEADER.trig_end]):
        i = I[q]
        S[i + PARTICLE.s], S[i + PARTICLE.c] = sincos(S[i + PARTICLE.theta])
    for q in range(I[HEADER.pinned], I[HEADER.pinned_end]):
        clear(S, I[q] + PARTICLE.fx)
    levers(S, I)
    turn_driven(S, I, dt)
    fill(S, I)
    factor(S, I, FLOOR if I[HEADER.redundant] != 0 else 0.0)
    for _ in range(I[HEADER.velocity_corrections]):
        predict(S, I, dt, 1.0, 1.0)
        residual(S, I)
        solve(S, I, I[HEADER.y])
        apply_corrections(S, I, dt, 1.0)
    for q in range(I[HEADER.pinned], I[HEADER.pinned_end]):
        i = I[q]
        S[i + PARTICLE.u] += S[i + PARTICLE.inverse_mass] * S[i + PARTICLE.fx]
        S[i + PARTICLE.v] += S[i + PARTICLE.inverse_mass] * S[i + PARTICLE.fy]
        S[i + PARTICLE.w] += S[i + PARTICLE.inverse_inertia] * S[i + PARTICLE.mz]


def hold(S, I, start, central: Central):
    """Solve for the reactions of all ideal joints at t_n under the other forces."""
    dt = S[SYSTEM.step]
    levers(S, I)
    turn_driven(S, I, dt)
    equations(S, I, dt, start)
    warm_start(S, I)
    close(S, I, central)
    if unlikely(start):
        # Before the start there are no reactions to extrapolate: three corrections of Newton's method find
        # them from any guess.
        newton(S, I, dt, central.decay, central.gain)
        newton(S, I, dt, central.decay, central.gain)
        newton(S, I, dt, central.decay, central.gain)
