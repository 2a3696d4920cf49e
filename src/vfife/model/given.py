"""What Python gives a builder: numbers in SI units or texts with a unit, laws, materials and sections by name, read by the fields of the nouns."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, TypeAlias

from ..errors import Fault, Path, article, kind_of, shown, suggestion
from ..fields import Reading, described_fields, partial, required, value_of
from ..laws import MATERIALS, Law
from .bodies import Section
from .lawtables import LAWS, read_law
from .sectiontable import read_section

Quantity: TypeAlias = float | str  # 0.1, or "100 mm"
Place: TypeAlias = Sequence[Quantity]  # x and y
Table: TypeAlias = Mapping[str, Any]  # keys and values as in a model file


class Given(Reading):
    """Reads what a script gives: everything that a model file can say, and the nouns themselves."""

    written = True

    def noun(self, path: Path, kind: type, value: Any) -> Any:
        """A noun, or the table of one."""
        if isinstance(value, Mapping):
            return read_section(self, path, value) if kind is Section else self.table(path, kind, value)
        return self.one_of(path, kind, value)

    def table(self, path: Path, kind: type, value: Table) -> Any:
        """The noun of a table."""
        before, fields = len(self.faults), {field.name: field for field in described_fields(kind)}
        for key in value.keys() - fields.keys():
            self.refuse((*path, key), "unknown key", shown(value[key]), "", suggestion(key, fields, "remove it"))
        found = {key: value_of(field).read(value[key], (*path, key), self) for key, field in fields.items() if key in value}
        for key, field in fields.items():
            if required(field) and key not in value:
                self.refuse((*path, key), "this key is missing", "", "", "add it")
        return kind(**found) if len(self.faults) == before else partial(kind, found)

    def unknown(self, path: Path, value: Any) -> None:
        """A key of a section that there is not."""
        known = (*Section.shapes, *(field.name for field in described_fields(Section)))
        self.refuse(path, "unknown key", shown(value), "", suggestion(str(path[-1]), known, "remove it"))

    def named(self, path: Path, kind: type, value: Any) -> Any:
        """A material, or the name of one."""
        if not isinstance(value, str):
            return self.one_of(path, kind, value)
        if value not in MATERIALS:
            remedy = suggestion(value, MATERIALS, "make one: vfife.Material(name, youngs_modulus=..., poissons_ratio=..., density=...)")
            self.refuse(path, "there is no material of this name", shown(value), "", remedy)
        return MATERIALS.get(value)

    def chosen(self, path: Path, base: type, value: Any) -> Any:
        """A law, its name, or its table: law = name, and its parameters."""
        kind = next(kind for kind, known in LAWS.items() if known is base)
        if isinstance(value, Law) and not isinstance(value, base):
            self.refuse(path, f"this is no {kind} law", shown(value.name), "", f"give {article(kind)} law here")
            return None
        if isinstance(value, base):
            return value
        if isinstance(value, type) and issubclass(value, base):
            self.refuse(path, "this is the law's class", value.__name__, "", f"write {value.__name__}(), with its parameters by name")
            return None
        if not isinstance(value, str | Mapping):
            self.refuse(path, f"this is {kind_of(value)}", shown(value), f"{article(kind)} law, its name, or its table", "give one")
            return None
        law, faults = read_law(kind, {"law": value} if isinstance(value, str) else value)
        for fault in faults:
            self.add(fault.at((*path, *fault.path)))
        return law

    def one_of(self, path: Path, kind: type, value: Any) -> Any:
        """A noun as it is: it was made by Python, where numbers are numbers."""
        plain = Reading()
        found = plain.one_of(path, kind, value)
        self.faults += plain.faults
        return found


def idle(noun: Any, word: Any, users: tuple[str, ...], value: Any) -> Fault:
    """What is said of a value for which the model of a link, or the kind of analysis, has no use; ``users`` would have one."""
    chooser = noun.selected_by
    kind = f"{article(word)} {'link' if chooser == 'model' else chooser}"
    listed = " or ".join(users if chooser == "model" else map(shown, users))
    return Fault("", f"{kind} has no use for this", shown(value), "", f"remove it, or set {chooser} {'to' if chooser == 'model' else '='} {listed}")
