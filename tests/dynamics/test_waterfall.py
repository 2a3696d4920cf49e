"""Waterfalls over speed: resonance where the closed form has it, cases as runs of their own, files that go
on.
"""

import csv
import math
from functools import cache

import numpy as np
import pytest

import vfife
from vfife.dynamics import load_map
from vfife.dynamics.waterfall import Waterfall, waterfall
from vfife.errors import ModelError, VfifeError
from vfife_validation.verification.chaotic import turning

SPEED = "driver.crank.speed"
GIVEN = {
    "count": 5,
    "turns": 14,
    "last": 2,
    "outputs": 96,
    "highest": 6.0,
    "series": ["block.x"],
    "step": 1e-3,
}
NATURAL, DAMPING = 30.0, 12.0  # rad/s, 1/s


def shaken(speed: float = 10.0) -> vfife.Mechanism:
    """1 kg on a spring, shaken with 1 N at the first and 2 N at the third order of a crank."""
    m = turning("shaken block", speed)
    m.rigid_body("block", mass=1.0, inertia=0.01, position=(0.3, 0.0))
    m.slider("guide", "ground.O", "block.center")
    m.spring("spring", "ground.O", "block.center", stiffness=NATURAL**2, damping=DAMPING, free_length=0.3)
    m.force("shaker", "block.center", force=(1.0, 0.0), expression="cos(angle) + 2 * cos(3 * angle)")
    return m


@cache
def whole() -> Waterfall:
    """Five speeds."""
    return waterfall(shaken(), SPEED, 6.0, 14.0, **GIVEN)


def response(omega: float) -> float:
    """Amplitude (m) of the block for 1 N."""
    return 1.0 / math.hypot(NATURAL**2 - omega**2, DAMPING * omega)


def test_orders_have_the_amplitudes_of_the_closed_form():
    """Orders 1 and 3 of each speed, the third in resonance at 10 rad/s; none between, and frequencies that
    fan out.
    """
    found = whole()
    assert found.done == 5 and not found.diverged and found.orders[:3] == pytest.approx([0.0, 0.5, 1.0])
    for value, sizes, frequencies in zip(
        found.spec.values, found.amplitudes["block.x"], found.frequencies, strict=True
    ):
        assert sizes[2] == pytest.approx(response(value), rel=5e-3)
        assert sizes[6] == pytest.approx(2.0 * response(3.0 * value), rel=5e-3)
        assert sizes[9:].max() < 1e-2 * sizes[2]
        assert frequencies[2] == pytest.approx(value / (2.0 * math.pi))
    assert found.amplitudes["block.x"][:, 6].argmax() == 2


def test_a_member_is_a_run_of_its_own():
    found = whole()
    size = 2.0 * math.pi / 14.0 / 96 / math.ceil(2.0 * math.pi / 14.0 / 96 / 1e-3)
    alone = vfife.simulate(
        shaken(14.0), turns=14, outputs=96, step=size, companions=0, reference=False, force_step=True
    )
    expected = vfife.dynamics.spectrum(alone.series["block.x"].values[-192:], 1.0).amplitudes[:13]
    assert np.array_equal(found.amplitudes["block.x"][-1], expected)


@pytest.mark.system("breaks a waterfall off")
def test_a_waterfall_goes_on_with_what_is_missing(tmp_path):
    """To the bit; a file that asks something else is not touched."""

    def stop(done: int, count: int) -> None:
        if done == 2:
            raise KeyboardInterrupt

    part = waterfall(shaken(), SPEED, 6.0, 14.0, **GIVEN, file=tmp_path / "a.waterfall", progress=stop)
    assert part.done == 2 and np.isnan(part.amplitudes["block.x"]).all(axis=1).sum() == 3
    calls = []
    rest = waterfall(
        shaken(),
        SPEED,
        6.0,
        14.0,
        **GIVEN,
        file=tmp_path / "a.waterfall",
        progress=lambda *at: calls.append(at),
    )
    assert calls == [(3, 5), (4, 5), (5, 5)]
    for found in (rest, load_map(tmp_path / "a.waterfall")):
        assert (
            np.array_equal(found.amplitudes["block.x"], whole().amplitudes["block.x"])
            and found.spec == whole().spec
        )
    before = (tmp_path / "a.waterfall").read_bytes()
    with pytest.raises(VfifeError, match="with another specification"):
        waterfall(shaken(), SPEED, 6.0, 15.0, **GIVEN, file=tmp_path / "a.waterfall")
    assert (tmp_path / "a.waterfall").read_bytes() == before


def test_a_table_and_a_picture_have_every_amplitude(tmp_path):
    found = whole()
    found.write_csv(tmp_path / "all.csv")
    rows = list(csv.reader((tmp_path / "all.csv").read_text().splitlines()))
    assert (
        rows[0] == ["driver.crank.speed [rad/s]", "order [1]", "frequency [Hz]", "block.x [m]"]
        and len(rows) == 1 + 5 * 13
    )
    assert float(rows[3][3]) == found.amplitudes["block.x"][0, 2]
    from vfife.plots.spectra import cell_edges, over_values

    ax = over_values(found).axes[0]
    assert ax.get_ylabel() == "driver.crank.speed (rpm)" and ax.get_ylim() == pytest.approx(
        (5.0 * 30 / math.pi, 15.0 * 30 / math.pi)
    )
    assert cell_edges(found, True)[-1, 3] == pytest.approx(1.25 * 14.0 / (2.0 * math.pi))


@pytest.mark.parametrize("words, said", [
    ({"last": 20}, "the run has fewer turns"),
    ({"highest": 60.0}, "half the 96 outputs"),
    ({"series": ["block.xx"]}, "block.x"),
    ({"window": "han"}, "hann"),
    ({"last": 1}, "neighbouring orders overlap"),
])  # fmt: skip
def test_what_cannot_be_is_told(words, said):
    with pytest.raises((ModelError, VfifeError), match=said):
        waterfall(shaken(), SPEED, **{"low": 6.0, "high": 14.0, **GIVEN, **words})


def test_a_crank_that_stands_still_is_told():
    with pytest.raises(ModelError, match="no crank turns here"):
        waterfall(turning("alone", 10.0), SPEED, 0.0, 10.0, count=2, turns=4, step=1e-3)
