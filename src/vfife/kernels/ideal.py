"""Ideal revolute joints (paper Eq. 14-17, generalised): reactions that keep bearing and journal in one place.

For two particles alone the block of a joint is (1/m_B + 1/m_J) and its solution is Eq. 16 with external forces. Equal accelerations alone
let positions drift, so the reaction at t_n is the one that closes the joint at t_(n+1) (SHAKE: Ryckaert, Ciccotti and Berendsen 1977). Where
rigid bodies carry several pins the blocks couple; they are factored along the profile of the joint graph, never as a matrix of the mechanism.
"""

from .arrays import JD, JK, JR, C, D, F, H, P, R
from .elementary import sincos, small_turn
from .pin import arm, coupling


def levers(S, I):
    """Arms of all ideal joints at t_n."""
    for m in range(I[H.ideal_count]):
        r = I[H.ideal] + JR.SIZE * m
        i = I[r + JR.row]
        b = I[r + JR.bearing]
        k = I[r + JR.journal]
        S[i + R.bx], S[i + R.by] = arm(S[b + P.c], S[b + P.s], S[i + R.bearing_x], S[i + R.bearing_y])
        S[i + R.kx], S[i + R.ky] = arm(S[k + P.c], S[k + P.s], S[i + R.journal_x], S[i + R.journal_y])


def ahead(S, I, after):
    """Position and direction of the driven bodies at t_(n+1)."""
    for m in range(I[H.driven_count]):
        r = I[H.driven] + JD.SIZE * m
        k = I[r + JD.row]
        i = I[r + JD.body]
        f = I[r + JD.function]
        angle = S[k + D.angle] + S[k + D.speed] * after if f == 0 else S[f + F.next]
        S[i + P.xn] = S[i + P.x]
        S[i + P.yn] = S[i + P.y]
        S[i + P.sn], S[i + P.cn] = sincos(angle)


def fill(S, I):
    """Lower half of the joints' block matrix G M^-1 G^T, summed over the bodies that two joints share."""
    for q in range(I[H.profile_count]):
        S[I[H.profile] + q] = 0.0
    for m in range(I[H.couple_count]):
        r = I[H.couple] + JK.SIZE * m
        first = I[r + JK.first]
        second = I[r + JK.second]
        body = I[r + JK.body]
        xx, xy, yx, yy = coupling(
            S[body + P.inverse_mass],
            S[body + P.inverse_inertia],
            S[I[r + JK.first_arm]],
            S[I[r + JK.first_arm] + 1],
            S[I[r + JK.second_arm]],
            S[I[r + JK.second_arm] + 1],
        )
        sign = 1.0 if I[r + JK.same] != 0 else -1.0
        upper = I[r + JK.upper]
        lower = I[r + JK.lower]
        S[upper] += sign * xx
        if first != second:
            S[upper + 1] += sign * xy
        S[lower] += sign * yx
        S[lower + 1] += sign * yy


def factor(S, I):
    """L D L^T of the block matrix along its profile, in place; a pivot lost to rounding (a redundant joint) is left out."""
    inverse = I[H.inverse]
    for r in range(I[H.row_count]):
        first = I[I[H.row] + 2 * r]
        at = I[I[H.row] + 2 * r + 1]
        for c in range(first, r):
            other = I[I[H.row] + 2 * c + 1]
            start = max(first, I[I[H.row] + 2 * c])
            value = S[at + c]
            for q in range(start, c):
                value -= S[at + q] * S[other + q]
            S[at + c] = value
        diagonal = S[at + r]
        left = diagonal
        for c in range(first, r):
            value = S[at + c]
            ratio = value * S[inverse + c]
            left -= value * ratio
            S[at + c] = ratio
        S[inverse + r] = 1.0 / left if left > 1e-12 * diagonal else 0.0


