"""What the function of a law may say: each thing that some loop once computed otherwise than Python is
refused, with line and replacement, or computed as Python computes it.
"""

import itertools
import re
import shutil
import threading

import pytest

from choice import default_cases
from laws.random_laws import HEAD, classes
from support import bits, four_bar, lanes
from vfife.assembly.assemble import assemble
from vfife.compiler.runtime.lawloops import Loops, Single
from vfife.errors import LawError
from vfife.laws import ContactLaw, FrictionLaw, Pair, agreement, check, user
from vfife.laws.agreement import agreement_of, compared
from vfife.laws.check import faults, faults_of_functions, faults_of_loops, try_out
from vfife.laws.contact.hertz import Hertz
from vfife.laws.language import codes
from vfife.laws.law import law_kind

PAIR = Pair(0.01, 2e-4, 0.02)
COUNT = itertools.count()
FORCE = """
class Law0(ContactLaw):
    name: ClassVar[str] = "{name}"
    slots: ClassVar[tuple[str, ...]] = ("stiffness", "share")

    def parameters(self, pair):
        return 1e9, 0.0

    @staticmethod
    def force(penetration, slowness, p):
        stiffness, share = p
        elastic = stiffness * penetration
{body}
"""
pytestmark = pytest.mark.usefixtures("only_built_in_laws")


def law_of(body: str, more: str = ""):
    """A contact law with lines in its function, and more in its file."""
    lines = "\n".join(f"        {line}" for line in body.splitlines())
    number = next(COUNT)
    return classes(f"language_{number}", HEAD + more + FORCE.format(name=f"law-{number}", body=lines))["Law0"]


