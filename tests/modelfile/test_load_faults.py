"""What can be wrong with a load, told in words, and tables that are alike in a file and in Python."""

import pytest

from model_texts import COMPRESSOR as MODEL
from model_texts import GAS
from vfife.errors import ModelError
from vfife.model.loads import GuideForce, PointForce
from vfife.modelfile import dump, loads

TABLE = 'travels = ["150 mm", "0.25 m"]\n'
FAULTS = {
    "no size": (GAS, "[load.gas]", "the size of the load is missing"),
    "two sizes": (
        GAS + 'force = 3\npressure = "1 bar"\nbore = "50 mm"',
        "[load.gas] pressure",
        "exclude each other",
    ),
    "no bore": (GAS + 'pressure = "1 bar"', "[load.gas] bore", "bore, which is missing"),
    "bore of a force": (GAS + 'force = 3\nbore = "50 mm"', "[load.gas] bore", "goes with a pressure"),
    "no such joint": (
        GAS.replace('slider = "guide"', 'slider = "guid"') + "force = 3",
        "[load.gas] slider",
        'Did you mean "guide"',
    ),
    "no guide": (
        GAS.replace('slider = "guide"', 'slider = "C"') + "force = 3",
        "[load.gas] slider",
        "of kind ideal, which has no guide",
    ),
    "two axes": (
        GAS + TABLE + "times = [0, 1]\nforce = [1, 2]",
        "[load.gas] travels",
        "one of times and travels",
    ),
    "not alike": (GAS + TABLE + "force = [1, 2, 3]", "[load.gas] force", "2 values"),
    "back not alike": (GAS + TABLE + "force = [1, 2]\nforce_back = [1]", "[load.gas] force_back", "2 values"),
    "back over times": (
        GAS + "times = [0, 1]\nforce = [1, 2]\nforce_back = [1, 3]",
        "[load.gas] force_back",
        "only a table over travels",
    ),
    "descends": (GAS + "travels = [1, 0]\nforce = [1, 2]", "[load.gas] travels", "must ascend"),
    "no places": (GAS + "force = [1, 2]", "[load.gas] times", "go together"),
    "does not repeat": (
        GAS + "times = [0, 1]\nforce = [1, 2]\nrepeat = true",
        "[load.gas] force",
        "begins at 1 and ends at 2",
    ),
    "cannot repeat": (
        GAS + TABLE + "force = [1, 1]\nrepeat = true",
        "[load.gas] repeat",
        "only a table over times or angles",
    ),
    "joining": (
        GAS + TABLE + 'force = [1, 2]\ninterpolation = "cubic"',
        "[load.gas] interpolation",
        "monotone",
    ),
    "some units": (
        GAS + TABLE + 'force = ["40", "55 kN"]',
        "[load.gas] force",
        '1 of the values have no unit, others have one, as "55 kN"',
    ),
    "unit": (GAS + TABLE + 'force = [1, "2 bar"]', "[load.gas] force", "a pressure"),
    "expression": (
        GAS + 'travels = [0.1, 0.2]\nexpression = "2*sine(x)"',
        "[load.gas] expression",
        'column 3: there is no "sine"',
    ),
    "expression and force": (
        GAS + 'force = 3\nexpression = "2*x"\ntravels = [0, 1]',
        "[load.gas] force",
        "exclude each other",
    ),
    "no range": (GAS + 'expression = "2*x"', "[load.gas] travels", "needs the range"),
    "other range": (
        GAS + 'expression = "2*x"\ntimes = [0, 1]',
        "[load.gas] times",
        "goes over travels, not over times",
    ),
    "range of three": (
        GAS + 'expression = "2*x"\ntravels = [0, 1, 2]',
        "[load.gas] travels",
        "its first and its last place",
    ),
    "pole": (
        GAS + 'expression = "1/x"\ntravels = [-1, 1]',
        "[load.gas] expression",
        "no finite value at x = 0",
    ),
    "back of time": (
        GAS + 'expression = "2*t"\ntimes = [0, 1]\nexpression_back = "x"',
        "[load.gas] expression_back",
        "only an expression of x",
    ),
    "open period": (
        GAS + 'expression = "2*t"\ntimes = [0, 1]\nrepeat = true',
        "[load.gas] expression",
        "and ends at 2",
    ),
    "no guide for travels": (
        '[load.p]\nat = "rod.end"\nforce = [1, 0]\ntravels = [0, 1]\nfactors = [0, 1]',
        "[load.p] slider",
        "needs a joint with a guide",
    ),
    "no such crank": (
        '[load.p]\nat = "rod.end"\nangles = [0, 1]\nfactors = [0, 1]\ncrank = "krank"',
        "[load.p] crank",
        "there is no body",
    ),
}


@pytest.mark.parametrize("name", FAULTS)
def test_a_fault_of_a_load_is_told(name):
    text, where, what = FAULTS[name]
    with pytest.raises(ModelError) as told:
        loads(MODEL + text)
    assert where in str(told.value) and what in str(told.value), str(told.value)
    assert str(told.value).count("\n") <= 4, "one fault, one sentence or two"


def test_an_angle_without_a_crank_is_told():
    with pytest.raises(ModelError, match="no driver turns a body"):
        loads(
            MODEL.replace('[driver.crank]\nspeed = "600 rpm"\n', "")
            + '[load.p]\nat = "rod.end"\nangles = [0, 1]\nfactors = [0, 1]\n'
        )


def test_a_moving_guide_whose_journal_turns_is_told():
    text = MODEL.replace(
        'kind = "slider"\nbearing = "ground.O"', 'kind = "slider"\nturning = true\nbearing = "crank.start"'
    )
    with pytest.raises(ModelError, match="does not turn with it"):
        loads(text + GAS + "force = 3\n")


def test_loads_are_read_and_written():
    m = loads(
        MODEL
        + GAS
        + TABLE
        + 'pressure = ["1 bar", "5 bar"]\npressure_back = [1e5, 5e5]\nbore = "50 mm"\nambient = "1'
        ' bar"\nreverse = true\n[load.p]\nat = "rod.end"\nforce = ["1 kN", 0]\nangles = ["0 deg", "90 deg",'
        ' "360 deg"]\nfactors = [0, 1, 0]\nzero_angle = "10 deg"\ninterpolation = "linear"\nrepeat = true\n'
    )
    gas, p = m.loads["gas"], m.loads["p"]
    assert isinstance(gas, GuideForce) and isinstance(p, PointForce)
    assert (gas.travels, gas.pressure_back, gas.values) == ((0.15, 0.25), (1e5, 5e5), (0.0, 4e5))
    assert (
        gas.unit == pytest.approx(-1.9634954e-3)
        and p.repeats
        and p.argument == "angle"
        and gas.argument == "travel"
    )
    assert loads(dump(m)) == m


def test_places_that_do_not_ascend_are_told_once_for_both_ways():
    with pytest.raises(ModelError, match="must ascend") as told:
        loads(MODEL + GAS + "travels = [1, 0]\nforce = [1, 2]\nforce_back = [1, 2]\n")
    assert len(told.value.faults) == 1
