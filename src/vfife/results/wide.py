"""The data of a run as people hold them: all about one joint or body, and one table with a column for each series."""

from __future__ import annotations

import dataclasses
from collections.abc import Collection, Iterator
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ..errors import VfifeError, kind_of, shown, suggestion
from .channels import entities
from .series import PREFIXES, of_the_ground

if TYPE_CHECKING:
    import pandas
    import xarray

    from .view import View

JOINTS, BODIES, SPRINGS = ("joint", "clearance", "slider"), ("body", "driver", "link"), ("spring",)  # dimensions that name them
FINE = ("element", "particle")  # of which a body may have thousands


@dataclasses.dataclass(frozen=True)
class Column:
    """A series over the outputs: ``name`` as measures have it (``C.force``), its noun and quantity, unit, meaning, values of shape (outputs,)."""

    name: str
    noun: str
    quantity: str
    unit: str
    meaning: str
    values: NDArray[Any]

    @property
    def titled(self) -> str:
        """Name and unit, ``C.force [N]``."""
        return self.name if self.unit == "1" else f"{self.name} [{self.unit}]"


def about(view: View, name: str, kind: str, dimensions: Collection[str]) -> xarray.Dataset:
    """All series of one noun, each by its quantity. A block in a guide keeps its four corners, a body its elements and particles, as dimensions."""
    data = view.data
    found: dict[str, Any] = {}
    for variable, values in data.data_vars.items():
        for entity in [one for one in values.dims if one in dimensions or (kind == "body" and one in FINE)]:
            names = [str(one) for one in data[entity].values]
            exact, parts = entity not in FINE and name in names, [one for one in names if one == name or numbered(one, name)]
            if exact or parts:
                quantity = str(variable) if entity in FINE else str(variable).removeprefix(PREFIXES.get(str(entity), ""))
                found.setdefault(quantity, values.sel({entity: name if exact else parts}, drop=exact))
    if not found:
        known = [one for entity, names in entities(view.record).items() if entity in dimensions for one in names]
        raise VfifeError(f"there is no {kind} {shown(name)} in this result: {suggestion(str(name), known, f'name a {kind}')}")
    about_it: xarray.Dataset = type(data)(found, attrs={**data.attrs, kind: name})
    return about_it


def numbered(one: str, name: str) -> bool:
    """Whether a name is that of a numbered part: ``rod.3`` of ``rod``."""
    return one.startswith(f"{name}.") and one[len(name) + 1 :].isdigit()


def columns(view: View, names: Collection[str] = (), fine: bool = False) -> Iterator[Column]:
    """The series of a result, or of the joints, bodies and springs that are named; ``fine``: elements and particles as well.

    Time (or the load factor) and the crank's angle come first. Raises VfifeError for a name that nothing has.
    """
    there = entities(view.record)
    known = dict.fromkeys(one for entity, every in there.items() if entity not in FINE for one in every)
    for name in names:
        if not isinstance(name, str):
            raise VfifeError(
                f'{shown(name)} is {kind_of(name)}, no name of a joint, body or spring; write them one by one, as in to_dataframe("C", "crank")'
            )
        if name not in known and not any(numbered(one, name) for one in known):
            raise VfifeError(f"there is no joint, body or spring {shown(name)} in this result: {suggestion(str(name), known, 'name one')}")
    static = view.record.static
    yield Column("load_factor" if static else "time", "", "time", "1" if static else "s", "load factor" if static else "time", view.time)
    if view.crank_angle is not None:
        said = f"angle of {view.crank}, not reduced to one turn"
        yield Column("crank_angle", "", "crank_angle", "deg", said, view.crank_angle)
    of_nouns: dict[str, dict[str, Column]] = {}
    whole: list[Column] = []
    for variable, one in view.channels.items():
        if one.values.ndim > 2 or (one.entity in FINE and not fine):
            continue
        if one.entity is None:
            whole.append(Column(of_the_ground(variable), "", variable, one.unit, one.meaning, one.values))
            continue
        quantity = variable if one.entity in FINE else variable.removeprefix(PREFIXES.get(one.entity, ""))
        for k, noun in enumerate(there[one.entity]):
            if not names or any(noun == name or numbered(noun, name) for name in names):
                column = Column(f"{noun}.{quantity}", noun, quantity, one.unit, one.meaning, one.values[:, k])
                of_nouns.setdefault(noun, {}).setdefault(quantity, column)
    for found in of_nouns.values():
        yield from found.values()
    yield from () if names else whole


def frame(view: View, names: Collection[str], units: bool, fine: bool) -> pandas.DataFrame:
    """One table: a row an output, a column a series, over time. ``attrs`` has units and meanings by column."""
    first, *others = columns(view, names, fine)
    index, *keys = (one.titled if units else one.name for one in (first, *others))
    import xarray

    held = {key: (index, np.asarray(one.values)) for key, one in zip(keys, others, strict=True)}
    found = xarray.Dataset(held, {index: first.values}).to_dataframe()
    found.attrs = {
        "units": {key: one.unit for key, one in zip(keys, others, strict=True)},
        "meanings": {key: one.meaning for key, one in zip(keys, others, strict=True)},
    }
    return found
