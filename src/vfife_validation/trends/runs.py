"""The runs that the statements are judged by; each grid is computed once."""

from __future__ import annotations

import math
from functools import lru_cache
from typing import NamedTuple

from vfife import Mechanism

from . import contact_loss
from .contact_loss import Flight
from .grid import Grid, grid
from .mechanisms import FRICTION, RESTITUTION, RPM, chain, slider_crank

CLEARANCES = (0.02e-3, 0.05e-3, 0.1e-3, 0.2e-3, 0.3e-3, 0.5e-3)  # m
SPEEDS = tuple(RPM * rpm for rpm in (500.0, 1000.0, 2000.0, 5000.0))  # rad/s
FEW_CLEARANCES, FEW_SPEEDS = (0.05e-3, 0.2e-3, 0.5e-3), (SPEEDS[0], SPEEDS[2], SPEEDS[3])
CHAIN_CLEARANCES = (0.05e-3, 0.1e-3, 0.2e-3, 0.5e-3)  # m
CHAIN_SPEEDS = (10.0 * math.pi, 20.0 * math.pi, 50.0 * math.pi)  # rad/s, those of the paper
JOINTS = "BCD"
SOFT = 0.3  # restitution of soft impacts
PEAK, IMPACT, VOLUME, DEPTH = (
    "pin.force.max", "pin.impact_energy.total", "pin.bearing_wear.total", "pin.bearing_wear_depth.max"
)  # fmt: skip
ACCELERATION = "follower.angular_acceleration.max"
SURFACES = {
    "friction 0.1, restitution 0.9": (FRICTION, RESTITUTION),
    "friction 0.1, restitution 0.3": (FRICTION, SOFT),
    "no friction, restitution 0.9": (0.0, RESTITUTION),
    "no friction, restitution 0.3": (0.0, SOFT),
}


@lru_cache
def pin() -> Grid:
    """Run the slider-crank with clearance in its pin."""
    return grid(slider_crank(CLEARANCES[0]), ["pin"], CLEARANCES, SPEEDS, (PEAK, IMPACT, VOLUME, DEPTH))


@lru_cache
def pin_with(friction: float, restitution: float) -> Grid:
    """Run the slider-crank with other surfaces, at fewer clearances and speeds."""
    mechanism = slider_crank(FEW_CLEARANCES[0], friction=friction, restitution=restitution)
    return grid(mechanism, ["pin"], FEW_CLEARANCES, FEW_SPEEDS, (PEAK,))


@lru_cache
def loose(joints: str) -> Grid:
    """Run the four-bar with clearance in ``joints``."""
    measures = [f"{joint}.{ending}" for joint in joints for ending in ("force.max", "friction_energy.total")]
    mechanism = chain(joints, CHAIN_CLEARANCES[0], CHAIN_SPEEDS[0])
    return grid(mechanism, list(joints), CHAIN_CLEARANCES, CHAIN_SPEEDS, [ACCELERATION, *measures])


class Loss(NamedTuple):
    """Free flight of a joint of a mechanism, how many of its contact losses the ideal mechanism predicts, and
    the largest rate by which it does (rad/(s N)).
    """

    name: str
    flight: Flight
    predicted: int
    largest_rate: float


def losses() -> list[Loss]:
    """Where the pin of the slider-crank and the joints of the four-bar lose contact."""
    result = []
    for speed in FEW_SPEEDS:
        rate = contact_loss.turning_rate(slider_crank(speed=speed), "pin")
        for friction in (FRICTION, 0.0):
            for clearance in FEW_CLEARANCES:
                mechanism = slider_crank(clearance, speed, friction)
                result.append(loss(label("pin", clearance, speed, friction), mechanism, "pin", rate))
    clearance = CHAIN_CLEARANCES[-1]
    for speed in (CHAIN_SPEEDS[0], CHAIN_SPEEDS[-1]):
        for joint in JOINTS:
            rate = contact_loss.turning_rate(chain("", 0.0, speed), joint)
            name = label(f"{joint} of the four-bar", clearance, speed, FRICTION)
            result.append(loss(name, chain(joint, clearance, speed), joint, rate))
    return result


def label(joint: str, clearance: float, speed: float, friction: float) -> str:
    """Describe a run in words."""
    surface = f"friction {friction:g}" if friction else "no friction"
    return f"{joint}, {1e3 * clearance:g} mm, {speed / RPM:.0f} rpm, {surface}"


def loss(name: str, mechanism: Mechanism, joint: str, rate: contact_loss.Array) -> Loss:
    """Free flight of one joint beside the ``rate`` of the ideal one."""
    flight = contact_loss.flight(mechanism, joint)
    return Loss(name, flight, contact_loss.predicted(flight.losses, rate), float(rate.max()))
