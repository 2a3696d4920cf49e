"""What has derivatives: refusals of mechanisms and runs that have none, the measures that patterns name, and
those that companions do not determine.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from fnmatch import fnmatchcase

from ...assembly.assemble import assemble
from ...assembly.entities import Numbering
from ...errors import Fault, ModelError, VfifeError, suggestion
from ...measures.catalogue import UNITS, Groups, differentiable
from ...measures.error_ranges import over_tries, ranged
from ...measures.repetition import part_of
from ...model.mechanism import Mechanism
from ...results.derivatives import Sensitivity
from ...results.run_data import standing
from ...simulation.result import Result
from ...solvers.companions import SENSITIVE
from ...solvers.record import Record
from ...solvers.status import Status
from ...solvers.transient import choose_loop
from ..spec.study_file import measure_names
from .rounding import floors, rounding


def refuse_unended(record: Record) -> None:
    """Raise VfifeError for a run that did not complete."""
    if record.status != Status.COMPLETE:
        message = f"the run ended as {record.status} after step {record.reached}"
        raise VfifeError(f"{message}, so it has no derivatives; see vfife run")


def refuse_unfit(mechanism: Mechanism, of: Sequence[str]) -> None:
    """Raise ModelError for a mechanism whose steps have no derivatives, and for measures that no run of it
    can have, before there is one.
    """
    if mechanism.settings.analysis == "static":
        message = "a static analysis has no steps that carry derivatives along"
        remedy = "vary the number with vfife study instead"
        raise ModelError([Fault("run.analysis", message, "static", "dynamic", remedy)], mechanism.name)
    if counts := [name for name in of if not differentiable(name)]:
        message = "it is counted over the whole run, so it has no derivatives"
        remedy = "vary numbers with vfife study, or rank clearances with vfife design"
        raise ModelError([Fault(f"of {name!r}", message, "", "", remedy) for name in counts], "sensitivity")
    special_patterns = [name for name in of if not fits(name.partition(".")[2], UNITS)]
    if not special_patterns and not Numbering(mechanism).elements:
        return
    assembly = assemble(mechanism)
    if choose_loop(assembly, "auto") != "generated":
        elements = len(assembly.topology.frame_nodes)
        message = (
            f"its {elements} elements are stepped by the data-driven loop, which carries no derivatives along"
        )
        remedy = "use fewer elements, or vary the number with vfife study"
        raise ModelError([Fault("body", message, "", "", remedy)], mechanism.name)
    matching("of", special_patterns, dict.fromkeys(measure_names(standing(assembly)), 0.0))


def fits(pattern: str, names: Iterable[str]) -> bool:
    """Return whether a pattern fits any name."""
    return any(fnmatchcase(name, pattern) for name in names)


def matching(argument: str, patterns: Sequence[str], values: Mapping[str, float]) -> dict[str, float]:
    """Return the values whose names fit any pattern. Raises ModelError with each pattern that fits none."""
    faults = []
    for pattern in patterns:
        if not fits(pattern, values):
            remedy = suggestion(pattern, values, "* stands for any characters")
            faults.append(Fault(f"{argument} {pattern!r}", "matches no name of this model", "", "", remedy))
    if faults:
        raise ModelError(faults, "sensitivity")
    return {
        name: value
        for name, value in values.items()
        if any(fnmatchcase(name, pattern) for pattern in patterns)
    }


def undetermined(
    result: Result, values: Mapping[str, float], names: Mapping[str, float], measures: Groups
) -> Sensitivity | None:
    """Return an answer without derivatives if companions disagree on all measures ``names`` of the run that
    are not zero; else None. ``values`` are those of all measures.
    """
    assembly, nonzero = result.record.assembly, {name: value for name, value in names.items() if value != 0.0}
    remainders = rounding(values, scales=floors(assembly, values)) & nonzero.keys()
    if not nonzero.keys() - remainders or len(doubtful(result, nonzero, measures)) < len(nonzero):
        return None
    significant = {name: value for name, value in nonzero.items() if name not in remainders}
    return Sensitivity(
        assembly.mechanism.name, significant, doubtful=frozenset(significant), rounding=remainders,
        part=part_of(result.record, None),
    )  # fmt: skip


def doubtful(result: Result, names: Iterable[str], measures: Groups) -> frozenset[str]:
    """Return the measures on which companions disagree by more than a run may that is not sensitive: their
    derivatives mean nothing.
    """
    ideal = None if result.reference is None else result.reference.measures
    ranges = (ranged if result.record.companions is None else over_tries)(result.record, ideal, measures)
    widths = {name: ranges[name].high - ranges[name].low for name in names if name in ranges}
    return frozenset(
        name for name, width in widths.items() if width > SENSITIVE * max(abs(ranges[name].value), 1e-300)
    )
