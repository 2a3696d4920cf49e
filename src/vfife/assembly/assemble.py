"""Mechanism -> arrays: numbering, lumped masses, start positions and velocities; assemblies that differ in
clearance joints alone.
"""

from __future__ import annotations

import dataclasses
import itertools
from collections.abc import Iterable, Mapping, Sequence
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..errors import VfifeError
from ..kernels.arrays import layout_of
from ..kernels.topology import Topology
from ..kinematics.batch import Batch, Structures
from ..kinematics.drives import standing
from ..kinematics.initial import Motion, attempt, ideal_motions, in_batches, seats_of
from ..kinematics.start import Seat, StartState
from ..laws import ContactLaw, FrictionLaw, Law, Pair
from ..laws.check import try_out
from ..laws.law import built_in
from ..model.geometry.polynomials import Polynomials
from ..model.joints import Contact, Joint
from ..model.joints.gear import gear_cautions
from ..model.mechanism import Mechanism
from ..model.surfaces import cautions, surfaces
from ..model.validation.plausibility import contradictions
from .assembled import Assembly, StepChoice
from .checks import (
    missed,
    off_angle,
    other_outputs,
    outside_tables,
    redundant,
    refuse_deep,
    refuse_idle,
    refuse_infinite,
    refuse_static,
    refuse_stuck,
    shared,
)  # fmt: skip
from .entities import Numbering, Parts, parts_of, turning
from .fill import Draft, Filler, touch_values
from .prestress import is_prestressed, prestress
from .stability import turning_errors
from .timestep import StepModels, StepRequest, choose_steps, coarse, length_of

Array = NDArray[np.float64]


def forms(base: type[Law], used: Iterable[Law]) -> tuple[type[Law], ...]:
    """Return the law classes between which the data-driven loop can choose: the common ones, so that one
    compilation serves most models, and those in ``used``.

    Laws that differ in their parameters only are one class. The order does not depend on that of
    the joints.
    """
    common = tuple(law for law in base.registry.values() if law.common)
    return _forms(common, frozenset(map(type, used)))


@lru_cache(maxsize=64)
def _forms(common: tuple[type[Law], ...], used: frozenset[type[Law]]) -> tuple[type[Law], ...]:
    """Forms of the common laws and of those in use, each in the order of their names."""
    first = {law.form() for law in common}
    second = {law.form() for law in used} - first
    return tuple(sorted(first, key=_spelled)) + tuple(sorted(second, key=_spelled))


def _spelled(form: type[Law]) -> str:
    return f"{form.__module__}.{form.__qualname__}"


def assemble(
    mechanism: Mechanism,
    step: float | str | None = None,
    *,
    expected: Mapping[str, float] | None = None,
    loop_of: Mechanism | None = None,
    start_state: StartState | None = None,
    motion: Motion | None = None,
    **run: Any,
) -> Assembly:
    """Numbers the mechanism and fills its arrays.

    ``step``: s, or "auto"; None takes the mechanism's setting. ``expected``: largest force (N) each joint is
    expected to carry, for the stable step. ``start_state``: a start from known positions. ``motion``: the
    start, solved before (:func:`ideal_motion`). ``loop_of``: a mechanism whose laws the loop can do as well,
    so that both share one compilation. ``run``: ``turns``, ``duration``, ``outputs``, ``force_step`` override
    the settings. Raises VfifeError (AssemblyError where links cannot reach, StepError where the step is too
    large, LawError where a law of the user's own cannot be used) with a sentence that names what is wrong.
    """
    [result] = assemble_all(
        [mechanism],
        step,
        expected=[expected or {}],
        loop_of=[loop_of],
        start_state=start_state,
        motions=[motion],
        **run,
    )
    if isinstance(result, VfifeError):
        raise result
    return result


