"""Cautions about the fall of journals onto their bearings at the start of a run."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

from ..measures.landings import Fall, start_fall
from ..solvers.status import Status
from .design_words import and_words

if TYPE_CHECKING:
    from ..model.mechanism import Mechanism
    from ..results.run_data import RunData

MOST_NAMES = 6  # of what has a largest force in the fall at the start
SEATED = 'start.journals = "seated"'


def fall_of(result: RunData) -> Fall | None:
    """Return the fall of the journals at the start, if it makes the largest forces and torques of a run that
    reached its end.
    """
    if result.record.status != Status.COMPLETE:
        return None
    return start_fall(result.record, result.reference.measures if result.reference else {}, result.motion)


def fall_caution(fall: Fall, mechanism: Mechanism, turns: bool) -> str:
    """Return a sentence on a fall at the start that makes the largest forces; ``turns``: of a crank."""
    driven_first = sorted(fall.measures, key=lambda name: "torque" not in name and "actuator_" not in name)
    owners = list(dict.fromkeys(name.partition(".")[0] for name in driven_first))
    listed = owners[:MOST_NAMES] + [f"{len(owners) - MOST_NAMES} more"] * (len(owners) > MOST_NAMES)
    torques = " and torques" if any("torque" in name for name in fall.measures) else ""
    return (
        f"The largest forces{torques} of {and_words(listed)} are those of the first"
        f" {1e3 * fall.time:.3g} ms, in which the journals of {and_words(list(fall.joints))} fall from the"
        " middle onto their bearings: a machine that stands or runs has no such blow."
        f" {fall_remedy(mechanism, fall.joints, turns)}"
    )


def fall_remedy(mechanism: Mechanism, joints: Iterable[str], turns: bool) -> str:
    """Return how a run has no forces of the fall of these ``joints`` at its start."""
    seats = [name for name in joints if name in mechanism.clearances]
    blocks = [name for name in joints if name not in seats]
    sentences = [f"{SEATED} starts without this fall."] if seats else []
    if seats and mechanism.start.journals == "seated":
        sentences = [
            f"{SEATED} has no direction for {and_words(seats)}, whose ideal reaction is zero at the start: go"
            " on from the end of this run, vfife run MODEL --start-from RUN."
        ]
    if blocks:
        subject = f"The slider{'s' * (len(blocks) > 1)} of {and_words(blocks)} cannot start seated"
        leave = "" if turns else ": read the curves after the fall"
        sentences.append(f"{subject}{leave}.")
    if turns:
        sentences.append("Values of two turns or more are those of the last, without the fall.")
    return " ".join(sentences)


def fall_remark(mechanism: Mechanism, turns: bool) -> str:
    """Return a sentence that largest forces may be those of the fall at the start of a run whose measures
    include it; "" where no journal starts free.
    """
    if not (joints := falling_journals(mechanism)):
        return ""
    return (
        f"Largest values may be those of the start, where the journals of {and_words(joints)} fall onto their"
        f" bearings (vfife run states where forces are). {fall_remedy(mechanism, joints, turns)}"
    )


def falling_journals(mechanism: Mechanism) -> list[str]:
    """Return the joints with clearance whose journals start in the middle of their bearings."""
    seated = mechanism.start.journals == "seated"
    return [
        name
        for name, joint in mechanism.contacts.items()
        if getattr(joint, "clearance", None) and not (seated and name in mechanism.clearances)
    ]
