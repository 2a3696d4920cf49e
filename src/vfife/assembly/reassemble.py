"""Assemblies with other numbers of clearance joints, made from one that is there: a tenth of a millisecond
each.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from copy import copy
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, NamedTuple, cast

import numpy as np

from ..errors import VfifeError
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


def reassembled(assembly: Assembly, joints: Mapping[str, Contact]) -> Assembly:
    """The assembly with other numbers in some of its clearance joints: what ``assemble`` gives with the same
    step, sooner. Raises VfifeError where a :class:`Reassembler` cannot make it.
    """
    result = Reassembler(assembly, None).with_joints(joints)
    if result is None:
        raise VfifeError(
            f"other numbers of {', '.join(joints)} change more than contacts of the assembly: kinds of laws,"
            " sides or wear, a journal that starts seated or deep in its bearing, or a law that is a table;"
            " assemble the mechanism anew"
        )
    return result


class LooseJoint(NamedTuple):
    """A clearance joint of an assembly, by what its numbers do not change: the mass (kg) that its contact
    meets, materials of its bodies, first rows of its blocks, distance (m) of its pins at the start.
    """

    effective_mass: float | None
    materials: list[Material]
    rows: list[int]
    eccentricity: float


@dataclass(eq=False)
class Reassembler:
    """Makes assemblies with other numbers of clearance joints from one that ``assemble`` made with the same
    ``request`` and ``expected`` forces (N); without a request the step stays as it is.

    A number of such a joint reaches the rows of its contact and, where it is one of the contact law's, the
    step; nothing else of an assembly whose journals start centred. So every field may change but those that
    :func:`_kind` compares, and no field has to be listed. ``usable``: False where something else is
    known to follow from them. ``choices``: steps, and the topologies they make, by the slots of contact laws.
    """

    assembly: Assembly
    request: StepRequest | None
    expected: Mapping[str, float] = field(default_factory=dict)
    usable: bool = True
    choices: dict[bytes, tuple[StepChoice, Topology]] = field(default_factory=dict)

    @cached_property
    def joints(self) -> dict[str, LooseJoint]:
        """The joints whose numbers may be replaced; none where more than their rows and the step follows from
        them: joints that do not ``refits``, laws with tables, journals that start seated.
        """
        assembly, mechanism = self.assembly, self.assembly.mechanism
        refits = [mechanism.contacts[name].refits for name in assembly.contact_joints]
        if not all(refits) or assembly.topology.contact_knots or mechanism.start.journals != "centred":
            return {}
        return {name: self._loose(k, name) for k, name in enumerate(assembly.contact_joints) if self.usable}

    def _loose(self, index: int, name: str) -> LooseJoint:
        """The joint of a contact."""
        mechanism, layout = self.assembly.mechanism, self.assembly.layout
        joint = mechanism.contacts[name]
        materials = [
            mechanism.bodies[body].material if body != "ground" else Material() for body, _ in joint.sides
        ]
        gap = distance(self._pin(index, "bearing"), self._pin(index, "journal"))
        mass = surfaces(mechanism, joint).effective_mass
        return LooseJoint(mass, materials, [layout.row(block, index) for block in TOUCHED], gap)

    def _pin(self, index: int, side: str) -> tuple[float, float]:
        """Where the pin of a contact is at the start (m)."""
        layout, state = self.assembly.layout, self.assembly.state
        particle = getattr(self.assembly.topology, f"contact_{side}")[index]
        x, y = (float(state[layout.row(f"contact_{side}_{axis}", index)]) for axis in "xy")
        px, py, angle = (
            float(state[layout.row(f"particle_{axis}", particle)]) for axis in ("x", "y", "theta")
        )
        s, c = sincos(angle)
        return px + c * x - s * y, py + s * x + c * y

    def with_joints(self, joints: Mapping[str, Contact]) -> Assembly | None:
        """The assembly with some of its joints replaced by others of the same laws; None where it has to be
        made from the start, or cannot be.
        """
        old = self.assembly
        state = old.state.copy()
        for name, contact in joints.items():
            joint, former, loose = (
                cast(Any, contact),
                cast(Any, old.mechanism.joints[name]),
                self.joints.get(name),
            )
            if loose is None or _kind(joint) != _kind(former) or any(joint.conflicts()):
                return None
            if not loose.eccentricity - joint.clearance <= joint.deepest_start[0]:  # assembly refuses it
                return None
            pair = joint.pair(*loose.materials).between(loose.effective_mass)
            blocks = touch_values(joint, joint.touchings(0.0)[0], pair)
            for row, values in zip(loose.rows, blocks, strict=True):
                state[row : row + len(values)] = values
        slots = state[old.layout.rows_of("contact_slots")]
        if not np.isfinite(slots).all():
            return None
        mechanism = copy(old.mechanism)
        mechanism.joints = {**old.mechanism.joints, **joints}
        if self.request is None:
            return dataclasses.replace(old, mechanism=mechanism, state=state)
        choice, topology = self._choice(mechanism, state, slots.tobytes(), self.request)
        state[old.layout.row("step")] = choice.step
        return dataclasses.replace(old, mechanism=mechanism, state=state, choice=choice, topology=topology)

    def _choice(
        self, mechanism: Mechanism, state: Any, key: bytes, request: StepRequest
    ) -> tuple[StepChoice, Topology]:
        """The step, and the topology that it makes, which depend on the laws of contact alone."""
        old = self.assembly
        if not self.choices:
            self.choices[old.state[old.layout.rows_of("contact_slots")].tobytes()] = old.choice, old.topology
        if key in self.choices:
            return self.choices[key]
        touches = [
            touches_of(name, joint, NOWHERE, NOWHERE, 0.0)[0] for name, joint in mechanism.contacts.items()
        ]
        owners = [name for name, body in old.bodies.items() for _ in body.elements]
        free = 0 if old.mobility is None else old.mobility.after_drives
        topology = old.topology
        model = StepModel(
            mechanism, old.layout, state, topology, touches, owners, old.ideals, self.expected, free
        )
        choice = choose_step(model, request)
        if old.ideals:
            topology = topology.corrected(coarse(mechanism, choice, old.layout, state))
        if len(self.choices) < MOST_CHOICES:
            self.choices[key] = choice, topology
        return choice, topology


def _kind(joint: Any) -> tuple[Any, ...]:
    """What two joints have in common that differ in numbers alone; a change of it needs a new assembly. Wear
    belongs to it: worn profiles have rows of their own, which are not written here.
    """
    return joint.sides, type(joint.contact), type(joint.friction), joint.wear
