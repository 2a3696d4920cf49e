"""Compare a law in every loop with Python: the same bits at random arguments and at those where comparisons
change.

Python runs the law's own function; each loop runs its translation. Arguments are drawn from all magnitudes
and from special values: zeros of both signs, the smallest and largest doubles, infinity, the numbers with
which the text compares and their neighbours, and the law's own parameters. Where Python raises (a division by
zero, the root of a negative number), the compiled loops have to agree with each other.
"""

from __future__ import annotations

import base64
import json
import math
import shutil
import subprocess
import traceback
from collections.abc import Sequence
from types import FunctionType
from typing import Any, NamedTuple
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import NDArray

from ..compiler.runtime.lawloops import PARTS, Loops, Single, plain_function
from ..compiler.trace.tape import COMPARISONS, Trace
from ..errors import LawError, SourceError
from .grammar import REMEDY

Rows = NDArray[np.float64]

STATES = 256  # number of states at which a law is compared
SPECIAL = (
    0.0,
    -0.0,
    5e-324,
    1e-308,
    1e-30,
    1e-12,
    1.0,
    -1.0,
    0.5,
    1e6,
    1e30,
    1e300,
    1.7976931348623157e308,
    math.inf,
    -math.inf,
    math.nan,
)
SECONDS = 20.0  # time limit of node
NO_NODE = "JavaScript: not compared, because there is no node on this machine"


class Agreement(NamedTuple):
    """The result of a comparison: the ``loops``, the number of ``states``, a note on ``javascript``, and the
    ``faults``, none if all agree.
    """

    loops: tuple[str, ...]
    states: int
    javascript: str
    faults: tuple[str, ...]

    def words(self) -> str:
        """Return the result as a sentence."""
        from_card = "text for graphics cards: run on this processor, not on a card"
        return (
            f"equal to Python to the bit at {self.states} states in {len(self.loops)} loops;"
            f" {self.javascript}; {from_card}"
        )


def states_of(single: Single, trace: Trace, slots: Sequence[float], count: int, seed: int = 1) -> Rows:
    """Return states of a part, shape (count, rows): half of the values are special, half random over all
    magnitudes that occur.
    """
    random = np.random.default_rng(seed)
    compared = [
        operand
        for operation in trace.operations
        if operation.operator in COMPARISONS
        for operand in operation.operands
        if isinstance(operand, float)
    ]
    turns = [
        float(neighbour)
        for value in [*compared, *slots]
        for neighbour in (value, np.nextafter(value, -np.inf), np.nextafter(value, np.inf))
    ]
    pool = np.array([*SPECIAL, *turns, *turns])
    shape = (count, single.rows)
    spread = random.choice([-1.0, 1.0, 1.0], shape) * 10.0 ** random.uniform(-12.0, 6.0, shape)
    states = np.where(random.random(shape) < 0.5, random.choice(pool, shape), spread)
    part = PARTS[single.part]
    usual = random.random(count) < 0.6  # the law's own parameters, nearly always
    states[usual, part.slots : part.slots + len(slots)] = slots
    states[:, [k for k in part.answers if k not in part.arguments]] = 0.0
    twins = random.random(count) < 0.1  # two arguments that are equal: a comparison of them turns there
    first, second = random.choice(part.arguments, 2)
    states[twins, first] = states[twins, second]
    return states


def by_python(single: Single, states: Rows) -> Rows:
    """Return the answers of the law's own function at states, shape (states, answers), None in all rows of a
    state at which it raises.
    """
    part, function = PARTS[single.part], plain_function(single)
    rows: list[list[float | None]] = []
    memories = len(single.law.memory) if single.part == "friction" else 0
    for state in states.tolist():
        slots = tuple(state[part.slots : part.slots + len(single.law.slots)])
        arguments: list[Any] = [state[k] for k in part.arguments]
        if single.part == "friction":
            memory = tuple(state[part.memory : part.memory + memories])
            arguments.insert(3, memory if memories > 1 else memory[0] if memories else 0.0)
        try:
            answer: Any = function(*arguments, slots)
        except (ArithmeticError, ValueError):
            rows.append([None] * len(single.answers))
            continue
        if single.part == "friction":
            force, memory = answer
            left = memory if memories > 1 else (memory,) * memories
            answer = (force, *(number if state[part.arguments[0]] > 0.0 else 0.0 for number in left))
        rows.append([float(number) for number in (answer if isinstance(answer, tuple) else (answer,))])
    return np.array(rows, dtype=object)


def same_bits(first: Rows, second: Rows) -> NDArray[np.bool_]:
    """Return whether numbers have the same bits; any NaN equals any other."""
    a, b = np.ascontiguousarray(first), np.ascontiguousarray(second)
    equal: NDArray[np.bool_] = (a.view(np.uint64) == b.view(np.uint64)) | (np.isnan(a) & np.isnan(b))
    return equal


def node_answers(loops: Loops, states: Sequence[Rows]) -> list[Rows]:
    """Return the states of each law after JavaScript. Raises OSError or SubprocessError if node does not
    run.
    """
    data = [
        {"rows": array.shape[1], "bytes": base64.b64encode(np.ascontiguousarray(array).tobytes()).decode()}
        for array in states
    ]
    script = (
        loops.javascript()
        + f"""
const laws = [{", ".join(f"law{k}" for k in range(len(states)))}];
const data = {json.dumps(data)};
const found = data.map((one, k) => {{
  const bytes = Buffer.from(one.bytes, "base64"), S = new Float64Array(bytes.length / 8);
  for (let i = 0; i < S.length; i++) S[i] = bytes.readDoubleLE(8 * i);
  for (let at = 0; at < S.length; at += one.rows) laws[k](S.subarray(at, at + one.rows));
  return Buffer.from(S.buffer).toString("base64");
}});
process.stdout.write(JSON.stringify(found));
"""
    )
    command = [shutil.which("node") or "node", "-"]
    done = subprocess.run(command, input=script, capture_output=True, text=True, timeout=SECONDS, check=True)
    return [
        np.frombuffer(base64.b64decode(text)).reshape(array.shape)
        for text, array in zip(json.loads(done.stdout), states, strict=True)
    ]


