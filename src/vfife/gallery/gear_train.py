"""A motor starts a flywheel through two stages of gears."""

from __future__ import annotations

from ..model.drivers import Torque
from ..model.mechanism import Mechanism, Settings


def gear_train(
    *,
    stall_torque: float = 2.0,
    idle_speed: float = 300.0,
    ratios: tuple[float, float] = (-0.4, -0.5),
    inertias: tuple[float, float, float] = (1e-3, 4e-3, 0.05),
    duration: float = 0.6,
) -> Mechanism:
    """Motor, middle shaft and flywheel (kg m^2), coupled by gears; the motor's torque (N m) falls in a straight line to 0 at idle speed (rad/s).

    w = idle_speed (1 - exp(-t/T)) with T = idle_speed/stall_torque (J_1 + r_1^2 J_2 + r_1^2 r_2^2 J_3).
    """
    m = Mechanism("gear train", settings=Settings(duration=duration, outputs=300, step=1e-4))
    for name, inertia, x in zip(("motor", "middle", "flywheel"), inertias, (0.0, 0.14, 0.32), strict=True):
        m.point(name, x, 0.0)
        m.rigid_body(name, mass=1.0, inertia=inertia, position=(x, 0.0))
        m.revolute(name, f"ground.{name}", f"{name}.center")
    m.gear("first-stage", "motor", "middle", ratio=ratios[0])
    m.gear("second-stage", "middle", "flywheel", ratio=ratios[1])
    m.drivers["curve"] = Torque(body="motor", value=(stall_torque, 0.0), speeds=(0.0, idle_speed))
    return m
