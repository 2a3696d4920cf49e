"""The summary of a run as data: texts, numbers, lists and dictionaries."""

from __future__ import annotations

import dataclasses
from typing import TYPE_CHECKING, Any

import numpy as np

from ..measures import influence
from ..measures.blows import blows
from ..measures.efforts import efforts, work_of_drivers
from ..measures.energy import actuators, quantity_of
from ..measures.forces import MODES, ground_joints, other_ground_force
from ..measures.landings import measured_knocks
from ..measures.motion import rotation
from ..measures.output_intervals import shaking_estimate
from ..measures.statics import equilibria
from ..measures.stops import output_interval, stop_contacts
from ..measures.turns import full_run
from ..measures.values import Measured, lips
from ..measures.wear import SIDES
from ..measures.zero_limits import about_zero
from ..model.bodies import Link
from ..model.functions import without_ideal
from ..model.joints import Contact
from ..model.surfaces import body_of, law_facts, surface_facts, surfaces
from ..model.validation.plausibility import clearances_at_rest, suspect_surfaces
from ..model.wear import deepest
from ..solvers.record import Record
from ..solvers.refinement import worth_other_meshes, worth_refining
from .cautions import largest_by_joint, law_cautions, transient_cautions, usual_remarks, wide_contacts
from .dead_centres import dead_centres
from .fall_cautions import fall_caution, fall_of
from .freedom import freedom_left
from .run_up import motor_sentence
from .static_cautions import static_cautions
from .trust import over_several_turns, trust_summary, turns_summary, verdict
from .wear import on_default_length

if TYPE_CHECKING:
    from rich.console import Console

    from ..model.mechanism import Mechanism
    from ..results.run_data import RunData

Json = dict[str, Any]
SHARES = tuple(f"share.{mode}" for mode in MODES)
CONTACT_KEYS = ("penetration.max", "impacts", "grazing", "deep_landings", "landing_depth.max", *SHARES)
JOINT_KEYS = ("force.max", "moment.max", *CONTACT_KEYS)


def run_summary(result: RunData, reference: RunData | None = None) -> Json:
    """Summarise a run as data; ``reference`` takes the place of the result's own.

    ``status``, ``step`` (s), ``steps``, ``wall_s``, ``ns_per_step``, ``energy_error``, ``turns``
    (:func:`~vfife.report.trust.turns_summary`), the ``part`` of the run that ``measures`` are of, these,
    their ``ranges`` (``low`` and ``high`` over the companions or by their error, whether that is
    ``estimated``, ``lowest`` and ``highest`` turn), names of those that are ``not_unique`` or
    ``not_estimated``, those that are ``about_zero`` with the limits below which they lie, and ``trust`` stand
    at the top; ``model``, ``run``, ``energy``, ``joints``, ``lip``, ``laws``, ``surfaces`` (bodies of
    joints that wear, by side), ``knocks`` (of the turns of the
    measures, by contact: ``count``, ``speed`` in m/s, whether it is the ``hardest`` of the whole run),
    ``blows`` (in closed contact, by joint: ``excess`` and ``lowest`` in N, ``crank`` in degrees), ``ground``
    (what bounds the shaking force of a run with contact), ``dead_centres``, ``conformal``, ``law_facts``,
    ``surface_facts``, ``remarks``, ``warnings``, ``law_dependent`` (joints whose forces depend more on the
    contact law than on the step, with the index of the warning), ``law_shocks`` and ``law_loads`` (what else
    the law decides, see :func:`_cautions`), of a run whose largest forces are those of the fall of journals
    at its start ``start_fall`` (``joints``, ``time`` in s, ``measures``, and the index of the warning) and,
    of a model with stops, ``stops`` (contacts that the outputs show, by name) with the ``stop_interval`` of
    the outputs (s), and of a model with drivers of sliders or points ``actuators``, of one with drivers that
    apply torques or forces ``efforts`` (:mod:`~vfife.measures.efforts`) and, of one with elastic bodies in
    motion, ``meshes_not_covered`` (elements of the bodies whose mesh error is in no range) are what
    the document of :mod:`~vfife.report.run` is made of.
    """
    reference = reference if reference is not None else result.reference
    record, choice, turns, trust = (
        result.record,
        result.record.assembly.choice,
        turns_summary(result),
        trust_summary(result),
    )
    steps, static = int(record.steps[-1]), record.static
    measures: dict[str, float] = {name: float(value) for name, value in result.measures.items()}
    ideal = {} if reference is None else reference.measures
    if reference is not None and reference is not result.reference:
        driven = [body.name for body in record.assembly.bodies.values() if body.driven is not None]
        measures |= influence(measures, reference.measures, driven)
    ranges = {name: _range(measure) for name, measure in result.measures.items()}
    leading = (
        "" if static else verdict({"trust": trust, "measures": measures, "ranges": ranges, "turns": turns})
    )
    energies = _energies(result)
    motors = {"status": record.status, "part": result.measures.part, **energies}
    return {
        "status": record.status,
        "step": choice.step,
        "steps": steps,
        "wall_s": record.wall,
        "ns_per_step": 1e9 * record.wall / max(int(record.block("iterations").sum()) if static else steps, 1),
        "energy_error": None if static else result.ledger.error,
        "model": _model(result, measures, ideal),
        "run": _static_run(result) if static else _transient_run(result),
        **energies,
        "joints": _joints(result, measures, ideal),
        "contacts": {name: _numbers(measures, name, CONTACT_KEYS) for name in record.assembly.contacts},
        "lip": lips(measures),
        "laws": _laws(result),
        "surfaces": _wearing_bodies(result),
        **_cautions(result, leading, motor_sentence(motors, remedy=True)),
        "ground": _ground(result),
        "knocks": _knocks(result),
        "blows": _blows(result, reference),
        "dead_centres": [] if static else dead_centres(result, measures, ideal),
        "conformal": wide_contacts(result),
        "law_facts": list(law_facts(record.assembly.mechanism)),
        "surface_facts": list(surface_facts(record.assembly.mechanism)),
        "remarks": [] if static else usual_remarks(result),
        "measures": measures,
        "turns": turns,
        "part": result.measures.part,
        "ranges": ranges if record.companions or record.estimate or over_several_turns(turns) else {},
        "not_unique": [name for name, measure in result.measures.items() if not measure.unique],
        "about_zero": about_zero(record, result.measures),
        "not_estimated": [name for name, measure in result.measures.items() if not measure.estimated],
        "trust": trust,
        **(_stops(record) | _meshes(record)),
        **({} if static else _actuators(result, ideal)),
    }


