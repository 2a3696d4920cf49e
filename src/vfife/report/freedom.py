"""Degrees of freedom of a mechanism as data and in sentences: redundant and shared constraints, singular
positions, blocked motions, the class of a four-bar.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from ..job.progress import counted
from ..model.bodies import ELASTIC, Frame

if TYPE_CHECKING:
    from ..assembly.assembled import Assembly


def freedom(assembly: Assembly) -> dict[str, Any]:
    """Return degrees of freedom of the ideal mechanism, redundant and singular joints, and the class of a
    four-bar.
    """
    from ..kinematics.mobility import grashof

    mobility = assembly.mobility
    return {
        "free": mobility.free,
        "after_drives": mobility.after_drives,
        "redundant": mobility.redundant,
        "redundant_joints": list(mobility.redundant_joints),
        **({"determined_by_elastic": True} if mobility.redundant and elastic_shares(assembly) else {}),
        "shared": list(assembly.shared),
        "singular": list(mobility.singular),
        "blocked": mobility.blocked,
        "four_bar": grashof(assembly.mechanism),
    }


def freedom_words(freedom: Mapping[str, Any]) -> list[str]:
    """Return sentences on the degrees of freedom."""
    lines = [degrees_of_freedom(freedom["free"], freedom["after_drives"])]
    if freedom["redundant"]:
        lines.append(
            redundancy(
                counted(freedom["redundant"], "redundant constraint"),
                freedom["redundant_joints"],
                freedom.get("determined_by_elastic", False),
            )
        )
    if freedom["shared"]:
        lines.append(f"Shared by least norm, not unique: {', '.join(freedom['shared'])}.")
    if freedom["singular"]:
        lines.append(
            "The start is a singular position (a change point or dead centre), at"
            f" {', '.join(freedom['singular'])}: the constraints of these joints coincide only there. The"
            " branch that the motion takes from here is not determined; start slightly off this position."
        )
    if freedom["blocked"]:
        lines.append(
            "The joints allow an infinitesimal motion only: links lie on a line, where forces along them have"
            " no component across it."
        )
    if freedom["four_bar"]:
        lines.append(f"Four-bar: {freedom['four_bar']}.")
    return lines


def degrees_of_freedom(free: int, after_drives: int) -> str:
    """Return a sentence on the degrees of freedom without and with drives."""
    driven = f"; {after_drives} when driven" if after_drives != free else ""
    return f"Degrees of freedom with ideal joints: {free}{driven}."


def elastic_shares(assembly: Assembly) -> bool:
    """Return whether elastic bodies determine every reaction, those of redundant joints among them."""
    bodies = assembly.mechanism.bodies.values()
    return not assembly.shared and any(body.model in (*ELASTIC, Frame.model) for body in bodies)


def redundancy(constraints: str, joints: Sequence[str], by_elastic: bool = False) -> str:
    """Return a sentence on redundant ``constraints`` and their joints; ``by_elastic``: bodies that are
    elastic determine the reactions.
    """
    reason = (
        "the elastic bodies determine how these joints share their load; rigid ones would not"
        if by_elastic
        else "rigid links do not determine how these joints share their load"
    )
    return f"{constraints}, at {', '.join(joints)}: {reason}."


def freedom_left(assembly: Assembly) -> int:
    """Return the degrees of freedom of the ideal mechanism that drivers leave; 0 where none prescribes a
    motion.
    """
    driven = any(driver.moves for driver in assembly.mechanism.drivers.values())
    return assembly.mobility.after_drives if driven else 0


def freedom_left_words(run: Mapping[str, Any]) -> str:
    """Return how many degrees of freedom drivers leave in a run, a part of its summary; "" for none."""
    left = run.get("free_when_driven", 0)
    return f"{left} degree{'s' * (left != 1)} of freedom left when driven" if left else ""
