"""A fault: one type from where a value is read to what a user sees."""

from __future__ import annotations

import pickle
import re

import pytest

from vfife.errors import Fault
from vfife.results.parameters import Varied
from vfife.units import number


def test_a_fault_has_its_place_in_keys_and_words() -> None:
    fault = Fault(("joint", "C", "clearance"), "this is negative", "-1", "above 0 m", "correct the value")
    assert (fault.path, fault.where) == (("joint", "C", "clearance"), "[joint.C] clearance")
    assert str(fault) == "[joint.C] clearance = -1: this is negative; allowed: above 0 m. Correct the value."


def test_a_fault_without_a_place_is_told_by_its_value() -> None:
    fault = Fault("", "this is negative", "-1", "above 0 m", "correct the value")
    assert str(fault) == "-1: this is negative; allowed: above 0 m. Correct the value."
    placed = fault.at(("run", "turns"), overrides={("run", "turns")})
    assert (placed.where, placed.what, placed.value) == ("[run] turns (given by set)", fault.what, "-1")
    assert (
        fault.at("--turns", value="2").value == "-1"
        and Fault("", "missing").at("--turns", value="2").value == "2"
    )


def test_a_fault_is_a_value_that_is_kept_between_processes() -> None:
    fault = Fault("", "this is negative", "-1").at(("run", "turns"))
    again = pickle.loads(pickle.dumps(fault))
    assert (
        again == fault
        and hash(again) == hash(fault)
        and (again.where, again.path) == (fault.where, fault.path)
    )
    assert fault != Fault("", "this is negative", "-1")


def test_a_fault_that_ends_with_a_question_has_no_full_stop() -> None:
    assert str(Fault("path", "did you mean this?")) == "path: did you mean this?"
    assert str(Fault("path", "too large", "2")) == "path = 2: too large."


@pytest.mark.parametrize(
    ("text", "unit", "hint"),
    [
        ("2.2 kNm", "N m", 'write it with a space, "kN m"'),
        ("2200 Nmm", "N m", 'write it with a space, "N mm"'),
        ("960 upm", "rad/s", 'write revolutions per minute as "rpm"'),
    ],
)
def test_a_unit_of_a_catalogue_has_its_spelling_in_the_message(text: str, unit: str, hint: str) -> None:
    with pytest.raises(Fault, match=re.escape(hint)):
        number(text, unit)


def test_a_number_of_a_study_comes_back_in_the_unit_in_which_it_is_written() -> None:
    for unit, si in (("rpm", "rad/s"), ("mm", "m"), ("deg", "rad"), ("um", "m")):
        varied = Varied("x", (), si, "values", written=unit)
        for digits in (*range(1, 1000), 0.1, 0.3, 12.7, 199.9):
            assert varied.in_written_unit(number(f"{digits} {unit}", si)) == digits
