"""Powers in a law's function: every loop computes the product that stands for them."""

import math
import sys

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from laws.random_laws import HEAD, classes
from vfife.laws import Pair
from vfife.laws.check import faults_of_class, faults_of_loops

PAIR = Pair(0.01, 2e-4, 0.02)
EXPONENTS = [k / 2 for k in range(-16, 17) if k]
LAW = """
class Law0(ContactLaw):
    name: ClassVar[str] = "{name}"
    slots: ClassVar[tuple[str, ...]] = ("stiffness", "share")

    def parameters(self, pair):
        return 1e9, 0.5

    @staticmethod
    def force(penetration, slowness, p):
        depth = penetration + 1e-5
        return p[0] * penetration * ({first}), helper(depth) * slowness


def helper(x):
    x {update}
    return x
"""
pytestmark = pytest.mark.usefixtures("only_built_in_laws")


def product(exponent: float, base: str) -> str:
    """Text of the product that stands for a power."""
    factors = [base] * int(abs(exponent)) + [f"math.sqrt({base})"] * (exponent % 1 == 0.5)
    return f"{'1.0 / ' * (exponent < 0)}({' * '.join(factors)})"


def laws_of(exponent: float, text: str, number: int):
    """A law with powers, and one with their products."""
    pairs = [
        ("power", {"first": f"depth ** {text}", "update": f"**= {text}"}),
        ("product", {"first": product(exponent, "depth"), "update": f"= {product(exponent, 'x')}"}),
    ]
    return [
        classes(f"powers_{name}_{number}", HEAD + LAW.format(name=f"law-{name}-{number}", **words))["Law0"]
        for name, words in pairs
    ]


@pytest.fixture(scope="module")
def pairs_of_laws():
    """Laws of all exponents, examined as before a run."""
    result = [laws_of(exponent, repr(exponent), k) for k, exponent in enumerate(EXPONENTS)]
    result += [laws_of(value, text, 100 + k) for k, (text, value) in enumerate(WRITTEN.items())]
    for law in (law for pair in result for law in pair):
        assert faults_of_class(law) == []
    return result


WRITTEN = {"2": 2.0, "-1": -1.0, "(3 / 2)": 1.5, "-(5 / 2)": -2.5, "8": 8.0}
positive = st.floats(1e-30, 1e30)


@given(depth=positive, slowness=positive)
@settings(max_examples=200)
def test_a_power_is_its_product_to_the_bit(pairs_of_laws, depth, slowness):
    for power, product in pairs_of_laws:
        answers = []
        for law in (power, product):
            try:
                answers.append(law.force(depth, slowness, (1e9, 0.5)))
            except ZeroDivisionError:
                answers.append("division by zero")
        assert answers[0] == answers[1]


def test_products_differ_from_the_power_of_the_library(pairs_of_laws):
    """Otherwise the test above would pass with powers as they are."""
    k = EXPONENTS.index(4.5)
    states = [0.1 + 0.01 * n for n in range(100)]
    forces = [pairs_of_laws[k][0].force(x, 0.0, (1.0, 0.5))[0] for x in states]
    assert any(force != x * (x + 1e-5) ** 4.5 for x, force in zip(states, forces, strict=True))
    assert forces == pytest.approx([x * math.pow(x + 1e-5, 4.5) for x in states], rel=1e-14)


@pytest.mark.slow("compiles laws")
@pytest.mark.parametrize("exponent", [-1.5, -1.0, 0.5, 2.5, 8.0])
def test_every_loop_computes_the_product(exponent, pairs_of_laws):
    power, _ = pairs_of_laws[EXPONENTS.index(exponent)]
    assert faults_of_loops(power(), PAIR, javascript=True) == []


def test_a_file_without_math_takes_half_exponents():
    """The file of a law need not import math for ``x ** 0.5``."""
    head = HEAD.replace("import math\n", "")
    assert head != HEAD
    words = {"name": "law-root", "first": "depth ** 0.5", "update": "**= 1.5"}
    law = classes("powers_without_math", head + LAW.format(**words))["Law0"]
    assert faults_of_class(law) == []
    assert law.force(1.0, 0.0, (1.0, 0.0))[0] == math.sqrt(1.0 + 1e-5)
    assert sys.modules["powers_without_math"].math is math
