"""Ensembles: the bits of single runs whatever the lanes, steady turns found, memory that does not grow."""

import dataclasses
import math

import numpy as np
import pytest

from support import SQUARE, bits, four_bar, journal_in_bearing
from vfife.assembly.assemble import assemble
from vfife.assembly.reassemble import reassembled
from vfife.compiler.runtime import loops
from vfife.laws import Ambrosio, LankaraniNikravesh, Pereira
from vfife.solvers.ensemble import advance, ensemble, placed
from vfife.solvers.repeating import distance
from vfife.solvers.transient import run

BARS = {"section": SQUARE, "release": "both", "stiffness_factor": 1000.0}
TURNS, OUTPUTS = 4, 40


def bars(clearance: float = 2e-4, **joint):
    """The paper's links with three loose joints, which settle within three or four turns."""
    options = {"axial_length": 5e-3, "friction_moment": "off"} | joint
    laws = {"contact": Pereira(restitution=0.5), "friction": Ambrosio(coefficient=0.1, v0=0.01, v1=0.1)}
    return four_bar("BCD", "two-particle", clearance=clearance, below=True, joint=options, **laws, **BARS)


VARIANTS = [
    bars(1e-4),
    bars(2e-4),
    bars(5e-4),
    bars(2e-4, axial_length=8e-3),
    bars(3e-4, friction_moment="mid-overlap"),
]
STEPS = [1e-6, 1e-6, 1e-6, 1e-6, 1e-6]


@pytest.fixture(scope="module")
def single():
    """Each variant by itself in the data-driven loop, all turns."""
    return [run(placed(m, 1e-6, TURNS, OUTPUTS), loop="data-driven") for m in VARIANTS]


@pytest.mark.parametrize(("loop", "lanes", "workers"), [("generated", 4, 2), ("data-driven", 1, 2)])
def test_members_are_single_runs_to_the_bit(single, loop, lanes, workers):
    """Five cases in four lanes, one batch of them padded, on two threads: the last turn and the extremes of
    every turn.
    """
    cases = ensemble(
        VARIANTS, step=STEPS, turns=TURNS, outputs=OUTPUTS, loop=loop, lanes=lanes, workers=workers
    )
    for case, record in zip(cases, single, strict=True):
        assert (bits(case.last.rows) == bits(record.rows[-OUTPUTS - 1 :])).all()
        assert (case.last.steps == record.steps[-OUTPUTS - 1 :]).all()
        alpha = record.block("body_alpha_max")[1:].reshape(TURNS, OUTPUTS, -1).max(axis=1)
        assert (case.turns.block("body_alpha_max")[1:] == alpha).all()
        assert (case.turns.block("particle_x")[1:] == record.block("particle_x")[OUTPUTS::OUTPUTS]).all()


def test_a_member_does_not_depend_on_those_beside_it():
    """Alone, and beside one that settles later and one that diverges: same bits, same end."""
    coupler = dataclasses.replace(bars().bodies["coupler"], stiffness_factor=1e6)
    wild = dataclasses.replace(VARIANTS[1], bodies=VARIANTS[1].bodies | {"coupler": coupler})
    options = {"step": 1e-6, "turns": 12, "outputs": OUTPUTS, "tolerance": 1e-3, "loop": "generated"}
    alone = ensemble(VARIANTS[:1], **options)[0]
    beside, unstable, other = ensemble([VARIANTS[0], wild, VARIANTS[2]], **options)
    assert (bits(alone.last.rows) == bits(beside.last.rows)).all()
    assert alone.settled == beside.settled and other.settled is not None
    assert unstable.status == "diverged" and unstable.settled is None and beside.status == "complete"


def test_steady_turns_are_found_where_they_are():
    """The first turn within the tolerance is the last one stepped; the next would be within it, too, and the
    turn before was not.
    """
    found = ensemble([VARIANTS[1]], step=1e-6, turns=12, outputs=OUTPUTS, tolerance=1e-3)[0]
    longer = ensemble([VARIANTS[1]], step=1e-6, turns=found.settled + 1, outputs=OUTPUTS)[0]
    assert 2 < found.settled < 8 and len(found.distances) == found.settled
    assert (longer.distances[: found.settled] == found.distances).all()
    assert (
        math.isinf(found.distances[0])
        and (found.distances[1:-1] > 1e-3).all()
        and found.distances[-1] <= 1e-3
    )
    assert longer.distances[-1] <= 1e-3 and longer.settled is None


