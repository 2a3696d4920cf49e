"""Laws that nobody wrote: random texts in the language of laws, and texts with one thing in them that is not
in it.

A file of laws has some dozens of classes; every text depends on the seed alone.
"""

from __future__ import annotations

import linecache
import random
import sys
import types
from typing import Any

HEAD = """import math
from enum import IntEnum
from typing import ClassVar
from vfife.kernels.elementary import approach, nearest, power, turned
from vfife.laws import ContactLaw, FrictionLaw

SHARE = 0.75
NEGATIVE = -2.5
ROUNDS = 3
ON = True
BIG = 1e300
class Level(IntEnum):
    low = 1
    high = 2
HIGH = Level.high


def clipped(x, low, high):
    x = low if x < low else x
    return high if x > high else x


def ordered(a, b):
    return (a, b) if a < b else (b, a)


def inside(x, low, high):
    return low <= x and x < high


def limited(x, most):
    beyond = x > most
    return beyond, most if beyond else x


def summed(n, x):
    total = x
    for k in range(4):
        total += x * (k + n)
    return total


def with_default(x, y=2.0):
    return x * y


def endless(x):
    return endless(x)
"""
LITERALS = (
    "math.inf",
    "0.0",
    "-0.0",
    "1.0",
    "-1.0",
    "0.5",
    "2.0",
    "3.7",
    "1e-6",
    "1e-300",
    "1e300",
    "1e6",
    "SHARE",
    "NEGATIVE",
    "BIG",
    "math.pi",
)
WHOLES = ("0", "1", "2", "3", "7", "ROUNDS", "2 ** 3", "-1")
EXPONENTS = ("0.5", "2", "2.5", "-1", "-(3 / 2)", "8")
# What is not in the language; {n} is a number, {t} a truth value, {w} a whole number.
FOREIGN = (
    "({n} or {n})", "({n} and {n})", "({t} and {n})", "({t} + {n})", "({n} if {n} else {n})", "({n} ** 2.25)",
    "({w} << 1)", "(not {t})", "({n} < {n} < {n})", "p[{w} + {w}]", "max({n}, {n})", "int({n})",
    "({n} // 2.0)", "({n} % 1.0)", "({t} == {t})", "(9007199254740993 * {n})",
    "(10 ** 20 * {n})", "(HIGH * {n})", "with_default({n})", "endless({n})",
    "clipped({n}, high=1.0, low={n})", "(+{n})", "(1 if {t} else 2)", "(-(0 if {t} else 1))",
    "(1.0 if {t} else 0)", "sum((1.0, {n}))", "math.exp({n})", "({n} if {t} else {t})", "-{t}", "abs({t})",
    "math.sqrt({t})", "ordered({n}, {n})", "(1, {n})[{w}]", "(lambda y: y)({n})", "(y := {n})", "float({w})",
    "(2.0 ** 0.3 * {n})", "({w} / 0 * {n})", "power({n}, 2)", "(3 * 4503599627370496 * {n})", "(~{w} * {n})",
    "({w} & 3)", "({n} is {n})",
)  # fmt: skip
FOREIGN_STATEMENTS = (
    "for i in range(3):\n    {v} += {n}\nelse:\n    {v} = 0.0", "while {t}:\n    {v} = 0.0",
    "if {t}:\n    {v} = {n}", "m = 1\nm = {n}\n{v} = m",
    "m = 2\nfor i in range(70):\n    m = m * m\n{v} = m * 1.0", "range = 3", "select = {n}\n{v} = select",
    "for i in range(2):\n    {v} = p[i]", "for i in range(0):\n    {v} = {n}",
    "{v} = {n} if {t} else unknown", "for i in range(4):\n    break", "(a, b), c = {n}, {n}",
    "a, b, c = ordered({n}, {n})", "{v} = ordered", "{v} = p", "del {v}", "a = b = {t}\n{v} = a * 1.0",
    "a = 0\na += {n}\n{v} = a", "m = 0\nm = -m\nm = m * 1.5\n{v} = m", "for i in (1, 2.5):\n    {v} += i",
    "for i in range(int({n})):\n    {v} += 1.0", "assert {t}", "import os", "{v} *= {t}",
    "both = {t}\n{v} = 1.0 if both else 0.0", "for i in range(10 ** 9):\n    {v} += 1.0", "return {n}, {n}",
)  # fmt: skip


