"""Materials by name: handbook numbers, their sources, and how a model file takes and replaces them."""

import pytest

import vfife
from model_texts import FOUR_BAR
from vfife.errors import ModelError
from vfife.laws import MATERIALS, Material
from vfife.laws.materials import TABLE
from vfife.modelfile import dump, loads


def test_steel_is_what_it_was():
    assert MATERIALS["steel"] == Material() == Material("steel", 207e9, 0.3, 7800.0)


@pytest.mark.parametrize("name", MATERIALS)
def test_each_has_a_source_and_numbers_that_nature_allows(name):
    material, (*_, meaning, source) = MATERIALS[name], TABLE[name]
    assert material.name == name and meaning and ("(19" in source or "(20" in source)
    assert (
        1e6 < material.youngs_modulus < 5e11
        and 0.0 < material.poissons_ratio < 0.5
        and 900.0 < material.density < 9000.0
    )


# Speed of sound along a bar, sqrt(E/rho) (m/s): CRC Handbook of Chemistry and Physics, "Speed of sound in
# various media".
BAR = {
    "aluminium": 5000,
    "brass": 3480,
    "copper": 3750,
    "steel": 5200,
    "stainless-steel": 5000,
    "magnesium": 4940,
    "titanium": 5080,
}


@pytest.mark.parametrize("name", BAR)
def test_sound_travels_at_the_speed_that_is_measured(name):
    """A check from elsewhere on modulus and density together: a slip in either would show."""
    one = MATERIALS[name]
    assert (one.youngs_modulus / one.density) ** 0.5 == pytest.approx(BAR[name], rel=0.05)


def test_a_model_names_one_without_a_table():
    model = loads(FOUR_BAR, [("body.coupler.material", "bronze"), ("joint.C.journal_material", "ptfe")])
    assert model.bodies["coupler"].material == MATERIALS["bronze"] is vfife.laws.MATERIALS["bronze"]
    assert model.clearances["C"].journal_material == MATERIALS["ptfe"]
    assert loads(dump(model)) == model


def test_a_table_takes_its_place():
    mine = "[material.bronze]\nyoungs_modulus = 1e11\npoissons_ratio = 0.3\ndensity = 8000\n"
    assert loads(FOUR_BAR + mine, [("body.coupler.material", "bronze")]).bodies[
        "coupler"
    ].material == Material("bronze", 1e11, 0.3, 8000.0)
    one = (
        loads(FOUR_BAR, [("body.coupler.material", "bronze"), ("material.bronze.youngs_modulus", "90 GPa")])
        .bodies["coupler"]
        .material
    )
    assert one == Material("bronze", 90e9, 0.341, 8860.0)


def test_an_unknown_one_is_told():
    with pytest.raises(ModelError, match=r'"bronce".*Did you mean "bronze"'):
        loads(FOUR_BAR, [("body.coupler.material", "bronce")])
