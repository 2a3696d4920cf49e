"""Reactions of ideal joints at t_n: those that keep the joints closed until t_(n+1).

What is solved are the increments of a step, not the positions at its end: u dt and the turns of arms are
small, and so is their rounding, eps v dt instead of eps x. Closing positions makes of that a noise of eps
x/dt^2 in the accelerations, which drowns the reactions of a short step. What is open at t_n is fed back by a
``GAIN``, a sixteenth a step, in which rounding is lost.

The first correction uses the directions of t_n. But forces in these directions close constraints that have
turned by t_(n+1): per unit of the angle of a step an error stays, which on a body of radius of gyration k on
an arm r counts (r/k)^2 times, and which the next step has to make up for: it grows. How the rows turn is
known after the first correction, and with it what is left. A run in coarse steps corrects once or twice more
with the same factors; where what is left is still not next to nothing (a fast light body on a long arm, a
link that swings through in a few steps) Newton's method follows with the turned rows, and where that does not
close either, the step is taken again in parts.
"""

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
from .constraint import gear_reaction, lever, levers, placed, pull, relative_turn
from .elementary import sincos, turned
from .factors import FLOOR, REDUNDANT, equations, factor, fill, fill_turned, halves, idle, solve, solve_turned
from .frame import chord
from .geometry import arm, seldom
from .topology import ALONG, APART, FREE, GEARED, NOWHERE, ON_PATH, PINNED

# of what is open at t_n, of which all is closed in coarse steps, where rounding over dt^2 is small
GAIN = 0.0625
LEFT = 5e-11  # sizes of a mechanism that the corrections along the rows of t_n may leave open in a step
LEFT_COARSE = 5e-10  # the same in coarse steps, in which it does not add up
# the same where impacts change the reactions from step to step: next to nothing beside a penetration
LEFT_BY_CONTACTS = 1e-8
# sizes that a third step of Newton's method may have to close; what it leaves is of the order of the square
MUCH = 1e-6


def ahead(S, I, dt):
    """Turns of the driven bodies from t_n to t_(n+1)."""
    for m in range(I[HEADER.driven_count]):
        r = I[HEADER.driven] + DRIVEN_INDEX.SIZE * m
        k = I[r + DRIVEN_INDEX.row]
        i = I[r + DRIVEN_INDEX.body]
        f = I[r + DRIVEN_INDEX.function]
        angle = S[k + DRIVEN.speed] * dt if f == 0 else S[f + FUNCTION.next] - S[f + FUNCTION.value]
        S[i + PARTICLE.step_x] = 0.0
        S[i + PARTICLE.step_y] = 0.0
        S[i + PARTICLE.step_turn] = angle
        S[i + PARTICLE.step_sine], S[i + PARTICLE.step_versine] = turned(angle)


def extrapolate(S, q):
    """Reaction that goes on as it did: with it the first correction closes the joints to third order in the
    step.
    """
    # Linear extrapolation through the last two steps. The force is set to zero because apply_reaction adds to
    # it.
    force = S[q + CONSTRAINT.force]
    before = S[q + CONSTRAINT.before]
    S[q + CONSTRAINT.before] = force
    S[q + CONSTRAINT.force] = 0.0
    return force + (force - before)


def begin(S, I):
    """The reactions of the start go on as they are."""
    for m in range(I[HEADER.constraint_count]):
        q = I[I[HEADER.constraint] + CONSTRAINT_INDEX.SIZE * m + CONSTRAINT_INDEX.row]
        S[q + CONSTRAINT.before] = S[q + CONSTRAINT.force]


def apply_reaction(S, I, r, q, force):
    """Adds a reaction along constraint q of joint r to the forces on its bodies."""
    pull(S, q, I[r + JOINT_INDEX.bearing], I[r + JOINT_INDEX.journal], force)
    if I[r + JOINT_INDEX.carrier] != 0:
        gear_reaction(S, q, I[r + JOINT_INDEX.carrier], force)


def warm_start(S, I):
    """Reactions to start from."""
    for m in range(I[HEADER.joint_count]):
        r = I[HEADER.joint] + JOINT_INDEX.SIZE * m
        for c in range(I[r + JOINT_INDEX.rows]):
            q = I[r + JOINT_INDEX.first] + c * CONSTRAINT.SIZE
            apply_reaction(S, I, r, q, extrapolate(S, q))