def _energies(result: RunData) -> Json:
    """Return the energies of a run, with the work of its drivers, and the figures of those that apply torques
    or forces.
    """
    record = result.record
    if record.static:
        return {"energy": {}}
    figures = efforts(record)
    energy = {
        "largest": result.ledger.largest,
        "end": {k: float(v[-1]) for k, v in result.ledger.terms.items()},
        "drivers": work_of_drivers(record, figures),
    }
    return {"energy": energy, **({"efforts": figures} if figures else {})}


def _cautions(result: RunData, leading: str, of_motors: str) -> Json:
    """Warnings, that ``of_motors`` first, and with the index of their warning the joints whose forces depend
    more on the contact law than on the step (``law_dependent``), those whose shocks depend on both
    (``law_shocks``), the measures of all that shocks load (``law_loads``), and the fall at the start.
    """
    if result.record.static:
        return {"warnings": list(static_cautions(result)), "law_dependent": {}}
    of_laws = law_cautions(result)
    warnings = [*filter(None, [of_motors]), *transient_cautions(result, leading, of_laws.texts)]
    entry = {}
    if fall := fall_of(result):
        assembly = result.record.assembly
        warnings.insert(0, fall_caution(fall, assembly.mechanism, assembly.choice.turn is not None))
        entry = {"start_fall": dataclasses.asdict(fall) | {"index": 0}}
    keys = ("law_dependent", "law_shocks", "law_loads")
    parts = ({name: warnings.index(text) for name, text in part.items()} for part in of_laws)
    return {"warnings": warnings, **dict(zip(keys, parts, strict=True)), **entry}


def _actuators(result: RunData, ideal: Any) -> Json:
    """Return for each actuator the ``measure`` of its largest force or torque with that of the ``ideal``
    mechanism, and its largest power at the outputs (``power``, W), as an entry of a summary; nothing without
    actuators.
    """
    powers = np.abs(result.record.block("actuator_power")).max(axis=0).tolist()
    entries = {}
    for (name, linear), power in zip(actuators(result.record).items(), powers, strict=True):
        quantity, unit = quantity_of(linear)
        measure = f"{name}.{quantity}.max"
        entries[name] = {"measure": measure, "unit": unit, "ideal": ideal.get(measure), "power": power}
    return {"actuators": entries} if entries else {}


