"""Wear over many turns: in proportion to them until geometry follows, conserved volumes, worn models, lives,
files that go on.
"""

import dataclasses
import math
from functools import cache

import numpy as np
import pytest

import vfife
from vfife.assembly.assemble import assemble
from vfife.errors import ModelError, VfifeError
from vfife.model.wear import Wear, depth_at
from vfife.modelfile import dump, loads
from vfife.report.wear import document
from vfife.simulation.turn_steps import step_count
from vfife.solvers.interrupts import Interrupts
from vfife.tribology.simulate_wear import FINER, WearSimulation, load_wear, wear, wearing_surfaces
from vfife.tribology.wear_state import (
    ANGLES,
    PLACES,
    WearSpec,
    clearances,
    harmonics_of,
    jackson,
    profiles,
    sharpness,
    smooth,
    surfaces_of,
)

SOFT, HARD = 1e-15, 2e-16  # 1/Pa
GIVEN = {"block": 2, "settle": 2, "step": 5e-6}


def loose_pin(own: Wear | None = None) -> vfife.Mechanism:
    """A slider-crank whose pin has clearance and rubs."""
    m = vfife.gallery.slider_crank_loose_pin(friction=0.05, clearance=2e-4, restitution=0.5)
    m.joints["pin"] = dataclasses.replace(m.joints["pin"], wear=own or Wear(bearing=SOFT, journal=HARD))
    return m


@cache
def worn(turns: float = 4e6, **more):
    return wear(loose_pin(), turns, **GIVEN | more)


@cache
def far():
    """Ten times as worn: a quarter of the clearance."""
    return wear(
        loose_pin(Wear(bearing=10.0 * SOFT, journal=10.0 * HARD)), 1.6e6, block=1, settle=1, step=5e-6
    )


def test_a_profile_from_the_start_keeps_its_harmonics():
    """(mean, a_1, b_1, a_2, b_2) of surfaces that have lost nothing since; what was lost evenly is added to
    the mean.
    """
    own = loose_pin(Wear(bearing=SOFT, journal=HARD, bearing_profile=(5e-6, 1e-6, 2e-6, 3e-6, 4e-6)))
    found = surfaces_of(own)
    (cosines, sines), (other, _) = profiles(found, np.stack([np.zeros(PLACES), np.full(PLACES, 7e-6)]), 4)
    assert cosines == pytest.approx([5e-6, 1e-6, 3e-6, 0.0], abs=1e-18) and sines == pytest.approx(
        [0.0, 2e-6, 4e-6, 0.0], abs=1e-18
    )
    assert other == pytest.approx([7e-6, 0.0, 0.0, 0.0], abs=1e-18)
    (few, _), _ = profiles(found, np.zeros((2, PLACES)), 2)
    assert few == pytest.approx([5e-6, 1e-6], abs=1e-18)


def volume_rate(found) -> np.ndarray:
    """Volume a turn, over that of the new machine."""
    return found.rate.sum(axis=(1, 2)) / found.rate[0].sum()


def reshaped(found) -> np.ndarray:
    """Largest change of the rate around the surfaces, smoothed, as a share of that of the new machine."""
    first = smooth(found.rate[0], 8).max()
    return np.array([np.abs(smooth(rate - found.rate[0], 8)).max() / first for rate in found.rate])


def test_depths_go_with_the_turns_until_geometry_follows():
    """As long as next to nothing is worn, and ever without feedback, rates differ by no more than blocks of a
    chaotic motion do; later they do.
    """
    for found in (worn(1e6, harmonics=0), worn(4e4)):
        assert volume_rate(found) == pytest.approx(1.0, abs=0.06) and reshaped(found).max() < 0.1
        even = smooth(0.5 * found.turns[-1] * (found.rate[0] + found.rate[-1]), 8)
        assert smooth(found.depth[-1], 8) == pytest.approx(even, abs=0.1 * even.max())
    assert reshaped(far())[-1] > 0.15 and far().force[-1, 0] > far().force[0, 0]
    assert (far().errors <= 0.01 * 2e-4).all() and len(far().turns) > 4
    # The motion is chaotic: of 40 clearances that differ by 1e-13 the largest share lies between 0.0006 and
    # 0.073, above 0.01 for every other one.
    assert max(far().step_difference) < 0.1, (
        "half the step wears the same surfaces the same: as round ones they would lose 14 % elsewhere"
    )


