"""Andrews' squeezer: seven bodies, a spring and a motor of constant torque; a test problem for integrators of stiff and constrained systems."""

from __future__ import annotations

from typing import Any

from ..model.drivers import Torque
from ..model.mechanism import Mechanism, Settings

# Name: mass (kg), inertia (kg m^2), angle at the start (rad), centre of mass and pins (m) in the frame of the body.
BODIES: dict[str, tuple[float, float, float, tuple[float, float], dict[str, tuple[float, float]]]] = {
    "K1": (0.04325, 2.194e-6, -0.0617138900142764, (0.00092, 0.0), {"O": (0.0, 0.0), "P": (0.007, 0.0)}),
    "K2": (0.00365, 4.410e-7, -0.0617138900142764, (-0.0115, 0.0), {"P": (0.0, 0.0), "E": (-0.028, 0.0)}),
    "K3": (0.02373, 5.255e-6, 0.4552798191630704, (0.01043, -0.01874), {"B": (0.0, 0.0), "E": (0.0, -0.035), "D": (0.02, -0.018)}),
    "K4": (0.00706, 5.667e-7, 0.7100333697294284, (0.0, -0.00579), {"H": (0.0, 0.0), "E": (0.0, -0.02)}),
    "K5": (0.07050, 1.169e-5, 0.4873649795438426, (0.02308, 0.00916), {"A": (0.0, 0.0), "H": (0.04, 0.0)}),
    "K6": (0.00706, 5.667e-7, 1.0078790543839353, (0.00579, 0.0), {"G": (0.0, 0.0), "E": (0.02, 0.0)}),
    "K7": (0.05498, 1.912e-5, 1.2305474445498212, (-0.00449, -0.01228), {"A": (0.0, 0.0), "G": (0.0, -0.04)}),
}
ORIGINS = {
    "K1": (0.0, 0.0), "K2": (0.006986674, -0.000431723), "K3": (-0.03635, 0.03273), "K4": (-0.033997204, 0.016461972), "K5": (-0.06934, -0.00227),
    "K6": (-0.031633135, -0.015618869), "K7": (-0.06934, -0.00227),
}  # fmt: skip


def squeezer(*, torque: float = 0.033, stiffness: float = 4530.0, duration: float = 0.03, **settings: Any) -> Mechanism:
    """Seven bodies closed in three loops at E; the motor (N m) turns K1, a spring (N/m) between the ground's C and K3 pulls back.

    Source: W. Schiehlen (ed.), Multibody Systems Handbook, Springer 1990; E. Hairer, G. Wanner, Solving Ordinary Differential Equations II,
    section VII.7, with these numbers.
    """
    m = Mechanism("Andrews' squeezer", settings=Settings(duration=duration, **({"step": 1e-6, "outputs": 600} | settings)))
    for name, x, y in (("O", 0.0, 0.0), ("A", -0.06934, -0.00227), ("B", -0.03635, 0.03273), ("C", 0.014, 0.072)):
        m.point(name, x, y)
    for name, (mass, inertia, angle, center, pins) in BODIES.items():
        m.rigid_body(name, mass=mass, inertia=inertia, angle=angle, position=ORIGINS[name], center=center, pins=pins)
    for name, bearing, journal in (
        ("O", "ground.O", "K1.O"), ("P", "K1.P", "K2.P"), ("B", "ground.B", "K3.B"), ("A5", "ground.A", "K5.A"), ("A7", "ground.A", "K7.A"),
        ("H", "K5.H", "K4.H"), ("G", "K7.G", "K6.G"), ("E2", "K3.E", "K2.E"), ("E4", "K3.E", "K4.E"), ("E6", "K3.E", "K6.E"),
    ):  # fmt: skip
        m.revolute(name, bearing, journal)
    m.spring("spring", "ground.C", "K3.D", stiffness=stiffness, free_length=0.07785)
    m.drivers["motor"] = Torque(body="K1", value=torque)
    return m
