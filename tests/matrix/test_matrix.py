"""The same answers on every machine, from the commands of a user: a few examples under two settings, and all
of them against kept answers.

``make matrix`` has every example under every setting, and says of each that differs which quantity does
first.
"""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from matrix import commands, libraries
from matrix.differences import Difference, differences, unlike
from matrix.matrix import KEPT, compacted
from matrix.settings import KERNELS, Setting, answers, carried_out, settings

# Of each kind of start one: closed, statically determined, hung, an impact at once, a static analysis; and
# commands made of many runs.
FEW = [
    "compressor",
    "slider_crank_loose_guide",
    "scissor_lift",
    "block_on_incline",
    "williams_toggle",
    "sensitivity",
    "study",
]
UNLIKE = (f"BLAS kernel {KERNELS[1]},", "other libraries")


@pytest.fixture(scope="module")
def base(tmp_path_factory):
    """What this machine answers to all commands."""
    folder = tmp_path_factory.mktemp("here")
    return answers(carried_out(settings()[0], folder), folder)


@pytest.mark.verify  # .ci/run has all examples under all settings: make matrix
@pytest.mark.parametrize(
    "setting", [one for one in settings() if one.name.startswith(UNLIKE)], ids=lambda one: one.name
)
def test_a_few_examples_answer_the_same_elsewhere(setting: Setting, base, tmp_path):
    """Another kernel of BLAS, NumPy and the C library without their wide instructions; and libraries that
    round everything otherwise.
    """
    found = answers(carried_out(setting, tmp_path, FEW), tmp_path)
    assert len(found) >= len(FEW)
    here = {name: base[name] for name in found}
    assert [str(one) for one in differences(here, found)] == []


@pytest.mark.verify  # .ci/run: make matrix compares these before it goes on to other settings
def test_all_examples_answer_as_kept(base):
    """The answers of all commands, as they were taken on another machine, with other versions of NumPy:
    ``make golden`` takes them anew.
    """
    kept = json.loads(KEPT.read_text())
    assert [str(one) for one in differences(kept, compacted(base))] == []


@pytest.mark.system("imports what the commands use")
def test_commands_cover_every_example():
    names = set(commands.commands(Path("x")))
    assert {f"run {name}" for name in commands.examples()} | {
        f"check {name}" for name in commands.examples()
    } <= names
    assert len(commands.examples()) >= 23


def test_the_first_difference_is_named():
    here = {
        "run a": {
            "exit": 0,
            "printed": {"measures/x": 1.0, "measures/y": 2.0},
            "rows": {"p[0]": "ab", "q[0]": "cd"},
        }
    }
    there = json.loads(json.dumps(here))
    assert list(differences(here, there)) == []
    there["run a"]["printed"]["measures/y"] = np.nextafter(2.0, 3.0)
    assert [one.quantity for one in differences(here, there)] == ["measures/y"]
    there["run a"]["rows"]["q[0]"] = "ce"
    assert list(differences(here, there)) == [Difference("run a", "row q[0]", "cd", "ce", 2)]
    assert [one.quantity for one in differences(here, {})] == ["answer"]


def test_signs_of_zeros_and_last_bits_count():
    assert unlike([0.0, 1.0, 2.0], [-0.0, 1.0, np.nextafter(2.0, 3.0)]).tolist() == [True, False, True]


def test_what_clocks_say_is_left_out():
    assert commands.flat({"a": [1.5, {"wall_s": 2.0, "b": "c"}], "estimate": {"seconds": 3.0}}) == {
        "a/0": 1.5,
        "a/1/b": "c",
    }


def test_other_libraries_differ_in_the_last_bit_only():
    sine, pair = libraries.higher(np.sin), libraries.higher(lambda x: (x, 0.0))
    x = np.linspace(-3.0, 3.0, 101)
    assert (np.abs(sine(x) - np.sin(x)) <= np.spacing(np.abs(np.sin(x)))).all() and (
        sine(x) != np.sin(x)
    ).sum() == 100
    assert pair(1.0) == (np.nextafter(1.0, 2.0), 0.0)
