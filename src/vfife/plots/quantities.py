"""What is drawn over crank angle, by joint, gear, driver, body or slider: samples, extremes between them, and the measure that reports the peak."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ..analysis.forces import joint_force, joint_force_max, joint_moment, joint_rows
from ..analysis.guides import slider_motion, sliders
from ..numerics.elementwise import hypot
from ..solvers.record import Record

if TYPE_CHECKING:
    from ..results.view import View

Array = NDArray[np.float64]
NOISE = 1e-5  # of the largest force or moment (N, N m), below which a joint carries nothing
ROUNDING = 1e-6  # of the largest acceleration, below which one is what rounding leaves


@dataclass(frozen=True)
class Quantity:
    """``samples`` of a record at its outputs, (outputs,); ``extremes``, the largest size since the output before; ``peak`` is a measure's name."""

    title: str
    what: str
    unit: str
    samples: Callable[[Record], Array]
    extremes: Callable[[Record], Array] | None = None
    peak: str = ""

    def largest(self, record: Record) -> float:
        """The largest size over a whole record."""
        every = [self.samples(record)] if self.extremes is None or record.static else [self.samples(record), self.extremes(record)]
        return max(float(np.nanmax(np.abs(one), initial=0.0)) for one in every)


def joint_forces(result: View) -> dict[str, Quantity]:
    """Size of the force of each joint that carries one, in the order of tables."""
    found = {name: _force(result, name) for name in joint_rows(result.record)}
    return _carrying(result, found, max([0.0, *(one.largest(result.record) for one in moments_of(result).values())]))


def moments(result: View) -> dict[str, Quantity]:
    """Moment of each gear, weld, guide and driver that has one, and torque of each driver."""
    return _carrying(result, moments_of(result), 0.0)


def moments_of(result: View) -> dict[str, Quantity]:
    """The same, with those that are zero."""
    record, found = result.record, {}
    for name, (block, _) in joint_rows(record).items():
        if block == "joint":
            found[name] = Quantity(titled(result, name), "moment", "N m", _column(joint_moment, name), _moment_max(name), f"{name}.moment.max")
    for name, body in record.assembly.bodies.items():
        if body.driven is not None and not record.static and record.keeps("driven_torque_max"):
            torque, most = (_of_body(block, name, "driven") for block in ("driven_torque", "driven_torque_max"))
            found[f"{name} "] = Quantity(f"drive of {name}", "torque", "N m", torque, most, f"{name}.torque.max")
    return found


def accelerations(result: View) -> dict[str, Quantity]:
    """Acceleration of each slider along its guide, and angular acceleration of each other body that is not driven."""
    record = result.record
    if record.static:
        return {}
    bodies, found, gliding = record.assembly.bodies, {}, set()
    for name in sliders(record) if record.keeps("particle_u") else ():
        gliding.add(record.assembly.mechanism.joints[name].sides[1][0])
        along = Quantity(f"{record.assembly.mechanism.joints[name].sides[1][0]} along {name}", "acceleration", "m/s²",
                         lambda one, name=name: slider_motion(one, name)[2], None, f"{name}.acceleration.max")  # type: ignore[misc]  # fmt: skip
        found[name] = along
    for name, body in bodies.items():
        measure = f"{name}.angular_acceleration.max"
        if body.driven is None and name not in gliding and result.measures.get(measure):
            sample, most = (_of_body(block, name, "row") for block in ("body_alpha", "body_alpha_max"))
            found[f"{name} "] = Quantity(name, "angular acceleration", "rad/s²", sample, most, measure)
    tallest = {unit: max((one.largest(record) for one in found.values() if one.unit == unit), default=0.0) for unit in ("m/s²", "rad/s²")}
    return {name: one for name, one in found.items() if one.largest(record) > ROUNDING * tallest[one.unit]}


def loaded_joints(result: View, most: int) -> list[str]:
    """Names of the joints that carry a force, in the order of tables; of more than ``most`` those with the largest forces."""
    return list(hardest(result, joint_forces(result), most))


def hardest(result: View, found: dict[str, Quantity], most: int) -> dict[str, Quantity]:
    """Those with the largest values, in the order they had."""
    kept = sorted(found, key=lambda name: -found[name].largest(result.record))[:most]
    return {name: one for name, one in found.items() if name in kept}


def titled(result: View, name: str) -> str:
    """What a joint, gear or driver is called over its panel."""
    mechanism = result.record.assembly.mechanism
    return ("joint " if name in mechanism.joints else "gear " if name in mechanism.gears else "driver ") + name


def _force(result: View, name: str) -> Quantity:
    def size(record: Record) -> Array:
        force = joint_force(record)[:, list(joint_rows(record)).index(name)]
        return np.asarray(hypot(force[:, 0], force[:, 1]), dtype=float)

    most = None if result.record.static else _column(joint_force_max, name)
    return Quantity(titled(result, name), "force", "N", size, most, f"{name}.force.max")


def _carrying(result: View, found: dict[str, Quantity], beside: float) -> dict[str, Quantity]:
    sizes = {name: one.largest(result.record) for name, one in found.items()}
    noise = NOISE * max([beside, *sizes.values()])
    return {name: one for name, one in found.items() if sizes[name] > noise}


def _column(of: Callable[[Record], Array], name: str) -> Callable[[Record], Array]:
    return lambda record: np.asarray(of(record)[:, list(joint_rows(record)).index(name)], dtype=float)


def _moment_max(name: str) -> Callable[[Record], Array]:
    return lambda record: np.asarray(record.block("joint_moment_max")[:, joint_rows(record)[name][1][0]], dtype=float)


def _of_body(block: str, name: str, place: str) -> Callable[[Record], Array]:
    return lambda record: np.asarray(record.block(block)[:, getattr(record.assembly.bodies[name], place)], dtype=float)
