"""Simulates a mechanism: assembles it at its start, runs it beside its ideal reference, gives the result."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias

from .assembly.assemble import assemble
from .assembly.assembled import Assembly
from .model.drivers import ConstantSpeed, Torque
from .model.mechanism import Mechanism
from .model.validate import validate
from .solvers.progress import Progress
from .solvers.record import Record, recorded_rows
from .solvers.transient import Loop, choose_loop, run

if TYPE_CHECKING:
    from .result import Result
    from .results.runfile import RunFile

StartFrom: TypeAlias = "Result | str | Path | Mapping[str, Any] | None"


def expected_forces(reference: Result | None) -> Mapping[str, float]:
    """Largest forces of the ideal mechanism, by joint."""
    if reference is None:
        return {}
    return {name.removesuffix(".force.max"): value for name, value in reference.measures.items() if name.endswith(".force.max")}


def reference_of(mechanism: Mechanism, turns: float | None = None, duration: float | None = None) -> Result | None:
    """The ideal mechanism, where a driver makes it comparable turn by turn: one turn at constant speed, else as long as the run."""
    if mechanism.settings.analysis == "static":
        return None
    moving = [driver for driver in mechanism.drivers.values() if not isinstance(driver, Torque)]
    if not mechanism.contacts or not moving or len(mechanism.ideal().joints) < len(mechanism.joints):
        return None
    if all(isinstance(driver, ConstantSpeed) for driver in moving):
        turns, duration = 1.0, None
    from .result import Result

    return Result(run(assemble(mechanism.ideal(), beside=mechanism, turns=turns, duration=duration)))


def simulate(
    mechanism: Mechanism,
    *,
    turns: float | None = None,
    duration: float | None = None,
    step: float | str | None = None,
    outputs: int | None = None,
    loop: Loop = "auto",
    reference: bool | Result = True,
    force_step: bool = False,
    progress: Callable[[Progress], None] | None = None,
    file: RunFile | None = None,
    start: StartFrom = None,
) -> Result:
    """Simulates a mechanism.

    ``turns`` of the crank or ``duration`` (s); ``step`` (s) or "auto"; ``outputs`` per turn (per run without a crank); ``loop`` "auto",
    "data-driven", "generated" or "interpreted", which give the same bits; ``reference``: also run the ideal mechanism to compare with.
    An automatic step is halved, three times at the most, while first contacts land deeper than a joint allows. A mechanism whose settings ask for
    a static analysis is brought to equilibrium instead (:func:`~vfife.solvers.statics.equilibrium`), which takes neither ``turns``,
    ``duration`` nor ``step``. ``start``: a former run (or its folder) to go on from, or states of bodies by name
    (:func:`~vfife.results.start_from.start_from`). Raises ValueError,
    all faults at once, for a mechanism that cannot be assembled and StepError for too large a step.
    """
    from .result import Result
    from .results.provenance import provenance

    validate(mechanism)
    if mechanism.settings.analysis == "static":
        from .solvers.statics import equilibrium

        given = {"turns": turns, "duration": duration, "step": step}
        asked: Any = {name: value for name, value in given.items() if value is not None}
        still = dataclasses.replace(mechanism, settings=dataclasses.replace(mechanism.settings, **asked))
        return Result(equilibrium(assemble(still), loop=loop, progress=progress, file=file))
    ideal = reference if not isinstance(reference, bool) else reference_of(mechanism, turns, duration) if reference else None
    expected = expected_forces(ideal)
    options: dict[str, Any] = {"turns": turns, "duration": duration, "outputs": outputs, "force_step": force_step}
    assembly = assembled_at(mechanism, step, start, expected=expected, **options)
    record = run(assembly, loop=loop, progress=progress, file=file)
    tries = 3 if assembly.choice.automatic else 0
    while tries and record.status == "complete" and _too_deep(record):
        tries -= 1
        assembly = assembled_at(mechanism, 0.5 * assembly.choice.step, start, expected=expected, **options)
        if file is not None:
            file.begin(provenance(assembly, recorded_rows(assembly), choose_loop(assembly, loop)))
        record = run(assembly, loop=loop, progress=progress, file=file)
    return Result(record, ideal)


def assembled_at(
    mechanism: Mechanism, step: float | str | None = None, start: StartFrom = None, time: float | None = None, **options: Any
) -> Assembly:
    """The assembled mechanism at its own start, or where a former run was at ``time`` (s; its end unless given), or at states given by name.

    A run that ended and is cut alike goes on with its whole state, element and contact forces with it.
    """
    if start is None:
        return assemble(mechanism, step, **options)
    from .result import Result
    from .results.restart import restart_record, restarted, same_layout
    from .results.start_from import initial_state

    if isinstance(start, str | Path):
        start = Result.load(start)
    assembly = assemble(mechanism, step, given=initial_state(start, mechanism, time), **options)
    record = restart_record(start, time)
    return restarted(assembly, record) if record is not None and same_layout(assembly, record) else assembly


def _too_deep(record: Record) -> bool:
    """Whether a first contact landed deeper than its joint allows."""
    return bool(record.assembly.contacts) and bool(record.block("contact_deep")[-1].any())
