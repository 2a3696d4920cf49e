"""What derivatives of a run will cost before it is begun: a run, and its steps with derivatives by each number."""

from __future__ import annotations

import os
import time
from fnmatch import fnmatchcase
from pathlib import Path
from typing import TYPE_CHECKING, Any

from .options import positive
from .terminal import counted, fail, span, tell

if TYPE_CHECKING:
    from ..assembly.assembled import Assembly
    from ..model.mechanism import Mechanism

EACH = 1.6  # of a lane's time for its own steps, that a number takes
SIZES = 2.8  # runs at the step and at 1.4, 1.7 and 2 times the step, in steps of the first
ASSEMBLIES = 6  # variants of a model by each number: two for its derivative, four finite changes
BATCH = 6e-4  # s that the assembly of one variant takes where many are assembled side by side
CHANGES = 4.0  # finite changes of each number, each at all step sizes


def one_by_one(assembly: Assembly) -> bool:
    """Whether variants are assembled one by one: elastic bodies, and blocks in guides with clearance, whose walls are laid for each."""
    return bool(assembly.topology.frame_nodes) or len(assembly.contacts) != len(set(assembly.contact_joints))


def told_of(
    mechanism: Mechanism, to: list[str], step: str | None, turns: float | None, duration: str | None, runs: int | None, force_step: bool,
    yes: bool, quiet: bool,
) -> None:  # fmt: skip
    """The forecast: a run, and its steps with derivatives by each number; and the end of what nobody can mean."""
    from ..assembly.assemble import assemble
    from ..codegen.native import CONTACT_LANES
    from ..errors import VfifeError
    from ..job.cost import Forecast, run_cost
    from ..modelfile.parameter import numbers

    asked: dict[str, Any] = {"turns": turns, "duration": None if duration is None else positive("--duration", duration, "s")}
    size = step if step in (None, "auto") else positive("--step", str(step), "s")
    try:
        assembly = assemble(mechanism, size, force_step=force_step, **asked)
    except (VfifeError, ValueError, ArithmeticError):  # told when it is run
        return
    began = time.process_time()
    if one_by_one(assembly):  # again, as the first one also loads what it needs
        assemble(mechanism, size, force_step=force_step, **asked)
    variant = max(time.process_time() - began, BATCH)
    count = sum(any(fnmatchcase(path, pattern) for pattern in to) for path, value in numbers(mechanism).items() if value)
    cores, lanes = os.cpu_count() or 1, CONTACT_LANES
    alone, displaced = run_cost(assembly), runs or 2 if assembly.contacts else 1
    each = EACH * (displaced + SIZES - 1.0) + CHANGES * SIZES
    seconds = alone.seconds * (1.0 + each * count / (lanes * cores)) + ASSEMBLIES * count * variant
    said = f"a run of {assembly.choice.steps:,} steps and {counted(count, 'number')} by which it has derivatives, each checked by finite changes"
    much = Forecast("run", seconds=seconds, memory=alone.memory).excess(Path())
    if much and not yes:
        remedy = "add --yes if that is meant, or ask for fewer numbers (--to) or turns"
        fail(f"{much}, for {said}; {remedy}. Nothing was begun.")
    if not quiet:
        automatic = ", more where an automatic step is halved" if assembly.choice.automatic else ""
        tell("forecast", f"{said}: {span(seconds)} with {counted(cores, 'thread')} of {lanes} lanes{automatic}.", "bold")
