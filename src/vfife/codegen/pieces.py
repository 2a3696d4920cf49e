"""The text of a step in three modules that call one another: what all steps of a width share, what every step needs, and what few do.

The first is compiled once in a process. The last is compiled with the least effort, which takes a quarter of the time, where it is long or no
event is to come. A short whole step is made as fast as the rest: impacts, of eight parts each, are a sixth of a run with one loose joint.
"""

from __future__ import annotations

import re
from typing import NamedTuple

from ..kernels.arrays import Layout
from ..kernels.topology import Topology
from .llvm import ANSWER, aligned, brief, driver, lanes, often, operators, parts, resize, whole

FUNCTION = re.compile(r"^define [^@]*@(\w+)\(.*?^}\n", re.M | re.S)
KNOWN = {
    "lean": "i64 @lean(ptr, ptr, ptr, i64, i64, i64)",
    "whole": "void @whole(ptr, ptr, i64, i64)",
    "functions": "void @functions(ptr, ptr, ptr, i64, i64)",
    "event": "void @event(ptr, ptr, ptr, i64, i64, i64)",
    "displace": "void @displace(ptr, ptr, ptr, i64, ptr)",
    "polynomial": f"{ANSWER} @polynomial(ptr, i64, double)",
}
FOR_ALL = ("advance", "stream", "watch", "polynomial")  # functions of the driver that know of no row
OF_EVENTS = ("event", "displace", "keep", "take")


class Pieces(NamedTuple):
    """Three modules; whether the last is ``hurried``, made with the least effort."""

    shared: str
    often: str
    seldom: str
    hurried: bool


def pieces(topology: Topology, width: int, directions: int = 0) -> Pieces:
    """The modules of :func:`.llvm.written`."""
    found, step, long, change = parts(topology, directions)
    fast = brief(step, long)
    theirs = {one[1]: one[0] for one in FUNCTION.finditer(driver(Layout(topology), width, directions))}
    events = [whole(long, width, bool(found), fast), resize(change, width), *(theirs[name] for name in OF_EVENTS)]
    return Pieces(
        _module(width, [theirs[name] for name in FOR_ALL]),
        _module(width, often(topology, width, directions, found, step)),
        _module(width, events),
        not fast,
    )


def _module(width: int, texts: list[str]) -> str:
    """A module of functions, all of which others can call, with what it needs of them."""
    own = {text[: text.index("(")].rpartition("@")[2] for text in texts}
    needed = [f"declare {said}" for name, said in KNOWN.items() if name not in own]
    public = (text.replace("define internal ", "define ", 1) for text in texts)
    return "\n".join([operators(width), lanes(width), *needed, *public, aligned(width)])
