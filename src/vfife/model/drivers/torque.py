"""A torque or a force."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from ..renamed import renamed
from .driver import Driver


@renamed(torque="value")
@dataclass(frozen=True, kw_only=True)
class Torque(Driver):
    """Torque (N m) on ``body`` (and its opposite on ``against``), or force (N) on ``point`` along ``direction``.

    A constant, or a table over time (s), over the speed of the body (``speeds``, rad/s: a motor's curve) or over its angle from the start
    (``angles``, rad). Tables are natural cubic splines through their points and keep their end values beyond.
    """

    kind: ClassVar[str] = "effort"

    value: float | tuple[float, ...]
    times: tuple[float, ...] | None = None
    speeds: tuple[float, ...] | None = None
    angles: tuple[float, ...] | None = None
