"""Assemblies that differ from another one in the numbers of its revolute joints with clearance: what :func:`assemble` gives, without closing anew.

A number of such a joint reaches the rows of its contact and, where it is one of the contact law's, the step; nothing else of an assembly whose
journals start centred.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from copy import copy
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray

from ..kernels.topology import Topology
from ..laws import Material
from ..model.joints import Contact
from ..model.mechanism import Mechanism
from ..model.surfaces import surfaces
from ..numerics.scalar import distance, sincos
from .assembled import Assembly, StepChoice
from .entities import touches_of
from .fill import TOUCHED, touch_values
from .timestep import StepModel, StepRequest, choose_step, coarse

NOWHERE = (0, (0.0, 0.0))
MOST_CHOICES = 4096  # steps that are remembered


class Refit:
    """Makes such assemblies from one, which ``assemble`` made with the same ``step``, ``expected`` and ``run``."""

    def __init__(self, assembly: Assembly, step: float | str | None, expected: Mapping[str, float], **run: Any) -> None:
        self.assembly, self.expected, self.request = assembly, expected, StepRequest(step, **run)
        mechanism, layout = assembly.mechanism, assembly.layout
        self.places = {name: k for k, name in enumerate(assembly.contact_joints) if mechanism.contacts[name].refits}
        self.usable = mechanism.start.journals == "centred" and len(self.places) == len(assembly.contacts) and not assembly.topology.contact_knots
        self.masses = {name: surfaces(mechanism, mechanism.contacts[name]).effective_mass for name in self.places}
        self.materials = {
            name: [mechanism.bodies[body].material if body != "ground" else Material() for body, _ in mechanism.contacts[name].sides]
            for name in self.places
        }
        self.rows = {name: [layout.row(block, k) for block in TOUCHED] for name, k in self.places.items()}
        self.apart = {name: self._apart(k) for name, k in self.places.items()}
        self.row = layout.row("step")
        self.slots = layout.rows_of("contact_slots")
        self.choices: dict[bytes, tuple[StepChoice, Topology]] = {assembly.state[self.slots].tobytes(): (assembly.choice, assembly.topology)}

    def _apart(self, index: int) -> float:
        """Distance of a journal from its bearing at the start (m)."""
        topology, layout, state = self.assembly.topology, self.assembly.layout, self.assembly.state

        def seen(side: str) -> tuple[float, float]:
            particle = getattr(topology, f"contact_{side}")[index]
            x, y = (float(state[layout.row(f"contact_{side}_{axis}", index)]) for axis in "xy")
            px, py, angle = (float(state[layout.row(f"particle_{axis}", particle)]) for axis in ("x", "y", "theta"))
            s, c = sincos(angle)
            return px + c * x - s * y, py + s * x + c * y

        return distance(seen("bearing"), seen("journal"))

    def with_joints(self, joints: Mapping[str, Contact]) -> Assembly | None:
        """The assembly with some of its joints replaced by others of the same laws; None where it has to be made anew, or cannot be."""
        old = self.assembly
        if not self.usable or not joints.keys() <= self.places.keys():
            return None
        state = old.state.copy()
        for name, joint in joints.items():
            joint, former = cast(Any, joint), cast(Any, old.mechanism.joints[name])
            alike = (joint.sides, type(joint.contact), type(joint.friction)) == (former.sides, type(former.contact), type(former.friction))
            alike = alike and joint.wear == former.wear
            if not alike or any(joint.conflicts()) or not self.apart[name] - joint.clearance <= joint.deepest_start[0]:
                return None
            pair = dataclasses.replace(joint.pair(*self.materials[name]), effective_mass=self.masses[name])
            for row, values in zip(self.rows[name], touch_values(joint, joint.touchings(0.0)[0], pair), strict=True):
                if len(values) == 1:
                    state[row] = values[0]
                else:
                    state[row : row + len(values)] = values
        slots = state[self.slots]
        if not np.isfinite(slots).all():
            return None
        mechanism = copy(old.mechanism)
        mechanism.joints = {**old.mechanism.joints, **joints}
        choice, topology = self.choices.get(slots.tobytes()) or self._stepped(mechanism, state, slots.tobytes())
        state[self.row] = choice.step
        found = copy(old)  # a third of the time of replacing fields, and there may be thousands
        for name, value in (("mechanism", mechanism), ("state", state), ("choice", choice), ("topology", topology)):
            object.__setattr__(found, name, value)
        return found

    def _stepped(self, mechanism: Mechanism, state: NDArray[np.float64], key: bytes) -> tuple[StepChoice, Topology]:
        """The step, and the topology that it makes, which hang on the laws of contact alone."""
        old = self.assembly
        touches = [touches_of(name, joint, NOWHERE, NOWHERE, 0.0)[0] for name, joint in mechanism.contacts.items()]
        owners = [name for name, body in old.bodies.items() for _ in body.elements]
        mobility = 0 if old.mobility is None else old.mobility.after_drives
        topology = old.topology
        choice = choose_step(StepModel(mechanism, old.layout, state, topology, touches, owners, old.ideals, self.expected, mobility), self.request)
        if old.ideals:
            topology = dataclasses.replace(topology, coarse=coarse(mechanism, choice, old.layout, state))
        if len(self.choices) < MOST_CHOICES:
            self.choices[key] = choice, topology
        return choice, topology
