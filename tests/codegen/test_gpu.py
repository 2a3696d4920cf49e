"""One member a thread, on a card that the processor plays: the bits of lanes, whatever batches, launches and looks there are; and what is told."""

import builtins

import numpy as np
import pytest

from fake_card import FakeDriver, on_card
from lane_models import one_clearance, rigid_bars, swing
from support import bits, four_bar, lanes
from vfife.assembly.assemble import assemble
from vfife.codegen import cuda
from vfife.codegen.cuda import Card
from vfife.codegen.gpu import TILE
from vfife.codegen.runner import LOOK, Watched
from vfife.errors import DeviceError
from vfife.laws import LankaraniNikravesh
from vfife.solvers.ensemble import ensemble


def placed(members: int, model=rigid_bars):
    """Members with parameters, steps and starts of their own."""
    return [assemble(model(k % 4), 2e-6 * (1 - 0.05 * (k % 4) - 0.001 * k), duration=1e-3, force_step=True) for k in range(members)]


@pytest.fixture(scope="module")
def members():
    """More than a tile of them, and what they do in lanes."""
    a = placed(TILE + 4)
    here = [lanes(a[k : k + 4], "generated") for k in range(0, len(a), 4)]
    rows = np.concatenate([np.concatenate([one.advance(1, 1), one.advance(50, 12)]) for one in here], axis=2)
    return a, rows, np.concatenate([one.states for one in here], axis=1)


def test_members_are_lanes(members):
    """Between two launches members change places: states that are written are those that go on."""
    a, expected, states = members
    there = on_card(a)
    rows = [there.advance(1, 1), there.advance(50, 5)]
    assert there.states.shape == (there.layout.rows, len(a))
    there.states[:] = there.states[:, ::-1].copy()
    rows.append(there.advance(50, 7)[:, :, ::-1])
    assert (bits(np.concatenate(rows)) == bits(expected)).all()
    state = there.layout.of("state", "memory")
    assert (bits(there.states[state, ::-1]) == bits(states[state])).all()
    assert (expected[-1][[int(row) in set(there.layout["repeated"].tolist()) for row in there.kept]] > 0).any(), "no step was taken again"


def test_batches_and_launches_change_nothing(members):
    """A card with room for one tile at a time and for few outputs."""
    a, expected, _ = members
    tile = 8 * TILE * (2 * on_card(a[:1]).layout.rows + a[0].tables.size + 2)
    driver = FakeDriver(a[0].topology, memory=3 * tile)
    there = on_card(a, driver=driver)
    assert there.batches.batch == 1 and there.batches.most < 12
    rows = np.concatenate([there.advance(1, 1), there.advance(50, 12)])
    assert (bits(rows) == bits(expected)).all()
    assert set(driver.threads) == {TILE} and len(driver.threads) >= 6
    there.advance(50, 1)
    assert len(driver.given) == 10, "memory is used again"
    del there
    assert not driver.given, "and given back"


def test_an_interval_in_several_calls_is_one():
    a = placed(2)
    there, here = on_card(a), lanes(a, "generated")
    here.advance(1, 1)
    there.advance(1, 1)
    assert there.advance(20, 1, record=False).shape == (1, 0, 2)
    assert (bits(there.advance(40, 1, anew=False)) == bits(here.advance(60, 1))).all()


def test_tables_of_their_own_and_first_steps_of_a_share():
    a, shares = placed(4, swing), np.array([0.0, 0.3, 0.7, 0.1])
    assert len({x.tables.tobytes() for x in a}) == 4
    there, here = on_card(a, shares=shares), lanes(a, "generated", shares=shares)
    for count, outputs in ((1, 1), (100, 3)):
        assert (bits(there.advance(count, outputs)) == bits(here.advance(count, outputs))).all()


