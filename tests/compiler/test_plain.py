"""Plain functions compiled do what Python does with the same text, to the bit; what they cannot say is
refused in a sentence.
"""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from support import bits, often
from vfife.compiler.backends import plain
from vfife.compiler.runtime import native
from vfife.compiler.runtime.native import compiled, interpreted
from vfife.errors import SourceError

TEXTS = {
    "rounded down": (
        "out[0] = i // 3\n    out[1] = i % 3\n    out[2] = i // max(i, 1)\n    out[3] = i % max(4, i)"
    ),
    "a quotient of integers": "out[0] = i / 7",
    "the second is not looked at": "out[0] = 1 if i < 0 or i >= len(out) or out[i] > 1.0 else 2",
    "nor is it by and": "out[1] = 1.0 if 0 <= i < len(out) and out[i] < 5.0 else x",
    "nor the other arm": "out[0] = out[i] if 0 <= i < len(out) else -1.0",
    "arms of one kind": "out[0] = (1.0 if x > 0.0 else x) + 2",
    "tuples": (
        "a, b = x, 2 * x\n    a, b = b, a\n    c = (a, b, i)\n    out[0] = c[0] - c[1]\n    out[1] = c[2]"
    ),
    "arms that are tuples": "a, b = (1.0, x) if x > 0.0 else (x, 2.0)\n    out[0] = a\n    out[1] = b",
    "out of a loop": (
        "for k in range(10):\n        if k * x > 9.0 or k == 7:\n            break\n        out[0] += k\n    "
        "    out[1] = k"
    ),
    "on with a loop": (
        "for k in range(10):\n        if k == 2:\n            continue\n        out[0] += k * x"
    ),
    "a name behind a loop": "for k in range(4):\n        y = k * x\n    out[0] = y\n    out[1] = k",
    "backwards": "for k in range(3, -1, -1):\n        out[k] = k * x\n        k = 0",
    "over what was named": (
        "for k in (2, 0, 3):\n        out[k] += x\n    for y in (x, 1.5):\n        out[1] += y"
    ),
    "over an array": "for y in out:\n        out[0] += y",
    "while": "k = 0\n    while k < 4 and out[k] < 3.0:\n        out[k] -= x\n        k += 1",
    "least and most": (
        "out[0] = min(x, 1.0, 0.25)\n    out[1] = max(i, 3)\n    out[2] = max(float(i), x)\n    out[3] ="
        " abs(i) + abs(x) - -x"
    ),
    "truths": (
        "a = x > 0.5\n    b = not a\n    out[0] = float(a)\n    out[1] = int(a) + int(i != 0)\n"
        "    out[2] = 1.0 if a == b else 2.0\n    out[3] = 1.0 if i else 0.0"
    ),
    "cut to an integer": "out[int(abs(x)) % 4] = float(i) * math.sqrt(abs(x))",
    "a value on each way": (
        "if x > 0.5:\n        y = x\n    elif i > 0:\n        y = 2.0\n    else:\n        return\n   "
        " out[0] = y"
    ),
    "others, of one text for each kind": (
        "out[0] = half(x)\n    out[1] = half(i)\n    put(out, 2, half(3))\n    a, out[3] = two(x, i > 0)"
    ),
    "two dimensions": (
        "for m in range(table.shape[0]):\n        for k in range(table.shape[1]):\n            out[k] +="
        " table[m, k] * x"
    ),
    "unsigned integers": "out[0] = where[1] - where[0] - 5\n    out[where[0]] = x",
    "integers and numbers compare exactly": (
        "for k in (9007199254740992, 9007199254740993, -9007199254740993, i):\n        for y in"
        " (9007199254740992.0, -9007199254740992.0, x, x / 0.0 if x == 0.0 and i > 9 else 2.0):\n           "
        " out[0] = 2.0 * out[0] + (1.0 if k < y else 0.0) + (4.0 if y <= k else 0.0) + (8.0 if k != y else"
        " 0.0)\n            out[1] = 3.0 * out[1] + (1.0 if k >= y else 0.0) + (2.0 if y > k else 0.0) + (4.0"
        " if y == k else 0.0)"
    ),
    "from the end of a tuple": "a = (x, 2.0)\n    out[0] = a[-2]",
    "long integers": "long[0] = i\n    long[1] += 3 * i\n    out[0] = long[1]",
}
OTHERS = """
def half(x):
    if x > 1000000:
        return 0.0
    return x / 2

def put(out, k, x):
    if k < 0:
        return
    out[k] = x

def two(x, early):
    y = 1.0
    if early:
        return x, y
    y = 2.5 * x
    return y, y
"""
HEAD = "def ask(out, i, x, table, where, long):\n    "
KINDS = "f1 i d f2 u1 l1"
TABLE, WHERE = np.arange(12.0).reshape(3, 4) / 7.0, np.array([2, 1], dtype=np.uint32)


