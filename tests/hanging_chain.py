"""Three bodies that hang on three joints with clearance and come to rest by many bounces, and 20 variants."""

from __future__ import annotations

from vfife.model.mechanism import Mechanism
from vfife.modelfile import loads

CHAIN = """
name = "three hanging bodies, three loose joints"
gravity = [0, "-9.81 m/s^2"]
[run]
duration = "0.4 s"
outputs = 800
[ground]
O = [0, 0]
[body.a]
length = "200 mm"
mass = "0.5 kg"
angle = "-60 deg"
[body.b]
length = "150 mm"
mass = "0.4 kg"
angle = "-80 deg"
[body.c]
length = "150 mm"
mass = "0.3 kg"
angle = "-50 deg"
[joint.O]
kind = "clearance"
bearing = "ground.O"
journal = "a.start"
clearance = "0.1 mm"
bearing_radius = "10 mm"
contact = { law = "lankarani-nikravesh", restitution = 0.7 }
friction = { law = "ambrosio", coefficient = 0.1, v0 = "1e-4 m/s", v1 = "1e-2 m/s" }
[joint.P]
kind = "clearance"
bearing = "a.end"
journal = "b.start"
clearance = "0.1 mm"
bearing_radius = "10 mm"
contact = { law = "lankarani-nikravesh", restitution = 0.7 }
friction = { law = "ambrosio", coefficient = 0.1, v0 = "1e-4 m/s", v1 = "1e-2 m/s" }
[joint.Q]
kind = "clearance"
bearing = "b.end"
journal = "c.start"
clearance = "0.1 mm"
bearing_radius = "10 mm"
contact = { law = "lankarani-nikravesh", restitution = 0.7 }
friction = { law = "ambrosio", coefficient = 0.1, v0 = "1e-4 m/s", v1 = "1e-2 m/s" }
"""


def variant(k: int) -> Mechanism:
    """Return variant ``k`` (0 to 19): other angles, clearances, friction and duration."""
    return loads(
        CHAIN,
        (
            ("body.a.angle", f"{-75 + (7 * k) % 40} deg"),
            ("body.b.angle", f"{-80 + (11 * k) % 30} deg"),
            ("body.c.angle", f"{-50 - (5 * k) % 35} deg"),
            ("joint.O.clearance", f"{0.05 + 0.01 * (k % 6)} mm"),
            ("joint.Q.clearance", f"{0.05 + 0.01 * (k % 9)} mm"),
            ("joint.P.friction.coefficient", 0.05 + 0.02 * (k % 5)),
            ("run.duration", f"{0.2 + 0.05 * (k % 3)} s"),
        ),
    )
