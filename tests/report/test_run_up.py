"""A motor that starts its machine from rest: what a run states whose values include the run-up, and what one
that goes on from its end, or in which the motor turns nothing.
"""

from __future__ import annotations

import dataclasses
import json
from functools import cache
from typing import Any

import pytest

import vfife
from model_texts import FALLING, FLYWHEEL
from vfife.modelfile import loads
from vfife.report.document import Paragraph, Table
from vfife.report.front import conclusion, front_page, without_options
from vfife.report.overview import certainty, heading_sentence
from vfife.report.run import document
from vfife.report.run_file import side_by_side
from vfife.report.run_up import run_up_note
from vfife.report.terminal import as_text

RUN_UP = "Forces, knocks and friction include the run-up of wheel from rest."


@cache
def wheel(duration: str = "12 s") -> vfife.Result:
    """A flywheel that reaches 99 % of its speed in twelve seconds."""
    return vfife.simulate(loads(FLYWHEEL.format(run=f'duration = "{duration}"', driver=FALLING)))


@cache
def operation() -> vfife.Result:
    """The same flywheel, on from there."""
    return vfife.simulate(wheel().record.assembly.mechanism, duration=1.0, start=wheel())


def titles(summary: dict[str, Any]) -> list[str]:
    """The titles of the tables of a report's first page."""
    return [part.title for part in front_page(summary, None).parts if isinstance(part, Table)]


def test_a_run_up_from_rest_is_said_before_its_values() -> None:
    """In the head, the table and the cautions of the answer, and first in the conclusion of the report."""
    summary = wheel().summary
    assert heading_sentence(summary).endswith("values of the whole run with the run-up")
    assert RUN_UP in certainty(summary) and RUN_UP in conclusion(summary)[0]
    assert titles(summary) == ["Whole run, with the run-up"]
    long = document(summary)
    leads = [part.text for part in long.parts[:3] if isinstance(part, Paragraph)]
    assert summary["warnings"][0] in leads and as_text(long, 200).count(RUN_UP) == 1
    assert summary["warnings"][0] == f"{RUN_UP} The machine in operation: vfife run MODEL --start-from RUN."
    assert "operation is in a run that starts from its end." in without_options(summary["warnings"][0])


def test_a_machine_in_operation_has_none() -> None:
    summary = operation().summary
    assert summary["efforts"]["wheel"]["start"] == pytest.approx(
        wheel().summary["run"]["reached"]["wheel"]["end"]
    )
    assert "run-up" not in json.dumps(summary["warnings"]) + str(operation())
    assert titles(summary) == [""]
    assert not any("run-up" in text for text in conclusion(summary))


def test_a_run_that_goes_on_from_a_slow_one_states_its_speed() -> None:
    """After 1 s the wheel turns at 50 rad/s (1 - exp(-0.4)) = 157.4 rpm."""
    slow = wheel("1 s")
    summary = vfife.simulate(slow.record.assembly.mechanism, duration=8.0, start=slow).summary
    assert "include the run-up of wheel from about 157 rpm" in certainty(summary)


def test_changes_between_a_run_up_and_operation_are_named() -> None:
    summaries = {"up": wheel().summary, "on": operation().summary}
    text = " ".join(as_text(side_by_side(summaries), 200).split())
    note = "friction of up include the run-up of a motor: their changes against a run without one"
    assert text.count(note) == 2
    assert not run_up_note({"on": summaries["on"]}) and not run_up_note({"up": summaries["up"]})


def test_runs_of_motors_have_rows_of_power_torque_and_speed() -> None:
    """By the figures of the answers, with the change of each, and the part of the run."""
    summaries = {"up": wheel().summary, "on": operation().summary}
    document = side_by_side(summaries)
    table = next(part for part in document.parts if getattr(part, "title", "").startswith("Knocks"))
    rows = {row[0]: row[1:] for row in table.rows}
    old, new = (summary["efforts"]["wheel"]["high"]["value"] for summary in summaries.values())
    assert rows["wheel, largest speed"][0].startswith(f"{old:.4g} rad/s")
    assert float(rows["wheel, largest speed"][2].split()[0]) == pytest.approx(
        100.0 * (new / old - 1.0), abs=0.01
    )
    assert "turns of wheel, " in rows["wheel, part"][0]
    assert " to 12 s, while kinetic energy takes " in rows["wheel, part"][0]
    assert {"wheel, mean power", "wheel, rms torque", "wheel, largest torque", "wheel, least speed"} <= set(
        rows
    )
    assert document.data["runs"]["on"]["efforts"] == summaries["on"]["efforts"]