def minimum_norm(S, I):
    """Takes off what moves nothing."""
    idle(S, I, I[HEADER.y])
    for m in range(I[HEADER.joint_count]):
        r = I[HEADER.joint] + JOINT_INDEX.SIZE * m
        for c in range(I[r + JOINT_INDEX.rows]):
            q = I[r + JOINT_INDEX.first] + c * CONSTRAINT.SIZE
            apply_reaction(S, I, r, q, -S[I[r + JOINT_INDEX.y] + c])


def predict(S, I, dt, decay, gain):
    """Displacements from t_n to t_(n+1) of the pinned bodies under the forces so far."""
    for q in range(I[HEADER.pinned_count]):
        i = I[I[HEADER.pinned] + q]
        im = dt * (gain * S[i + PARTICLE.inverse_mass])
        ii = dt * (gain * S[i + PARTICLE.inverse_inertia])
        S[i + PARTICLE.step_x] = dt * decay * S[i + PARTICLE.u] + im * S[i + PARTICLE.fx]
        S[i + PARTICLE.step_y] = dt * decay * S[i + PARTICLE.v] + im * S[i + PARTICLE.fy]
        angle = dt * decay * S[i + PARTICLE.w] + ii * S[i + PARTICLE.mz]
        S[i + PARTICLE.step_turn] = angle
        S[i + PARTICLE.step_sine], S[i + PARTICLE.step_versine] = turned(angle)


def change(S, i, x, y):
    """How a vector (x, y) that turns with a body changes from t_n to t_(n+1)."""
    s = S[i + PARTICLE.step_sine]
    v = S[i + PARTICLE.step_versine]
    return -(v * x + s * y), s * x - v * y


def turning(S, q, nx, ny, jb, jk):
    """How a row changes from t_n to t_(n+1)."""
    S[q + CONSTRAINT.turn_x] = nx
    S[q + CONSTRAINT.turn_y] = ny
    S[q + CONSTRAINT.turn_b] = jb
    S[q + CONSTRAINT.turn_k] = jk
    S[q + CONSTRAINT.turn_c] = 0.0


def residual(S, I):
    """What opens in each constraint from t_n to t_(n+1), with a share of what is open; and how its row turns."""
    # Opening = what the step moves the two pins apart + a share of what is open at t_n (Baumgarte's feedback,
    # but of positions alone). Differences
    # of increments come first and positions are multiplied by the small gain, so that rounding of positions
    # hardly enters.
    gain = 1.0 if I[HEADER.coarse] != 0 else GAIN
    for m in range(I[HEADER.joint_count]):
        r = I[HEADER.joint] + JOINT_INDEX.SIZE * m
        i = I[r + JOINT_INDEX.row]
        b = I[r + JOINT_INDEX.bearing]
        k = I[r + JOINT_INDEX.journal]
        y = I[r + JOINT_INDEX.y]
        q = I[r + JOINT_INDEX.first]
        f = I[r + JOINT_INDEX.function]
        place = I[r + JOINT_INDEX.place]
        turn = I[r + JOINT_INDEX.turn]
        aim = S[i + JOINT.offset]
        move = 0.0
        if f != 0:
            aim += S[f + FUNCTION.value]
            move = S[f + FUNCTION.next] - S[f + FUNCTION.value]
        if place != NOWHERE:
            bx, by = arm(S[b + PARTICLE.c], S[b + PARTICLE.s], S[i + JOINT.bearing_x], S[i + JOINT.bearing_y])
            kx, ky = arm(S[k + PARTICLE.c], S[k + PARTICLE.s], S[i + JOINT.journal_x], S[i + JOINT.journal_y])
            ex = (S[k + PARTICLE.x] + kx) - (S[b + PARTICLE.x] + bx)
            ey = (S[k + PARTICLE.y] + ky) - (S[b + PARTICLE.y] + by)
            dbx, dby = change(S, b, bx, by)
            dkx, dky = change(S, k, kx, ky)
            dx = (S[k + PARTICLE.step_x] - S[b + PARTICLE.step_x]) + (dkx - dbx)
            dy = (S[k + PARTICLE.step_y] - S[b + PARTICLE.step_y]) + (dky - dby)
            if place == PINNED:
                S[y] = dx + gain * ex
                S[y + 1] = dy + gain * ey
                turning(S, q, 0.0, 0.0, -dby, -dky)
                turning(S, q + CONSTRAINT.SIZE, 0.0, 0.0, dbx, dkx)
            else:
                guided(S, I, r, gain, ex, ey, dx, dy, kx, ky, dkx, dky, aim, move)
        if turn != FREE:
            q = q + CONSTRAINT.SIZE * (I[r + JOINT_INDEX.rows] - 1)
            y = y + (I[r + JOINT_INDEX.rows] - 1)
            ratio = S[i + JOINT.ratio] if turn == GEARED else 1.0
            c = I[r + JOINT_INDEX.carrier]
            apart = (
                relative_turn(
                    S[b + PARTICLE.theta],
                    S[k + PARTICLE.theta],
                    ratio,
                    S[c + PARTICLE.theta] if c != 0 else 0.0,
                )
                - aim
            )
            turned_by = relative_turn(
                S[b + PARTICLE.step_turn],
                S[k + PARTICLE.step_turn],
                ratio,
                S[c + PARTICLE.step_turn] if c != 0 else 0.0,
            )
            S[y] = (turned_by - move) + gain * apart
            turning(S, q, 0.0, 0.0, 0.0, 0.0)


