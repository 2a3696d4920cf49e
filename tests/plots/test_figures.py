"""What figures show is what the result says: peaks, order, frames, scales, energies, colours that can be told
apart, texts that can be read.
"""

import dataclasses
import re
from functools import cache
from itertools import combinations
from pathlib import Path

import numpy as np
import pytest
from matplotlib.axes import Axes
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure

import vfife
from drawn_texts import faults
from vfife import gallery
from vfife.errors import VfifeError
from vfife.measures.spectral import short_time
from vfife.measures.values import Measured
from vfife.plots import chosen, figures, style
from vfife.plots.catalogue import FIGURES, available, usual
from vfife.plots.curves import Quantity, accelerations, joint_forces, moments, reach_of
from vfife.plots.motion import bearing_force, relative_to_bearing, tilt_and_offset
from vfife.plots.spectra import pieces, spectra_of
from vfife.plots.style import peak_digits
from vfife.plots.turn import output_at, over_turn, shown_span
from vfife.report.digits import turns_text
from vfife.simulation.result import Result
from vfife.store.folder import FIGURE_NAMES
from vfife.tribology.wear_state import ANGLES, Surface, WearSpec, Worn


@cache
def run(name: str) -> Result:
    return vfife.simulate(getattr(gallery, name)(), companions=0, loop="data-driven")


@cache
def settled() -> Result:
    """Several turns, over which measures are means."""
    return vfife.simulate(gallery.four_bar_ideal(), turns=6, outputs=240)


@cache
def drawn(name: str) -> dict[str, Figure]:
    return figures(run(name), names=["all"])


def titles(figure: Figure) -> list[str]:
    return [ax.get_title(loc="left") for ax in figure.axes]


def labelled(ax: Axes, name: str) -> tuple[np.ndarray, np.ndarray]:
    """The line of a name."""
    return next(line for line in ax.lines if line.get_label() == name).get_data()


# ----------------------------------------------------------------------------------------------------- over a
# turn


@pytest.mark.parametrize("name", ["four_bar_case_c", "slider_crank_loose_guide", "toggle_press"])
def test_the_top_of_a_band_is_the_peak_that_is_reported(name: str) -> None:
    """To the bit, of every joint, driver and body; a slider's acceleration is that of the outputs."""
    result = run(name)
    over, found = shown_span(result), {**joint_forces(result), **moments(result), **accelerations(result)}
    assert len(found) >= 4
    for one in found.values():
        assert reach_of(result, one, over).largest_size == result.measures[one.peak], one.title


def test_the_band_holds_every_turn_that_measures_are_of() -> None:
    result = settled()
    assert result.motion.has_several and shown_span(result).turns == (result.motion.first, result.motion.last)
    for one in joint_forces(result).values():
        assert reach_of(result, one, shown_span(result)).largest_size == result.measures[one.peak].highest, (
            one.title
        )
    ax, told = result.plot("forces")["forces"].axes[1], result.measures["B.force.max"]
    assert ax.get_title(loc="right") == f"mean peak {1e-3 * told:.4g} kN"
    assert np.nanmax(labelled(ax, "highest of these turns")[1]) == pytest.approx(
        1e-3 * told.highest, rel=1e-12
    )


def test_the_range_of_single_turns_is_that_of_the_answer() -> None:
    """One answer to the question how high single turns are: that of the run and its companions, although the
    figure draws the turns of the run.
    """
    result = vfife.simulate(gallery.slider_crank_loose_pin(clearance=2e-4), turns=10, outputs=120)
    assert result.motion.has_several and not result.motion.repeats
    figure, seen = result.plot("forces")["forces"], 0
    for ax, joint in zip(figure.axes, result.summary["joints"], strict=True):
        told, text = turns_text(result.summary, f"{joint}.force.max", "N"), ax.get_title(loc="right")
        shown = text.partition(", single turns ")[2]
        ends = [
            [float(end) * (1e3 if words.endswith("kN") else 1.0) for end in re.findall(r"[\d.]+", words)]
            for words in (told.replace(",", ""), shown.replace(",", ""))
        ]
        assert ends[0] == pytest.approx(ends[1]) and "highest" not in text, (told, text)
        seen += bool(told)
    assert seen