def test_a_steady_motion_wears_in_exact_proportion():
    """A ring on a shaft: the volume of a turn is k m g 2 pi R_J, however much the bearing is worn; its
    journal stays round.
    """
    m = vfife.Mechanism("ring on a shaft", gravity=(0.0, -9.81))
    m.point("O", 0.0, 0.0)
    m.rigid_body("shaft", mass=1.0, inertia=1e-4, pins={"axis": (0.0, 0.0)})
    m.rigid_body("ring", mass=2.0, inertia=1e-3, pins={"bore": (0.0, 0.0)})
    m.revolute("O", "ground.O", "shaft.axis")
    m.slider("guide", "ground.O", "ring.bore", direction=(0.0, 1.0))
    wears = {"bearing": SOFT, "journal": HARD}
    m.clearance_joint(
        "bore",
        "ring.bore",
        "shaft.axis",
        clearance=1e-4,
        bearing_radius=0.01,
        wear=wears,
        friction={"law": "none"},
        contact={"law": "lankarani-nikravesh", "restitution": 0.3},
    )
    m.drive("shaft", speed=100.0)
    m.start = dataclasses.replace(m.start, journals="seated")
    turns = 2e6
    found = wear(m, turns, block=1, settle=1, step=1e-5)
    volume = HARD * 2.0 * 9.81 * 2.0 * math.pi * 0.0099 * found.turns
    assert found.volume("bore", "journal") == pytest.approx(volume, rel=1e-3, abs=0.0)
    assert found.volume("bore", "bearing") == pytest.approx(volume * SOFT / HARD, rel=1e-3, abs=0.0)
    assert smooth(found.depth[-1], 8)[1] == pytest.approx(HARD * 2.0 * 9.81 / 0.02 * turns, rel=0.02, abs=0.0)
    assert max(found.step_difference) < 1e-3, "half the step wears the same"
    assert np.degrees(ANGLES[smooth(found.depth[-1], 8)[0].argmax()]) == pytest.approx(90.0, abs=2.0)


def test_volumes_are_as_the_coefficients():
    found = worn()
    assert found.volume("pin", "bearing")[1:] / found.volume("pin", "journal")[1:] == pytest.approx(
        SOFT / HARD, rel=1e-9, abs=0.0
    )
    assert (found.depth >= 0.0).all() and (np.diff(found.clearance[:, 0]) > 0.0).all()
    with pytest.raises(ValueError, match="no surface pin wall wears; there are pin bearing, pin journal"):
        found.volume("pin", "wall")


def test_the_volume_of_a_turn_is_k_times_what_a_run_rubs():
    """The rate at the start is that of turns 3 and 4 of a simulation."""
    found = worn(4e4)
    m = loose_pin()
    alone = vfife.simulate(
        m,
        turns=4,
        outputs=360,
        step=2.0 * math.pi / 100.0 / found.spec.steps,
        companions=0,
        reference=False,
        force_step=True,
    )
    work = alone.record.block("wear_work")[:, 0]
    rate = found.rate[0, 0].mean() * 2.0 * math.pi * 0.01 * 0.02
    assert rate == pytest.approx(SOFT * (work[-1] - work[2 * 360]) / 2.0, rel=1e-9, abs=0.0)


def test_the_worn_model_has_the_geometry_of_its_last_block():
    """What a worn model assembles is what was written into the state between blocks, to rounding; its profile
    holds the volume.
    """
    found = worn()
    model = found.mechanism()
    assembly = assemble(model, 1e-6, turns=1, force_step=True)
    written = harmonics_of(surfaces_of(loose_pin()), found.depth[-1], 8, assembly)
    for part, values in zip(("cosine", "sine"), written, strict=True):
        assert assembly.state[assembly.layout.rows_of(f"harmonic_{part}")] == pytest.approx(values, abs=1e-18)
    pin = model.contacts["pin"].wear
    assert (
        pin.bearing_profile[0] == pytest.approx(found.depth[-1, 0].mean(), rel=1e-9, abs=0.0)
        and len(pin.bearing_profile) == 15
    )
    assert loose_pin().contacts["pin"].wear.bearing_profile == ()
    assert loads(dump(model)).contacts["pin"].wear == pin


def test_what_a_joint_had_before_stays():
    """A profile that the model has from the start is part of every depth, and of the worn model."""
    own = Wear(bearing=SOFT, bearing_profile=(1e-5, 2e-6, 0.0))
    found = wear(loose_pin(own), 1e4, **GIVEN)
    before = depth_at(own.bearing_profile, ANGLES)[0]
    assert found.depth[0, 0] == pytest.approx(before) and found.clearance[0, 0] == pytest.approx(
        2e-4 + 1.2e-5, rel=1e-4, abs=0.0
    )
    assert found.mechanism(0).contacts["pin"].wear.bearing_profile[:3] == pytest.approx(own.bearing_profile)
    assert [one.side for one in found.surfaces] == ["bearing"]