class Writer:
    """Writes the body of one function; ``numbers`` and ``truths`` are names that have values."""

    def __init__(self, chance: random.Random, numbers: list[str], slots: int) -> None:
        self.chance, self.numbers, self.truths, self.wholes = chance, list(numbers), ["ON"], []
        self.slots, self.count = slots, 0

    def number(self, depth: int) -> str:
        """An expression that is a number."""
        pick = self.chance.random()
        if depth <= 0 or pick < 0.15:
            return (
                self.chance.choice(LITERALS)
                if self.chance.random() < 0.25
                else self.chance.choice(self.numbers)
            )
        n = lambda: self.number(depth - 1)  # noqa: E731
        if pick < 0.5:
            sign = self.chance.choice(("+", "-", "*", "*", "+"))
            other = self.whole(1) if self.chance.random() < 0.2 else n()
            return f"({other} {sign} {n()})" if self.chance.random() < 0.5 else f"({n()} {sign} {other})"
        if pick < 0.58:
            return f"({n()} / ({n()}))" if self.chance.random() < 0.2 else f"({n()} / (abs({n()}) + 0.25))"
        if pick < 0.75:
            return f"({n()} if {self.truth(depth - 1)} else {n()})"
        if pick < 0.8:
            return f"-({n()})"
        if pick < 0.9:
            return self.chance.choice(
                (
                    f"abs({n()})",
                    f"math.sqrt(abs({n()}))",
                    f"abs({self.chance.choice(self.numbers)}) ** {self.chance.choice(EXPONENTS)}",
                    f"p[{self.chance.randrange(-self.slots, self.slots)}]",
                )
            )
        if self.chance.random() < 0.2:
            return f"limited({n()}, {n()})[1]"
        own = (
            f"clipped({n()}, {n()}, {n()})",
            f"ordered({n()}, {n()})[{self.chance.randrange(2)}]",
            f"summed({self.whole(1)}, {n()})",
        )
        theirs = (f"nearest({n()})", f"approach(abs({n()}))", f"turned({n()})[1]", f"power(abs({n()}), 1.5)")
        return self.chance.choice((*own, *own, *theirs))

    def truth(self, depth: int) -> str:
        """An expression that is a truth value."""
        pick = self.chance.random()
        if depth <= 0 or pick < 0.6:
            sign = self.chance.choice(("<", ">", "<=", ">=", "==", "!="))
            if self.chance.random() < 0.1:
                return f"({self.whole(1)} {sign} {self.whole(1)})"
            other = self.whole(0) if self.chance.random() < 0.2 else self.number(depth - 1)
            return f"({self.number(depth - 1)} {sign} {other})"
        t = lambda: self.truth(depth - 1)  # noqa: E731
        if pick < 0.85:
            return f"({t()} {self.chance.choice(('and', 'or'))} {t()})"
        if pick < 0.9:
            return f"({t()} if {t()} else {self.chance.choice((t(), 'True', 'False'))})"
        if pick < 0.93:
            return f"limited({self.number(1)}, {self.number(0)})[0]"
        return (
            self.chance.choice(self.truths)
            if pick < 0.96
            else f"inside({self.number(1)}, {self.number(0)}, {self.number(0)})"
        )

    def whole(self, depth: int) -> str:
        """An expression that is a whole number."""
        if depth <= 0 or self.chance.random() < 0.5:
            return self.chance.choice((*WHOLES, *self.wholes, *self.wholes))
        return f"({self.whole(depth - 1)} {self.chance.choice('+-*')} {self.whole(depth - 1)})"

    def fresh(self) -> str:
        """A name of its own."""
        self.count += 1
        return f"x{self.count}"

    def statement(self, loops: int = 0) -> list[str]:
        """A statement, a line or more."""
        pick = self.chance.random()
        if pick < 0.45 or loops > 1:
            expression, name = self.number(3), (self.chance.random() < 0.3 and self.local()) or self.fresh()
            self.numbers.append(name)
            return [
                f"{name}: float = {expression}" if self.chance.random() < 0.1 else f"{name} = {expression}"
            ]
        if pick < 0.55:
            expression, name = self.truth(2), f"t{self.count}"
            self.truths.append(name)
            self.count += 1
            return [f"{name} = {expression}"]
        if pick < 0.7:
            parts, (a, b) = [self.number(2) for _ in range(4)], (self.fresh(), self.fresh())
            test = self.truth(2)
            self.numbers += [a, b]
            return [f"{a}, {b} = ({parts[0]}, {parts[1]}) if {test} else ({parts[2]}, {parts[3]})"]
        name = self.local()
        if pick < 0.8 and name:
            return [f"{name} {self.chance.choice(('+=', '-=', '*='))} {self.number(2)}"]
        if not name:
            return ["pass"]
        counter = self.fresh()
        over = self.chance.choice(
            (f"range({self.chance.randrange(1, 4)})", "range(ROUNDS)", "range(4, 0, -2)", "p")
        )
        known = list(self.numbers), list(self.truths), list(self.wholes)
        (self.numbers if over == "p" else self.wholes).append(counter)
        body = [f"{name} = {self.number(2)}", *(line for _ in range(2) for line in self.statement(loops + 1))]
        self.numbers, self.truths, self.wholes = known
        return [f"for {counter} in {over}:", *(f"    {line}" for line in body)]

    def local(self) -> str:
        """A number that may be given another value, or nothing."""
        names = [name for name in self.numbers if name[0] == "x"]
        return self.chance.choice(names) if names else ""

    def foreign(self) -> list[str]:
        """A statement with something that is not in the language."""
        name = self.fresh()
        self.numbers.append(name)
        whole = self.chance.random() < 0.4
        text = self.chance.choice(FOREIGN_STATEMENTS) if whole else f"{{v}} = {self.chance.choice(FOREIGN)}"
        while "{n}" in text or "{t}" in text or "{w}" in text:
            text = (
                text.replace("{n}", self.safe(name), 1)
                .replace("{t}", f"({self.safe(name)} > 0.5)", 1)
                .replace("{w}", "1", 1)
            )
        return [f"{name} = 0.5", *text.replace("{v}", name).splitlines()]

    def safe(self, name: str) -> str:
        """A number whose name is there already."""
        return self.chance.choice([one for one in self.numbers if one != name])