def guided(S, I, r, gain, ex, ey, dx, dy, kx, ky, dkx, dky, aim, move):
    """The same for a guide, a path or a massless link: the journal's pin is (ex, ey) from the bearing's, goes
    (dx, dy), and a share is closed.
    """
    i = I[r + JOINT_INDEX.row]
    b = I[r + JOINT_INDEX.bearing]
    k = I[r + JOINT_INDEX.journal]
    y = I[r + JOINT_INDEX.y]
    q = I[r + JOINT_INDEX.first]
    place = I[r + JOINT_INDEX.place]
    nx = S[q + CONSTRAINT.nx]
    ny = S[q + CONSTRAINT.ny]
    dnx, dny = change(S, b, nx, ny)
    if place == ON_PATH:  # its normal turns along it too
        dcx, dsx = change(S, b, S[b + PARTICLE.c], S[b + PARTICLE.s])
        measured, mx, my = placed(
            S, place, I[r + JOINT_INDEX.piece], I[r + JOINT_INDEX.pieces], S[b + PARTICLE.c] + dcx, S[b + PARTICLE.s] + dsx,
            S[i + JOINT.direction_x], S[i + JOINT.direction_y], ex + dx, ey + dy,
        )  # fmt: skip
        dnx = mx - nx
        dny = my - ny
        S[y] = measured
    elif place == APART:  # its direction is that from pin to pin
        length = ex * nx + ey * ny
        after, _, mx, my = chord(ex + dx, ey + dy)
        dnx = mx - nx
        dny = my - ny
        S[y] = ((2.0 * ex + dx) * dx + (2.0 * ey + dy) * dy) / (after + length) - move + gain * (length - aim)
    else:
        apart = ex * nx + ey * ny
        opens = (dx * (nx + dnx) + dy * (ny + dny)) + (ex * dnx + ey * dny)
        if place == ALONG:
            apart = apart - aim
            opens = opens - move
        S[y] = opens + gain * apart
    rx = (S[k + PARTICLE.x] + kx) - S[b + PARTICLE.x]
    ry = (S[k + PARTICLE.y] + ky) - S[b + PARTICLE.y]
    mx = (S[k + PARTICLE.step_x] - S[b + PARTICLE.step_x]) + dkx
    my = (S[k + PARTICLE.step_y] - S[b + PARTICLE.step_y]) + dky
    jb = lever(rx + mx, ry + my, dnx, dny) + lever(mx, my, nx, ny)
    jk = lever(kx + dkx, ky + dky, dnx, dny) + lever(dkx, dky, nx, ny)
    turning(S, q, dnx, dny, jb, jk)


def linearisation_error(S, I, dt, gain):
    """Square (m^2) of what the last correction along the rows of t_n leaves open, because they turn to
    t_(n+1) while its forces do not.
    """
    total = 0.0
    for m in range(I[HEADER.joint_count]):
        r = I[HEADER.joint] + JOINT_INDEX.SIZE * m
        p = I[r + JOINT_INDEX.bearing]
        j = I[r + JOINT_INDEX.journal]
        if I[r + JOINT_INDEX.place] != NOWHERE:
            px, py, pw = correction_displacement(S, p, dt, gain)
            jx, jy, jw = correction_displacement(S, j, dt, gain)
            for c in range(2 if I[r + JOINT_INDEX.place] == PINNED else 1):
                q = I[r + JOINT_INDEX.first] + c * CONSTRAINT.SIZE
                along = S[q + CONSTRAINT.turn_x] * (jx - px) + S[q + CONSTRAINT.turn_y] * (jy - py)
                left = along + (S[q + CONSTRAINT.turn_k] * jw - S[q + CONSTRAINT.turn_b] * pw)
                total += left * left
    return total