def assemble_all(
    mechanisms: Sequence[Mechanism],
    step: float | str | None,
    *,
    expected: Sequence[Mapping[str, float]],
    motions: Sequence[Motion | None],
    loop_of: Sequence[Mechanism | None] | None = None,
    start_state: StartState | None = None,
    structures: Structures | None = None,
    **run: Any,
) -> list[Assembly | VfifeError]:
    """Assemble many mechanisms, each with its expected forces (N) and its start; the error of one that cannot
    be assembled stands in its place. ``structures``: of mechanisms that are known already.

    States of mechanisms of one topology are filled for all of them at once.
    """
    result: dict[int, Assembly | VfifeError] = {}
    outlines: dict[int, Outline] = {}
    drafts: dict[int, Draft] = {}

    def outlined(batch: Batch, members: Sequence[int]) -> list[Outline]:
        return outlines_of(batch, [loop_of[k] if loop_of else None for k in members])

    structures = structures or Structures()
    for k, entry in enumerate(in_batches(mechanisms, outlined, structures)):
        (result if isinstance(entry, VfifeError) else outlines)[k] = entry  # type: ignore[assignment]
    with np.errstate(over="ignore", invalid="ignore"):
        for k, entry in seated(outlines, motions, structures).items():
            if isinstance(entry, VfifeError):
                result[k] = entry
                del outlines[k]
            else:
                outlines[k] = entry
        started = ideal_motions(
            [outline.start for outline in outlines.values()],
            seats=[outline.seats for outline in outlines.values()],
            former=[motions[k] for k in outlines],
            start_state=start_state,
            structures=structures,
        )
    topologies: dict[Any, Topology] = {}
    for (k, outline), start in zip(outlines.items(), started, strict=True):
        draft = attempt(draft_of, outline, start, start_state, topologies)
        (result if isinstance(draft, VfifeError) else drafts)[k] = draft  # type: ignore[assignment]
    # Equal topologies are one object; its identity takes less time than a hash of all its integers.
    groups: dict[tuple[int, tuple[str, ...]], list[int]] = {}
    for k, draft in drafts.items():
        groups.setdefault((id(draft.topology), draft.motion.names), []).append(k)
    request = StepRequest(step, **run)
    for members in groups.values():
        topology = drafts[members[0]].topology
        layout = layout_of(topology)
        filler = Filler([drafts[k] for k in members], layout)
        states = filler.states
        turning = turning_errors(layout, states, topology) if topology.joint_bearing else None
        models = filler.step_models([expected[k] for k in members], turning)
        choices = choose_steps(models, request)
        for case, excess in enumerate(redundant(layout, states, topology)):
            case_topology, k = (
                dataclasses.replace(topology, redundant=True) if excess else topology,
                members[case],
            )
            result[k] = attempt(finished, filler, models, case, case_topology, choices[case], request)
    return [result[k] for k in range(len(mechanisms))]


class Outline(NamedTuple):
    """What is known of a mechanism before its start is solved: the mechanism that is to be closed at the
    ``start``, ``laws`` that the loop can tell apart, the surfaces of contacts as ``pairs``, and the ``seats``
    of its journals. Mechanisms of one structure have one numbering ``like`` theirs.
    """

    mechanism: Mechanism
    start: Mechanism
    numbering: Numbering
    laws: list[tuple[type[Law], ...]]
    pairs: dict[str, Pair]
    seats: dict[str, Seat]
    like: Numbering


def outlines_of(batch: Batch, loop_of: Sequence[Mechanism | None]) -> list[Outline]:
    """Return the outlines of mechanisms of one structure. Raises VfifeError if one cannot be assembled."""
    first = batch.first
    for mechanism in batch.mechanisms:
        refuse_static(mechanism)
    refuse_idle(first)
    numbering = Numbering(first, batch.shared)
    numberings = [numbering, *(numbering.alike(mechanism) for mechanism in batch.mechanisms[1:])]
    names = tuple(first.contacts)
    pairs = {name: surfaces_of(batch, name) for name in names}
    result = []
    for k, (mechanism, loop) in enumerate(zip(batch.mechanisms, loop_of, strict=True)):
        laws = batch.shared(_laws, mechanism.joints, *([] if loop is None else [loop.joints]))
        own_pairs = {name: pairs[name][k] for name in names}
        # The loop of an ideal mechanism contains the laws of the mechanism that it belongs to.
        used = [
            (law, surfaces(user, joint))
            for user in (mechanism, *([] if loop is None else [loop]))
            for joint in user.contacts.values()
            for law in (joint.contact, joint.friction)
            if not built_in(type(law))
        ]
        if used:
            try_out(used, *laws)
        result.append(Outline(mechanism, standing(mechanism), numberings[k], laws, own_pairs, {}, numbering))
    return result


def _laws(*joints: Mapping[str, Joint]) -> list[tuple[type[Law], ...]]:
    """Return the contact laws and the friction laws that a loop can tell apart for these joints."""
    lawful = [
        joint
        for joints_of_mechanism in joints
        for joint in joints_of_mechanism.values()
        if isinstance(joint, Contact)
    ]
    return [
        forms(ContactLaw, [joint.contact for joint in lawful]),
        forms(FrictionLaw, [joint.friction for joint in lawful]),
    ]


