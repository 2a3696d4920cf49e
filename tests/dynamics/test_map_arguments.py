"""Arguments of maps: quantities with units, and a sentence for what is none."""

import signal
import sys

import numpy as np
import pytest

import vfife
from dynamics.test_maps import oscillator
from vfife import gallery
from vfife.dynamics.basins import basins
from vfife.dynamics.bifurcation import bifurcation
from vfife.dynamics.sections import poincare_section
from vfife.dynamics.waterfall import waterfall
from vfife.errors import ModelError
from vfife.modelfile import dump, loads
from vfife.report.html import text

PATH = "spring.spring.damping"
QUICK = {"count": 2, "turns": 4, "dropped": 2, "step": 2e-4, "series": ["block.x"], "companions": 0}


def test_ends_of_a_sweep_are_quantities():
    """Texts with a unit and numbers in SI units give the same values."""
    written = bifurcation(oscillator(), PATH, "1000 N s/km", "0.002 kN s/m", **QUICK)
    assert written.spec.values == bifurcation(oscillator(), PATH, 1.0, 2.0, **QUICK).spec.values == (1.0, 2.0)


@pytest.mark.parametrize(
    ("arguments", "expected"),
    [
        ({"turns": "10"}, r'turns = "10": this is a text'),
        ({"turns": 10.5}, "turns = 10.5: this is a number"),
        ({"dropped": "3"}, r'dropped = "3": this is a text'),
        ({"dropped": -1}, "dropped = -1: this is too small"),
        ({"phase": "late"}, r'phase = "late": this is a text'),
        ({"phase": 1.5}, "phase = 1.5: this is too large"),
    ],
)
def test_faults_of_a_section_are_sentences(arguments, expected):
    with pytest.raises(ModelError, match=rf"poincare_section\(\), {expected}"):
        poincare_section(oscillator(), **arguments)


@pytest.mark.parametrize(
    ("low", "high", "expected"),
    [(1.0, None, "high = None: a value is missing"), ("1 mm", 2.0, 'low = "1 mm": this is a length')],
)
def test_faults_of_ends_are_sentences(low, high, expected):
    with pytest.raises(ModelError, match=rf"bifurcation\(\), {expected}"):
        bifurcation(oscillator(), PATH, low, high, **QUICK)


@pytest.mark.parametrize("function", [bifurcation, waterfall])
def test_a_range_without_extent_is_refused(function):
    sentence = rf"{function.__name__}\(\), high = .1 N s/m.: {PATH} has the same value at both ends"
    with pytest.raises(ModelError, match=sentence):
        function(oscillator(), PATH, "1 N s/m", "1 N s/m", count=2)
    with pytest.raises(ModelError, match=r"basins\(\), high = 1.0: .* has the same value at both ends"):
        basins(oscillator(), (PATH, 1.0, 1.0), AXES[0], count=2, **QUICK_GRID)


def test_a_sweep_of_a_single_value_has_an_exponent():
    """The difference that is followed is a share of the value, because there is no range."""
    single = bifurcation(oscillator(), PATH, 1.0, 1.0, **QUICK | {"count": 1})
    several = bifurcation(oscillator(), PATH, 1.0, 2.0, **QUICK)
    assert np.allclose(single.exponents[0, 0], several.exponents[0, 0], rtol=1e-3)


AXES = ("driver.crank.speed", 8.0, 10.0), (PATH, 1.0, 2.0)
SPECTRUM = {"count": 2, "turns": 4, "step": 2e-4, "series": ["block.x"], "outputs": 36, "highest": 10.0}
# None stands for the default, and so many turns, orders or companions there may be.
LEGAL = {("companions", 3), ("file", None), ("last", None), ("last", 3), ("outputs", 3), ("highest", 3)}
QUICK_GRID = QUICK | {"companions": 0, "exponents": False}
del QUICK_GRID["count"]


def test_one_count_of_basins_is_that_of_both_axes():
    single, pair = (basins(oscillator(), *AXES, count=count, **QUICK_GRID) for count in (2, (2, 2)))
    assert single.spec == pair.spec and single.done == 4


@pytest.mark.parametrize(
    ("arguments", "expected"),
    [
        ({"count": "4"}, r'count = "4": this is a text'),
        ({"count": 2.5}, r"count = 2.5: this is a number"),
        ({"count": (2,)}, r"count = \[2\]: these are 1 numbers"),
        ({"count": (2, 2, 2)}, "these are 3 numbers"),
        ({"companions": None}, "companions = None: a value is missing"),
        ({"x": ()}, "x = .*this is no axis"),
        ({"x": (PATH, 1.0)}, "x = .*this is no axis"),
        ({"y": (1, 2, 3)}, "y = .*this is no axis"),
    ],
)
def test_faults_of_basins_are_sentences(arguments, expected):
    given = {"x": AXES[0], "y": AXES[1], "count": (2, 2)} | QUICK_GRID | arguments
    with pytest.raises(ModelError, match=rf"(?s)basins\(\).*{expected}"):
        basins(oscillator(), **given)


