"""A run of a case, and what is read from its record."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np
from numpy.typing import NDArray

from vfife.assembly.assemble import assemble
from vfife.measures import Ledger, ledger
from vfife.measures.motion import body_motion, pin_path, times, velocities
from vfife.model.mechanism import Mechanism
from vfife.simulation.simulate import simulate
from vfife.solvers.record import Record
from vfife.solvers.statics import equilibrium
from vfife.solvers.status import Status

Array = NDArray[np.float64]
NO_LIMIT = 1e9  # share of the largest energy: a case is judged by its reference, and by nothing else


class CaseMotion:
    """Motion and forces of a run, as arrays over its outputs; of a static analysis the outputs are its load
    factors, from 0 on.
    """

    def __init__(self, record: Record) -> None:
        self.record = record
        self.time = times(record)
        self._motion = body_motion(record)

    def body(self, name: str, quantity: str = "angle") -> Array:
        """x, y (m), angle (rad) or angular_velocity (rad/s) of a body."""
        return self._motion[quantity][:, self.record.assembly.bodies[name].row]

    def pin(self, name: str, pin: str) -> Array:
        """Path of a pin (m), shape (outputs, 2)."""
        return pin_path(self.record, name, pin)

    def turn(self, name: str, pin: str) -> Array:
        """Rotation (rad) of the particle that carries a pin."""
        return self.particle("particle_theta", name, pin)

    def particle(self, block: str, name: str, pin: str = "") -> Array:
        """Return a block of the particle that carries a pin, or of the first particle of a body."""
        rows = self.record.assembly.bodies[name]
        return self.record.block(block)[:, rows.nodes.get(pin, rows.particles[0])]

    def speed(self, name: str, axis: str) -> Array:
        """Velocity u, v (m/s) or w (rad/s) of a body's first particle at the outputs."""
        return velocities(self.record)[axis][:, self.record.assembly.bodies[name].particles[0]]

    def ideal(self, joint: str, quantity: str) -> Array:
        """Reaction fx, fy (N) or moment (N m) on the journal of an ideal joint, gear or prescribed travel."""
        return self.record.block(f"joint_{quantity}")[:, self.record.assembly.ideals.index(joint)]

    def driven(self, body: str, quantity: str) -> Array:
        """torque (N m), fx, fy (N) of a driven body's pivot."""
        return self.record.block(f"driven_{quantity}")[:, int(self.record.assembly.bodies[body].driven or 0)]

    def contact(self, name: str, quantity: str) -> Array:
        """Return a block of one contact."""
        return self.record.block(f"contact_{quantity}")[:, self.record.assembly.contacts.index(name)]

    @property
    def ledger(self) -> Ledger:
        """The energy ledger."""
        return ledger(self.record)

    def at(self, time: float, values: Array) -> float:
        """Values at a time (s) between outputs, by a cubic through the four around it."""
        k = int(np.clip(np.searchsorted(self.time, time) - 2, 0, len(self.time) - 4))
        t, v = self.time[k : k + 4] - time, values[k : k + 4]
        return float(np.polyfit(t / (t[-1] - t[0]), v, 3)[-1])


def run(mechanism: Mechanism, **options: Any) -> CaseMotion:
    """Run a mechanism by the data-driven loop, which is compiled once for all cases. Raises RuntimeError if
    the run ends early.
    """
    if mechanism.settings.analysis == "static":
        record = equilibrium(assemble(mechanism))
    else:
        judged = dataclasses.replace(
            mechanism, settings=dataclasses.replace(mechanism.settings, energy_limit=NO_LIMIT)
        )
        record = simulate(judged, reference=False, loop="data-driven", **options).record
    if record.status == Status.INTERRUPTED:  # a run keeps what it has; a case has no use for half of it
        raise KeyboardInterrupt
    if record.status != Status.COMPLETE:
        raise RuntimeError(f"the run of {mechanism.name!r} ended {record.status}: {record.message}")
    return CaseMotion(record)


def frequency(time: Array, values: Array, expected: float) -> float:
    """Frequency (Hz) of a vibration near one that is expected: the peak of the spectrum under a Gaussian
    window, whose logarithm is a parabola.
    """
    values = values - np.polyval(np.polyfit(time, values, 2), time)
    window = np.exp(-0.5 * (np.linspace(-5.0, 5.0, len(values))) ** 2)
    size = np.abs(np.fft.rfft(values * window))
    rate = np.fft.rfftfreq(len(values), time[1] - time[0])
    close = np.flatnonzero((rate > 0.8 * expected) & (rate < 1.2 * expected))
    k = int(close[np.argmax(size[close])])
    a, b, c = np.log(size[k - 1 : k + 2])
    return float(rate[k] + 0.5 * (a - c) / (a - 2.0 * b + c) * (rate[1] - rate[0]))
