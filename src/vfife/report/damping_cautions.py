"""Cautions about largest forces that are mostly damping of the contact law."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from ..measures.damped_peaks import DampedPeak, damped_peaks
from ..numerics.outward import DOWN, significant
from .digits import prefixed

if TYPE_CHECKING:
    from ..model.joints import Contact
    from ..results.run_data import RunData

# Share of a largest force from which on its damping is mentioned.
MOSTLY = 0.5
# Rate over the speed of the onset beyond which a contact was struck while it was closed: in a free impact the
# rate is never larger than at the onset.
STRUCK = 1.1


def damping_cautions(result: RunData) -> dict[str, str]:
    """Return a sentence on each joint whose largest force is damping by more than a half, with what bounds
    it.
    """
    sentences = {}
    for name, peak in damped_peaks(result.record, result.motion).items():
        if peak.share > MOSTLY:
            share, force = significant(100.0 * peak.share, 2, DOWN), prefixed(float(f"{peak.force:.2g}"), "N")
            cause = _cause(peak, result.record.assembly.mechanism.contacts[name])
            sentences[name] = (
                f"Joint {name}: at least {share} % of its peak of {force} is damping of the contact law,"
                f" as the penetration shows. {cause}"
            )
    return sentences


def _cause(peak: DampedPeak, joint: Contact) -> str:
    """Return why damping is large, and which settings bound it."""
    law = joint.contact
    if math.isnan(peak.ratio):
        return f"It depends on the damping of {law.name}: compare other values of it, or another law."
    if peak.ratio <= STRUCK:
        restitution, factor = (getattr(law, key, math.nan) for key in ("restitution", "damping_factor"))
        return (
            f"That follows from the restitution of {restitution:.4g}, a damping factor of {factor:.3g}:"
            " compare another restitution, or another law."
        )
    floor = prefixed(joint.impact_speed_floor, "m/s")
    ratio = significant(peak.ratio, 2, DOWN)
    onset = "slowly" if math.isnan(peak.onset) else f"at {prefixed(peak.onset, 'm/s')}"
    speed = joint.impact_speed_floor if math.isnan(peak.onset) else peak.onset
    rate = prefixed(float(f"{peak.ratio * speed:.1g}"), "m/s")
    return (
        f"The damping of {law.name} is proportional to the rate over the speed of the onset. This contact"
        f" began {onset} and was struck while closed, at {ratio} times that speed or more. Such a force"
        f" may depend on impact_speed_floor ({floor} here), which bounds it: compare {rate} and ten times"
        ' that, or the law "hertz" with damping = "none", which loses no energy, and quote the range.'
    )
