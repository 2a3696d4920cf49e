"""What a reader sees: every body, names beside their pins, wheels that turn, one number format, bands and
vectors only where there is something to see.
"""

import re
from functools import cache
from pathlib import Path

import numpy as np
import pytest

import vfife
from vfife import gallery
from vfife.assembly.assemble import assemble
from vfife.model.joints import Gear
from vfife.plots import figures, motion
from vfife.plots.catalogue import available
from vfife.plots.drawing import clearest_output, drawing, least_visible, outlines_of
from vfife.plots.pose import _poses_of_a_turn, clear_pose
from vfife.results.run_data import standing
from vfife.simulation.result import Result

COMPRESSOR = Path(__file__).parents[2] / "examples" / "compressor.toml"
SIX = ["compressor", "scissor_lift", "six_bar_press", "jansen_leg", "gear_train", "quick_return"]


@cache
def run(name: str) -> Result:
    turns = {"turns": 1.0} if name in ("compressor", "six_bar_press", "jansen_leg") else {}
    return vfife.simulate(
        getattr(gallery, name)(), **turns, outputs=120, companions=0, loop="data-driven", reference=False
    )


def test_a_crank_at_its_dead_centre_is_drawn_elsewhere() -> None:
    result = run("compressor")
    outlines = outlines_of(result)
    shown = clearest_output(result, outlines)
    assert least_visible(outlines, 0) < 0.2 and least_visible(outlines, shown) > 0.6
    assert f"crank at {result.crank_angle[shown]:.4g}°" in drawing(result).get_suptitle()
    press = run("six_bar_press")
    assert clearest_output(press, outlines_of(press)) == 0


@pytest.mark.parametrize("speed", ["1450 rpm", "-1450 rpm"])
def test_a_mechanism_that_starts_at_a_dead_centre_is_drawn_elsewhere_before_any_run(speed: str) -> None:
    """The slider-crank formula places the piston: s = r cos a + sqrt(l² - r² sin² a) from the shaft."""
    compressor = vfife.load(COMPRESSOR, {"driver.crank.speed": speed})
    view, words = clear_pose(compressor)
    assert least_visible(outlines_of(view), 0) > 0.6 and "the start at 180° hides a body" in words
    assert words in compressor.plot().get_suptitle()
    angle = np.radians(float(view.crank_angle[0]))
    names = list(view.record.assembly.bodies)
    crank, rod = outlines_of(view)["crank"].path[0], outlines_of(view)["rod"].path[0]
    radius, length = (np.linalg.norm(np.diff(path[[0, -1]], axis=0)) for path in (crank, rod))
    assert crank[-1] == pytest.approx(rod[0], abs=1e-9)
    piston = view.channels["body_x"].values[0, names.index("piston")]
    expected = radius * np.cos(angle) + np.sqrt(length**2 - (radius * np.sin(angle)) ** 2)
    assert piston == pytest.approx(expected, abs=1e-9)
    press = gallery.six_bar_press()
    assert clear_pose(press)[1] == "at the start" and "at the start" in press.plot().get_suptitle()


def test_poses_of_a_turn_are_of_the_branch_of_the_start() -> None:
    """The four-bar is solved as its mirror image: from pose to pose no body turns by more than 60 degrees."""
    four_bar = gallery.four_bar()
    start = standing(assemble(four_bar))
    poses = [start, *_poses_of_a_turn(four_bar), start]
    angles = np.array([view.channels["body_angle"].values[0] for view in poses])
    changes = np.degrees((np.diff(angles, axis=0) + np.pi) % (2.0 * np.pi) - np.pi)
    assert len(poses) == 13 and np.abs(changes[:, list(start.record.assembly.bodies).index("crank")]) == (
        pytest.approx(30.0)
    )
    assert np.abs(changes).max() < 60.0


