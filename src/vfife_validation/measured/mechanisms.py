"""Models of the measured pendulums; lengths, masses and gravity are those of the authors."""

from __future__ import annotations

import math

from vfife import Mechanism, Settings

G = 9.810
MASS, ARM, INERTIA, DAMPING = 0.14758, 0.14775, 1.091e-4, 2.239e-4  # kg, m, kg m2, N m s: the authors'
UPPER_MASS, LOWER_MASS, LENGTH = 0.09384, 0.13760, 0.17272  # kg, kg, m
UPPER_ARM, LOWER_ARM = 0.10857, 0.11678  # m
UPPER_INERTIA, LOWER_INERTIA = 4.375e-4, 1.2689e-3  # kg m2
UPPER_DAMPING, LOWER_DAMPING = 2.371e-4, 1.0e-5  # N m s
REST_SPEED = 0.02  # rad/s, below which dry friction grows with the speed
MIDDLE, FAST = 7.0, 14.0  # rad/s, at which the friction of a curve is looked for
HALF = 0.5  # of the speed of the middle
DRY = "driver.rod.torque.0,-driver.rod.torque.1"
CURVE = tuple(f"driver.rod.torque.{k},-driver.rod.torque.{5 - k}" for k in (2, 1, 0))


def single(friction: str = "viscous and dry") -> Mechanism:
    """Build the single pendulum with the authors' parameters and viscous and dry friction, or friction over
    speed as a curve through three points (``"curve"``), which starts without dry friction.
    """
    m = Mechanism("single pendulum", gravity=(0.0, -G))
    m.settings = Settings(duration=9.2)
    m.point("O", 0.0, 0.0)
    m.rigid_body(
        "rod", mass=MASS, inertia=INERTIA, center=(0.0, ARM), pins={"pivot": (0.0, 0.0)}, angle=math.pi
    )
    m.revolute("O", "ground.O", "rod.pivot")
    if friction == "curve":
        values = (FAST * DAMPING, MIDDLE * DAMPING, REST_SPEED * DAMPING)
        speeds = (-FAST, -MIDDLE, -REST_SPEED, REST_SPEED, MIDDLE, FAST)
        m.torque("rod", value=(*values, *(-value for value in reversed(values))), speeds=speeds)
    else:
        m.torsional_spring("bearing", "ground", "rod", damping=DAMPING)
        m.torque("rod", value=(0.0, 0.0), speeds=(-REST_SPEED, REST_SPEED), interpolation="linear")
    return m


def double(elbow: float = LOWER_DAMPING) -> Mechanism:
    """Build the double pendulum with the authors' parameters and zero dry friction in both joints; ``elbow``
    is the viscous friction (N m s) between the bodies.
    """
    m = Mechanism("double pendulum", gravity=(0.0, -G))
    m.settings = Settings(duration=2.7)
    m.point("O", 0.0, 0.0)
    pins = {"pivot": (0.0, 0.0), "elbow": (0.0, LENGTH)}
    m.rigid_body(
        "upper", mass=UPPER_MASS, inertia=UPPER_INERTIA, center=(0.0, UPPER_ARM), pins=pins, angle=math.pi
    )
    m.rigid_body(
        "lower", mass=LOWER_MASS, inertia=LOWER_INERTIA, center=(0.0, LOWER_ARM),
        pins={"elbow": (0.0, 0.0)}, angle=math.pi,
    )  # fmt: skip
    m.revolute("O", "ground.O", "upper.pivot")
    m.revolute("E", "upper.elbow", "lower.elbow")
    m.torsional_spring("O", "ground", "upper", damping=UPPER_DAMPING)
    if elbow:
        m.torsional_spring("E", "upper", "lower", damping=elbow)
    m.torque("upper", value=(0.0, 0.0), speeds=(-REST_SPEED, REST_SPEED), interpolation="linear")
    m.torque(
        "lower", value=(0.0, 0.0), against="upper", speeds=(-REST_SPEED, REST_SPEED), interpolation="linear"
    )
    return m