def test_memory_does_not_grow_with_turns():
    short, long = (ensemble([VARIANTS[1]], step=1e-6, turns=n, outputs=OUTPUTS)[0] for n in (2, 6))
    assert short.last.rows.shape == long.last.rows.shape == (OUTPUTS + 1, len(short.last.row_numbers))
    assert len(long.turns.rows) == 7


def test_lanes_may_differ_in_crank_speed_and_step():
    """A crank half as fast with twice the step has as many steps a turn: same lanes, other step."""
    cases = ensemble(
        [bars(), four_bar("BCD", speed=25 * math.pi), four_bar("BCD")],
        step=[2e-6, 4e-6, 2e-6],
        turns=1,
        outputs=OUTPUTS,
    )
    assert cases[1].assembly.choice.step == pytest.approx(2 * cases[2].assembly.choice.step)
    assert cases[1].assembly.choice.steps == cases[2].assembly.choice.steps == 20000
    alone = run(cases[1].assembly, loop="data-driven")
    assert (bits(alone.rows) == bits(cases[1].last.rows)).all()


def test_the_step_divides_the_turn():
    """2.3 us is shortened so that each of 40 outputs a turn holds a whole number of steps."""
    choice = placed(four_bar("BCD"), 2.3e-6, 3, OUTPUTS).choice
    assert choice.step == pytest.approx(0.04 / (40 * math.ceil(0.04 / 40 / 2.3e-6)), rel=1e-12)
    assert choice.steps * choice.step == pytest.approx(0.12, rel=1e-12)


def test_a_mechanism_without_a_driver_is_refused():
    with pytest.raises(ValueError, match="journal in bearing: an ensemble counts turns of a crank"):
        ensemble([journal_in_bearing()], step=1e-6, turns=2)


def test_progress_and_interruption():
    """Progress comes as cases end; Ctrl-C out of it ends the ensemble."""
    told = []
    ensemble(
        VARIANTS[:2],
        step=1e-6,
        turns=1,
        outputs=OUTPUTS,
        progress=lambda done, total: told.append((done, total)),
    )
    assert told[-1] == (2, 2)

    def stop(done, total):
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        ensemble(VARIANTS, step=1e-6, turns=2, outputs=OUTPUTS, loop="data-driven", workers=1, progress=stop)


def test_refitted_is_assembled_to_the_bit():
    changed = bars(4e-4, axial_length=7e-3, friction_moment="surface", impact_speed_floor=2e-3)
    ours = reassembled(placed(bars(), 1e-6, 2, OUTPUTS), changed.clearances)
    theirs = placed(changed, 1e-6, 2, OUTPUTS)
    assert (bits(ours.state) == bits(theirs.state)).all() and ours.topology == theirs.topology
    assert ours.mechanism.clearances == changed.clearances


def test_refitting_refuses_what_it_cannot_do():
    base = assemble(bars(), 1e-6, force_step=True)
    other = {
        name: dataclasses.replace(joint, contact=LankaraniNikravesh())
        for name, joint in bars().clearances.items()
    }
    with pytest.raises(ValueError, match="other numbers of .*B.* kinds of laws"):
        reassembled(base, other)
    seated = dataclasses.replace(bars(), start=dataclasses.replace(bars().start, journals="seated"))
    with pytest.raises(ValueError, match="starts seated"):
        reassembled(assemble(seated, 1e-6, force_step=True), seated.clearances)


def test_distance_of_two_turns():
    before, after = (
        np.array([[1.0, 0.0, -4.0], [2.0, 0.0, 1.0]]),
        np.array([[1.0, 0.0, -5.0], [1.5, 0.0, 1.0]]),
    )
    assert distance(before, after) == pytest.approx(0.25)
    assert distance(before, before) == 0.0


def test_advance_keeps_the_order_of_its_members():
    """Cases of two topologies, mixed: each comes back where it was put."""
    mixed = [bars(1e-4), four_bar("BCD"), bars(5e-4), four_bar("C")]
    cases = advance([placed(m, 2e-6 if k % 2 else 1e-6, 1, OUTPUTS) for k, m in enumerate(mixed)])
    assert [case.assembly.mechanism for case in cases] == mixed


@pytest.mark.system("compiles several loops")
def test_several_topologies_may_be_prepared_at_once():
    """The steps of four topologies are written out by four threads that have nothing to go by; Python 3.11
    cannot parse in two at once.
    """
    mixed = [bars(), four_bar("BCD"), four_bar("C"), four_bar("BC")] * 2
    for _ in range(2):
        loops.straight_line.cache_clear()
        cases = ensemble(mixed, step=1e-5, turns=1, outputs=10, loop="generated", lanes=1, workers=8)
    assert (bits(cases[1].last.rows) == bits(cases[5].last.rows)).all()
