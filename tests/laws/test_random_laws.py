"""Random laws: what the language has is computed in every loop as Python computes it; what it has not is
refused in a sentence.
"""

import random
import re
import shutil
import sys
from collections import Counter

import numpy as np
import pytest

from choice import default_cases
from emulated import card
from laws.random_laws import laws, source
from vfife.compiler.backends import expressions, javascript, llvm, python
from vfife.compiler.runtime import native as compiling
from vfife.compiler.runtime.lawloops import WIDTHS, Loops, Single, traced
from vfife.compiler.trace.traceable import Traceable
from vfife.laws.agreement import STATES, by_python, compared, first_difference, same_bits, states_of
from vfife.laws.check import faults_of_functions
from vfife.laws.law import law_kind

BATCH = 50  # laws of one compilation
NODE = shutil.which("node") is not None


@pytest.fixture(autouse=True)
def nothing_kept(monkeypatch):
    """Each loop is compiled anew; nothing of it goes to the disk, and nothing that was there
    is taken for it.
    """
    monkeypatch.setattr(compiling.cache, "read", lambda name: None)
    monkeypatch.setattr(compiling.cache, "keep", lambda name, content: None)


def slots_of(singles: list[Single], seed: int) -> list[list[float]]:
    """Parameters of the laws."""
    chance = random.Random(seed)
    return [
        [chance.choice((0.0, -0.0, 0.5, 1.0, -1.0, 2.5, 1e5, 1e-7)) for _ in single.law.slots]
        for single in singles
    ]


def accepted(seed: int, count: int, foreign: float = 0.0) -> dict[str, list[Single]]:
    """Laws of a seed by their parts, all that ``check`` would let pass; what it refuses is
    told in sentences.
    """
    found: dict[str, list[Single]] = {"contact": [], "friction": []}
    for law in laws(seed, count, foreign):
        faults = faults_of_functions(law, law_kind(law))
        assert all(
            re.match(r"function \w+(, line \d+)?: .{10,}[;.,] ?.{5,}|function \w+ (returns|takes) .*", fault)
            for fault in faults
        ), faults
        assert foreign or not faults, f"{faults}\n{source(law)}"
        if not faults:
            single = Single(law_kind(law), law)
            try:
                traced(single)
            except (ZeroDivisionError, ValueError):  # of constants: told at once, too
                continue
            found[single.part].append(single)
    return found


def differences(
    seed: int, count: int, foreign: float = 0.0, states: int = 48, widths: tuple[int, ...] = WIDTHS
) -> Counter[str]:
    """Laws of a seed by what is wrong with them; '' for those with which nothing is."""
    found: Counter[str] = Counter()
    for singles in accepted(seed, count, foreign).values():
        if not singles:
            continue
        loops, slots = Loops(singles, widths), slots_of(singles, seed)
        agreement = compared(loops, slots, states, NODE, seed)
        found[""] += len(singles) - len(agreement.faults)
        found.update(agreement.faults)
        assert not NODE or agreement.javascript == "JavaScript: compared in node"
        programs = card.functions(loops.ptx())
        for k, (single, numbers) in enumerate(zip(singles, slots, strict=True)):
            drawn = states_of(single, loops.traces[k], numbers, states, seed)
            try:
                card_rows = card.run(programs[f"law{k}"], drawn)
            except ValueError as error:
                found[str(error)] += 1
                continue
            ran = {"generated, 1 lane": loops.compiled["generated, 1 lane"](k, drawn), "PTX": card_rows}
            if fault := first_difference(single, drawn, ran):
                found[fault] += 1
    return found


def none_differs(seeds: range, foreign: float) -> int:
    """How many laws of the seeds were compared; fails where one differs."""
    total = 0
    for seed in seeds:
        found = differences(seed, BATCH, foreign)
        total += found.pop("")
        assert not found, f"seed {seed}: {next(iter(found))}"
    return total


@pytest.mark.slow("compiles fifty laws")
@pytest.mark.parametrize(
    ("seeds", "foreign", "least"),
    [
        (range(10, 11), 0.0, 46),
        pytest.param(range(11, 14), 0.0, 136, marks=pytest.mark.system("compiles 150 laws")),
        pytest.param(range(20, 21), 0.2, 38, marks=pytest.mark.system("compiles 50 laws")),
    ],
)
def test_random_laws_are_computed_as_python_computes_them(seeds, foreign, least):
    """250 laws, 50 of them by default, in every loop, in JavaScript where node is there, and as PTX in an
    interpreter.

    Of the last 50 some have what is not in the language.
    """
    assert none_differs(seeds, foreign) >= least


def test_what_is_not_in_the_language_is_refused():
    """60 laws, each with one thing that is not; those few that pass (a part of a tuple that is written out)
    agree.
    """
    found = accepted(30, 60, 1.0)
    assert sum(map(len, found.values())) <= 6
    assert not [
        fault
        for singles in found.values()
        if singles
        for fault in compared(Loops(singles, (8,)), slots_of(singles, 1), 48, False).faults
        if "generated, 1 lane" not in fault
    ]