# Of what is refused: the lines, what is told, and what to write instead; the first of the lines is line 0.
REFUSED = {
    "a number for a condition, or": (
        "return elastic, elastic * slowness * (share or 0.5)",
        r"`share or 0.5`: `or` joins conditions",
        r"write `share if share != 0.0 else 0.5`",
    ),
    "a number for a condition, and": (
        "return elastic, elastic * slowness * (share and 2.0)",
        r"`and` joins conditions",
        r"write `2.0 if share != 0.0 else share`",
    ),
    "a truth value and a number": (
        "return elastic, elastic * (penetration > 0.0 and 2.0)",
        r"`2.0` is a number",
        r"write `2.0 if penetration > 0.0 else 0.0`",
    ),
    "a truth value in arithmetic": (
        "return elastic, elastic * (penetration > 0.0)",
        "is a truth value",
        r"write `1.0 if .* else 0.0`",
    ),
    "a number as a condition": (
        "return elastic, 0.0 if share else elastic",
        "is a number and no condition",
        r"write `share != 0.0`",
    ),
    "truth values compared": (
        "return elastic, 1.0 if (share > 0.0) == (share > 1.0) else 0.0",
        "compares truth values",
        "choose by",
    ),
    "a chain of comparisons": (
        "return elastic, 1.0 if 0.0 < share < 1.0 else 0.0",
        "compares twice",
        "`a < x and x < b`",
    ),
    "not": ("return elastic, 1.0 if not share > 0.0 else 0.0", "`not`", "reverse the comparison"),
    "a whole number beyond 2^53": (
        "return elastic, elastic * 9007199254740993",
        "beyond 2\\^53",
        "write it with a point",
    ),
    "a whole number beyond 2^63": ("return elastic, elastic * 10 ** 20", "beyond 2\\^53", "with a point"),
    "whole numbers that grow beyond it": (
        "big = 4503599627370496 * 3\nreturn elastic, elastic * big",
        "beyond 2\\^53",
        "with a point",
    ),
    "whole numbers that grow in a loop": (
        "m = 2\nfor _ in range(70):\n    m = m * m\nreturn elastic, m * 1.0",
        "changes from round to round",
        "with a point",
    ),
    "first a whole number, then a number": (
        "m = 1\nm = m * share\nreturn elastic, m",
        "a whole number before and a number here",
        "with a point",
    ),
    "a whole number or a number": (
        "return elastic, 0 if share > 0.0 else 1.0",
        "is a whole number",
        "with a point, as in 1.0",
    ),
    "a name for two kinds": (
        "m = share > 0.0\nm = share\nreturn elastic, m",
        "a truth value before and a number here",
        "two names",
    ),
    "for ... else": (
        "for _ in range(2):\n    elastic = elastic * share\nelse:\n    elastic = 0.0\nreturn elastic, share",
        "`for … else`",
        "after the loop",
    ),
    "break": ("for _ in range(2):\n    break\nreturn elastic, share", "`break`", "take all rounds"),
    "while": (
        "while elastic > 1.0:\n    elastic = 0.5 * elastic\nreturn elastic, share",
        "`while`",
        "fixed number of rounds",
    ),
    "p[k] in a loop": (
        "for k in range(2):\n    elastic += p[k]\nreturn elastic, share",
        "whose place is no literal",
        "for x in p",
    ),
    "p[k] beyond the end": ("return elastic, p[2]", "has 2 parts, the first at 0", "correct the number"),
    "a part of a number": (
        "return elastic, share[0]",
        "is a number and has no parts",
        "leave the brackets out",
    ),
    "a tuple in arithmetic": ("return elastic, elastic * (share, 2.0)", "is a tuple of 2", "take it apart"),
    "tuples within a tuple": (
        "a, (b, c) = (share, (1.0, 2.0)) if share > 0.0 else (share, (2.0, 1.0))\nreturn elastic, a + b + c",
        "tuples within a tuple",
        "choose each",
    ),
    "too few names": (
        "a, b, c = ordered(share, 1.0)\nreturn elastic, a + b + c",
        "takes 2 parts for 3 names",
        "write as many",
    ),
    "tuples without end": (
        "\n".join(
            [
                "a0 = (share, share)",
                *(f"a{k} = (a{k - 1}, a{k - 1})" for k in range(1, 40)),
                "return elastic, share",
            ]
        ),
        "a tuple may have 32",
        "names of their own",
    ),
    "a power": ("return elastic, share ** 2.25", r"whole or half numbers up to 8", r"power\(share, 2.25\)"),
    "a power with a name": ("return elastic, share ** slowness", "literal", r"power\(share, slowness\)"),
    "a power with a large exponent": ("return elastic, share ** 9", "up to 8", r"power\(share, 9\)"),
    "a power of nothing": ("return elastic, share ** 0", "always 1", "write 1.0"),
    "a power of e": ("return elastic, math.e ** share", "write", r"exp\(x\) of"),
    "powers of powers": (
        "return elastic, (((share ** 8) ** 8) ** 8) ** 8",
        "its base is long",
        "name in a line before",
    ),
    "a power without end": ("return elastic, 9 ** 999999999 * share", "beyond 2", "with a point"),
    "a shift": ("return elastic, (1 << 3) * share", "`<<`", r"8.0 \* x"),
    "a sign that does nothing": ("return elastic, +share", r"`\+` in front of", "leave it out"),
    "a default of an argument": (
        "return elastic, with_default(share)",
        "arguments with defaults",
        "hand all of them over",
    ),
    "an argument by name": (
        "return elastic, clipped(share, high=1.0, low=0.0)",
        "names or unpacks arguments",
        "in their order",
    ),
    "too few arguments": (
        "return elastic, clipped(share, 0.0)",
        "takes 3 arguments and is given 2",
        "correct the call",
    ),
    "a function that calls itself": (
        "return elastic, endless(share)",
        "leads back to itself",
        "fixed number of rounds",
    ),
    "IntEnum": ("return elastic, HIGH * share", r"HIGH \(Level\) is no plain number", "write HIGH = 2"),
    "a name before its value": (
        "return elastic, share * late",
        "the file does not define late",
        "define it, or correct the name",
    ),
    "a name from a loop without rounds": (
        "for k in range(0):\n    m = share\nreturn elastic, m",
        "has no rounds",
        "leave the loop out",
    ),
    "a local called range": (
        "range = share\nreturn elastic, range",
        "range is a name that the step itself uses",
        "my_range",
    ),
    "a name that Python changes": (
        "__m = share\nreturn elastic, __m",
        "Python gives such a name another one",
        "without `__`",
    ),
    "a division by zero": ("return elastic, share / 0", "divides by zero", "choose by"),
    "a root of a negative number": (
        "return elastic, share * math.sqrt(-4)",
        "root of a negative number",
        "choose by",
    ),
    "not a number": ("return elastic, share * math.nan", "is not a number", "choose by"),
    "a line behind return": (
        "return elastic, share\nelastic = 0.0",
        "a line behind `return`",
        "leave it out",
    ),
    "return in a loop": (
        "for _ in range(2):\n    return elastic, share\nreturn elastic, share",
        "`return` within a loop",
        "at the end",
    ),
    "no return": ("elastic = 0.0", "returns nothing", "end it with `return`"),
    "a truth value as answer": (
        "return elastic, share > 0.0",
        "returns a number and a truth value",
        "two numbers",
    ),
    "a whole number for an elementary function": (
        "return elastic, power(share, 2)",
        "hands over a whole number",
        "as in 2.0",
    ),
    "a lambda": (
        "return elastic, (lambda x: x)(share)",
        "cannot be compiled",
        "REMEDY|law's function may use",
    ),
    ":=": ("return elastic, (m := share)", "`:=`", "a line before"),
    "loops without end": (
        "for _ in range(10 ** 9):\n    elastic = 0.5 * elastic\nreturn elastic, share",
        "operations in every step",
        "fewer rounds",
    ),
    "loops in loops": (
        "\n".join(
            [
                *(f"{'    ' * k}for {name} in range(2):" for k, name in enumerate("abcde")),
                f"{'    ' * 5}elastic += share",
            ]
        )
        + "\nreturn elastic, share",
        "more than 4 loops",
        "write some of them out",
    ),
    "depth without end": (
        f"return elastic, {'(' * 90}share{' + 1.0)' * 90}",
        "stand in one another",
        "names of their own",
    ),
}


