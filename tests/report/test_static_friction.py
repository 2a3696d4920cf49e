"""The caution on friction whose peak lies at a speed that a step passes where the sliding turns round."""

import math

import numpy as np
import pytest

import vfife
from vfife.modelfile import loads

SHAKEN = """
gravity = [0, "-9.81 m/s^2"]
[run]
duration = "1 s"
step = "0.1 ms"
outputs = 1000
companions = 0
[ground]
O = [0, 0]
[body.disc]
mass = "1 kg"
inertia = "0.01 kg m^2"
position = [0, "9.999 mm"]
[joint.floor]
kind = "contact"
bearing = "ground.O"
journal = "disc.center"
journal_radius = "10 mm"
direction = [1, 0]
contact = {{law = "kelvin-voigt", stiffness = "1e6 N/m", damping_coefficient = "1000 N s/m"}}
friction = {{law = "{law}", coefficient = 0.1, static_coefficient = 0.15, {speed}}}
[load.shake]
at = "disc.center"
force = ["1.962 N", 0]
times = {times}
factors = {factors}
"""


def shaken(law: str, speed: str) -> tuple[float, list[str]]:
    """Path (m) of a disc that 0.2 of its weight shakes at 5 Hz, and the cautions of its run."""
    times = np.linspace(0.0, 1.0, 1001)
    factors = [round(math.sin(10.0 * math.pi * time), 9) for time in times]
    text = SHAKEN.format(law=law, speed=speed, times=times.round(6).tolist(), factors=factors)
    result = vfife.simulate(loads(text), reference=False)
    place = result.record.block("particle_x")[:, result.record.assembly.bodies["disc"].particles[0]]
    return float(np.abs(np.diff(place[len(place) // 2 :])).sum()), result.summary["warnings"]


@pytest.mark.parametrize(("law", "name"), [("brown-mcphee", "transition_speed"), ("bengisu-akay", "v0")])
def test_a_step_that_passes_the_peak_has_a_caution(law: str, name: str) -> None:
    """Static friction changes the speed by 0.15 g 0.1 ms = 0.147 mm/s a step. A peak at 1 um/s is passed, and
    the disc slides 10 % further than with karnopp; one at 17 um/s holds it.
    """
    decay = ', decay = "{} s/m"' * (law == "bengisu-akay")
    held, none = shaken("karnopp", 'band = "1e-6 m/s"')
    lost, warnings = shaken(law, f'{name} = "1e-6 m/s"' + decay.format(1e6))
    kept, rest = shaken(law, f'{name} = "1.7e-5 m/s"' + decay.format(6e4))
    words = f"Joint floor: the speed at which {law} has static friction is passed within a step"
    assert lost > 1.08 * held and any(text.startswith(words) for text in warnings)
    assert kept == pytest.approx(held, rel=0.03)
    assert not any("static friction" in text for text in [*none, *rest])
