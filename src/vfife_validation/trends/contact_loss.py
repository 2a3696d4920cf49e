"""Where a joint with clearance loses contact, beside what the mechanism without clearance says."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

import vfife
from vfife import Mechanism

Array = NDArray[np.float64]
OUTPUTS = 720  # a turn
TURNS, FIRST = 8, 4  # turns of a run, and those of them that are left out
LONG_CONTACT = 10.0  # degrees of contact before a loss of it; shorter contacts are bounces
SEPARATION = 20.0  # degrees of contact between two regions of free flight
QUARTER = 0.25  # of a turn, in which losses are predicted
FREE, LASTING = 0, 2  # modes of free flight and of continuous contact


class Flight(NamedTuple):
    """Free flight of a joint over the last turns of a run: its share of the time, the number of regions of
    the turn with free flight, and the crank angles (degrees) at which lasting contact is lost.
    """

    share: float
    regions: int
    losses: Array

    @property
    def losses_per_turn(self) -> float:
        """How often lasting contact is lost in a turn."""
        return len(self.losses) / (TURNS - FIRST)


def flight(mechanism: Mechanism, joint: str) -> Flight:
    """Run a mechanism and find where a joint flies freely."""
    data = vfife.simulate(mechanism, turns=TURNS, outputs=OUTPUTS).data
    modes, angles = data["mode"].sel(clearance=joint).values, data["crank_angle"].values
    first, long_contact = FIRST * OUTPUTS + 1, round(LONG_CONTACT / 360.0 * OUTPUTS)
    free = np.flatnonzero(modes[first:] == FREE) + first
    losses = [k for k in free if (modes[k - long_contact : k] == LASTING).all()]
    return Flight(len(free) / len(modes[first:]), regions(angles[free]), angles[losses])


def regions(angles: Array) -> int:
    """Count the groups of crank angles (degrees) that are at least SEPARATION apart on the circle."""
    if not len(angles):
        return 0
    places = np.sort(angles)
    return max(1, int((np.diff(np.append(places, places[0] + 360.0)) > SEPARATION).sum()))


def turning_rate(mechanism: Mechanism, joint: str) -> Array:
    """How fast the force of an ideal joint turns over its size (rad/(s N)), at OUTPUTS crank angles from 0:
    the quantity by which Earles and Wu predict that contact is lost.
    """
    data = vfife.simulate(mechanism, turns=1, outputs=OUTPUTS).data.isel(time=slice(1, None))
    x, y = (data[f"joint_force_{axis}"].sel(joint=joint).values for axis in "xy")
    rate = np.abs(np.gradient(np.unwrap(np.arctan2(y, x)), data["time"].values)) / np.hypot(x, y)
    result = np.empty(OUTPUTS)
    result[places(data["crank_angle"].values)] = rate
    return result


def places(angles: Array) -> NDArray[np.int64]:
    """Return the indices of crank angles (degrees) among OUTPUTS of a turn."""
    return np.rint(angles * OUTPUTS / 360.0).astype(np.int64) % OUTPUTS


def predicted(losses: Array, rate: Array) -> int:
    """Count the losses of contact (degrees) within the quarter of the turn in which ``rate`` is largest."""
    return int((rate[places(losses)] >= np.quantile(rate, 1.0 - QUARTER)).sum())
