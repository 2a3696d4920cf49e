"""
Four-bar with a loose pin
=========================

A crank drives a coupler and a follower. The pin between these two has a clearance of 0.2 mm. How much do the
force in the pin and the acceleration of the follower exceed those of the ideal mechanism?
"""

# %%
# The mechanism has three rigid links, with lengths and masses of Table 1 of the paper, three ideal pins, one
# with clearance, and a crank at 1500 rpm.

import math

import vfife

m = vfife.Mechanism("four-bar with a loose pin")
m.point("A", 0.0, 0.0)
m.point("D", 0.150, 0.0)
m.link("crank", length=0.400, mass=3.120)
m.link("coupler", length=0.260, mass=2.028, angle=math.radians(51))
m.link("follower", length=0.460, mass=3.588, angle=math.radians(26))
m.revolute("A", "ground.A", "crank.start")
m.revolute("B", "crank.end", "coupler.start")
m.clearance_joint("C", "coupler.end", "follower.end", clearance=0.2e-3, bearing_radius=10e-3)
m.revolute("D", "ground.D", "follower.start")
m.drive("crank", speed=50 * math.pi)

# %%
# The run covers two turns, and one turn of the ideal mechanism for comparison. ``result.data`` is an
# ``xarray.Dataset`` with units, ``result.measures`` contains single numbers. LIP is the increase above the
# ideal mechanism.

result = vfife.simulate(m, turns=2)
force = result.data["joint_force"].sel(joint="C")
print(
    f"largest force in C ({result.measures.part}) {result.measures['C.force.max']:.0f} {force.units}, LIP "
    f"{result.measures['C.force.lip']:.2f} %"
)
print(f"follower: LIP {result.measures['follower.angular_acceleration.lip']:.1f} %")

# %%
# The figures show the path of the journal in its bearing, and forces and accelerations with the ideal curves.

figures = result.plot()

# %%
# The pin never leaves its bearing for long, so its force hardly increases. The acceleration of the follower
# increases much more.

assert abs(result.measures["follower.angular_acceleration.lip"] - 27.3) < 0.3