@pytest.mark.parametrize("case", REFUSED)
def test_what_is_refused_is_told_with_line_and_replacement(case):
    body, told, instead = REFUSED[case]
    found = faults_of_functions(law_of(body), "contact")
    assert found and all(fault.startswith("function ") for fault in found)
    text = "\n".join(found)
    assert re.search(f"{told}.*({instead})", text), text
    if case not in ("loops without end", "a truth value as answer"):
        first = (HEAD + FORCE).splitlines().index("{body}") + 1
        lines = [int(fault.split("line ")[1].split(":")[0]) for fault in found]
        helper = "endless" in body or "with_default" in body or "clipped(share, 0.0)" in body
        assert all(1 <= line < first if helper else first - 6 <= line <= first + 45 for line in lines), text


HELPERS = {
    "range": "def range(x):\n    return x\n", "both": "def both(x):\n    return x\n",
    "either": "def either(x):\n    return x\n", "select": "def select(x):\n    return x\n",
    "abs": "def abs(x):\n    return 2.0 * x\n", "nearest": "def nearest(x):\n    return 2.0 * x\n",
    "unlikely": "def unlikely(x):\n    return x\n", "contact_law": "def contact_law(x):\n    return x\n",
    "min": "def min(x):\n    return x\n",
    "step": "def step(x):\n    return x\n",  # the kernel's own
    "named": "def other(x):\n    return 2.0 * x\n\nstep = named = other\n",
    "twice": "import functools\n@functools.lru_cache\ndef twice(x):\n    return x\n",
    "wrapped": "def around(f):\n    def inner(x):\n        return 2.0 * f(x)\n    return inner\n"
    "\n@around\ndef wrapped(x):\n    return x\n",
    "spread": "def spread(*x):\n    return 1.0\n",
    "nothing": "def nothing(x):\n    y = x\n",
    "branches": "def branches(x):\n    if x > 1.0:\n        return x\n    return 2.0 * x\n",
}  # fmt: skip


@pytest.mark.parametrize("name", HELPERS)
def test_functions_that_would_be_taken_for_others_are_refused(name):
    law = law_of(f"return elastic, {name}(share)", HELPERS[name])
    assert faults_of_functions(law, "contact") or faults_of_loops(law(), PAIR, javascript=True)


