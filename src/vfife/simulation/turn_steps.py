"""Number of steps in a turn of the crank, common to all models of a map or a wear simulation."""

from __future__ import annotations

import math
from collections import OrderedDict
from collections.abc import Sequence

from ..assembly.assemble import assemble
from ..assembly.assembled import Assembly
from ..errors import Fault, ModelError, StepError
from ..model.functions import turn_of
from ..model.mechanism import Mechanism
from ..modelfile import dump
from ..solvers.arguments import RunArguments
from ..solvers.status import Status
from ..solvers.transient import choose_loop
from .simulate import prepare, run_prepared

# Turns of the run that finds a step. In ten turns a run notices that its turns do not repeat and halves its
# step less often.
SEARCH_TURNS = 10.0
MOST_COUNTS = 16
# Counts found so far, by models, step and search: a command needs them for its forecast first.
COUNTS: OrderedDict[tuple[tuple[str, ...], float | None, bool], int] = OrderedDict()


def with_steps(model: Mechanism, steps: int) -> Assembly:
    """Assemble a model with a number of steps in a turn and one output."""
    return assemble(model, (turn_of(model) or 0.0) / steps, turns=1, outputs=1, force_step=True)


def step_count(models: Sequence[Mechanism], step: float | None, search: bool = False) -> int:
    """Return a number of steps in a turn that suits all models.

    ``step`` (s) is the largest step, None the automatic one; with ``search`` the one to which a run refines
    it. Raises ModelError for a step with which a model is unstable.
    """
    key = tuple(dump(model) for model in models), step, search
    if key not in COUNTS:
        COUNTS[key] = max([_steps(model, step, search) for model in models])
        if len(COUNTS) > MOST_COUNTS:
            COUNTS.popitem(last=False)
    return COUNTS[key]


def _steps(model: Mechanism, step: float | None, search: bool) -> int:
    """Return the number of steps in a turn for one model."""
    if step is not None:
        refuse_unstable(model, step)
    elif search:
        step = run_step(model)
    else:
        step = prepare(model, RunArguments(turns=1.0, companions=0)).assembly.choice.step
    return math.ceil((turn_of(model) or 0.0) / step * (1.0 - 1e-9))


def run_step(model: Mechanism) -> float:
    """Find the step (s) to which ``vfife run`` refines the automatic one, by a run of ten turns.

    Raises ModelError for a model that is not stepped in straight-line code, KeyboardInterrupt if the run is
    interrupted.
    """
    prepared = prepare(model, RunArguments(turns=SEARCH_TURNS))
    refuse_large_frame(prepared.assembly)
    record = run_prepared(prepared).record
    if record.status == Status.INTERRUPTED:
        raise KeyboardInterrupt
    return record.assembly.choice.step


def refuse_large_frame(assembly: Assembly, refusal: str = "is not swept") -> None:
    """Raise ModelError for a frame that is too large for straight-line code."""
    if choose_loop(assembly, "auto") != "generated":
        raise ModelError(
            [Fault("body", f"a frame of so many elements {refusal}", "", "", "use fewer elements")],
            assembly.mechanism.name,
        )


def refuse_unstable(model: Mechanism, step: float) -> None:
    """Raise ModelError for a step (s) with which the model is unstable."""
    try:
        assemble(model, step, turns=1.0, outputs=1)
    except StepError as error:
        limit = str(error).partition(": ")[2].partition(";")[0]
        raise ModelError(
            [Fault("step", "this is not taken", f"{step:g} s", limit, "give another")], model.name
        ) from None
