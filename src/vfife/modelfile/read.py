"""TOML text -> mechanism: values set by path, keys, units and limits, checks across tables; all faults at once."""

from __future__ import annotations

import re
import tomllib
from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path as FilePath
from typing import Any

from pydantic import ValidationError

from ..errors import Fault, ModelError, Path, kind_of, place, shown, suggestion
from ..model.mechanism import Mechanism, Settings
from .build import build, unsuited
from .check_bodies import check_body
from .check_drivers import check_drivers, check_loads
from .check_joints import check_gears, check_joints, check_springs
from .checks import EFFORTS, Checks, article
from .override import override
from .schema import CLEARANCE_ONLY, JOINT_TABLES, SPRING_TABLES, ModelFile, driver_kind, joint_kind, spring_kind
from .tables import Raw, entries, known_keys, table
from .write import dump

Items = Iterable[tuple[str, Any]]


def load(path: str | FilePath, set: Items = ()) -> Mechanism:
    """The mechanism of a model file.

    ``set`` holds (path, value) pairs that replace or add values before anything is checked, as in
    ("joint.C.clearance", "0.5 mm"); "joint.coupler-follower" stands for the joint that connects the two bodies. A text
    is read as TOML if it is that, else as it stands. Where a ``model``, a ``kind`` or a ``law`` is set, keys beside it
    in the file that the new one has no use for are dropped. Raises ModelError with every fault of the file.
    """
    try:
        text = FilePath(path).read_bytes().decode("utf-8-sig")
    except OSError as error:
        remedy = "check the name" if isinstance(error, FileNotFoundError) else "name a file that can be read"
        raise ModelError([Fault("file", f"it cannot be read ({error.strerror})", "", "", remedy)], str(path)) from None
    except UnicodeDecodeError as error:
        fault = Fault(f"byte {error.start}", "the text is not UTF-8", "", "", "save the file in this encoding")
        raise ModelError([fault], str(path)) from None
    return loads(text, set, file=str(path))


def loads(text: str, set: Items = (), *, file: str | None = None) -> Mechanism:
    """The mechanism of a model file's text; ``file`` names it in messages. See :func:`load`."""
    known_as = file or "model"
    try:
        raw = tomllib.loads(text)
    except (ValueError, RecursionError) as error:
        raise ModelError([syntax_fault(text, error)], known_as) from None
    faults, given = override(raw, set)
    model = None
    try:
        model = ModelFile.model_validate(raw)
    except ValidationError as error:
        faults += [schema_fault(raw, dict(entry), given) for entry in error.errors(include_url=False)]
    faults += across(raw, given)
    if model is None or faults:
        raise ModelError(faults, known_as)
    mechanism = build(model, file)
    faults = unsuited(mechanism)
    if faults:
        raise ModelError(faults, known_as)
    return mechanism


def examined(mechanism: Mechanism) -> None:
    """Raises ModelError with every fault that a file of this mechanism would have, so that Python hears the same sentences.

    What no file can hold, as laws and bodies of one's own or two materials of one name, is not examined, nor are settings of a static analysis,
    which tell their own faults.
    """
    if mechanism.settings.analysis == "static":
        mechanism = replace(mechanism, settings=Settings())
    try:
        text = dump(mechanism)
    except (TypeError, ValueError):
        return
    laws = {type(law) for joint in mechanism.contacts.values() for law in (joint.contact, joint.friction)}
    if all(law.registry.get(law.name) is law for law in laws):
        loads(text, file=mechanism.name or "mechanism")


def across(raw: Raw, given: set[Path]) -> list[Fault]:
    """Faults that no table shows alone."""
    checks = Checks(raw, given)
    checks.names()
    for name, body in entries(raw, "body"):
        check_body(checks, name, body)
    check_joints(checks)
    check_gears(checks)
    check_springs(checks)
    check_drivers(checks)
    check_loads(checks)
    checks.run()
    return checks.faults


def syntax_fault(text: str, error: Exception) -> Fault:
    """Line and column of a fault in the TOML itself, with the line."""
    if isinstance(error, RecursionError):
        return Fault("file", "lists or tables are nested too deeply", "", "", "a model needs no more than lists of numbers")
    said, _, place_said = str(error).partition(" (at ")
    what, where = f"this is no TOML: {said}", place_said.rstrip(")") or "file"
    if where == "end of document":
        where = f"line {text.count(chr(10)) + 1}, column {len(text) - text.rfind(chr(10))} (the end)"
    if found := re.match(r"line (\d+), column (\d+)", where):
        line = text.splitlines()[int(found[1]) - 1 : int(found[1])]
        what += f", in {shown(line[0].strip())}" if line else ""
    remedy = "put texts and quantities with units in quotes, and close every quote and bracket"
    if "overwrite" in said or "twice" in said:
        remedy = "give each key and each table once"
    elif "digits" in said:
        what, remedy = "this is no TOML: a number of thousands of digits", "shorten it"
    return Fault(where, what, "", "", remedy)