def solve(S, I, y):
    """Solves with the factors in place."""
    for r in range(I[H.row_count]):
        at = I[I[H.row] + 2 * r + 1]
        value = S[y + r]
        for c in range(I[I[H.row] + 2 * r], r):
            value -= S[at + c] * S[y + c]
        S[y + r] = value
    for r in range(I[H.row_count]):
        S[y + r] = S[y + r] * S[I[H.inverse] + r]
    for q in range(I[H.row_count]):
        r = I[H.row_count] - 1 - q
        at = I[I[H.row] + 2 * r + 1]
        value = S[y + r]
        for c in range(I[I[H.row] + 2 * r], r):
            S[y + c] -= S[at + c] * value


def pull(S, i, b, k, fx, fy):
    """Adds a reaction to ideal joint i: on the journal, and its opposite on the bearing."""
    S[i + R.fx] += fx
    S[i + R.fy] += fy
    S[k + P.fx] += fx
    S[k + P.fy] += fy
    S[k + P.mz] += S[i + R.kx] * fy - S[i + R.ky] * fx
    S[b + P.fx] -= fx
    S[b + P.fy] -= fy
    S[b + P.mz] -= S[i + R.bx] * fy - S[i + R.by] * fx


def recall(S, I):
    """The last step's reactions, as a start."""
    for m in range(I[H.ideal_count]):
        r = I[H.ideal] + JR.SIZE * m
        i = I[r + JR.row]
        fx = S[i + R.fx]
        fy = S[i + R.fy]
        S[i + R.fx] = 0.0
        S[i + R.fy] = 0.0
        pull(S, i, I[r + JR.bearing], I[r + JR.journal], fx, fy)


def gaps(S, I, dt, b, k):
    """Distances journal - bearing at t_(n+1) under the forces so far."""
    y = I[H.y]
    for q in range(I[H.pinned_count]):
        i = I[I[H.pinned] + q]
        im = S[i + P.inverse_mass]
        S[i + P.xn] = S[i + P.x] + dt * (b * S[i + P.u] + k * (im * S[i + P.fx]))
        S[i + P.yn] = S[i + P.y] + dt * (b * S[i + P.v] + k * (im * S[i + P.fy]))
        angle = dt * (b * S[i + P.w] + k * (S[i + P.inverse_inertia] * S[i + P.mz]))
        S[i + P.cn], S[i + P.sn] = small_turn(S[i + P.c], S[i + P.s], angle)
    for m in range(I[H.ideal_count]):
        r = I[H.ideal] + JR.SIZE * m
        i = I[r + JR.row]
        p = I[r + JR.bearing]
        q = I[r + JR.journal]
        bx, by = arm(S[p + P.cn], S[p + P.sn], S[i + R.bearing_x], S[i + R.bearing_y])
        kx, ky = arm(S[q + P.cn], S[q + P.sn], S[i + R.journal_x], S[i + R.journal_y])
        S[y + 2 * m] = (S[q + P.xn] + kx) - (S[p + P.xn] + bx)
        S[y + 2 * m + 1] = (S[q + P.yn] + ky) - (S[p + P.yn] + by)


def close(S, I, dt, b, k):
    """Corrects the reactions so that the joints are closed at t_(n+1)."""
    y = I[H.y]
    gaps(S, I, dt, b, k)
    solve(S, I, y)
    scale = -1.0 / (dt * k)
    for m in range(I[H.ideal_count]):
        r = I[H.ideal] + JR.SIZE * m
        pull(S, I[r + JR.row], I[r + JR.bearing], I[r + JR.journal], scale * S[y + 2 * m], scale * S[y + 2 * m + 1])


