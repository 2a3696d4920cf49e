"""The two mechanisms of the problems, written twice: each integration of certify.py has its own coordinates.

A text is independent of the other: ``FourBarAtCentres`` and ``SliderCrankAtCentres`` have the centres of mass
of the bodies as coordinates and a diagonal mass matrix, ``FourBarAtPins`` and ``SliderCrankInComplexNumbers``
have other ones. All of them have the same methods:

``rates(t, y, modes)``: derivatives of the state while the modes of the contacts last.
``gaps(t, y)``: for each contact its penetration (m), its rate (m/s) and the sliding speed (m/s).
``outputs(t, y, modes)``: the quantities of the table.

A mode of a contact is (whether it touches, approach speed of the last onset, band of friction); within one
set of modes the rates are smooth. Bands of friction: -2 and 2 full, -1 and 1 on the ramp, 0 none.
"""

from __future__ import annotations

import math
from typing import Any

K = 6.6e10  # N/m^1.5
RESTITUTION = 0.9
HYSTERESIS = 0.75 * (1.0 - RESTITUTION**2)
LEAST_APPROACH = 1e-3  # m/s
V0, V1 = 1e-4, 1e-2  # m/s

Mode = tuple[bool, Any, int]


def normal_force(depth: Any, rate: Any, approach: Any, sqrt: Any) -> Any:
    """Lankarani and Nikravesh: K d^1.5 (1 + 3(1 - e^2)/4 d'/d'0)."""
    if depth <= 0.0:
        return 0.0 * depth
    return K * depth * sqrt(depth) * (1.0 + HYSTERESIS * rate / max(approach, LEAST_APPROACH))


def friction_share(speed: Any, band: int) -> Any:
    """Ambrosio's c_d sgn(v) with the text of one band."""
    if band == 0:
        return 0.0 * speed
    sign = 1.0 if band > 0 else -1.0
    return sign + 0.0 * speed if abs(band) == 2 else (speed - sign * V0) / (V1 - V0)


def band_of(speed: Any) -> int:
    """Return the friction band of a sliding speed (m/s)."""
    size = 0 if abs(speed) <= V0 else 1 if abs(speed) < V1 else 2
    return size if speed > 0.0 else -size


class FourBar:
    """Problem 1. Numbers in SI units; no gravity."""

    crank, coupler, follower, ground = 0.40, 0.26, 0.46, 0.15
    masses = 2.028, 3.588
    clearance, bearing = 2e-4, 0.010
    friction = 0.1
    speed = 50.0 * math.pi
    duration, window = 0.08, 0.04
    contacts = 3
    sizes = (0.2, 0.2, 1.0) * 2 + (
        10.0,
        10.0,
        100.0,
    ) * 2  # of the coordinates and their rates, to which errors are compared
    names = (
        "coupler_x", "coupler_y", "coupler_angle", "follower_x", "follower_y", "follower_angle",
        "coupler_u", "coupler_v", "coupler_w", "follower_u", "follower_v", "follower_w",
        "force_B", "force_C", "force_D", "depth_B", "depth_C", "depth_D", "follower_acceleration",
    )  # fmt: skip
    largest = ("force_B", "force_C", "force_D", "follower_acceleration")

    def __init__(self, number: type = float, cos: Any = math.cos, sin: Any = math.sin, sqrt: Any = math.sqrt):
        self.number, self.cos, self.sin, self.sqrt = number, cos, sin, sqrt
        # Every length, mass and speed is the double next to its decimal text, in both integrations.
        self.w = number(self.speed)
        self.inertias = [
            number(m) * number(one) ** 2 / 12 for m, one in zip(self.masses, (0.26, 0.46), strict=True)
        ]

    def start_angles(self) -> tuple[Any, Any, Any, Any]:
        """Angles and speeds of coupler and follower of the ideal mechanism, crank at zero, C above."""
        n = self.number
        bx, d = n(self.crank), n(self.crank) - n(self.ground)
        a = (n(self.follower) ** 2 - n(self.coupler) ** 2 + d * d) / (2 * d)
        h = self.sqrt(n(self.follower) ** 2 - a * a)
        cx, cy = n(self.ground) + a, h
        bc, dc = (cx - bx, cy), (cx - n(self.ground), cy)
        # w2 x bc - w3 x dc = -v_B with v_B = (0, w r)
        vy = self.w * bx
        det = -bc[1] * -dc[0] - dc[1] * bc[0]
        w2, w3 = (dc[1] * vy) / det, (bc[1] * vy) / det
        return self.atan2(bc[1], bc[0]), self.atan2(dc[1], dc[0]), w2, w3

    def atan2(self, y: Any, x: Any) -> Any:
        """Compute the angle (rad) by Newton's method, to all digits of the number."""
        angle = self.number(math.atan2(float(y), float(x)))
        for _ in range(3):
            c, s = self.cos(angle), self.sin(angle)
            angle += (y * c - x * s) / (x * c + y * s)
        return angle


