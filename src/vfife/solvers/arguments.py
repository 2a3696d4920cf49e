"""Arguments of a run, read by the fields of the settings of a model file: one validation for Python, files
and the command line.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Literal, get_args

import numpy as np

from ..errors import ModelError, kind_of, shown, suggestion
from ..model.mechanism import Mechanism, Settings
from ..schema import Integer, Measure, Reading, Value, described_fields, value_of

Loop = Literal["auto", "data-driven", "generated", "interpreted"]
MOST = 10**12  # of anything that is counted; more is a slip of units
# What the settings of a model file and the arguments of a run have in common.
SHARED: dict[str, Value] = {
    field.name: value_of(field)
    for field in described_fields(Settings)
    if field.name in ("turns", "duration", "settle", "step", "outputs", "companions")
}


@dataclass(frozen=True)
class RunArguments:
    """What is given for a run beside its mechanism, checked; None leaves it to the mechanism's settings.
    Times are in s.
    """

    turns: float | None = None
    duration: float | None = None
    step: float | str | None = None
    outputs: int | None = None
    companions: int | str | None = None
    settle: float | None = None
    loop: Loop = "auto"
    force_step: bool = False

    def in_settings(self, mechanism: Mechanism) -> Mechanism:
        """The mechanism with these values in its settings."""
        values: dict[str, Any] = {
            name: value for name in SHARED if (value := getattr(self, name)) is not None
        }
        if {"turns", "duration"} & values.keys():
            values = {"turns": None, "duration": None} | values
        return dataclasses.replace(mechanism, settings=dataclasses.replace(mechanism.settings, **values))


class Arguments(Reading):
    """Reads the arguments of a function one by one and keeps what is wrong with them; :meth:`check` raises
    it.
    """

    def __init__(self, function: str) -> None:
        super().__init__(written=True)
        self.function = function

    def check(self) -> None:
        """Raises ModelError with all faults, if there are any."""
        if self.faults:
            raise ModelError(self.faults, f"{self.function}()")

    def fault(self, name: str, what: str, value: Any, limit: str, remedy: str) -> None:
        """Keeps a fault of an argument."""
        self.refuse((name,), what, "None" if value is None else shown(value), limit, remedy)

    def read(self, name: str, held: Value, value: Any) -> Any:
        """The value of an argument by a field; None stays None."""
        return None if value is None else held.read(_plain(value), (name,), self)

    def mechanism(self, value: Any, name: str = "mechanism") -> None:
        """A mechanism."""
        if not isinstance(value, Mechanism):
            remedy = (
                "read it with load_model first"
                if isinstance(value, str) or hasattr(value, "__fspath__")
                else "make one, or read a model file"
            )
            self.fault(name, f"this is {kind_of(value)}", value, "a Mechanism", remedy)

    def mechanisms(self, values: Any) -> list[Mechanism]:
        """A sequence of mechanisms."""
        if not isinstance(values, Sequence):
            self.fault(
                "mechanisms",
                f"this is {kind_of(values)}",
                values,
                "a list of Mechanisms",
                "put it in square brackets",
            )
            return []
        for k, value in enumerate(values):
            self.mechanism(value, f"mechanisms[{k}]")
        return list(values)

    def quantity(self, name: str, value: Any, unit: str, *, zero: bool = False) -> float | None:
        """A quantity above zero (or zero, where that is allowed): a number in SI units, or a text with a
        unit; None stays None.
        """
        result: float | None = self.read(
            name, Measure(unit, low=0.0) if zero else Measure(unit, above=0.0), value
        )
        return result

    def step(self, value: Any) -> float | str | None:
        """A step (s), "auto" or None."""
        result: float | str | None = self.read("step", SHARED["step"], value)
        return result

    def run(self, *, loop: Any = "auto", force_step: Any = False, **values: Any) -> RunArguments:
        """The arguments that every run has; of ``turns`` and ``duration`` one at the most."""
        turns, duration = values.get("turns"), values.get("duration")
        if turns is not None and duration is not None:
            remedy = f"leave out one of them; duration is {shown(duration)}"
            self.fault("turns", "turns and duration exclude each other", turns, "", remedy)
        self.kind("force_step", force_step, (bool,), "True or False")
        result = {name: self.read(name, SHARED[name], value) for name, value in values.items()}
        return RunArguments(**result, loop=self.loop(loop), force_step=bool(force_step))

    def count(self, name: str, value: Any, *, optional: bool = True) -> int | None:
        """A whole number of 1 or more; None stays None where it is ``optional``."""
        if value is None and not optional:
            self.fault(name, "this is nothing", value, "a whole number of 1 or more", "give one")
        result: int | None = self.read(name, Integer(1, MOST), value)
        return result

    def loop(self, value: Any) -> Loop:
        """The name of a loop."""
        loops: tuple[Loop, ...] = get_args(Loop)
        for one in loops:
            if isinstance(value, str) and value == one:
                return one
        self.fault(
            "loop", "there is no such loop", value, "", suggestion(str(value), loops, "name another one")
        )
        return "auto"

    def device(self, value: Any) -> None:
        """What steps members beside the processor, or None."""
        if value not in (None, "cuda"):
            self.fault(
                "device",
                "there is no such device",
                value,
                '"cuda", or None for the processor',
                "give one of these",
            )

    def kind(self, name: str, value: Any, kinds: tuple[type, ...], limit: str) -> None:
        """A value of one of some classes."""
        if not isinstance(value, kinds):
            self.fault(name, f"this is {kind_of(value)}", value, limit, "give one of these")

    def callable(self, name: str, value: Any) -> None:
        """Something to be called, or None."""
        if value is not None and not callable(value):
            self.fault(
                name,
                f"this is {kind_of(value)}",
                value,
                "a function",
                "give the function itself, or leave it out",
            )

    def each(self, name: str, values: Any, count: int) -> list[float]:
        """One positive time (s) for all of ``count`` members, or a sequence of one for each."""
        single = isinstance(values, int | float | str) or not isinstance(values, Sequence | np.ndarray)
        each_value = [values] * count if single else list(values)
        if len(each_value) != count:
            self.fault(
                name,
                f"{len(each_value)} values for {count} mechanisms",
                values,
                "",
                "give one for all, or one for each",
            )
        result = [
            self.quantity(name if single else f"{name}[{k}]", value, "s")
            for k, value in enumerate(each_value[: 1 if single else None])
        ]
        if None in each_value:
            self.fault(name, "no step is given", values, "a time above 0 s", 'for example "1 us"')
        return [value or math.nan for value in (result * count if single else result)]


def _plain(value: Any) -> Any:
    """A number of NumPy as one of Python."""
    return (
        value.item()
        if isinstance(value, np.generic) or (isinstance(value, np.ndarray) and value.ndim == 0)
        else value
    )
