"""A user's law on its way into the step: what may stand in it, and the sentence that tells what may not."""

import importlib.util
import math
from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np
import pytest

from support import bits, four_bar, lanes
from vfife.assembly.assemble import assemble
from vfife.compiler.runtime.loops import python_line
from vfife.compiler.runtime.native import compiled
from vfife.compiler.trace.source import Gathered, data_driven, dispatch
from vfife.compiler.trace.straight_line import trace
from vfife.compiler.trace.tape import Branch
from vfife.errors import LawError, SourceError
from vfife.kernels.blocks import CONTACT_SLOTS
from vfife.laws import ContactLaw, LankaraniNikravesh, Pair

pytestmark = pytest.mark.usefixtures("only_built_in_laws")


class OneStiffness:
    """Fields of the laws below."""

    slots: ClassVar[tuple[str, ...]] = ("stiffness",)

    def parameters(self, pair: Pair) -> tuple[float, ...]:
        return (6e10,)

    def elastic_energy(self, penetration, p):
        return 0.4 * p[0] * penetration**2.5


def select_law() -> type[ContactLaw]:
    @dataclass(frozen=True)
    class Selecting(OneStiffness, ContactLaw):
        name: ClassVar[str] = "selecting"

        @staticmethod
        def force(penetration, slowness, p):
            elastic = p[0] * penetration * math.sqrt(penetration)
            return elastic, (0.3 * elastic * slowness if penetration > 1e-6 else 0.0)

    return Selecting


def branch_law() -> type[ContactLaw]:
    @dataclass(frozen=True)
    class Branching(OneStiffness, ContactLaw):
        name: ClassVar[str] = "branching"

        @staticmethod
        def force(penetration, slowness, p):
            elastic = p[0] * penetration * math.sqrt(penetration)
            if penetration > 1e-6:
                return elastic, 0.3 * elastic * slowness
            return elastic, 0.0

    return Branching


def assembled(law: type[ContactLaw]):
    return assemble(four_bar("C", contact=law()), 2e-6, duration=1e-3, force_step=True)


def rows(law: type[ContactLaw], loop: str) -> np.ndarray:
    return lanes([assembled(law)], loop).advance(100, 6)


@pytest.mark.system("steps in the interpreter")
def test_a_law_of_selects_goes_into_straight_lines():
    """The generated text, interpreted here (compiling it is other tests' work), takes the step of the
    data-driven loop.
    """
    law = select_law()
    runner = lanes([assembled(law)], "interpreted")
    runner.take = python_line(runner.topology)(runner.memory)
    assert (bits(runner.advance(100, 6)) == bits(rows(law, "interpreted"))).all()


def test_a_law_that_branches_is_refused_in_words():
    """The data-driven loop could take an ``if``, the generated one cannot: one answer for both, before
    anything is compiled.
    """
    with pytest.raises(
        LawError,
        match=(
            r"test_trace.py, line \d+, law 'branching'.*line \d+: an `if` statement.*`a if condition else b`"
        ),
    ):
        assembled(branch_law())


def test_a_law_that_branches_compiles_beside_others():
    """The choice of a law as the loop compiles it, alone (the whole loop would take ten seconds more)."""
    laws = (LankaraniNikravesh, branch_law())
    gathered = Gathered()
    choice = dispatch("contact", laws, gathered)
    asked = (
        "def ask(kind, depth, S, out):\n    out[0], out[1] = contact_law(kind, depth, 2.0, S, 0)\n   "
        " return 0\n"
    )
    ask = compiled("\n\n".join([*gathered.texts.values(), choice, asked]), "ask", "i d f1 f1")
    out, slots = np.zeros(2), np.array([6e10, 0.3])
    for kind, law in enumerate(laws):
        for depth in (1e-7, 1e-5):
            ask(kind, depth, slots, out)
            assert tuple(out) == law.force(depth, 2.0, tuple(slots[: len(law.slots)]))


def test_a_law_that_branches_is_no_straight_line():
    """Generated code refuses it and says what to write instead."""
    with pytest.raises(Branch, match="conditional expression"):
        trace(replace(assembled(select_law()).topology, contact_laws=(branch_law(),), contact_form=(0,)))


def test_an_unused_law_of_the_user_does_not_stand_in_the_way():
    branch_law()
    assert trace(assemble(four_bar("C"), 2e-6, duration=1e-3).topology).operations


def gathered_with(force, slots=("stiffness",)) -> str:
    count = slots

    class Faulty(LankaraniNikravesh):
        name: ClassVar[str] = "faulty"
        slots: ClassVar[tuple[str, ...]] = count

    Faulty.force = staticmethod(force)
    return data_driven((Faulty,), ())


TABLE = [1.0, 2.0]
FACTOR = 3.0


def test_a_number_of_the_module_becomes_part_of_the_law():
    def force(penetration, slowness, p):
        return FACTOR * p[0] * penetration, 0.0

    text = gathered_with(force)
    assert "3.0 * p[0]" in text and "contact_faulty" in text


def test_a_closure_is_refused_and_named():
    secret = 3.0

    def force(penetration, slowness, p):
        return secret * penetration, 0.0

    with pytest.raises(SourceError, match="secret.*parameters"):
        gathered_with(force)


def test_an_object_of_the_module_is_refused_and_named():
    def force(penetration, slowness, p):
        return TABLE[0] * penetration, 0.0

    with pytest.raises(SourceError, match="TABLE.*list"):
        gathered_with(force)


def test_too_many_parameters_are_refused():
    def force(penetration, slowness, p):
        return p[0] * penetration, 0.0

    with pytest.raises(SourceError, match=f"{CONTACT_SLOTS + 1} parameters.*{CONTACT_SLOTS}"):
        gathered_with(force, tuple("abcdefghi"))


def larger(a, b):
    """Bears the name of a function of the kernels."""
    return 1000.0 * a


def test_a_function_that_bears_a_kernels_name_does_not_replace_it():
    """Refused in words, or both kept apart; never one in the place of the other."""

    def force(penetration, slowness, p):
        return larger(p[0] * penetration, 0.0), 0.0

    try:
        text = gathered_with(force)
    except SourceError as error:
        assert "larger" in str(error)
    else:
        space = {"math": math, "jit": lambda f: f}
        exec(text, space)
        assert space["contact_faulty"](2.0, 0.0, (3.0,))[0] == 6000.0


MODULE = """
from dataclasses import dataclass
from typing import ClassVar
from vfife.laws import LankaraniNikravesh
SCALE = {scale}
class Scaled(LankaraniNikravesh):
    name: ClassVar[str] = "{name}"
    @staticmethod
    def force(penetration, slowness, p):
        return SCALE * p[0] * penetration, 0.0
"""


def test_numbers_of_two_modules_stay_apart(tmp_path):
    """Two users' files may both call a number SCALE: each law keeps its own, or the clash is told."""
    laws = []
    for name, scale in (("first", 2.0), ("second", 5.0)):
        path = tmp_path / f"{name}.py"
        path.write_text(MODULE.format(name=name, scale=scale))
        spec = importlib.util.spec_from_file_location(name, path)
        module = importlib.util.module_from_spec(spec)
        spec.loader.exec_module(module)
        laws.append(module.Scaled)
    try:
        text = data_driven(tuple(laws), ())
    except SourceError as error:
        assert "SCALE" in str(error)
    else:
        space = {"math": math, "jit": lambda f: f}
        exec(text, space)
        assert [space[f"contact_{law.name}"](1.0, 0.0, (1.0, 0.0))[0] for law in laws] == [2.0, 5.0]
