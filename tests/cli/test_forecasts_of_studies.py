"""A study of short runs takes what its cases take beside their steps; forecasts count the work that is then
done.
"""

from __future__ import annotations

import dataclasses
import re
from pathlib import Path

import pytest

from cli.models import ROOT
from vfife import load
from vfife.assembly.assemble import assemble
from vfife.job.cost import Stream, cores
from vfife.studies.engine.lanes import streams
from vfife.studies.forecast import CasesLeft, remark_on_step
from vfife.studies.spec.plan import Plan, StudySpec

ASKED = StudySpec("slider_crank.toml", ("O.force.max",), turns=1)
BASE = load(ROOT / "examples" / "slider_crank.toml")
PLAN = Plan("s", BASE, ASKED, ())


def test_cases_take_time_beside_their_steps(tmp_path: Path) -> None:
    seconds = [CasesLeft(PLAN, [{}], left, 0).forecast().seconds for left in (0, 40, 100)]
    assert seconds[0] == 0.0 and 0.05 < seconds[1] < 20.0, (
        "ten to a hundred cases in a second are what is measured, whatever the steps"
    )
    assert Stream(0.03, 0.1).seconds(100) == pytest.approx(100 * max(0.03, 0.13 / cores()))


def test_a_step_that_goes_into_no_lanes_is_told_with_one_that_does(tmp_path: Path) -> None:
    auto = CasesLeft(PLAN, [{}], 10, 0).forecast()
    turn = assemble(BASE, turns=1.0).choice.turn
    assert turn is not None
    asked = dataclasses.replace(ASKED, step=turn / 1234.5)
    found = CasesLeft(dataclasses.replace(PLAN, spec=asked), [{}], 10, 0).forecast()
    assert abs(found.steps - 1234) < 10 and found.lanes == 1 < auto.lanes and not auto.remarks
    (said,) = found.remarks
    assert said == remark_on_step({turn}, asked)
    fitting = re.search(r'step = "(\S+) s"', said)
    assert fitting is not None and not streams(assemble(BASE, asked.step, turns=1.0))
    assert float(fitting[1]) <= turn / 1234.5 and streams(assemble(BASE, float(fitting[1]), turns=1.0))
