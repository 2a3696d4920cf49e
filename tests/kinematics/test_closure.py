"""Where the bodies of an ideal mechanism are: closed on the branch of a guess, mobility, and what does not
close, by its joints and gaps.
"""

from dataclasses import replace

import numpy as np
import pytest

from kinematics.rods import along, at_angle, double_crank, driven, four_bar, rough_guess
from rigid import Drive, Pin, velocities
from vfife.errors import AssemblyError
from vfife.kinematics.mobility import mobility
from vfife.kinematics.solve import close


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_closure_is_the_intersection_of_two_circles(side):
    b, d = np.array([0.4, 0.0]), np.array([0.15, 0.0])
    x = (0.25**2 + 0.46**2 - 0.26**2) / (2.0 * 0.25)
    c = d + np.array([x, side * np.sqrt(0.46**2 - x**2)])
    closure = close(driven(four_bar(), 0.0), rough_guess(side))
    np.testing.assert_allclose(closure.position[2], along(b, c), atol=2e-15)
    np.testing.assert_allclose(closure.position[3], along(d, c), atol=2e-15)
    assert closure.residual < 1e-15
    assert 1 < closure.iterations < 12


def test_a_long_step_stays_on_the_branch_of_the_guess():
    np.testing.assert_allclose(
        close(driven(four_bar(), 1.5), at_angle(0.0)).position, at_angle(1.5), atol=1e-13
    )


def test_a_guess_whole_turns_away_takes_the_angle_of_the_drive():
    guess = at_angle(0.7)
    guess[1, 2] -= 4.0 * np.pi
    guess[0] = 7.0
    np.testing.assert_allclose(close(driven(four_bar(), 0.7), guess).position, at_angle(0.7), atol=1e-14)


def test_wild_guesses_close_on_one_of_the_two_branches():
    upper, lower = at_angle(0.7), at_angle(0.7, -1.0)
    draw = np.random.default_rng(1)
    for _ in range(60):
        position = close(driven(four_bar(), 0.7), draw.normal(size=(4, 3)) * (1.0, 1.0, 2.0)).position
        found = np.where(abs(position[2, 0] - upper[2, 0]) < abs(position[2, 0] - lower[2, 0]), upper, lower)
        np.testing.assert_allclose(position[:, :2], found[:, :2], atol=1e-12)


@pytest.mark.parametrize("scale", [1e-3, 1e3])
def test_size_does_not_matter(scale):
    system = driven(four_bar(*(scale * length for length in (0.15, 0.4, 0.26, 0.46))), 0.0, 2.0)
    position = close(system, rough_guess() * (scale, scale, 1.0)).position
    here = at_angle(0.0)
    np.testing.assert_allclose(position, here * (scale, scale, 1.0), rtol=1e-13, atol=1e-15 * scale)
    turning = velocities(driven(four_bar(), 0.0, 2.0), here)[:, 2]
    np.testing.assert_allclose(velocities(system, position)[:, 2], turning, rtol=1e-12)
    assert mobility(system, position).free == 1


def test_a_free_mechanism_closes_near_its_guess_and_a_closed_one_stays():
    closed = at_angle(0.7)
    np.testing.assert_array_equal(close(four_bar(), closed).position, closed)
    disturbed = closed + 1e-4 * np.sin(np.arange(12.0)).reshape(4, 3)
    closure = close(four_bar(), disturbed)
    assert closure.residual < 1e-15
    assert np.abs(closure.position - disturbed)[1:].max() < 5e-4


def test_parallel_cranks_report_the_redundant_joint_and_still_move():
    system, position, angle = double_crank()
    result = mobility(driven(system, angle), position)
    assert (result.free, result.after_drives) == (1, 0)
    assert (result.redundant, result.redundant_joints) == (1, ("B3",))
    moving = driven(system, angle, 4.0)
    assert close(moving, position + 0.01).residual < 1e-15
    velocity = velocities(moving, position)
    np.testing.assert_allclose(velocity[1:, 2], [4.0, 4.0, 4.0, 0.0], atol=1e-13)


def test_mobility_of_a_four_bar_is_one_and_none_when_driven():
    position = at_angle(0.7)
    assert mobility(four_bar(), position).after_drives == 1
    result = mobility(driven(four_bar(), 0.7), position)
    assert (result.free, result.after_drives, result.redundant, result.redundant_joints) == (1, 0, 0, ())


def test_flat_parallelogram_gains_a_freedom_at_its_change_point():
    system = four_bar(0.3, 0.2, 0.3, 0.2)
    flat = np.array([[0.0, 0.0, 0.0], [0.1, 0.0, 0.0], [0.35, 0.0, 0.0], [0.4, 0.0, 0.0]])
    assert mobility(system, flat).free == 2
    assert mobility(system, flat).redundant_joints == ("D",)
    opened = close(driven(system, 1e-3), flat).position
    assert mobility(system, opened).free == 1


def test_a_loop_too_short_names_its_joints_and_the_missing_length():
    guess = np.array([[0.0, 0.0, 0.0], [0.0, 0.1, 1.2], [0.3, 0.3, 0.4], [0.9, 0.2, 1.9]])
    with pytest.raises(
        AssemblyError, match=r"C by 100 mm \(with A, B, D closed\).*A, B, C, D cannot reach"
    ) as info:
        close(four_bar(1.0, 0.2, 0.3, 0.4), guess)
    assert info.value.joints == ("C",)
    assert sum(info.value.gaps) == pytest.approx(0.1, rel=1e-9)
    assert isinstance(info.value, ValueError)


def test_a_drive_beyond_its_range_is_blamed_with_the_gap_of_the_other_links():
    system = driven(four_bar(1.0, 0.4, 0.5, 0.5), np.pi / 2.0)
    guess = np.array([[0.0, 0.0, 0.0], [0.1, 0.2, 1.2], [0.4, 0.5, -0.2], [0.8, 0.2, 2.0]])
    with pytest.raises(AssemblyError, match="driven angle of crank") as info:
        close(system, guess)
    assert sum(info.value.gaps) == pytest.approx(np.hypot(1.0, 0.4) - 1.0, rel=1e-8)


def test_a_guess_between_two_branches_is_called_so():
    guess = np.array([[0.0, 0.0, 0.0], [0.2, 0.0, 0.0], [0.53, 0.0, 0.0], [0.38, 0.0, 0.0]])
    with pytest.raises(AssemblyError, match="between two branches"):
        close(driven(four_bar(), 0.0), guess)


def test_bad_input_is_refused():
    good = four_bar()
    with pytest.raises(ValueError, match="one entry for each"):
        replace(good, mass=np.ones(3))
    with pytest.raises(ValueError, match="greater than zero"):
        replace(good, inertia=np.array([0.0, 1.0, 0.0, 1.0]))
    for body, point in ((1, (0.0, 0.0)), (4, (0.0, 0.0)), (0, (0.0, 0.0, 0.0)), (0, (0.0, np.nan))):
        with pytest.raises(ValueError, match=r"joint X must join a point .* of two different bodies"):
            replace(good, joints=[Pin("X", 1, (0.0,) * len(point), body, point)])
    with pytest.raises(ValueError, match="every drive must be finite"):
        replace(good, drives=(Drive(1, np.inf),))
    with pytest.raises(ValueError, match="moving body of its own"):
        replace(good, drives=(Drive(0, 0.0),))
    with pytest.raises(ValueError, match="moving body of its own"):
        replace(good, drives=(Drive(1, 0.0), Drive(1, 0.1)))
    with pytest.raises(ValueError, match=r"guess must .* shape \(4, 3\)"):
        close(good, np.zeros((3, 3)))
