"""The loop driver, one text for all loops: take steps, repeat those with events in smaller steps, record
outputs, detect lanes that fail.

**Events.** A central difference uses the force at the end of a step for all of it. Where a contact begins,
friction changes its regime, or a load has a kink, the error is of first order in the step; eight steps of an
eighth reduce it to a sixty-fourth. Such a step is an *event* and is repeated in ``parts`` smaller steps.
Small steps throughout would cost eight times as much for the same accuracy. Cutting the step at the time of
the event would need an iteration for that time, which differs from lane to lane.

**Functions of a loop.** The driver calls four functions, of which each loop has its own:

``fast_steps(S, R, T, I, n, count, watching)``
    Take up to ``count`` steps from step n and return how many were taken. Straight-line code stops before the
    first step that the fast step cannot take. The data-driven loop takes any step, and stops before one with
    an event if ``watching``. R is scratch of the size of S.
``full_step(S, T, I, n)``
    Take step n, whatever happens in it.
``functions(S, T, I, n)``
    Evaluate functions of time at step n.
``resize(S, I, C)``
    Change the state, lane by lane, to the step size C[0] and the phase C[1], and add C[2] to its number of
    events.

:mod:`~vfife.kernels.data_driven` has those of the data-driven loop, ``compiler/trace/straight_line.py`` those
of straight-line code. For the latter the driver is compiled once for all mechanisms, or translated to
JavaScript.

**Layout.** Row r of lane w is ``S[r * stride + w]``: lanes lie side by side on a processor; on a graphics
card, so do the cases of a tile.

**Rules that other files rely on.** Step n leads to t_n, and the state after it has velocities at
t_n + step/2. Step 0 is the start, of half a step. Lanes do not wait for each other within a step: all take
it, and if only some have an event, only those keep the result of the smaller steps. Steps may be divided
among any number of calls with the same bits; companions, streams and checkpoints depend on that.
"""

from typing import NamedTuple

from .arrays import SYSTEM, Counts, Integers, Numbers, fields
from .data_driven import copy_lane, fast_steps, full_step, resize
from .step import functions

# The array N of a run: number of lanes, distance between two rows in S, number of rows, parts of a step with
# an event (Settings.parts of a model, 8 by default: model/mechanism.py), steps between two checks of lanes
# (LOOK for a run, STREAM_LOOK for a stream of cases, in compiler/runtime/runner.py).
RUN = fields("lanes", "stride", "rows", "parts", "look")


class Memory(NamedTuple):
    """Arrays of a run.

    S (rows x lanes) is the state; Q, R (as S) and C (3 x lanes) are scratch. T holds the tables of functions,
    I the topology of the data-driven loop, N the numbers of :data:`RUN`. ``shares`` (lanes) are additional
    first steps, as shares of a step, which shift the phase of a lane (:func:`displace`). ``recorded`` are the
    rows that are recorded, ``extremes`` those that are set to zero before each output. A lane fails if a
    recorded row is not finite, or if one of the rows ``limited`` leaves its two ``limits`` (limited x 2 x
    lanes); ``broken`` (lanes) is then the step at which this was found. It is 0 before, and negative in lanes
    that are not watched.
    """

    S: Numbers
    Q: Numbers
    R: Numbers
    C: Numbers
    T: Numbers
    I: Integers
    N: Counts
    shares: Numbers
    recorded: Integers
    extremes: Integers
    limited: Integers
    limits: Numbers
    broken: Numbers


class Outputs(NamedTuple):
    """Outputs of a stream, lane by lane: the step ``due`` of the next output, the steps ``interval`` between
    two, the number of outputs ``at`` so far, and the number ``stop`` that ends the stream.

    ``out`` (lanes x room x recorded) receives them. The rows ``sound`` must be finite: those that outputs and
    checkpoints consist of.
    """

    due: Counts
    interval: Counts
    at: Counts
    stop: Counts
    out: Numbers
    sound: Integers