class FourBarAtCentres(FourBar):
    """State: x, y, angle of coupler and follower at their centres, then the rates of these."""

    def start(self) -> list[Any]:
        """Journals in the middle of their bearings, with the speeds of the ideal mechanism."""
        a2, a3, w2, w3 = self.start_angles()
        n = self.number
        r2 = n(self.coupler) / 2 * self.cos(a2), n(self.coupler) / 2 * self.sin(a2)
        r3 = n(self.follower) / 2 * self.cos(a3), n(self.follower) / 2 * self.sin(a3)
        l1 = n(self.crank)
        return [
            l1 + r2[0], r2[1], a2, n(self.ground) + r3[0], r3[1], a3,
            -w2 * r2[1], self.w * l1 + w2 * r2[0], w2, -w3 * r3[1], w3 * r3[0], w3,
        ]  # fmt: skip

    def pins(self, t: Any, y: Any) -> list[tuple[Any, ...]]:
        """For B, C, D: place, velocity and angular speed of the bearing, then of the journal."""
        n = self.number
        c, s = self.cos(self.w * t), self.sin(self.w * t)
        bx, by = n(self.crank) * c, n(self.crank) * s
        x2, y2, a2, x3, y3, a3, u2, v2, w2, u3, v3, w3 = y
        c2, s2 = n(self.coupler) / 2 * self.cos(a2), n(self.coupler) / 2 * self.sin(a2)
        c3, s3 = n(self.follower) / 2 * self.cos(a3), n(self.follower) / 2 * self.sin(a3)
        zero = n(0)
        return [
            (bx, by, -self.w * by, self.w * bx, self.w, x2 - c2, y2 - s2, u2 + s2 * w2, v2 - c2 * w2, w2),
            (
                x2 + c2,
                y2 + s2,
                u2 - s2 * w2,
                v2 + c2 * w2,
                w2,
                x3 + c3,
                y3 + s3,
                u3 - s3 * w3,
                v3 + c3 * w3,
                w3,
            ),
            (n(self.ground), zero, zero, zero, zero, x3 - c3, y3 - s3, u3 + s3 * w3, v3 - c3 * w3, w3),
        ]

    def contact(self, pin: tuple[Any, ...]) -> tuple[Any, ...]:
        """Depth, its rate, sliding speed, normal, arms of journal and bearing."""
        bx, by, bu, bv, bw, jx, jy, ju, jv, jw = pin
        ex, ey = jx - bx, jy - by
        e = self.sqrt(ex * ex + ey * ey)
        if e == 0.0:
            return -self.number(self.clearance), e, e, e, e, e, e
        nx, ny = ex / e, ey / e
        depth, u, v = e - self.number(self.clearance), ju - bu, jv - bv
        journal = self.number(self.bearing) - self.number(self.clearance) - depth / 2
        bearing = self.number(self.bearing) + depth / 2
        return depth, u * nx + v * ny, v * nx - u * ny + jw * journal - bw * bearing, nx, ny, journal, bearing

    def gaps(self, t: Any, y: Any) -> list[tuple[Any, Any, Any]]:
        """Penetration, its rate and sliding speed of B, C and D."""
        return [self.contact(pin)[:3] for pin in self.pins(t, y)]

    def forces(self, t: Any, y: Any, modes: list[Mode]) -> list[tuple[Any, ...]]:
        """Force on the journal and moments on journal's and bearing's body of B, C and D."""
        result = []
        for pin, (touches, approach, band) in zip(self.pins(t, y), modes, strict=True):
            depth, rate, slide, nx, ny, journal, bearing = self.contact(pin)
            if not touches:
                result.append((0.0 * depth,) * 5)
                continue
            normal = normal_force(depth, rate, approach, self.sqrt)
            tangent = -self.number(self.friction) * friction_share(slide, band) * normal
            fx, fy = -normal * nx - tangent * ny, -normal * ny + tangent * nx
            result.append((fx, fy, journal * tangent, -bearing * tangent, depth))
        return result

    def rates(self, t: Any, y: Any, modes: list[Mode]) -> list[Any]:
        """Newton and Euler of two free bodies."""
        n = self.number
        (bx, by, bm, _, _), (cx, cy, cm, cb, _), (dx, dy, dm, _, _) = self.forces(t, y, modes)
        a2, a3 = y[2], y[5]
        c2, s2 = n(self.coupler) / 2 * self.cos(a2), n(self.coupler) / 2 * self.sin(a2)
        c3, s3 = n(self.follower) / 2 * self.cos(a3), n(self.follower) / 2 * self.sin(a3)
        m2, m3 = (n(one) for one in self.masses)
        i2, i3 = self.inertias
        return [
            *y[6:],
            (bx - cx) / m2,
            (by - cy) / m2,
            (-c2 * by + s2 * bx + bm - c2 * cy + s2 * cx + cb) / i2,
            (cx + dx) / m3,
            (cy + dy) / m3,
            (c3 * cy - s3 * cx + cm - c3 * dy + s3 * dx + dm) / i3,
        ]

    def outputs(self, t: Any, y: Any, modes: list[Mode]) -> list[Any]:
        """Return a row of the table."""
        forces = self.forces(t, y, modes)
        sizes = [self.sqrt(fx * fx + fy * fy) for fx, fy, *_ in forces]
        return [*y, *sizes, *(gap[0] for gap in self.gaps(t, y)), self.rates(t, y, modes)[11]]


