"""The loop driver, one text for all loops: which steps are taken, which are taken again in parts, what is
recorded, and when a lane breaks.

A central difference takes the force at the end of a step for all of it. Where a contact begins, friction
changes its regime or a load has a kink, that is an error of first order in the step; eight steps of an eighth
leave a sixty-fourth of it. Such a step is an *event*, and is taken again in ``parts``.

The driver calls four functions, which differ between loops:

    lean(S, R, T, I, n, count, watching)  takes up to ``count`` steps from step n and stops before the first
    that the lean step cannot take;
                                          returns how many it took. R is scratch of the size of S.
    whole(S, T, I, n)                     takes step n, whatever happens in it.
    functions(S, T, I, n)                 functions of time at step n.
    resize(S, I, C)                       gives the state the step size C[0], phase C[1] and adds C[2] to the
    count of events, lane by lane.

Those of the data-driven loop are in :mod:`~vfife.kernels.data_driven`. Straight-line code has its own
(:mod:`vfife.compiler.trace.straight_line`); there the driver is compiled once for all mechanisms, or
translated to JavaScript.

Row r of lane w lies at ``S[r * stride + w]``: lanes side by side on a processor, members of a tile on a
graphics card. Q, R and C are scratch: two copies of the state and three rows.
"""

from .arrays import SYSTEM, Fields
from .data_driven import copy_lane, lean, resize, whole
from .step import functions

# Numbers of a run, the array N: lanes, distance of two rows, rows of a state, parts of a step with an event,
# steps between two checks of lanes.
RUN = Fields((name, 1) for name in ("lanes", "stride", "rows", "parts", "look"))


def advance(
    S, Q, R, C, T, I, N, shares, kept, extremes, limited, limits, broken, anew, until, n0, count, outputs, out
):
    """Take ``outputs`` times ``count`` steps from step n0 and record the rows ``kept`` after each ``count``
    in ``out`` (outputs, kept, lanes).

    Rows ``extremes`` start from zero before each output where ``anew`` is not 0. Nothing is recorded into an
    empty ``out``. Right after the start lane w takes a step of ``shares[w]`` of one, where that is not zero.
    Lanes are checked ``until`` steps from n0 and every ``look`` steps from there; when no lane is left that
    is sound and watched, the rest is left out.
    """
    lanes, stride, look = N[RUN.lanes], N[RUN.stride], N[RUN.look]
    n = n0
    seen = n0 + until
    for m in range(outputs):
        if anew != 0:
            for q in range(len(extremes)):
                for w in range(lanes):
                    S[extremes[q] * stride + w] = 0.0
        last = n0 + (m + 1) * count
        while n < last:
            if n == 0:
                whole(S, T, I, 0)
                displace(S, Q, C, T, I, N, shares)
                n = 1
            else:
                n = proceed(S, Q, R, C, T, I, N, n, min(last, seen))
            if n == seen:
                seen += look
                if not watch(S, N, kept, limited, limits, broken, n):
                    return
        if len(out) > 0:
            first = m * len(kept)
            for q in range(len(kept)):
                if lanes == 4:
                    copy_four(out, (first + q) * 4, S, kept[q] * stride)
                else:
                    copy_numbers(out, (first + q) * lanes, S, kept[q] * stride, lanes)


def stream(
    S,
    Q,
    R,
    C,
    T,
    I,
    N,
    kept,
    extremes,
    sound,
    limited,
    limits,
    broken,
    due,
    every,
    at,
    stop,
    out,
    room,
    until,
    n0,
    count,
):
    """Take up to ``count`` steps from step n0, which is not 0; every lane records outputs of its own.

    After step ``due[w]`` the rows ``kept`` of lane w are recorded as output ``at[w]`` in ``out`` (lanes,
    room, kept), its extremes start from zero, and it is due again ``every[w]`` steps later. Rows ``sound``
    are checked, as :func:`advance` does. It ends when a lane has reached its output ``stop[w]`` or is found
    broken; the number of steps made since the very start is returned.
    """
    lanes, stride, look = N[RUN.lanes], N[RUN.stride], N[RUN.look]
    last = n0 + count
    seen = n0 + until
    n = n0
    ended = False
    while n < last and not ended:
        soonest = last
        for w in range(lanes):
            soonest = min(soonest, due[w])
        while n < soonest and not ended:
            n = proceed(S, Q, R, C, T, I, N, n, min(soonest, seen))
            if n == seen:
                seen += look
                watch(S, N, sound, limited, limits, broken, n)
                for w in range(lanes):
                    ended = ended or broken[w] > 0.0
        if not ended:
            for w in range(lanes):
                if due[w] == n:
                    place = (w * room + at[w]) * len(kept)
                    for q in range(len(kept)):
                        out[place + q] = S[kept[q] * stride + w]
                    for q in range(len(extremes)):
                        S[extremes[q] * stride + w] = 0.0
                    at[w] += 1
                    due[w] += every[w]
                    ended = ended or at[w] >= stop[w]
    return n


