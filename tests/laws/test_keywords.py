"""Parameters of a law are given by name."""

from __future__ import annotations

import copy
import pickle

import pytest

from support import CONTACT_LAWS, contact_law
from vfife.errors import LawError
from vfife.laws import Ambrosio, FrictionLaw, LankaraniNikravesh


@pytest.mark.parametrize("law", [*CONTACT_LAWS, *FrictionLaw.registry.values()], ids=lambda law: law.name)
def test_numbers_without_names_are_refused(law: type) -> None:
    """Lankarani and Nikravesh with (6.6e10, 0.9) would have a restitution of 6.6e10."""
    with pytest.raises(
        TypeError, match=rf"the law '{law.name}' takes its parameters by name, as in {law.__name__}\("
    ):
        law(0.5)


def test_laws_can_be_copied() -> None:
    law = LankaraniNikravesh(restitution=0.4, stiffness=6.6e10)
    assert copy.deepcopy(law) == pickle.loads(pickle.dumps(law)) == law
    assert contact_law(LankaraniNikravesh) == LankaraniNikravesh()


def test_texts_with_units_are_read_as_in_a_model_file() -> None:
    law = Ambrosio(v0="1 mm/s", v1="0.02 m/s")
    assert law == Ambrosio(v0=1e-3, v1=0.02) and isinstance(law.v0, float)
    with pytest.raises(LawError, match=r'v0 = "1 kg": this is a mass; allowed: a velocity') as raised:
        Ambrosio(v0="1 kg", coefficient=-2.0)
    assert [fault.where for fault in raised.value.faults] == ["coefficient", "v0"]