def surfaces_of(batch: Batch, name: str) -> list[Pair]:
    """Return the surfaces of a joint with clearance in each mechanism."""
    joint = batch.first.joints[name]
    columns = [batch.column("bodies", body) for body, _ in joint.sides if body != "ground"]
    if all(column.index is None for column in (*columns, batch.column("joints", name))):
        return [surfaces(batch.first, joint)] * len(batch)  # type: ignore[arg-type]
    return [surfaces(mechanism, mechanism.joints[name]) for mechanism in batch.mechanisms]  # type: ignore[arg-type]


def seated(
    outlines: Mapping[int, Outline], motions: Sequence[Motion | None], structures: Structures
) -> dict[int, Outline | VfifeError]:
    """Return the outlines whose starts ask for seated journals, with the seats; the error of one without an
    ideal motion stands in its place. ``motions``: starts of all mechanisms, if solved before.
    """

    def placed(outline: Outline, ideal: Motion | VfifeError) -> Outline:
        if isinstance(ideal, VfifeError):
            raise ideal
        return outline._replace(seats=seats_of(outline.mechanism, ideal))

    seat_outlines = {
        k: outline
        for k, outline in outlines.items()
        if outline.mechanism.start.journals == "seated" and outline.mechanism.clearances
    }
    ideals = ideal_motions(
        [outline.mechanism for outline in seat_outlines.values()],
        former=[motions[k] for k in seat_outlines],
        structures=structures,
    )
    return {
        k: attempt(placed, seat_outlines[k], ideal) for k, ideal in zip(seat_outlines, ideals, strict=True)
    }


def draft_of(
    outline: Outline,
    motion: Motion | VfifeError,
    start_state: StartState | None,
    topologies: dict[Any, Topology],
) -> Draft:
    """Create the entities of a mechanism with the ``motion`` of its start; ``topologies`` are those of former
    mechanisms. Raises VfifeError.
    """
    if isinstance(motion, VfifeError):
        raise motion
    mechanism, _, numbering, laws, pairs, seats, like = outline
    refuse_infinite(motion)
    if not numbering.meshes:  # what is held as rigid may still bend
        refuse_stuck(motion)
    parts = parts_of(mechanism, numbering, motion)
    functions = numbering.functions
    starts, tables = numbering.shared.recall("tables", functions, lambda: tables_of(functions))
    key = id(like), tuple(laws), parts.structure, starts, tuple(numbering.arguments)
    if key not in topologies:
        topologies[key] = topology_of(mechanism, numbering, parts, laws, starts)
    topology = topologies[key]
    contacts = [touch_values(touch.joint, touch.touching, pairs[touch.joint.name]) for touch in parts.touches]
    stressed = prestress(mechanism, seats) if is_prestressed(mechanism) and start_state is None else None
    lengths = {} if start_state is None else motion.datum.spring
    notes = off_angle(mechanism, motion) if start_state is None else ()
    return Draft(
        mechanism, motion, numbering, parts, contacts, tables, topology, seats, lengths, stressed, notes
    )


def finished(
    filler: Filler,
    models: StepModels,
    case: int,
    topology: Topology,
    choice: StepChoice | VfifeError,
    request: StepRequest,
) -> Assembly:
    """Return the assembly of a case with its step. Raises StepError, and VfifeError where a contact starts
    too deep.
    """
    draft, layout, state = filler.drafts[case], filler.layout, filler.states[case].copy()
    mechanism, numbering, parts = draft.mechanism, draft.numbering, draft.parts
    refuse_deep(parts.touches, filler.depths[case])
    if isinstance(choice, VfifeError):
        raise choice
    ideals = models.ideals
    if parts.ideals:
        topology = topology.corrected(coarse(mechanism, choice, layout, state))
    state[layout.row("step")], state[layout.row("damping")] = choice.step, mechanism.settings.damping
    shared_notes = numbering.shared.recall
    materials = [body.material for body in mechanism.bodies.values()]
    usual = shared_notes("surfaces", (mechanism.joints, *materials), lambda: cautions(mechanism))
    strange = shared_notes("loads", (mechanism.loads,), lambda: _load_cautions(mechanism))
    notes = (
        usual + draft.notes + contradictions(mechanism) + strange + missed(mechanism, choice, layout, state)
    )
    notes += tuple(misfit.text for misfit in draft.motion.misfits)
    notes += gear_cautions(mechanism.gears) + outside_tables(mechanism, choice)
    if not choice.automatic:
        length = length_of(mechanism, request.turns, request.duration, choice.turn)
        notes += other_outputs(mechanism, choice, length)
    pivots = tuple(joint.name for joint in numbering.pivots.values())
    return Assembly(
        mechanism, topology, layout, state, draft.tables, numbering.bodies,
        tuple(t.name for t in parts.touches), tuple(ideals), pivots, choice, tuple(mechanism.springs),
        tuple(t.joint.name for t in parts.touches), draft.motion.mobility, notes,
        shared=shared(layout, state, topology, ideals, pivots, numbering.driven),
    )  # fmt: skip