def test_a_life_ends_at_its_limit():
    """The clearance at the end is the limit; of a force the turns are between the two points around it."""
    found = worn(clearance=2.06e-4)
    assert (
        found.life_end["by"] == "clearance"
        and found.clearance[-1, 0] == pytest.approx(2.06e-4, rel=1e-9, abs=0.0)
        and found.complete
    )
    assert 0.0 < found.life_end["turns"] < 4e6 and found.turns[-1] == found.life_end["turns"]
    limit = 0.5 * (worn().force[0, 0] + worn().force.max())
    pressed = worn(force=limit)
    assert (
        pressed.life_end["by"] == "force"
        and pressed.turns[-2] < pressed.life_end["turns"] <= pressed.turns[-1]
    )
    assert pressed.force[-1, 0] >= limit > pressed.force[-2, 0]


def test_it_goes_on_where_it_was_broken_off(tmp_path):
    """To the bit; a file that asks something else is not touched, and one of another kind is told."""

    def stop(known: float, turns: float, simulated: int) -> None:
        if known > 0.0:
            raise KeyboardInterrupt

    path = tmp_path / "a.wear"
    part = wear(loose_pin(), 4e6, **GIVEN, file=path, progress=stop)
    assert not part.complete and len(part.turns) == 2
    whole = wear(loose_pin(), 4e6, **GIVEN, file=path)
    assert (
        np.array_equal(whole.depth, worn().depth)
        and np.array_equal(whole.force, worn().force)
        and whole.simulated == worn().simulated
    )
    assert np.array_equal(load_wear(path).depth, whole.depth) and part.step_difference == ()
    assert (
        load_wear(path).step_difference == whole.step_difference == worn().step_difference
        and 0.0 < worn().step_difference[0] < 0.1
        and worn().step_difference[1] < 0.3
    )
    before = path.read_bytes()
    with pytest.raises(VfifeError, match="there is a wear file here with another specification"):
        wear(loose_pin(), 5e6, **GIVEN, file=path)
    assert path.read_bytes() == before
    whole.write_csv(tmp_path / "a.csv")
    assert len((tmp_path / "a.csv").read_text().splitlines()) == 1 + len(whole.turns) * 2 * PLACES


def test_what_cannot_wear_is_told_at_once():
    m = vfife.gallery.slider_crank_loose_pin()
    with pytest.raises(ModelError) as told:
        wear(m, 0.5, block=0, tolerance=2.0)
    assert [fault.where for fault in told.value.faults] == ["joint", "turns", "block", "tolerance"]
    with pytest.raises(ModelError, match="a joint has as much clearance at the start"):
        wear(loose_pin(), 1e6, clearance=1e-4)


def test_smoothed_depths_are_nowhere_negative_and_lose_nothing():
    """Jackson's kernel: a single deep place stays positive all around, and its volume is kept."""
    depth = np.zeros((1, PLACES))
    depth[0, 100] = 1.0
    for harmonics in (1, 4, 8, 32):
        found = smooth(depth, harmonics)
        assert (
            found.min() > -1e-15
            and found.sum() == pytest.approx(1.0)
            and jackson(harmonics)[0] == pytest.approx(1.0)
        )
    assert np.argmax(smooth(depth, 32)) == 100


def test_a_profile_of_a_displaced_journal_is_as_sharp_as_the_journal():
    """h = a cos(phi): -h'' = a, over clearance and depth."""
    m = loose_pin(Wear(bearing=SOFT, bearing_profile=(0.0, 5e-5, 0.0)))
    found = surfaces_of(m)
    assert sharpness(found, np.zeros((1, PLACES)), 4) == pytest.approx(5e-5 / 2.5e-4, rel=1e-3, abs=0.0)
    assert profiles(found, np.zeros((1, PLACES)), 4)[0][0] == pytest.approx([0.0, 5e-5, 0.0, 0.0])