def advance(m: Memory, reset: int, until: int, n0: int, count: int, outputs: int, out: Numbers):
    """Take ``outputs`` times ``count`` steps from step n0, and record the rows ``recorded`` after each
    ``count`` steps in ``out`` (outputs, recorded, lanes).

    If ``reset`` is not 0, extremes are set to zero before each output. An empty ``out`` records nothing.
    After the start, lane w takes one more step of the share ``shares[w]`` of a step, if that is not zero.
    Lanes are checked ``until`` steps after n0 and every RUN.look steps from there. Callers choose ``until``
    so that checks come at multiples of RUN.look, however the steps are divided among calls. The function
    returns early when all watched lanes have failed.
    """
    S, N, recorded, extremes, broken = m.S, m.N, m.recorded, m.extremes, m.broken
    lanes, stride = N[RUN.lanes], N[RUN.stride]
    n = n0
    check = n0 + until
    for output in range(outputs):
        if reset != 0:
            for q in range(len(extremes)):
                for w in range(lanes):
                    S[extremes[q] * stride + w] = 0.0
        last = n0 + (output + 1) * count
        # Fast steps run up to the next output or check, whichever comes first: they need no test for either.
        while n < last:
            if n == 0:
                full_step(S, m.T, m.I, 0)
                displace(m)
                n = 1
            else:
                n = proceed(m, n, min(last, check))
            if n == check:
                check += N[RUN.look]
                # Without a lane that is watched nothing can fail, and the run goes on to its end.
                if not sound_lanes(m, recorded, n) and failed_lanes(broken, lanes):
                    return
        if len(out) > 0:
            for q in range(len(recorded)):
                place = (output * len(recorded) + q) * lanes
                if lanes == 4:
                    copy_four(out, place, S, recorded[q] * stride)
                else:
                    copy_numbers(out, place, S, recorded[q] * stride, lanes)


def stream(m: Memory, o: Outputs, room: int, until: int, n0: int, count: int) -> int:
    """Take up to ``count`` steps from step n0 > 0, with outputs of each lane at steps of its own.

    After step ``due[w]`` the rows ``recorded`` of lane w become its output ``at[w]``, its extremes are set to
    zero, and the next output is due ``interval[w]`` steps later. Lanes are checked as in :func:`advance`. The
    function returns as soon as a lane has reached its output ``stop[w]`` or has failed, so that the caller
    can put another simulation into that lane. Returns the number of the last step.
    """
    S, N, recorded, extremes, broken = m.S, m.N, m.recorded, m.extremes, m.broken
    due, interval, at, stop, out = o.due, o.interval, o.at, o.stop, o.out
    lanes, stride = N[RUN.lanes], N[RUN.stride]
    last = n0 + count
    check = n0 + until
    n = n0
    is_over = False
    # Lanes share the number of the step, not their outputs: fast steps run up to the next output of any lane.
    while n < last and not is_over:
        soonest = last
        for w in range(lanes):
            soonest = min(soonest, due[w])
        while n < soonest and not is_over:
            n = proceed(m, n, min(soonest, check))
            if n == check:
                check += N[RUN.look]
                sound_lanes(m, o.sound, n)
                is_over = failed_lanes(broken, lanes)
        if not is_over:
            for w in range(lanes):
                if due[w] == n:
                    place = (w * room + at[w]) * len(recorded)
                    for q in range(len(recorded)):
                        out[place + q] = S[recorded[q] * stride + w]
                    for q in range(len(extremes)):
                        S[extremes[q] * stride + w] = 0.0
                    at[w] += 1
                    due[w] += interval[w]
                    is_over = at[w] >= stop[w] or is_over
    return n


def proceed(m: Memory, n, end):
    """Take steps n to ``end`` - 1, or up to and including the first event; return the next step's number."""
    n += fast_steps(m.S, m.Q, m.T, m.I, n, end - n, m.N[RUN.parts] > 1)
    if n < end:
        event(m, n)
        n += 1
    return n


def sound_lanes(m: Memory, rows, n):
    """Mark lanes that have failed after n steps; return whether a watched lane without failure is left.

    A lane fails if one of ``rows`` is not finite, or a row of ``limited`` is outside its two ``limits``. A
    nonzero entry of ``broken`` marks a lane that has failed already or is not watched.
    """
    S, N, limited, limits, broken = m.S, m.N, m.limited, m.limits, m.broken
    lanes, stride = N[RUN.lanes], N[RUN.stride]
    left = False
    for w in range(lanes):
        if broken[w] == 0.0:
            # One sum and one comparison for all rows: infinity times zero is NaN, and a sum that contains
            # NaN is NaN. Comparisons with NaN are false, so that a NaN among ``limited`` fails as well.
            check = 0.0
            for q in range(len(rows)):
                check += S[rows[q] * stride + w] * 0.0
            within = check == 0.0
            for q in range(len(limited)):
                x = S[limited[q] * stride + w]
                within = within and x >= limits[2 * q * stride + w] and x <= limits[(2 * q + 1) * stride + w]
            if within:
                left = True
            else:
                broken[w] = float(n)
    return left