def correction_displacement(S, i, dt, gain):
    """By how much a correction displaces a body at t_(n+1)."""
    im = dt * (gain * S[i + PARTICLE.inverse_mass])
    ii = dt * (gain * S[i + PARTICLE.inverse_inertia])
    return im * S[i + PARTICLE.change_x], im * S[i + PARTICLE.change_y], ii * S[i + PARTICLE.change_m]


def correct(S, I, dt, gain):
    """Adds corrections to the reactions, and to the bodies' forces, that are solved for."""
    apply_corrections(S, I, dt, gain)
    scale = -1.0 / (dt * gain)
    for m in range(I[HEADER.joint_count]):
        r = I[HEADER.joint] + JOINT_INDEX.SIZE * m
        for c in range(I[r + JOINT_INDEX.rows]):
            S[I[r + JOINT_INDEX.first] + c * CONSTRAINT.SIZE + CONSTRAINT.force] += (
                scale * S[I[r + JOINT_INDEX.y] + c]
            )


def apply_corrections(S, I, dt, gain):
    """Adds to the bodies' forces the corrections that are solved for."""
    for m in range(I[HEADER.joint_count]):
        r = I[HEADER.joint] + JOINT_INDEX.SIZE * m
        for i in (I[r + JOINT_INDEX.bearing], I[r + JOINT_INDEX.journal]):
            S[i + PARTICLE.change_x] = 0.0
            S[i + PARTICLE.change_y] = 0.0
            S[i + PARTICLE.change_m] = 0.0
        if I[r + JOINT_INDEX.carrier] != 0:
            S[I[r + JOINT_INDEX.carrier] + PARTICLE.change_x] = 0.0
            S[I[r + JOINT_INDEX.carrier] + PARTICLE.change_y] = 0.0
            S[I[r + JOINT_INDEX.carrier] + PARTICLE.change_m] = 0.0
    scale = -1.0 / (dt * gain)
    for m in range(I[HEADER.joint_count]):
        r = I[HEADER.joint] + JOINT_INDEX.SIZE * m
        for c in range(I[r + JOINT_INDEX.rows]):
            q = I[r + JOINT_INDEX.first] + c * CONSTRAINT.SIZE
            force = scale * S[I[r + JOINT_INDEX.y] + c]
            accumulate(S, q, I[r + JOINT_INDEX.bearing], I[r + JOINT_INDEX.journal], force)
            if I[r + JOINT_INDEX.carrier] != 0:
                S[I[r + JOINT_INDEX.carrier] + PARTICLE.change_m] -= force * S[q + CONSTRAINT.jc]
    for q in range(I[HEADER.pinned_count]):
        add_forces(S, I[I[HEADER.pinned] + q])
    for m in range(I[HEADER.driven_count]):
        add_forces(S, I[I[HEADER.driven] + DRIVEN_INDEX.SIZE * m + DRIVEN_INDEX.body])


def accumulate(S, q, b, k, force):
    """Adds a reaction to what has been added to the forces of its bodies."""
    px = force * S[q + CONSTRAINT.nx]
    py = force * S[q + CONSTRAINT.ny]
    S[k + PARTICLE.change_x] += px
    S[k + PARTICLE.change_y] += py
    S[k + PARTICLE.change_m] += force * S[q + CONSTRAINT.jk]
    S[b + PARTICLE.change_x] -= px
    S[b + PARTICLE.change_y] -= py
    S[b + PARTICLE.change_m] -= force * S[q + CONSTRAINT.jb]


def add_forces(S, i):
    """Forces of a body with what corrections add."""
    S[i + PARTICLE.fx] += S[i + PARTICLE.change_x]
    S[i + PARTICLE.fy] += S[i + PARTICLE.change_y]
    S[i + PARTICLE.mz] += S[i + PARTICLE.change_m]


def closure_error(S, I, dt, decay, gain):
    """What is to be closed under the forces so far; returned: its square (m^2 and rad^2)."""
    predict(S, I, dt, decay, gain)
    residual(S, I)
    total = 0.0
    for q in range(I[HEADER.constraint_count]):
        total += S[I[HEADER.y] + q] * S[I[HEADER.y] + q]
    return total


