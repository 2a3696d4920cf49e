"""Records of user-defined laws in a run file, and the classes that replace the laws when the file is read.
Reading never executes the text of a law.

A contact law is recorded as a table of its elastic force and energy over the penetration, for each joint that
has it. The table suffices for every number and figure of the run, but not for another run.
"""

from __future__ import annotations

import dataclasses
import types
from bisect import bisect_right
from collections.abc import Mapping, Sequence
from contextlib import AbstractContextManager
from typing import Any, ClassVar

from ..errors import LawError
from ..numerics.scalar import integer_power
from .law import LAWS, ContactLaw, FrictionLaw, Law, Pair, built_in, law_kind, registered_here
from .user import file_of, text_of

POINTS = 401  # of a table, closer together at small depths

Entry = dict[str, Any]


def law_entries(laws: Sequence[tuple[Law, Pair]]) -> list[Entry]:
    """Describe every user-defined law for JSON: name, file with its text, fields, slots, and a table for each
    joint.
    """
    entries: dict[tuple[str, str], Entry] = {}
    for law, pair in laws:
        kind = type(law)
        if built_in(kind) and not issubclass(kind, Recorded):
            continue
        kind_name = law_kind(kind)
        origin = kind.entry if issubclass(kind, Recorded) else {"file": file_of(kind), "text": text_of(kind)}
        entry: Entry = {
            "name": law.name,
            "kind": kind_name,
            "source": law.source,
            "formula": law.formula,
            "slots": list(law.slots),
            "joints": [],
        }
        entry = entries.setdefault(
            (kind_name, law.name), {**entry, "file": origin["file"], "text": origin["text"]}
        )
        joint: Entry = {
            "fields": fields(law),
            "pair": described(pair),
            "p": [float(v) for v in law.parameters(pair)],
        }
        if isinstance(law, ContactLaw):
            joint["table"] = (
                kind.of(joint)["table"] if issubclass(kind, Recorded) else table(law, pair, tuple(joint["p"]))
            )
        if joint not in entry["joints"]:
            entry["joints"].append(joint)
    return list(entries.values())


def fields(law: Law) -> dict[str, Any]:
    """Return the parameters of a law by name."""
    return {field.name: getattr(law, field.name) for field in dataclasses.fields(law)}


def described(pair: Pair) -> Entry:
    """Describe a pair of surfaces for JSON. Hardness is left out: no law uses it, and files of former
    versions do not contain it.
    """
    entries = dataclasses.asdict(pair)
    for side in ("bearing", "journal"):
        del entries[side]["hardness"]
    return entries


def table(law: ContactLaw, pair: Pair, p: tuple[float, ...]) -> list[list[float]]:
    """Return depths (m) up to twice the clearance, or to the smaller radius where surfaces touch from outside
    and have none, and the elastic forces (N) and energies (J) there.
    """
    deepest = 2.0 * pair.clearance or min(pair.bearing_radius, pair.journal_radius)
    depths = [deepest * integer_power(k / (POINTS - 1), 3) for k in range(POINTS)]
    forces = [float(law.force(depth, 0.0, p)[0]) for depth in depths]
    try:
        energies = [float(law.elastic_energy(depth, p)) for depth in depths]
    except NotImplementedError:
        energies = [0.0]
        for k in range(1, POINTS):
            middle = float(law.force(0.5 * (depths[k - 1] + depths[k]), 0.0, p)[0])
            energies.append(
                energies[-1] + (depths[k] - depths[k - 1]) * (forces[k - 1] + 4.0 * middle + forces[k]) / 6.0
            )
    return [depths, forces, energies]


class Recorded(Law, register=False):
    """Base of the classes that replace a user-defined law of a run file."""

    entry: ClassVar[Entry] = {}

    def parameters(self, pair: Pair) -> tuple[float, ...]:
        """Return the parameters that were recorded for these surfaces."""
        return tuple(self.of({"fields": fields(self), "pair": described(pair)})["p"])

    @classmethod
    def of(cls, joint: Mapping[str, Any]) -> Entry:
        """Return the record of these parameters and surfaces. Raises LawError for others."""
        for joint_entry in cls.entry["joints"]:
            if joint_entry["fields"] == joint["fields"] and joint_entry["pair"] == joint["pair"]:
                return dict(joint_entry)
        raise LawError(
            f"law {cls.name!r} is known from a run file only, for the joints of that run; to use it"
            f" otherwise, load {cls.entry['file']} (--laws)"
        )