# What is computed in every loop as Python computes it.
COMPUTED = {
    "the replacement for or": "return elastic, elastic * slowness * (share if share != 0.0 else 0.5)",
    "the replacement for and": "return elastic, elastic * slowness * (2.0 if share != 0.0 else share)",
    "zero times infinity": "big = penetration * 1e300 * 1e300\nreturn elastic, big * 0 + big * -0.0",
    "signs of zeros": "return -0.0 + elastic * 0.0, 0.0 - (0.0 + elastic) * -0.0",
    "a sign of zero that is chosen": "return elastic, -0.0 if share > 0.0 else 0.0",
    "nothing less nothing": "return 0 - elastic, 0.0 / (elastic + 1.0) * -1.0",
    "a whole number without sign": "m = 0\nreturn elastic * -m, share * -0",
    "whole numbers and numbers compared": (
        "return elastic, (1.0 if share < 2 else 0.0) + (1.0 if 3 >= share else 0.0)"
    ),
    "2 ** 3": "return elastic, 2 ** 3 * share",
    "counters": "for k in range(1, 8, 2):\n    elastic += share * (k - 3) / (k + 1)\nreturn elastic, share",
    "counting down": (
        "for k in range(4, 0, -1):\n    elastic = elastic * 0.5 + k * share\nreturn elastic, share"
    ),
    "parts in a loop": "for x in p:\n    elastic += x\nreturn elastic, share",
    "parts of two": "for x in ordered(share, 2.5):\n    elastic += x\nreturn elastic, x",
    "tuples that are chosen": "a, b = (share, 2.0) if share < 2.0 else (2.0, share)\nreturn elastic * a, b",
    "tuples within a tuple": "(a, b), c = ordered(share, 2.0), 3.0\nreturn elastic * a, b + c",
    "an annotation": "factor: float = 2.0 * share\nreturn elastic, factor",
    "the last part": "return elastic, p[-1] + p[-2]",
    "truth values": (
        "on = share > 0.0 and penetration > 0.0\noff = (share < 1.0 or on) if on else False\nreturn elastic,"
        " 1.0 if off else share"
    ),
    "a truth value from a function": "return elastic, 1.0 if inside(share, -1.0, 1.0) else 0.0",
    "infinity": (
        "least = math.inf\nleast = share if share < least else least\nreturn elastic, least if least >"
        " -math.inf else 0.0"
    ),
    "a root of nothing": "return elastic, math.sqrt(share * 0.0) + math.sqrt(2)",
    "a helper that counts": "return elastic, summed(3, share) + summed(0, share)",
    "an elementary function": (
        "return elastic, power(abs(share), 1.5) + approach(abs(share)) + nearest(share)"
    ),
    "names of other letters": "härte = share\nreturn elastic, härte * 2",
    "a value for two names": "a = b = share\nreturn elastic * a, b",
    "another name of the module": "return elastic, m.sqrt(share * share) + m.pi",
    "a root beside math.sqrt": "return elastic, math.sqrt(share * share)",
}


# One of each kind of expression; each case compiles a law for every loop and starts node.
DEFAULT_CASES = (
    "an elementary function", "the replacement for or", "a helper that counts", "signs of zeros",
    "tuples that are chosen", "counting down", "infinity",
)  # fmt: skip


@pytest.mark.parametrize(
    "case",
    default_cases(COMPUTED, lambda case: case in DEFAULT_CASES, "starts a process and compiles every loop"),
)
def test_what_is_in_the_language_is_python_to_the_bit(case):
    """In all loops of this machine, in JavaScript where node is there."""
    more = {
        "another name of the module": "import math as m\n",
        "a root beside math.sqrt": "from math import sqrt\n",
    }.get(case, "")
    law = law_of(COMPUTED[case], more)
    assert faults_of_functions(law, "contact") == []
    found = agreement_of("contact", law, (1e9, 0.3), javascript=True)
    assert found.faults == () and found.states == agreement.STATES and len(found.loops) >= 8
    assert found.javascript == ("JavaScript: compared in node" if shutil.which("node") else agreement.NO_NODE)


def test_a_law_for_a_card_alone_is_said_to_be_not_compared_without_node(monkeypatch):
    monkeypatch.setenv("PATH", "")
    law = law_of("return elastic, share")
    assert agreement_of("contact", law, (1e9, 0.3), javascript=True).javascript == agreement.NO_NODE
    assert "not on a card" in agreement_of("contact", law, (1e9, 0.3)).words()