@pytest.mark.soak
def test_ten_thousand_random_laws():
    seed = random.SystemRandom().randrange(10**6)
    print(f"seed {seed}")
    assert (
        none_differs(range(seed, seed + 160), 0.0) + none_differs(range(seed + 160, seed + 240), 0.5) >= 9000
    )


def fused(monkeypatch):
    """Products and sums may be contracted."""
    real = llvm.Writer.operation

    def operation(self, one):
        real(self, one)
        self.out[-1] = re.sub(r"= (fadd|fmul) ", r"= \1 contract ", self.out[-1])

    monkeypatch.setattr(llvm.Writer, "operation", operation)


def whole_turned(monkeypatch):
    """Whole numbers compare the other way."""
    monkeypatch.setattr(
        expressions,
        "INTEGER_ORDER",
        {"<": "sge", ">": "sle", "<=": "sgt", ">=": "slt", "==": "ne", "!=": "eq"},
    )


def folded(monkeypatch):
    monkeypatch.setattr(Traceable, "exactly", lambda self, function: function)


def without_sign(module):
    return lambda monkeypatch: monkeypatch.setattr(
        module, "literal", lambda x, real=module.literal: real(abs(x) if x == 0.0 else x)
    )


def entry(name, key, value):
    return lambda monkeypatch: monkeypatch.setitem(name, key, value)


# Faults of one place of one writer, and in which loop they have to be seen.
PLANTED = {
    "a product with zero is left out": (folded, "Python computes"),
    "-0.0 becomes 0.0 in LLVM's text": (without_sign(llvm), "generated"),
    "-0.0 becomes 0.0 in the data-driven loop": (without_sign(expressions), "data-driven"),
    "branches of the straight line are swapped": (
        entry(python.PATTERNS, "select", "{2} if {0} else {1}"),
        "straight line as Python",
    ),
    "branches of JavaScript are swapped": (
        entry(javascript.PATTERNS, "select", "{0} ? {2} : {1}"),
        "JavaScript",
    ),
    "a value at which a comparison turns": (entry(llvm.ORDER, ">=", "ogt"), "generated"),
    "the same in the data-driven loop": (entry(expressions.ORDER, "<", "ole"), "data-driven"),
    "a comparison that NaN passes": (entry(llvm.ORDER, "!=", "one"), "generated"),
    "a comparison of whole numbers": (whole_turned, "data-driven"),
    "a difference of whole numbers": (entry(expressions.INTEGER, "-", "add nsw"), "data-driven"),
    "and for or": (entry(llvm.BINARY, "or", "and"), "generated"),
    "a product that is fused": (fused, "PTX"),
    "a root in single precision": (
        entry(javascript.PATTERNS, "sqrt", "Math.fround(Math.sqrt({}))"),
        "JavaScript",
    ),
}
# Faults that few laws show.
SELDOM = (
    "a product with zero is left out",
    "-0.0 becomes 0.0 in LLVM's text",
    "-0.0 becomes 0.0 in the data-driven loop",
)


@pytest.mark.parametrize(
    "fault", default_cases(PLANTED, lambda fault: fault == "and for or", "compiles ten laws in every loop")
)
def test_a_planted_fault_is_found(monkeypatch, fault):
    """By ten laws, and by thirty where few have what it changes."""
    plant, loop = PLANTED[fault]
    if loop == "JavaScript" and not NODE:
        pytest.skip("needs node, which runs JavaScript")
    plant(monkeypatch)
    found = differences(50, 30 if fault in SELDOM else 10, widths=(1,))
    found.pop("")
    assert any(loop in one for one in found), found


def test_states_are_not_beside_the_point():
    """Nearly all states of random laws give finite numbers, and both arms of most choices are taken."""
    counted = Counter()
    for part, singles in accepted(40, 30).items():
        for single in singles:
            drawn = states_of(single, traced(single), [1.0] * len(single.law.slots), STATES)
            answers = by_python(single, drawn)
            raised = np.array([one[0] is None for one in answers])
            counted["raised"] += int(raised.sum())
            counted["finite"] += int(np.isfinite(answers[~raised].astype(float)).all(axis=1).sum())
            counted["all"] += len(drawn)
        assert part in ("contact", "friction")
    assert counted["raised"] < 0.1 * counted["all"] and counted["finite"] > 0.7 * counted["all"]


def test_bits_are_compared():
    assert same_bits(
        np.array([0.0, -0.0, 1.0, np.nan]), np.array([0.0, 0.0, 1.0 + 2**-52, -np.nan])
    ).tolist() == [True, False, False, True]
    assert sys.float_info.mant_dig == 53
