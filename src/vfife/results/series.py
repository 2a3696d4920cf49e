"""Series of a result by the names that measures have: ``C.force`` of ``C.force.max``, ``crank.torque`` of
``crank.torque.max``.

A :class:`Channel` holds the values of all joints or bodies; a :class:`SeriesColumn` is one of them.
:class:`Series` finds it by name. Tables, exports, spectra and reductions are selections of these columns.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ..errors import VfifeError, kind_of, shown, suggestion
from ..measures.energy import ledger
from ..solvers.record import Record
from .channels import Channel, channel_groups, entities

if TYPE_CHECKING:
    import xarray

    from .run_data import RunData

Array = NDArray[np.float64]
PREFIXES = {
    entity: f"{entity}_"
    for entity in ("joint", "body", "driver", "element", "particle", "spring", "slider", "elastic")
}
# Dimensions of channels whose labels are names of joints, bodies or springs.
DIMENSIONS = {
    "joint": ("joint", "clearance", "slider"),
    "body": ("body", "driver", "link"),
    "spring": ("spring",),
}
FINE = ("element", "particle")  # of which a body may have thousands


@dataclass(frozen=True)
class SeriesColumn:
    """One series of a result: the channel ``variable`` of its ``owner`` (a joint, body, spring ...), empty
    for the whole mechanism.

    ``index`` is the place of the owner along the dimension of the channel.
    """

    variable: str
    owner: str
    index: int | None
    channel: Channel

    @property
    def entity(self) -> str | None:
        """Dimension of the channel."""
        return self.channel.entity

    @property
    def short(self) -> str:
        """Variable without its dimension: ``force`` of ``joint_force``."""
        return self.variable.removeprefix(PREFIXES.get(self.entity or "", ""))

    @property
    def quantity(self) -> str:
        """The same in tables, where elements and particles keep the dimension, because they may have the name
        of their body.
        """
        return self.variable if self.entity in FINE else self.short

    @property
    def name(self) -> str:
        """Name in tables, ``C.force``; ``ground.shaking_force`` for a variable of the ground."""
        if self.owner:
            return f"{self.owner}.{self.quantity}"
        return self.variable.replace("_", ".", 1) if self.variable.startswith("ground_") else self.variable

    @property
    def unit(self) -> str:
        """Unit of the values."""
        return self.channel.unit

    @property
    def metadata(self) -> dict[str, str]:
        """Unit and meaning of the values."""
        return {"units": self.channel.unit, "long_name": self.channel.meaning}

    @property
    def values(self) -> NDArray[Any]:
        """Values at the outputs, shape (outputs,)."""
        return self.channel.values if self.index is None else self.channel.values[:, self.index]


class Series(Mapping[str, "xarray.DataArray"]):
    """Series of a result by name: ``<joint, body ...>.<quantity>``, or the quantity alone for one of the
    whole mechanism.

    ``result.series["C.force"]`` is ``result.data["joint_force"].sel(joint="C")``; the measure of its maximum
    is ``C.force.max``.
    """

    def __init__(self, view: RunData) -> None:
        self._view, self._columns = view, dict[str, SeriesColumn]()
        names = entities(view.record)
        self.every: list[SeriesColumn] = []
        for variable, channel in view.channels.items():
            owners = ("",) if channel.entity is None else names[channel.entity]
            self.every += [
                SeriesColumn(variable, owner, k if owner else None, channel) for k, owner in enumerate(owners)
            ]
        for column in self.every:
            self._columns.setdefault(
                f"{column.owner}.{column.short}" if column.owner else column.name, column
            )

    def __getitem__(self, name: str) -> xarray.DataArray:
        if name not in self._columns:
            raise KeyError(
                f"there is no series {name!r}."
                f" {suggestion(str(name), self._columns, 'Their names are those of result.series')}"
            )
        column = self._columns[name]
        values = self._view.data[column.variable]
        return values if column.entity is None else values.sel({column.entity: column.owner})

    def column(self, name: str) -> SeriesColumn:
        """Return a series with its place in the data and its plain values. Raises KeyError."""
        return self._columns[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._columns)

    def __len__(self) -> int:
        return len(self._columns)

    def __repr__(self) -> str:
        return f"<{len(self)} series: {', '.join(list(self)[:6])} ...>"


def belongs(part: str, name: str) -> bool:
    """Return whether a name is another one, or that of its numbered part: ``rod.3`` of ``rod``."""
    return part == name or (part.startswith(f"{name}.") and part[len(name) + 1 :].isdigit())


# --------------------------------------------------------------------------------------- selections of series


def dataset_of(view: RunData, name: str, kind: str) -> xarray.Dataset:
    """Return the dataset of one joint, body or spring, by quantity.

    A block in a guide keeps its four corners, a body its elements and particles, as dimensions.
    """
    data, dimensions = view.data, DIMENSIONS[kind]
    variables: dict[str, Any] = {}
    for variable, values in data.data_vars.items():
        for entity in [
            dimension
            for dimension in values.dims
            if dimension in dimensions or (kind == "body" and dimension in FINE)
        ]:
            names = [str(label) for label in data[entity].values]
            exact, parts = (
                entity not in FINE and name in names,
                [label for label in names if belongs(label, name)],
            )
            if exact or parts:
                quantity = (
                    str(variable)
                    if entity in FINE
                    else str(variable).removeprefix(PREFIXES.get(str(entity), ""))
                )
                variables.setdefault(quantity, values.sel({entity: name if exact else parts}, drop=exact))
    if not variables:
        owners = [
            owner
            for entity, names in entities(view.record).items()
            if entity in dimensions
            for owner in names
        ]
        raise VfifeError(
            f"there is no {kind} {shown(name)} in this result:"
            f" {suggestion(str(name), owners, f'name a {kind}')}"
        )
    dataset: xarray.Dataset = type(data)(variables, attrs={**data.attrs, kind: name})
    return dataset


def columns(view: RunData, names: Collection[str] = (), fine: bool = False) -> list[SeriesColumn]:
    """Return the series of some joints, bodies and springs, by default of all; ``fine``: with elements and
    particles.

    Time (or the load factor) and the crank's angle come first, those of the whole mechanism last. Raises
    VfifeError for an unknown name.
    """
    owners = dict.fromkeys(
        owner
        for entity, names_of in entities(view.record).items()
        if entity not in FINE
        for owner in names_of
    )
    for name in names:
        if not isinstance(name, str):
            raise VfifeError(
                f"{shown(name)} is {kind_of(name)}, no name of a joint, body or spring; write them one by"
                ' one, as in to_dataframe("C", "crank")'
            )
        if not any(belongs(owner, name) for owner in owners):
            raise VfifeError(
                f"there is no joint, body or spring {shown(name)} in this result:"
                f" {suggestion(str(name), owners, 'name one')}"
            )
    variable, unit, meaning = (
        ("load_factor", "1", "load factor") if view.record.static else ("time", "s", "time")
    )
    first = [SeriesColumn(variable, "", None, Channel(view.time, None, unit, meaning))]
    if view.crank_angle is not None:
        angle = Channel(view.crank_angle, None, "deg", f"angle of {view.crank}")
        first.append(SeriesColumn("crank_angle", "", None, angle))
    of_owners: dict[str, dict[str, SeriesColumn]] = {}
    for column in view.series.every:
        if (not names or any(belongs(column.owner, name) for name in names)) and (
            fine or column.entity not in FINE
        ):
            of_owners.setdefault(column.owner, {}).setdefault(column.quantity, column)
    of_mechanism = of_owners.pop("", {})
    return (
        first
        + [column for owned in of_owners.values() for column in owned.values()]
        + list(of_mechanism.values())
    )


class SeriesReader:
    """Reads some series from many records of one mechanism, and computes no others.

    ``columns`` has those that a result of the mechanism, such as ``view``, has under these names.
    """

    def __init__(self, view: RunData, names: Iterable[str]) -> None:
        self.columns = {name: view.series.column(name) for name in names if name in view.series}
        variables = {column.variable for column in self.columns.values()}
        self.groups: dict[str, str] = {}
        for group, compute in channel_groups(view.record, lambda: view.ledger).items():
            if variables - self.groups.keys():
                for variable in variables & compute().keys():
                    self.groups.setdefault(variable, group)

    def read(self, record: Record) -> dict[str, Array]:
        """Return the series of a record by name, each of shape (outputs,)."""
        groups, channels = channel_groups(record, lambda: ledger(record)), dict[str, Channel]()
        for group in dict.fromkeys(self.groups.values()):
            channels = groups[group]() | channels
        return {
            name: np.asarray(replace(column, channel=channels[column.variable]).values, dtype=float)
            for name, column in self.columns.items()
        }


# ------------------------------------------------------------------------------------------------- reductions

REDUCTION = re.compile(r"(max|min|mean|rms|range)\((.+)\)")


def mean(time: Array, values: Array) -> float:
    """Return the mean over time, ∫ x dt / T, by the trapezoidal rule between outputs."""
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
    """Return turns in sequence, with the output between two turns once."""
    return np.concatenate([part if k == 0 else part[1:] for k, part in enumerate(parts)])
