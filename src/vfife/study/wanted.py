"""What is wanted of each member, checked against the model before anything is run: measures by name, reductions of channels."""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Sequence
from typing import NamedTuple

from ..analysis.wanted import of_whole_runs
from ..assembly.assemble import assemble
from ..errors import StepError, VfifeError, shown, suggestion
from ..fields import Reading, Refused
from ..model.functions import turn_of
from ..model.mechanism import Mechanism
from ..modelfile import dump
from ..results.reductions import REDUCTION
from ..results.studied import UNITS
from ..results.view import View, standing
from .engine import Wanted
from .plan import Asked

MOST_MODELS = 16  # whose names are kept: a command reads a study file more than once


class Names(NamedTuple):
    """What may be wanted of a model."""

    measures: tuple[str, ...]
    series: tuple[str, ...]


NAMES: OrderedDict[str, Names] = OrderedDict()


def names_of(base: Mechanism) -> Names:
    """Names of the measures and of the channels of a model. Raises VfifeError where it cannot be assembled."""
    text = dump(base)
    found = NAMES.get(text)
    if found is None:
        view = standing(assemble(base))
        found = NAMES[text] = Names(tuple(known_measures(view)), tuple(view.series))
        if len(NAMES) > MOST_MODELS:
            NAMES.popitem(last=False)
    return found


def wanted_of(asked: Asked) -> Wanted:
    """What the engine is asked for."""
    step = None if asked.step == "auto" else float(asked.step)
    return Wanted(tuple(asked.measures), asked.turns, asked.settle, asked.last, step)


def beside_last(asked: Asked) -> str:
    """What of the measures does not heed the ``last`` turns asked for, in a sentence; empty where nothing is."""
    names = of_whole_runs(asked.measures) if asked.last > 1 else []
    if not names:
        return ""
    of = "is of the whole run" if len(names) == 1 else "are of the whole run"
    return f"{', '.join(names)} {of}, from its first turn on; last = {asked.last} does not change that."


def check_measures(base: Mechanism, names: Sequence[str] | None, by: Reading) -> None:
    """Tells names that no measure of the model has, and channels that it does not have."""
    try:
        known, series = names_of(base)
    except VfifeError as error:
        by.tell(("model",), Refused(f"it cannot be assembled: {error}", base.name, "", "see vfife check"))
        return
    endings = {name.partition(".")[2] for name in known}  # what is there from the start, where it is at all; others begin later
    owners = {name for part in (base.bodies, base.joints, base.drivers, base.springs, base.loads) for name in part} | {"ground", "mechanism"}
    for k, name in enumerate(names or ()):
        reduced = REDUCTION.fullmatch(name)
        if reduced is not None:
            if reduced[2] not in series:
                remedy = suggestion(reduced[2], series, "name a channel of the run")
                by.tell(("measures", k), Refused("there is no such channel", shown(name), "", remedy))
        elif name not in known:
            owner, _, ending = name.partition(".")
            if owner not in owners or ending not in UNITS or ending in endings:
                remedy = suggestion(name, known, "the names are those of vfife run MODEL.toml --json")
                by.tell(("measures", k), Refused("there is no such measure", shown(name), "", remedy))
    if names and len(set(names)) < len(names):
        by.tell(("measures",), Refused("the same measure twice", "", "each one once", "remove it"))


def known_measures(view: View) -> list[str]:
    """Names of measures that the model has at its start, and those that need a turn."""
    from ..analysis.measures import measures

    found = list(measures(view.record))
    found += [f"{name.removesuffix('.max')}.lip" for name in found if name.endswith((".force.max", ".angular_acceleration.max"))]
    found += [f"{name.removesuffix('.max')}.{kind}" for name in found if name.endswith(".torque.max") for kind in ("mean", "ripple")]
    found += [name.replace(".torque.max", ".power.mean") for name in found if name.endswith(".torque.max")]
    return [*found, "mechanism.efficiency"]


def check_turns(base: Mechanism, asked: Asked, by: Reading) -> None:
    """Tells what keeps members from being counted in turns."""
    if base.settings.analysis == "static":
        by.tell(("model",), Refused("a static analysis has no turns", base.name, "a model that moves", 'set "run.analysis" = "dynamic" in [set]'))
    elif turn_of(base) is None:
        by.tell(("model",), Refused("no driver turns a crank, so turns cannot be counted", base.name, "", "drive a body"))
    elif isinstance(asked.step, float):
        try:
            assemble(base, asked.step)
        except StepError as error:
            by.tell(
                ("step",),
                Refused("too large for the model", f"{asked.step:g} s", str(error).partition(": ")[2].partition(";")[0], "set it smaller"),
            )
        except VfifeError:
            pass  # told by its measures
    if None not in (asked.last, asked.turns) and asked.last > asked.turns:
        by.tell(("last",), Refused("more turns than a member makes", str(asked.last), f"at most {asked.turns}", "give fewer, or more turns"))
