"""A step that does not divide a turn into the requested outputs is answered with the number that results and
the step that has the requested one; an automatic step always has it.
"""

from __future__ import annotations

import dataclasses
import re
from typing import Any

import pytest

import vfife
from vfife import gallery
from vfife.assembly.assemble import assemble
from vfife.errors import StepError
from vfife.model.functions import turn_of

TURN = 0.1  # s


def crank(**settings: Any) -> vfife.Mechanism:
    m = vfife.Mechanism("crank")
    link = m.link("crank", length="50 mm", mass="0.1 kg")
    m.revolute("main", m.point("O", 0.0, 0.0), link.start)
    m.drive(link, speed="600 rpm")
    m.settings = dataclasses.replace(m.settings, **settings)
    return m


def notes(**options: Any) -> list[str]:
    result = vfife.simulate(crank(), turns=1, companions=0, **options)
    return list(result.summary["run"]["notes"])


@pytest.mark.parametrize(
    ("step", "words"),
    [
        ("20 us", r"gives (500|625) outputs a turn instead of 720: a turn is 5000 steps"),
        (1.3e-5, r"gives \d+\.\d+ outputs a turn instead of 720, at other angles in each turn"),
    ],
)
def test_other_outputs_than_requested_are_named(step: Any, words: str) -> None:
    (note,) = notes(outputs=720, step=step)
    assert re.search(words, note)
    remedy = re.search(r"take a step of (\S+) s", note)
    assert remedy is not None
    assert not notes(outputs=720, step=float(remedy[1]))
    result = vfife.simulate(crank(), turns=2, companions=0, outputs=720, step=float(remedy[1]))
    assert len(result.time) == 1441 and result.time[720] == pytest.approx(TURN, rel=1e-12)
    assert result.time[1] - result.time[0] <= TURN / 720 * (1 + 1e-9)


def test_outputs_that_fit_are_not_cautioned() -> None:
    assert not notes(outputs=500, step="20 us") and not notes(outputs=720) and not notes(step="20 us")


def test_the_answer_and_check_name_it() -> None:
    model = crank(outputs=700, step=2e-5)
    assert "625 outputs a turn instead of 700" in " ".join(str(model.check()).split())
    result = vfife.simulate(model, turns=1, companions=0)
    assert "625 outputs a turn instead of 700" in " ".join(str(result).split())


def test_a_tiny_step_that_divides_a_turn_divides_it() -> None:
    """A turn of 1e8 steps has whole outputs, a turn of a prime number of them has none."""
    assembly = assemble(crank(), TURN / 10**8, turns=2)
    outputs = TURN / (assembly.choice.step * assembly.choice.outputs_every)
    assert 360 < outputs < 1440 and outputs == pytest.approx(round(outputs), rel=1e-12)
    assert not assembly.notes
    (note,) = assemble(crank(), TURN / 99_999_989, turns=2).notes
    assert "divides a turn into 99,999,989 steps, but these into no whole number of outputs" in note


@pytest.mark.parametrize(
    ("length", "words"),
    [
        ({"turns": 2}, r"after 2\.\d+ turns instead of 2:"),
        ({"turns": 0.5}, r"after 0\.50\d+ turns instead of 0\.5:"),
        ({"duration": 0.03}, r"after 0\.30\d+ turns instead of 0\.3:"),
    ],
)
def test_a_run_that_is_longer_than_requested_says_so(length: dict[str, float], words: str) -> None:
    (note,) = assemble(crank(), 1.3e-5, **length).notes
    assert re.search(words, note) and "means over the run" in note
    assert not assemble(crank(), 1.25e-5, **length).notes
    automatic = assemble(crank(), None, **length)
    assert not assemble(crank(), automatic.choice.step / 4, force_step=True, **length).notes


def test_a_step_just_too_large_is_told_from_the_limit() -> None:
    model = gallery.jansen_leg()
    turn = turn_of(model)
    assert turn is not None
    with pytest.raises(StepError) as refusal:
        assemble(model, turn / 117, turns=1)
    size, largest = re.search(r"a step of (\S+) s .* of it \((\S+) s\)", str(refusal.value)).groups()
    assert float(size) > float(largest)
