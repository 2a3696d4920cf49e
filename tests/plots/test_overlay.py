"""Several runs in one figure: their numbers, over one axis, with legends that say what differs."""

from __future__ import annotations

import dataclasses
import re
from functools import cache
from typing import Any

import matplotlib.colors
import numpy as np
import pytest

import vfife
from drawn_texts import faults
from vfife import gallery
from vfife.plots import run_labels
from vfife.plots.catalogue import FIGURES
from vfife.plots.curves import joint_forces
from vfife.plots.overlay import OVERLAYS, RUNS, overlaid, overlay
from vfife.plots.turn import shown_span


@cache
def run(clearance: float = 2e-4, speed: float = 157.0, turns: float = 1) -> vfife.Result:
    """The four-bar with play in joint C; no test changes it."""
    m = gallery.four_bar_case_b()
    m.joints["C"] = dataclasses.replace(m.contacts["C"], clearance=clearance)
    m.drivers["crank"] = dataclasses.replace(m.drivers["crank"], speed=speed)
    return vfife.simulate(m, turns=turns, outputs=120, companions=0)


@cache
def pair() -> tuple[vfife.Result, vfife.Result]:
    return run(), run(4e-4)


def curves(figure: Any, title: str) -> list[Any]:
    """The lines of a panel that belong to runs, in their order."""
    (ax,) = (one for one in figure.axes if one.get_title(loc="left") == title)
    return [line for line in ax.lines if line.get_lw() == 1.1]


def legend(figure: Any) -> list[str]:
    return [text.get_text() for text in figure.legends[0].get_texts()]


def test_lines_are_the_extremes_of_each_run_over_the_crank_angle() -> None:
    one, other = pair()
    figure = one.plot("forces", other=other)["forces"]
    assert figure.axes[-1].get_xlabel() == "crank angle (degrees)" and figure.axes[0].get_xlabel() == ""
    for line, result in zip(curves(figure, "joint C"), (one, other), strict=True):
        values, part = joint_forces(result)["C"], shown_span(result)
        sampled = values.samples(result.record)[part.first :]
        most = np.nanmax(line.get_ydata())
        assert 1e3 * most == pytest.approx(result.measures["C.force.max"], rel=1e-12)
        assert (1e3 * line.get_ydata()[np.isfinite(line.get_ydata())]).max() >= sampled.max()
        x = line.get_xdata()
        assert x.min() == 0.0 and x.max() == 360.0
    peaks = [f"{1e-3 * result.measures['C.force.max']:.4g}" for result in pair()]
    (ax,) = (one for one in figure.axes if one.get_title(loc="left") == "joint C")
    assert ax.get_title(loc="right") == f"peak {peaks[0]} / {peaks[1]} kN"


def test_other_speeds_share_the_crank_angle_and_have_their_own_ideal() -> None:
    figure = run().plot("forces", other=run(speed=100.0), labels=["fast", "slow"])["forces"]
    fast, slow = curves(figure, "joint A")
    assert fast.get_xdata().max() == slow.get_xdata().max() == 360.0
    handles = figure.legends[0].legend_handles
    for line, handle in zip((fast, slow), handles, strict=False):
        assert line.get_color() == handle.get_color()
        assert line.get_linestyle() == handle.get_linestyle()
    assert fast.get_color() != slow.get_color() and fast.get_linestyle() != slow.get_linestyle()
    assert legend(figure) == ["fast", "slow", "ideal joints, fast", "ideal joints, slow"]
    assert legend(run().plot("forces", other=run(4e-4))["forces"])[2:] == ["ideal joints"]