def test_what_is_drawn_is_what_is_told() -> None:
    """The mark of the peak, the number over the panel and the edge of the band, in the unit of the axis."""
    result, figure, seen = run("four_bar_case_c"), drawn("four_bar_case_c")["forces"], 0
    for ax, joint in zip(figure.axes, "ABCD", strict=True):
        peak = 1e-3 * result.measures[f"{joint}.force.max"]  # kN
        assert ax.get_ylabel() == "force (kN)" and ax.get_title(loc="right") == f"peak {peak:.4g} kN"
        assert np.nanmax(labelled(ax, "peak that is reported")[1]) == pytest.approx(peak, rel=1e-12)
        bands = [one for one in ax.collections if one.get_label() == "extremes between outputs"]
        seen += len(bands)
        tops = [path.vertices[:, 1].max() for band in bands for path in band.get_paths()]
        assert not tops or max(tops) == pytest.approx(peak, rel=1e-12)
        samples = result.joint(joint).force.values[result.last_turn]
        assert np.nanmax(labelled(ax, "at the outputs")[1]) == pytest.approx(1e-3 * samples.max(), rel=1e-12)
    assert seen


def test_joints_stand_in_the_order_of_the_table() -> None:
    for name in ("slider_crank_loose_guide", "four_bar_case_c"):
        told = [f"joint {joint}" for joint in run(name).summary["joints"]]
        assert titles(drawn(name)["forces"]) == [
            title for title in told if title in titles(drawn(name)["forces"])
        ]
        assert len(titles(drawn(name)["forces"])) == 4


def test_a_slider_shows_its_motion_along_its_guide() -> None:
    figure, result = drawn("slider_crank_loose_guide")["accelerations"], run("slider_crank_loose_guide")
    assert titles(figure) == ["block along guide", "rod"] and figure.axes[0].get_ylabel().endswith("m/s²)")
    x, y = labelled(figure.axes[0], "at the outputs")
    assert np.allclose(y, result.channels["slider_acceleration"].values[:, 0]) and len(x) == len(result.time)


def test_a_turn_goes_from_0_to_360_degrees_of_the_crank() -> None:
    result, figure = run("four_bar_case_c"), drawn("four_bar_case_c")["forces"]
    ax = figure.axes[3]
    assert [tick.get_text() for tick in ax.get_xticklabels()] == [
        "0",
        "60",
        "120",
        "180",
        "240",
        "300",
        "360",
    ]
    x, y = labelled(ax, "at the outputs")
    assert abs((x[np.nanargmax(y)] + 180.0) % 360.0 - 180.0) < 15.0
    force = 1e-3 * result.joint("D").force.values[shown_span(result).first :]
    assert np.isin(force, y).all() and np.isfinite(y).sum() <= len(force) + 2  # nothing lost, two ends added
    assert drawn("slider_crank_loose_guide")["forces"].axes[0].get_xlim() == pytest.approx(
        (0.0, 180.0), abs=0.5
    )  # half a turn stays


@pytest.mark.parametrize("way", [1.0, -1.0])
@pytest.mark.parametrize("start", [0.0, 100.3, 90.0 - 1e-9, 90.0 + 1e-9])
def test_a_turn_begins_anywhere_whichever_way_it_goes(way: float, start: float) -> None:
    x = start + way * np.linspace(
        0.0, 360.0 + 2.0 * (90.0 - start if abs(start - 90.0) < 1e-6 else 0.0), 361
    )  # rounded at both ends
    at, values = over_turn(x, np.cos(np.radians(x)))
    seen = np.isfinite(values)
    assert np.allclose(values[seen], np.cos(np.radians(at[seen])), atol=1e-4)  # ends are linear
    assert seen.sum() >= 361 and at.min() == 0.0 and at.max() == pytest.approx(360.0)
    jumps = np.flatnonzero(np.abs(np.diff(at)) > 180.0)
    assert len(jumps) and all(np.isnan(values[[k, k + 1]]).any() for k in jumps)  # no line across the figure