def test_a_watched_member_that_breaks_stops_no_other():
    """The second leaves its bounds at the first look; the third is looked at by nobody."""
    a = placed(3)
    free = on_card(a)
    expected = np.concatenate([free.advance(1, 1), free.advance(LOOK - 1, 1), free.advance(500, 2)])
    row = int(free.layout["driven_torque"][0])
    bound = np.array([[np.inf, 1e-30, np.inf]])
    watched = Watched(np.array([row], dtype=np.uint32), -bound, bound, np.array([True, True, False]))
    there = on_card(a, watched=watched)
    rows = np.concatenate([there.advance(1, 1), there.advance(LOOK - 1, 1), there.advance(500, 2)])
    assert there.broken.tolist() == [0.0, LOOK, -1.0]
    assert (bits(rows[:, :, 0]) == bits(expected[:, :, 0])).all()
    assert (bits(rows[0]) == bits(expected[0])).all()


def test_an_ensemble_on_a_card_is_one_on_the_processor(monkeypatch):
    """Members that settle, one that goes on to the last turn, one that breaks."""
    made = [four_bar("BCD", clearance=c, speed=500.0) for c in (1e-4, 3e-4)]
    made.append(four_bar("BCD", speed=500.0, contact=LankaraniNikravesh(restitution=0.9, stiffness=6.6e14)))
    options = {"step": 5e-6, "turns": 2, "outputs": 20, "tolerance": 0.3}
    here = ensemble(made, **options)
    monkeypatch.setattr(cuda, "_bindings", lambda: FakeDriver(here[0].assembly.topology))
    cuda.card.cache_clear()
    there = ensemble(made, **options, device="cuda")
    cuda.card.cache_clear()
    assert [one.status for one in there] == [one.status for one in here] and {one.status for one in here} == {"complete", "diverged"}
    for ours, theirs in zip(there, here, strict=True):
        assert (bits(ours.last.rows) == bits(theirs.last.rows)).all() and (bits(ours.turns.rows) == bits(theirs.turns.rows)).all()
        assert ours.settled == theirs.settled


# ------------------------------------------------------------------------------------------------------- what is told


@pytest.fixture(scope="module")
def topology():
    return placed(1, one_clearance)[0].topology


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"cuInit": 100}, ("no card", "nvidia-smi", "without it the processor")),
        ({"version": 12020}, ("too old", "CUDA 12.2", "13.0", "cuda-bindings<13")),
        ({"capability": 61}, ("6.1", "7.0")),
        ({"cuModuleLoadData": 222}, ("driver is too old", "CUDA_ERROR_UNSUPPORTED_PTX_VERSION")),
        ({"cuMemAlloc": 2}, ("memory is full", "fewer members")),
        ({"cuCtxSynchronize": 999}, ("CUDA_ERROR_UNKNOWN", "nvidia-smi")),
        ({"memory": 1000}, ("32 members", "bytes", "1000")),
    ],
    ids=lambda given: "-".join(given) if isinstance(given, dict) else "",
)
def test_what_fails_is_one_sentence(topology, given, words):
    with pytest.raises(DeviceError) as found:
        on_card(placed(1, one_clearance), driver=FakeDriver(topology, **given)).advance(1, 1)
    assert all(word in str(found.value) for word in words), found.value
    assert "\n" not in str(found.value)


def test_without_a_driver(topology):
    """The bindings look for it when they are first used."""

    class Without(FakeDriver):
        def cuInit(self, flags):
            raise RuntimeError("Failed to dlopen\nlibcuda.so.1.")

    with pytest.raises(DeviceError, match="no NVIDIA driver on this machine .Failed to dlopen libcuda.so.1.; install one"):
        Card(Without(topology))


def test_without_the_bindings(monkeypatch):
    real = builtins.__import__

    def missing(name, *arguments, **options):
        if name.partition(".")[0] == "cuda":
            raise ImportError(name)
        return real(name, *arguments, **options)

    monkeypatch.setattr(builtins, "__import__", missing)
    with pytest.raises(DeviceError, match=r"pip install 'vfife\[gpu\]'"):
        Card()
