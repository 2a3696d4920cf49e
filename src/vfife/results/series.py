"""Series over time by the names that measures have: ``C.force`` of ``C.force.max``, ``crank.torque`` of ``crank.torque.max``."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from typing import TYPE_CHECKING

from ..errors import suggestion
from .channel import Channel

if TYPE_CHECKING:
    import xarray

PREFIXES = {entity: f"{entity}_" for entity in ("joint", "body", "driver", "element", "particle", "spring", "slider", "elastic")}


class Series(Mapping[str, "xarray.DataArray"]):
    """The channels of ``result.data`` one by one: ``<joint, body ...>.<quantity>``, or the quantity alone where it is one of the whole mechanism.

    ``result.series["C.force"]`` is ``result.data["joint_force"].sel(joint="C")``; the measure of its largest value is ``C.force.max``.
    """

    def __init__(self, channels: Mapping[str, Channel], entities: Mapping[str, list[str]], data: Callable[[], xarray.Dataset]) -> None:
        self._data = data
        self._places: dict[str, tuple[str, str | None, str]] = {}
        for variable, channel in channels.items():
            if channel.entity is None:
                self._places[of_the_ground(variable)] = variable, None, ""
                continue
            quantity = variable.removeprefix(PREFIXES.get(channel.entity, ""))
            for name in entities[channel.entity]:
                self._places.setdefault(f"{name}.{quantity}", (variable, channel.entity, name))

    def __getitem__(self, name: str) -> xarray.DataArray:
        if name not in self._places:
            raise KeyError(f"there is no series {name!r}. {suggestion(str(name), self._places, 'Their names are those of result.series')}")
        variable, entity, label = self._places[name]
        found = self._data()[variable]
        return found if entity is None else found.sel({entity: label})

    def place(self, name: str) -> tuple[str, str | None, str]:
        """Where a series lies in the data: variable, dimension and name along it; no dimension for one of the whole mechanism."""
        return self._places[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._places)

    def __len__(self) -> int:
        return len(self._places)

    def __repr__(self) -> str:
        return f"<{len(self)} series: {', '.join(list(self)[:6])} ...>"


def of_the_ground(variable: str) -> str:
    """A variable of the ground with the ground as who has it: ``ground.shaking_force``."""
    return variable.replace("_", ".", 1) if variable.startswith("ground_") else variable