def test_the_ideal_curve_lies_over_the_same_angles() -> None:
    """Four-bar case c against its ideal mechanism, whose torque is known at every angle of the figure."""
    result, ax = run("four_bar_case_c"), drawn("four_bar_case_c")["moments"].axes[0]
    x, y = labelled(ax, "ideal joints")
    reference = result.reference
    angle, torque = (
        np.mod(reference.crank_angle[reference.last_turn], 360.0),
        reference.channels["driver_torque"].values[reference.last_turn, 0],
    )
    order, seen = np.argsort(angle), np.isfinite(y)
    x, y = x[seen], y[seen]
    assert np.allclose(
        1e3 * y,
        np.interp(np.mod(x, 360.0), angle[order], torque[order], period=360.0),
        rtol=1e-6,
        atol=1e-6 * np.abs(torque).max(),
    )


# ------------------------------------------------------------------------------------------------- orbits and
# guides


def test_orbits_are_seen_from_the_bearing_and_have_one_scale() -> None:
    result, figure = run("four_bar_case_c"), drawn("four_bar_case_c")["orbits"]
    angle = dict(zip(result.record.assembly.bodies, result.channels["body_angle"].values.T, strict=True)) | {
        "ground": np.zeros(len(result.time))
    }
    for name, ax in zip(result.record.assembly.contacts, figure.axes, strict=True):
        away = relative_to_bearing(result, name) @ np.array([1.0, 1.0j])
        told = result.joint(name).eccentricity_x.values + 1.0j * result.joint(name).eccentricity_y.values
        bearing = result.record.assembly.mechanism.joints[name].sides[0][0]
        assert np.allclose(away * np.exp(1.0j * angle[bearing]), told, atol=1e-15)
        x, y = labelled(ax, "journal centre")
        assert np.allclose(x + 1.0j * y, 1e3 * away[-len(x) :])
        radius = np.hypot(*labelled(ax, "clearance circle"))
        assert np.allclose(radius, 1e3 * result.record.assembly.mechanism.clearances[name].clearance)
        every = 1.0e3 * np.abs(away)
        assert (
            ax.get_xlim() == ax.get_ylim() == figure.axes[0].get_xlim() and ax.get_xlim()[1] > every.max()
        )  # nothing is cut


def test_a_corner_that_leaves_the_diamond_has_met_its_wall() -> None:
    """|offset| + (L/2 - r) |tilt| less the clearance is the deepest penetration of a corner,
    but for the second order of the tilt.
    """
    result = run("slider_crank_loose_guide")
    joint = result.record.assembly.mechanism.joints["guide"]
    tilt, offset = tilt_and_offset(result, "guide")
    beyond = np.abs(offset) + (0.5 * joint.length - joint.corner_radius) * np.abs(tilt) - joint.clearance
    deepest = result.channels["penetration"].values.max(axis=1)
    inside = np.abs(tilt) < 1e-3
    assert inside.sum() > 20 and (deepest[inside] > 1e-6).any()
    assert np.allclose(np.maximum(beyond, 0.0)[inside], np.maximum(deepest, 0.0)[inside], atol=2e-8)


def test_a_polar_force_has_the_size_of_the_joints_force() -> None:
    result = run("four_bar_case_c")
    for joint in "ABCD":
        force = bearing_force(result, joint)
        assert np.allclose(np.hypot(*force.T), result.joint(joint).force.values, rtol=1e-12)
    turned = np.exp(1.0j * result.body("crank").angle.values)  # B's bearing is the crank's
    told = result.joint("B").force_x.values + 1.0j * result.joint("B").force_y.values
    assert np.allclose(bearing_force(result, "B") @ np.array([1.0, 1.0j]) * turned, told, rtol=1e-9)
    assert np.allclose(
        bearing_force(result, "A")[:, 0], result.joint("A").force_x.values
    )  # its bearing is the ground's


