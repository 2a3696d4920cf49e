"""Arguments of a run, read by the fields of the settings of a model file: one validation for Python, files
and the command line.
"""

from __future__ import annotations

import dataclasses
import math
import os
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Literal, get_args

import numpy as np

from ..errors import ModelError, kind_of, shown, suggestion
from ..model.mechanism import Mechanism, Settings
from ..model.validation import refuse_types
from ..schema import Integer, Measure, Reader, Value, described_fields, value_of

Loop = Literal["auto", "data-driven", "generated", "interpreted"]
LARGEST_COUNT = 10**12  # largest number of anything that is counted: more is a mistake
# Settings of a model file that are also arguments of a run.
SHARED: dict[str, Value] = {
    field.name: value_of(field)
    for field in described_fields(Settings)
    if field.name in ("turns", "duration", "settle", "step", "outputs", "companions")
}


@dataclass(frozen=True)
class RunArguments:
    """Checked arguments of a run other than its mechanism; None stands for the mechanism's settings. Times
    are in s.
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
        """Return the mechanism with these values in its settings."""
        values: dict[str, Any] = {
            name: value for name in SHARED if (value := getattr(self, name)) is not None
        }
        if {"turns", "duration"} & values.keys():
            values = {"turns": None, "duration": None} | values
        return dataclasses.replace(mechanism, settings=dataclasses.replace(mechanism.settings, **values))


class Arguments(Reader):
    """Read the arguments of a public function one by one and collect their faults; :meth:`check` raises
    them.
    """

    def __init__(self, function: str) -> None:
        super().__init__(written=True)
        self.function = function

    def check(self) -> None:
        """Raise ModelError with all faults, if there are any."""
        if self.faults:
            raise ModelError(self.faults, f"{self.function}()")

    def fault(self, name: str, problem: str, value: Any, limit: str, remedy: str) -> None:
        """Add a fault of an argument."""
        self.refuse((name,), problem, "None" if value is None else shown(value), limit, remedy)

    def read(self, name: str, rules: Value, value: Any) -> Any:
        """Return the value of an argument, read by the rules of a field; None stays None."""
        return None if value is None else rules.read(_plain(value), (name,), self)

    def mechanism(self, value: Any, name: str = "mechanism") -> None:
        """Add a fault unless the value is a mechanism. Raises ModelError for one with values of another
        type.
        """
        if isinstance(value, Mechanism):
            refuse_types(value)
        else:
            remedy = (
                "read it first: vfife.load(path)"
                if isinstance(value, str) or hasattr(value, "__fspath__")
                else "make one, or read a model file"
            )
            self.fault(name, f"this is {kind_of(value)}", value, "a Mechanism", remedy)

    def mechanisms(self, values: Any) -> list[Mechanism]:
        """Return a sequence of mechanisms as a list; add faults for anything else."""
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
        """Return a positive quantity (with ``zero`` also zero) in SI units, from a number or a text with a
        unit; None stays None.
        """
        result: float | None = self.read(
            name, Measure(unit, low=0.0) if zero else Measure(unit, above=0.0), value
        )
        return result

    def step(self, value: Any) -> float | str | None:
        """Return a step (s), "auto" or None."""
        result: float | str | None = self.read("step", SHARED["step"], value)
        return result

    def run(self, *, loop: Any = "auto", force_step: Any = False, **values: Any) -> RunArguments:
        """Return the arguments that every run has; add a fault if both ``turns`` and ``duration`` are
        given.
        """
        turns, duration = values.get("turns"), values.get("duration")
        if turns is not None and duration is not None:
            remedy = f"leave out one of them; duration is {shown(duration)}"
            self.fault("turns", "turns and duration exclude each other", turns, "", remedy)
        self.kind("force_step", force_step, (bool,), "True or False")
        result = {name: self.read(name, SHARED[name], value) for name, value in values.items()}
        return RunArguments(**result, loop=self.loop(loop), force_step=bool(force_step))

    def count(self, name: str, value: Any, *, optional: bool = True, low: int = 1) -> int | None:
        """Return a whole number of ``low`` or more; None stays None if the argument is ``optional``."""
        if value is None and not optional:
            self.fault(name, "a value is missing", value, f"a whole number of {low} or more", "give one")
        result: int | None = self.read(name, Integer(low, LARGEST_COUNT), value)
        return result

    def pair(self, name: str, value: Any) -> tuple[int, int]:
        """Return two whole numbers of 1 or more, from one for both or a sequence of two."""
        values = value if isinstance(value, Sequence) and not isinstance(value, str) else (value, value)
        if len(values) != 2:
            limit = "a whole number of 1 or more, or two of them"
            self.fault(name, f"these are {len(values)} numbers", value, limit, "give one or two")
            return 1, 1
        first, second = (self.count(name, number, optional=False) or 1 for number in values)
        return first, second

    def loop(self, value: Any) -> Loop:
        """Return the name of a loop; add a fault for any other text."""
        loops: tuple[Loop, ...] = get_args(Loop)
        if isinstance(value, str) and value in loops:
            return value
        self.fault(
            "loop", "there is no such loop", value, "", suggestion(str(value), loops, "name another one")
        )
        return "auto"

    def device(self, value: Any) -> None:
        """Add a fault unless the value is the name of a device or None."""
        if value not in (None, "cuda"):
            self.fault(
                "device",
                "there is no such device",
                value,
                '"cuda", or None for the processor',
                "give one of these",
            )

    def kind(self, name: str, value: Any, kinds: tuple[type, ...], limit: str) -> None:
        """Add a fault unless the value is an instance of one of ``kinds``, which ``limit`` names."""
        if not isinstance(value, kinds):
            self.fault(name, f"this is {kind_of(value)}", value, limit, "give one of these")

    def names(self, name: str, value: Any, minimum: int = 0) -> tuple[str, ...]:
        """Return one name or a sequence of names, of the ``minimum`` length, as a tuple; add a fault for
        anything else.
        """
        names = (value,) if isinstance(value, str) else value
        if isinstance(names, Sequence) and all(isinstance(entry, str) for entry in names):
            if len(names) >= minimum:
                return tuple(names)
            self.fault(name, "it is empty", value, "one name or more", "give names, or leave it out")
            return ()
        self.fault(name, f"this is {kind_of(value)}", value, "a list of names", "give names, or leave it out")
        return ()

    def file(self, name: str, value: Any) -> None:
        """Add a fault unless the value is a path or None."""
        if value is not None and not isinstance(value, str | os.PathLike):
            remedy = "give the path of a file, or leave it out"
            self.fault(name, f"this is {kind_of(value)}", value, "a path", remedy)

    def folder(self, name: str, value: str | os.PathLike[str] | None) -> None:
        """Add a fault unless the folder of the path exists, or the value is None."""
        if value is not None and not os.path.isdir(folder := os.path.dirname(os.path.abspath(value))):
            self.fault(name, "there is no such folder", folder, "", "make it first")

    def callable(self, name: str, value: Any) -> None:
        """Add a fault unless the value is a function or None."""
        if value is not None and not callable(value):
            self.fault(
                name,
                f"this is {kind_of(value)}",
                value,
                "a function",
                "give the function itself, or leave it out",
            )

    def positive_times(self, name: str, values: Any, count: int) -> list[float]:
        """Return ``count`` positive times (s) from one for all or a sequence of one for each."""
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
    """Return a number of NumPy as one of Python."""
    return (
        value.item()
        if isinstance(value, np.generic) or (isinstance(value, np.ndarray) and value.ndim == 0)
        else value
    )