def newton(S, I, dt, decay, gain):
    """Corrects the reactions with the rows turned to t_(n+1); returned: as :func:`closure_error` has it, of
    before.
    """
    total = closure_error(S, I, dt, decay, gain)
    fill_turned(S, I)
    halves(S, I, S[SYSTEM.share] + (REDUNDANT if I[HEADER.redundant] != 0 else 0.0))
    solve_turned(S, I, I[HEADER.y])
    correct(S, I, dt, gain)
    return total


def once_more(S, I, dt, decay, gain):
    """Corrects once more with the turned rows of the correction before; returned: as :func:`newton` has it."""
    total = closure_error(S, I, dt, decay, gain)
    solve_turned(S, I, I[HEADER.y])
    correct(S, I, dt, gain)
    return total


def repeat(S, I, dt, decay, gain, much):
    """Newton's method where the corrections so far do not do; a coarse step that it does not close is one
    with an event.
    """
    # Two corrections with fresh factors each; their error is of second order, so the second tells what the
    # first has left.
    newton(S, I, dt, decay, gain)
    left = newton(S, I, dt, decay, gain)
    if I[HEADER.coarse] != 0:
        S[SYSTEM.event] = 1.0 if left > much else S[SYSTEM.event]


def close(S, I, dt, decay, gain):
    """Corrects the reactions so that the joints are closed at t_(n+1)."""
    # 1. Corrections with the factors of t_n, which are there already: one in fine steps, more in coarse ones.
    # 2. What these leave open follows from how the rows turn (linearisation_error), without looking at
    # positions again. Only where it is not next
    #    to nothing does Newton's method follow, with its own factors: an unlikely branch, which the lean step
    # leaves out.
    # 3. In the coarsest steps Newton's method is the rule; its second correction has the factors of the first
    # (once_more).
    # All tests are of squares, in (m and rad)^2: a root would be waited for.
    much = MUCH * S[SYSTEM.size] * (MUCH * S[SYSTEM.size])
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
        most = left * S[SYSTEM.size]
        if seldom(linearisation_error(S, I, dt, gain) > most * most):
            repeat(S, I, dt, decay, gain, much)
    else:
        newton(S, I, dt, decay, gain)
        if seldom(once_more(S, I, dt, decay, gain) > much):
            repeat(S, I, dt, decay, gain, much)
    if I[HEADER.redundant] != 0:
        minimum_norm(S, I)


def close_velocities(S, I, dt):
    """Corrects the half-step velocities so that the joints are closed after a step of another size; the
    reactions are told as they were.
    """
    # The change of a step's size keeps positions; half-step velocities shift by dt^2 and open the joints by a
    # third order of the step. With the
    # forces set to zero, what correct() would add as reactions are impulses that close them; they are no
    # reactions and are not recorded.
    for q in range(I[HEADER.trig_count]):
        i = I[I[HEADER.trig] + q]
        S[i + PARTICLE.s], S[i + PARTICLE.c] = sincos(S[i + PARTICLE.theta])
    for q in range(I[HEADER.pinned_count]):
        i = I[I[HEADER.pinned] + q]
        S[i + PARTICLE.fx] = 0.0
        S[i + PARTICLE.fy] = 0.0
        S[i + PARTICLE.mz] = 0.0
    levers(S, I)
    ahead(S, I, dt)
    fill(S, I)
    factor(S, I, FLOOR if I[HEADER.redundant] != 0 else 0.0)
    for _ in range(I[HEADER.velocity_corrections]):
        predict(S, I, dt, 1.0, 1.0)
        residual(S, I)
        solve(S, I, I[HEADER.y])
        apply_corrections(S, I, dt, 1.0)
    for q in range(I[HEADER.pinned_count]):
        i = I[I[HEADER.pinned] + q]
        S[i + PARTICLE.u] += S[i + PARTICLE.inverse_mass] * S[i + PARTICLE.fx]
        S[i + PARTICLE.v] += S[i + PARTICLE.inverse_mass] * S[i + PARTICLE.fy]
        S[i + PARTICLE.w] += S[i + PARTICLE.inverse_inertia] * S[i + PARTICLE.mz]


def hold(S, I, dt, decay, gain, start):
    """Reactions of all ideal joints at t_n under the other forces."""
    levers(S, I)
    ahead(S, I, dt)
    equations(S, I, dt, start)
    warm_start(S, I)
    close(S, I, dt, decay, gain)
    if seldom(start):
        newton(S, I, dt, decay, gain)
        newton(S, I, dt, decay, gain)
        newton(S, I, dt, decay, gain)