@pytest.fixture(autouse=True)
def kept_elsewhere(tmp_path, monkeypatch):
    monkeypatch.setenv("VFIFE_CACHE", str(tmp_path))


@pytest.mark.parametrize("body", TEXTS.values(), ids=list(TEXTS))
def test_what_python_does(body):
    text = f"{OTHERS}\n{HEAD}{body}\n"
    ask, asked = compiled(text, "ask", KINDS), interpreted(text, "ask")
    for i in (-7, -1, 0, 1, 2, 9):
        for x in (-3.7, -0.0, 0.3, 5.0, 1e7):
            ours, theirs = np.array([0.5, -1.0, 4.0, 2.0]), np.array([0.5, -1.0, 4.0, 2.0])
            mine, other = np.array([5, -2]), np.array([5, -2])
            ask(ours, i, x, TABLE, WHERE, mine)
            asked(theirs, i, x, TABLE, WHERE.astype(int), other)
            assert (mine == other).all()
            assert np.array_equal(bits(ours), bits(theirs)), (i, x, ours, theirs)


EXPRESSIONS = st.recursive(
    st.sampled_from(["x", "y", "z", "2.0", "-0.5"]),
    lambda part: st.one_of(
        st.tuples(part, st.sampled_from("+-*/"), part).map(lambda p: f"({p[0]} {p[1]} {p[2]})"),
        st.tuples(part, st.sampled_from(["<", ">=", "==", "!="]), part, part, part).map(
            lambda p: f"({p[3]} if {p[0]} {p[1]} {p[2]} else {p[4]})"
        ),
        part.map(lambda p: f"math.sqrt(abs({p}))"),
        part.map(lambda p: f"(-{p})"),
    ),
    max_leaves=12,
)


@pytest.mark.system("compiles hundreds of expressions")
@settings(max_examples=often(100))
@given(st.lists(EXPRESSIONS, min_size=8, max_size=8))
def test_expressions_to_the_bit(expressions):
    """Neither reordered nor fused, whatever LLVM makes of them; numbers that are none compare
    as in IEEE 754.
    """
    lines = "".join(f"    out[{k}] = {one}\n" for k, one in enumerate(expressions))
    text = f"def ask(out, x, y, z):\n{lines}"
    ours, theirs, given = np.zeros(8), np.zeros(8), [np.float64(value) for value in (0.1, -7.3, 1e-3)]
    compiled(text, "ask", "f1 d d d")(ours, *given)
    with np.errstate(all="ignore"):
        try:
            interpreted(text, "ask")(theirs, *given)
        except ZeroDivisionError:  # of numbers that are written there
            return
    numbers = ~np.isnan(theirs)
    assert np.array_equal(numbers, ~np.isnan(ours))
    assert np.array_equal(bits(ours)[numbers], bits(theirs)[numbers])