def test_the_run_of_the_issue_is_refused_and_its_replacement_computes_what_python_does():
    body = "stiffness = stiffness * 1.0\nreturn elastic, elastic * slowness * ({})"
    with pytest.raises(LawError, match=r"line \d+: `share or 0.5`.*write `share if share != 0.0 else 0.5`"):
        assemble(
            four_bar("C", contact=law_of(body.format("share or 0.5"))()), 2e-6, duration=1e-3, force_step=True
        )
    right = law_of(body.format("share if share != 0.0 else 0.5"))
    model = assemble(four_bar("C", contact=right()), 2e-6, duration=1e-3, force_step=True)
    rows = [bits(lanes([model], loop).advance(100, 5)) for loop in ("interpreted", "generated")]
    assert (rows[0] == rows[1]).all()


# ------------------------------------------------------------------------------------------------- whole laws


@pytest.mark.slow("compiles every law")
def test_every_law_of_vfife_is_in_the_language_and_is_python_in_every_loop():
    """But for signs of zeros, and for what terms that drop out make of infinity. A table is not: the kernels'
    own text computes it.
    """
    values = {"exponent": 1.5, "full_damping_depth": 1e-5}
    pair = Pair(0.01, 2e-4, 0.02, effective_mass=1.0)
    parts: dict[str, list] = {}
    for law in [*ContactLaw.registry.values(), *FrictionLaw.registry.values()]:
        if getattr(law, "tabled", False):
            continue
        assert faults_of_functions(law, law_kind(law)) == [], law.name
        slots = law(**{key: values.get(key, 1e6) for key in check.needed(law)}).parameters(pair)
        for part in check.parts_of(law, law_kind(law)):
            name = check.NAMES.get(part.name, law_kind(law))
            parts.setdefault(name, []).append((Single(name, law), [float(value) for value in slots]))
    assert sum(map(len, parts.values())) >= 40
    for found in parts.values():
        agreement_of_all = compared(
            Loops([one for one, _ in found]), [slots for _, slots in found], 128, True
        )
        assert agreement_of_all.faults == () and ("in node" in agreement_of_all.javascript) == (
            shutil.which("node") is not None
        )


REMEMBERS = """
class Law0(FrictionLaw):
    name: ClassVar[str] = "{name}"
    slots: ClassVar[tuple[str, ...]] = ("coefficient",)
    memory: ClassVar[tuple[str, ...]] = ("last (m/s)", "dwell (s)")

    def parameters(self, pair):
        return (0.1,)

    @staticmethod
    def force(normal_force, free_velocity, mobility, memory, dt, p):
        last, dwell = memory
        limit = p[0] * normal_force * (1.0 + dwell)
        return (-limit if free_velocity > 0.0 else limit), ({first}, dwell + dt)

    @staticmethod
    def regime(sliding_velocity, p):
        return {second}
"""


def remembering(first: str, second: str):
    number = next(COUNT)
    return classes(
        f"language_{number}", HEAD + REMEMBERS.format(name=f"law-{number}", first=first, second=second)
    )["Law0"]


def test_a_friction_law_with_memory_and_regime():
    assert faults(remembering("free_velocity", "1.0 if sliding_velocity > p[0] else 0.0")) == []
    assert "is a number and no condition" in faults(remembering("free_velocity if last else 0.0", "0.0"))[0]
    told = faults(remembering("free_velocity", "1.0 if sliding_velocity else 0.0"))
    assert "function regime, line" in told[0] and "no condition" in told[0]
    assert (
        "the friction force (N) and a tuple of 2 numbers to remember"
        in faults(remembering("(free_velocity, last)", "0.0"))[0]
    )


