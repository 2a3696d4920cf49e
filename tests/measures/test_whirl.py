"""Backward whirl of a journal: the closed form of rolling, its mirror image, the same for all outputs, and
none without friction or whole turns.
"""

import numpy as np
import pytest

import vfife
from support import go
from vfife import Mechanism, gallery
from vfife.laws import Coulomb, FrictionLaw, Frictionless, LankaraniNikravesh
from vfife.measures.forces import eccentricity
from vfife.measures.whirl import backward_whirls
from vfife.modelfile import loads
from vfife.report.cautions import whirl_cautions
from vfife.solvers.record import Record

CLEARANCE, BEARING, MASS, INERTIA, SPIN = 5e-4, 0.01, 1.0, 5e-5, 200.0


def spun(friction: FrictionLaw, spin: float = SPIN, outputs: int = 4000) -> Record:
    """A free journal that turns, and meets its fixed bearing."""
    m = Mechanism("spinning journal")
    m.point("O", 0.0, 0.0)
    m.rigid_body("journal", mass=MASS, inertia=INERTIA, velocity=(0.1, 0.0, spin))
    contact = LankaraniNikravesh(restitution=0.3)
    m.clearance_joint(
        "J", "ground.O", "journal.center", clearance=CLEARANCE, bearing_radius=BEARING, contact=contact,
        friction=friction,
    )  # fmt: skip
    return go(m, 1e-6, duration=0.3, outputs=outputs)


def friction() -> FrictionLaw:
    return Coulomb(coefficient=0.3)


@pytest.mark.parametrize("spin", [SPIN, -SPIN])
def test_a_dry_journal_rolls_backward_as_its_impulses_demand(spin: float) -> None:
    """The friction impulse J gives m v = J and I (W0 - W) = J r until v = W r: W = W0/(1 + m r^2/I). The
    journal then goes round at v/e.
    """
    record = spun(friction(), spin)
    radius = BEARING - CLEARANCE
    end = spin / (1.0 + MASS * radius**2 / INERTIA)
    speed = end * radius
    whirl = backward_whirls(record)["J"]
    assert whirl.spin == pytest.approx(end, rel=0.005)
    assert whirl.rate == pytest.approx(-speed / np.hypot(*eccentricity(record)[-1, 0]), rel=0.005)
    (sentence,) = whirl_cautions(record)
    assert "Joint J: " in sentence and " 19 times as fast" in sentence


def test_the_rate_grows_with_the_spin() -> None:
    assert backward_whirls(spun(friction(), 0.9 * SPIN))["J"].rate == pytest.approx(
        0.9 * backward_whirls(spun(friction()))["J"].rate, rel=0.02
    )


def test_the_whirl_is_named_at_any_outputs() -> None:
    """With 60 outputs the journal goes round its bearing once and more from one to the next."""
    fine, coarse = spun(friction()), spun(friction(), outputs=60)
    turns = backward_whirls(fine)["J"].rate * 0.3 / 60 / (2.0 * np.pi)
    assert abs(turns) > 1.0
    assert backward_whirls(coarse)["J"].rate == pytest.approx(backward_whirls(fine)["J"].rate, rel=0.005)
    (sentence,) = whirl_cautions(coarse)
    assert "Joint J: " in sentence and " 19 times as fast" in sentence


def test_no_whirl_without_friction_nor_from_few_outputs() -> None:
    assert backward_whirls(spun(Frictionless())) == {}
    assert list(whirl_cautions(spun(friction(), outputs=30))) == []


def test_a_journal_that_swings_across_its_bearing_does_not_whirl() -> None:
    """The rod of a press under load: its pin swings through 160 degrees where the rocker turns back, and
    crosses the bearing in a moment, but never goes round.
    """
    text = "\n".join(
        line.removeprefix("#~ ") for line in gallery.path("six_bar_press").read_text().splitlines()
    )
    worn = {f"joint.{name}.clearance": "0.15 mm" for name in "EF"}
    model = loads(text, set=[*worn.items(), ("run.turns", 1), ("run.outputs", 720)])
    record = vfife.simulate(model, companions=0, reference=False).record
    angle = np.unwrap(np.arctan2(*eccentricity(record)[20:, 0].T[::-1]))
    assert np.ptp(angle) < 2.0 * np.pi
    assert list(whirl_cautions(record)) == []