REFUSED = {
    "out[0] = [x][0]": "no part of the language",
    "out[0] = x ** 2": "no part of the language",
    "with x:\n        pass": "no part of the language",
    "out[0] = x if x in (1.0, 2.0) else 0.0": "no part of the language",
    "import math": "no part of the language",
    "out[0] = sum(out)": "no such function",
    "out[0] = nobody(x)": "no such function",
    "out[0] = abs(x, x)": "not with so many arguments",
    "out[0] = min(x)": "not with so many arguments",
    "out[0] = half(x=x)": "by their place",
    "x": "has no effect",
    # A name, the arms of a condition, the returns of a function: of one kind each.
    "y = 0\n    for k in range(3):\n        y = y + x": "one is an integer, the other a number",
    "out[0] = 1 if x > 0.0 else x": "one is an integer, the other a number",
    "out[0] = max(i, x)": "one is an integer, the other a number",
    "out[0] = mixed(x)": "elsewhere the function returns an integer",
    "out[0] = ending(x)": "ends without the value that it returns elsewhere",
    "a = (x, x)\n    a = (x, x, x)": "one is (a number, a number), the other (a number, a number, a number)",
    "a, b = (x, x, x)": "2 names are given",
    "out = where": "out stands for two arrays",
    "x = out": "x stands for two arrays",
    # A truth is no number, and a number no truth.
    "out[0] = x if x and i else 1.0": "take truths, and x is a number",
    "out[0] = 1.0 if x else 2.0": "a number is no condition",
    "out[0] = 1.0 + (x > 0.5)": "this is a truth, and a number is needed",
    "out[0] = x > 0.5": "this is a truth, and a number is needed",
    "out[0] = -(x > 0.5)": "no sign of a truth",
    "out[0] = 1.0 if (x > 0.5) < (i > 0) else 0.0": "neither is the larger",
    # Integers: an index counts from 0, a divisor is above zero, 64 bits.
    "out[x] = 1.0": "an integer is needed",
    "out[-1] = x": "-1 is not the last item",
    "a = (x, 2.0)\n    out[0] = a[2]": "by a number that is written there",
    "a = (x, 2.0)\n    out[0] = a[i]": "by a number that is written there",
    "out[0] = i // 0": "above zero",
    "out[0] = i // -4": "above zero",
    "out[0] = 7 % i": "above zero",
    "out[0] = x // 2": "// and % are of integers",
    "i //= i": "above zero",
    "out[0] = 9223372036854775808": "an integer has 64 bits",
    "for k in range(0, 4, i):\n        out[k] = x": "not 0",
    "for k in range(0, 4, 0):\n        out[k] = x": "not 0",
    # A chain of which the end might not be computed in Python.
    "out[0] = 1.0 if 0 <= i < out[i] else 0.0": "the last part of a chain",
    # What may have no value, where Python would tell so at that place.
    "out[0] = w": "w may be used before it has a value",
    "if x > 0.0:\n        w = x\n    out[0] = w": "w may be used before it has a value",
    "for k in range(i):\n        w = x\n    out[0] = w": "w may be used before it has a value",
    "for k in range(3):\n        if k == i:\n            break\n        w = x\n    out[0] = w": (
        "w may be used before it has a value"
    ),
    "while x < 0.0:\n        w = x\n    out[0] = w": "w may be used before it has a value",
    "for k in range(3):\n        x += 1.0\n    else:\n        x = 0.0": "no else",
    # Functions that lead back to themselves, by themselves or another, with other kinds each time; other
    # numbers of arguments.
    "ask(out, i, x, table, where, long)": "ask calls itself",
    "out[0] = around(x)": "around calls itself",
    "out[0] = deeper((x, x))": "deeper calls itself",
    "out[0] = put(out, 1, x)": "returns nothing",
    "out[0] = half(x, x)": "half takes 1 arguments and was given 2",
    "out[0] = usual(x)": "without defaults",
    # Arrays: those that are handed in, by all their indices; no two that are the same where the code relies
    # on it.
    "where[0] = x": "a number is put into an array of unsigned integers",
    "where[0] += 1": "an integer is put into an array of unsigned integers",
    "long[0] = x": "a number is put into an array of integers",
    "out[0] = table[0]": "this array has 2 dimensions",
    "out[0] = x[0]": "by a number that is written there",
    "newton(out, out)": "the same array is given twice",
    "for y in table:\n        out[0] = y": "nothing to go through",
}
MORE = """
def mixed(x):
    if x > 0.0:
        return 0
    return x

def ending(x):
    if x > 0.0:
        return x

def around(x):
    return about(x)

def about(x):
    return around(x)

def deeper(x):
    return deeper((x, x))

def usual(x, y=1.0):
    return x

def newton(a, b):
    a[0] = b[0]
"""


@pytest.mark.parametrize("body", REFUSED)
def test_what_is_refused(body):
    with pytest.raises(SourceError) as told:
        compiled(f"{OTHERS}\n{MORE}\n{HEAD}{body}\n", "ask", KINDS)
    assert REFUSED[body] in str(told.value)


def test_a_refusal_names_function_line_and_reason():
    with pytest.raises(SourceError) as told:
        compiled(f"{OTHERS}\n{HEAD}y = x\n    if x > 0.5:\n        y = i // i\n", "ask", KINDS)
    assert str(told.value).startswith("ask, line 4: 'i // i': // and % are of integers")


def test_a_second_time_nothing_is_written(monkeypatch):
    text, out = "def ask(out, x):\n    out[0] = 2.0 * x\n", np.zeros(1)
    compiled(text, "ask", "f1 d")
    monkeypatch.setattr(plain, "library_text", None)
    compiled(text, "ask", "f1 d")(out, math.pi)
    assert out[0] == 2.0 * math.pi
    monkeypatch.setattr(
        native, "processor", lambda: ("another", "")
    )  # the name that it is kept under tells processors apart
    with pytest.raises(TypeError):
        compiled(text.replace("2.0", "3.0"), "ask", "f1 d")


def test_an_array_of_another_kind_is_refused():
    ask = compiled("def ask(out):\n    out[0] = 1.0\n", "ask", "f1")
    for wrong in (np.zeros(2, dtype=np.float32), np.zeros((2, 2)), np.zeros(4)[::2]):
        with pytest.raises(TypeError, match="an array of float"):
            ask(wrong)
