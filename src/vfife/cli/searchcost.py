"""What a search will cost before it is begun: how many members it asks for is known, or about so many, and some of them are looked at."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from .forecast import LOOKED_AT, refuse_absurd, sought, tell_forecast
from .slopecost import EACH
from .terminal import counted, sentences, span, tell

if TYPE_CHECKING:
    from ..model.mechanism import Mechanism
    from ..study.optimise import Axis, Search
    from ..study.plan import Plan
    from ..study.searches import Allotment

CHOSEN = (2e-3, 6e-6), (6e-4, 0.0)  # s for a member, and for each other one; of Parzen estimators, of NSGA-II; measured with three parameters
DISPLACED = 2  # runs of which derivatives are the mean
SHARES = tuple((k + 0.5) / LOOKED_AT for k in range(LOOKED_AT))  # of the way through what varies


def told_of_search(plan: Plan, base: Mechanism, search: Search, target: Path, yes: bool, quiet: bool, anew: bool) -> None:
    """The forecast of an optimisation, and the end of what nobody can mean."""
    from ..study.searches import numbers_at

    chosen = [numbers_at(plan.parameters, {axis.name: along(axis, share) for axis in search.axes}) for share in SHARES]
    with sentences(str(target)):
        found = sought(chosen, search.members, search.batch, base, plan.asked, target, anew)
        more = refinement(plan, search, chosen, base)
    found["seconds"] += choosing(search) + more
    refuse_absurd(found, target, yes, "search")
    if found["members"] and not quiet:
        tell_forecast(found, target, plan)
    if more and not quiet:
        tell("forecast", f"up to {counted(search.refine, 'member')} more by derivatives, in at most {span(more)} of that.", "bold")


def refinement(plan: Plan, search: Search, chosen: Sequence[dict[str, float | str]], base: Mechanism) -> float:
    """Time (s) of the members that derivatives lead to, each with derivatives of its own: two runs, and its steps with derivatives."""
    from ..codegen.native import CONTACT_LANES
    from ..errors import VfifeError
    from ..job.cost import run_cost
    from ..study.local_search import refuses
    from .forecast import member

    if not search.refine or refuses(search):
        return 0.0
    names = {axis.name for axis in search.axes if axis.continuous}
    paths = sum(len(one.paths) for one in plan.parameters if one.name in names)
    for one in chosen:
        try:
            assembly = member(base, one, plan.asked)
        except VfifeError:  # told when it is run
            continue
        directions = EACH * paths * (DISPLACED if assembly.contacts else 1) / CONTACT_LANES
        alone = run_cost(assembly).seconds
        return search.refine * alone * (3.0 + directions)
    return 0.0


def choosing(search: Search) -> float:
    """Time (s) that the search itself takes to choose its members; those that are kept are chosen again."""
    first, more = CHOSEN[len(search.aims) > 1]
    return search.members * (first + more * search.members)


def told_of_allotment(plan: Plan, base: Mechanism, task: Allotment, target: Path, yes: bool, quiet: bool, anew: bool) -> None:
    """The forecast of an allocation, and the end of what nobody can mean: all machines of the choice that is taken, the first few of others."""
    from ..study.allocation import FIRST
    from ..study.limits import needed
    from ..study.searches import WIDTH, numbers_at

    machines = task.asked.count or needed(1.0 - task.asked.share, task.asked.confidence)
    choices = math.prod(map(len, task.options))
    first = [(one.name, options[0].clearance) for one, options in zip(task.parameters, task.options, strict=True)]
    chosen = [numbers_at(plan.parameters, {name: float(drawn.quantile(share)) for name, drawn in first}) for share in SHARES]
    with sentences(str(target)):
        found = sought(chosen, machines + FIRST * (choices - 1), WIDTH, base, plan.asked, target, anew)
    refuse_absurd(found, target, yes, "search")
    if found["members"] and not quiet:
        tell_forecast(found, target, plan)
        tell(
            "note",
            f"{counted(choices, 'choice')} of fits: {machines:,} machines of the one that is taken, and {FIRST} of each other are reckoned with; "
            f"fewer where a cheap one is taken, more where some are close to the limit, {machines * choices:,} at most.",
        )


def along(axis: Axis, share: float) -> float | str:
    """A value of a parameter, so far along what it may be."""
    if axis.values:
        return axis.values[int(share * len(axis.values))]
    return axis.value(share)
