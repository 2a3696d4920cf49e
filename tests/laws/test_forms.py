"""Forms of laws: what a compiled loop tells apart, so that few models need a compilation of their own."""

import dataclasses

from support import CONTACT_LAWS, contact_law, four_bar
from vfife.assembly.assemble import assemble, forms
from vfife.laws import (
    Ambrosio,
    ContactLaw,
    Flores,
    FrictionLaw,
    Frictionless,
    Johnson,
    LankaraniNikravesh,
    Liu,
    Pereira,
    Radzimovsky,
)
from vfife.simulation.start import reference_of

COMMON = forms(ContactLaw, [])


def test_common_laws_are_in_every_loop_and_no_others():
    assert set(COMMON) == {LankaraniNikravesh.form(), Pereira.form()}
    assert set(forms(FrictionLaw, [])) == {Ambrosio.form(), Frictionless.form()}
    assert len({law.form() for law in CONTACT_LAWS} - set(COMMON)) >= 4


def test_laws_that_differ_in_numbers_only_share_a_compilation():
    assert forms(ContactLaw, [Flores(), LankaraniNikravesh()]) == COMMON
    assert (
        forms(ContactLaw, [Johnson()])
        == forms(ContactLaw, [Radzimovsky(restitution=0.5), Johnson(restitution=0.9)])
        != COMMON
    )


def test_the_order_of_the_joints_does_not_matter():
    assert forms(ContactLaw, [Johnson(), Liu()]) == forms(
        ContactLaw, [Liu(), LankaraniNikravesh(), Johnson()]
    )


def test_a_form_has_the_function_and_the_slots_of_its_laws():
    for law in CONTACT_LAWS:
        assert law.form().force is law.force and law.form().slots == law.slots
        assert assemble(
            four_bar("B", contact=contact_law(law)), 1e-7, duration=1e-3, force_step=True
        ).topology.contact_laws == forms(ContactLaw, [contact_law(law)])


def test_a_subclass_with_a_force_of_its_own_is_a_form_of_its_own():
    @dataclasses.dataclass(frozen=True)
    class Softer(LankaraniNikravesh):
        @staticmethod
        def force(penetration, slowness, p):
            return 0.5 * p[0] * penetration, 0.0

    assert Softer.form() is Softer and forms(ContactLaw, [Softer()]) == (*COMMON, Softer)


def test_the_reference_shares_the_loop_of_its_run():
    m = four_bar("C", contact=Johnson(restitution=0.9))
    reference = reference_of(m, duration=1e-3)
    assert (
        reference.record.assembly.topology.contact_laws
        == assemble(m, 1e-7, duration=1e-3, force_step=True).topology.contact_laws
    )
