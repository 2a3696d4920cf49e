"""
Four-bar with a loose pin
=========================

A crank turns a coupler and a follower; the pin between the two has 0.2 mm of play. How much harder does the
pin knock, and how much more does the follower shake, than in the ideal mechanism?
"""

# %%
# The mechanism: three rigid links (lengths and masses of the paper's Table 1), ideal pins but one, a crank at
# 1500 rpm.

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
# Two turns, and one of the ideal mechanism to compare with. The result is an ``xarray.Dataset`` with units
# and a few numbers.

result = vfife.simulate(m, turns=2)
force = result.data["joint_force"].sel(joint="C")
print(
    f"largest force in C ({result.measures.part}) {result.measures['C.force.max']:.0f} {force.units}, LIP {result.measures['C.force.lip']:.2f} %"
)
print(f"follower: LIP {result.measures['follower.angular_acceleration.lip']:.1f} %")

# %%
# The path of the journal in its bearing, and force and acceleration over the ideal curves.

figures = result.plot()

# %%
# The pin never leaves the bearing for long, so the force hardly rises; the follower feels the play far more.

assert abs(result.measures["follower.angular_acceleration.lip"] - 27.3) < 0.3
