"""Every friction law that is registered can be written into a model file, with units, and
comes back from it.
"""

import dataclasses

import pytest

from model_texts import FOUR_BAR
from vfife.errors import ModelError
from vfife.laws import FrictionLaw, LuGre
from vfife.modelfile import dump, loads

LAWS = sorted(FrictionLaw.registry.values(), key=lambda law: law.name)
OLD = 'law = "ambrosio"\nv0 = "0.01 m/s"\nv1 = "0.1 m/s"\n'
# The same quantity in a unit that people write, and what it is in SI.
WRITTEN = {
    "1": ("0.25", 0.25),
    "m/s": ('"2 mm/s"', 2e-3),
    "1/m": ('"30 1/mm"', 3e4),
    "s/m": ('"0.02 s/mm"', 20.0),
    "s": ('"300 ms"', 0.3),
}
HIGHER = {"static_coefficient": ("0.3", 0.3), "v1": ('"0.5 m/s"', 0.5)}


@pytest.mark.parametrize("law", LAWS, ids=lambda law: law.name)
def test_a_law_comes_back_from_its_file(law):
    values = {
        field.name: HIGHER.get(field.name, WRITTEN[field.metadata["unit"]])
        for field in dataclasses.fields(law)
    }
    table = "".join(f"{name} = {text}\n" for name, (text, _) in values.items())
    model = loads(FOUR_BAR.replace(OLD, f'law = "{law.name}"\n{table}'))
    chosen = model.clearances["C"].friction
    assert chosen == law(**{name: value for name, (_, value) in values.items()})
    assert loads(dump(model)).clearances["C"].friction == chosen
    assert loads(FOUR_BAR.replace(OLD, f'law = "{law.name}"\n')).clearances["C"].friction == law()


def test_a_stiffness_in_newtons_per_metre_is_told_what_it_should_be():
    """Bristle stiffness is per unit of normal force, so that it goes with it."""
    text = FOUR_BAR.replace(
        OLD, f'law = "{LuGre.name}"\nbristle_stiffness = "1e5 N/m"\nstatic_coefficient = 0.01\n'
    )
    with pytest.raises(ModelError, match=r"bristle_stiffness.*a stiffness per unit of normal force"):
        loads(text)
    with pytest.raises(ModelError, match="Raise the one or lower the other"):
        loads(text.replace('bristle_stiffness = "1e5 N/m"\n', ""))