# ----------------------------------------------------------------------------------------- spectra, energy,
# elastic links


def test_a_spectrum_shows_the_amplitude_of_a_wave() -> None:
    turn = 2.0 * np.pi * np.arange(400) / 400
    first = np.zeros(1, dtype=np.int64)
    found = short_time(
        3.0 + 2.0 * np.cos(7.0 * turn + 0.4) + 0.5 * np.sin(30.0 * turn), first, "rectangular", 400
    )[0]
    assert found[[0, 7, 30]] == pytest.approx([3.0, 2.0, 0.5]) and found.sum() == pytest.approx(5.5)
    assert short_time(2.0 * np.cos(7.0 * turn), first, "hann", 400)[0, 7] == pytest.approx(
        2.0
    )  # Hann's window keeps it


def test_turns_are_taken_as_they_are_and_parts_of_a_run_through_hanns_window() -> None:
    result = run("four_bar_case_c")
    starts, count, turning = pieces(result)
    wave = Quantity("", "", "N", lambda record: np.cos(6.0 * np.pi * np.arange(len(record.steps)) / count))
    assert turning and spectra_of(result, wave, starts, count, True).amplitudes[-1, 2:5] == pytest.approx(
        [0.0, 1.0, 0.0], abs=1e-12
    )
    assert spectra_of(result, wave, starts, count, False).amplitudes[-1, 2:5] == pytest.approx(
        [0.5, 1.0, 0.5]
    )


def test_orders_of_the_crank_and_frequencies() -> None:
    assert drawn("four_bar_case_c")["spectrum"].axes[2].get_xlabel() == "order of crank"
    figure, result = drawn("elastic_pendulum")["spectrum"], run("elastic_pendulum")
    x, _ = labelled(figure.axes[0], "this run")
    assert figure.axes[0].get_xlabel() == "frequency (Hz)" and x[1] == pytest.approx(1.0 / result.time[-1])


def test_energies_are_those_of_the_ledger() -> None:
    result, figure = run("elastic_pendulum"), drawn("elastic_pendulum")["energy"]
    assert np.allclose(labelled(figure.axes[0], "strain of elastic links")[1], result.ledger.terms["strain"])
    assert np.allclose(
        labelled(figure.axes[1], "work of weight, loads and driver torques")[1],
        result.ledger.terms["external"],
    )
    assert figure.axes[0].get_ylabel() == "stored (J)"


def test_stress_and_deflection_reach_what_is_reported() -> None:
    result, found = run("elastic_pendulum"), drawn("elastic_pendulum")
    x, y = labelled(found["stress"].axes[0], "largest")
    told = max(result.measures["rod.tension.max"], result.measures["rod.compression.max"])
    assert 1e3 * abs(y[0]) == pytest.approx(told, rel=1e-12) and x[0] == pytest.approx(
        result.measures["rod.stress.place"]
    )
    _, y = labelled(found["deflection"].axes[0], "largest")
    assert 1e-3 * abs(y[0]) == pytest.approx(result.measures["rod.deflection.max"], rel=1e-12)


# ------------------------------------------------------------------------------------------------------------
# the table