def law_text(number: int, chance: random.Random, foreign: bool) -> str:
    """A class with one law."""
    slots, contact, memories = chance.randrange(1, 5), chance.random() < 0.6, chance.randrange(4)
    names = ["penetration", "slowness"] if contact else ["normal_force", "free_velocity", "mobility", "dt"]
    head = ", ".join(names if contact else [*names[:3], "memory", "dt"])
    writer, lines = Writer(chance, names, slots), []
    if not contact and memories:
        rows = [f"m{k}" for k in range(memories)]
        lines.append(f"{', '.join(rows)} = memory")
        writer.numbers += rows
    for _ in range(chance.randrange(1, 5)):
        lines += writer.statement()
    if foreign:
        lines += writer.foreign()
    results = [writer.number(3) for _ in range(2 if contact else 1 + memories)]
    if foreign:  # what is foreign takes part in the answer
        results[0] = f"{results[0]} + x{writer.count}"
    rest = "memory" if not memories else results[1] if memories == 1 else f"({', '.join(results[1:])})"
    lines.append(f"return {results[0]}, {results[1] if contact else rest}")
    body = "\n".join(f"        {line}" for line in lines)
    memory = (
        ""
        if contact
        else f"\n    memory: ClassVar[tuple[str, ...]] = {tuple(f'm{k} (1)' for k in range(memories))!r}"
    )
    return f"""

class Law{number}({"ContactLaw" if contact else "FrictionLaw"}):
    slots: ClassVar[tuple[str, ...]] = {tuple(f"s{k}" for k in range(slots))!r}{memory}

    @staticmethod
    def force({head}, p):
{body}
"""


def laws(seed: int, count: int, foreign: float = 0.0) -> list[Any]:
    """So many laws; a share of them has something in it that is not in the language."""
    chance = random.Random(seed)
    texts = [law_text(k, chance, chance.random() < foreign) for k in range(count)]
    name = f"random_laws_{seed}_{count}_{foreign}".replace(".", "_")
    text = HEAD + "".join(texts)
    return list(classes(name, text).values())


def classes(name: str, text: str) -> dict[str, Any]:
    """The classes called Law... of a text, read as a file is."""
    module = types.ModuleType(name)
    module.__file__ = f"/{name}.py"
    linecache.cache[module.__file__] = (len(text), None, text.splitlines(keepends=True), module.__file__)
    sys.modules[name] = module
    exec(compile(text, module.__file__, "exec", dont_inherit=True), module.__dict__)
    return {key: value for key, value in vars(module).items() if key.startswith("Law")}


def source(law: Any) -> str:
    """The text of a law, to be shown."""
    lines = linecache.getlines(law.force.__code__.co_filename)
    first = law.force.__code__.co_firstlineno - 1
    end = next((k for k in range(first + 1, len(lines)) if lines[k].startswith("class ")), len(lines))
    return "".join(lines[first:end])
