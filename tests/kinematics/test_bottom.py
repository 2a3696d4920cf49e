"""Where a mechanism cannot close, the descent ends at the bottom of |phi|^2 as soon as it is
near; it ends nowhere else.
"""

import numpy as np
import pytest

from vfife import gallery
from vfife.errors import AssemblyError
from vfife.kinematics import descent
from vfife.kinematics.descent import bottom
from vfife.kinematics.drives import rigid_system
from vfife.kinematics.guess import first_guess
from vfife.kinematics.passage import sized
from vfife.kinematics.solve import close


def of(function, slopes):
    return lambda at: (function(*at), np.array(slopes(*at), dtype=float))


def test_the_bottom_of_a_bowl_is_found():
    """f = 1 + (x - 0.1)^2 + 4 (y + 0.05)^2 + (x - 0.1)^4."""
    found = bottom(
        of(lambda x, y: 1.0 + (x - 0.1) ** 2 + 4.0 * (y + 0.05) ** 2 + (x - 0.1) ** 4,
           lambda x, y: (2.0 * (x - 0.1) + 4.0 * (x - 0.1) ** 3, 8.0 * (y + 0.05))),
        1.0, 2,
    )  # fmt: skip
    assert found == pytest.approx([0.1, -0.05], abs=1e-9)


@pytest.mark.parametrize(
    ("function", "slopes", "why"),
    [
        (lambda x, y: 1.0 + x * x - 0.01 * y * y, lambda x, y: (2.0 * x, -0.02 * y), "a saddle"),
        (lambda x, y: 1.0 + x * x - 0.1 * y, lambda x, y: (2.0 * x, -0.1), "a slope that goes on"),
        (lambda x, y: 1.0 + (x - 0.3) ** 2 + y * y, lambda x, y: (2.0 * (x - 0.3), 2.0 * y), "too far"),
        (
            lambda x, y: 0.001 + 5.0 * (x - 0.1) ** 2 + y * y,
            lambda x, y: (10.0 * (x - 0.1), 2.0 * y),
            "much deeper than here",
        ),
        (
            lambda x, y: 1.0 + 2000.0 * x * x - 0.02 * y * y,
            lambda x, y: (4000.0 * x, -0.04 * y),
            "a saddle beside a drive's weight",
        ),
    ],
)
def test_what_is_no_bottom_is_none(function, slopes, why):
    assert bottom(of(function, slopes), 1.0, 2) is None, why


def bowl(*, at=0.1, floor=1.0, slope=0.0):
    """f = floor + (x - at)^2, with a slope along y that does not change."""
    return of(lambda x, y: floor + (x - at) ** 2 + slope * y, lambda x, y: (2.0 * (x - at), slope))


@pytest.mark.parametrize(
    ("near", "beyond"),
    [
        (bowl(slope=0.9e-6), bowl(slope=1.1e-6)),
        (bowl(slope=1.8e-6, floor=4.0), bowl(slope=2.2e-6, floor=4.0)),
        (bowl(at=0.199), bowl(at=0.201)),
        (bowl(floor=0.0102), bowl(floor=0.0098)),
    ],
    ids=["slope", "slope and value", "distance", "share of the value"],
)
def test_a_bottom_is_accepted_up_to_its_limits(near, beyond):
    """A slope of 1e-6 of the root of the value, a fifth of the extent, half of the value."""
    assert bottom(near, 1.0, 2) is not None and bottom(beyond, 1.0, 2) is None


def test_it_gives_up_after_twelve_steps():
    """Newton's method reduces the distance from the bottom of a fourth power by a third in each step. A step
    asks for two gradients: beside the place, and at the next one.
    """
    asked = []

    def slopes(at):
        asked.append(float(at[0]))
        return 1.0 + (at[0] - 0.1) ** 4, 4.0 * (at - 0.1) ** 3

    assert bottom(slopes, 1.0, 1) is None
    assert len(asked) == 1 + 2 * 12
    assert asked[-1] == pytest.approx(0.1 * (1.0 - (2.0 / 3.0) ** 12), rel=1e-3)


def system_of(mechanism):
    return rigid_system(mechanism), np.array(first_guess(mechanism))


@pytest.mark.parametrize(
    ("link", "part"), [("crank", 0.3), ("crank", 3.0), ("coupler", 0.3), ("follower", 3.0)]
)
def test_links_that_cannot_reach_share_the_gap(link, part):
    """The crank lies along the ground. Coupler and follower come to lie there too, and all four joints have a
    quarter of what is missing.
    """
    four_bar = gallery.four_bar_ideal()
    mechanism = sized(four_bar, link, part * four_bar.bodies[link].length)
    crank, coupler, follower = (mechanism.bodies[name].length for name in ("crank", "coupler", "follower"))
    apart = float(np.linalg.norm(np.subtract(mechanism.points["D"], (crank, 0.0))))
    gap = max(apart - coupler - follower, abs(coupler - follower) - apart)
    assert gap > 0.0
    system, guess = system_of(mechanism)
    [found] = descent.descend([system], guess[None])
    assert found.residual == pytest.approx(0.25 * gap, rel=1e-9)
    assert found.iterations < descent.STEPS


def lots(count):
    """Four-bars and slider-cranks of any lengths, from any guesses."""
    random = np.random.default_rng(5)
    for k in range(count):
        mechanism = (gallery.four_bar_ideal, gallery.slider_crank)[k % 2]()
        for name, body in mechanism.bodies.items():
            if hasattr(body, "length"):
                mechanism = sized(mechanism, name, body.length * float(np.exp(0.6 * random.normal())))
        system, guess = system_of(mechanism)
        guess[1:, 2] += random.normal(size=len(guess) - 1)
        yield system, guess


def test_it_closes_what_closes_to_the_same_bits(monkeypatch):
    def told():
        found = []
        for system, guess in lots(12):
            try:
                found.append(close(system, guess, named=False).position.tobytes())
            except AssemblyError:
                found.append(b"")
        return found

    looked = told()
    monkeypatch.setattr(descent, "LOOKS", ())
    assert looked == told()
    assert 2 <= looked.count(b"") <= 10