def test_the_table_says_what_a_result_has_nothing_for() -> None:
    assert {name for name in FIGURES if name not in available(run("toggle_press"))} == {
        "orbits", "guides", "moments", "accelerations", "phase", "spectrum", "waterfall", "spectrogram",
        "envelope", "energy", "stress", "deflection", "wear",
    }  # fmt: skip
    with pytest.raises(
        VfifeError,
        match='nothing for the figure "energy": a static analysis has no motion; there are mechanism, ',
    ):
        run("toggle_press").plot("energy")
    with pytest.raises(
        VfifeError, match='nothing for the figure "guides": no block has clearance in a guide'
    ):
        run("elastic_pendulum").plot("guides")
    with pytest.raises(VfifeError, match='no figure "spectra": did you mean "spectrum"'):
        run("elastic_pendulum").plot("spectra")
    assert (
        chosen(run("elastic_pendulum"), ())
        == ["mechanism", "forces", "accelerations"]
        == usual(run("elastic_pendulum"))
    )
    assert set(FIGURE_NAMES) == {name for name, one in FIGURES.items() if one.usual}


def test_a_page_shows_every_figure() -> None:
    page = (Path(__file__).parents[2] / "examples" / "figures.py").read_text(encoding="utf-8")
    assert all(f"**{name}**" in page and f'"{name}"' in page for name in FIGURES)


def test_all_that_there_is_can_be_drawn() -> None:
    """Every kind of figure is among these runs."""
    assert set(FIGURES) == {
        *drawn("slider_crank_loose_guide"),
        *drawn("elastic_pendulum"),
        *drawn("four_bar_case_c"),
        "wear",
    }


def test_surfaces_that_wear_are_drawn_around_themselves() -> None:
    """As deep as the measure of the turn says, a million times; a surface without a coefficient has no panel,
    and words stand clear.
    """
    m = gallery.four_bar_case_c()
    for name, wear in (
        ("B", vfife.joints.Wear(bearing=1e-17)),
        ("C", vfife.joints.Wear(bearing=1e-17, journal=1e-18)),
        ("D", vfife.joints.Wear()),
    ):
        m.joints[name] = dataclasses.replace(m.contacts[name], wear=wear)
    result = vfife.simulate(m, companions=0, loop="data-driven")
    figure = result.plot("wear")["wear"]
    assert [ax.get_xlabel().partition(",")[0] for ax in figure.axes] == [
        "B: crank (bearing)",
        "C: coupler (bearing)",
        "C: follower (journal)",
    ]
    told = 1e6 * result.measures["C.journal_wear_depth.max"]
    assert figure.axes[2].get_xlabel().endswith(f"up to {float(f'{1e6 * told:.3g}'):.4g} µm")
    assert not faults(figure)
    assert "wear" not in available(run("four_bar_case_c"))


def test_wear_over_turns_is_readable() -> None:
    """Depths at some of the turns, play and force with their limits, a life that ended; markup in a name is
    text.
    """
    surfaces = tuple(Surface("pin", side, 1e-15, (), 1e-4) for side in ("bearing", "journal"))
    asked = WearSpec("", 1e7, 4, 4, 0.01, 8, 1.5e-4, None, 3600)
    turns, ripple = np.linspace(0.0, 1e7, 12), 1.0 + np.cos(2.0 * ANGLES)
    depth = turns[:, None, None] * np.stack([2e-12 * ripple, 4e-13 * ripple])
    play, zeros = 1e-4 + 5e-12 * turns[:, None], np.zeros(12)
    ended = {"turns": 1e7, "joint": "pin", "by": "clearance"}
    found = Worn(
        "press $x_1$",
        asked,
        surfaces,
        ("pin",),
        turns,
        depth,
        depth,
        play,
        1e3 + play,
        zeros,
        zeros,
        zeros,
        192.0,
        ended,
    )
    figure = found.plot()
    assert not faults(figure)
    assert [ax.get_xlabel() for ax in figure.axes] == [
        "pin: bearing, up to 40 µm",
        "pin: journal, up to 8 µm",
        "",
        "million turns",
    ]
    assert labelled(figure.axes[2], "limit")[1] == pytest.approx([0.15, 0.15])
    assert "life of joint pin ends after 10 million by its clearance" in figure.get_suptitle().replace(
        "\n", " "
    )
    assert [line.get_label() for line in figure.axes[0].lines][-2:] == ["10 million", "new"]


