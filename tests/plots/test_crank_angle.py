"""One crank angle, 0 to 360 degrees of the crank itself, in data, tables, figures, films and pages."""

import math

import numpy as np
import pytest

import vfife
from live.pages import needs_node, page_of, run_by_node
from support import four_bar
from vfife.measures.motion import within_turn
from vfife.plots import figures
from vfife.plots.film import Film
from vfife.simulation.result import Result

START = 100.3  # degrees
PER_TURN = 360
JOINT = "C"


def run(mirrored: bool) -> Result:
    mechanism = four_bar("C", crank_angle=math.radians(START), mirrored=mirrored, speed=2.0 * math.pi)
    return vfife.simulate(mechanism, turns=2.0, outputs=PER_TURN, companions=0, loop="data-driven")


@pytest.mark.parametrize("mirrored", [False, True])
def test_one_peak_lies_at_one_angle_in_all_outputs(mirrored: bool) -> None:
    result = run(mirrored)
    force = result.channels["joint_force_max"].values[
        :, list(result.record.assembly.mechanism.joints).index(JOINT)
    ]
    k = PER_TURN + 1 + int(np.argmax(force[PER_TURN + 1 :]))
    angle = (
        math.degrees(result.record.block("particle_theta")[k, result.record.assembly.topology.driven[0]])
        % 360.0
    )  # by hand
    sense = -1.0 if mirrored else 1.0
    assert angle == pytest.approx((sense * (START + k)) % 360.0, abs=1e-6)

    assert float(result.data.crank_angle[k]) == pytest.approx(angle)
    assert result.to_dataframe()["crank_angle [deg]"].iloc[k] == pytest.approx(angle)
    turn = result.turns.joint_force_max.sel(joint=JOINT).isel(turn=-1)
    assert float(turn.crank_angle[int(np.argmax(turn.values))]) == pytest.approx(angle)
    assert np.all(np.diff(result.turns.crank_angle) > 0.0) and float(result.turns.crank_angle[-1]) < 360.0

    ax = next(
        ax for ax in figures(result, names=["forces"])["forces"].axes if JOINT in ax.get_title(loc="left")
    )
    peak = next(line for line in ax.lines if line.get_label() == "peak that is reported")
    x, y = peak.get_xdata(), peak.get_ydata()
    assert x[np.nanargmax(y)] == pytest.approx(angle) and ax.get_xlim() == (0.0, 360.0)
    panel = next(
        one for one in Film(result, None, 12, 1.0, 40.0).curves if JOINT in one.ax.get_title(loc="left")
    )
    x, y = panel.ax.lines[0].get_data()
    assert x[np.nanargmax(y)] == pytest.approx(angle) and panel.ax.get_xlim() == (0.0, 360.0)

    moments = {float(time): at for time, at in zip(result.time, result.crank_angle, strict=True)}
    assert result.impacts.entries
    for entry in result.impacts.entries:
        assert entry.crank == pytest.approx(moments[entry.time]) and 0.0 <= entry.crank < 360.0


@needs_node
@pytest.mark.system("runs the page's numbers beside Python's")
@pytest.mark.parametrize("mirrored", [False, True])
def test_a_page_has_the_angles_of_python(mirrored: bool, tmp_path) -> None:
    result = run(mirrored)
    body = """
    const setting = new Setting();
    const reader = new Reader(own, setting.part("state"), setting);
    const turns = Array.from({ length: 500 }, (_, k) => withinTurn(reader.rotation(k / given.perTurn)));
    const over = overTurn([350, 355, 365, 372], [0, 1, 3, 5]);
    return { turns, over: over.map((list) => list.map((one) => String(Math.round(one)))) };
    """
    found = run_by_node(page_of(result.record.assembly.mechanism), body, tmp_path)
    # a page has outputs of its own: as many as the model says
    rotation = math.degrees(
        result.record.block("particle_theta")[0, result.record.assembly.topology.driven[0]]
    )
    per_turn = round(result.record.assembly.mechanism.settings.outputs or 1000)
    sense = -1.0 if mirrored else 1.0
    assert found["turns"] == pytest.approx(
        within_turn(rotation + sense * 360.0 * np.arange(500) / per_turn), abs=1e-6
    )
    assert found["over"] == [
        ["350", "355", "360", "360", "0", "5", "12"],
        ["0", "1", "2", "NaN", "2", "3", "5"],
    ]