def test_a_motor_that_turns_nothing_is_said_first() -> None:
    """In 0.2 s the wheel moves by 0.4 rad; a torque over time may mean that."""
    summary = wheel("0.2 s").summary
    words = "Driver wheel: no body is a whole turn on at the end of the run."
    assert certainty(summary).startswith(words) and conclusion(summary)[0].startswith(words)
    assert summary["warnings"][0].startswith(words) and "inverse ratio" in summary["warnings"][0]
    steady = loads(FLYWHEEL.format(run='duration = "0.2 s"', driver='torque = "2 N m"'))
    assert "no body" not in certainty(vfife.simulate(steady).summary)


PRESS = """
[run]
duration = "{duration}"
step = "0.5 ms"
outputs = 600
[ground]
O = [0, 0]
P = [1, 0]
[body.motor]
mass = "5 kg"
inertia = "0.05 kg m^2"
position = [0, 0]
[body.crank]
mass = "5 kg"
inertia = "2 kg m^2"
position = [1, 0]
[joint.O]
bearing = "ground.O"
journal = "motor.center"
[joint.P]
bearing = "ground.P"
journal = "crank.center"
[gear.reduction]
first = "motor"
second = "crank"
ratio = -0.05
[load.work]
at = "crank.center"
moment = "200 N m"
times = ["0.6 s", "0.8 s"]
factors = [1, {factor}]
[driver.motor]
interpolation = "linear"
torque = ["30 N m", 0]
speeds = [0, "160 rad/s"]
"""


@pytest.mark.parametrize(
    ("duration", "factor", "words"),
    [
        ("1.1 s", 1, "Driver motor: crank is only 0.69 of a turn on at the end of the run."),
        ("30 s", 3, "Driver motor: what it turns stands and crank is only 0.59 of a turn on at the end"),
        ("3 s", 1, RUN_UP.replace("wheel", "motor")),
    ],
)
def test_a_motor_whose_gears_turn_nothing_is_said_first(duration: str, factor: int, words: str) -> None:
    """The motor makes turns, its crank on a gear of 1:20 makes none, or the load stops both."""
    summary = vfife.simulate(loads(PRESS.format(duration=duration, factor=factor))).summary
    assert summary["efforts"]["motor"]["turns"] >= 1
    assert certainty(summary).startswith(words)


def test_a_jump_to_another_clearance_has_a_caution() -> None:
    """Of the joints whose clearance differs; none where it is the same."""
    model = vfife.gallery.four_bar_case_c()
    first = vfife.simulate(model, turns=0.05, companions=0, reference=False)

    def warnings(mechanism: vfife.Mechanism) -> str:
        options = {"turns": 0.05, "companions": 0, "reference": False}
        return " ".join(vfife.simulate(mechanism, start=first, **options).summary["warnings"])

    name = next(iter(model.clearances))
    joint = model.joints[name]
    wider = dataclasses.replace(
        model, joints={**model.joints, name: dataclasses.replace(joint, clearance=1.5 * joint.clearance)}
    )
    text = f"The clearance of {name} is not that of the run from which this one goes on"
    assert text in warnings(wider) and "is not that of the run" not in warnings(model)


def test_files_without_the_speed_at_the_start_are_read() -> None:
    """Summaries of former versions have efforts without it."""
    summary = dict(wheel().summary)
    summary["efforts"] = {"wheel": {k: v for k, v in summary["efforts"]["wheel"].items() if k != "start"}}
    assert "run-up" not in certainty(summary)