def schema_fault(raw: Raw, error: dict[str, Any], given: set[Path]) -> Fault:
    """A pydantic error in words; tags of unions, in angle brackets, are no part of the path."""
    path: Path = tuple(part for part in error["loc"] if not (isinstance(part, str) and part.startswith("<")))
    where, value, kind, ctx = place(path, given), error.get("input"), error["type"], error.get("ctx", {})
    if kind == "fault":
        return Fault(where, ctx["what"], ctx["value"], ctx["limit"], ctx["remedy"])
    if kind == "extra_forbidden":
        return unknown_key(raw, path, value, where)
    if kind == "missing":
        return missing_key(raw, path, where)
    if kind == "too_long":
        count = ctx.get("max_length", 2)
        return Fault(where, "too many values", shown(value), f"{count} values", "remove what is too many")
    if kind in WANTED:
        return Fault(where, f"this is {kind_of(value)}", shown(value), *WANTED[kind])
    return Fault(where, str(error.get("msg", kind)), shown(value), "", "correct the value")


A_TABLE = ("a table", "write its keys in a table of that name")
WANTED = {
    "string_type": ("a text", "put it in quotes"),
    "dict_type": A_TABLE,
    "model_type": A_TABLE,
    "model_attributes_type": A_TABLE,
    "tuple_type": ("a list", "put the values in square brackets"),
    "bool_type": ("true or false", "write it without quotes"),
}


def unknown_key(raw: Raw, path: Path, value: Any, where: str) -> Fault:
    """A key that its table does not know, or only one of another kind."""
    key, above = str(path[-1]), path[:-1]
    known = known_keys(above) or ()
    holder = table(raw, *above)
    if key == "$schema" and not above:
        return Fault(where, "a model names no schema among its keys", shown(value), "", "write it as a comment in the first line: #:schema PATH")
    if key in known and above:
        return Fault(where, *other_kind(str(above[0]), key, holder, shown(value)))
    what = "unknown table" if isinstance(value, dict) else "unknown key"
    return Fault(where, what, shown(value), "", suggestion(key, known, "remove it"))


def other_kind(section: str, key: str, holder: Raw, value: str) -> tuple[str, str, str, str]:
    """What to say of a key that only another kind of body, joint, spring or driver has: what, value, limit, remedy."""
    if section == "joint":
        kind = joint_kind(holder).strip("<>")
        users = [name for name, model in JOINT_TABLES.items() if key in model.model_fields]
        first = "clearance" if kind == "ideal" and key in CLEARANCE_ONLY else users[0]
        more = f" (or {', '.join(name for name in users if name != first)})" if len(users) > 1 else ""
        return f"{article(kind)} joint has no such key", value, "", f'set kind = "{first}"{more}, or remove it'
    if section == "driver":
        driven = driver_kind(holder).strip("<>")
        remedy = "remove it; a force acts on a point, a torque on a body" if key in EFFORTS else "remove it"
        return f"a driver of a {driven} has no such key", value, "", remedy
    if section == "spring":
        kind = spring_kind(holder).strip("<>")
        users = [name for name, model in SPRING_TABLES.items() if key in model.model_fields]
        return f"a spring of kind {kind} has no such key", value, "", f"remove it, or set kind to {' or '.join(users)}"
    length = "with" if "length" in holder else "without"
    what = f"a body of this kind ({holder.get('model', 'rigid')}, {length} a length) has no such key"
    return what, value, "", "remove it, or give the body the model and the length that go with it"


def missing_key(raw: Raw, path: Path, where: str) -> Fault:
    """A key, or a value of a list, that has to be there."""
    if isinstance(path[-1], int):
        return Fault(where, "this value of the list is missing", "", "", "give the list all its values")
    key, holder = path[-1], table(raw, *path[:-1])
    remedy = "add it"
    if path[0] == "joint" and key == "kind":
        remedy = 'add kind = "clearance", or remove what an ideal joint does not have'
    elif path[0] == "spring" and key == "kind":
        remedy = f'add kind = "{spring_kind(holder).strip("<>")}"'
    elif path[0] == "body" and key == "length":
        remedy = "add it; a rigid body that is no link has mass, inertia and pins instead"
    elif path[0] == "body" and key == "inertia" and "length" not in holder:
        remedy = "add it; a link has a length instead"
    return Fault(where, "this key is missing", "", "", remedy)
