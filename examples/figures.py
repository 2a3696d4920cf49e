"""
Figures of a run
================

``vfife plot RUN`` draws the usual ones into ``RUN/figures``; ``vfife plot RUN --figure list`` says which
others there are and which of them the run has nothing for, ``--figure NAME`` draws one (``all``: every one
that there is). Files are PNG, or ``--format svg`` or ``pdf``. In Python ``result.plot()`` and
``result.plot("orbits", "energy")`` give them as Matplotlib figures by name. One style serves all; colours are
told apart by the colour-blind too.

Two short runs have nearly all of them: a slider-crank whose block has play in its guide, and the four-bar of
the source paper.
"""

# %%
# **mechanism**: bodies and joints where the run starts, other positions faint. ``vfife plot RUN --at 90deg``
# (or ``--at 12ms``) draws it as
# it is then.

import dataclasses

import vfife
from vfife import gallery

slider = vfife.simulate(gallery.slider_crank_loose_guide())
mechanism = slider.plot("mechanism")["mechanism"]

# %%
# **strip**: the same at moments of the turn, side by side.

strip = slider.plot("strip")["strip"]

# %%
# **guides**: how a block with play tilts and leaves the middle of its guide. In the diamond no corner touches
# a wall; on its edge one does,
# at its ends two.

guides = slider.plot("guides")["guides"]

# %%
# **forces** over the turn: the line joins the outputs, the band reaches to the extremes between them, and
# over all turns that measures are
# means of. Its top is the peak that the summary reports, which stands over the panel. Dashed: the ideal
# mechanism. Joints stand in the order
# of the tables.

four_bar = vfife.simulate(gallery.four_bar_case_c())
forces = four_bar.plot("forces")["forces"]
assert forces.axes[3].get_title(loc="right") == f"peak {1e-3 * four_bar.measures['D.force.max']:.4g} kN"

# %%
# A turn is opened where joint forces vary least, so that no event is cut in two: here at 180 degrees, the
# peak at 0 stands in the middle.
#
# **moments** of gears, welds and guides, torques of drivers, and **accelerations** of sliders along their
# guides and of turning bodies, are
# drawn alike.

moments, accelerations = slider.plot("moments", "accelerations").values()

# %%
# **orbits**: journals in their clearance circles, seen from their bearings, all in one scale. Dots are what
# came before the last turn.

orbits = four_bar.plot("orbits")["orbits"]

# %%
# **polar**: the force on each journal as a vector seen from its bearing: from where it is loaded, and where
# wear gathers.

polar = four_bar.plot("polar")["polar"]

# %%
# **wear**: how deep each surface of a joint with a table ``wear`` wears, where, by Archard's law, in a
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
# where no turn is whole. What is
# faster than half the rate of the outputs folds back: more outputs show it where it is. **waterfall**: the
# same turn by turn.

spectrum = four_bar.plot("spectrum")["spectrum"]
waterfall = slider.plot("waterfall")["waterfall"]

# %%
# **spectrogram**: the same from moment to moment, in windows that overlap; title and axes tell window,
# overlap and resolution. **envelope**: the
# size of what vibrates, by Hilbert's transform, and how often it is struck.
# ``result.spectrogram("C.force", turns=0.1)`` and ``vfife spectrum``
# take any series, window and band.

spectrogram = slider.plot("spectrogram")["spectrogram"]
envelope = slider.plot("envelope")["envelope"]

# %%
# **energy**: what is stored, supplied and lost over the whole run, and what the ledger leaves open.

energy = four_bar.plot("energy")["energy"]

# %%
# **stress** and **deflection** along elastic links, here of a pendulum of soft rubber.

rubber = vfife.simulate(gallery.elastic_pendulum())
stress, deflection = rubber.plot("stress", "deflection").values()
