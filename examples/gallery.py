"""
The gallery
===========

Mechanisms to start from: each is a function of ``vfife.gallery`` with keyword parameters, and a model file of the same name for ``vfife run``.
Here each runs as it stands, and is drawn. The tests hold a number of each against a closed form, a publication or an independent calculation.
"""

# %%
# **Slider-crank**: ideal, with a loose pin, with a loose guide whose block strikes the walls with its corners.

import vfife
from vfife import gallery

result = vfife.simulate(gallery.slider_crank_loose_pin())
pin, orbit = result.plot("mechanism", "orbits").values()

# %%

guide = vfife.simulate(gallery.slider_crank_loose_guide()).plot("mechanism", "forces")

# %%
# **Four-bar** with three clearance joints, the reference case c.

four_bar = vfife.simulate(gallery.four_bar_case_c()).plot("mechanism")["mechanism"]

# %%
# **Journal in bearing**: the smallest impact there is.

journal = vfife.simulate(gallery.journal_in_bearing()).plot("mechanism")["mechanism"]

# %%
# **Double pendulum**, and a **pendulum of soft rubber** that swings, bends and stretches.

double = vfife.simulate(gallery.double_pendulum()).plot("mechanism")["mechanism"]
rubber = vfife.simulate(gallery.elastic_pendulum()).plot("mechanism")["mechanism"]

# %%
# **Jansen's leg**: the foot's path is the dotted line.

leg = vfife.simulate(gallery.jansen_leg()).plot("mechanism")["mechanism"]

# %%
# **Six-bar press** and **toggle press**; the latter in equilibrium with its work piece, a spring.

six_bar = vfife.simulate(gallery.six_bar_press()).plot("mechanism")["mechanism"]
toggle = vfife.simulate(gallery.toggle_press()).plot("mechanism")["mechanism"]

# %%
# **Quick return** with its slot on a moving guide, and **Scotch yoke**.

shaper = vfife.simulate(gallery.quick_return()).plot("mechanism")["mechanism"]
yoke = vfife.simulate(gallery.scotch_yoke()).plot("mechanism")["mechanism"]

# %%
# **Scissor lift**, free of redundant constraints.

lift = vfife.simulate(gallery.scissor_lift()).plot("mechanism")["mechanism"]

# %%
# **Gear train**: a motor's curve, two stages of gears, a flywheel.

gears = vfife.simulate(gallery.gear_train()).plot("mechanism", "moments")

# %%
# **Andrews' squeezer**: seven bodies in three loops, the test problem of integrators.

result = vfife.simulate(gallery.squeezer())
squeezer = result.plot("mechanism")["mechanism"]
assert abs(float(result.data["body_angle"].sel(body="K1")[-1]) - 15.81077119629904) < 1e-5  # published

# %%
# **Block on an incline** under Coulomb's friction.

block = vfife.simulate(gallery.block_on_incline()).plot("mechanism")["mechanism"]

# %%
# Statics: a **cantilever rolled into a circle**, the **Williams toggle** pushed through, **Lee's frame** past its limit load.

circle = vfife.simulate(gallery.elastica_circle()).plot("mechanism")["mechanism"]

# %%

snap = vfife.simulate(gallery.williams_toggle()).plot("mechanism", "forces")

# %%

result = vfife.simulate(gallery.lee_frame())
lee = result.plot("mechanism")["mechanism"]
assert abs(result.measures["push.force.max"] - 1855.2) < 12.0  # published: 1.8552 kN