def test_labels_say_what_differs() -> None:
    assert run_labels(pair()) == ["C.clearance 0.2 mm", "C.clearance 0.4 mm"]
    both = run_labels([run(), run(3e-4, 100.0)], ["new", "worn"])
    assert both == [
        "new: C.clearance 0.2 mm; crank.speed 1499 rpm",
        "worn: C.clearance 0.3 mm; crank.speed 954.9 rpm",
    ]
    assert run_labels([run(), run(turns=2)]) == ["(run 1)", "(run 2)"]
    assert run_labels([run(), run(turns=2)], ["a", "b"]) == ["a", "b"]
    c = gallery.four_bar_case_c()
    wide = gallery.four_bar_case_c()
    for name in wide.clearances:
        wide.joints[name] = dataclasses.replace(wide.contacts[name], clearance=3e-4)
    views = [
        vfife.simulate(m, duration="0.1 ms", outputs=2, companions=0, reference=False) for m in (c, wide)
    ]
    assert run_labels(views)[1] == "clearance 0.3 mm"  # of three joints alike
    for name, clearance in zip(wide.clearances, (8e-6, 3e-5, 1.6e-4), strict=True):
        wide.joints[name] = dataclasses.replace(wide.contacts[name], clearance=clearance)
    views[1] = vfife.simulate(wide, duration="0.1 ms", outputs=2, companions=0, reference=False)
    names = run_labels(views, ["new", "worn"])
    assert names[1] == "worn: clearance B 0.008 mm, C 0.03 mm, D 0.16 mm", "one unit for all"


def test_a_long_label_is_broken_and_never_cut() -> None:
    label = "worn: " + ", ".join(f"joint number {k} 80 µm" for k in range(12))
    figure = overlay("forces", pair(), ["new", label], ["joint C"])
    lines = legend(figure)[1].split("\n")
    assert " ".join(lines) == label and len(lines) > 1
    assert not faults(figure)


def test_a_mean_peak_is_called_so_where_turns_differ() -> None:
    m = gallery.four_bar_case_b()
    m.joints["C"] = dataclasses.replace(m.contacts["C"], clearance=1e-3)
    result = vfife.simulate(m, turns=6, outputs=120, companions=0)
    assert shown_span(result).turns is not None
    figure = result.plot("forces", other=result, labels=["one", "same"])["forces"]
    assert all(ax.get_title(loc="right").startswith("mean peak") for ax in figure.axes)
    assert "turn 6" in figure._suptitle.get_text()
    ax = figure.axes[0]
    count = len(ax.lines)
    shown_span(result).set_limits(ax)
    assert len(ax.lines) == count, "this turn starts at 0"
    later = dataclasses.replace(shown_span(result), x=shown_span(result).x + 180.0)
    later.set_limits(ax)
    assert [line.get_label() for line in ax.lines[count:]] == ["start of the turn"]
    assert ax.lines[-1].get_xdata()[0] == pytest.approx(180.0)
    assert "means of peaks" not in figure._suptitle.get_text()
    narrow = result.plot("polar", other=result, labels=["one", "same"])["polar"]
    assert "turn 6, means of peaks" in narrow._suptitle.get_text()
    for ax in narrow.axes:
        assert ax.get_title(loc="right").startswith("means ") and not ax.get_title(loc="left").endswith("…")
    polar = result.plot("polar")["polar"]
    assert all(ax.get_title(loc="right").startswith("mean peak") for ax in polar.axes)


def test_only_the_peak_of_a_mean_is_called_mean() -> None:
    """A run that scatters beside one whose last turn counts."""
    m = gallery.four_bar_case_b()
    m.joints["C"] = dataclasses.replace(m.contacts["C"], clearance=1e-3)
    scattering = vfife.simulate(m, turns=6, outputs=120, companions=0)
    single = vfife.simulate(gallery.four_bar_case_b(), turns=1, outputs=120, companions=0)
    assert shown_span(scattering).turns is not None and shown_span(single).turns is None
    figure = single.plot("forces", other=scattering, labels=["one", "six"])["forces"]
    for ax in figure.axes:
        assert re.fullmatch(r"peak [\d.,]+ / [\d., to]+ \(mean\) k?N", ax.get_title(loc="right"))
    narrow = single.plot("polar", other=scattering, labels=["one", "six"])["polar"]
    assert "* mean of peaks" in narrow._suptitle.get_text()
    for ax in narrow.axes:
        assert re.fullmatch(r"peak [\d.,]+ / [\d., to]+ \* k?N", ax.get_title(loc="right"))