@pytest.mark.system("draws every figure of several runs")
def test_no_text_covers_another_or_leaves_the_sheet() -> None:
    every = {
        **drawn("slider_crank_loose_guide"),
        **{name: drawn("elastic_pendulum")[name] for name in ("stress", "deflection", "traces")},
    }
    assert not {figure: found for figure, one in every.items() if (found := faults(one))}


@pytest.mark.parametrize("name", ["compressor", "slider_crank_loose_guide", "six_bar_press"])
def test_blocks_are_drawn_below_the_rods_that_end_in_them(name: str) -> None:
    """Whatever is filled lies below the lines of all bodies, so that a piston hides no rod."""
    result = run(name)
    [ax, *_] = figures(result, names=["mechanism"])["mechanism"].axes
    bodies = [line for line in ax.lines if line.get_label() in result.record.assembly.bodies]
    filled = [patch for patch in ax.patches if patch.get_facecolor()[3] > 0.0]
    assert bodies and filled
    assert max(patch.get_zorder() for patch in filled) <= min(line.get_zorder() for line in bodies)


def test_long_names_are_cut_before_they_run_into_each_other() -> None:
    """Names as long as they may be, on every figure that shows them; markup in a name is text."""
    long = "connecting rod of cylinder two, delivered in spring $x_1$ "
    m = vfife.Mechanism(2 * long, gravity=(0.0, -9.81))
    m.point("O", 0.0, 0.0)
    for k in range(3):
        m.link(f"{long}{k}", length=0.3, mass=0.2, angle=0.3 * k)
        m.revolute(f"j-{long}{k}", "ground.O" if k == 0 else f"{long}{k - 1}.end", f"{long}{k}.start")
    result = vfife.simulate(m, duration=0.05, outputs=40, companions=0, loop="data-driven")
    found = figures(result, names=["mechanism", "forces", "traces", "phase"])
    assert not {name: told for name, one in found.items() if (told := faults(one))}
    assert titles(found["forces"])[0].startswith("joint j-connecting rod") and titles(found["forces"])[
        0
    ].endswith("…")


@pytest.mark.parametrize(("at", "wanted"), [("10ms", 10e-3), ("0.02", 20e-3)])
def test_a_moment_is_the_output_nearest_to_it(at: str, wanted: float) -> None:
    result = run("slider_crank_loose_guide")
    assert result.time[output_at(result, at)] == pytest.approx(wanted, abs=0.5 * result.time[1])
    assert result.crank_angle[output_at(result, "90deg")] == pytest.approx(90.0, abs=0.3)
    figure = result.plot("mechanism", at="90deg")["mechanism"]
    assert "crank at 90°" in figure.get_suptitle()
    crank = next(line for line in figure.axes[0].lines if line.get_label() == "crank")
    assert np.allclose(crank.get_xydata()[1], [0.0, 50.0], atol=0.5)  # mm: upright
    with pytest.raises(VfifeError, match="name no other figure"):
        result.plot("forces", at="90deg")


@pytest.mark.parametrize(
    ("name", "at", "says"),
    [
        ("slider_crank_loose_guide", "270deg", "crank goes from 0 to 180 degrees"),
        ("slider_crank_loose_guide", "3 kg", "neither an angle nor a time"),
        ("slider_crank_loose_guide", "2 s", "the run goes from 0 to 0.03"),
        ("elastic_pendulum", "90deg", "nothing is driven"),
        ("toggle_press", "1.5", "the run goes from 0 to 1"),
    ],
)
def test_what_is_no_moment_of_a_run_is_refused(name: str, at: str, says: str) -> None:
    with pytest.raises(VfifeError, match=says):
        output_at(run(name), at)


# ---------------------------------------------------------------------------------------------------- colours