class RecordedContact(Recorded, ContactLaw, register=False):
    """A contact law as a table."""

    @classmethod
    def row(cls, depth: float, p: tuple[float, ...]) -> tuple[float, float]:
        """Return elastic force (N) and energy (J) at a depth (m); the force is linear between points and
        beyond.
        """
        depths, forces, energies = next(
            joint_entry["table"] for joint_entry in cls.entry["joints"] if tuple(joint_entry["p"]) == tuple(p)
        )
        k = min(max(bisect_right(depths, depth), 1), len(depths) - 1)
        share = (depth - depths[k - 1]) / (depths[k] - depths[k - 1])
        step = share * (depths[k] - depths[k - 1])
        force = forces[k - 1] + share * (forces[k] - forces[k - 1])
        area = (depths[k] - depths[k - 1]) * 0.5 * (forces[k] + forces[k - 1])
        part = (
            step * 0.5 * (forces[k - 1] + force)
        )  # the straight force's own work, stretched to that of the interval
        return force, energies[k - 1] + (part * (energies[k] - energies[k - 1]) / area if area > 0.0 else 0.0)

    def elastic_energy(self, penetration: Any, p: tuple[float, ...]) -> Any:
        """Return the energy (J) from the table, for a depth or an array of depths."""
        if hasattr(penetration, "shape") and penetration.shape:
            return [self.row(float(depth), p)[1] if depth > 0.0 else 0.0 for depth in penetration]
        return self.row(float(penetration), p)[1]


class RecordedFriction(Recorded, FrictionLaw, register=False):
    """A friction law of which the parameters are known, and not the force."""

    @property
    def dissipative(self) -> bool:
        """False, as of every law of the user's own."""
        return False


def stand_in(entry: Entry) -> type[Law]:
    """Create a class with the fields of a recorded law, which can be read and written but not run."""
    contact = entry["kind"] == "contact"
    values: dict[str, Any] = {}
    for joint in entry["joints"]:
        values |= {name: value for name, value in joint["fields"].items() if values.get(name) is None}
    space: dict[str, Any] = {
        "__module__": __name__,
        "__doc__": entry["formula"],
        "__annotations__": {name: type(value) for name, value in values.items()},
        **{
            "name": entry["name"],
            "source": entry["source"],
            "formula": entry["formula"],
            "slots": tuple(entry["slots"]),
            "entry": entry,
        },
    }
    for name in values:
        space[name] = dataclasses.field(default=None, metadata={"unit": "1", "meaning": "as it was recorded"})
    law = types.new_class(
        "Recorded",
        (RecordedContact if contact else RecordedFriction,),
        {"register": False},
        lambda named: named.update(space),
    )
    if contact:
        law.force = staticmethod(lambda penetration, slowness, p: (law.row(penetration, p)[0], 0.0))  # type: ignore[attr-defined]
    law_class: type[Law] = dataclasses.dataclass(frozen=True, kw_only=True)(law)
    return law_class


def refuse_recorded(laws: Sequence[type]) -> None:
    """Raise LawError for a law that is known only from a run file, because it cannot be run."""
    for law in laws:
        if issubclass(law, Recorded):
            file = law.entry["file"]
            raise LawError(
                f"law {law.name!r} is known from a run file only, which does not run code; load its file"
                f" first: {file} (--laws)"
            )


def standing_in(entries: Sequence[Entry]) -> AbstractContextManager[None]:
    """Register the laws of a run file while its model is read, except laws that are loaded with the same
    text.
    """
    return registered_here([stand_in(entry) for entry in entries if not _loaded(entry)])


def _loaded(entry: Entry) -> bool:
    """Return whether the law itself is known: it was loaded from the same text."""
    law = LAWS[entry["kind"]].registry.get(entry["name"])
    return law is not None and not built_in(law) and text_of(law) == entry["text"]