def spread(S, I, w, y, b, k, fx, fy, mk, mb):
    """Velocities (from row P.rn or P.rt of each body) per unit of a force pair: f and mk on k, -f and -mb on b, all pinned bodies along."""
    for q in range(I[H.jointed_count]):
        i = I[I[H.jointed] + q]
        S[i + w] = 0.0
        S[i + w + 1] = 0.0
        S[i + w + 2] = 0.0
    S[k + w] = S[k + P.inverse_mass] * fx
    S[k + w + 1] = S[k + P.inverse_mass] * fy
    S[k + w + 2] = S[k + P.inverse_inertia] * mk
    S[b + w] = -S[b + P.inverse_mass] * fx
    S[b + w + 1] = -S[b + P.inverse_mass] * fy
    S[b + w + 2] = -S[b + P.inverse_inertia] * mb
    for m in range(I[H.ideal_count]):
        r = I[H.ideal] + JR.SIZE * m
        i = I[r + JR.row]
        p = I[r + JR.bearing] + w
        q = I[r + JR.journal] + w
        S[y + 2 * m] = (S[q] - S[i + R.ky] * S[q + 2]) - (S[p] - S[i + R.by] * S[p + 2])
        S[y + 2 * m + 1] = (S[q + 1] + S[i + R.kx] * S[q + 2]) - (S[p + 1] + S[i + R.bx] * S[p + 2])
    solve(S, I, y)
    for m in range(I[H.ideal_count]):
        r = I[H.ideal] + JR.SIZE * m
        i = I[r + JR.row]
        p = I[r + JR.bearing]
        q = I[r + JR.journal]
        gx = S[y + 2 * m]
        gy = S[y + 2 * m + 1]
        S[q + w] -= S[q + P.inverse_mass] * gx
        S[q + w + 1] -= S[q + P.inverse_mass] * gy
        S[q + w + 2] -= S[q + P.inverse_inertia] * (S[i + R.kx] * gy - S[i + R.ky] * gx)
        S[p + w] += S[p + P.inverse_mass] * gx
        S[p + w + 1] += S[p + P.inverse_mass] * gy
        S[p + w + 2] += S[p + P.inverse_inertia] * (S[i + R.bx] * gy - S[i + R.by] * gx)


def respond(S, I, j, b, k):
    """Inverse masses (1/kg) of clearance joint j along n and t, and their coupling, where its bodies hang in ideal joints."""
    nx = S[j + C.nx]
    ny = S[j + C.ny]
    jn = S[j + C.jn]
    jt = S[j + C.jt]
    bn = S[j + C.bn]
    bt = S[j + C.bt]
    spread(S, I, P.rn, I[H.gn], b, k, nx, ny, jn, bn)
    spread(S, I, P.rt, I[H.gt], b, k, -ny, nx, jt, bt)
    nu = S[k + P.rn] - S[b + P.rn]
    nv = S[k + P.rn + 1] - S[b + P.rn + 1]
    tu = S[k + P.rt] - S[b + P.rt]
    tv = S[k + P.rt + 1] - S[b + P.rt + 1]
    gn = nx * nu + ny * nv + jn * S[k + P.rn + 2] - bn * S[b + P.rn + 2]
    gt = nx * tv - ny * tu + jt * S[k + P.rt + 2] - bt * S[b + P.rt + 2]
    gm = nx * nv - ny * nu + jt * S[k + P.rn + 2] - bt * S[b + P.rn + 2]
    return gn, gt, gm


def hold(S, I, h, normal, friction):
    """Velocities at t_n and reactions after a change of the force in the clearance joint that ``respond`` was last asked about."""
    for q in range(I[H.jointed_count]):
        i = I[I[H.jointed] + q]
        S[i + P.vu] += h * (friction * S[i + P.rt] - normal * S[i + P.rn])
        S[i + P.vv] += h * (friction * S[i + P.rt + 1] - normal * S[i + P.rn + 1])
        S[i + P.vw] += h * (friction * S[i + P.rt + 2] - normal * S[i + P.rn + 2])
    for m in range(I[H.ideal_count]):
        r = I[H.ideal] + JR.SIZE * m
        n = I[H.gn] + 2 * m
        f = I[H.gt] + 2 * m
        fx = normal * S[n] - friction * S[f]
        fy = normal * S[n + 1] - friction * S[f + 1]
        pull(S, I[r + JR.row], I[r + JR.bearing], I[r + JR.journal], fx, fy)