def test_parameters_that_do_not_end_are_stopped(monkeypatch):
    """In the main thread by the system's clock, in others line by line."""
    law = law_of("return elastic, share")
    monkeypatch.setattr(check, "SECONDS", 0.2)
    ending = law.parameters

    def endless(self, *arguments):
        while True:
            pass

    monkeypatch.setattr(law, "parameters", endless)
    assert "parameters() has run for 10 s and does not end" in faults(law)[0]
    told = []
    other = threading.Thread(target=lambda: told.extend(faults(law)))
    other.start()
    other.join(20.0)
    assert "does not end" in told[0]
    monkeypatch.setattr(law, "parameters", ending)
    monkeypatch.setattr(law, "elastic_energy", endless)
    assert "elastic_energy() has run for" in faults(law)[0]
    assert user.SECONDS == 10.0


def test_an_elastic_energy_is_the_integral_of_the_elastic_force(monkeypatch):
    assert faults(Hertz) == []
    right = Hertz.elastic_energy
    for factor, is_fault in ((1.2, True), (0.8, True), (1.001, False)):
        monkeypatch.setattr(
            Hertz, "elastic_energy", lambda self, depth, p, share=factor: share * right(self, depth, p)
        )
        assert bool(faults(Hertz)) is is_fault
        assert not is_fault or "the integral of the elastic force is" in faults(Hertz)[0]


def test_a_law_is_compared_once_and_anew_when_a_number_of_its_file_changes(monkeypatch):
    law = law_of("return elastic, share * SHARE")
    counted = []
    monkeypatch.setattr(
        agreement, "compared", lambda *given, real=agreement.compared: counted.append(1) or real(*given)
    )
    for _ in range(3):
        try_out([(law(), PAIR)])
    assert counted == [1]
    law.force.__globals__["SHARE"] = 0.5
    try_out([(law(), PAIR)])
    assert counted == [1, 1]


@pytest.mark.system("compiles two loops")
def test_a_step_is_made_anew_when_a_number_of_the_file_changes():
    """As at a prompt, where one line is entered again."""
    law = law_of("return elastic * SHARE, 0.3 * elastic * slowness * SHARE")
    rows = []
    for share in (0.75, 0.25, 0.25):
        law.force.__globals__["SHARE"] = share
        model = assemble(four_bar("C", contact=law()), 2e-6, duration=1e-3, force_step=True)
        rows.append([bits(lanes([model], loop).advance(100, 5)) for loop in ("interpreted", "generated")])
    assert all((one == other).all() for one, other in rows)
    assert (rows[1][1] == rows[2][1]).all() and (rows[0][1] != rows[1][1]).any()


def test_a_text_that_python_does_not_run_is_refused():
    """A file that has changed since it was read: the step would be made of the new text, and Python would run
    the old one.
    """
    import linecache

    law = law_of("return elastic, share * 2.0")
    path = law.force.__code__.co_filename
    lines = [line.replace("share * 2.0", "share * 3.0") for line in linecache.getlines(path)]
    linecache.cache[path] = (len("".join(lines)), None, lines, path)
    assert "the file has changed since; load it again" in faults_of_functions(law, "contact")[0]
    assert codes("this is = no Python", "laws.py", True, False) == {}


def test_a_loop_that_differs_is_told(monkeypatch):
    """Should a loop ever differ, the law cannot be used, and the sentence says which loop, where and by how
    much.
    """
    from vfife.compiler.backends import python

    monkeypatch.setitem(python.PATTERNS, "abs", "-abs({})")
    told = faults_of_loops(law_of("return elastic, abs(share) + 1.0")(), PAIR)
    assert "Python computes" in told[0] and "'straight line as Python'" in told[0] and "report it" in told[0]


def test_numbers_of_the_text_that_python_cannot_divide():
    law = law_of("return elastic, share * (1.0 / (SHARE - SHARE) if share > 9.0 else 1.0)")
    first = (HEAD + FORCE).splitlines().index("{body}") + 1
    assert (
        f"function force, line {first}: numbers of its text are divided by zero; both arms"
        in faults_of_loops(law(), PAIR)[0]
    )
    more = (
        "def halved(x):\n    y = 2.0 * x\n    return y / (SHARE - SHARE) if x > SHARE else"
        " math.sqrt(NEGATIVE)\n"
    )
    law = law_of("return elastic, halved(share)", more)
    assert (
        f"line {len(HEAD.splitlines()) + 3}: numbers of its text give none (math domain error)"
        in faults_of_loops(law(), PAIR)[0]
    )
