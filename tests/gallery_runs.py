"""Runs of the gallery that several files look at; the scheduler gives these files to one process."""

from functools import cache

import vfife
from vfife import gallery
from vfife.simulation.result import Result

# Of ideal joints, and of few steps: the loop that all tests share is done with them before a straight line of
# their own is compiled.
# Those with clearance, the squeezing mechanism and the ideal four-bar have theirs.
QUICK = ("double_pendulum", "elastic_pendulum", "gear_train", "jansen_leg", "quick_return", "scissor_lift",
    "scotch_yoke", "six_bar_press",
         "slider_crank")  # fmt: skip


@cache
def run(name: str) -> Result:
    """The mechanism with its default values, run as it says itself; the compressor for one of
    its six turns.
    """
    fewer = {"turns": 1.0} if name == "compressor" else {}
    result = vfife.simulate(
        getattr(gallery, name)(**fewer), reference=False, loop="data-driven" if name in QUICK else "auto"
    )
    assert result.record.status == "complete"
    return result
