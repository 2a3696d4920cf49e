"""Cases of a batch have the bits of each alone, those that cannot be closed as well as those that can."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np
import pytest

from choice import default_cases
from vfife import gallery
from vfife.assembly.assemble import assemble, assemble_all
from vfife.assembly.assembled import Assembly
from vfife.errors import VfifeError
from vfife.kinematics import initial
from vfife.kinematics.batch import Shared
from vfife.kinematics.drives import rigid_system
from vfife.kinematics.guess import first_guess
from vfife.kinematics.initial import Motion, attempt, ideal_motion, ideal_motions, motions
from vfife.kinematics.system import equations, rows_of
from vfife.model.bodies import Link
from vfife.model.mechanism import Mechanism

COUNT = 8
NAMES = (
    "four_bar_case_b",
    "slider_crank_loose_pin",
    "six_bar_press",
    "scissor_lift",
    "quick_return",
    "scotch_yoke",
    "gear_train",
    "compressor",
)


def resized(name: str, share: float = 0.01, seed: int = 1) -> list[Mechanism]:
    """A mechanism of the gallery with links of random lengths: up to so much longer or shorter."""
    rng, base = np.random.default_rng(seed), getattr(gallery, name)()
    results = []
    for _ in range(COUNT):
        bodies = {
            key: dataclasses.replace(body, length=body.length * (1.0 + share * rng.uniform(-1.0, 1.0)))
            if isinstance(body, Link)
            else dataclasses.replace(body, angle=body.angle * (1.0 + share * rng.uniform(-1.0, 1.0)))
            for key, body in base.bodies.items()
        }
        results.append(dataclasses.replace(base, bodies=bodies))
    return results


def same(one: Motion, other: Motion) -> bool:
    """Whether two motions are one, to the bit."""
    arrays = ("position", "velocity", "acceleration")
    alike = all(getattr(one, name).tobytes() == getattr(other, name).tobytes() for name in arrays)
    return alike and (one.reaction, one.torque, one.mobility) == (
        other.reaction,
        other.torque,
        other.mobility,
    )


@pytest.mark.parametrize("name", NAMES)
def test_rows_of_a_batch_are_those_of_each_case(name: str) -> None:
    """phi, G and gamma next to closed positions, with velocities."""
    mechanisms = resized(name)
    systems = [rigid_system(one) for one in mechanisms]
    position = np.array([first_guess(one) for one in mechanisms])
    velocity = np.cos(np.arange(position.size)).reshape(position.shape)
    velocity[:, 0] = 0.0
    rows = rows_of(systems)
    phi, entries = rows.at(position)
    gamma, matrices = rows.gamma(position, velocity), rows.dense(entries)
    for k, system in enumerate(systems):
        alone = equations(system, position[k], velocity[k])
        ours, theirs = (phi[k], matrices[k], gamma[k]), (alone.phi, alone.jacobian, alone.gamma)
        assert [one.tobytes() for one in ours] == [one.tobytes() for one in theirs]


@pytest.mark.parametrize("name", NAMES)
def test_starts_of_a_batch_are_those_of_each_case(name: str) -> None:
    mechanisms = resized(name)
    for one, found in zip(mechanisms, ideal_motions(mechanisms), strict=True):
        alone = attempt(ideal_motion, one)
        if isinstance(alone, VfifeError):
            assert str(found) == str(alone)
        else:
            assert isinstance(found, Motion) and same(found, alone)


def test_a_case_that_cannot_close_has_its_own_message_and_the_others_their_motion() -> None:
    mechanisms = resized("four_bar_ideal", 0.6, seed=4)
    motions = ideal_motions(mechanisms)
    messages = [str(attempt(ideal_motion, one)) for one in mechanisms]
    faults = [k for k, one in enumerate(motions) if isinstance(one, VfifeError)]
    assert 0 < len(faults) < COUNT
    assert all("joints stay open" in messages[k] and str(motions[k]) == messages[k] for k in faults)
    assert len({messages[k] for k in faults}) == len(faults)
    for k, motion in enumerate(motions):
        assert isinstance(motion, VfifeError) or same(motion, ideal_motion(mechanisms[k]))


def test_a_case_whose_numbers_leave_all_bounds_leaves_the_others_their_motion(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Linear algebra refuses a batch with one infinite number as a whole."""
    mechanisms = resized("four_bar_case_b")

    def strict(starts: Any, places: Any, shared: Shared) -> Any:
        if any(one.mechanism is mechanisms[3] for one in starts):
            raise ValueError("infinite numbers")
        return motions(starts, places, shared)

    monkeypatch.setattr(initial, "motions", strict)
    for k, motion in enumerate(ideal_motions(mechanisms)):
        if k == 3:
            assert isinstance(motion, VfifeError) and str(motion) == "infinite numbers"
        else:
            assert isinstance(motion, Motion) and same(motion, ideal_motion(mechanisms[k]))


@pytest.mark.parametrize(
    "name",
    default_cases(
        NAMES,
        lambda name: name in ("four_bar_case_b", "gear_train", "scotch_yoke", "quick_return"),
        "assembles every mechanism many times",
    ),
)
def test_assemblies_of_a_batch_are_those_of_each_case(name: str) -> None:
    mechanisms = resized(name)
    none: list[Any] = [None] * COUNT
    together = assemble_all(mechanisms, None, expected=[{}] * COUNT, motions=none, turns=1.0)
    for one, found in zip(mechanisms, together, strict=True):
        alone = attempt(assemble, one, turns=1.0)
        if isinstance(alone, VfifeError):
            assert str(found) == str(alone)
        else:
            assert isinstance(found, Assembly) and found.state.tobytes() == alone.state.tobytes()
            assert (found.topology, found.choice, found.shared) == (
                alone.topology,
                alone.choice,
                alone.shared,
            )
