"""What ``vfife verify published`` shows: published studies, each with statements that are true or false."""

from __future__ import annotations

from collections.abc import Callable

from vfife.studies.methods.sensitivity_indices import salib

from ..paper.contents import Item
from . import four_bar_chaos, free_guide, jansen, loose_chain, lubricated, slap

TITLE = "Comparison with published studies"
INTRODUCTION = (
    "Published studies of linkages with clearance, recomputed. Our numbers decide whether a statement is"
    " true or false; the page shows disagreement as openly as agreement. Each item states how much of its"
    " source we could read, which numbers the source leaves open, and how much these matter."
)
ITEMS: dict[str, Callable[[], Item]] = {
    "loose-guide": free_guide.item,
    "loose-chain": loose_chain.item,
    "lubricated-pin": lubricated.item,
    "piston-slap": slap.item,
    "four-bar-chaos": four_bar_chaos.item,
    "jansen-leg": jansen.item,
    "jansen-scales": jansen.scale_item,
    "jansen-sobol": jansen.sobol_item,
}
# Processor time (s) of each item, on a common machine.
SECONDS = {
    "loose-guide": 9.0, "loose-chain": 2.0, "lubricated-pin": 5.0, "piston-slap": 28.0,
    "four-bar-chaos": 16.0, "jansen-leg": 28.0, "jansen-scales": 35.0, "jansen-sobol": 71.0,
}  # fmt: skip
# Items that need a library of an extra, with what imports it or raises VfifeError.
LIBRARIES: dict[str, Callable[[], object]] = {"jansen-sobol": salib}