SEEN_BY = {  # Machado, Oliveira, Fernandes 2009, severity 1, on linear RGB
    "all cones": np.eye(3),
    "deuteranopia": np.array(
        [[0.367322, 0.860646, -0.227968], [0.280085, 0.672501, 0.047413], [-0.011820, 0.042940, 0.968881]]
    ),
    "protanopia": np.array(
        [[0.152286, 1.052583, -0.204868], [0.114503, 0.786281, 0.099216], [-0.003882, -0.048116, 1.051998]]
    ),
}
TOLD_APART = 15.0  # distance in CIELAB; 2.3 is what is just noticed side by side


def seen(colour: str, by: np.ndarray) -> np.ndarray:
    """A colour in CIELAB (D65) as it is seen."""
    rgb = np.array(to_rgb(colour))
    linear = by @ np.where(rgb <= 0.04045, rgb / 12.92, ((rgb + 0.055) / 1.055) ** 2.4)
    xyz = np.array(
        [
            [0.4124564, 0.3575761, 0.1804375],
            [0.2126729, 0.7151522, 0.0721750],
            [0.0193339, 0.1191920, 0.9503041],
        ]
    ) @ linear.clip(0, 1)
    f = np.where(
        (t := xyz / np.array([0.95047, 1.0, 1.08883])) > 0.008856, np.cbrt(t), 7.787 * t + 16.0 / 116.0
    )
    return np.array([116.0 * f[1] - 16.0, 500.0 * (f[0] - f[1]), 200.0 * (f[1] - f[2])])


@pytest.mark.parametrize("by", SEEN_BY)
def test_colours_of_a_figure_can_be_told_apart(by: str) -> None:
    drawing = (*style.BODIES, style.SYMBOLS, style.LOADS, style.INK)
    curves = (style.BLUE, style.VERMILION, style.SKY, style.ORANGE, style.INK)
    for colours in (drawing, curves):
        for one, other in combinations(colours, 2):
            assert np.linalg.norm(seen(one, SEEN_BY[by]) - seen(other, SEEN_BY[by])) > TOLD_APART, (
                one,
                other,
            )


@pytest.mark.parametrize("name", ["elastic_pendulum", "four_bar_case_c", "slider_crank_loose_guide"])
def test_no_two_lines_of_a_legend_look_alike(name: str) -> None:
    """By colour, dashes, width and mark; of the drawing by the sign, which is a line and a
    stripe, or rings.
    """
    for figure in drawn(name).values():
        looks = [
            tuple(
                (
                    one.get_color(),
                    one.get_linestyle(),
                    one._dash_pattern,
                    one.get_marker(),
                    one.get_markersize(),
                    one.get_markerfacecolor(),
                )
                for one in (handle if isinstance(handle, tuple) else (handle,))
                if hasattr(one, "get_marker")
            )
            for legend in figure.legends
            for handle in legend.legend_handles
        ]
        looks = [str(look) for look in looks if look]
        assert len(set(looks)) == len(looks), (figure.get_suptitle(), looks)


def test_the_seventh_body_is_striped() -> None:
    m = vfife.Mechanism("chain", gravity=(0.0, -9.81))
    m.point("O", 0.0, 0.0)
    for k in range(8):
        m.link(f"l{k}", length=0.1, mass=0.1)
        m.revolute(f"j{k}", "ground.O" if k == 0 else f"l{k - 1}.end", f"l{k}.start")
    lines = [(line.get_color(), line.get_linewidth()) for line in m.plot().axes[0].lines]
    assert lines.count(("white", 1.4)) == 2


def test_a_figure_states_a_peak_as_certainly_as_the_answer() -> None:
    """A range, its ends rounded outwards to two digits, where the peak is not certain; else four digits."""
    assert peak_digits(Measured(621.3, 118.2, 811.0), 1.0) == "110 to 820"
    assert peak_digits(Measured(2370.0, 2331.0, 2409.0), 1e-3) == "2.33 to 2.41"
    assert peak_digits(Measured(621.3, 621.0, 621.9), 1.0) == "621.3"
    assert peak_digits(Measured(621.3), 1.0) == peak_digits(621.3, 1.0) == "621.3"
