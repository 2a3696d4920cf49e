"""Write src/vfife/model/builders.pyi, the signatures of the builders for editors and type checkers:
``python tests/model/stubs.py``.
"""

from __future__ import annotations

import inspect
from pathlib import Path

from vfife.model.builders import Builders, builders

STUB = Path(__file__).resolve().parents[2] / "src" / "vfife" / "model" / "builders.pyi"
HEAD = """\
# ruff: noqa
# fmt: off
# Made by tests/model/stubs.py from the fields of the kinds.
from collections.abc import Mapping, Sequence
from typing import Any, Literal, TypeVar

from ..laws import ContactLaw, FrictionLaw, Material
from .bodies import Body, Frame, Link, Member, Pin, PointMass, RigidBody, Section
from .drivers import *
from .readers import Place, Quantity, Table
from .joints import *
from .loads import *
from .springs import *
from .wear import Wear

Item = TypeVar("Item")

class Builder:
    name: str
    section: str
    kind: Any
    @property
    def fields(self) -> dict[str, Any]: ...

def builders() -> dict[str, Builder]: ...

class Builders:
    name: str
    points: dict[str, tuple[float, float]]
    def point(self, name: str, x: Quantity, y: Quantity) -> Pin: ...
    def clearance(self, name: str, bearing: str, journal: str, **values: Any) -> ClearanceRevolute: ...
    def add(self, item: Item, name: str | None = None) -> Item: ...
"""


def stub() -> str:
    """The text of the stub."""
    lines = [HEAD]
    for name in builders():
        found = inspect.signature(getattr(Builders, name))
        words = []
        for one in found.parameters.values():
            if one.kind is one.KEYWORD_ONLY and "*" not in words:
                words.append("*")
            default = (
                "" if one.default is one.empty else f" = {one.default!r}" if one.default != {} else " = ..."
            )
            words.append(one.name + (f": {one.annotation}" if one.name != "self" else "") + default)
        lines.append(f"    def {name}({', '.join(words)}) -> {found.return_annotation}: ...\n")
    return "".join(lines)


if __name__ == "__main__":
    STUB.write_text(stub(), encoding="utf-8")
