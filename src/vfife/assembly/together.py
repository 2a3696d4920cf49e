"""Members that differ in numbers, assembled side by side: one walk through their nouns, whose numbers are those of all of them.

What comes out is what :func:`~vfife.assembly.assemble.assemble` makes of each, to the bit. Where members are not to be treated alike, or a number
reaches what is made mechanism by mechanism, ``Differing`` or ``Alone`` says so, and each is assembled by itself.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Mapping
from functools import partial
from typing import Any

import numpy as np

from ..errors import StepError
from ..fields.members import Alone, Members
from ..fields.members import chosen as of_member
from ..kernels.topology import Topology
from ..kinematics.initial import driven_start
from ..kinematics.mobility import Mobility
from ..model.functions import turn_of
from ..model.mechanism import Mechanism
from .assemble import filled, tables_of, topology_of
from .assembled import Assembly, BodyMap
from .checks import refuse_idle, refuse_infinite
from .entities import parts_of
from .fill import Filler
from .numbering import Numbering
from .prescribed import prescribed
from .redundancy import redundant
from .timestep import Bounds, bounds, chosen, coarseness, length_of, size_of, spin_of


class MemberAssembly(Assembly):
    """One of many: its nouns are made when somebody asks for them."""

    picked: Mapping[str, Callable[[], Any]]

    def __getattr__(self, name: str) -> Any:
        if name not in ("mechanism", "bodies"):
            raise AttributeError(name)
        value = self.picked[name]()
        object.__setattr__(self, name, value)
        return value


class Together:
    """Assembles mechanisms that differ in numbers from one that was assembled with the same ``step`` and ``run``.

    ``met`` remembers closed positions, for several of them.
    """

    def __init__(self, base: Assembly, step: float | str | None, met: dict[Any, Any] | None = None, **run: Any) -> None:
        self.base, self.step, self.run, self.met = base, step, run, met
        self.topologies: dict[int, Topology] = {base.topology.coarse: base.topology}
        self.plain = dataclasses.replace(base.topology, coarse=0)
        laws = [base.topology.contact_laws, base.topology.friction_laws]
        self.laws: list[Any] = laws

    def assembled(
        self,
        mechanism: Mechanism,
        count: int,
        expected: Mapping[str, Any] | None = None,
        steps: Members | None = None,
        one_of: Callable[[int], Mechanism] | None = None,
    ) -> list[Assembly | None]:
        """All of them; ``mechanism`` has numbers of :mod:`members <vfife.fields.members>`, ``expected`` is as assemble takes it.

        ``steps``: one (s) for each; ``one_of`` makes the mechanism of one. None stands for a member that is refused its step.
        """
        refuse_idle(mechanism)
        if len(self.base.topology.frame_nodes):
            raise Alone("elastic bodies start mechanism by mechanism")
        numbering = Numbering(mechanism)
        with np.errstate(all="ignore"):
            motion = driven_start(mechanism, self.met)
            refuse_infinite(motion)
            parts = parts_of(mechanism, numbering, motion)
            starts, tables = tables_of(numbering.functions)
            topology = topology_of(mechanism, numbering, parts, self.laws, starts)
            if (topology, len(tables)) != (self.plain, len(self.base.tables)):
                raise Alone("another topology")
            filler = filled(Filler(mechanism, numbering, self.base.layout, motion, None, count=(count,)), parts, tables)
            if redundant(filler.layout, filler.state, topology):
                raise Alone("joints hold more than there is to hold")
            freedom = motion.system.starts[-1]
            columns = 3 * (len(motion.names) - 1)
            mobility = Mobility(columns - motion.system.held, columns - freedom, 0, ())
            if mobility.after_drives:
                raise Alone("free motions have a period of their own")
            names = [joint.name for joint in parts.ideals]
            found = bounds(mechanism, filler.layout, filler.state, topology, parts.touches, expected, (), names)
        filler.put("damping", mechanism.settings.damping)
        ends = _Ends(self, mechanism, one_of or partial(of_member, mechanism), numbering, filler, mobility, tables)
        sizes = [None] * count if steps is None else steps.tolist()
        return [ends.tried(k, one, size) for k, (one, size) in enumerate(zip(found.each(count), sizes, strict=True))]

    def topology(self, coarse: int) -> Topology:
        """That of so many corrections more."""
        if coarse not in self.topologies:
            self.topologies[coarse] = dataclasses.replace(self.base.topology, coarse=coarse)
        return self.topologies[coarse]


class _Ends:
    """Picks members out of what was made of all."""

    def __init__(
        self, together: Together, mechanism: Mechanism, one_of: Callable[[int], Mechanism], numbering: Numbering, filler: Filler,
        mobility: Mobility, tables: Any,
    ) -> None:  # fmt: skip
        self.together, self.mechanism, self.one_of, self.tables = together, mechanism, one_of, tables
        self.bodies = numbering.bodies
        self.other = [name for name, body in self.bodies.items() if of_member(body, 0) is not body]
        self.kept = {name: value for name, value in vars(together.base).items() if name not in ("mechanism", "bodies")}
        self.state, self.row = np.ascontiguousarray(filler.state.view(np.ndarray)), filler.layout.row("step")
        self.mobility, self.moving = mobility, together.base.layout["particle_w"]
        turn: Any = turn_of(mechanism)
        self.turns_each = turn.tolist() if isinstance(turn, Members) else [turn] * len(self.state)
        for noun in (*mechanism.loads.values(), *(one for one in mechanism.drivers.values() if one.steady_speed is None)):
            if of_member(noun, 0) is not noun:
                raise Alone("a function of time of its own")
        self.told = bool(mechanism.loads) or any(one.steady_speed is None or not one.revolves for one in mechanism.drivers.values())
        run = dict(together.run)
        self.turns, self.duration = run.pop("turns", None), run.pop("duration", None)
        self.outputs, self.force = run.pop("outputs", None), run.pop("force_step", False)
        self.contact_steps = run

    def tried(self, k: int, found: Bounds, step: float | None) -> Assembly | None:
        """One of them; None where its step is refused."""
        try:
            return self.of(k, found, step)
        except StepError:
            return None

    def of(self, k: int, found: Bounds, step: float | None) -> Assembly:
        """One of them."""
        together, mechanism, state = self.together, self.mechanism, self.state[k]
        turn = self.turns_each[k]
        length = length_of(mechanism, self.turns, self.duration, turn)
        told = partial(self._told, k, length) if self.told else partial(iter, ())
        choice = chosen(
            mechanism.settings, found, turn, length, math.inf, told, together.step if step is None else step, self.outputs, self.force,
            **self.contact_steps,
        )  # fmt: skip
        topology = together.base.topology
        if together.base.ideals:
            topology = together.topology(coarseness(choice, spin_of(turn, mechanism, together.base.layout, state)))
        state[self.row] = choice.step
        one = object.__new__(MemberAssembly)
        vars(one).update(self.kept)
        picked = {"mechanism": partial(self.one_of, k), "bodies": partial(self._bodies, k)}
        vars(one).update(
            state=state, choice=choice, topology=topology, mobility=self.mobility, tables=self.tables, notes=(), picked=picked
        )  # fmt: skip
        return one

    def _bodies(self, k: int) -> dict[str, BodyMap]:
        return {**self.bodies, **{name: of_member(self.bodies[name], k) for name in self.other}}

    def _told(self, k: int, length: float) -> Any:
        mechanism = self.one_of(k)
        spin = spin_of(None, mechanism, self.together.base.layout, self.state[k])
        return prescribed(mechanism, length, spin, size_of(mechanism))
