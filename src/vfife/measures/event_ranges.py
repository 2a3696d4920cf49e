"""Ranges of shares of time and of friction energy, which change by whole impacts.

A journal that comes to rest bounces many times, each time lower. How many of the last bounces there are
depends on the step, and all step sizes may miss the same one. A flight more or less changes the share of free
flight by the length of that flight, and friction, which acts in contact, by as much. The duration of a flight
is known in the mean only; the last flights of such a series are shorter. Impacts of nearly one speed have no
such series, and the step sizes show their error.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

from ..solvers.record import Record

if TYPE_CHECKING:
    from .samples import Samples

# Mean flights by which a share may change, where step sizes have different numbers of impacts, and where all
# have the same. Measured in 20 variants of a chain of three joints (tests/verification/test_event_ranges.py)
# and in that with 11, 16 and 6 impacts, whose true share lies 0.28 mean flights from the value.
FLIGHTS_UNEQUAL, FLIGHTS_EQUAL = 0.5, 0.1
# Mean approach speed over the fastest, below which impacts decay: 0.41 for eleven with a restitution of 0.8.
DECAYING = 0.5
STEPS = 2.0  # of each impact: those in which it begins and ends
CONTACT = "continuous_contact"
FRICTION = ("friction_energy.total", "friction_power.mean")


def event_errors(record: Record, samples: Mapping[str, Samples]) -> dict[str, float]:
    """Return the least errors of shares (1) and friction energies (J) and powers (W) by measure, from one
    flight more or less where impacts decay, and from the steps in which contacts begin and end.
    """
    if not record.assembly.contacts or not record.keeps("contact_approach"):
        return {}
    onsets, sums, fastest = (record.last(f"contact_{name}") for name in ("onsets", "approach", "fastest"))
    decays = sums < DECAYING * fastest * onsets
    errors: dict[str, float] = {}
    relative: dict[str, float] = {}
    joints = zip(record.assembly.contacts, record.assembly.contact_joints, strict=True)
    for k, (contact, joint) in enumerate(joints):
        names = [f"{contact}.impacts", *(f"{contact}.share.{mode}" for mode in ("free_flight", CONTACT))]
        if not onsets[k] or not all(name in samples for name in names):
            continue
        impacts, flight, touching = (samples[name] for name in names)
        error = STEPS * impacts.value / float(record.steps[-1])
        if decays[k]:
            part = FLIGHTS_EQUAL if impacts.low == impacts.high else FLIGHTS_UNEQUAL
            error = max(error, part * flight.value / impacts.value)
        errors[names[1]] = errors[names[2]] = error
        relative[joint] = relative.get(joint, 0.0) + error / max(touching.value, error)
    for joint, share in relative.items():
        for kind in FRICTION:
            if (sample := samples.get(f"{joint}.{kind}")) is not None:
                errors[f"{joint}.{kind}"] = share * abs(sample.value)
    return errors


def friction_losses(record: Record) -> frozenset[str]:
    """Return the friction energies and mean powers that are never negative, because their law only takes
    energy from the sliding at every moment; those of laws with bristles are not among them.
    """
    contacts = record.assembly.mechanism.contacts
    joints = {name for name in record.assembly.contact_joints if contacts[name].friction.dissipative}
    return frozenset(f"{joint}.{kind}" for joint in joints for kind in FRICTION)


def widened(name: str, sample: Samples, bounds: tuple[float, float], error: float) -> tuple[float, float]:
    """Return a range, not narrower than its values and the error to both sides; that of a share lies between
    0 and 1.
    """
    low, high = min(bounds[0], sample.low - error), max(bounds[1], sample.high + error)
    return (max(low, 0.0), min(high, 1.0)) if ".share." in name else (low, high)