def test_every_overlay_is_readable() -> None:
    for name in set(OVERLAYS) - {"guides", "stress", "deflection"}:
        figure = overlay(name, pair(), ["first", "second"])
        assert not faults(figure), name
        assert legend(figure)[:2] == ["first", "second"]
        assert all(len([one for one in ax.lines if one.get_lw() == 1.1]) == 2 for ax in figure.axes), name
    m = gallery.elastic_pendulum()
    views = [vfife.simulate(m, duration=time, outputs=30, companions=0) for time in ("40 ms", "60 ms")]
    for name in ("stress", "deflection"):
        assert len(curves(overlay(name, views, ["a", "b"]), "rod")) == 2


def test_every_figure_of_the_outputs_of_a_turn_names_it() -> None:
    """Guides, paths and portraits do as orbits do; spectra and energies are not of one turn."""
    views = [run(turns=2), vfife.simulate(gallery.four_bar_case_b(), turns=2, outputs=120, companions=0)]
    for name in ("orbits", "traces", "phase", "polar"):
        assert ", last turn" in overlay(name, views, ["a", "b"]).get_suptitle().replace("\n", " "), name
    assert "turn" not in overlay("energy", views, ["a", "b"]).get_suptitle()
    loose = gallery.compressor()
    loose.joints["cylinder"] = dataclasses.replace(loose.joints["cylinder"], clearance=4e-5)
    views = [vfife.simulate(loose, turns=2, outputs=60, companions=0)] * 2
    assert "blocks in their guides, last turn" in overlay("guides", views, ["a", "b"]).get_suptitle().replace(
        "\n", " "
    )


def test_runs_differ_in_grey_print() -> None:
    dashes = {str(one["ls"]) for one in RUNS}
    assert len(dashes) == len(RUNS)
    first = [np.dot(matplotlib.colors.to_rgb(one["color"]), (0.299, 0.587, 0.114)) for one in RUNS[:3]]
    assert np.diff(sorted(first)).min() > 0.2


def test_what_cannot_be_overlaid_gets_a_sentence() -> None:
    one, other = pair()
    chosen, sentence = overlaid([one, other], (), ["a", "b"])
    assert chosen == ["orbits", "forces", "moments", "accelerations"]
    assert sentence == (
        "Not overlaid: mechanism (drawn of one run at a time), guides (a: no block has clearance in a guide)."
    )
    for wrong, words in (
        (lambda: one.plot("strip", other=other), '"strip" is not overlaid: name one of orbits'),
        (lambda: one.plot("guides", other=other), "no block has clearance in a guide"),
        (lambda: one.plot("guidess", other=other), 'did you mean "guides"'),
        (lambda: one.plot(other=[other] * 6), "7 runs: a figure shows 6 at most"),
        (lambda: one.plot(other=other, labels=["a"]), "these are 1 for 2 runs"),
        (lambda: one.plot(other=other, at="90deg"), "of one run"),
    ):
        with pytest.raises(vfife.VfifeError, match=words):
            wrong()
    still = vfife.simulate(gallery.lee_frame())
    with pytest.raises(vfife.VfifeError, match="no panel of it in common"):
        one.plot("forces", other=still)
    free = vfife.simulate(gallery.double_pendulum(), duration="10 ms", outputs=10, companions=0)
    with pytest.raises(
        vfife.VfifeError, match=r"abscissae differ: a over turns of the crank; b over time \(ms\)"
    ):
        overlay("energy", [one, free], ["a", "b"])


def test_every_overlay_is_a_figure_of_one_run_too() -> None:
    assert set(OVERLAYS) < set(FIGURES)
