"""Assemblies with other numbers of clearance joints, made from an existing one in a tenth of a millisecond.

Assembling a mechanism closes its position, computes reactions and fills all arrays. A number of a clearance
joint whose journal starts centred affects none of these: it enters the rows of its contact, and through the
contact law the step. Studies, fits and tolerance analyses vary such numbers in thousands of cases, so their
rows are written into a copy of the state. Everything else is shared with the original assembly.
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
from .timestep import StepModels, StepRequest, choose_steps, coarse

NO_CONTACT = (0, (0.0, 0.0))
MOST_CHOICES = 4096  # steps that are remembered


def reassembled(assembly: Assembly, joints: Mapping[str, Contact]) -> Assembly:
    """Return the assembly with some of its clearance joints replaced: the result of ``assemble`` with the
    same step. Raises VfifeError if the joints differ in more than numbers of their contacts.
    """
    result = Reassembler(assembly, None).with_joints(joints)
    if result is None:
        raise VfifeError(
            f"other numbers of {', '.join(joints)} change more than contacts of the assembly: kinds of laws,"
            " sides or wear, a journal that starts seated or deep in its bearing, or a law that is a table;"
            " assemble the mechanism anew"
        )
    return result


def is_reassemblable(mechanism: Mechanism) -> bool:
    """Return whether numbers of its clearance joints enter only their rows and the step: not for a kind of
    joint without ``refits``, a law with a table, or journals that start seated.
    """
    contacts = mechanism.contacts.values()
    return mechanism.start.journals == "centred" and all(j.refits and not j.contact.knots() for j in contacts)


class LooseJoint(NamedTuple):
    """Properties of a clearance joint that do not depend on its numbers: the effective mass (kg) of its
    contact, the materials of its bodies, the first rows of its blocks, and the distance (m) of its pins at
    the start.
    """

    effective_mass: float | None
    materials: list[Material]
    rows: list[int]
    eccentricity: float


@dataclass(eq=False)
class Reassembler:
    """Make assemblies with other numbers of clearance joints from one that ``assemble`` made with the same
    ``request`` and ``expected`` forces (N); without a request the step is not changed.

    A number of such a joint enters the rows of its contact and, if it belongs to the contact law, the step;
    it enters nothing else of an assembly whose journals start centred. Every field may therefore change
    except those that :func:`_kind` compares, and no field has to be listed. ``usable`` is False if something
    else is known to depend on them. ``choices`` caches steps and their topologies by the parameters of
    contact laws.
    """

    assembly: Assembly
    request: StepRequest | None
    expected: Mapping[str, float] = field(default_factory=dict)
    usable: bool = True
    choices: dict[bytes, tuple[StepChoice, Topology]] = field(default_factory=dict)

    @cached_property
    def joints(self) -> dict[str, LooseJoint]:
        """The joints whose numbers may be replaced; none if more than their rows and the step depends on
        them.
        """
        if not (self.usable and is_reassemblable(self.assembly.mechanism)):
            return {}
        return {name: self._loose(k, name) for k, name in enumerate(self.assembly.contact_joints)}

    def _loose(self, index: int, name: str) -> LooseJoint:
        """Return the joint of a contact."""
        mechanism, layout = self.assembly.mechanism, self.assembly.layout
        joint = mechanism.contacts[name]
        materials = [
            mechanism.bodies[body].material if body != "ground" else Material() for body, _ in joint.sides
        ]
        gap = distance(self._pin(index, "bearing"), self._pin(index, "journal"))
        mass = surfaces(mechanism, joint).effective_mass
        return LooseJoint(mass, materials, [layout.row(block, index) for block in TOUCHED], gap)

    def _pin(self, index: int, side: str) -> tuple[float, float]:
        """Return the place (m) of a contact's pin at the start."""
        layout, state = self.assembly.layout, self.assembly.state
        particle = getattr(self.assembly.topology, f"contact_{side}")[index]
        x, y = (float(state[layout.row(f"contact_{side}_{axis}", index)]) for axis in "xy")
        px, py, angle = (
            float(state[layout.row(f"particle_{axis}", particle)]) for axis in ("x", "y", "theta")
        )
        s, c = sincos(angle)
        return px + c * x - s * y, py + s * x + c * y

    def with_joints(self, joints: Mapping[str, Contact]) -> Assembly | None:
        """Return the assembly with some of its joints replaced by others with the same laws; None if the
        mechanism has to be assembled anew, or cannot be assembled.

        This is so if any joint belongs to none of :attr:`joints`, differs in its :func:`_kind`, contradicts
        itself, would start too deep in contact, or has a law with a parameter that is not finite. A number
        that passes these checks may differ from the former one by any factor.
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
            # An assembly refuses such a depth (m) at the start. A centred journal has one only if its start
            # state was given.
            if not loose.eccentricity - joint.clearance <= joint.deepest_start[0]:
                return None
            # The function that fills these rows in an assembly is called here, too, so that both have the
            # same bits.
            pair = joint.pair(*loose.materials).between(loose.effective_mass)
            blocks = touch_values(joint, joint.touchings(0.0)[0], pair)
            for row, values in zip(loose.rows, blocks, strict=True):
                state[row : row + len(values)] = values
        # A full assembly finds the same fault and explains it.
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
        """Return the step and its topology, which depend only on the parameters of contact laws; ``key`` are
        their bytes.
        """
        old = self.assembly
        # The original assembly is the first entry: a case with its numbers gets its step without choosing it
        # again.
        if not self.choices:
            self.choices[old.state[old.layout.rows_of("contact_slots")].tobytes()] = old.choice, old.topology
        if key in self.choices:
            return self.choices[key]
        # The step depends on the parameters of a contact and the masses at it, not on its place, which is
        # left out.
        touches = [
            touches_of(name, joint, NO_CONTACT, NO_CONTACT, 0.0)[0]
            for name, joint in mechanism.contacts.items()
        ]
        owners = [name for name, body in old.bodies.items() for _ in body.elements]
        free = 0 if old.mobility is None else old.mobility.after_drives
        topology = old.topology
        models = StepModels(
            [mechanism],
            old.layout,
            state[None],
            topology,
            [touches],
            owners,
            old.ideals,
            [self.expected],
            [free],
        )
        [choice] = choose_steps(models, request)
        if isinstance(choice, VfifeError):
            raise choice
        # Corrections of ideal joints follow from the step, and are part of the topology. Cases of one study
        # may therefore need more than one loop.
        if old.ideals:
            topology = topology.corrected(coarse(mechanism, choice, old.layout, state))
        if len(self.choices) < MOST_CHOICES:
            self.choices[key] = choice, topology
        return choice, topology


def _kind(joint: Any) -> tuple[Any, ...]:
    """Return the properties in which two joints must agree to be replaced by each other. Wear is one of them:
    worn profiles have rows of their own, which are not written here.
    """
    return joint.sides, type(joint.contact), type(joint.friction), joint.wear
