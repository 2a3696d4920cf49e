"""The summary of a run as data: texts, numbers, lists and dictionaries."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

from ..laws import Law
from ..measures.energy import own_floor
from ..measures.forces import MODES
from ..measures.measured import Measured, lips
from ..measures.ranges import OPEN
from ..model.bodies import Link
from ..solvers.status import Status
from .divergence import FLOOR
from .limits import conformal, out_of_range, quiet
from .statics import static_run, static_warnings
from .trust import several, trusted, turned, verdict

if TYPE_CHECKING:
    from rich.console import Console

    from ..results.view import View

CONTACT_KEYS = (
    "penetration.max",
    "impacts",
    "grazing",
    "deep_landings",
    "landing_depth.max",
    *(f"share.{mode}" for mode in MODES),
)
JOINT_KEYS = ("force.max", "moment.max", *CONTACT_KEYS)


def report(result: View, reference: View | None = None) -> dict[str, Any]:
    """All that the summary of a run says: texts, numbers, lists and dictionaries only.

    ``status``, ``step`` (s), ``steps``, ``wall_s``, ``ns_per_step``, ``energy_error``, ``turns``
    (:func:`~vfife.report.trust.turned`), the ``part`` of the run that ``measures`` are of, these, their
    ``ranges`` (``low`` and ``high`` over the companions or by their error, whether that is ``estimated``,
    ``lowest`` and ``highest`` turn), names of those that are ``not_unique`` or ``not_estimated`` and
    ``trust`` stand at the top; ``model``, ``run``, ``energy``, ``joints``, ``lip``, ``laws``, ``conformal``,
    ``remarks`` and ``warnings`` are what the document of
    :mod:`~vfife.report.run` is made of. The reference is the result's own unless another
    one is given.
    """
    reference = reference if reference is not None else result.reference
    record, choice, turns = result.record, result.record.assembly.choice, turned(result)
    done = int(record.steps[-1])
    measures: dict[str, float] = {name: float(value) for name, value in result.measures.items()}
    if reference is not None and reference is not result.reference:
        from ..measures import influence

        driven = [body.name for body in record.assembly.bodies.values() if body.driven is not None]
        measures |= influence(measures, reference.measures, driven)
    return {
        "status": record.status,
        "step": choice.step,
        "steps": done,
        "wall_s": record.wall,
        "ns_per_step": (
            1e9 * record.wall / max(int(record.block("iterations").sum()) if record.static else done, 1)
        ),
        "energy_error": None if record.static else result.ledger.error,
        "model": _model(result, measures, reference),
        "run": static_run(result) if record.static else _run(result),
        "energy": (
            {}
            if record.static
            else {
                "largest": result.ledger.largest,
                "end": {k: float(v[-1]) for k, v in result.ledger.terms.items()},
            }
        ),
        "joints": _joints(result, measures, reference),
        "contacts": _contacts(result, measures),
        "lip": lips(measures),
        "laws": _laws(result),
        "warnings": list(static_warnings(result) if record.static else warnings(result)),
        "conformal": conformal(result),
        "remarks": [] if record.static else quiet(result),
        "measures": measures,
        "turns": turns,
        "part": result.measures.part,
        "ranges": (
            {name: _range(one) for name, one in result.measures.items()}
            if record.companions or record.estimate or several(turns)
            else {}
        ),
        "not_unique": [name for name, one in result.measures.items() if not one.unique],
        "not_estimated": [name for name, one in result.measures.items() if not one.estimated],
        "trust": trusted(result),
    }


def _range(one: Measured) -> dict[str, float | bool]:
    """What is not known of a measure, and what varies."""
    return {
        "low": one.low,
        "high": one.high,
        "lowest": one.lowest,
        "highest": one.highest,
        "estimated": one.estimated,
    }


def _model(result: View, measures: dict[str, float], reference: View | None) -> dict[str, Any]:
    mechanism = result.record.assembly.mechanism
    ideal = {} if reference is None else reference.measures
    bodies: dict[str, dict[str, Any]] = {}
    for name, where in result.record.assembly.bodies.items():
        noun = mechanism.bodies[name]
        bodies[name] = {
            "model": where.model,
            "elements": len(where.elements),
            "mass": where.mass,
            "inertia": where.inertia,
        }
        bodies[name] |= {
            "driven": where.driven is not None,
            "release": noun.release if isinstance(noun, Link) else "none",
        }
        for key in ("angular_acceleration.max", "torque.max"):
            bodies[name] |= {key: measures.get(f"{name}.{key}"), f"ideal_{key}": ideal.get(f"{name}.{key}")}
    return {
        "name": mechanism.name,
        "note": " ".join(mechanism.note.split()),
        "source": mechanism.source,
        "bodies": bodies,
    }


def _run(result: View) -> dict[str, Any]:
    record, choice = result.record, result.record.assembly.choice
    time = float(result.time[-1])
    moving = [driver for driver in record.assembly.mechanism.drivers.values() if driver.moves]
    return {
        "loop": record.loop,
        "time_s": time,
        "turns": None if choice.turn is None else time / choice.turn,
        "steady": bool(moving) and all(driver.steady_speed is not None for driver in moving),
        "outputs": len(record.steps),
        "automatic": choice.automatic,
        "stable_step": choice.stable if choice.stable < float("inf") else None,
        "set_by": choice.culprit,
        "notes": list(record.assembly.notes),
    }


def _contacts(result: View, measures: dict[str, float]) -> dict[str, dict[str, float]]:
    """Counts and depths of each contact; a block in a guide has four."""
    names = result.record.assembly.contacts
    return {
        name: {key: measures[f"{name}.{key}"] for key in CONTACT_KEYS if f"{name}.{key}" in measures}
        for name in names
    }


def _joints(
    result: View, measures: dict[str, float], reference: View | None
) -> dict[str, dict[str, float | None]]:
    ideal = {} if reference is None else reference.measures
    names = [key.removesuffix(".force.max") for key in measures if key.endswith(".force.max")]
    found: dict[str, dict[str, float | None]] = {}
    for name in names:
        found[name] = {"ideal_force.max": ideal.get(f"{name}.force.max")}
        found[name] |= {key: measures[f"{name}.{key}"] for key in JOINT_KEYS if f"{name}.{key}" in measures}
    assembly = result.record.assembly
    for contact, joint in zip(assembly.contacts, assembly.contact_joints, strict=True):
        if contact != joint and joint in found:  # the deepest of the corners
            depth = measures.get(f"{contact}.penetration.max", 0.0)
            found[joint]["penetration.max"] = max(depth, found[joint].get("penetration.max") or 0.0)
    return found


def _laws(result: View) -> dict[str, dict[str, Any]]:
    from ..model.surfaces import surfaces

    mechanism = result.record.assembly.mechanism
    found = {}
    for name, joint in mechanism.contacts.items():
        pair = surfaces(mechanism, joint)
        found[name] = {
            kind: {
                "law": law.name,
                "formula": law.formula,
                "source": law.source,
                "derived": law.derived(pair),
                "units": law.units(pair),
            }
            for kind, law in _named(("contact", joint.contact), ("friction", joint.friction))
        }
    return found


def _named(*laws: tuple[str, Law]) -> tuple[tuple[str, Law], ...]:
    return laws


def open_by(result: View) -> str:
    """By how much the energy ledger is open, in words."""
    return f"{100.0 * result.ledger.error:.2g} %"


def missing(result: View) -> Iterable[str]:
    """A sentence about what was damaged in the file of a run."""
    if lost := result.record.lost:
        yield (
            f"The run file is damaged: {', '.join(lost)} could not be read and count nowhere in what is told"
            " here; run the model again."
        )


def warnings(result: View) -> Iterable[str]:
    """Sentences about what makes a run doubtful, each with what to do."""
    record, choice, measures = result.record, result.record.assembly.choice, result.measures
    yield from missing(result)
    if record.status != Status.COMPLETE:
        yield STATUS.get(record.status, f"The run is {record.status}.").format(time=float(result.time[-1]))
    if choice.step > choice.stable:
        yield (
            f"The step of {choice.step:.4g} s is larger than the stable one, {choice.stable:.4g} s"
            f' ({choice.culprit}): take a smaller step, or "auto".'
        )
    for name, joint in record.assembly.mechanism.contacts.items():
        deep, count = int(measures.get(f"{name}.deep_landings", 0)), int(measures.get(f"{name}.impacts", 0))
        if deep:
            yield (
                f"Joint {name}: {deep} of {count} first contacts landed deeper than {1e6 * joint.landing:.4g}"
                f" µm, the deepest at {1e6 * measures[f'{name}.landing_depth.max']:.4g} µm, so their impact"
                f" speeds are coarse: halve the step ({0.5 * choice.step:.3g} s), or raise landing_depth if"
                " that will do."
            )
    ranges = {name: _range(one) for name, one in measures.items()}
    if sensitive := verdict(
        {"trust": trusted(result), "measures": measures, "ranges": ranges, "turns": turned(result)}
    ):
        yield sensitive
    yield from out_of_range(result)
    if result.ledger.error > OPEN:
        then = FLOOR if own_floor(record) else "take a smaller step and see whether it closes"
        yield f"The energy ledger is open by {open_by(result)} of the largest energy: {then}."


STATUS = {
    Status.INTERRUPTED: (
        "The run was interrupted at {time:.4g} s; what is told here is what was computed until then."
    ),
    Status.UNFINISHED: (
        "The run has not said that it ended: it was killed, or is at work. It has written {time:.4g} s."
    ),
    Status.ENERGY: (
        "More energy came or went until {time:.4g} s than can be accounted for: these numbers are not to be"
        " used."
    ),
    Status.DIVERGED: (
        "The numbers were no longer finite after {time:.4g} s: take a smaller step, or check the model there."
    ),
}


def show(console: Console, result: View, reference: View | None = None) -> None:
    """Print the summary as tables."""
    from .run import document
    from .terminal import write

    console.print()
    write(document(report(result, reference)), console)
