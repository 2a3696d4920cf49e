"""A mechanism before a run: bodies, joints and laws as numbers (SI), step and cost; the answer of ``vfife
check``.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from ..job.progress import counted
from ..kinematics.forces import driven_body
from ..laws.materials import PAIRS, coefficient
from ..model.bodies import MOST_ELEMENTS, Frame, Link
from ..model.lumping import rigid_properties
from ..model.surfaces import body_of, surfaces
from ..model.wear import deepest
from ..solvers.refinement import DOUBLE, with_elements
from .document import Table
from .freedom import degrees_of_freedom, elastic_shares, redundancy

if TYPE_CHECKING:
    from ..assembly.assembled import Assembly
    from ..laws import Pair
    from ..model.drivers import Driver
    from ..model.joints import Joint
    from ..model.mechanism import Mechanism
    from ..model.wear import Wear

SIZES = ("axial_length", "friction_moment", "landing")  # of all joints with clearance, after their own


@dataclass(frozen=True)
class Checked:
    """A valid mechanism: ``free`` degrees of freedom with ideal joints, ``after_drives`` with drivers,
    ``redundant`` joints.

    ``step`` (s) is the initial step of a run, ``set_by`` its cause; ``notes`` are cautions.
    ``determined_by_elastic``: elastic bodies determine the reactions of redundant joints.
    """

    name: str
    bodies: int
    joints: int
    free: int
    after_drives: int
    redundant: tuple[str, ...]
    step: float
    set_by: str
    notes: tuple[str, ...]
    determined_by_elastic: bool = False

    def __str__(self) -> str:
        counts = f"{self.bodies} {'body' if self.bodies == 1 else 'bodies'}, {counted(self.joints, 'joint')}"
        lines = [f"{self.name}: no faults; {counts}.", degrees_of_freedom(self.free, self.after_drives)]
        if self.redundant:
            lines.append(redundancy("Redundant constraints", self.redundant, self.determined_by_elastic))
        if self.step > 0.0:
            lines.append(f"Step {self.step:.4g} s, set by {self.set_by}.")
        return "\n".join([*lines, *self.notes])

    __repr__ = __str__


def checked(assembly: Assembly, notes: Sequence[str] = ()) -> Checked:
    """Return the summary of an assembled mechanism, with further ``notes``."""
    mechanism, mobility = assembly.mechanism, assembly.mobility
    return Checked(
        name=mechanism.name, bodies=len(mechanism.bodies), joints=len(mechanism.joints), free=mobility.free,
        after_drives=mobility.after_drives,
        redundant=tuple(mobility.redundant_joints) if mobility.redundant else (),
        step=assembly.choice.step, set_by=assembly.choice.culprit, notes=(*assembly.notes, *notes),
        determined_by_elastic=bool(mobility.redundant) and elastic_shares(assembly),
    )  # fmt: skip


# ---------------------------------------------------------------------------------------------------- numbers


def mechanism_parts(mechanism: Mechanism) -> list[Table]:
    """Return tables of the bodies, joints, gears, springs, drivers and loads of a mechanism."""
    pairs: dict[str, Any] = {**mechanism.gears, **mechanism.springs}
    drivers = [
        (name, driver(drive), drive.body or drive.slider or drive.point)
        for name, drive in mechanism.drivers.items()
    ]
    tables = (
        Table(
            ("body", "model", "pins"),
            [(n, b.model, ", ".join(b.points)) for n, b in mechanism.bodies.items()],
            "Bodies",
        ),
        Table(
            ("joint", "what", "bearing", "journal"),
            [(n, j.words, j.bearing, j.journal) for n, j in mechanism.joints.items()],
            "Joints",
        ),
        Table(
            ("name", "what", "between"),
            [(n, pair.words, f"{pair.first} and {pair.second}") for n, pair in pairs.items()],
            "Gears and springs",
        ),
        Table(("driver", "what", "of"), drivers, "Drivers"),
        Table(
            ("load", "what", "at"),
            [(name, load.words, load.place) for name, load in mechanism.loads.items()],
            "Loads",
        ),
    )
    return [table for table in tables if table.rows]


def bodies(assembly: Assembly) -> list[dict[str, Any]]:
    """Return model, mass (kg), inertia about the centre of mass (kg m^2) and centre of mass (m) of
    each body.
    """
    excess = inertia_excess(assembly)
    return [
        {
            "name": name,
            "model": body.model,
            "elements": len(body.elements),
            "mass": body.mass,
            "inertia": body.inertia,
            "center": list(body.center),
            "driver": turned_by(assembly.mechanism, name),
            **({"inertia_excess": excess[name]} if name in excess else {}),
        }
        for name, body in assembly.bodies.items()
    ]


def inertia_excess(assembly: Assembly) -> dict[str, float]:
    """Return by which share (1) the inertia of the particles of elastic bodies exceeds that of infinitely
    many.

    The excess falls with the square of the number of elements, so that twice as many show it. Bent links,
    whose elements do not halve, are left out.
    """
    bodies = {
        name: body
        for name, body in assembly.mechanism.bodies.items()
        if isinstance(body, Frame) or (isinstance(body, Link) and body.model == "elastic" and not body.via)
    }
    excess = {}
    for name, body in bodies.items():
        finer = with_elements(body, DOUBLE)
        if finer is None or 2 * len(assembly.bodies[name].elements) > MOST_ELEMENTS:
            continue
        inertia, fine = assembly.bodies[name].inertia, rigid_properties(finer).inertia
        limit = (4.0 * fine - inertia) / 3.0
        if inertia > limit > 0.0:
            excess[name] = inertia / limit - 1.0
    return excess


def turned_by(mechanism: Mechanism, body: str) -> str | None:
    """Return the description of what turns a body, with its name where that is not the body's; None if
    nothing does.
    """
    turning = [
        driver(item) if name == body else f"{name}: {driver(item)}"
        for name, item in mechanism.drivers.items()
        if driven_body(name, item) == body
    ]
    return "; ".join(turning) or None


def driver(driver: Driver) -> str:
    """Return the description of a driver."""
    return driver.words + (f", against {driver.against}" if driver.against != "ground" else "")


def joints(assembly: Assembly, expected: Mapping[str, float]) -> list[dict[str, Any]]:
    """Return kind, sides, clearance (m), laws and expected force (N) of each joint."""
    mechanism, entries = assembly.mechanism, []
    for name, joint in mechanism.joints.items():
        entry = {
            "name": name,
            "kind": joint.words + (", driven pivot" if name in assembly.pivots else ""),
            "bearing": joint.bearing,
            "journal": joint.journal,
            "expected_force": expected.get(name),
        }
        entries.append(entry | (_contact(mechanism, joint) if name in mechanism.contacts else {}))
    return entries


def _contact(mechanism: Mechanism, joint: Any) -> dict[str, Any]:
    """Return sizes and laws of a joint with clearance."""
    pair = surfaces(mechanism, joint)
    entry = {
        key: getattr(joint, key) for key in (*joint.sizes, *SIZES) if getattr(joint, key, None) is not None
    }
    entry |= {kind: _law(getattr(joint, kind), pair) for kind in ("contact", "friction")}
    entry["contact"] |= {
        "modulus": pair.composite_modulus,
        "exponent": joint.contact.exponent_at(joint.landing, pair),
    }
    if joint.wear is not None:
        entry["wear"] = _wear(joint, joint.wear, pair)
    return entry | {"bearing_material": pair.bearing.name, "journal_material": pair.journal.name}


def _wear(joint: Joint, wear: Wear, pair: Pair) -> dict[str, dict[str, Any]]:
    """Return the body, coefficient of wear (1/Pa), named pair of materials with its source, and initial
    depth (m) of bearing and journal.
    """
    sides: dict[str, dict[str, Any]] = {}
    for side in ("bearing", "journal"):
        value = getattr(wear, side)
        source = {"pair": value, "source": PAIRS[value][1]} if isinstance(value, str) else {}
        depth = {"worn": deepest(profile)} if (profile := getattr(wear, f"{side}_profile")) else {}
        number = coefficient(value, getattr(pair, side))
        sides[side] = {"body": body_of(joint, side), "coefficient": number, **source, **depth}
    return sides


def couplings(assembly: Assembly) -> list[dict[str, str]]:
    """Return name, kind and ends of gears, springs, and drivers whose name is not that of the body
    they turn.
    """
    mechanism = assembly.mechanism
    pairs: dict[str, Any] = {**mechanism.gears, **mechanism.springs}
    couplings = [(name, pair.words, pair.first, pair.second) for name, pair in pairs.items()]
    couplings += [
        (name, f"driver: {driver(drive)}", drive.body or drive.slider or drive.point, "")
        for name, drive in mechanism.drivers.items()
        if name not in mechanism.bodies
    ]
    return [dict(zip(("name", "what", "first", "second"), coupling, strict=True)) for coupling in couplings]


def _law(law: Any, pair: Any) -> dict[str, Any]:
    """Return a law with its parameters, and the numbers derived from them and the two surfaces."""
    parameters = {field.name: getattr(law, field.name) for field in dataclasses.fields(law)}
    return {"law": law.name, "parameters": parameters, "derived": law.derived(pair), "units": law.units(pair)}


def step(assembly: Assembly) -> dict[str, Any]:
    """Return the step (s) with its cause, and all limits."""
    choice = assembly.choice
    origin = {"automatic": choice.automatic, "set_by": choice.culprit}
    return {"size": choice.step, **origin, "stable": choice.stable, "limits": dict(choice.limits)}


# ------------------------------------------------------------------------------------------------------ words