def compared(
    loops: Loops, slots: Sequence[Sequence[float]], count: int, javascript: bool, seed: int = 1
) -> Agreement:
    """Compare laws in all loops with Python at ``count`` states each; ``javascript``: also in node."""
    faults, javascript_note = [], "JavaScript: not compared here"
    states = [
        states_of(single, trace, numbers, count, seed)
        for single, trace, numbers in zip(loops.singles, loops.traces, slots, strict=True)
    ]
    runs = {
        name: [function(k, array) for k, array in enumerate(states)]
        for name, function in loops.compiled.items()
    }
    if javascript:
        try:
            runs["JavaScript"], javascript_note = node_answers(loops, states), "JavaScript: compared in node"
        except FileNotFoundError:
            javascript_note = NO_NODE
        except (OSError, subprocess.SubprocessError, ValueError) as error:
            javascript_note = f"JavaScript: not compared, because node did not run ({type(error).__name__})"
    for k, single in enumerate(loops.singles):
        fault = first_difference(single, states[k], {name: rows[k] for name, rows in runs.items()})
        if fault:
            faults.append(fault)
    return Agreement(tuple(runs), count * len(loops.singles), javascript_note, tuple(faults))


def first_difference(single: Single, states: Rows, runs: dict[str, Rows]) -> str:
    """Return a sentence on the first difference of a loop from Python, or from the other loops where Python
    raises; empty if there is none.
    """
    rows, expected = single.answers, by_python(single, states)
    raises = np.array([row[0] is None for row in expected])
    reference = runs["generated, 1 lane"][:, rows].copy()
    reference[~raises] = expected[~raises].astype(float)
    for name, answers in runs.items():
        # In vfife's own laws zero terms are dropped, which changes signs of zeros and results with infinity:
        # only finite states are compared, and zeros of both signs are equal.
        is_built_in = plain_function(single).__module__.startswith("vfife.")
        looked = (
            ~raises
            if is_built_in or name in ("interpreted", "straight line as Python")
            else np.ones(len(states), bool)
        )
        if is_built_in:
            looked &= np.isfinite(states).all(axis=1) & np.isfinite(reference).all(axis=1)
        equal = same_bits(answers[:, rows], reference) | (is_built_in & (answers[:, rows] == reference))
        # Straight-line Python computes both arms of a choice, and raises in the one that is not chosen.
        if name == "straight line as Python":
            equal |= np.isnan(answers[:, rows])
        wrong = np.flatnonzero(looked & ~equal.all(axis=1))
        if len(wrong):
            at = int(wrong[0])
            k = int(np.flatnonzero(~equal[at])[0])
            source = "the other loops have" if raises[at] else "Python computes"
            numbers = ", ".join(f"{value!r}" for value in states[at].tolist())
            return (
                f"function {plain_function(single).__name__}: {source} {float(reference[at, k])!r} and the"
                f" loop {name!r} {float(answers[at, rows[k]])!r} as answer {k + 1} (at the state {numbers})."
                " This is a fault of vfife: report it with the law's text, and do not use the law until then"
            )
    return ""


# Results by class: a study assembles thousands of cases with one law.
_CACHE: WeakKeyDictionary[type, dict[tuple[str, bool], Agreement]] = WeakKeyDictionary()


def forget(law: type) -> None:
    """Forget the results of a law."""
    _CACHE.pop(law, None)


def agreement_of(part: str, law: type, slots: tuple[float, ...], javascript: bool = False) -> Agreement:
    """Compare one part of a law, once for each class. Raises LawError if it cannot be compiled."""
    cached = _CACHE.setdefault(law, {})
    agreement = cached.get((part, True)) or cached.get((part, javascript))
    if agreement is None:
        agreement = cached[part, javascript] = _agreement(Single(part, law), slots, javascript)
    return agreement


def _agreement(single: Single, slots: tuple[float, ...], javascript: bool) -> Agreement:
    try:
        return compared(Loops([single]), [slots], STATES, javascript)
    except SourceError as error:
        problem = str(error)
    except (ArithmeticError, ValueError) as error:
        reason = (
            "numbers of its text are divided by zero"
            if isinstance(error, ZeroDivisionError)
            else f"numbers of its text give none ({error})"
        )
        problem = (
            f"line {line_of(error, plain_function(single))}: {reason}; both arms of `a if condition else b`"
            " are computed: work it out in parameters()"
        )
    except RecursionError:
        problem = "its expressions are nested too deeply; give parts of them names of their own"
    except Exception as error:
        problem = f"it cannot be written into the step ({type(error).__name__}: {error}). {REMEDY}"
    raise LawError(f"function {plain_function(single).__name__}, {problem}")


def line_of(error: BaseException, function: FunctionType) -> int | str:
    """Return the line of the law's file at which the trace of a function failed."""
    frames = traceback.extract_tb(error.__traceback__)
    inside = [frame for frame in frames if frame.filename in ("<vfife trace>", function.__code__.co_filename)]
    if not inside or inside[-1].filename != "<vfife trace>":
        return inside[-1].lineno or "?" if inside else "?"
    name = next((frame.name for frame in reversed(inside) if frame.name != "<lambda>"), function.__name__)
    failed: Any = function if name == function.__name__ else function.__globals__.get(name, function)
    return (inside[-1].lineno or 1) + int(failed.__code__.co_firstlineno) - 1