@pytest.mark.parametrize("value", [None, 3, object(), [None]])
def test_what_is_no_name_file_or_number_is_named_by_every_map(value):
    """Whatever the type, a sentence names the argument; None leaves out what may be left out."""
    sweep = {"path": PATH, "low": 1.0, "high": 2.0}
    calls = [
        (bifurcation, "series", sweep | QUICK), (bifurcation, "companions", sweep | QUICK),
        (bifurcation, "starts", sweep | QUICK), (bifurcation, "file", sweep | QUICK),
        (poincare_section, "joints", {"turns": 4}), (poincare_section, "series", {"turns": 4}),
        (waterfall, "last", sweep | SPECTRUM), (waterfall, "outputs", sweep | SPECTRUM),
        (waterfall, "highest", sweep | SPECTRUM), (waterfall, "window", sweep | SPECTRUM),
    ]  # fmt: skip
    for function, name, arguments in calls:
        if any(name == legal and value == number for legal, number in LEGAL):
            continue
        with pytest.raises(ModelError, match=rf"(?:{function.__name__}\(\)|oscillator), {name}"):
            function(oscillator(), **(arguments | {name: value}))


def test_a_single_recorded_turn_has_no_kind_that_a_rotation_tells():
    arguments = QUICK | {"dropped": 3, "companions": 1}
    diagram = bifurcation(oscillator(), PATH, 1.0, 2.0, **arguments)
    assert diagram.done == diagram.planned and "not settled" in " ".join(str(diagram).split())


@pytest.mark.parametrize(
    ("function", "arguments"),
    [
        (bifurcation, (PATH, 1.0, 2.0)),
        (poincare_section, ()),
        (basins, AXES),
        (waterfall, ("driver.crank.speed", 8.0, 10.0)),
    ],
)
def test_ctrl_c_while_the_step_is_looked_for_is_named(monkeypatch, function, arguments):
    """Nothing is computed yet that the function could return; a caller sees what was interrupted."""
    for name in ("simulation.turn_steps", "dynamics.waterfall"):
        module = sys.modules[f"vfife.{name}"]
        monkeypatch.setattr(module, "prepare", lambda *_, **__: signal.raise_signal(signal.SIGINT))
    monkeypatch.setattr("vfife.simulation.turn_steps.COUNTS", {})
    former = signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        with pytest.raises(
            KeyboardInterrupt, match=rf"{function.__name__}\(\) was interrupted before it had"
        ):
            function(oscillator(), *arguments)
    finally:
        signal.signal(signal.SIGINT, former)


def test_basins_vary_a_velocity_that_the_model_leaves_at_zero():
    """A list is no number: the sentence names its elements, which are."""
    axes = ("body.block.velocity.0", -0.1, 0.1), ("body.block.position.0", "0 mm", "1 mm")
    found = basins(oscillator(), *axes, count=2, **QUICK_GRID)
    first, last = (found.points[k][-1, 0] for k in (0, 3))
    assert found.done == 4 and first != last
    with pytest.raises(ModelError, match=r"body\.block\.velocity: .* \"body\.block\.velocity\.0\""):
        basins(oscillator(), ("body.block.velocity", -0.1, 0.1), axes[1], count=2, **QUICK_GRID)


def test_a_number_that_the_kind_of_joint_or_driver_lacks_is_not_suggested():
    """An ideal joint has no clearance, and a driver with a speed has no frequency of a harmonic motion."""
    machine = gallery.slider_crank_loose_pin()
    for path in ("clearance", "joint.*.clearance"):
        with pytest.raises(ModelError, match=r'did you mean "joint\.pin\.clearance"\?') as refused:
            bifurcation(machine, path, "0.1 mm", "0.2 mm")
        assert "joint.O.clearance" not in str(refused.value) and "list the paths" not in str(refused.value)
    sentence = r"that of crank has speed.*[dD]id you mean .driver\.crank\.speed."
    for ends in (("1 mm", "2 mm"), ("1 Hz", "2 Hz")):
        with pytest.raises(ModelError, match=sentence):
            bifurcation(machine, "driver.crank.frequency", *ends)
    with pytest.raises(ModelError, match=sentence):
        vfife.study(machine, {"driver.crank.frequency": ["1 Hz", "2 Hz"]}, "pin.force.max", turns=1)
    with pytest.raises(ModelError, match=r"[Dd]id you mean") as unknown:
        loads(dump(machine), set=[("joint.O.clearence", 1e-4)])
    assert "joint.O.clearance" not in str(unknown.value)


def test_a_range_from_its_upper_end_begins_on_the_way_down():
    down = bifurcation(oscillator(), PATH, 2.0, 1.0, **QUICK)
    up = bifurcation(oscillator(), PATH, 1.0, 2.0, **QUICK)
    assert down.spec.ways == up.spec.ways[::-1] == ("down", "up")
    assert [row[:2] for row in down.table()][1] == [2.0, "down"]
    assert "from 1 N s/m to 2 N s/m" in text(down) and "from 2 N s/m" not in text(down)
    assert down.spells(0)[0].first == up.spells(0)[0].first == 1.0