def _load_cautions(mechanism: Mechanism) -> tuple[str, ...]:
    return tuple(sentence for load in mechanism.loads.values() for sentence in load.cautions())


_topology = lru_cache(maxsize=64)(Topology)  # one object for all that are equal, which is soon compared


def topology_of(
    mechanism: Mechanism,
    numbering: Numbering,
    parts: Parts,
    laws: list[tuple[type[Law], ...]],
    functions: tuple[int, ...],
) -> Topology:
    """State which particles, joints, contacts, springs and functions are connected, as integers."""
    paths, knots = parts.numbered(), tuple(len(t.joint.contact.knots()) for t in parts.touches)
    return _topology(
        particles=numbering.count,
        free=tuple(numbering.free),
        trig=turning(numbering, parts),
        frame_nodes=tuple(numbering.elements),
        frame_release=tuple(numbering.releases),
        frame_strain=tuple(numbering.strains),
        contact_bearing=tuple(t.bearing[0] for t in parts.touches),
        contact_journal=tuple(t.journal[0] for t in parts.touches),
        contact_kind=tuple(t.kind for t in parts.touches),
        contact_path=paths[len(parts.ideals) :],
        guides=guides_of(parts),
        contact_knots=knots if any(knots) else (),
        wears=tuple(k for k, t in enumerate(parts.touches) if t.joint.wear is not None),
        profiles=profiles_of(parts),
        contact_form=tuple(laws[0].index(t.joint.contact.form()) for t in parts.touches),
        friction_form=tuple(laws[1].index(t.joint.friction.form()) for t in parts.touches),
        joint_bearing=tuple(j.bearing[0] for j in parts.ideals),
        joint_journal=tuple(j.journal[0] for j in parts.ideals),
        joint_place=tuple(j.restraint.place for j in parts.ideals),
        joint_turn=tuple(j.restraint.turn for j in parts.ideals),
        joint_path=paths[: len(parts.ideals)],
        path_pieces=tuple(len(path.pieces) for path in parts.paths),
        joint_carrier=tuple(j.carrier for j in parts.ideals),
        joint_function=tuple(j.function for j in parts.ideals),
        joint_actuator=actuators_of(parts),
        spring_first=tuple(s[2][0] for s in parts.springs),
        spring_second=tuple(s[3][0] for s in parts.springs),
        spring_kind=tuple(s[1] for s in parts.springs),
        driven=tuple(numbering.driven_particle(name) for name in numbering.driven),
        driven_function=parts.driven,
        load_particle=tuple(load.place[0] for load in parts.loads),
        load_function=tuple(load.function for load in parts.loads),
        load_follow=tuple(load.follow for load in parts.loads),
        body_nodes=tuple((b.particles[0], b.particles[-1]) for b in numbering.bodies.values()),
        function_start=functions,
        function_argument=tuple(numbering.arguments),
        path_unit=mechanism.settings.path_unit,
        damped=mechanism.settings.damping > 0.0 or mechanism.settings.analysis == "static",
        weightless=not any(mechanism.gravity),
        contact_laws=laws[0],
        friction_laws=laws[1],
    )


def actuators_of(parts: Parts) -> tuple[int, ...]:
    """Index of the actuator of each ideal joint, -1 for none; nothing where no joint has one."""
    count = itertools.count()
    indices = tuple(-1 if joint.function < 0 else next(count) for joint in parts.ideals)
    return indices if max(indices, default=-1) >= 0 else ()


def guides_of(parts: Parts) -> tuple[tuple[int, int], ...]:
    """First contact, and the one after the last, of each joint that has several: the corners of a block in
    its guide.
    """
    joints = [touch.joint.name for touch in parts.touches]
    return tuple(
        (joints.index(name), joints.index(name) + joints.count(name))
        for name in dict.fromkeys(joints)
        if joints.count(name) > 1
    )


def profiles_of(parts: Parts) -> tuple[tuple[int, int], ...]:
    """How many harmonics the worn profiles of each contact have; nothing where all surfaces are round."""
    counts = tuple(touch.harmonics for touch in parts.touches)
    return counts if any(map(any, counts)) else ()


def tables_of(functions: list[Polynomials]) -> tuple[tuple[int, ...], NDArray[np.float64]]:
    """Start of each function's table, and all of them in one array."""
    starts, parts, at = [], [np.zeros(1)], 1
    for function in functions:
        table = function.table()
        starts.append(at)
        parts.append(table)
        at += len(table)
    return tuple(starts), np.concatenate(parts)
