"""What a run is asked for in Python, checked before anything is done: all faults at once, in the sentences of a model file."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Literal, get_args

import numpy as np

from ..errors import Fault, ModelError, kind_of, shown, suggestion
from ..model.mechanism import MOST_COMPANIONS, Mechanism
from ..units import dimension_of, number

Loop = Literal["auto", "data-driven", "generated", "interpreted"]
MOST = 10**12  # of anything that is counted; more is a slip of units


@dataclass(frozen=True)
class Asked:
    """What a run is asked for beside its mechanism, checked; None leaves it to the mechanism's settings. Times are in s."""

    turns: float | None = None
    duration: float | None = None
    step: float | str | None = None
    outputs: int | None = None
    loop: Loop = "auto"
    force_step: bool = False
    companions: int | str | None = None
    settle: float | None = None


class Arguments:
    """Reads the arguments of a function one by one and gathers what is wrong with them; :meth:`tell` raises it."""

    def __init__(self, function: str) -> None:
        self.function = function
        self.faults: list[Fault] = []

    def tell(self) -> None:
        """Raises ModelError with all faults, if there are any."""
        if self.faults:
            raise ModelError(self.faults, f"{self.function}()")

    def fault(self, name: str, what: str, value: Any, limit: str, remedy: str) -> None:
        """Notes a fault of an argument."""
        self.faults.append(Fault(name, what, told(value), limit, remedy))

    def mechanism(self, value: Any, name: str = "mechanism") -> None:
        """A mechanism."""
        if not isinstance(value, Mechanism):
            remedy = "read it with load_model first" if isinstance(value, str) or hasattr(value, "__fspath__") else "make one, or read a model file"
            self.fault(name, f"this is {kind_of(value)}", value, "a Mechanism", remedy)

    def mechanisms(self, values: Any) -> list[Mechanism]:
        """A sequence of mechanisms."""
        if not isinstance(values, Sequence):
            self.fault("mechanisms", f"this is {kind_of(values)}", values, "a list of Mechanisms", "put it in square brackets")
            return []
        for k, value in enumerate(values):
            self.mechanism(value, f"mechanisms[{k}]")
        return list(values)

    def quantity(self, name: str, value: Any, unit: str, *, zero: bool = False) -> float | None:
        """A finite quantity above zero (or zero, where that is allowed): a number in SI units, or a text with a unit; None stays None."""
        if value is None:
            return None
        words, example = dimension_of(unit)
        limit = f"{words} {'of 0 or more' if zero else f'above 0{_of(unit)}'}"
        try:
            found = number(_plain(value), unit)
        except Fault as error:
            self.fault(name, f"this is {error.what}", value, limit, f'for example "{example}"' if unit != "1" else "for example 2")
            return None
        if found < 0.0 or (found == 0.0 and not zero):
            self.fault(name, "zero or negative" if not zero else "negative", value, limit, "give a positive one, or leave it out")
            return None
        return found

    def share(self, name: str, value: Any) -> float | None:
        """A quantity above 0 and up to 1: a number, or a text in per cent; None stays None."""
        found = self.quantity(name, value, "1")
        if found is not None and found > 1.0:
            self.fault(name, "out of range", value, "a share above 0 and up to 1", 'for example 0.01, or "1 %"')
            return None
        return found

    def step(self, value: Any) -> float | str | None:
        """A step (s), "auto" or None."""
        if isinstance(value, str) and value.strip().lower() == "auto":
            return "auto"
        before = len(self.faults)
        found = self.quantity("step", value, "s")
        if len(self.faults) > before:
            last = self.faults[-1]
            self.faults[-1] = Fault(last.where, last.what, last.value, 'a time above 0 s, or "auto"', 'for example "1 us"')
        return found

    def run(
        self, *, turns: Any, duration: Any, step: Any, outputs: Any, loop: Any, force_step: Any, companions: Any = None, settle: Any = None
    ) -> Asked:
        """The arguments that every run has; of ``turns`` and ``duration`` one at the most."""
        if turns is not None and duration is not None:
            self.fault("turns", "turns and duration exclude each other", turns, "", f"leave out one of them; duration is {told(duration)}")
        self.one_of("force_step", force_step, (bool,), "True or False")
        return Asked(
            self.quantity("turns", turns, "1"), self.quantity("duration", duration, "s"), self.step(step),
            self.count("outputs", outputs), self.loop(loop), bool(force_step), self.companions(companions),
            self.share("settle", settle),
        )  # fmt: skip

    def companions(self, value: Any) -> int | str | None:
        """Runs beside a run: a whole number that fits the lanes, "auto" or None."""
        value = _plain(value)
        if value is None or value == "auto":
            return None if value is None else "auto"
        whole = isinstance(value, int) and not isinstance(value, bool)
        if not whole or not 0 <= value <= MOST_COMPANIONS:
            limit = f'a whole number from 0 to {MOST_COMPANIONS}, or "auto"'
            self.fault("companions", "out of range" if whole else f"this is {kind_of(value)}", value, limit, "give one of these")
            return None
        return int(value)

    def count(self, name: str, value: Any, *, optional: bool = True) -> int | None:
        """A whole number of 1 or more; None stays None where it is ``optional``."""
        if value is None and optional:
            return None
        value = _plain(value)
        if isinstance(value, bool) or not isinstance(value, int):
            self.fault(name, f"this is {kind_of(value)}", value, "a whole number of 1 or more", "write it without a fraction, unit or quotes")
        elif not 1 <= value <= MOST:
            self.fault(name, "out of range", value, f"a whole number from 1 to {MOST:.0e}", "give at least 1" if value < 1 else "give fewer")
        else:
            return int(value)
        return None

    def loop(self, value: Any) -> Loop:
        """The name of a loop."""
        known: tuple[Loop, ...] = get_args(Loop)
        for one in known:
            if isinstance(value, str) and value == one:
                return one
        self.fault("loop", "there is no such loop", value, "", suggestion(str(value), known, "name another one"))
        return "auto"

    def device(self, value: Any) -> None:
        """What steps members beside the processor, or None."""
        if value not in (None, "cuda"):
            self.fault("device", "there is no such device", value, '"cuda", or None for the processor', "give one of these")

    def one_of(self, name: str, value: Any, kinds: tuple[type, ...], limit: str) -> None:
        """A value of one of some classes."""
        if not isinstance(value, kinds):
            self.fault(name, f"this is {kind_of(value)}", value, limit, "give one of these")

    def callable(self, name: str, value: Any) -> None:
        """Something to be called, or None."""
        if value is not None and not callable(value):
            self.fault(name, f"this is {kind_of(value)}", value, "a function", "give the function itself, or leave it out")

    def each(self, name: str, values: Any, count: int) -> list[float]:
        """One positive time (s) for all of ``count`` members, or a sequence of one for each."""
        single = isinstance(values, int | float | str) or not isinstance(values, Sequence | np.ndarray)
        given = [values] * count if single else list(values)
        if len(given) != count:
            self.fault(name, f"{len(given)} values for {count} mechanisms", values, "", "give one for all, or one for each")
        found = [self.quantity(name if single else f"{name}[{k}]", value, "s") for k, value in enumerate(given[: 1 if single else None])]
        if None in given:
            self.fault(name, "no step is given", values, "a time above 0 s", 'for example "1 us"')
        return [value or math.nan for value in (found * count if single else found)]


def _plain(value: Any) -> Any:
    """A number of NumPy as one of Python."""
    return value.item() if isinstance(value, np.generic) or (isinstance(value, np.ndarray) and value.ndim == 0) else value


def _of(unit: str) -> str:
    return "" if unit == "1" else f" {unit}"


def told(value: Any) -> str:
    """A value as it would be written."""
    return "None" if value is None else shown(value)
