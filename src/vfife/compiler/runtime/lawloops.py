"""The functions of laws by themselves in every loop, so that a law can be compared with Python before a step
is compiled with it.

A *part* of a law is one of its functions. Its arguments and answers are rows of a small state, laid out as in
``PARTS``. The same choice between laws calls it as in a step (:mod:`~vfife.compiler.trace.source`), and the
same code traces, orders, writes and compiles it. A difference to Python is therefore found here, where it can
be attributed to the law.
"""

from __future__ import annotations

import ctypes
import math
from collections.abc import Callable, Sequence
from types import FunctionType
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...kernels.elementary import nearest
from ..backends import javascript, python
from ..backends.gpu import TILE
from ..backends.llvm import full_step, operators
from ..trace.schedule import in_place, ordered, streamed
from ..trace.source import Gathered, choices
from ..trace.straight_line import give_laws_of
from ..trace.tape import Rows as TracedRows
from ..trace.tape import Tape, Trace
from ..trace.traceable import WRITING, Traceable
from .loops import aligned
from .native import Code, compiled, interpreted, object_code
from .ptx import assembly

Rows = NDArray[np.float64]
WIDTHS = (1, 2, 4, 8)


class Part(NamedTuple):
    """The rows of a part: its answers, its arguments, its memory (which is both), and the first of its slots;
    the ``text`` that calls the ``choice`` between laws, and the ``function`` of a law that this calls.
    """

    answers: tuple[int, ...]
    arguments: tuple[int, ...]
    memory: int
    slots: int
    text: str
    choice: str
    function: str = "force"


PARTS = {
    "contact": Part(
        (0, 1), (2, 3), 0, 4, "S[at], S[at + 1] = contact_law(kind, S[at + 2], S[at + 3], S, at + 4)",
        "contact_law",
    ),
    "friction": Part(
        (0,), (1, 2, 3, 4), 5, 8,
        "S[at] = friction_law(kind, S[at + 1], S[at + 2], S[at + 3], S[at + 4], S, at + 8, at + 5)",
        "friction_law",
    ),
    "film": Part(
        (0, 1, 2, 3, 4), (5, 6, 7), 0, 8,
        "S[at], S[at + 1], S[at + 2], S[at + 3], S[at + 4] ="
        " film_law(kind, S[at + 5], S[at + 6], S[at + 7], S, at + 8)",
        "film_law", "film_force",
    ),
    "regime": Part(
        (0,), (1,), 0, 2, "S[at] = friction_regime(kind, S[at + 1], S, at + 2)", "friction_regime", "regime"
    ),
}  # fmt: skip


class Single(NamedTuple):
    """One part of one law."""

    part: str
    law: Any

    @property
    def rows(self) -> int:
        """Number of rows of its state."""
        return PARTS[self.part].slots + max(len(self.law.slots), 1)

    @property
    def answers(self) -> list[int]:
        """Rows of its answers, memory last."""
        part = PARTS[self.part]
        remembers = len(self.law.memory) if self.part == "friction" else 0
        return [*part.answers, *range(part.memory, part.memory + remembers)]

    @property
    def law_classes(self) -> tuple[tuple[type, ...], tuple[type, ...]]:
        """Contact laws and friction laws of a step that has only this law."""
        return ((self.law,), ()) if self.part in ("contact", "film") else ((), (self.law,))


def traced(single: Single) -> Trace:
    """Return the trace of a part, as in a step. Raises what the law's text raises for constants, such as
    ZeroDivisionError.
    """
    tape = Tape()
    rows = TracedRows(tape, {}, set(single.answers))
    with WRITING:
        traceable = Traceable(tape)
        give_laws_of(traceable, *single.law_classes)
        function = traceable.written(f"def single(kind, S, at):\n    {PARTS[single.part].text}\n", {})
        function(0, rows, 0)
    return tape.trace_of(rows.stores())


def data_driven_text(singles: Sequence[Single]) -> str:
    """Return the text of the data-driven loop's choice between laws of one part, with a function that calls
    it for several states.
    """
    (name,) = {single.part for single in singles}
    contacts, frictions = (
        tuple(law for single in singles for law in single.law_classes[k]) for k in range(2)
    )
    gathered = Gathered()
    with WRITING:
        texts = choices(contacts, frictions, gathered)
    driver = f"def single(kind, S, at):\n    {PARTS[name].text}\n"
    driver += (
        "def states(S, kind, rows, count):\n    for m in range(count):\n        single(kind, S, rows * m)\n"
    )
    return "\n\n".join([gathered.text(), texts[PARTS[name].choice], driver])


def text_of(single: Single) -> str:
    """Return all that decides the bits of a part: its text, those of the functions that it calls, and the
    constants of their files.
    """
    return data_driven_text([single])