def test_more_harmonics_are_advised_only_while_the_journal_fits_into_the_groove():
    """A groove of 40° and 5 µm fits; the same of two clearances is narrower than the journal."""
    found = worn(4e4)
    groove = np.where(np.abs(ANGLES) < math.radians(20.0), np.cos(4.5 * ANGLES), 0.0)
    shown = {}
    for depth in (1e-6, 2.0 * found.surfaces[0].clearance):
        depths = found.depth.copy()
        depths[-1, 0] += depth * groove
        clearance = np.array([clearances(found.surfaces, one, found.spec.harmonics) for one in depths])
        text = str(document(dataclasses.replace(found, depth=depths, clearance=clearance)).parts)
        shown[depth] = "--harmonics 16" in text, "More of them do not help" in text
    assert list(shown.values()) == [(True, False), (False, True)]


def test_a_life_has_the_range_of_the_shapes_that_its_volume_permits():
    """By hand: a groove deepens by 10 and the mean by 0.1 nm a turn; 20 µm need 2,000 and 200,000 turns. The
    range has the life of a journal that beds into its bearing, whatever the number of harmonics.
    """
    found = worn(4e4)
    turns = found.turns
    depth = np.zeros_like(found.depth)
    depth[:, 0, :] = 1e-10 * turns[:, None]
    depth[:, 0, 180] += 9.9e-9 * turns
    clearance = found.surfaces[0].clearance
    mean = 1e-10 + 9.9e-9 / PLACES
    for harmonics in (4, 8, 16):
        spec = dataclasses.replace(found.spec, harmonics=harmonics)
        smoothed = np.array([clearances(found.surfaces, one, harmonics) for one in depth])
        life = dataclasses.replace(found, depth=depth, clearance=smoothed, spec=spec).life(
            "pin", clearance + 2e-5
        )
        assert life.deepest == pytest.approx(2e-5 / 1e-8) and life.uniform == pytest.approx(2e-5 / mean)
        assert not life.determined and (life.shortest, life.longest) == (life.deepest, life.uniform)
        assert life.shortest < life.smoothed < life.longest


def test_a_groove_deeper_than_the_clearance_is_in_the_headline():
    """One place in 360 that is worn by 18 clearances: the smoothed clearance hardly grows."""
    found = worn(4e4)
    (joint,), clearance = found.joints, found.surfaces[0].clearance
    assert "groove" not in document(found).title
    assert "largest force (not estimated)" in str(document(found).parts)
    depth = found.depth.copy()
    depth[-1, 0, 0] += 18.0 * clearance
    title = document(dataclasses.replace(found, depth=depth)).title
    assert f"the groove in {joint}, {18e6 * clearance:.3g} µm deep, is 18 times its clearance" in title


def test_the_answer_names_joints_whose_wear_is_not_computed():
    """A block in a guide loses volume but has no profile."""
    m = loose_pin()
    m.joints["guide"] = vfife.gallery.slider_crank_loose_guide().joints["guide"]
    answer = str(document(wear(m, 1e5, block=1, settle=1, step=1e-5)).parts)
    assert "The wear of guide is not computed here" in answer
    assert "is not computed here" not in str(document(worn()).parts)


def test_a_forecast_ends_at_the_limit_of_the_clearance():
    """A billion turns are requested, and the pin has a tenth more clearance after a few jumps: forecast and
    time left are of these, the range covers all turns, and both shrink as the limit comes near.
    """
    m = loose_pin(Wear(bearing=10.0 * SOFT, journal=10.0 * HARD))
    spec = WearSpec(dump(m), 1e9, block=1, settle=1, clearance=2.2e-4)
    surfaces = wearing_surfaces(m, spec)
    spec = dataclasses.replace(spec, steps=-(-step_count([m], 5e-6) // PLACES) * PLACES)
    with Interrupts() as interrupts:
        simulation = WearSimulation(m, spec, surfaces, interrupts)
        forecast = simulation.forecast(simulation.pilot(), None)
        left, progress = [], []
        for k, point in enumerate(simulation.points([], None)):
            left.append(simulation.blocks_to(point, simulation.expected_end(point)))
            progress.append(simulation.progress(point, float(k)))
    assert point.numbers["ended"]["by"] == "clearance"
    made = simulation.blocks.turns / 2.0 + FINER
    assert made / 1.5 < forecast.count < 1.5 * made < 100
    assert forecast.ends[0] <= 2.0 * simulation.turn_seconds * made <= forecast.ends[1]
    assert forecast.ends[1] > 100.0 * forecast.seconds and ", up to " in forecast.note
    assert all(after < before for before, after in zip(left[:-1], left[1:], strict=True)), left
    assert progress[-1].share == 1.0 and progress[len(progress) // 2].share > 0.3
    assert (
        " left" in progress[1].text and "at most" not in progress[1].text and "left" not in progress[-1].text
    )
