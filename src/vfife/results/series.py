"""Series of a result by the names that measures have: ``C.force`` of ``C.force.max``, ``crank.torque`` of
``crank.torque.max``.

:class:`Series` is the one way from a name to numbers. Datasets of a joint or body, tables, exports, spectra
and reductions are made of its columns.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ..errors import VfifeError, kind_of, shown, suggestion
from .channels import Channel, entities

if TYPE_CHECKING:
    import pandas
    import xarray

    from .view import View

Array = NDArray[np.float64]
PREFIXES = {
    entity: f"{entity}_"
    for entity in ("joint", "body", "driver", "element", "particle", "spring", "slider", "elastic")
}
DIMENSIONS = {
    "joint": ("joint", "clearance", "slider"),
    "body": ("body", "driver", "link"),
    "spring": ("spring",),
}  # that name one of a kind
FINE = ("element", "particle")  # of which a body may have thousands


@dataclass(frozen=True)
class Column:
    """One series of a result: ``owner`` is the joint, body, spring ... that has it, empty for the whole
    mechanism; ``index`` its place along the dimension of the channel, which ``variable`` names.
    """

    variable: str
    owner: str
    index: int | None
    channel: Channel

    @property
    def entity(self) -> str | None:
        """The dimension of the channel."""
        return self.channel.entity

    @property
    def short(self) -> str:
        """The variable without its dimension: ``force`` of ``joint_force``."""
        return self.variable.removeprefix(PREFIXES.get(self.entity or "", ""))

    @property
    def quantity(self) -> str:
        """The same in tables, where elements and particles, which may be called as their body is, keep the
        dimension.
        """
        return self.variable if self.entity in FINE else self.short

    @property
    def name(self) -> str:
        """``C.force`` in tables."""
        return f"{self.owner}.{self.quantity}" if self.owner else of_the_ground(self.variable)

    @property
    def titled(self) -> str:
        """Name and unit, ``C.force [N]``."""
        return self.name if self.unit == "1" else f"{self.name} [{self.unit}]"

    @property
    def unit(self) -> str:
        """Unit of the values."""
        return self.channel.unit

    @property
    def meaning(self) -> str:
        """What the values are."""
        return self.channel.meaning

    @property
    def values(self) -> NDArray[Any]:
        """Values at the outputs, shape (outputs,)."""
        return self.channel.values if self.index is None else self.channel.values[:, self.index]


class Series(Mapping[str, "xarray.DataArray"]):
    """The series of a result: ``<joint, body ...>.<quantity>``, or the quantity alone where it is one of the
    whole mechanism.

    ``result.series["C.force"]`` is ``result.data["joint_force"].sel(joint="C")``; the measure of its largest
    value is ``C.force.max``.
    """

    def __init__(self, view: View) -> None:
        self._view, self._columns = view, dict[str, Column]()
        names = entities(view.record)
        self.every: list[Column] = []
        for variable, channel in view.channels.items():
            if channel.entity is None:
                self.every.append(Column(variable, "", None, channel))
            else:
                self.every += [
                    Column(variable, owner, k, channel) for k, owner in enumerate(names[channel.entity])
                ]
        for one in self.every:
            self._columns.setdefault(f"{one.owner}.{one.short}" if one.owner else one.name, one)

    def __getitem__(self, name: str) -> xarray.DataArray:
        if name not in self._columns:
            raise KeyError(
                f"there is no series {name!r}."
                f" {suggestion(str(name), self._columns, 'Their names are those of result.series')}"
            )
        one = self._columns[name]
        found = self._view.data[one.variable]
        return found if one.entity is None else found.sel({one.entity: one.owner})

    def column(self, name: str) -> Column:
        """A series with its place in the data and its plain values. Raises KeyError."""
        return self._columns[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._columns)

    def __len__(self) -> int:
        return len(self._columns)

    def __repr__(self) -> str:
        return f"<{len(self)} series: {', '.join(list(self)[:6])} ...>"


def of_the_ground(variable: str) -> str:
    """A variable of the ground with the ground as its owner: ``ground.shaking_force``."""
    return variable.replace("_", ".", 1) if variable.startswith("ground_") else variable


def is_part(one: str, name: str) -> bool:
    """Whether a name is that of a numbered part: ``rod.3`` of ``rod``."""
    return one.startswith(f"{name}.") and one[len(name) + 1 :].isdigit()


# ---------------------------------------------------------------------------------------------------------
# tables of series


def dataset_of(view: View, name: str, kind: str) -> xarray.Dataset:
    """All series of one joint, body or spring, each by its quantity.

    A block in a guide keeps its four corners, a body its elements and particles, as dimensions.
    """
    data, dimensions = view.data, DIMENSIONS[kind]
    found: dict[str, Any] = {}
    for variable, values in data.data_vars.items():
        for entity in [one for one in values.dims if one in dimensions or (kind == "body" and one in FINE)]:
            names = [str(one) for one in data[entity].values]
            exact, parts = (
                entity not in FINE and name in names,
                [one for one in names if one == name or is_part(one, name)],
            )
            if exact or parts:
                quantity = (
                    str(variable)
                    if entity in FINE
                    else str(variable).removeprefix(PREFIXES.get(str(entity), ""))
                )
                found.setdefault(quantity, values.sel({entity: name if exact else parts}, drop=exact))
    if not found:
        known = [
            one for entity, names in entities(view.record).items() if entity in dimensions for one in names
        ]
        raise VfifeError(
            f"there is no {kind} {shown(name)} in this result:"
            f" {suggestion(str(name), known, f'name a {kind}')}"
        )
    made: xarray.Dataset = type(data)(found, attrs={**data.attrs, kind: name})
    return made


def columns(view: View, names: Collection[str] = (), fine: bool = False) -> list[Column]:
    """The series of a result, or of the joints, bodies and springs that are named; ``fine``: elements and
    particles as well.

    Time (or the load factor) and the crank's angle come first, those of the whole mechanism last. Raises
    VfifeError for a name that nothing has.
    """
    known = dict.fromkeys(
        one for entity, every in entities(view.record).items() if entity not in FINE for one in every
    )
    for name in names:
        if not isinstance(name, str):
            raise VfifeError(
                f"{shown(name)} is {kind_of(name)}, no name of a joint, body or spring; write them one by"
                ' one, as in to_dataframe("C", "crank")'
            )
        if name not in known and not any(is_part(one, name) for one in known):
            raise VfifeError(
                f"there is no joint, body or spring {shown(name)} in this result:"
                f" {suggestion(str(name), known, 'name one')}"
            )
    time = (
        Channel(view.time, None, "1", "load factor")
        if view.record.static
        else Channel(view.time, None, "s", "time")
    )
    first = [Column("load_factor" if view.record.static else "time", "", None, time)]
    if view.crank_angle is not None:
        said = f"angle of {view.crank}, not reduced to one turn"
        first.append(Column("crank_angle", "", None, Channel(view.crank_angle, None, "deg", said)))
    of_owners: dict[str, dict[str, Column]] = {}
    for one in view.series.every:
        wanted = not names or any(one.owner == name or is_part(one.owner, name) for name in names)
        if wanted and (fine or one.entity not in FINE):
            of_owners.setdefault(one.owner, {}).setdefault(one.quantity, one)
    of_all = of_owners.pop("", {})
    return first + [one for found in of_owners.values() for one in found.values()] + list(of_all.values())


def frame(view: View, names: Collection[str], units: bool, fine: bool) -> pandas.DataFrame:
    """One table: a row an output, a column a series, over time. ``attrs`` has units and meanings by column."""
    import xarray

    first, *others = columns(view, names, fine)
    index, *keys = (one.titled if units else one.name for one in (first, *others))
    held = {key: (index, np.asarray(one.values)) for key, one in zip(keys, others, strict=True)}
    found = xarray.Dataset(held, {index: first.values}).to_dataframe()
    found.attrs = {
        "units": {key: one.unit for key, one in zip(keys, others, strict=True)},
        "meanings": {key: one.meaning for key, one in zip(keys, others, strict=True)},
    }
    return found


# ------------------------------------------------------------------------------------------------------------- reductions

REDUCTION = re.compile(r"(max|min|mean|rms|range)\((.+)\)")


def mean(time: Array, values: Array) -> float:
    """Mean over time, ∫ x dt / T, by trapezoids between outputs."""
    return float(np.trapezoid(values, time) / (time[-1] - time[0]))


# Each of values at outputs, with the times of these (s).
REDUCED: dict[str, Callable[[Array, Array], float]] = {
    "max": lambda time, values: float(values.max()),
    "min": lambda time, values: float(values.min()),
    "mean": mean,
    "rms": lambda time, values: math.sqrt(mean(time, values * values)),
    "range": lambda time, values: float(np.ptp(values)),
}


def joined(parts: Sequence[Array]) -> Array:
    """Turns one after another, the output between two of them once."""
    return np.concatenate([one if k == 0 else one[1:] for k, one in enumerate(parts)])
