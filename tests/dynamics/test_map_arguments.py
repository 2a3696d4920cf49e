"""Arguments of maps: quantities with units, and a sentence for what is none."""

import pytest

from dynamics.test_maps import oscillator
from vfife.dynamics.bifurcation import bifurcation
from vfife.dynamics.sections import poincare_section
from vfife.errors import ModelError

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
