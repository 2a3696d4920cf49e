"""The loop driver, one text for all loops: which steps are taken, which are taken again in parts, what is
recorded, and when a lane breaks.

A central difference takes the force at the end of a step for all of it. Where a contact begins, friction
changes its regime or a load has a kink, that is an error of first order in the step; eight steps of an eighth
leave a sixty-fourth of it. Such a step is an *event*, and is taken again in ``parts``. Smaller steps
throughout would cost eight times as much for the same; a step that is cut at the event itself would have to
be solved for the time of it, and differ from lane to lane.

The driver calls four functions, which differ between loops:

    fast_steps(S, R, T, I, n, count, watching)  take up to ``count`` steps from step n, stop before the first
    that a fast step cannot take, and
                                                return how many were taken. Those of the data-driven loop can
                                                take any; where ``watching``, they stop before one with an
                                                event. R is scratch of the size of S.
    full_step(S, T, I, n)                       take step n, whatever happens in it.
    functions(S, T, I, n)                       functions of time at step n.
    resize(S, I, C)                             give the state the step size C[0] and phase C[1], and add C[2]
    to the count of events, lane by lane.

Those of the data-driven loop are in :mod:`~vfife.kernels.data_driven`. Straight-line code has its own
(``compiler/trace/straight_line.py``); there the driver is compiled once for all mechanisms, or translated to
JavaScript.

Row r of lane w lies at ``S[r * stride + w]``: lanes side by side on a processor, members of a tile on a
graphics card.

Rules that other files rely on: step n leads to t_n, and the state after it has velocities at t_n + step/2.
Step 0 is the start, half a step. Lanes never wait for each other within a step: all take it, and where only
some have an event, those alone keep the parts. A step may be taken in any number of calls, with the same
bits; companions, streams and checkpoints depend on it.
"""

from typing import NamedTuple

from .arrays import SYSTEM, Counts, Fields, Integers, Numbers
from .data_driven import copy_lane, fast_steps, full_step, resize
from .step import functions

# Numbers of a run, the array N: lanes, distance of two rows, rows of a state, parts of a step with an event,
# steps between two checks of lanes. The caller sets them; the steps between checks are LOOK of a run and
# STREAM_LOOK of a stream of cases, both in compiler/runtime/runner.py.
RUN = Fields((name, 1) for name in ("lanes", "stride", "rows", "parts", "look"))


class Memory(NamedTuple):
    """What a run works on.

    S (rows x lanes) is the state; Q, R (as S) and C (3 x lanes) are scratch; T holds the tables of functions,
    I the topology of the data-driven loop, N the numbers of a run. ``shares`` (lanes) are first steps, as
    parts of one, that come beside those that are counted. The rows ``recorded`` are recorded; ``extremes``
    are rows that start from zero before each output. A number of the rows ``limited`` lies between two of
    ``limits`` (limited x 2 x lanes), and those that are recorded are finite, or the lane breaks: ``broken``
    (lanes) is then the step at which that was found. It is 0 before, and negative in lanes that are not
    watched.
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
    """Outputs of a stream, lane by lane: the step of the next one, steps between two, outputs so far, and
    that with which the stream ends.

    ``out`` (lanes x room x recorded) takes them. Rows ``sound`` have to be finite: those that the outputs, or
    a checkpoint, are made of.
    """

    due: Counts
    every: Counts
    at: Counts
    stop: Counts
    out: Numbers
    sound: Integers


def advance(m: Memory, reset: int, until: int, n0: int, count: int, outputs: int, out: Numbers):
    """Take ``outputs`` times ``count`` steps from step n0 and record the rows ``recorded`` after each
    ``count`` in ``out`` (outputs, recorded, lanes).

    Extremes start from zero before each output where ``reset`` is not 0. Nothing is recorded into an empty
    ``out``. Right after the start lane w takes a step of ``shares[w]`` of one, where that is not zero. Lanes
    are checked ``until`` steps from n0 and every RUN.look steps from there: callers choose ``until`` so that
    checks come at multiples of RUN.look, whatever the calls. When no lane is left that is sound and watched,
    the rest is left out.
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
        while n < last:
            if n == 0:
                full_step(S, m.T, m.I, 0)
                displace(m)
                n = 1
            else:
                n = proceed(m, n, min(last, check))
            if n == check:
                check += N[RUN.look]
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
    """Take up to ``count`` steps from step n0, which is not 0; every lane records outputs of its own.

    After step ``due[w]`` the rows ``recorded`` of lane w are recorded as output ``at[w]``, its extremes start
    from zero, and it is due again ``every[w]`` steps later. Lanes are checked as :func:`advance` does. It
    ends when a lane has reached its output ``stop[w]`` or is found broken, so that the caller can put another
    simulation there; returns the number of steps made since the very start.
    """
    S, N, recorded, extremes, broken = m.S, m.N, m.recorded, m.extremes, m.broken
    due, every, at, stop, out = o.due, o.every, o.at, o.stop, o.out
    lanes, stride = N[RUN.lanes], N[RUN.stride]
    last = n0 + count
    check = n0 + until
    n = n0
    is_over = False
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
                    due[w] += every[w]
                    is_over = at[w] >= stop[w] or is_over
    return n


