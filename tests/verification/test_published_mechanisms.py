"""What is published of mechanisms with clearance, as far as it can be read without the papers: tendencies,
told as such.
"""

from __future__ import annotations

import math

import numpy as np
import pytest

import vfife
from vfife_validation.verification.chaotic import striking
from vfife_validation.verification.guides import flores, let_go

pytestmark = pytest.mark.verify


@pytest.mark.parametrize("restitution, friction, chaotic", [(0.1, 0.1, False), (0.9, 0.0, True)])
def test_a_block_with_play_is_chaotic_where_impacts_are_nearly_ideal(restitution, friction, chaotic):
    """Farahanchi and Shaw (Journal of Sound and Vibration 177 (1994) 307-324) by their abstract: chaos at
    high speed, low friction and nearly ideal impacts; periodic motions at low restitution. Here with the
    sizes of Flores, Leine and Glocker at 150 rad/s; no number of theirs is compared.
    """
    m = flores(0.0)
    m.drive("crank", speed=150.0)
    rough = (
        vfife.laws.Ambrosio(coefficient=friction, v0=1e-3, v1=1e-2) if friction else vfife.laws.Frictionless()
    )
    m.clearance_slider(
        "S",
        "ground.O",
        "block.center",
        clearance=1e-3,
        length=0.1,
        height=0.05,
        contact=striking(restitution, 1e7),
        friction=rough,
        corner_radius=1e-4,
    )
    given = {
        "count": 2,
        "turns": 60,
        "dropped": 30,
        "series": ["block.y", "block.angle"],
        "step": 2.0 * math.pi / 150.0 / 10000,
    }
    found = vfife.bifurcation(m, "body.block.inertia", 2.7e-6, 2.71e-6, **given)
    assert all((low > 0.0) is chaotic for low in found.exponents[..., 1].ravel().tolist()), found.exponents
    if not chaotic:
        assert all(kind.startswith("period") for way in found.kinds for kind in way), found.kinds


@pytest.mark.parametrize(
    "begin, wall, speed", [(0.0, 1.0, 0.8294), (0.015, -1.0, 0.6448), (0.035, 1.0, 0.9332)]
)
def test_impacts_are_as_fast_as_a_program_of_rigid_contacts_has_them(begin, wall, speed):
    """Siconos' reference result of the slider-crank of Flores, Leine and Glocker, steps of 0.1 ms: within
    three per cent.
    """
    seen = let_go(150.0, 0.4, 0.045)
    first = int(np.argmax((seen.time > begin) & (wall * seen.body("block", "y") > 1e-3)))
    assert abs(seen.speed("block", "v")[first - 1]) == pytest.approx(speed, rel=0.03)
