"""Start of a run: start state, ideal reference, and assemblies with any step from one solved start."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, TypeAlias, TypedDict, Unpack

from ..assembly.assemble import assemble, assemble_all
from ..assembly.assembled import CONTINUED, Assembly
from ..assembly.possible import Outlook, outlook
from ..assembly.timestep import CONTACT_STEPS, FIRST_CONTACT_STEPS
from ..errors import VfifeError
from ..job.cost import BRIEF, run_cost
from ..kinematics.batch import Shared, Structures
from ..kinematics.initial import Motion
from ..measures.catalogue import LOADS
from ..measures.error_ranges import own_ranges
from ..measures.trust import trust
from ..model.functions import repeats_each_turn, without_ideal
from ..model.mechanism import Mechanism
from ..results.continuation import (
    States,
    final_record,
    initial_state,
    on_clock,
    refuse_stateless,
    same_layout,
    step_of,
    with_last_state,
)
from ..results.run_data import RunData
from ..solvers.arguments import Loop
from ..solvers.companions import companion_count
from ..solvers.record import Record
from ..solvers.status import Status
from ..solvers.transient import choose_loop, run
from .result import Result

StartFrom: TypeAlias = Result | str | Path | States


class Span(TypedDict, total=False):
    """Length and outputs of a run, as arguments of ``assemble``."""

    turns: float | None
    duration: float | None
    outputs: int | None
    force_step: bool


def expected_forces(reference: Result | None) -> Mapping[str, float]:
    """Return the largest forces (N) of the ideal mechanism, by joint."""
    if reference is None:
        return {}
    return {
        name.removesuffix(".force.max"): value
        for name, value in own_ranges(reference.record, groups=(LOADS,)).items()
        if name.endswith(".force.max")
    }


def comparable(mechanism: Mechanism) -> bool:
    """Return whether there is an ideal mechanism for comparison turn by turn: clearance, a driver, and an
    ideal counterpart of every joint.
    """
    dynamic = mechanism.settings.analysis != "static"
    return dynamic and bool(mechanism.contacts) and not without_ideal(mechanism)


def ideal_of(
    mechanism: Mechanism,
    turns: float | None = None,
    duration: float | None = None,
    start: Result | States | None = None,
    motion: Motion | None = None,
) -> Assembly | None:
    """Return the assembled ideal mechanism, or None if it is not :func:`comparable`.

    One turn is enough if each turn is the same; otherwise it runs as long as the mechanism, from its
    ``start``. ``motion``: start of the mechanism, if solved before.
    """
    if not comparable(mechanism):
        return None
    ideal = mechanism.ideal()
    # An ideal mechanism repeats its first turn exactly if its drivers leave nothing free and all that acts on
    # it repeats, so one turn from any start suffices.
    if repeats_each_turn(mechanism):
        assembly = assemble(ideal, loop_of=mechanism, turns=1.0, motion=motion)
        if driven_throughout(assembly):
            return assembly
    state = None if start is None else initial_state(start, ideal)
    return assemble(
        ideal, loop_of=mechanism, turns=turns, duration=duration, start_state=state, motion=motion
    )


def driven_throughout(assembly: Assembly) -> bool:
    """Return whether drivers determine the whole motion of an ideal mechanism."""
    return assembly.mobility is None or assembly.mobility.after_drives == 0


def ideals_of(
    mechanisms: Sequence[Mechanism],
    turns: float,
    motions: Sequence[Motion | None],
    structures: Structures | None = None,
) -> list[Assembly | VfifeError | None]:
    """Return the assembled ideal mechanism of each of many mechanisms, the error of one that cannot be
    assembled, or None. ``motions``: their starts, if solved before.
    """
    assemblies: dict[int, Assembly | VfifeError | None] = {
        k: None for k, mechanism in enumerate(mechanisms) if not comparable(mechanism)
    }
    alike = {k: repeats_each_turn(mechanism) for k, mechanism in enumerate(mechanisms)}
    shared = Shared()
    # Two batches, since all mechanisms of a batch have one length: a turn if each is the same, else all.
    for length, repeats in ((1.0, True), (turns, False)):
        indices = [k for k in alike if k not in assemblies and alike[k] == repeats]
        models = [mechanisms[k] for k in indices]
        ideals = [mechanism.ideal(shared) for mechanism in models]
        assembled = assemble_all(
            ideals,
            None,
            expected=[{}] * len(indices),
            motions=[motions[k] for k in indices],
            loop_of=models,
            turns=length,
            structures=structures,
        )
        for k, ideal in zip(indices, assembled, strict=True):
            if repeats and isinstance(ideal, Assembly) and not driven_throughout(ideal):
                alike[k] = False  # runs in the second batch
            else:
                assemblies[k] = ideal
    return [assemblies[k] for k in range(len(mechanisms))]


@dataclass(frozen=True)
class Examination:
    """What is known of a mechanism before a run: its ``assembly`` with the step with which a run begins, the
    ``outlook`` of its motion, its ``ideal`` mechanism, the ``expected`` forces (N) by joint, and the
    ``contact_steps`` of the first try.
    """

    assembly: Assembly
    outlook: Outlook
    ideal: Assembly | None
    expected: Mapping[str, float]
    contact_steps: int


def examination(mechanism: Mechanism, force_step: bool = False) -> Examination:
    """Examine a mechanism; ``force_step`` permits a step that is larger than the stable one.

    Forces are those of its ideal mechanism; where that takes longer than ``vfife.job.cost.BRIEF``, the step
    follows from the contact laws alone.

    Raises AssemblyError where no position satisfies its joints or it jams on its way.
    """
    prospect = outlook(mechanism)
    ideal = ideal_of(mechanism) if prospect.passes else None
    brief = ideal is not None and run_cost(ideal).seconds <= BRIEF
    expected = expected_forces(referred(ideal)) if brief else {}
    steps = first_contact_steps(mechanism, mechanism.settings.companions)
    assembly = assemble(mechanism, expected=expected, contact_steps=steps, force_step=force_step)
    return Examination(assembly, prospect, ideal, expected, steps)


def referred(ideal: Assembly | None) -> Result | None:
    """Run an ideal mechanism and return its result; None without one. Raises KeyboardInterrupt on Ctrl-C."""
    if ideal is None:
        return None
    record = run(ideal)
    if record.status == Status.INTERRUPTED:
        raise KeyboardInterrupt
    return Result(record)


def reference_of(
    mechanism: Mechanism,
    turns: float | None = None,
    duration: float | None = None,
    start: Result | States | None = None,
) -> Result | None:
    """Return the result of the ideal mechanism (:func:`ideal_of`). Raises KeyboardInterrupt on Ctrl-C."""
    return referred(ideal_of(mechanism, turns, duration, start))


def first_contact_steps(mechanism: Mechanism, companions: int | str, loop: Loop = "auto") -> int:
    """Return the steps per half period of the stiffest contact with which an automatic step begins: fewer
    with companions, which detect a step that is too large.
    """
    looked = mechanism.contacts and companions and (companions != "auto" or loop in ("auto", "generated"))
    return FIRST_CONTACT_STEPS if looked else CONTACT_STEPS


def assembled_at(
    mechanism: Mechanism,
    step: float | str | None = None,
    start: Result | States | None = None,
    time: float | None = None,
    *,
    expected: Mapping[str, float] | None = None,
    contact_steps: int = CONTACT_STEPS,
    motion: Motion | None = None,
    **length: Unpack[Span],
) -> Assembly:
    """Return the mechanism assembled at its own start, at ``time`` (s, by default the end) of a former run,
    or at states by body name.

    ``motion``: its own start, if solved before. After a former run with the same layout the whole state
    continues, including element and contact forces.
    """
    if start is None:
        return assemble(
            mechanism, step, expected=expected, contact_steps=contact_steps, motion=motion, **length
        )
    # Positions and velocities come first, through the names of bodies, so that the model may have changed. If
    # it has not, the whole state replaces them, which keeps forces in elements and contacts.
    mechanism = on_clock(mechanism, start, time)
    state = initial_state(start, mechanism, time)
    assembly = assemble(
        mechanism, step, start_state=state, expected=expected, contact_steps=contact_steps, **length
    )
    record = final_record(start, time)
    if isinstance(start, RunData) and time is None:
        refuse_stateless(start.record, start.name, same_layout(assembly, start.record))
    return (
        with_last_state(assembly, record)
        if record is not None and same_layout(assembly, record)
        else assembly
    )


def former_errors(former: Result, assembly: Assembly) -> dict[str, Any]:
    """Return whether the ranges of a run with this ``assembly`` have the errors of the ``former`` run from
    which it goes on ``included``, for JSON; if not, the ``measure`` of that run, or of one before it, with
    the largest error, the share ``apart`` (1) by which its values differ, and whether it was ``sensitive``.

    They are included where its companions go on from those of the former run; where companions of an even
    earlier run were lost, its errors remain left out. An empty ``measure`` means that nothing was estimated.
    """
    earlier = former.arguments.get("former", {"included": True})
    if assembly.companion_states is not None and earlier["included"]:
        return {"included": True}
    estimate = trust(former.record, former.measures)
    error = {"measure": "", "apart": 0.0, "sensitive": False}
    if estimate is not None:
        error = {"measure": estimate.measure, "apart": estimate.apart, "sensitive": estimate.sensitive}
    worst = max(error, error | earlier, key=lambda entry: (not entry["measure"], entry["apart"]))
    return {**worst, "included": False}


def changed_clearances(former: Result, mechanism: Mechanism) -> list[str]:
    """Return the joints of a ``mechanism`` whose clearance is not that of the run from which it goes on."""
    clearances = {
        name: getattr(joint, "clearance", None)
        for name, joint in former.record.assembly.mechanism.contacts.items()
    }
    return [
        name
        for name, joint in mechanism.contacts.items()
        if name in clearances and getattr(joint, "clearance", None) != clearances[name]
    ]


def with_outlook(assembly: Assembly, prospect: Outlook) -> Assembly:
    """Return an assembly with the notes and cautions of the outlook of its motion."""
    notes = (*assembly.notes, *prospect.notes)
    return dataclasses.replace(assembly, notes=notes, missing_joints=prospect.missing_joints)


@dataclass(frozen=True)
class RunStart:
    """Start and length of a run: everything but the step.

    ``source``: a former run, or states by body name; ``outlook``: the solved start and notes on the motion;
    ``expected``: largest forces (N) of the ideal mechanism, by joint.
    """

    mechanism: Mechanism
    length: Span
    source: Result | States | None = None
    outlook: Outlook = field(default_factory=Outlook)
    expected: Mapping[str, float] = field(default_factory=dict)

    def assemble(self, step: float | str | None, contact_steps: int = CONTACT_STEPS) -> Assembly:
        """Return the mechanism assembled with a step (s), "auto", or None for that of its settings."""
        assembly = assembled_at(
            self.mechanism,
            step,
            self.source,
            expected=self.expected,
            contact_steps=contact_steps,
            motion=self.outlook.motion,
            **self.length,
        )
        return with_outlook(assembly, self.outlook)

    def first(self, step: float | str | None, loop: Loop, companions: int | str) -> Assembly:
        """Return the first try: with the given step, else that of the former run, else an automatic one.

        With companions an automatic step begins coarse, because they detect a step that is too large; a large
        frame has no companions.
        """
        # How many companions a run can have is known only after assembly, since large frames have none. So
        # the coarse step is assembled first, and replaced by the fine one if nobody would judge it.
        begin = first_contact_steps(self.mechanism, companions, loop)
        assembly = self.assemble(step, begin)
        former = (
            step_of(self.source.record, assembly)
            if isinstance(self.source, RunData) and step is None
            else None
        )
        if former is not None:
            assembly = self.assemble(former)
            choice = dataclasses.replace(assembly.choice, automatic=True, culprit=CONTINUED)
            return dataclasses.replace(assembly, choice=choice)
        if (
            begin != CONTACT_STEPS
            and assembly.choice.automatic
            and not companion_count(assembly, choose_loop(assembly, loop), companions)
        ):
            return self.assemble(step)
        return assembly


@dataclass(frozen=True)
class StaticStart:
    """Start of a static analysis: the mechanism without loads. It has no step."""

    mechanism: Mechanism

    def assemble(self, step: float | str | None = None) -> Assembly:
        """Return the assembled mechanism, with the cautions of a dynamic run about its numbers."""
        del step
        assembly = assemble(self.mechanism)
        return with_outlook(assembly, outlook(self.mechanism))


@dataclass(frozen=True)
class RestoredStart:
    """Start of the run of a file: its first output, length and largest ideal forces (N)."""

    record: Record
    length: Span
    expected: Mapping[str, float]
    started: bool  # whether it went on from another run

    def assemble(self, step: float | str | None) -> Assembly:
        """Return the mechanism assembled with another step (s)."""
        record, mechanism = self.record, self.record.assembly.mechanism
        if record.static or not self.started:
            return assembled_at(mechanism, step, expected=self.expected, **self.length)
        assembly = assemble(
            mechanism,
            step,
            start_state=initial_state(RunData(record), mechanism, 0.0),
            expected=self.expected,
            **self.length,
        )
        # The whole state is copied, because element and contact forces do not follow from positions.
        state = record.assembly.state.copy()
        state[assembly.layout["step"]] = assembly.choice.step
        return dataclasses.replace(
            assembly,
            state=state,
            tables=record.assembly.tables,
            companion_states=record.assembly.companion_states,
        )
