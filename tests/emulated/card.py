"""PTX of a law, run without a card: an interpreter of what LLVM writes for a straight line of operations, for
many threads at once.

It follows NVIDIA's *PTX ISA* (8.x, sections 9.7.3 to 9.7.9): ``.rn`` is IEEE 754's rounding to nearest,
``min`` and ``max`` return the number where the other operand is NaN and hold -0.0 to be less than 0.0,
comparisons with a ``u`` are true where an operand is NaN. Anything else raises, so that nothing is run which
is not known.
"""

from __future__ import annotations

import re
import struct

import numpy as np

BODY = re.compile(r"^\.func (\w+)\(.*?^\{(.*?)^\}", re.M | re.S)
LINE = re.compile(r"^\s*(?:@(!?%p\d+)\s+)?([a-z][\w.]*)\s*(.*?);\s*$|^\s*(\$\w+):.*$")
Instruction = tuple[
    str, str, list[str]
]  # condition or nothing, name, operands; of a label the name alone, which begins with $
TILE = 32


def functions(text: str) -> dict[str, list[Instruction]]:
    """Instructions of each function."""
    found = {}
    for name, body in BODY.findall(text):
        lines = [
            one for one in body.splitlines() if one.strip() and not one.strip().startswith((".reg", "//"))
        ]
        matched = [LINE.match(one) for one in lines]
        if None in matched:
            raise ValueError(f"no instruction: {lines[matched.index(None)]}")
        found[name] = [
            (one[1] or "", one[2] or one[4], [part.strip() for part in (one[3] or "").split(",")])
            for one in matched
            if one
        ]
    return found


def less(a: np.ndarray, b: np.ndarray, largest: bool) -> np.ndarray:
    """``min`` or ``max``."""
    low = (a > b) if largest else (a < b)
    found = np.where(low, a, b)
    zeros = (a == 0.0) & (b == 0.0)
    negative = (np.signbit(a) & np.signbit(b)) if largest else (np.signbit(a) | np.signbit(b))
    found = np.where(zeros, np.where(negative, -0.0, 0.0), found)
    return np.where(np.isnan(a), b, np.where(np.isnan(b), a, found))


def double(a: np.ndarray) -> np.ndarray:
    """What 64 bits are as a double."""
    return a.view(np.float64) if a.dtype == np.int64 else a


COMPARISONS = {
    "gt": np.greater, "lt": np.less, "ge": np.greater_equal, "le": np.less_equal, "eq": np.equal,
    "ne": lambda a, b: (a != b) & ~(np.isnan(a) | np.isnan(b)),
    "num": lambda a, b: ~(np.isnan(a) | np.isnan(b)), "nan": lambda a, b: np.isnan(a) | np.isnan(b),
}  # fmt: skip
ARITHMETIC = {
    "mul.rn.f64": np.multiply, "add.rn.f64": np.add, "sub.rn.f64": np.subtract, "div.rn.f64": np.divide,
    "sqrt.rn.f64": np.sqrt, "rcp.rn.f64": lambda a: 1.0 / a, "neg.f64": np.negative, "abs.f64": np.abs,
    "min.f64": lambda a, b: less(a, b, False), "max.f64": lambda a, b: less(a, b, True),
    "and.pred": np.logical_and, "or.pred": np.logical_or, "xor.pred": np.logical_xor,
    "not.pred": np.logical_not, "add.s64": np.add,
}  # fmt: skip


def run(instructions: list[Instruction], states: np.ndarray) -> np.ndarray:
    """What a function makes of states, (states, rows), row r of which it finds 32 r numbers behind its
    address.
    """
    memory = states.T.copy()
    names: dict[str, np.ndarray] = {}

    def value(text: str) -> np.ndarray:
        if text.startswith("%"):
            return names[text]
        if text.startswith("0d"):
            return np.full(len(states), struct.unpack(">d", bytes.fromhex(text[2:]))[0])
        return np.full(len(states), int(text), dtype=np.int64)

    def place(text: str) -> np.ndarray:
        name, _, more = text.strip("[]").partition("+")
        at = names[name] + int(more or 0)
        return at // (8 * TILE)

    every, at = np.arange(len(states)), 0
    labels = {name: k for k, (_, name, _) in enumerate(instructions) if name[0] == "$"}
    with np.errstate(all="ignore"):
        while at < len(instructions):
            condition, name, operands = instructions[at]
            at += 1
            if name[0] == "$":
                continue
            if name in ("bra", "bra.uni"):
                goes = (
                    value(condition.lstrip("!")) ^ condition.startswith("!")
                    if condition
                    else np.ones(1, bool)
                )
                if goes.all() != goes.any():
                    raise ValueError("threads part")
                at = labels[operands[0]] if goes.all() else at
            elif condition:
                raise ValueError(f"a condition of {name}")
            elif name == "ld.param.b64":
                names[operands[0]] = np.zeros(len(states), dtype=np.int64)
            elif name.startswith("ld.global"):
                names[operands[0]] = memory[place(operands[1]), every]
            elif name.startswith("st.global"):
                memory[place(operands[0]), every] = double(value(operands[1]))
            elif name.startswith("setp."):
                kind = name.split(".")[1]
                if name.endswith("s64"):
                    names[operands[0]] = COMPARISONS[kind](value(operands[1]), value(operands[2]))
                    continue
                a, b = double(value(operands[1])), double(value(operands[2]))
                known = COMPARISONS[kind if kind in COMPARISONS else kind.removesuffix("u")]
                names[operands[0]] = known(a, b) | (
                    (np.isnan(a) | np.isnan(b)) if kind not in COMPARISONS else False
                )
            elif name in ("selp.f64", "selp.b64"):
                a, b = value(operands[1]), value(operands[2])
                if a.dtype != b.dtype:
                    a, b = double(a), double(b)
                names[operands[0]] = np.where(value(operands[3]), a, b)
            elif name in ("mov.b64", "mov.f64", "mov.pred"):
                names[operands[0]] = value(operands[1])
            elif name == "ret":
                return memory.T.copy()
            elif name not in ARITHMETIC:
                raise ValueError(f"PTX: {name} is no instruction that is known to round")
            else:
                given = map(value, operands[1:])
                names[operands[0]] = ARITHMETIC[name](
                    *(map(double, given) if name.endswith("f64") else given)
                )
    raise ValueError("the function does not end")
