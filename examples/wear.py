"""
A pin that wears
================

The pin between rod and block of a slider-crank has a clearance of 0.2 mm. Where does it wear in ten million
turns, how much does the clearance grow, and how much does the force? Only a few turns are simulated. Between
them, the surfaces change by the wear rate of these turns, and the next turns run with the worn pin.
"""

# %%
# Wear coefficients belong to a pair of materials and its lubrication: here 1e-6 mm³/(N m) for the bearing and
# a fifth of it for the harder journal, mild wear in spite of lubrication. They are the least certain numbers
# of the model, and a life is inversely proportional to them.

import dataclasses

import vfife

m = vfife.gallery.slider_crank_loose_pin(clearance=0.2e-3, restitution=0.7, friction=0.05)
m.joints["pin"] = dataclasses.replace(m.joints["pin"], wear=vfife.joints.Wear(bearing=1e-15, journal=2e-16))
worn = vfife.wear(m, 1e7, block=2, settle=2, step=4e-6)

# %%
# The bearing in the rod wears in two places, where the inertia of the block presses at both ends of its
# stroke. The journal rotates against it and wears over a wider part. Zero is the circle of the new surface;
# depths are enlarged thousands of times.

figure = worn.plot()

# %%
# The results, with two uncertainties: the error of all jumps together, and the scatter of the rate over the
# turns of a block.

volume = 1e9 * worn.volume("pin", "bearing")[-1]
print(f"{worn.turns[-1]:,.0f} turns, {worn.simulated:.0f} of them simulated in {len(worn.turns) - 1} jumps")
print(f"bearing: {1e6 * worn.depth[-1, 0].max():.0f} µm at its deepest place, {volume:.1f} mm³")
print(
    f"clearance: {1e6 * worn.clearance[0, 0]:.0f} µm at first, {1e6 * worn.clearance[-1, 0]:.0f} µm at "
    f"the end"
)
print(f"errors: jumps {1e6 * worn.errors.sum():.1f} µm, rates {100 * worn.spread.max():.1f} %")

# The volumes lost by the two surfaces are proportional to their coefficients.
assert abs(worn.volume("pin", "journal")[-1] / (1e-9 * volume) - 0.2) < 1e-9

# %%
# The worn mechanism is a model like any other: run it, or save it with :func:`vfife.save_model`.

new, old = (
    vfife.simulate(model, turns=4, companions=0).measures["pin.force.max"] for model in (m, worn.mechanism())
)
print(f"largest force in the pin: {new:.0f} N when new, {old:.0f} N when worn")
