"""
Results for a designer
======================

A small compressor has clearance in its piston pin. This example reads from one run: energy losses, load and
pressure of the pin, impacts, places of wear, shaking forces on the foundation, stresses in the rod, and the
distance of the running speed from resonances.
"""

# %%
# Gas presses on the piston on its way up, and hardly on its way down. The rod is elastic, so that it has
# stresses and natural frequencies.

import math

import numpy as np

import vfife

SPEED = 100.0  # rad/s


def compressor() -> vfife.Mechanism:
    """Return a compressor: crank 50 mm, rod 150 mm, piston 1 kg, bore 40 mm; 30 µm clearance in the pin."""
    m = vfife.Mechanism("compressor", settings=vfife.Settings(turns=4))
    m.point("O", 0, 0)
    m.link("crank", length="50 mm", mass="2 kg")
    m.link(
        "rod",
        length="150 mm",
        model="elastic",
        elements=4,
        section=vfife.bodies.Section.rectangle(0.012, 0.02),
    )
    m.rigid_body("piston", mass="1 kg", inertia=1e-3, position=(0.2, 0))
    m.revolute("O", "ground.O", "crank.start")
    m.revolute("crankpin", "crank.end", "rod.start")
    m.clearance_joint(
        "pin",
        "rod.end",
        "piston.center",
        clearance="30 um",
        bearing_radius="10 mm",
        axial_length="25 mm",
        friction=vfife.laws.Ambrosio(coefficient=0.1),
    )
    m.slider("guide", "ground.O", "piston.center")
    m.guide_force(
        "gas",
        "guide",
        pressure=("0 bar", "1 bar", "4 bar"),
        pressure_back=("0 bar", "0 bar", "4 bar"),
        bore="40 mm",
        travels=("100 mm", "160 mm", "200 mm"),
        reverse=True,
    )
    m.drive("crank", speed=SPEED)
    return m


machine = compressor()
result = vfife.simulate(machine, reference=False, companions=0)
measures = result.measures

# %%
# **Energy.** The losses of the pin, and the efficiency: the gas takes work, the rest is heat.

for name in (
    "pin.friction_power.mean",
    "pin.impact_power.mean",
    "crank.power.mean",
    "crank.torque.mean",
    "mechanism.efficiency",
):
    print(f"{name:28} {measures[name]:10.4g}")
assert 0.5 < measures["mechanism.efficiency"] < 1.0
assert math.isclose(measures["crank.power.mean"], SPEED * measures["crank.torque.mean"], rel_tol=1e-9)

# %%
# **The pin.** Sliding velocity, Hertzian line pressure with its half-width, p v, and the list of all impacts.

for name in (
    "sliding_velocity.max",
    "contact_pressure.max",
    "contact_half_width.max",
    "pressure_velocity.mean",
):
    print(f"pin.{name:28} {measures[f'pin.{name}']:10.4g}")
drawn = result.plot("orbits", "forces")
struck = result.impacts
print(f"{struck.count} impacts, {struck.alone} of them alone in their output interval; the hardest:")
for one in struck.hardest(3):
    where, energy = f"{1e3 * one.time:7.2f} ms, crank {one.crank % 360:5.1f}°", f"{1e3 * one.energy:6.3f} mJ"
    print(f"  {where}: {1e3 * one.speed:5.1f} mm/s, {energy}, {1e6 * one.depth:5.2f} µm")
assert struck.count == measures["pin.impacts"]

# %%
# **Places of wear.** Friction loss over the angle of the bearing, in the frame of the rod, and of the pin.

for side in ("bearing", "journal"):
    found = result.around(side, bins=12, last_turn=True)
    worst = int(np.argmax(found.friction[0]))
    share = found.friction[0, worst] / found.friction[0].sum()
    print(
        f"{side}: {100 * share:.0f} % of the friction within 15° of {math.degrees(found.middles[worst]):.0f}°"
    )
    assert found.friction.sum() <= result.ledger.terms["friction_loss"][-1]

# %%
# **The piston and the foundation.** Motion along the guide, and the shaking force on the ground.

stroke = measures["guide.position.high"] - measures["guide.position.low"]
print(f"stroke {1e3 * stroke:.2f} mm, acceleration up to {measures['guide.acceleration.max']:.0f} m/s², "
      f"shaking force up to {measures['ground.shaking_force.max']:.0f} N")  # fmt: skip
assert abs(stroke - 0.1) < 1e-4

# %%
# **The rod.** Signed stresses and their place, deflection, and the lowest natural frequencies of the machine
# with a fixed crank.

print(
    f"rod: tension {1e-6 * measures['rod.tension.max']:.1f} MPa, compression "
    f"{1e-6 * measures['rod.compression.max']:.1f} MPa, "
    f"largest at {1e3 * measures['rod.stress.place']:.0f} mm, deflection "
    f"{1e6 * measures['rod.deflection.max']:.1f} µm"
)
lowest = vfife.dynamics.modes(machine, 3).frequencies
print(
    "natural frequencies:",
    ", ".join(f"{one:.0f} Hz ({one / (SPEED / (2 * math.pi)):.0f} x)" for one in lowest),
)
assert lowest[0] > 10 * SPEED / (2 * math.pi)