def _meshes(record: Record) -> Json:
    """Return the elements of the bodies whose mesh error no range covers, as an entry of a summary."""
    bodies = {} if record.static else record.assembly.bodies
    counts = {name: len(body.elements) for name, body in bodies.items() if body.model != "two-particle"}
    elements = {name: count for name, count in counts.items() if count}
    return {"meshes_not_covered": elements} if elements else {}


def _stops(record: Record) -> Json:
    stops = stop_contacts(record)
    return {"stops": stops, "stop_interval": output_interval(record)} if stops else {}


def _knocks(result: RunData) -> Json:
    knocks = measured_knocks(result.record, result.motion)
    return {name: dataclasses.asdict(knock) for name, knock in knocks.items()}


def _blows(result: RunData, reference: RunData | None) -> Json:
    """Blows of joints with clearance in closed contact, with the crank angle at which the largest ends."""
    angle = result.crank_angle
    if angle is None or reference is None:
        return {}
    return {
        name: {"excess": blow.excess, "lowest": blow.lowest, "crank": float(angle[blow.row])}
        for name, blow in blows(result.record, reference.record, result.motion).items()
    }


def _ground(result: RunData) -> Json:
    """Bounds of the shaking force of a run with contact, which is taken at the outputs only: the sum of the
    largest forces of what stands on the ground is ``at_most`` (N), of a single ``joint`` it is the force, and
    ``estimate`` (N) is it with the peaks of the joints between the outputs.
    """
    record, measures = result.record, result.measures
    if record.static or not record.assembly.contacts or "ground.shaking_force.max" not in measures:
        return {}
    joints, other_force = ground_joints(record), other_ground_force(record, full_run(record))
    sole = joints[0] if len(joints) == 1 and other_force == 0.0 else None
    at_most = sum(measures[f"{name}.force.max"].high for name in joints) + other_force
    estimate = max(float(measures["ground.shaking_force.max"]), shaking_estimate(record, result.motion))
    return {"at_most": at_most, "joint": sole, "estimate": min(estimate, at_most)}


def _range(measure: Measured) -> Json:
    """Return the numerical range of a measure and its scatter over turns."""
    return {key: getattr(measure, key) for key in ("low", "high", "lowest", "highest", "estimated")}


def _numbers(measures: dict[str, float], name: str, keys: tuple[str, ...]) -> dict[str, float]:
    """Return the measures of a joint or contact without its name."""
    return {key: measures[f"{name}.{key}"] for key in keys if f"{name}.{key}" in measures}


def _model(result: RunData, measures: dict[str, float], ideal: Any) -> Json:
    mechanism, bodies = result.record.assembly.mechanism, dict[str, Json]()
    for name, body in result.record.assembly.bodies.items():
        source = mechanism.bodies[name]
        bodies[name] = {
            "model": body.model, "elements": len(body.elements), "mass": body.mass, "inertia": body.inertia,
            "driven": body.driven is not None,
            "release": source.release if isinstance(source, Link) else "none",
        }  # fmt: skip
        for key in ("angular_acceleration.max", "torque.max"):
            bodies[name] |= {key: measures.get(f"{name}.{key}"), f"ideal_{key}": ideal.get(f"{name}.{key}")}
    return {
        "name": mechanism.name,
        "note": " ".join(mechanism.note.split()),
        "source": mechanism.source,
        "bodies": bodies,
        "ideal_shaking_force.max": ideal.get("ground.shaking_force.max"),
    }


def _transient_run(result: RunData) -> Json:
    record, choice = result.record, result.record.assembly.choice
    time = float(result.time[-1])
    mechanism = record.assembly.mechanism
    drivers = mechanism.drivers
    moving = [driver for driver in drivers.values() if driver.moves]
    turning = {name: driver for name, driver in drivers.items() if driver.moves and driver.unit == "rad"}
    count = mechanism.crank_turns(choice.turn, time)
    return {
        "loop": record.loop,
        "time_s": time,
        "turns": None if choice.turn is None else time / choice.turn,
        **({} if count is None else {"crank_turns": count}),
        **({"free_when_driven": left} if (left := freedom_left(record.assembly)) else {}),
        "speeds": {
            name: driver.steady_speed for name, driver in turning.items() if driver.steady_speed is not None
        },
        "steady": bool(moving) and all(driver.steady_speed is not None for driver in moving),
        "outputs": len(record.steps),
        "automatic": choice.automatic,
        "long": not worth_refining(record.assembly),
        **({"without_ideal": without_ideal(mechanism)} if record.assembly.contacts else {}),
        "stable_step": choice.stable if choice.stable < float("inf") else None,
        "set_by": choice.culprit,
        **({"steps_planned": choice.steps} if record.status == "interrupted" else {}),
        "notes": [note for note in record.assembly.notes if note not in _leading_notes(mechanism)],
        **({"reached": reached} if choice.turn is None and (reached := _reached_speeds(record)) else {}),
    }


