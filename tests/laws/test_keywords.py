"""Parameters of a law are given by name."""

from __future__ import annotations

import copy
import pickle

import pytest

from support import CONTACT_LAWS, contact_law
from vfife.laws import FrictionLaw, LankaraniNikravesh


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
