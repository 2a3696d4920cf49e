"""Checks of springs: they connect two different things, and do something."""

from __future__ import annotations

from typing import Any

from ...errors import Path
from ...fields import Text, described_fields, value_of
from .checks import Checks, known, shown_name
from .joints import rigid


def check_springs(checks: Checks) -> None:
    """Every spring."""
    for name, spring in known(checks.mechanism.springs):
        path: Path = ("spring", name)
        for field in described_fields(type(spring)):
            value = value_of(field)
            if isinstance(value, Text) and value.refers:
                (checks.side if value.refers == "pin" else checks.body)((*path, field.name), getattr(spring, field.name))
        one, two = ((end or "").partition(".")[0] for end in (spring.first, spring.second))
        # A spring may brace a body that deforms.
        if one and one == two and (spring.axes != "linear" or spring.first == spring.second or rigid(checks, one)):
            what = "both ends are on the ground" if one == "ground" else f"both ends are on {shown_name(one)}, and do nothing there"
            checks.add((*path, "second"), what, "name another body")
        check_strength(checks, path, spring)


def check_strength(checks: Checks, path: Path, spring: Any) -> None:
    """A spring has a stiffness or a damping; a stop has room between its limits."""
    strength = [spring.stiffness, spring.damping]
    if None not in strength and not any(any(one) if isinstance(one, tuple) else one for one in strength):
        checks.add((*path, ""), "neither a stiffness nor a damping: it does nothing", "give one of the two, or remove it")
    for conflict in spring.conflicts():
        checks.take(path, conflict)