def proceed(S, Q, R, C, T, I, N, n, end):
    """Take steps from n up to ``end``, or up to and with the first event; return the number of the next step."""
    n += lean(S, Q, T, I, n, end - n, N[RUN.parts] > 1)
    if n < end:
        event(S, Q, R, C, T, I, N, n)
        n += 1
    return n


def watch(S, N, kept, limited, limits, broken, n):
    """Mark lanes that have failed after n steps, and return whether to go on: a sound watched lane is left,
    or none has failed.

    A lane fails where one of the rows ``kept`` is not finite (times zero it is NaN then) or a row of
    ``limited`` is not between its two ``limits`` (limited, 2, lanes). ``broken`` is 0 for a sound lane, else
    the step at which it was found broken, or negative if the lane is not watched.
    """
    lanes, stride = N[RUN.lanes], N[RUN.stride]
    left = False
    failed = False
    for w in range(lanes):
        if broken[w] == 0.0:
            nothing = 0.0
            for q in range(len(kept)):
                nothing += S[kept[q] * stride + w] * 0.0
            within = nothing == 0.0
            for q in range(len(limited)):
                x = S[limited[q] * stride + w]
                within = within and x >= limits[2 * q * stride + w] and x <= limits[(2 * q + 1) * stride + w]
            if within:
                left = True
            else:
                broken[w] = float(n)
        failed = failed or broken[w] > 0.0
    return left or not failed


def event(S, Q, R, C, T, I, N, n):
    """Take step n as a whole; lanes in which something began, ended or changed its regime take it again in
    ``parts``.

    The small steps are those of a state of its own, Q, from before step n: they are numbered from (n - 1)
    parts + 1 to n parts, and the phase is multiplied by ``parts``, so that time stays (step + phase) * size.
    All lanes go along; only those with an event keep the result.
    """
    lanes, stride, rows, parts = N[RUN.lanes], N[RUN.stride], N[RUN.rows], N[RUN.parts]
    copy(Q, S, rows, lanes, stride)
    whole(S, T, I, n)
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
        i += lean(Q, R, T, I, i + 1, last - i, False)
        if i < last:
            i += 1
            whole(Q, T, I, i)
    for w in range(lanes):
        C[w] = S[SYSTEM.step * stride + w]
        C[stride + w] = S[SYSTEM.shift * stride + w]
        C[2 * stride + w] = 0.0
    resize(Q, I, C)
    if count == lanes:
        copy(S, Q, rows, lanes, stride)
    else:
        for w in range(lanes):
            if S[SYSTEM.event * stride + w] > 0.0:
                copy_lane(S, Q, rows, stride, w)


def displace(S, Q, C, T, I, N, shares):
    """After the start, take a first step of a share of one in lanes where that is not zero: their later steps
    lie between those of the others.
    """
    lanes, stride, rows = N[RUN.lanes], N[RUN.stride], N[RUN.rows]
    moved = False
    for w in range(lanes):
        moved = moved or shares[w] > 0.0
    if not moved:
        return
    copy(Q, S, rows, lanes, stride)
    for w in range(lanes):
        C[w] = shares[w] * S[SYSTEM.step * stride + w]
        C[stride + w] = 0.0
        C[2 * stride + w] = 0.0
    resize(Q, I, C)
    whole(Q, T, I, 1)
    for w in range(lanes):
        C[w] = S[SYSTEM.step * stride + w]
        C[stride + w] = shares[w]
    resize(Q, I, C)
    for w in range(lanes):
        if shares[w] > 0.0:
            copy_lane(S, Q, rows, stride, w)


def copy(to, source, rows, lanes, stride):
    """Copy a state."""
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
