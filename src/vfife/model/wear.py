"""Wear of the two surfaces of a joint with clearance: Archard's coefficients, and the worn profiles."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..errors import Fault, shown
from ..laws.materials import PAIRS
from ..numerics.elementwise import sincos
from ..numerics.scalar import hypot
from ..schema import LENGTH, FreeList, Measure, described

MOST_HARMONICS = 32
EXAMPLE = "8e-8 mm^3/(N m)"  # steel on steel with oil


class WearCoefficient(Measure):
    """A wear coefficient (1/Pa) or the name of a pair of materials. ``mm3`` stands for ``mm^3``, because
    tables of tribology have it.
    """

    def take(self, value: Any, written: bool) -> Any:
        """Return an SI value or the name of a pair."""
        try:
            return super().take(
                re.sub(r"\bmm3\b", "mm^3", value) if isinstance(value, str) else value, written
            )
        except Fault as fault:
            if self.words[0] not in fault.limit:  # of the right kind, but negative
                raise
            pairs = ", ".join(f'"{name}"' for name in self.words)
            limit = f"a number in mm^3/(N m) or 1/Pa, or one of the pairs {pairs}"
            raise Fault(
                fault.where, fault.what, shown(value), limit, f'write for example "{EXAMPLE}"'
            ) from None

    def remedy(self, written: bool) -> str:
        """Return the remedy for a negative coefficient."""
        return f'correct the value or its unit (as in "{EXAMPLE}")' if written else super().remedy(written)


COEFFICIENT = WearCoefficient("1/Pa", low=0.0, words=tuple(PAIRS))
MEANING = (
    "wear coefficient of the {}: volume over normal force and sliding distance, or a pair of materials by"
    " name"
)
PROFILE = (
    "worn depth around the {}, in its body's frame: mean depth, then cosine and sine of each multiple of the"
    " angle"
)


@dataclass(frozen=True, kw_only=True)
class Wear:
    """Archard's law: a surface loses the volume k F s.

    ``bearing`` and ``journal`` are the coefficients k (1/Pa) of the two surfaces, or names of material pairs,
    whose K is divided by the hardness of the surface's material. The ``_profile`` of a surface is the depth
    (m) already lost over the angle from its body's x axis, as (mean, cosine 1, sine 1, cosine 2, sine 2,
    ...); it adds to the clearance.
    """

    bearing: float | str = described(COEFFICIENT, MEANING.format("bearing"), 0.0)
    journal: float | str = described(COEFFICIENT, MEANING.format("journal"), 0.0)
    bearing_profile: tuple[float, ...] = described(FreeList(LENGTH), PROFILE.format("bearing"), ())
    journal_profile: tuple[float, ...] = described(FreeList(LENGTH), PROFILE.format("journal"), ())

    @property
    def harmonics(self) -> tuple[int, int]:
        """Number of harmonics of the profiles of bearing and journal, the mean included; 0 for a round
        surface.
        """
        return (len(self.bearing_profile) + 1) // 2, (len(self.journal_profile) + 1) // 2

    def conflicts(self) -> Iterator[Fault]:
        """Yield a fault for a profile that is too long, or has a cosine without its sine."""
        for key in ("bearing_profile", "journal_profile"):
            profile = getattr(self, key)
            if profile and len(profile) % 2 == 0:
                yield Fault(
                    ("wear",),
                    f"{key} has {len(profile)} depths: a cosine lacks its sine",
                    remedy="give it the mean and pairs after it",
                )
            elif profile and len(profile) > 2 * MOST_HARMONICS - 1:
                limit = f"at most {2 * MOST_HARMONICS - 1} depths"
                yield Fault(
                    ("wear",), f"{key} has {len(profile)} depths", "", limit, "leave out the finest ones"
                )


def depth_at(profile: tuple[float, ...], angle: Any) -> tuple[Any, Any]:
    """Return the depth (m) of a profile at angles (rad) of any shape, and its derivative (m/rad)."""
    depth, slope = np.zeros_like(angle), np.zeros_like(angle)
    for k in range((len(profile) + 1) // 2):
        a, b = (profile[0], 0.0) if k == 0 else profile[2 * k - 1 : 2 * k + 1]
        s, c = sincos(k * np.asarray(angle))
        depth, slope = depth + a * c + b * s, slope + k * (b * c - a * s)
    return depth, slope


def deepest(profile: tuple[float, ...]) -> float:
    """Return an upper bound of the depth (m) of a profile."""
    return (
        abs(profile[0]) + sum(hypot(*profile[k : k + 2]) for k in range(1, len(profile), 2))
        if profile
        else 0.0
    )