def _leading_notes(mechanism: Mechanism) -> tuple[str, ...]:
    """Return the notes that are among the cautions already."""
    return (*suspect_surfaces(mechanism), *clearances_at_rest(mechanism))


def _reached_speeds(record: Record) -> dict[str, Json]:
    """Return the speed (rad/s) at the ``end``, and the ``low``est and ``high``est at the outputs, of each
    body that a torque drives.
    """
    reached = {}
    for name, driver in record.assembly.mechanism.drivers.items():
        body = driver.body or name
        if not driver.moves and not driver.is_linear and body in record.assembly.bodies:
            speed = rotation(record, body).velocity
            reached[body] = {"end": float(speed[-1]), "low": float(speed.min()), "high": float(speed.max())}
    return reached


def _static_run(result: RunData) -> Json:
    record, mechanism = result.record, result.record.assembly.mechanism
    settings = mechanism.settings
    return {
        "analysis": "static",
        "loop": record.loop,
        "load_factors": len(settings.load_factors),
        "reached": max(len(record.steps) - 1, 0),
        "iterations": int(record.block("iterations").sum()),
        "residual": settings.residual,
        "refined": bool(result.arguments.get("refined")),
        "long": not worth_other_meshes(record.assembly),
        "factors": equilibria(record),
        "notes": [note for note in record.assembly.notes if note not in _leading_notes(mechanism)],
    }


def _joints(result: RunData, measures: dict[str, float], ideal: Any) -> dict[str, Json]:
    """Measures of each joint; the depth of a block in a guide is that of its deepest corner."""
    names = [key.removesuffix(".force.max") for key in measures if key.endswith(".force.max")]
    joints: dict[str, Json] = {
        name: {"ideal_force.max": ideal.get(f"{name}.force.max"), **_numbers(measures, name, JOINT_KEYS)}
        for name in names
    }
    assembly = result.record.assembly
    for name, loose in assembly.mechanism.contacts.items():
        if name in joints:
            joints[name] |= {"clearance": getattr(loose, "clearance", None), **_surfaces(loose)}
    depths = largest_by_joint(
        result.record, (measures.get(f"{contact}.penetration.max", 0.0) for contact in assembly.contacts)
    )
    for contact, joint in zip(assembly.contacts, assembly.contact_joints, strict=True):
        if contact != joint and joint in joints:
            joints[joint]["penetration.max"] = depths[joint]
    return joints


def _surfaces(joint: Contact) -> Json:
    """Return whether the surfaces are those of a guide, and the greatest depth (m) of those that are worn."""
    depths = {side: deepest(getattr(joint.wear, f"{side}_profile", ())) for side in SIDES}
    depths = {side: depth for side, depth in depths.items() if depth}
    guide: Json = {"guide": True} if joint.is_guide else {}
    if on_default_length(joint):
        guide["default_length"] = joint.axial_length
    return guide | ({"worn": depths} if depths else {})


def _laws(result: RunData) -> dict[str, Json]:
    mechanism, laws = result.record.assembly.mechanism, dict[str, Json]()
    for name, joint in mechanism.contacts.items():
        pair, kinds = surfaces(mechanism, joint), {"contact": joint.contact, "friction": joint.friction}
        laws[name] = {
            kind: {
                "law": law.name,
                "formula": law.formula,
                "source": law.source,
                "derived": law.derived(pair),
                "units": law.units(pair),
            }
            for kind, law in kinds.items()
        }
    return laws


def _wearing_bodies(result: RunData) -> dict[str, dict[str, str]]:
    """Return the bodies that have the two surfaces of each joint that wears."""
    contacts = result.record.assembly.mechanism.contacts.items()
    return {
        name: {side: body_of(joint, side) for side in SIDES}
        for name, joint in contacts
        if joint.wear is not None
    }


def summary_text(result: RunData) -> str:
    """Return the short document of a run as text of 100 columns."""
    from .overview import overview
    from .terminal import as_text

    return as_text(overview(run_summary(result)))


def show(console: Console, result: RunData, reference: RunData | None = None) -> None:
    """Print the long document of a run."""
    from .run import document
    from .terminal import write

    console.print()
    write(document(run_summary(result, reference)), console)