class FourBarAtPins(FourBar):
    """State: the pins at both ends of coupler and follower, as lengths along and across turning axes.

    Coordinates of a rod are the place of its first pin and its angle; Lagrange's equations then have a full
    mass matrix, which is solved here. The force of a contact acts at the pin, its moment on the rod.
    """

    def start(self) -> list[Any]:
        """As the centres have it: journals in the middle of their bearings."""
        a2, a3, w2, w3 = self.start_angles()
        n = self.number
        zero = n(0)
        return [
            n(self.crank), zero, a2, n(self.ground), zero, a3,
            zero, self.w * n(self.crank), w2, zero, zero, w3,
        ]  # fmt: skip

    def hits(self, t: Any, y: Any) -> list[dict[str, Any]]:
        """Return the geometry of the three contacts, with unit vectors along the line of centres."""
        n = self.number
        p, q = (y[0], y[1]), (y[3], y[4])
        along2, along3 = (self.cos(y[2]), self.sin(y[2])), (self.cos(y[5]), self.sin(y[5]))
        v, z = (y[6], y[7]), (y[9], y[10])
        l2, l3, w2, w3 = n(self.coupler), n(self.follower), y[8], y[11]
        end2 = p[0] + l2 * along2[0], p[1] + l2 * along2[1]
        end3 = q[0] + l3 * along3[0], q[1] + l3 * along3[1]
        speed2 = v[0] - l2 * w2 * along2[1], v[1] + l2 * w2 * along2[0]
        speed3 = z[0] - l3 * w3 * along3[1], z[1] + l3 * w3 * along3[0]
        turn = self.cos(self.w * t), self.sin(self.w * t)
        b = n(self.crank) * turn[0], n(self.crank) * turn[1]
        vb = -self.w * b[1], self.w * b[0]
        zero = n(0)
        triples = [
            (b, vb, self.w, p, v, w2),
            (end2, speed2, w2, end3, speed3, w3),
            ((n(self.ground), zero), (zero, zero), zero, q, z, w3),
        ]
        result = []
        for bearing, bearing_speed, bearing_turn, journal, journal_speed, journal_turn in triples:
            ex, ey = journal[0] - bearing[0], journal[1] - bearing[1]
            e = self.sqrt(ex**2 + ey**2)
            nx, ny = (ex / e, ey / e) if e > 0.0 else (zero, zero)
            du, dv = journal_speed[0] - bearing_speed[0], journal_speed[1] - bearing_speed[1]
            d = e - n(self.clearance)
            r_j, r_b = n(self.bearing) - n(self.clearance) - d / 2, n(self.bearing) + d / 2
            result.append({
                "n": (nx, ny), "depth": d, "rate": du * nx + dv * ny, "arms": (r_j, r_b),
                "slide": nx * dv - ny * du + r_j * journal_turn - r_b * bearing_turn,
            })  # fmt: skip
        return result

    def gaps(self, t: Any, y: Any) -> list[tuple[Any, Any, Any]]:
        """Penetration, its rate and sliding speed of B, C and D."""
        return [(hit["depth"], hit["rate"], hit["slide"]) for hit in self.hits(t, y)]

    def loads(self, t: Any, y: Any, modes: list[Mode]) -> list[tuple[Any, ...]]:
        """Force on the journal, moments on journal's and bearing's body."""
        result = []
        for hit, (touches, approach, band) in zip(self.hits(t, y), modes, strict=True):
            normal = (
                normal_force(hit["depth"], hit["rate"], approach, self.sqrt)
                if touches
                else 0.0 * hit["depth"]
            )
            drag = self.number(self.friction) * friction_share(hit["slide"], band) * normal
            (nx, ny), (r_j, r_b) = hit["n"], hit["arms"]
            result.append((drag * ny - normal * nx, -drag * nx - normal * ny, -r_j * drag, r_b * drag))
        return result

    def rod(
        self,
        mass: Any,
        length: Any,
        angle: Any,
        speed: Any,
        first: tuple[Any, Any],
        last: tuple[Any, Any],
        moment: Any,
    ) -> tuple[Any, Any, Any]:
        """Accelerations of the first pin and of the angle of a uniform rod with forces at both pins."""
        c, s, h = self.cos(angle), self.sin(angle), length / 2
        # m (a + alpha h n - w^2 h e) = F + G ; about the first pin: m h n.a + m l^2/3 alpha = l n.G + M
        sx, sy = first[0] + last[0] + mass * h * speed**2 * c, first[1] + last[1] + mass * h * speed**2 * s
        across = -s * last[0] + c * last[1]
        pushed = -s * sx + c * sy
        alpha = (length * across + moment - h * pushed) / (mass * length**2 / 3 - mass * h**2)
        return sx / mass + alpha * h * s, sy / mass - alpha * h * c, alpha

    def rates(self, t: Any, y: Any, modes: list[Mode]) -> list[Any]:
        """Lagrange's equations of two rods."""
        n = self.number
        (bx, by, bj, _), (cx, cy, cj, cb), (dx, dy, dj, _) = self.loads(t, y, modes)
        coupler = self.rod(n(self.masses[0]), n(self.coupler), y[2], y[8], (bx, by), (-cx, -cy), bj + cb)
        follower = self.rod(n(self.masses[1]), n(self.follower), y[5], y[11], (dx, dy), (cx, cy), dj + cj)
        return [*y[6:], *coupler, *follower]

    def outputs(self, t: Any, y: Any, modes: list[Mode]) -> list[Any]:
        """Return a row of the table, at the centres of mass."""
        n = self.number
        rates, places = self.rates(t, y, modes), []
        for k, length in ((0, n(self.coupler)), (3, n(self.follower))):
            c, s, h = self.cos(y[k + 2]), self.sin(y[k + 2]), length / 2
            w = y[k + 8]
            places.append(
                (y[k] + h * c, y[k + 1] + h * s, y[k + 2], y[k + 6] - h * w * s, y[k + 7] + h * w * c, w)
            )
        forces = [self.sqrt(fx**2 + fy**2) for fx, fy, *_ in self.loads(t, y, modes)]
        depths = [gap[0] for gap in self.gaps(t, y)]
        return [*places[0][:3], *places[1][:3], *places[0][3:], *places[1][3:], *forces, *depths, rates[11]]