def failed_lanes(broken, lanes):
    """Return whether a lane has failed."""
    failed = False
    for w in range(lanes):
        failed = failed or broken[w] > 0.0
    return failed


def event(m: Memory, n):
    """Take step n as a full step, and repeat it in ``parts`` smaller steps for lanes with an event.

    The smaller steps start from Q, a copy of the state before step n. They have the numbers (n - 1) parts + 1
    to n parts, and the phase is multiplied by ``parts``, so that time remains (step + phase) * size. All
    lanes take them; only those with an event keep the result.
    """
    S, Q, C, T, I, N = m.S, m.Q, m.C, m.T, m.I, m.N
    lanes, stride, parts = N[RUN.lanes], N[RUN.stride], N[RUN.parts]
    copy(Q, S, N)
    full_step(S, T, I, n)
    count = 0
    if parts > 1:
        for w in range(lanes):
            if S[SYSTEM.event * stride + w] > 0.0:
                count += 1
    if count == 0:
        return
    # resize shifts velocities from half a step after t_(n-1) to half a small step after it, and needs the
    # functions of time at t_(n-1) for prescribed motions.
    for w in range(lanes):
        C[w] = S[SYSTEM.step * stride + w] / parts
        C[stride + w] = S[SYSTEM.shift * stride + w] * parts
        C[2 * stride + w] = 1.0
    functions(Q, T, I, n - 1)
    resize(Q, I, C)
    last = n * parts
    i = last - parts
    while i < last:
        # An event within a smaller step is not refined again: its error is an eighth squared of that of a
        # step, and one more level would cost eight more steps.
        i += fast_steps(Q, m.R, T, I, i + 1, last - i, False)
        if i < last:
            i += 1
            full_step(Q, T, I, i)
    for w in range(lanes):
        C[w] = S[SYSTEM.step * stride + w]
        C[stride + w] = S[SYSTEM.shift * stride + w]
        C[2 * stride + w] = 0.0
    resize(Q, I, C)
    if count == lanes:
        copy(S, Q, N)
    else:
        for w in range(lanes):
            if S[SYSTEM.event * stride + w] > 0.0:
                copy_lane(S, Q, N[RUN.rows], stride, w)


def displace(m: Memory):
    """After the start, take one step of the share ``shares[w]`` of a step in lanes where it is not zero, so
    that their later steps lie between those of the other lanes.

    Derivatives use it (``solvers/tangents.py``): in displaced runs, events lie elsewhere in their steps.
    """
    S, Q, C, T, I, N, shares = m.S, m.Q, m.C, m.T, m.I, m.N, m.shares
    lanes, stride = N[RUN.lanes], N[RUN.stride]
    moved = False
    for w in range(lanes):
        moved = moved or shares[w] > 0.0
    if not moved:
        return
    copy(Q, S, N)
    for w in range(lanes):
        C[w] = shares[w] * S[SYSTEM.step * stride + w]
        C[stride + w] = 0.0
        C[2 * stride + w] = 0.0
    resize(Q, I, C)
    full_step(Q, T, I, 1)
    for w in range(lanes):
        C[w] = S[SYSTEM.step * stride + w]
        C[stride + w] = shares[w]
    resize(Q, I, C)
    for w in range(lanes):
        if shares[w] > 0.0:
            copy_lane(S, Q, N[RUN.rows], stride, w)


def copy(to, source, N):
    """Copy the state of all lanes; lanes beyond N.lanes in a stride are left alone."""
    lanes, stride, rows = N[RUN.lanes], N[RUN.stride], N[RUN.rows]
    if lanes == stride:
        copy_numbers(to, 0, source, 0, rows * lanes)
    else:
        for w in range(lanes):
            copy_lane(to, source, rows, stride, w)


def copy_numbers(to, at, source, place, count):
    """Copy ``count`` consecutive numbers, four at a time."""
    fours = 4 * (count // 4)
    for q in range(0, fours, 4):
        copy_four(to, at + q, source, place + q)
    for q in range(fours, count):
        to[at + q] = source[place + q]


def copy_four(to, at, source, place):
    """Copy four numbers, all read before one is written, so that the compiler makes one vector of them."""
    a = source[place]
    b = source[place + 1]
    c = source[place + 2]
    d = source[place + 3]
    to[at] = a
    to[at + 1] = b
    to[at + 2] = c
    to[at + 3] = d
