"""Runs of the gallery that several files look at; the scheduler gives these files to one process."""

from functools import cache

import vfife
from vfife import gallery
from vfife.result import Result


@cache
def run(name: str) -> Result:
    """The mechanism with its default values, run as it says itself; the compressor for one of its six turns."""
    fewer = {"turns": 1.0} if name == "compressor" else {}
    result = vfife.simulate(getattr(gallery, name)(**fewer), reference=False)
    assert result.record.status == "complete"
    return result