@pytest.mark.system("draws six mechanisms")
@pytest.mark.parametrize("name", SIX)
def test_names_of_joints_cover_neither_pins_nor_each_other(name: str) -> None:
    figure = drawing(run(name))
    ax, renderer = figure.axes[0], figure.canvas.get_renderer()
    boxes = {one.get_text(): one.get_window_extent(renderer) for one in ax.texts if one.get_text()}
    fixed = {joint for joint in boxes if any(word in joint for word in ("guide", "slot"))}
    pins = [line for line in ax.lines if line.get_marker() == "o" and line.get_zorder() >= 7]
    assert boxes and (pins or name == "gear_train")
    ground = [one.get_window_extent(renderer) for one in ax.patches if one.get_hatch()]
    for text, box in boxes.items():
        assert text in fixed or not [one for one in ground if box.overlaps(one)], text
    for line in pins:
        for at in ax.transData.transform(np.asarray(line.get_xydata(), dtype=float)):
            assert not [text for text, box in boxes.items() if text not in fixed and box.contains(*at)], at
    ordered = list(boxes.items())
    for k, (one, box) in enumerate(ordered):
        assert not [other for other, second in ordered[k + 1 :] if box.overlaps(second)], one


def test_wheels_of_a_gear_have_a_spoke_that_turns_with_them() -> None:
    result = run("gear_train")
    count = 2 * sum(isinstance(one, Gear) for one in result.record.assembly.mechanism.gears.values())
    for shown in (0, 40, 80):
        spokes = [line for line in drawing(result, shown).axes[0].lines if line.get_zorder() == 2.8]
        ways = [np.diff(np.asarray(line.get_xydata()), axis=0)[0] for line in spokes]
        drawn = sorted(float(np.degrees(np.arctan2(y, x))) % 360.0 for x, y in ways)
        angles = [
            np.degrees(
                result.channels["body_angle"].values[shown, list(result.record.assembly.bodies).index(b)]
            )
            for gear in result.record.assembly.mechanism.gears.values()
            for b in (gear.first, gear.second)
        ]
        assert len(spokes) == count and drawn == pytest.approx(sorted(a % 360.0 for a in angles), abs=1e-6)


def test_a_smooth_force_has_no_band_and_an_ideal_mechanism_no_envelope() -> None:
    for figure in figures(run("six_bar_press"), names=["forces", "accelerations", "moments"]).values():
        assert not [one for ax in figure.axes for one in ax.collections]
    assert "envelope" not in available(run("six_bar_press")) and "envelope" in available(run("compressor"))
    figure = figures(run("compressor"), names=["forces"])["forces"]
    assert any(one.get_label() == "extremes between outputs" for ax in figure.axes for one in ax.collections)


def test_the_force_of_a_guide_is_drawn_as_vectors() -> None:
    ax = next(
        ax
        for ax in figures(run("six_bar_press"), names=["polar"])["polar"].axes
        if "guide" in ax.get_title(loc="left")
    )
    (rays,) = (line for line in ax.lines if line.get_label() == "vectors")
    lengths = np.hypot(*np.asarray(rays.get_xydata())[1::3].T)
    assert len(lengths) > 50 and lengths.min() > 0.5 * ax.get_xlim()[1]


def test_a_peak_between_outputs_does_not_hide_the_forces_at_them(monkeypatch: pytest.MonkeyPatch) -> None:
    def circles() -> list[list[str]]:
        axes = figures(run("compressor"), names=["polar"])["polar"].axes
        return [
            [ax.get_title(loc="right") for ax in axes if "between outputs" in ax.get_title(loc="right")],
            [str(line.get_label()) for ax in axes for line in ax.lines if "peak" in str(line.get_label())],
        ]

    assert circles() == [[], ["peak that is reported"] * 4]
    monkeypatch.setattr(motion, "MOST_PEAK", 0.5)
    beyond, drawn = circles()
    assert len(beyond) == 4 and not drawn


def test_axes_of_amplitudes_have_one_number_format() -> None:
    every = figures(run("compressor"), names=["spectrum", "spectrogram"])
    for name, figure in every.items():
        for ax in figure.axes:
            labels = [tick.get_text() for tick in ax.get_yticklabels() if tick.get_text()]
            powers = [one for one in labels if one.startswith("10") and one != "10" and not one.isdigit()]
            assert not powers or all(re.fullmatch("10⁻?[⁰¹²³⁴⁵⁶⁷⁸⁹]+", one) for one in labels), (name, labels)
