"""A user's law on its way into the step: what may stand in it, and the sentence that tells what may not."""

import math
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
import pytest
from support import bits, four_bar, lanes

from vfife.assemble import assemble
from vfife.kernels.arrays import CONTACT_SLOTS
from vfife.kernels.generate import straight_line
from vfife.kernels.source import SourceError, data_driven
from vfife.kernels.trace import Branch
from vfife.laws import ContactLaw, FrictionLaw, LankaraniNikravesh, Pair, quantity


@pytest.fixture(autouse=True)
def only_built_in_laws():
    """Laws of these tests do not stay in the registries, which other tests go through."""
    before = dict(ContactLaw.registry), dict(FrictionLaw.registry)
    yield
    for law, kept in zip((ContactLaw, FrictionLaw), before, strict=True):
        law.registry.clear()
        law.registry.update(kept)


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


def test_a_law_of_selects_goes_into_every_loop():
    """Compiled and interpreted data-driven, and generated (whose text is interpreted here: compiling it is other tests' work)."""
    from vfife.kernels.compile import interpreted

    law = select_law()
    expected = rows(law, "data-driven")
    assert (bits(rows(law, "interpreted")) == bits(expected)).all()
    runner = lanes([assembled(law)], "interpreted")
    runner.wide = interpreted(straight_line(runner.topology, 1), "advance")
    assert (bits(runner.advance(100, 6)) == bits(expected)).all()


def test_a_law_that_branches_runs_in_the_data_driven_loop():
    """What happens: compiled and interpreted the loop takes an ``if`` as it is, and gives what the select gives, to the bit."""
    plain = rows(branch_law(), "interpreted")
    assert (bits(plain) == bits(rows(select_law(), "interpreted"))).all()
    assert np.abs(plain).max() > 1e3
    compile(data_driven((branch_law(),), ()), "law", "exec")


def test_a_law_that_branches_is_no_straight_line():
    """Generated code refuses it and says what to write instead."""
    with pytest.raises(Branch, match="conditional expression"):
        straight_line(assembled(branch_law()).topology, 1)


def test_an_unused_law_of_the_user_does_not_stand_in_the_way():
    branch_law()
    assert "advance" in straight_line(assemble(four_bar("C"), 2e-6, duration=1e-3).topology, 1)


def gathered_with(force, slots=("stiffness",)) -> str:
    name, count = "faulty", slots

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
    assert "FACTOR = 3.0" in text and "contact_faulty" in text


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


def test_two_functions_of_one_name_are_refused():
    """A user's own ``arm`` must not replace the kernels' ``arm``, nor another law's."""
    def arm(x):
        return 2.0 * x

    space = {"arm": arm}
    exec("def force(penetration, slowness, p):\n    return arm(p[0] * penetration), 0.0", space)
    with pytest.raises((SourceError, OSError)):
        gathered_with(space["force"])
