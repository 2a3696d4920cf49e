"""The tables of drivers: what they do is told by their keys, each kind of driver naming its own."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from ..errors import Path, kind_of, shown
from ..fields import partial
from .tables import TARGETS, Table, known_keys, strangeness, tables, target_of

if TYPE_CHECKING:
    from .reader import Written


def driver_of(by: Written, path: Path, holder: Any) -> Any:
    """The driver that the keys tell; None where they do not."""
    if not isinstance(holder, dict):
        by.refuse(path, f"this is {kind_of(holder)}", shown(holder), "a table", "write its keys in a table of that name")
        return None
    target = target_of(holder)
    kinds = [one for one in tables("driver") if one.target == target]
    leads: dict[str, list[Table]] = {}
    for one in kinds:
        leads.setdefault(lead(one), []).append(one)
    told = [key for key in leads if key in holder]
    told = [key for key in told if not any(key in one.fields for other in told if other != key for one in leads[other])]
    strange = {lead(one) for one in tables("driver")} & set(holder) - set(leads)
    if len(told) != 1 and not strange:
        said = f"{' and '.join(told)} exclude each other" if told else "nothing says what the driver does"
        by.refuse((*path, ""), said, "", limits(leads), "give one of these")
    among = leads[told[0]] if len(told) == 1 else kinds
    what = min(among, key=lambda one: strangeness(one, holder))
    found: dict[str, Any] = {} if target != "body" or "body" in holder else {"body": path[1]}
    before = len(by.faults)
    for key, value in holder.items():
        users = [what] if key in what.fields else [one for one in kinds if key in one.fields]
        if not users:
            unknown(by, (*path, key), target, value)
        elif users[0] is what or len(told) != 1:
            found[users[0].fields[key].name] = users[0].value(key).read(value, (*path, key), by)
        else:
            owners = dict.fromkeys(map(lead, users))
            by.refuse((*path, key), f"{key} goes with {' or '.join(owners)}, not with {told[0]}", shown(value), "", "remove it")
    if len(told) != 1:
        return None
    by.shapes.append((path, what, holder))
    for key in what.needed:
        if key not in holder:
            said = f"{told[0]} and {key} go together, and {key} is missing" if key.endswith("s") else f"{told[0]} needs a {key}, which is missing"
            by.refuse((*path, key), said, "", "", "add it")
    return what.noun(**found) if len(by.faults) == before else partial(what.noun, found)


def lead(one: Table) -> str:
    """The key that tells a kind."""
    return str(one.noun.lead_keys(one.along))


def limits(leads: dict[str, list[Table]]) -> str:
    """Which keys tell a kind, and what goes with them."""
    words = []
    for key, kinds in leads.items():
        own = [name for one in kinds for name in one.fields if name not in TARGETS[one.target] and name != key]
        needed = {name for one in kinds for name in one.needed} if len(kinds) == 1 else set()
        must, may = [name for name in own if name in needed], [name for name in own if name not in needed]
        words.append(key + (f" with {' and '.join(must)}" if must else "") + (f" (with {' or '.join(may)})" if may else ""))
    return ", or ".join((", ".join(words[:-1]), words[-1]))


def unknown(by: Written, path: Path, target: str, value: Any) -> None:
    """A key that no driver of this target has."""
    key, known = str(path[-1]), known_keys(path[:-1]) or ()
    if key not in known:
        by.unknown(path, value)
        return
    efforts = {lead(one) for one in tables("driver") if not one.noun.moves}
    remedy = "remove it; a force acts on a point, a torque on a body" if key in efforts else "remove it"
    by.refuse(path, f"a driver of a {target} has no such key", shown(value), "", remedy)


def merged(target: str) -> dict[str, tuple[Table, bool]]:
    """Keys of all drivers of a target, each with a table that has it; whether it must be there."""
    found: dict[str, tuple[Table, bool]] = {}
    for one in tables("driver"):
        if one.target == target:
            for key in (*TARGETS[target], *one.fields):
                found.setdefault(key, (one, key == target and target != "body"))
    return found
