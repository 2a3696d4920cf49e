"""A study of short runs takes what its members take beside their steps: forecast by steps alone it was told a seventeenth of its time."""

import dataclasses
import re

from cli.models import ROOT
from vfife import load
from vfife.assembly.assemble import assemble
from vfife.cli.forecast import expected, one_by_one
from vfife.study.member import streams
from vfife.study.plan import Asked

ASKED = Asked("slider_crank.toml", ("O.force.max",), turns=1)


def test_members_take_time_beside_their_steps(tmp_path):
    base = load(ROOT / "examples" / "slider_crank.toml")
    seconds = [expected([{}], left, 0, base, ASKED, tmp_path / "s.study")["seconds"] for left in (0, 100, 10_000)]
    assert seconds[0] == 0.0 and 1.0 < seconds[1] < 20.0, "ten to a hundred members in a second are what is measured, whatever the steps"
    assert abs(seconds[2] - 100.0 * seconds[1]) < 1e-9 * seconds[2]


def test_a_step_that_goes_into_no_lanes_is_told_with_one_that_does(tmp_path):
    base = load(ROOT / "examples" / "slider_crank.toml")
    auto = expected([{}], 10, 0, base, ASKED, tmp_path / "s.study")
    turn = assemble(base, turns=1.0).choice.turn
    asked = dataclasses.replace(ASKED, step=turn / 1234.5)
    found = expected([{}], 10, 0, base, asked, tmp_path / "s.study")
    assert abs(found["steps"] - 1234) < 10 and found["lanes"] == 1 < auto["lanes"] and not auto["turns"]
    said = one_by_one(found["turns"], asked)
    fitting = re.search(r'step = "(\S+) s"', said)
    assert fitting is not None and not streams(assemble(base, asked.step, turns=1.0))
    assert float(fitting[1]) <= asked.step and streams(assemble(base, float(fitting[1]), turns=1.0))