class Loops:
    """Laws of one part in every loop that this machine can run.

    A loop is a function of the index of a law and of states, shape (states, rows); it returns the states with
    their answers.
    """

    def __init__(self, singles: Sequence[Single], widths: Sequence[int] = WIDTHS) -> None:
        self.singles = tuple(singles)
        self.traces = [traced(single) for single in singles]
        text = data_driven_text(singles)
        self.compiled: dict[str, Callable[[int, Rows], Rows]] = {
            "data-driven": _states(compiled(text, "states", "f1 i i i")),
            "interpreted": _listed(interpreted(text, "states")),
            "straight line as Python": self._python(),
            **{
                f"generated, {width} lane{'s' * (width > 1)}": self._generated(width, width)
                for width in widths
            },
            "text for graphics cards, on this processor": self._generated(1, TILE),
        }

    def _generated(self, width: int, stride: int) -> Callable[[int, Rows], Rows]:
        texts = [full_step(trace, width, False, stride == width, stride) for trace in self.traces]
        names = [f"@law{k}(" for k in range(len(texts))]
        named = [
            text.replace("@full_step(", name).replace("define internal ", "define ")
            for text, name in zip(texts, names, strict=True)
        ]
        code = Code(object_code("\n".join([operators(width), *named])))
        functions = [code.named(f"law{k}", STEP) for k in range(len(texts))]

        def run(place: int, states: Rows) -> Rows:
            count, rows = states.shape
            groups = -(-count // width)
            memory = aligned(groups * rows * stride)
            lanes = memory.reshape(groups, rows, stride)
            padded = np.concatenate([states, np.repeat(states[-1:], groups * width - count, axis=0)])
            lanes[:, :, :width] = padded.reshape(groups, width, rows).transpose(0, 2, 1)
            for group in range(groups):
                functions[place](memory.ctypes.data + 8 * group * rows * stride, None, 0, 0)
            _ = code  # keeps the code in memory as long as this function
            return lanes[:, :, :width].transpose(0, 2, 1).reshape(-1, rows)[:count].copy()

        return run

    def _python(self) -> Callable[[int, Rows], Rows]:
        functions = []
        for trace in self.traces:
            space: dict[str, Any] = {"sqrt": math.sqrt, "nearest": nearest}
            text = python.definition(
                "full_step(S, n)", [*map(python.line, in_place(trace, ordered(trace))), "return True"]
            )
            # The text is our own and the user's laws, never a model file's.
            exec(compile(text, "<vfife law>", "exec"), space)
            functions.append(space["full_step"])
        return _listed(lambda S, place, rows, count: functions[place](S, 0))

    def javascript(self) -> str:
        """Return a text with functions ``law0(S)``, ``law1(S)`` ... as pages use them."""
        texts = [
            javascript.definition(f"law{k}(S)", map(javascript.line, in_place(trace, streamed(trace))))
            for k, trace in enumerate(self.traces)
        ]
        return "\n".join(texts)

    def ptx(self) -> str:
        """Return the PTX of kernels ``card0``, ``card1`` ..., for one thread each."""
        texts = [
            full_step(trace, 1, False, True, TILE).replace("@full_step(", f"@law{k}(")
            for k, trace in enumerate(self.traces)
        ]
        kernels = [
            f"define ptx_kernel void @card{k}(ptr %S) {{\n  call void @law{k}(ptr %S, ptr %S, i64 0, i64 0)\n"
            "  ret void\n}\n"
            for k in range(len(texts))
        ]
        return assembly("\n".join([operators(1), *texts]), "\n".join(kernels))


STEP = ctypes.CFUNCTYPE(None, ctypes.c_void_p, ctypes.c_void_p, ctypes.c_int64, ctypes.c_int64)


def _states(function: Callable[..., Any]) -> Callable[[int, Rows], Rows]:
    """Return a function that runs a compiled loop over all states at once."""

    def run(place: int, states: Rows) -> Rows:
        flat = np.ascontiguousarray(states).reshape(-1).copy()
        function(flat, place, states.shape[1], len(states))
        return flat.reshape(states.shape)

    return run


def _listed(function: Callable[..., Any]) -> Callable[[int, Rows], Rows]:
    """Return a function that runs plain Python state by state, with NaN in all rows where Python raises."""

    def run(place: int, states: Rows) -> Rows:
        answers = []
        for state in states.tolist():
            try:
                function(state, place, len(state), 1)
                answers.append(state)
            except (ArithmeticError, ValueError):
                answers.append([np.nan] * len(state))
        return np.array(answers)

    return run


def plain_function(single: Single) -> FunctionType:
    """Return the function of the law itself."""
    function: FunctionType = getattr(single.law, PARTS[single.part].function)
    return function
