"""Andrews' squeezing mechanism: seven bodies, three of them in one joint, a spring, a constant torque."""

from __future__ import annotations

import math

from vfife.model.drivers import Torque
from vfife.model.mechanism import Mechanism

from .case import Nudge, Row, Rows, verified
from .case_motion import run

SOURCE = (
    "Mazzia, Magherini: Test Set for Initial Value Problem Solvers, release 2.4 (2008), problem Andrews,"
    " reference solution at 0.03 s; Schiehlen (ed.): Multibody Systems Handbook, Springer (1990); IFToMM"
    " benchmark A03"
)
BETA, GAMMA, PHI, DELTA, OMEGA, EPSILON = (
    -0.0617138900142764496, 0.455279819163070380, 0.222668390165885885, 0.487364979543842550,
    -0.222668390165885885, 1.23054744454982120,
)  # fmt: skip
# angles of beta, theta, gamma, phi, delta, omega, epsilon at 0.03 s
REFERENCE = {
    "beta": 15.81077119629904, "theta": -15.75637105984298, "gamma": 0.04082224013073101,
    "phi": -0.5347301163226948,
    "delta": 0.5244099658805304, "omega": 0.5347301163226948, "epsilon": 1.048080741042263,
}  # fmt: skip


Point = tuple[float, float]
BodyData = tuple[float, float, Point, dict[str, Point], float, Point]


def squeezer_bodies(a: Point, b: Point) -> dict[str, BodyData]:
    """Mass (kg), inertia (kg m²), centre, pins, angle (rad) and place of the origin (m) of each body; ``a``
    and ``b`` are the fixed points A and B.
    """
    quarter, x, y = 0.5 * math.pi, 7e-3 * math.cos(BETA), 7e-3 * math.sin(BETA)
    elbow = (a[0] + 0.04 * math.cos(DELTA), a[1] + 0.04 * math.sin(DELTA))
    second_elbow = (a[0] + 0.04 * math.sin(EPSILON), a[1] - 0.04 * math.cos(EPSILON))
    return {
        "k1": (0.04325, 2.194e-6, (0.92e-3, 0.0), {"o": (0.0, 0.0), "e": (7e-3, 0.0)}, BETA, (0.0, 0.0)),
        "k2": (
            0.00365,
            4.410e-7,
            (0.0115, 0.0),
            {"o": (0.0, 0.0), "p": (0.028, 0.0)},
            BETA + math.pi,
            (x, y),
        ),
        "k3": (
            0.02373,
            5.255e-6,
            (0.01874, 0.01043),
            {"o": (0.0, 0.0), "p": (0.035, 0.0), "d": (0.018, 0.02)},
            GAMMA - quarter,
            b,
        ),
        "k4": (
            0.00706,
            5.667e-7,
            (0.00579, 0.0),
            {"o": (0.0, 0.0), "p": (0.02, 0.0)},
            PHI + DELTA - quarter,
            elbow,
        ),
        "k5": (0.07050, 1.169e-5, (0.02308, 0.00916), {"o": (0.0, 0.0), "e": (0.04, 0.0)}, DELTA, a),
        "k6": (
            0.00706,
            5.667e-7,
            (0.00579, 0.0),
            {"o": (0.0, 0.0), "p": (0.02, 0.0)},
            OMEGA + EPSILON,
            second_elbow,
        ),
        "k7": (
            0.05498,
            1.912e-5,
            (0.01228, 0.00449),
            {"o": (0.0, 0.0), "e": (0.04, 0.0)},
            EPSILON - quarter,
            a,
        ),
    }


def squeezer(spring: float = 4530.0) -> Mechanism:
    """Bodies k1 to k7 of the test set; all meet in P, where k2, k3, k4 and k6 are pinned together."""
    m = Mechanism("Andrews' squeezer")
    for name, at in (
        ("O", (0.0, 0.0)),
        ("A", (-0.06934, -0.00227)),
        ("B", (-0.03635, 0.03273)),
        ("C", (0.014, 0.072)),
    ):
        m.point(name, *at)
    for name, (mass, inertia, center, points, angle, position) in squeezer_bodies(
        m.points["A"], m.points["B"]
    ).items():
        m.rigid_body(
            name, mass=mass, inertia=inertia, center=center, pins=points, angle=angle, position=position
        )
    pins = [
        ("ground.O", "k1.o"),
        ("k1.e", "k2.o"),
        ("ground.B", "k3.o"),
        ("ground.A", "k5.o"),
        ("ground.A", "k7.o"),
    ]
    pins += [("k5.e", "k4.o"), ("k7.e", "k6.o"), ("k2.p", "k3.p"), ("k2.p", "k4.p"), ("k2.p", "k6.p")]
    for k, (bearing, journal) in enumerate(pins, start=1):
        m.revolute(f"J{k}", bearing, journal)
    m.spring("spring", "ground.C", "k3.d", stiffness=spring, free_length=0.07785)
    m.drivers["k1"] = Torque(body="k1", value=0.033)
    return m


@verified("Andrews' squeezing mechanism", SOURCE, nudges={"spring": 1.01})
def andrews_squeezer(nudge: Nudge) -> Rows:
    """Compare the seven angles of the test set at 0.03 s."""
    motion = run(squeezer(4530.0 * nudge("spring")), step=1e-6, duration=0.03, outputs=300)
    end = {name: float(motion.body(name)[-1]) for name in ("k1", "k2", "k3", "k4", "k5", "k6", "k7")}
    quarter = 0.5 * math.pi
    beta, delta, epsilon = end["k1"], end["k5"], end["k7"] + quarter
    angles = {
        "beta": beta, "theta": end["k2"] - math.pi - beta, "gamma": end["k3"] + quarter,
        "phi": end["k4"] + quarter - delta,
        "delta": delta, "omega": end["k6"] - epsilon, "epsilon": epsilon,
    }  # fmt: skip
    for name, reference in REFERENCE.items():
        yield Row(f"{name} at 0.03 s", "rad", reference, angles[name], 1e-5)
