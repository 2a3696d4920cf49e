"""
A pin that wears
================

The pin between rod and block of a slider-crank has 0.2 mm of play and rubs. Where does it wear in ten million
turns, how much more play is there then, and how much harder does it strike? Few turns are simulated: between
them the surfaces change by what a turn takes, and the next ones run with the worn pin.
"""

# %%
# Coefficients of wear are data of the pair of materials and its lubrication: here 1e-6 mm³/(N m) of the
# bearing and a fifth of it of the harder
# journal, a mild wear that oil does not quite prevent. They are the least certain numbers of all: the turns
# of a life go with their inverse.

import dataclasses

import vfife

m = vfife.gallery.slider_crank_loose_pin(clearance=0.2e-3, restitution=0.7, friction=0.05)
m.joints["pin"] = dataclasses.replace(m.joints["pin"], wear=vfife.joints.Wear(bearing=1e-15, journal=2e-16))
worn = vfife.wear(m, 1e7, block=2, settle=2, step=4e-6)

# %%
# The bearing, in the rod, wears in two places, where the inertia of the block presses at both ends of its
# way. The journal turns against it and
# wears over a wider part. Zero is the circle of the new surface; depths are drawn thousands of times too
# large.

figure = worn.plot()

# %%
# What was asked for, and what it is known to: the error of all jumps together, and what the turns of a block
# leave open of a rate.

volume = 1e9 * worn.volume("pin", "bearing")[-1]
print(f"{worn.turns[-1]:,.0f} turns, {worn.simulated:.0f} of them simulated in {len(worn.turns) - 1} jumps")
print(f"bearing: {1e6 * worn.depth[-1, 0].max():.0f} µm at the deepest place, {volume:.1f} mm³")
print(f"play: {1e6 * worn.play[0, 0]:.0f} µm at first, {1e6 * worn.play[-1, 0]:.0f} µm in the end")
print(f"errors: jumps {1e6 * worn.errors.sum():.1f} µm, rates {100 * worn.spread.max():.1f} %")

# What one surface loses the other loses too, by their coefficients.
assert abs(worn.volume("pin", "journal")[-1] / (1e-9 * volume) - 0.2) < 1e-9

# %%
# The worn machine is a model like any other: run it, save it with :func:`vfife.save_model`, or go on from it.

new, old = (
    vfife.simulate(model, turns=4, companions=0).measures["pin.force.max"] for model in (m, worn.mechanism())
)
print(f"largest force of the pin: {new:.0f} N when new, {old:.0f} N when worn")
