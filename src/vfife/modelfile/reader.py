"""Objects from the tables of a model file: each key is read by its field; faults have their places; the rest
is kept.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from ..errors import Fault, Path, article, shown, suggestion
from ..laws import MATERIALS, Material
from ..laws.law import law_kind
from ..model.bodies import Section
from ..model.joints import Contact
from ..model.mechanism import Mechanism, Settings, StartSettings
from ..model.readers import idle, read_law, read_section
from ..schema import A_TABLE, Choice, Reader, Text, partial
from .tables import (
    FAMILIES,
    SECTIONS,
    TARGETS,
    Raw,
    Table,
    keys_at,
    kind_table,
    kinds_of,
    strangeness,
    table,
    tables,
    target_of,
)


def driver_of(by: Written, path: Path, holder: Any) -> Any:
    """Return the driver that the keys determine; None if they determine none."""
    if not isinstance(holder, dict):
        by.unexpected(path, holder, *A_TABLE)
        return None
    target = target_of(holder)
    kinds = [kind for kind in tables("driver") if kind.target == target]
    leads: dict[str, list[Table]] = {}
    for kind in kinds:
        leads.setdefault(lead(kind), []).append(kind)
    leading = [key for key in leads if key in holder]
    leading = [
        key
        for key in leading
        if not any(key in kind.fields for rival in leading if rival != key for kind in leads[rival])
    ]
    strange = {lead(kind) for kind in tables("driver")} & set(holder) - set(leads)
    if len(leading) != 1 and not strange:
        sentence = (
            f"{' and '.join(leading)} exclude each other"
            if leading
            else "the motion or force of the driver is missing"
        )
        by.refuse((*path, ""), sentence, "", limits(leads), "give one of these")
    among = leads[leading[0]] if len(leading) == 1 else kinds
    kind = min(among, key=lambda candidate: strangeness(candidate, holder))
    values: dict[str, Any] = {} if target != "body" or "body" in holder else {"body": path[1]}
    fault_count = len(by.faults)
    for key, value in holder.items():
        users = (
            [kind] if key in kind.fields else [candidate for candidate in kinds if key in candidate.fields]
        )
        if not users:
            unknown(by, (*path, key), target, value)
        elif users[0] is kind or len(leading) != 1:
            values[users[0].fields[key].name] = users[0].value(key).read(value, (*path, key), by)
        else:
            owners = dict.fromkeys(map(lead, users))
            by.refuse(
                (*path, key),
                f"{key} goes with {' or '.join(owners)}, not with {leading[0]}",
                shown(value),
                "",
                "remove it",
            )
    if len(leading) != 1:
        return None
    by.shapes.append((path, kind, holder))
    for key in kind.needed:
        if key not in holder:
            sentence = (
                f"{leading[0]} and {key} go together, and {key} is missing"
                if key.endswith("s")
                else f"{leading[0]} needs a {key}, which is missing"
            )
            by.refuse((*path, key), sentence, remedy="add it")
    return by.build(kind.model_class, values, fault_count)


def lead(kind: Table) -> str:
    """Return the key that determines a kind."""
    return str(kind.model_class.lead_keys(kind.is_linear))


def limits(leads: dict[str, list[Table]]) -> str:
    """Return a text on the keys that determine kinds, and those that belong to them."""
    words = []
    for key, kinds in leads.items():
        companions = [
            name for kind in kinds for name in kind.fields if name not in TARGETS[kind.target] and name != key
        ]
        needed = {name for kind in kinds for name in kind.needed} if len(kinds) == 1 else set()
        must, may = (
            [name for name in companions if name in needed],
            [name for name in companions if name not in needed],
        )
        words.append(
            key
            + (f" with {' and '.join(must)}" if must else "")
            + (f" (with {' or '.join(may)})" if may else "")
        )
    return ", or ".join((", ".join(words[:-1]), words[-1]))


def unknown(by: Written, path: Path, target: str, value: Any) -> None:
    """Report a key that no driver of this target has."""
    key, keys = str(path[-1]), keys_at(path[:-1]) or ()
    if key not in keys:
        by.unknown(path, value)
        return
    efforts = {lead(kind) for kind in tables("driver") if not kind.model_class.moves}
    remedy = "remove it; a force acts on a point, a torque on a body" if key in efforts else "remove it"
    by.refuse(path, f"a driver of a {target} has no such key", shown(value), "", remedy)


def merged(target: str) -> dict[str, tuple[Table, bool]]:
    """Return the keys of all drivers of a target, each with a table that has it and whether it is
    required.
    """
    keys: dict[str, tuple[Table, bool]] = {}
    for kind in tables("driver"):
        if kind.target == target:
            for key in (*TARGETS[target], *kind.fields):
                keys.setdefault(key, (kind, key == target and target != "body"))
    return keys


class Written(Reader):
    """Reader of a model file. ``shapes`` are the tables read, by path; ``paths_set`` the paths of values that
    do not stand in the file; ``materials_used`` the names of the materials that something is made of.
    """

    def __init__(self, raw: Raw, paths_set: set[Path]) -> None:
        super().__init__(written=True)
        self.raw, self.given = raw, paths_set
        self.materials: dict[str, Material | None] = dict(MATERIALS)
        self.shapes: list[tuple[Path, Table, Raw]] = []
        self.materials_used: set[str] = set()

    def add(self, fault: Fault) -> None:
        """Add a fault; one of a value outside the file is marked."""
        super().add(fault.at(fault.path, self.given))

    def mechanism(self) -> Mechanism:
        """Return the mechanism, with only the valid values."""
        raw, top = self.raw, Table(Mechanism)
        for key, value in raw.items():
            if key not in (*top.keys, "material"):
                self.unknown((key,), value)
            elif not isinstance(value, dict) and key in ("material", *SECTIONS):
                self.unexpected((key,), value, *A_TABLE)
        for name, holder in table(raw, "material").items():
            self.materials[name] = self.table(("material", name), tables("material")[0], holder, name=name)
        values: dict[str, Any] = {}
        for key in ("name", "note", "gravity", "ground"):
            if key in raw:
                values[top.fields[key].name] = top.value(key).read(raw[key], (key,), self)
        values["points"] = values.get("points") or {}
        values["settings"] = self.table(("run",), Table(Settings), raw.get("run", {}))
        values["start"] = self.table(("start",), Table(StartSettings), raw.get("start", {}))
        for section in SECTIONS:
            values[top.fields[section].name] = {
                name: self.entry(section, name, holder) for name, holder in table(raw, section).items()
            }
        return Mechanism(**values)

    def entry(self, section: str, name: str, holder: Any) -> Any:
        """Return a body, joint, gear, spring, driver or load; None if nothing of it is known."""
        path: Path = (section, name)
        if section == "driver":
            return driver_of(self, path, holder)
        kind = kinds_of(section, holder)[0]
        item = self.table(path, kind, holder, name=name)
        if isinstance(item, Contact) and self.materials["steel"] != Material():
            # A body brings its own material; the ground is of steel, also where the file says what steel is.
            unsaid = [
                f"{side}_material"
                for side in ("bearing", "journal")
                if (getattr(item, side) or "").startswith("ground.")
            ]
            steel = {key: self.materials["steel"] for key in unsaid if key not in holder}
            self.materials_used |= {"steel"} if steel else set()
            item = partial(type(item), vars(item) | steel)
        return item

    def table(self, path: Path, kind: Table, holder: Any, **values: Any) -> Any:
        """Return the object of a table."""
        if not isinstance(holder, dict):
            self.unexpected(path, holder, *A_TABLE)
            return None
        self.shapes.append((path, kind, holder))
        fault_count = len(self.faults)
        for key, value in holder.items():
            if key == kind.tag:
                Choice((kind.word,), kind.foreign).read(value, (*path, key), self)
            elif key not in kind.fields:
                self.unknown((*path, key), value)
            else:
                read = kind.value(key).read(value, (*path, key), self)
                if users := kind.idle(key, holder):
                    self.idle((*path, key), kind, holder, users)
                else:
                    values[kind.fields[key].name] = read
        for key in kind.needed:
            if key not in holder:
                self.lacking((*path, key), kind, holder)
        for key, field in kind.fields.items():
            if key not in holder and field.default_factory is Material:  # of steel, as the file has it
                values[field.name] = self.materials[Material().name]
                self.materials_used.add(Material().name)
        return self.build(kind.model_class, values, fault_count)

    def inner(self, path: Path, kind: type, value: Any) -> Any:
        """Return a nested object; a section may be given by its shape."""
        if kind is Section and isinstance(value, dict):
            return read_section(self, path, value)
        return self.table(path, Table(kind), value)

    def named(self, path: Path, kind: type, value: Any) -> Any:
        """Return a material by name."""
        name = Text().read(value, path, self)
        if name is not None and name not in self.materials:
            remedy = suggestion(name, self.materials, f"add a table [material.{name}]")
            self.refuse(path, "there is no material of this name", shown(name), "", remedy)
        self.materials_used |= {name} if name is not None else set()
        return self.materials.get(name)

    def chosen(self, path: Path, base: type, value: Any) -> Any:
        """Return a law from its table."""
        if not isinstance(value, dict):
            self.unexpected(path, value, *A_TABLE)
            return None
        law, faults = read_law(law_kind(base), value)
        for fault in faults:
            self.add(fault.at((*path, *fault.path)))
        return law

    def idle(self, path: Path, kind: Table, holder: Raw, users: tuple[str, ...]) -> None:
        """Report a key that the link model or kind of analysis does not use."""
        chooser = kind.fields[kind.model_class.selected_by]
        word = holder.get(chooser.name, chooser.default)
        self.add(idle(kind.model_class, word, users, holder[str(path[-1])]).at(path))

    def unknown(self, path: Path, value: Any, names: Iterable[str] = ()) -> None:
        """Report a key that the table does not have, or that only another kind has."""
        key, parent = str(path[-1]), path[:-1]
        names, holder = keys_at(parent) or (), table(self.raw, *parent)
        if key == "$schema" and not parent:
            remedy = "write it as a comment in the first line: #:schema PATH"
            self.refuse(path, "the schema is not a key of the model", shown(value), "", remedy)
        elif key in names and parent:
            self.add(other_kind(str(parent[0]), key, holder, shown(value)).at(path))
        else:
            super().unknown(path, value, names)

    def lacking(self, path: Path, kind: Table, holder: Raw) -> None:
        """Report a missing key."""
        key, remedy = path[-1], "add it"
        if key == "kind" and path[0] in FAMILIES:
            plain = next(candidate for candidate in tables(str(path[0])) if candidate.optional)
            alternative = (
                f", or remove what {article(plain.word)} joint does not have" if path[0] == "joint" else ""
            )
            remedy = f'add kind = "{kind.word}"{alternative}'
        elif path[0] == "body" and key == "length":
            remedy = "add it; a rigid body that is no link has mass, inertia and pins instead"
        elif path[0] == "body" and key == "inertia" and "length" not in holder:
            remedy = "add it; a link has a length instead"
        self.refuse(path, "this key is missing", remedy=remedy)


def other_kind(section: str, key: str, holder: Raw, value: str) -> Fault:
    """Return the fault for a key that only another kind of body, joint, spring or driver has."""
    if section in FAMILIES:
        word = kind_table(section, holder).word
        # First the kind that the rest of the table suits best.
        bare = {name: entry for name, entry in holder.items() if name != "kind"}
        users = [
            kind.word
            for kind in sorted(tables(section), key=lambda kind: strangeness(kind, bare))
            if key in kind.fields
        ]
        alternative = f" (or {', '.join(users[1:])})" if len(users) > 1 else ""
        named = f"{article(word)} joint" if section == "joint" else f"a {section} of kind {word}"
        return Fault(
            "", f"{named} has no such key", value, "", f'set kind = "{users[0]}"{alternative}, or remove it'
        )
    length = "with" if "length" in holder else "without"
    problem = f"a body of this kind ({holder.get('model', 'rigid')}, {length} a length) has no such key"
    return Fault(
        "", problem, value, "", "remove it, or give the body the model and the length that go with it"
    )
