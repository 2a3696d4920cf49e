"""Plain functions as JavaScript do what Python does; what would be another thing there is refused with its
line.
"""

import json
import shutil
import subprocess

import pytest

from vfife.compiler.backends.javascript import script
from vfife.compiler.runtime.native import interpreted
from vfife.errors import SourceError

TEXTS = {
    "a range counts on its own": "for k in range(3):\n        a[k] += k\n        k = 0\n    a[3] = k",
    "its end is computed once": "n = 2\n    for k in range(n):\n        n += 1\n    a[0] = n",
    "backwards, and out of it": (
        "for k in range(3, -1, -1):\n        if k == 1:\n            break\n        a[k] = 7.0"
    ),
    "while": (
        "k = 0\n    while k < 4 and a[k] < 3.0:\n        k += 1\n"
        "        if k == 2:\n            continue\n        a[k - 1] *= -2.0\n    a[0] = k"
    ),
    "rounded down": "a[0] = i // 3\n    a[1] = (i + 1) // 2 - i",
    "least and most": (
        "a[0] = min(a[1], 0.25)\n    a[1] = max(i, 3)\n    a[2] = abs(i) + math.sqrt(abs(x)) - -x"
    ),
    "the first of two that are equal": "a[0] = 1.0 / min(0.0, -0.0)\n    a[1] = max(x, x - x + 1.0)",
    "choices": "a[0] = 1.0 if x > 0.5 or not i < 2 else x / 3\n    a[1] = float(i) if i != 2 else int(x)",
    "several values": (
        "a[0], a[1] = two(x, i)\n    b, c = a[1], a[0]\n    a[2] = b - c\n    a[3] = two(x, 2)[0] + len(a)"
    ),
}
OTHERS = "def two(x, i):\n    if i == 2:\n        return x, 0.0\n    return 2.0 * x, x\n"
CASES = [(-7, -3.7), (0, 0.3), (2, 5.25), (9, -0.0)]


@pytest.mark.skipif(shutil.which("node") is None, reason="needs node, which runs JavaScript")
def test_what_python_does():
    texts = {name: f"{OTHERS}\ndef ask(a, i, x):\n    {body}\n" for name, body in TEXTS.items()}
    run = (
        f"return {json.dumps(CASES)}.map(([i, x]) => {{ const a = [0.5, -1, 4, 2]; ask(a, i, x); return"
        " a.map(String); });"
    )
    calls = [f"(() => {{ {script(text)} {run} }})()" for text in texts.values()]
    done = subprocess.run(
        ["node", "-e", f"console.log(JSON.stringify([{', '.join(calls)}]))"],
        capture_output=True,
        text=True,
        check=True,
    )
    for (name, text), found in zip(texts.items(), json.loads(done.stdout), strict=True):
        for (i, x), theirs in zip(CASES, found, strict=True):
            try:
                interpreted(text, "ask")(ours := [0.5, -1.0, 4.0, 2.0], i, x)
            except ZeroDivisionError:
                assert "Infinity" in theirs[0]
                continue
            assert [float(one) for one in theirs] == ours, name


REFUSED = (
    "a[0] = i % 2", "a[0] = x ** 2", "a[0] = i // j", "i //= 2", "a[0] = 1.0 if 0 < i < 3 else 0.0",
    "a[0] = 1.0 if x else 0.0 if x + 1 else 2.0", "if x + 1.0:\n        a[0] = 1.0",
    "while 1:\n        a[0] = 1.0", "a[0] = min(two(x, i)[0], 1.0)", "a[0] = nobody(x)", "a[0] = two(x, i=2)",
    "a[0] = [x][0]", "a[-1] = x", "a[0:1] = a", "a[0] = 9007199254740993", "a[0] = 1e999", "a[0] = 'x'",
    "for y in a:\n        a[0] = y", "for k in range(0, 4, i):\n        a[k] = x",
    "for k in range(3):\n        a[k] = x\n    else:\n        a[0] = 1.0", "with x:\n        pass",
    "a[0] = x if x in (1.0, 2.0) else 0.0", "a[0] = b = x", "x", "a[0] = math.sin(x)", "a[0] = lambda: x",
)  # fmt: skip


@pytest.mark.parametrize("body", REFUSED)
def test_what_is_refused(body):
    with pytest.raises(SourceError, match=r"^ask, line \d: .* is not translated to JavaScript$"):
        script(f"{OTHERS}\ndef ask(a, i, x):\n    {body}\n")
