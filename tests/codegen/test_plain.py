"""Plain functions compiled do what Python does with the same text, to the bit; what they cannot say is refused in a sentence."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from support import bits, often
from vfife.codegen import native, plain
from vfife.codegen.compile import compiled, interpreted
from vfife.errors import SourceError

TEXTS = {
    "an integer becomes a number later": "y = 0\n    for k in range(3):\n        y = y + x * k\n    out[0] = y",
    "and in a loop before it": "y, z = 0, 0\n    for k in range(4):\n        z = z + y\n        y = y + x\n    out[0] = z",
    "rounded down": "out[0] = i // 3\n    out[1] = i % 3\n    out[2] = i // -4\n    out[3] = i % -4",
    "a quotient of integers": "out[0] = i / 7",
    "the second is not looked at": "out[0] = 1 if i < 0 or i >= len(out) or out[i] > 1.0 else 2",
    "nor is it by and": "out[1] = 1.0 if 0 <= i < len(out) and out[i] < 5.0 else x",
    "nor the other arm": "out[0] = out[i] if 0 <= i < len(out) else -1.0",
    "arms of two kinds": "out[0] = (1 if x > 0.0 else x) + 2",
    "tuples": "a, b = x, 2 * x\n    a, b = b, a\n    c = (a, b, i)\n    out[0] = c[0] - c[1]\n    out[1] = c[2]",
    "arms that are tuples": "a, b = (1, x) if x > 0.0 else (x, 2.0)\n    out[0] = a\n    out[1] = b",
    "out of a loop": "for k in range(10):\n        if k * x > 9.0 or k == 7:\n            break\n        out[0] += k\n    out[1] = k",
    "on with a loop": "for k in range(10):\n        if k == 2:\n            continue\n        out[0] += k * x",
    "backwards": "for k in range(3, -1, -1):\n        out[k] = k * x\n        k = 0",
    "over what was named": "for k in (2, 0, 3):\n        out[k] += x\n    for y in (x, 1.5):\n        out[1] += y",
    "over an array": "for y in out:\n        out[0] += y",
    "while": "k = 0\n    while k < 4 and out[k] < 3.0:\n        out[k] -= x\n        k += 1",
    "least and most": "out[0] = min(x, 1.0, 0.25)\n    out[1] = max(i, 3)\n    out[2] = max(i, x)\n    out[3] = abs(i) + abs(x) - -x",
    "truths": "a = x > 0.5\n    b = not a\n    out[0] = a\n    out[1] = a + b + (i != 0)\n    out[2] = a == b\n    out[3] = 1.0 if i else 0.0",
    "cut to an integer": "out[int(abs(x)) % 4] = float(i) * math.sqrt(abs(x))",
    "others, of one text for each kind": "out[0] = half(x)\n    out[1] = half(i)\n    put(out, 2, half(3))\n    a, out[3] = two(x, i > 0)",
    "two dimensions": "for m in range(table.shape[0]):\n        for k in range(table.shape[1]):\n            out[k] += table[m, k] * x",
    "unsigned integers": "out[0] = where[1] - where[0] - 5\n    out[where[0]] = x",
}
OTHERS = """
@jit
def half(x):
    if x > 1e6:
        return 0
    return x / 2

@jit
def put(out, k, x):
    if k < 0:
        return
    out[k] = x

@jit
def two(x, early):
    y = 1
    if early:
        return x, y
    y = 2.5 * x
    return y, y
"""
HEAD = "@jit\ndef ask(out, i, x, table, where):\n    "
KINDS = "f1 i d f2 u1"
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
            ask(ours, i, x, TABLE, WHERE)
            asked(theirs, i, x, TABLE, WHERE.astype(int))
            assert np.array_equal(bits(ours), bits(theirs)), (i, x, ours, theirs)


EXPRESSIONS = st.recursive(
    st.sampled_from(["x", "y", "z", "2.0", "-0.5", "3"]),
    lambda part: st.one_of(
        st.tuples(part, st.sampled_from("+-*/"), part).map(lambda p: f"({p[0]} {p[1]} {p[2]})"),
        st.tuples(part, st.sampled_from(["<", ">=", "==", "!="]), part, part, part).map(lambda p: f"({p[3]} if {p[0]} {p[1]} {p[2]} else {p[4]})"),
        part.map(lambda p: f"math.sqrt(abs({p}))"),
        part.map(lambda p: f"(-{p})"),
    ),
    max_leaves=12,
)


@settings(max_examples=often(100))
@given(st.lists(EXPRESSIONS, min_size=8, max_size=8))
def test_expressions_to_the_bit(expressions):
    """Neither reordered nor fused, whatever LLVM makes of them; numbers that are none compare as in IEEE 754."""
    lines = "".join(f"    out[{k}] = {one}\n" for k, one in enumerate(expressions))
    text = f"@jit\ndef ask(out, x, y, z):\n{lines}"
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
    "out[0] = [x][0]": "'[x]' is more than a plain function of numbers may say",
    "out[0] = x ** 2": "'x ** 2' is more",
    "out[0] = x if x and i else 1.0": "'x and i' is more",
    "out[0] = sum(out)": "'sum(out)' is more",
    "out[0] = nobody(x)": "'nobody(x)' is more",
    "out[0] = w": "ask: w is used before it has a value",
    "out[x] = 1.0": "a value of kind d is used as one of kind i",
    "out[0] = put(out, 1, x)": "put returns nothing",
    "out[0] = half(x, x)": "half takes 1 arguments and was given 2",
    "ask(out, i, x, table, where)": "ask calls itself",
    "a = (x, x)\n    a = (x, x, x)": "one name stands for values of two kinds",
    "out[-1] = x": "'out[-1]' is more",
    "for k in range(3):\n        x += 1.0\n    else:\n        x = 0.0": "is more",
    "out = where": "out stands for two arrays",
    "where[0] = x": "'where[0]' is more",
    "out[0] = table[0]": "'table[0]' is more",
    "out[0] = half(x=x)": "'half(x=x)' is more",
    "with x:\n        pass": "is more",
}


@pytest.mark.parametrize("body", REFUSED)
def test_what_is_refused(body):
    with pytest.raises(SourceError) as told:
        compiled(f"{OTHERS}\n{HEAD}{body}\n", "ask", KINDS)
    assert REFUSED[body] in str(told.value)


def test_a_second_time_nothing_is_written(monkeypatch):
    text, out = "@jit\ndef ask(out, x):\n    out[0] = 2.0 * x\n", np.zeros(1)
    compiled(text, "ask", "f1 d")
    monkeypatch.setattr(plain, "library_text", None)
    compiled(text, "ask", "f1 d")(out, math.pi)
    assert out[0] == 2.0 * math.pi
    monkeypatch.setattr(native, "processor", lambda: ("another", ""))  # the name that it is kept under tells processors apart
    with pytest.raises(TypeError):
        compiled(text.replace("2.0", "3.0"), "ask", "f1 d")


def test_an_array_of_another_kind_is_refused():
    ask = compiled("@jit\ndef ask(out):\n    out[0] = 1.0\n", "ask", "f1")
    for wrong in (np.zeros(2, dtype=np.float32), np.zeros((2, 2)), np.zeros(4)[::2]):
        with pytest.raises(TypeError, match="an array of float"):
            ask(wrong)
