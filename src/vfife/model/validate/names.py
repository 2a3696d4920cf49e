"""Names: every one can be part of a path, and a noun stands under its own."""

from __future__ import annotations

from collections.abc import Iterator

from ...errors import Path, shown
from .checks import NAME_LIMIT, Checks, given, known

TITLE_LIMIT = 300  # signs of a mechanism's name
SECTIONS = {"body": "bodies", "joint": "joints", "gear": "gears", "spring": "springs", "load": "loads"}


def check_names(checks: Checks) -> None:
    """Bodies there are, and all names."""
    if not checks.bodies:
        checks.add(("body",), "the model has no body", "add a table such as [body.crank]")
    if "ground" in checks.bodies:
        checks.add(("body", "ground"), '"ground" is what does not move', "call the body otherwise")
    for key, allowed in (("name", ""), ("note", "\n\t")):
        text = getattr(checks.mechanism, key)
        if isinstance(text, str) and not all(sign.isprintable() or sign in allowed for sign in text):
            checks.add((key,), "it has signs that cannot be printed", "leave them out")
    if len(str(checks.mechanism.name)) > TITLE_LIMIT:
        checks.add(("name",), f"it has {len(checks.mechanism.name):,} signs", f"{TITLE_LIMIT} are the most; a note may be longer")
    for path in named_things(checks):
        check_name(checks, path)
    for section, field in SECTIONS.items():
        for key, noun in known(getattr(checks.mechanism, field)):
            if noun.name != key:
                what = f"the {section} {shown(key)} calls itself {shown(noun.name)}"
                checks.add((section, key, "name"), what, "give it the name under which it stands")


def check_name(checks: Checks, path: Path) -> None:
    """A name can be part of a path."""
    name = path[-1]
    if not (isinstance(name, str) and 0 < len(name) <= NAME_LIMIT and name.isprintable() and name == name.strip() and "." not in name):
        remedy = f"choose a name of 1 to {NAME_LIMIT} printable signs without dots"
        checks.add((*path[:-1], ""), f"the name {shown(name)} cannot be part of a path", remedy)


def named_things(checks: Checks) -> Iterator[Path]:
    """Paths of everything that the user gives a name."""
    model = checks.mechanism
    yield from (("ground", name) for name in model.points or ())
    for section, field in SECTIONS.items():
        yield from ((section, name) for name in getattr(model, field))
    # A driver's name is that of its body, and told there, unless it says otherwise.
    yield from (("driver", name) for name, driver in known(model.drivers) if driver.target != "body" or driver.body != name)
    for name, body in known(checks.bodies):
        for key in ("pins", "nodes"):
            yield from (("body", name, key, pin) for pin in given(body, key))