class SliderCrank:
    """Problem 2. Numbers in SI units; no gravity, no friction; the block moves along the line y = 0."""

    crank, rod = 0.05, 0.12
    masses, inertia = (0.21, 0.14), 2.5e-4
    clearance = 5e-4
    speed = 500.0 * math.pi / 3.0  # 5000 rpm
    duration, window = 0.024, 0.012
    contacts = 1
    names = (
        "rod_angle", "block_x", "rod_w", "block_u",
        "force", "depth", "rod_acceleration", "block_acceleration",
    )  # fmt: skip
    largest = ("force", "rod_acceleration", "block_acceleration")

    def __init__(self, number: type = float, cos: Any = math.cos, sin: Any = math.sin, sqrt: Any = math.sqrt):
        self.number, self.cos, self.sin, self.sqrt = number, cos, sin, sqrt
        self.w = number(self.speed)

    def start(self) -> list[Any]:
        """Crank at zero, rod along the line of the block, journal in the middle; ideal speeds."""
        n = self.number
        return [n(0), n(self.crank) + n(self.rod), -n(self.crank) * self.w / n(self.rod), n(0)]


class SliderCrankAtCentres(SliderCrank):
    """State: angle of the rod, place of the block, rates. Euler's equation about the crank pin."""

    def relative(self, t: Any, y: Any) -> tuple[Any, ...]:
        """Depth, its rate and normal of the contact of the block's journal in the rod's bearing."""
        n = self.number
        l1, l2 = n(self.crank), n(self.rod)
        c, s, ca, sa = self.cos(self.w * t), self.sin(self.w * t), self.cos(y[0]), self.sin(y[0])
        ex, ey = y[1] - l1 * c - l2 * ca, -l1 * s - l2 * sa
        u, v = y[3] + l1 * self.w * s + l2 * y[2] * sa, -l1 * self.w * c - l2 * y[2] * ca
        e = self.sqrt(ex * ex + ey * ey)
        if e == 0.0:
            return -n(self.clearance), e, e, e
        return e - n(self.clearance), (u * ex + v * ey) / e, ex / e, ey / e

    def gaps(self, t: Any, y: Any) -> list[tuple[Any, Any, Any]]:
        """Penetration and its rate; nothing slides with friction."""
        depth, rate, *_ = self.relative(t, y)
        return [(depth, rate, 0.0 * depth)]

    def force(self, t: Any, y: Any, modes: list[Mode]) -> tuple[Any, Any, Any]:
        """Return the normal force and its direction, from the bearing to the journal."""
        depth, rate, nx, ny = self.relative(t, y)
        ((touches, approach, _),) = modes
        return (normal_force(depth, rate, approach, self.sqrt) if touches else 0.0 * depth), nx, ny

    def rates(self, t: Any, y: Any, modes: list[Mode]) -> list[Any]:
        """Return the rates of the rod about the moving crank pin, and of the block along its line."""
        n = self.number
        size, nx, ny = self.force(t, y, modes)
        l1, l2, (m2, m3) = n(self.crank), n(self.rod), (n(one) for one in self.masses)
        c, s, ca, sa = self.cos(self.w * t), self.sin(self.w * t), self.cos(y[0]), self.sin(y[0])
        ax, ay = -l1 * self.w**2 * c, -l1 * self.w**2 * s
        moment = l2 * (ca * size * ny - sa * size * nx) - m2 * l2 / 2 * (ca * ay - sa * ax)
        return [y[2], y[3], moment / (n(self.inertia) + m2 * l2**2 / 4), -size * nx / m3]

    def outputs(self, t: Any, y: Any, modes: list[Mode]) -> list[Any]:
        """Return a row of the table."""
        return [*y, self.force(t, y, modes)[0], self.gaps(t, y)[0][0], *self.rates(t, y, modes)[2:]]