def proceed(m: Memory, n, end):
    """Take steps from n up to ``end``, or up to and with the first event; return the next step's number."""
    n += fast_steps(m.S, m.Q, m.T, m.I, n, end - n, m.N[RUN.parts] > 1)
    if n < end:
        event(m, n)
        n += 1
    return n


def sound_lanes(m: Memory, rows, n):
    """Mark lanes that have failed after n steps, and return whether a sound watched lane is left.

    A lane fails where one of ``rows`` is not finite or a row of ``limited`` is not between its two
    ``limits``. A nonzero entry of ``broken`` marks a lane that has failed already or is not watched.
    """
    S, N, limited, limits, broken = m.S, m.N, m.limited, m.limits, m.broken
    lanes, stride = N[RUN.lanes], N[RUN.stride]
    left = False
    for w in range(lanes):
        if broken[w] == 0.0:
            # One sum and one comparison for all rows: infinity times zero is NaN, as NaN is, and whatever is
            # added to it stays so.
            nothing = 0.0
            for q in range(len(rows)):
                nothing += S[rows[q] * stride + w] * 0.0
            within = nothing == 0.0
            for q in range(len(limited)):
                x = S[limited[q] * stride + w]
                within = within and x >= limits[2 * q * stride + w] and x <= limits[(2 * q + 1) * stride + w]
            if within:
                left = True
            else:
                broken[w] = float(n)
    return left


def failed_lanes(broken, lanes):
    """Whether a lane has failed."""
    failed = False
    for w in range(lanes):
        failed = failed or broken[w] > 0.0
    return failed


def event(m: Memory, n):
    """Take step n as a full step; lanes in which something began, ended or changed its regime take it again
    in ``parts``.

    The small steps are those of a state of its own, Q, from before step n: they are numbered from (n - 1)
    parts + 1 to n parts, and the phase is multiplied by ``parts``, so that time stays (step + phase) * size.
    All lanes go along; only those with an event keep the result.
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
    for w in range(lanes):
        C[w] = S[SYSTEM.step * stride + w] / parts
        C[stride + w] = S[SYSTEM.shift * stride + w] * parts
        C[2 * stride + w] = 1.0
    functions(Q, T, I, n - 1)
    resize(Q, I, C)
    last = n * parts
    i = last - parts
    while i < last:
        # An event within an eighth of a step is not refined again: the parts of parts would cost more than
        # the error that they save.
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
    """After the start, take a first step of a share of one in lanes where that is not zero: their later steps
    lie between those of the others.
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
    """Copy a state."""
    lanes, stride, rows = N[RUN.lanes], N[RUN.stride], N[RUN.rows]
    if lanes == stride:
        copy_numbers(to, 0, source, 0, rows * lanes)
    else:
        for w in range(lanes):
            copy_lane(to, source, rows, stride, w)


def copy_numbers(to, at, source, place, count):
    """Copy ``count`` numbers that lie one behind the other."""
    fours = 4 * (count // 4)
    for q in range(0, fours, 4):
        copy_four(to, at + q, source, place + q)
    for q in range(fours, count):
        to[at + q] = source[place + q]


def copy_four(to, at, source, place):
    """Copy four numbers: all are read before one is written, so that they become one vector."""
    a = source[place]
    b = source[place + 1]
    c = source[place + 2]
    d = source[place + 3]
    to[at] = a
    to[at + 1] = b
    to[at + 2] = c
    to[at + 3] = d
