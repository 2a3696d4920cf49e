"""Parser of expressions of one variable: numbers, + - * / ^, parentheses and some functions. A text is
parsed, never executed.

    sum      = product {("+" | "-") product}
    product  = signed {("*" | "/") signed}
    signed   = ["-" | "+"] signed | power
    power    = value ["^" signed]
    value    = number ["[" unit "]"] | "pi" | variable | function "(" sum {"," sum} ")" | "(" sum ")"

A bare number is in SI units; ``2.5[kN]`` has its own. ``-2^2`` is -4, and ``2^3^2`` is 2^9.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterator
from dataclasses import dataclass
from functools import lru_cache
from typing import NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from ...errors import Fault, suggestion
from ...numerics import elementwise
from ...units import quantity_in_si

Array: TypeAlias = NDArray[np.float64]

LONGEST, DEEPEST = 1000, 40  # characters; parentheses and powers within each other
VARIABLES = {"t": "times", "angle": "angles", "x": "travels", "v": "speeds"}
# Functions by name, with the number of their arguments.
FUNCTIONS = {
    "sin": 1,
    "cos": 1,
    "tan": 1,
    "exp": 1,
    "log": 1,
    "sqrt": 1,
    "abs": 1,
    "step": 1,
    "min": 2,
    "max": 2,
}
NUMPY_NAMES = {
    "+": "add",
    "-": "subtract",
    "*": "multiply",
    "/": "divide",
    "min": "minimum",
    "max": "maximum",
}
# Functions of numerics.elementwise, which have the same bits on every machine; numpy computes the others.
TRANSLATED = {"sin": "sin", "cos": "cos", "tan": "tan", "exp": "exp", "log": "log", "^": "power"}
TOKEN = re.compile(
    r"(?P<number>(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]{1,3})?)|(?P<name>[A-Za-z_]+)|(?P<mark>[-+*/^(),\[])|(?P<other>\S)"
)
UNIT = re.compile(r"[^\[\]]{1,40}\]")


class Token(NamedTuple):
    """A token of the text: its kind ("number", "name", "mark", "end"), text and column."""

    kind: str
    text: str
    column: int

    def fault(self, problem: str, remedy: str) -> Fault:
        """Return a fault at this token."""
        return Fault(f"column {self.column}", problem, remedy=remedy)


@dataclass(frozen=True)
class Node:
    """A node of the syntax tree: a number, the variable, or an operator or function with its operands."""

    word: str  # "number", "variable", an operator or a function
    value: float = 0.0
    parts: tuple[Node, ...] = ()

    def at(self, x: Array) -> Array:
        """Return the values at many arguments, shape (n,)."""
        if self.word in ("number", "variable"):
            return x if self.word == "variable" else np.full_like(x, self.value)
        parts = [part.at(x) for part in self.parts]
        if self.word == "step":
            return np.where(parts[0] < 0.0, 0.0, 1.0)
        if self.word in TRANSLATED:
            return np.asarray(getattr(elementwise, TRANSLATED[self.word])(*parts))
        values: Array = getattr(np, NUMPY_NAMES.get(self.word, self.word))(*parts)
        return values

    def switches(self) -> Iterator[Node]:
        """Yield the nodes whose zeros are kinks or jumps: arguments of abs and step, differences of the
        arguments of min and max, denominators.
        """
        if self.word in ("abs", "step"):
            yield self.parts[0]
        elif self.word in ("min", "max"):
            yield Node("-", parts=self.parts)
        elif self.word == "/":
            yield self.parts[1]
        for part in self.parts:
            yield from part.switches()


@dataclass(frozen=True)
class Expression:
    """A parsed text: its tree, and its variable ("" for a constant)."""

    text: str
    tree: Node
    variable: str

    @property
    def constant(self) -> float:
        """Value of an expression without variable."""
        return float(self(np.zeros(1))[0])

    def __call__(self, x: Array) -> Array:
        """Return the values at many arguments, shape (n,); not finite where undefined."""
        with np.errstate(all="ignore"):
            return self.tree.at(np.asarray(x, dtype=float))


@lru_cache(maxsize=64)
def parse(text: str) -> Expression:
    """Return the expression of a text. Raises Fault, with the column, for an invalid one."""
    if len(text) > LONGEST:
        raise Fault(
            f"column {LONGEST}",
            f"an expression of {len(text)} characters",
            remedy=f"write at most {LONGEST}, or give a table",
        )
    parser = _Parser(text)
    tree = parser.sum(0)
    if parser.here.kind != "end":
        parser.refuse("an operator", "write * between factors, and close what was opened")
    return Expression(text, tree, parser.variable)


class _Parser:
    """Recursive-descent parser with one token of lookahead."""

    def __init__(self, text: str) -> None:
        self.text, self.at, self.variable = text, 0, ""
        self.here = self.next()

    def next(self) -> Token:
        """Return the next token of the text."""
        while self.at < len(self.text) and self.text[self.at].isspace():
            self.at += 1
        match = TOKEN.match(self.text, self.at)
        if match is None:
            return Token("end", "", len(self.text) + 1)
        self.at = match.end()
        return Token(str(match.lastgroup), match[0], match.start() + 1)

    def take(self) -> Token:
        """Return the current token and advance."""
        token, self.here = self.here, self.next()
        return token

    def refuse(self, expected: str, remedy: str) -> None:
        """Raise Fault: something other than ``expected`` is at the current token."""
        problem = (
            f"{expected} is missing at the end"
            if self.here.kind == "end"
            else f'"{self.here.text}" stands where {expected} should'
        )
        raise self.here.fault(problem, remedy)

    def shallow(self, depth: int) -> None:
        """Raise Fault if the nesting is too deep."""
        if depth > DEEPEST:
            problem = f"more than {DEEPEST} parentheses, signs or powers within each other"
            raise self.here.fault(problem, "write it shorter, or give a table")

    def sum(self, depth: int) -> Node:
        """Parse a sum."""
        self.shallow(depth)
        tree = self.product(depth)
        while self.here.text in ("+", "-") and self.here.kind == "mark":
            tree = Node(self.take().text, parts=(tree, self.product(depth)))
        return tree

    def product(self, depth: int) -> Node:
        """Parse a product."""
        tree = self.signed(depth)
        while self.here.text in ("*", "/") and self.here.kind == "mark":
            tree = Node(self.take().text, parts=(tree, self.signed(depth)))
        return tree

    def signed(self, depth: int) -> Node:
        """Parse a power with its sign."""
        if self.here.text in ("+", "-"):
            self.shallow(depth)
            sign = self.take().text
            tree = self.signed(depth + 1)
            return tree if sign == "+" else Node("-", parts=(Node("number"), tree))
        return self.power(depth)

    def power(self, depth: int) -> Node:
        """Parse a value with an optional exponent."""
        self.shallow(depth)
        tree = self.value(depth)
        if self.here.text == "^":
            self.take()
            return Node("^", parts=(tree, self.signed(depth + 1)))
        return tree

    def value(self, depth: int) -> Node:
        """Parse a number, the variable, a function or a parenthesis."""
        token = self.here
        if token.kind == "number":
            return self.number()
        if token.text == "(":
            self.take()
            tree = self.sum(depth + 1)
            self.close()
            return tree
        if token.kind != "name":
            doubled = self.here.text == "*"
            self.refuse(
                "a number, a variable or a function",
                "write ^ for a power, as in x^2" if doubled else "complete the expression",
            )
        self.take()
        if token.text == "pi":
            return Node("number", math.pi)
        if token.text in FUNCTIONS:
            return self.function(token, depth)
        if token.text not in VARIABLES:
            names = (*FUNCTIONS, *VARIABLES, "pi")
            hint = suggestion(token.text, names, "")
            remedy = (
                hint
                if hint.startswith("did you mean")
                else f"there are {', '.join(names)}; a unit goes in brackets"
            )
            raise token.fault(f'there is no "{token.text}"', remedy)
        if self.variable not in ("", token.text):
            problem = f"{token.text} and {self.variable} in one expression"
            raise token.fault(problem, "a load depends on one of t, angle, x and v; make two loads of it")
        self.variable = token.text
        return Node("variable")

    def number(self) -> Node:
        """Parse a number with an optional unit."""
        token, begin = self.here, self.at
        if self.text[self.at :].lstrip().startswith("["):
            unit_match = UNIT.match(self.text, self.text.index("[", begin) + 1)
            if unit_match is None:
                raise token.fault("the unit's bracket is not closed", "write it as in 2.5[kN]")
            self.at = unit_match.end()
            unit = unit_match[0][:-1].strip()
            self.here = self.next()
            try:
                return Node("number", quantity_in_si(token.text, unit))
            except ValueError as error:
                raise token.fault(str(error), "write units as in 2.5[kN] or 30[deg]") from None
        self.take()
        return Node("number", float(token.text))

    def function(self, token: Token, depth: int) -> Node:
        """Parse the arguments of a function."""
        if self.here.text != "(":
            raise token.fault(f"{token.text} has no argument", f"write {token.text}(...)")
        self.take()
        parts = [self.sum(depth + 1)]
        while self.here.text == ",":
            self.take()
            parts.append(self.sum(depth + 1))
        self.close()
        arity = FUNCTIONS[token.text]
        if len(parts) != arity:
            problem = f"{token.text} has {len(parts)} argument{'s' * (len(parts) > 1)}"
            raise token.fault(problem, f"give it {arity}")
        return Node(token.text, parts=tuple(parts))

    def close(self) -> None:
        """Parse a closing parenthesis."""
        if self.here.text != ")":
            self.refuse('")"', "close what was opened, and write * between factors")
        self.take()