class SliderCrankInComplexNumbers(SliderCrank):
    """State: components of the rod's direction times its length, place of the block, rates of these.

    The rod is two masses at its ends and one in its middle that together have its mass, its centre and its
    inertia; the direction obeys p' = i w p, and the length of p is an invariant that the integration keeps.
    """

    sizes = (0.1, 0.1, 0.1, 100.0, 10.0, 0.1)  # of the state, to which errors are compared

    def start(self) -> list[Any]:
        """Return the start of the other formulation in these coordinates."""
        n = self.number
        angle, x, w, u = super().start()
        return [n(self.rod), 0.0 * x, x, w, u, angle]

    def parts(self, t: Any, y: Any) -> tuple[Any, ...]:
        """Line of centres, its rate, depth and the rate of that."""
        n = self.number
        phase = self.w * t
        crank = n(self.crank) * self.cos(phase), n(self.crank) * self.sin(phase)
        line = y[2] - (crank[0] + y[0]), -(crank[1] + y[1])
        rate = y[4] - (-self.w * crank[1] - y[3] * y[1]), -(self.w * crank[0] + y[3] * y[0])
        e = self.sqrt(line[0] ** 2 + line[1] ** 2)
        closing = (line[0] * rate[0] + line[1] * rate[1]) / e if e > 0.0 else 0.0 * e
        return crank, line, e, e - n(self.clearance), closing

    def gaps(self, t: Any, y: Any) -> list[tuple[Any, Any, Any]]:
        """Penetration and its rate."""
        *_, depth, rate = self.parts(t, y)
        return [(depth, rate, 0.0 * depth)]

    def pull(self, t: Any, y: Any, modes: list[Mode]) -> tuple[Any, Any, Any]:
        """Components of the force on the rod, and its size."""
        _, line, e, depth, rate = self.parts(t, y)
        ((touches, approach, _),) = modes
        if not touches:
            return 0.0 * e, 0.0 * e, 0.0 * e
        size = normal_force(depth, rate, approach, self.sqrt)
        return size * line[0] / e, size * line[1] / e, size

    def rates(self, t: Any, y: Any, modes: list[Mode]) -> list[Any]:
        """Virtual power of the masses at crank pin, middle and end of the rod."""
        n = self.number
        m2, m3 = (n(one) for one in self.masses)
        end = 2 * n(self.inertia) / n(self.rod) ** 2  # at each end; the rest in the middle
        middle = m2 - 2 * end
        fx, fy, _ = self.pull(t, y, modes)
        crank = self.parts(t, y)[0]
        ax, ay = -(self.w**2) * crank[0], -(self.w**2) * crank[1]
        px, py = y[0], y[1]
        # the power of inertia in a virtual turn of the rod: at the end p, in the middle p/2
        inertia = (end + middle / 4) * n(self.rod) ** 2
        power = (px * (fy - (end + middle / 2) * ay)) - (py * (fx - (end + middle / 2) * ax))
        return [-y[3] * py, y[3] * px, y[4], power / inertia, -fx / m3, y[3]]

    def outputs(self, t: Any, y: Any, modes: list[Mode]) -> list[Any]:
        """Return a row of the table."""
        rates = self.rates(t, y, modes)
        return [y[5], y[2], y[3], y[4], self.pull(t, y, modes)[2], self.gaps(t, y)[0][0], rates[3], rates[4]]
