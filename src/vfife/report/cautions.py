"""Cautions about a run: models used outside their range, lost or missing data, and remedies."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable, Iterator
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ..assembly.timestep import MANY_OUTPUTS
from ..laws.friction.forms import StaticFriction, regime_of_peak
from ..laws.materials import hardness_of
from ..measures.contacts import CONFORMAL, line_pressure
from ..measures.efforts import excess_speeds
from ..measures.energy import open_share, own_floor
from ..measures.landings import lasting_landings
from ..measures.motion import at_rest
from ..measures.normal_forces import friction_changes, largest_normal_forces
from ..measures.rounding import rounding_noise
from ..measures.trust import OPEN
from ..measures.turns import full_run
from ..measures.whirl import backward_whirls
from ..model.functions import crank_of, cycle_of, turn_of, without_ideal
from ..model.joints import Contact
from ..model.surfaces import cautions, law_facts, remarks, surfaces
from ..model.validation.plausibility import suspect_surfaces
from ..solvers.status import Status
from ..units import in_rpm
from .damping_cautions import (
    certain_shocks,
    comparison,
    damping_cautions,
    load_cautions,
    load_words,
    raised_loads,
    shock_cautions,
)
from .design_words import and_words
from .divergence import FLOOR, soft_contact
from .document import grouped
from .run_up import jump_caution

if TYPE_CHECKING:
    from ..laws import Material
    from ..model.mechanism import Mechanism
    from ..results.run_data import RunData
    from ..solvers.record import Record

CORNERS = " A block touches its guide with its corners: a larger corner_radius lowers both there."
# Of the change of the sliding velocity that static friction makes in a step: where the peak of a curve lies
# at a lower speed, a reversal passes it. Blocks shaken at 5 to 30 Hz slid on with peaks up to 0.06 of it.
PASSED = 0.1
PIN = 0.1  # of the journal's radius: a pin that sinks in deeper has lost its shape
# Endings of measures that a rebound changes: speeds, numbers and energies of impacts.
OF_IMPACTS = (".approach_speed.max", ".impacts", ".impact_energy.total", ".impact_power.mean")
STATUS = {
    Status.INTERRUPTED: ("The run was interrupted at {time:.4g} s of simulated time; the results end there."),
    Status.UNFINISHED: (
        "The run has no end: it was killed, or is still running. Its results reach {time:.4g} s."
    ),
    Status.ENERGY: (
        "The energy balance is open beyond its limit after {time:.4g} s: do not use these numbers."
    ),
    Status.DIVERGED: (
        "The numbers were no longer finite after {time:.4g} s: take a smaller step, or check the model there."
    ),
}


class LawCautions(NamedTuple):
    """Cautions on what the contact law decides, each with its sentence: ``joints`` whose force depends more
    on the law than on the step, joints with ``shocks`` whose force depends on both, and the ``loads`` (names
    of measures) that all these shocks make.
    """

    joints: dict[str, str]
    shocks: dict[str, str]
    loads: dict[str, str]

    @property
    def texts(self) -> tuple[str, ...]:
        """All sentences, each once."""
        return tuple(dict.fromkeys(text for part in self for text in part.values()))


def transient_cautions(result: RunData, verdict: str, of_laws: Iterable[str]) -> Iterator[str]:
    """Yield sentences on what makes a dynamic run doubtful, each with a remedy; ``verdict`` is that of the
    companions, ``of_laws`` are those of :func:`law_cautions`.
    """
    record, choice, measures = result.record, result.record.assembly.choice, result.measures
    yield from damage(result)
    yield from record.assembly.missing_joints
    yield from suspect_surfaces(record.assembly.mechanism)
    if record.status != Status.COMPLETE:
        sentence = STATUS.get(record.status, f"The run is {record.status}.")
        soft = soft_contact(record)
        yield f"{soft[0].upper()}{soft[1:]}" if soft else sentence.format(time=float(result.time[-1]))
    yield from rest_cautions(record)
    if joints := getattr(result, "arguments", {}).get("jumps"):
        yield jump_caution(joints)
    yield from cycle_cautions(result)
    yield from curve_cautions(record)
    if choice.step > choice.stable:
        yield (
            f"The step of {choice.step:.4g} s is larger than the stable one, {choice.stable:.4g} s"
            f' ({choice.culprit}): take a smaller step, or "auto".'
        )
    if MANY_OUTPUTS in choice.culprit and choice.automatic:
        yield (
            f"The step of {choice.step:.3g} s is set by {choice.culprit}: fewer outputs shorten the run"
            " in proportion."
        )
    for name, joint in record.assembly.mechanism.contacts.items():
        deep, count = int(measures.get(f"{name}.deep_landings", 0)), int(measures.get(f"{name}.impacts", 0))
        if deep:
            deepest = _micrometres(measures[f"{name}.landing_depth.max"], 3)
            yield (
                f"Joint {name}: {deep} of {count} first contacts landed deeper than {1e6 * joint.landing:.4g}"
                f" µm, the deepest at about {deepest}, so their impact"
                f" speeds are inaccurate: halve the step ({0.5 * choice.step:.3g} s), or raise landing_depth"
                " if this accuracy suffices."
            )
    if verdict:
        yield verdict
    yield from rounding_cautions(result)
    yield from whirl_cautions(record)
    yield from of_laws
    yield from peak_cautions(record)
    yield from open_contact_cautions(record)
    yield from out_of_range(result)
    if (share := open_share(record, result.ledger)) > OPEN:
        remedy = FLOOR if own_floor(record) else "take a smaller step and see whether it closes"
        yield f"The energy ledger is open by {100.0 * share:.2g} % of the largest energy: {remedy}."
    yield from comparison_cautions(record)


def comparison_cautions(record: Record) -> Iterator[str]:
    """Yield a sentence on why a driven run with contacts has no ideal mechanism to compare with."""
    mechanism = record.assembly.mechanism
    driven = mechanism.drivers and record.assembly.contacts
    if driven and (reason := without_ideal(mechanism)):
        yield (
            f"There is no comparison with ideal joints: {reason}. Which loads the contact law raises is not"
            f" known: {comparison(mechanism, mechanism.contacts)}."
        )


def rest_cautions(record: Record) -> Iterator[str]:
    """Yield a sentence on a run in which nothing moves, with what may be missing."""
    if not at_rest(record):
        return
    mechanism = record.assembly.mechanism
    if mechanism.drivers:
        cause, remedy = (
            "no driver moves anything in its time",
            "look at the drivers and the length of the run",
        )
    elif any(mechanism.gravity) or mechanism.loads:
        cause = "the mechanism starts in equilibrium, and stays there; whether it is stable is not examined"
        remedy = (
            "give it another start position, a velocity, a load or a driver; vfife modes examines the start"
        )
    else:
        cause = "the model has no gravity and no load"
        remedy = 'give it gravity = [0, "-9.81 m/s^2"], a load, a driver or a velocity'
    yield f"Nothing moves in this run: {cause}. If something should move, {remedy}."


def cycle_cautions(result: RunData) -> Iterator[str]:
    """Yield a sentence on bodies that turn slower than the driver whose turns are those of the run."""
    mechanism, motion = result.record.assembly.mechanism, result.motion
    if turn_of(mechanism) is None:
        return
    turns = cycle_of(mechanism)
    cycle, slow = math.lcm(*turns.values()), [body for body, count in turns.items() if count > 1]
    if not slow:
        return
    fact = (
        f"A turn is one of {crank_of(mechanism)}, the fastest driver: {and_words(slow)} repeat"
        f"{'s' * (len(slow) == 1)} after {cycle} of them."
    )
    if motion is None or (motion.last - motion.first + 1) % cycle:
        yield (
            f"{fact} The values are not those of the whole machine, in mean powers not even by their sign:"
            f" give at least --turns {2 * cycle}."
        )
        return
    yield (
        f"{fact} Mean powers and ends of strokes are those of the machine, largest values in the highest of"
        " the single turns; rms torque and energy fluctuation are those of single turns, not of the machine."
    )


def curve_cautions(record: Record) -> Iterator[str]:
    """Yield a sentence on each driver whose speed leaves its curve."""
    for name, speed, end, value in excess_speeds(record):
        yield (
            f"Driver {name} reaches about {float(f'{30.0 * speed / math.pi:.4g}'):,g} rpm; its curve ends"
            f" at {in_rpm(end)} and keeps {value:.4g} N m beyond. Let speeds go on to there: a motor may"
            " brake. Is the speed unexpected, look for a load that drives the machine (force and force_back"
            " exchanged, a wrong sign) or is"
            " missing."
        )


def rounding_cautions(result: RunData) -> Iterator[str]:
    """Yield a sentence on a step that is so small that rounding of positions shows in accelerations."""
    diverged = result.record.status == Status.DIVERGED
    noise = None if diverged else rounding_noise(result.record, result.measures)
    if noise is None:
        return
    choice = result.record.assembly.choice
    share = f"{100.0 * noise.share:.2g} %" if noise.share < 0.995 else "all"
    text = (
        f"The step of {choice.step:.3g} s is so small that rounding of positions shows in accelerations: up"
        f" to {share} of the largest angular acceleration of {noise.body} may be noise."
    )
    if noise.step <= min(choice.stable, choice.steps * choice.step):
        remedy = "" if choice.automatic else ', or "auto"'
        yield f"{text} Take {noise.step:.2g} s or more{remedy}."
    else:
        yield f"{text} No step that is stable shows it better: quote no angular acceleration of {noise.body}."


def whirl_cautions(record: Record) -> Iterator[str]:
    """Yield a sentence on each journal that friction drives around its bearing."""
    for name, (rate, spin) in backward_whirls(record).items():
        yield (
            f"Joint {name}: friction drives the journal around its bearing, against its rotation and"
            f" about {_two_digits(rate / spin)} times as fast (about {_two_digits(rate)} rad/s, dry-friction"
            " whirl); forces"
            " grow far beyond the ideal ones. An oil film prevents this: lower the coefficient of friction,"
            ' or take the contact law "hydrodynamic".'
        )


def peak_cautions(record: Record) -> Iterator[str]:
    """Yield a sentence on the joints whose friction has its peak in a range of speeds that a step passes."""
    contacts, steepest = record.assembly.mechanism.contacts, dict[str, float]()
    if not contacts or not record.keeps("contact_normal_force"):
        return
    for name, change in largest_by_joint(record, friction_changes(record)).items():
        law, pair = contacts[name].friction, surfaces(record.assembly.mechanism, contacts[name])
        has_peak = isinstance(law, StaticFriction) and law.static_coefficient > law.coefficient
        if has_peak and law.regime is regime_of_peak:
            steepest[name] = law.parameters(pair)[2] * change
    names = [name for name, steepness in steepest.items() if steepness > 1.0 / PASSED]
    if names:
        step = record.assembly.choice.step / (PASSED * max(steepest.values()))
        yield (
            f"Joint{'s' * (len(names) > 1)} {and_words(names)}: the speed at which"
            f" {contacts[names[0]].friction.name} has static friction is passed within a step, so that"
            " surfaces whose sliding turns round may slide on against kinetic friction where static friction"
            f" would hold them: take a step below {step:.2g} s, a higher speed of the peak, or karnopp, which"
            " holds one contact of a body with any step."
        )


def law_cautions(result: RunData) -> LawCautions:
    """Return a sentence on each force that the contact law decides: by the speed of a landing that it
    remembers, by its damping, or by shocks; and on all that these load.
    """
    damped, lasting = damping_cautions(result), landing_cautions(result)
    joints = lasting | damped
    shocks = shock_cautions(result, joints)
    loads = load_cautions(result, [*damped, *shocks])
    certain = certain_shocks(result, shocks)
    if not lasting.keys() <= damped.keys():
        text = next(iter(lasting.values()))
        loads = {
            name: text for name in raised_loads(result) if not _belongs(name, {*joints, *shocks})
        } | loads
    return LawCautions(
        joints | {name: shocks[name] for name in certain},
        {name: text for name, text in shocks.items() if name not in certain},
        loads,
    )


def _belongs(measure: str, joints: Collection[str]) -> bool:
    """Return whether a measure is the largest force of one of ``joints``."""
    return measure.removesuffix(".force.max") in joints


def open_contact_cautions(record: Record) -> Iterator[str]:
    """Yield a sentence on the joints whose surfaces have no force between them in the whole run."""
    if not record.assembly.contacts or record.status != Status.COMPLETE or at_rest(record):
        return
    if not record.keeps("contact_force_squared_max"):
        return
    forces = largest_by_joint(record, record.block("contact_force_squared_max").max(axis=0))
    if names := [name for name, force in forces.items() if force == 0.0]:
        yield (
            f"Joint{'s' * (len(names) > 1)} {', '.join(names)}: the surfaces never touched in the whole run."
            " If they should, look for gravity or a load with the wrong sign, a wrong direction or position"
            " of the surface, or another joint that holds the body."
        )


def landing_cautions(result: RunData) -> dict[str, str]:
    """Return a sentence on the joints whose contact lasts and whose law remembers the last landing, where
    turns repeat.
    """
    motion, measures = result.motion, result.measures
    if motion is None or motion.motion not in ("periodic", "settling"):
        return {}
    names = [name for name in lasting_landings(result.record) if f"{name}.force.max" in measures]
    if not names:
        return {}
    law = result.record.assembly.mechanism.contacts[names[0]].contact.name
    loads = load_words(name for name in raised_loads(result) if not _belongs(name, names))
    listed = f" This includes all that exceeds its ideal value by more than a tenth: {', '.join(loads)}."
    text = (
        f"Joint{'s' * (len(names) > 1)} {', '.join(names)}: the contact never ends, and {law} remembers"
        " the speed of the last landing (of a seated start: impact_speed_floor). Another start or law may"
        " lead to another periodic motion, whose forces and torques lie outside the ranges: up to 15 % away"
        " in crank-rockers, by half in slider-cranks under a constant load, severalfold where a"
        f" motion whirls.{listed * bool(loads)} Compare start.journals"
        ' "seated" and "centred", and other laws. kelvin-voigt remembers no landing: give it as stiffness the'
        " largest force over the largest penetration of the joint in this run, and as damping_coefficient"
        " 1e-4 s times this stiffness."
    )
    return dict.fromkeys(names, text)


def rebound_cautions(mechanism: Mechanism, measures: Iterable[str]) -> tuple[str, ...]:
    """Return the facts about the laws where one of the ``measures`` is of impacts, whose rebound decides."""
    return law_facts(mechanism) if any(name.endswith(OF_IMPACTS) for name in measures) else ()


def damage(result: RunData) -> Iterator[str]:
    """Yield a sentence about unreadable parts of a run file."""
    if blocks := result.record.damaged_parts:
        yield (
            f"The run file is damaged: {', '.join(blocks)} could not be read, and no number includes them;"
            " run the model again."
        )


# --------------------------------------------------------------------------------------- ranges of the models


def out_of_range(result: RunData) -> Iterator[str]:
    """Yield sentences on laws that were used outside their ranges, and one on loads beyond any joint."""
    extremes = contact_extremes(result.record)
    yield from cautions(result.record.assembly.mechanism, extremes)
    if texts := excesses(result, extremes):
        part = result.measures.part
        aside = "" if part == "whole run" else f" (tables: {part})"
        contacts = result.record.assembly.mechanism.contacts.values()
        has_corners = any(hasattr(joint, "corner_radius") for joint in contacts)
        yield (
            f"Beyond what joints are built for, in the whole run{aside}:"
            f" {'; '.join(texts)}. The forces are still those of the laws; check loads, sizes, materials"
            f" and stiffness.{CORNERS * has_corners}"
        )


def excesses(result: RunData, extremes: dict[str, tuple[float, float]]) -> list[str]:
    """Return penetrations and line pressures that no joint is built for; ``extremes``: of
    :func:`contact_extremes`.
    """
    return [*_deep_penetrations(result, extremes), *_high_pressures(result.record)]


def usual_remarks(result: RunData) -> list[str]:
    """Return lines on impacts beyond the theory of the laws, to the extent that is usual in machines."""
    return list(remarks(result.record.assembly.mechanism, contact_extremes(result.record)))


def contact_extremes(record: Record) -> dict[str, tuple[float, float]]:
    """Return the deepest penetration (m) and the fastest impact (m/s) of each joint with clearance over the
    run.
    """
    if not record.assembly.contacts:
        return {}
    depths = record.block("contact_penetration_max").max(axis=0)
    speeds = record.block("contact_fastest")[-1] if record.keeps("contact_fastest") else np.zeros(len(depths))
    fastest = largest_by_joint(record, speeds)
    return {name: (depth, fastest[name]) for name, depth in largest_by_joint(record, depths).items()}


def largest_by_joint(record: Record, values: Iterable[float]) -> dict[str, float]:
    """Return the largest of a non-negative quantity over the contacts of each joint; a block in a guide has
    four.
    """
    largest: dict[str, float] = {}
    for name, value in zip(record.assembly.contact_joints, values, strict=True):
        largest[name] = max(largest.get(name, 0.0), float(value))
    return largest


def _deep_penetrations(result: RunData, extremes: dict[str, tuple[float, float]]) -> Iterator[str]:
    """Yield sentences on penetrations beyond the clearance or a tenth of the pin's radius,
    whichever is less.
    """
    mechanism, penetrations = result.record.assembly.mechanism, list[tuple[str, str]]()
    for name, (depth, _) in extremes.items():
        joint = mechanism.contacts[name]
        pin, clearance = (
            PIN * surfaces(mechanism, joint).journal_radius,
            getattr(joint, "clearance", None) or np.inf,
        )
        limit = (
            f"a clearance of {1e6 * clearance:.4g} µm"
            if clearance < pin
            else f"a tenth of the journal's radius, {1e6 * pin:.4g} µm"
        )
        if depth > min(pin, clearance):
            penetrations.append((limit, f"{_micrometres(depth, 3)} in {name}"))
    yield from (
        f"penetrations of about {', '.join(depths)} are more than {limit}"
        for limit, depths in grouped(penetrations).items()
    )


def _high_pressures(record: Record) -> Iterator[str]:
    """Yield sentences on Hertzian line pressures beyond the hardness of the softer material over the run."""
    mechanism, peaks = record.assembly.mechanism, list[tuple[str, str]]()
    forces = largest_normal_forces(record, full_run(record)) if record.assembly.contacts else ()
    for name, force in largest_by_joint(record, forces).items():
        pair = surfaces(mechanism, mechanism.contacts[name])
        softest = softer(pair.bearing, pair.journal)
        pressure = float(line_pressure(pair, np.asarray(force))[0])
        if softest is not None and pressure > softest[1]:
            default = " (that of joints without axial_length)" * (pair.axial_length == Contact.axial_length)
            length = f"{1e3 * pair.axial_length:.4g} mm{default}"
            pressure_words = f"{1e-9 * pressure:.3g} GPa in {name} on its {length}"
            peaks.append((f"the hardness of {softest[0]}, {1e-9 * softest[1]:.3g} GPa", pressure_words))
    yield from (
        f"line pressures of about {', '.join(pressures)} are more than {limit}"
        for limit, pressures in grouped(peaks).items()
    )


def wide_contacts(result: RunData) -> list[str]:
    """Return the joints whose contact becomes wider than Hertzian theory allows."""
    assembly = result.record.assembly
    widths = [result.measures.get(f"{contact}.contact_half_width.max", 0.0) for contact in assembly.contacts]
    radius = {
        name: surfaces(assembly.mechanism, joint).journal_radius
        for name, joint in assembly.mechanism.contacts.items()
    }
    return [
        name
        for name, width in largest_by_joint(result.record, widths).items()
        if width > CONFORMAL * radius[name]
    ]


def softer(*materials: Material) -> tuple[str, float] | None:
    """Return the softest material of known hardness, and its hardness (Pa); None if all are unknown."""
    hardnesses = [
        (material.name, hard) for material in materials if (hard := hardness_of(material)) is not None
    ]
    return min(hardnesses, key=lambda pair: pair[1], default=None)


def _micrometres(length: float, digits: int) -> str:
    """Return a length (m) whose error is not estimated, with so many digits."""
    return f"{float(f'{1e6 * length:.{digits}g}'):,g} µm"


def _two_digits(value: float) -> str:
    """Return the amount of a number whose error is not estimated, with two digits."""
    return f"{float(f'{abs(value):.2g}'):,g}"
