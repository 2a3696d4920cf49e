"""Cautions about largest forces that the contact law decides: by its damping, or because shocks make
them: knocks, or blows in closed contact; and about all loads that a shock passes on.

Whether a caution appears depends on the share of turns of the run and its companions, not on the single shock
that holds the peak.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable, Mapping
from typing import TYPE_CHECKING

from ..laws.contact.forms import PointContact
from ..measures.forces import ground_joints
from ..measures.turn_peaks import (
    LEAST_LOAD,
    LOAD_RATIO,
    RAISED,
    DampedPeaks,
    RaisedPeaks,
    contact_laws,
    damped_peaks,
    peak_columns,
    raised_peaks,
    shock_loads,
)
from ..numerics.outward import DOWN, significant
from .amounts import prefixed

if TYPE_CHECKING:
    from ..laws import ContactLaw
    from ..model.joints import Contact
    from ..model.mechanism import Mechanism
    from ..results.run_data import RunData

# Share of the turns from which on their largest forces are mentioned: means and ranges contain every turn.
TURNS = 0.1
# Rate over the speed of the onset beyond which a contact was struck while it was closed: in a free impact the
# rate is never larger than at the onset.
STRUCK = 1.1
# Width of the range of a force over its value from which on its motion is sensitive.
SENSITIVE_FORCE = 0.1
# Times the ideal force from which on a shock is a quarter of a force or more: then the law moves the force
# by more than a narrow range. At 1.34 times the ideal force damped laws agreed within 4 % (four_bar,
# four_bar_case_c), at 1.42 times within 24 % (the template slider-crank).
SHOCK = 1.4
ENDINGS, ACTUATOR = ("force.max", "moment.max", "torque.max"), ".actuator_"
SHAKING = "ground.shaking_force.max", "ground.shaking_moment.max"
# Laws of a comparison, from no loss of energy to much.
COMPARED = "hertz", "lankarani-nikravesh", "gonthier"


def damping_cautions(result: RunData) -> dict[str, str]:
    """Return a sentence on each joint whose largest force is mostly damping in a tenth of the turns or more,
    with what bounds it. For a joint without shocks a tenth of the turns of one lane suffices, because of
    companions only the least shares are known.
    """
    mechanism, shocks = result.record.assembly.mechanism, _shock_counts(result)
    sentences = {}
    for name, peaks in damped_peaks(result.record, result.motion).items():
        if peaks.damped < TURNS * peaks.turns and (name in shocks or peaks.frequency < TURNS):
            continue
        share = significant(100.0 * peaks.largest.share, 2, DOWN)
        amount = f"at least {share} % of its largest force"
        if peaks.damped < peaks.turns:
            count = f"at least {peaks.damped} of {peaks.turns} turns{_of_lanes(result)}"
            amount = f"in {count} more than half of its largest force ({share} % or more in one)"
        sentences[name] = (
            f"Joint {name}: {amount} is damping of the contact law. The range covers the step, not the law:"
            f" {comparison(mechanism, [name])}. {_cause(peaks, mechanism.contacts[name])}"
        )
    return sentences


def shock_cautions(result: RunData, exceptions: Iterable[str]) -> dict[str, str]:
    """Return one sentence for all joints whose largest force is made by a shock in a tenth of the turns or
    more (:func:`_shock_counts`, :func:`_hard_shock_counts`); without ``exceptions``, which have a caution
    already.
    """
    mechanism, laws = result.record.assembly.mechanism, contact_laws(result.record)
    shocks = _hard_shock_counts(result) | _shock_counts(result)
    counts = {name: peaks for name, peaks in shocks.items() if name not in exceptions}
    if not counts:
        return {}
    undamped = [name for name in counts if _is_undamped(*laws[name])]
    law = f" ({mechanism.contacts[undamped[0]].contact.name} without damping)" if undamped else ""
    text = (
        f"Joint{'s' * (len(counts) > 1)} {_listed(counts, _of_lanes(result))}: shocks (knocks, or blows in"
        f" closed contact) make the largest force. Its range covers the step, not the contact law{law}, which"
        " decides how hard shocks are:"
        f" {comparison(mechanism, counts)}."
    )
    return dict.fromkeys(counts, text)


def certain_shocks(result: RunData, joints: Iterable[str]) -> list[str]:
    """Return those of ``joints`` with a shock in their force that hardly depend on the step."""
    uncertain = _shock_counts(result)
    return [name for name in joints if name not in uncertain]


def load_cautions(result: RunData, sources: Collection[str]) -> dict[str, str]:
    """Return one sentence for all loads, by the name of their measure, that the shocks in ``sources`` make:
    forces of other joints, moments, torques of drivers and shaking forces.
    """
    if not sources or result.reference is None or result.record.static:
        return {}
    ideal = result.reference.measures
    counts = shock_loads(result.record, ideal, result.motion, sources)
    loads = [
        name
        for name, peaks in counts.items()
        if name in result.measures and peaks.raised >= max(TURNS * peaks.turns, 1.0)
    ]
    struck = {*sources, *(name.removesuffix(".force.max") for name in loads)}
    if struck & {*ground_joints(result.record)}:
        loads += [
            name for name in SHAKING if result.measures.get(name, 0.0) > LOAD_RATIO * ideal.get(name, 1e300)
        ]
    if not loads:
        return {}
    text = (
        f"Shocks in {', '.join(sources)} make the largest values of all that they load, too:"
        f" {', '.join(load_words(loads))}. The contact law decides these as well: compare them under the same"
        " laws."
    )
    return dict.fromkeys(loads, text)


def raised_loads(result: RunData) -> list[str]:
    """Return the measures of forces of joints, moments, torques, actuators and shaking forces that exceed
    those of the ideal mechanism by more than a tenth; none without that mechanism, and of statics.
    """
    if result.reference is None or result.record.static:
        return []
    ideal, measures = result.reference.measures, result.measures
    names = [*peak_columns(result.record), *(name for name in measures if ACTUATOR in name)]
    groups = [[name for name in names if name.endswith(ending)] for ending in ENDINGS]
    loads = [
        name
        for group in (*groups, SHAKING[:1], SHAKING[1:])
        for name in group
        if name in measures and name in ideal
        if measures[name] > LOAD_RATIO * ideal[name]
        if measures[name] > LEAST_LOAD * max(measures.get(load, 0.0) for load in group)
    ]
    return sorted(loads, key=[*names, *SHAKING].index)


def load_words(loads: Iterable[str]) -> list[str]:
    """Return measures of loads in words; a joint whose force is among them by its name alone."""
    words = []
    for name in (names := list(loads)):
        item, kind = name.removesuffix(".max").rsplit(".", 1)
        if kind != "moment" or f"{item}.force.max" not in names:
            subject = "" if item == "ground" else item
            words.append(
                item if kind == "force" else f"{kind.replace('_', ' ')} {'of ' * bool(subject)}{subject}"
            )
    return [word.strip() for word in words]


def law_words(
    dependent: Collection[str], shocks: Collection[str], loads: Iterable[str], compared: bool = True
) -> str:
    """Return which forces the contact law decides: of the joints ``dependent`` more than the step does, of
    ``shocks`` as the step does, and of all ``loads`` that these shocks make; these are not known where the
    run is not ``compared`` with an ideal mechanism.
    """
    open_end = "" if compared else "; which other loads do is not known without an ideal mechanism"
    plural = len(dependent) + len(shocks) > 1
    passed = ", ".join(load_words(loads))
    loaded = [f"all that {'they load' if plural else 'it loads'} ({passed})"] * bool(passed)
    if not dependent:
        force = "forces" if len(shocks) > 1 else "force"
        objects = " and ".join([f"the {force} of {', '.join(shocks)}", *loaded])
        return f"The contact law decides {objects}, too"
    rest = [f"{'those' if len(shocks) > 1 else 'that'} of {', '.join(shocks)}"] * bool(shocks) + loaded
    do = "does" if len(rest) == 1 and len(shocks) < 2 else "do"
    too = f", and so {do} {' and '.join(rest)}" * bool(rest)
    force, depend = ("forces", "depend") if len(dependent) > 1 else ("force", "depends")
    lead = f"The {force} of {', '.join(dependent)} {depend} more on the contact law than on the step"
    return f"{lead}{too}{open_end}"


def comparison(mechanism: Mechanism, joints: Iterable[str]) -> str:
    """Return how to find out by how much the contact law moves the forces of ``joints``: the command that
    compares laws of pins, changes for others.
    """
    names = list(joints)
    if all(name in mechanism.clearances for name in names):
        used = [mechanism.contacts[name].contact.name for name in names]
        laws = ",".join(dict.fromkeys([*used, *COMPARED]))
        return f"vfife compare MODEL --contact {laws} --companions 3, with the other options of this run"
    changes = [(name, law_change(mechanism.contacts[name].contact)) for name in names]
    options = " ".join(f"--set joint.{name}.contact.{change}" for name, change in changes if change)
    return f"run it again with {options}" if options else "run it again with another law"


def law_change(law: ContactLaw) -> str:
    """Return a change of a law that decides how much energy a shock loses, as ``key=value``; "" for none."""
    if isinstance(factor := getattr(law, "damping", None), str):
        return "damping=gonthier" if factor == "none" else "damping=none"
    if (damping := getattr(law, "damping_coefficient", 0.0)) > 0.0:
        return f"damping_coefficient={10.0 * damping:g}"
    if isinstance(law, PointContact):
        return "law=hertz"
    return "restitution=0.1" if hasattr(law, "restitution") else ""


def _shock_counts(result: RunData) -> dict[str, RaisedPeaks]:
    """Return the joints whose forces the step moves and whose largest force is made by a shock in a tenth of
    the turns or more.
    """
    counts = _raised(result, RAISED)
    return {name: peaks for name, peaks in counts.items() if _is_sensitive(result, name)}


def _hard_shock_counts(result: RunData) -> dict[str, RaisedPeaks]:
    """Return the joints whose largest force exceeds the ideal one by 40 % in a tenth of the turns or
    more: whether the step moves it or not, the law decides a quarter of it or more.
    """
    return _raised(result, SHOCK)


def _raised(result: RunData, ratio: float) -> dict[str, RaisedPeaks]:
    if result.reference is None or result.record.static:
        return {}
    laws = contact_laws(result.record)
    counts = raised_peaks(result.record, result.reference.measures, result.motion, ratio)
    return {
        name: peaks
        for name, peaks in counts.items()
        if name in laws and peaks.raised >= max(TURNS * peaks.turns, 1.0)
    }


def _listed(counts: Mapping[str, RaisedPeaks], lanes: str) -> str:
    """Return names of joints, each with its number of turns where that is not all of them."""
    return ", ".join(
        name if peaks.raised == peaks.turns else f"{name} (in {peaks.raised} of {peaks.turns} turns{lanes})"
        for name, peaks in counts.items()
    )


def _is_undamped(law: ContactLaw, p: tuple[float, ...]) -> bool:
    """Return whether a law loses no energy, at a penetration (m) and an impact speed (m/s) of no import."""
    return law.force(1e-6, 1.0, p)[1] == 0.0


def _is_sensitive(result: RunData, name: str) -> bool:
    """Return whether the largest force of a joint scatters by chance, or depends on the step."""
    if result.motion is not None and result.motion.motion == "not repeating":
        return True
    force = result.measures.get(f"{name}.force.max")
    return force is not None and force.estimated and force.width > SENSITIVE_FORCE * abs(force.value)


def _of_lanes(result: RunData) -> str:
    return "" if result.record.companions is None else " of the run and its companions"


def _cause(peaks: DampedPeaks, joint: Contact) -> str:
    """Return why damping is large, and which settings bound it."""
    law, ratio, onset = joint.contact, peaks.ratio, peaks.largest.onset
    if math.isnan(ratio):
        return f"It depends on the damping of {law.name}."
    if ratio <= STRUCK:
        restitution, factor = (getattr(law, key, math.nan) for key in ("restitution", "damping_factor"))
        return (
            f"It follows from the restitution of {restitution:.4g}, a damping factor of {factor:.3g}: compare"
            " another restitution too."
        )
    floor = prefixed(joint.impact_speed_floor, "m/s")
    began = "slowly" if math.isnan(onset) else f"at {prefixed(onset, 'm/s')}"
    speed = joint.impact_speed_floor if math.isnan(onset) else onset
    rate = prefixed(float(f"{ratio * speed:.1g}"), "m/s")
    return (
        f"The damping of {law.name} is proportional to the rate over the speed of the onset; a contact that"
        f" began {began} was struck while closed, at {significant(ratio, 2, DOWN)} times that speed or more."
        f" impact_speed_floor ({floor} here) bounds it too: compare {rate}."
    )
