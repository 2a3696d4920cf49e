"""
Figures of a run
================

``vfife plot RUN`` draws the usual figures into ``RUN/figures``. ``vfife plot RUN --figure list`` names all
figures and states which of them the run does not support; ``--figure NAME`` draws one, ``--figure all`` every
one. Files are PNG, or with ``--format`` SVG or PDF. In Python, ``result.plot()`` and
``result.plot("orbits", "energy")`` return Matplotlib figures by name. The colours are distinguishable for the
colour-blind.

Two short runs show nearly all figures: a slider-crank whose block has clearance in its guide, and a four-bar
with three loose pins.
"""

# %%
# **mechanism**: bodies and joints at the start of the run, with other positions in light colours.
# ``vfife plot RUN --at 90deg`` (or ``--at 12ms``) draws it at another moment.

import dataclasses

import vfife
from vfife import gallery

slider = vfife.simulate(gallery.slider_crank_loose_guide())
mechanism = slider.plot("mechanism")["mechanism"]

# %%
# **strip**: the mechanism at several moments of a turn, side by side.

strip = slider.plot("strip")["strip"]

# %%
# **guides**: tilt and offset of a block with clearance in its guide. Inside the diamond no corner touches a
# wall; on its edge one corner does, at its vertices two.

guides = slider.plot("guides")["guides"]

# %%
# **forces** over the turn: the line joins the outputs; the band covers the extremes between them, over all
# turns of the measures. Its top is the peak that the summary and the title of the panel state. The dashed
# line belongs to the ideal mechanism.

four_bar = vfife.simulate(gallery.four_bar_case_c())
forces = four_bar.plot("forces")["forces"]
assert forces.axes[3].get_title(loc="right") == f"peak {1e-3 * four_bar.measures['D.force.max']:.4g} kN"

# %%
# The horizontal axis is the angle of the crank itself, from 0 to 360 degrees.
#
# **moments** (of gears, welds and guides, and torques of drivers) and **accelerations** (of sliders along
# their guides and of rotating bodies) look the same.

moments, accelerations = slider.plot("moments", "accelerations").values()

# %%
# **orbits**: path of each journal's centre in its clearance circle, relative to its bearing, all in one
# scale. Dots belong to earlier turns.

orbits = four_bar.plot("orbits")["orbits"]

# %%
# **polar**: force on each journal as a vector relative to its bearing. It shows the loaded side, where wear
# gathers.

polar = four_bar.plot("polar")["polar"]

# %%
# **wear**: depth of wear around each surface of a joint with a table ``wear``, by Archard's law, for a
# million turns like the last one.

worn = gallery.four_bar_case_c()
worn.joints["C"] = dataclasses.replace(
    worn.contacts["C"], wear=vfife.joints.Wear(bearing=1e-17, journal=2e-18)
)
wear = vfife.simulate(worn, companions=0).plot("wear")["wear"]

# %%
# **traces**: paths of points. **phase**: velocity over position.

traces, phase = four_bar.plot("traces", "phase").values()

# %%
# **spectrum**: amplitudes of the joint forces at the outputs, over orders of the crank, or over frequencies
# without whole turns. Frequencies above half the output rate appear at wrong, lower ones; use more outputs.
# **waterfall**: the same turn by turn.

spectrum = four_bar.plot("spectrum")["spectrum"]
waterfall = slider.plot("waterfall")["waterfall"]

# %%
# **spectrogram**: the spectrum over time, in overlapping windows; title and axes state window, overlap and
# resolution. **envelope**: the amplitude of vibrations, by the Hilbert transform, and how often they are
# excited. ``result.spectrogram("C.force", turns=0.1)`` and ``vfife spectrum`` accept any series, window and
# band.

spectrogram = slider.plot("spectrogram")["spectrogram"]
envelope = slider.plot("envelope")["envelope"]

# %%
# **energy**: energy stored, supplied and lost over the whole run, and the error of the ledger.

energy = four_bar.plot("energy")["energy"]

# %%
# **stress** and **deflection** along elastic links, here of a soft rubber pendulum.

rubber = vfife.simulate(gallery.elastic_pendulum())
stress, deflection = rubber.plot("stress", "deflection").values()
