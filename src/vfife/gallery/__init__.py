"""Mechanisms to start from, each a function with keyword parameters (SI units) that returns a :class:`~vfife.model.mechanism.Mechanism`.

With its default values a function builds what the model file of the same name in ``examples/`` holds.

>>> from vfife import gallery
>>> gallery.jansen_leg(speed=3.0).name
'Jansen leg'
"""

from .block_on_incline import block_on_incline
from .compressor import compressor
from .four_bar import four_bar, four_bar_case_b, four_bar_case_c, four_bar_ideal
from .frames import elastica_circle, lee_frame, williams_toggle
from .gear_train import gear_train
from .jansen_leg import jansen_leg
from .journal_in_bearing import journal_in_bearing
from .pendulums import double_pendulum, elastic_pendulum
from .presses import six_bar_press, toggle_press
from .quick_return import quick_return
from .scissor_lift import scissor_lift
from .scotch_yoke import scotch_yoke
from .slider_crank import slider_crank, slider_crank_loose_guide, slider_crank_loose_pin
from .squeezer import squeezer

__all__ = [
    "block_on_incline",
    "compressor",
    "double_pendulum",
    "elastic_pendulum",
    "elastica_circle",
    "four_bar",
    "four_bar_case_b",
    "four_bar_case_c",
    "four_bar_ideal",
    "gear_train",
    "jansen_leg",
    "journal_in_bearing",
    "lee_frame",
    "quick_return",
    "scissor_lift",
    "scotch_yoke",
    "six_bar_press",
    "slider_crank",
    "slider_crank_loose_guide",
    "slider_crank_loose_pin",
    "squeezer",
    "toggle_press",
    "williams_toggle",
]
