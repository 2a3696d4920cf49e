"""One case a thread, on a card that the processor plays: the bits of cases in lanes, whatever card and
whoever beside; and what is told.
"""

import builtins
import contextlib

import numpy as np
import pytest

from fake_card import FakeDriver, in_this_machine, rows_on_card
from lane_models import one_clearance, swing
from support import bits, four_bar, lanes
from vfife.assembly.assemble import assemble
from vfife.assembly.reassemble import reassembled
from vfife.compiler.backends.gpu import TILE
from vfife.compiler.runtime import cuda
from vfife.compiler.runtime.cuda import Card
from vfife.errors import DeviceError
from vfife.laws import LankaraniNikravesh
from vfife.solvers import interrupts, streaming
from vfife.solvers.ensemble import advance, ensemble, placed


@pytest.fixture
def driver():
    """Puts a card of a topology into this machine."""
    with contextlib.ExitStack() as stack:
        yield lambda topology, **given: stack.enter_context(in_this_machine(FakeDriver(topology, **given)))


def same(ours, theirs) -> bool:
    """Whether cases of two ensembles left the same, to the bit."""
    return all(
        a.settled == b.settled and a.status == b.status and (bits(a.last.rows) == bits(b.last.rows)).all() and
        (bits(a.turns.rows) == bits(b.turns.rows)).all()
        for a, b in zip(ours, theirs, strict=True)
    )  # fmt: skip


def of_play(cases: int, turns: int = 2):
    """The four-bar with as many clearances, every other one with half the step."""
    bases = [placed(four_bar("BCD", speed=2000.0), step, turns, 4) for step in (8e-6, 4e-6)]
    return [
        reassembled(bases[k % 2], four_bar("BCD", clearance=1e-4 * (1 + 0.1 * k)).clearances)
        for k in range(cases)
    ]


def test_members_on_a_card_are_those_in_lanes(driver):
    """More than two tiles hold: some come into lanes that others have left, of which those with the smaller
    step go on.
    """
    a = of_play(2 * TILE + 5)
    here = advance(a)
    there = driver(a[0].topology)
    assert same(advance(a, device="cuda", lanes=2 * TILE), here)
    assert set(there.threads) == {2 * TILE} and not there.given, "memory is given back"
    repeated = [one.last.block("repeated")[-1, 0] for one in here]
    assert min(repeated) > 5, "steps were taken again in smaller ones"


def test_a_card_with_little_memory_takes_fewer_at_once(driver, monkeypatch):
    a = of_play(TILE + 2, turns=1)
    here = advance(a)
    there = driver(a[0].topology, memory=450_000)
    assert same(advance(a, device="cuda"), here)
    assert set(there.threads) == {TILE}
    there = driver(a[0].topology)
    monkeypatch.setattr(cuda, "MOST_BYTES", 300_000)
    assert same(advance(a, device="cuda"), here)
    assert set(there.threads) == {TILE}


def test_launches_are_short_and_change_nothing(driver, monkeypatch):
    """Calls of the loop are as long as on a processor: between two of them somebody may end it all."""
    a = of_play(3)
    here = advance(a)
    monkeypatch.setattr(streaming, "QUICK", 37)
    monkeypatch.setattr(interrupts, "FIRST", 37)
    monkeypatch.setattr(interrupts, "GROWTH", 1)
    there = driver(a[0].topology)
    assert same(advance(a, device="cuda"), here)
    assert len(there.threads) > 10


def test_who_settles_or_breaks_makes_room(driver):
    """Members that settle, one that goes on to the last turn, one that breaks: as on the processor."""
    made = [four_bar("BCD", clearance=c, speed=500.0) for c in (1e-4, 3e-4)]
    made.append(four_bar("BCD", speed=500.0, contact=LankaraniNikravesh(restitution=0.9, stiffness=6.6e17)))
    options = {"step": 5e-6, "turns": 2, "outputs": 20, "tolerance": 0.3}
    here = ensemble(made, **options)
    driver(here[0].assembly.topology)
    assert same(ensemble(made, **options, device="cuda"), here)
    assert {one.status for one in here} == {"complete", "diverged"}


def test_tables_of_their_own():
    """Functions over time: each case's tables lie behind those of the one before."""
    a = [assemble(swing(k), 4e-6, duration=1e-3, outputs=5, force_step=True) for k in range(2)]
    assert a[0].tables.tobytes() != a[1].tables.tobytes()
    for one in a:
        here = lanes([one], "generated")
        rows = np.concatenate(
            [here.advance(1, 1), here.advance(one.choice.outputs_every, one.choice.outputs)]
        )[:, :, 0]
        assert (bits(rows_on_card(one, lane=33)) == bits(rows)).all()


def test_ctrl_c_ends_it_and_gives_memory_back(driver):
    a = of_play(3)
    there = driver(a[0].topology)

    def stop(done, total):
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        advance(a, device="cuda", progress=stop)
    assert not there.given


def test_a_loop_that_a_card_does_not_have(driver):
    a = of_play(1)
    driver(a[0].topology)
    with pytest.raises(
        DeviceError,
        match="straight-line code, and one of these needs the data-driven loop; without it the processor",
    ):
        advance(a, device="cuda", loop="data-driven")


# ------------------------------------------------------------------------------------------------------- what
# is told


@pytest.fixture(scope="module")
def topology():
    return short().topology


def short():
    return assemble(one_clearance(0), 2e-6, duration=4e-6, outputs=1, force_step=True)


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"cuInit": 100}, ("no card", "nvidia-smi", "without it the processor")),
        ({"version": 12020}, ("too old", "CUDA 12.2", "13.0", "cuda-bindings<13")),
        ({"capability": 61}, ("6.1", "7.0")),
        ({"cuModuleLoadData": 222}, ("driver is too old", "CUDA_ERROR_UNSUPPORTED_PTX_VERSION")),
        ({"cuMemAlloc": 2}, ("memory is full", "fewer cases")),
        ({"cuCtxSynchronize": 999}, ("CUDA_ERROR_UNKNOWN", "nvidia-smi")),
        ({"memory": 1000}, ("32 cases", "bytes", "1000")),
    ],
    ids=lambda given: "-".join(given) if isinstance(given, dict) else "",
)
def test_what_fails_is_one_sentence(topology, given, words):
    with pytest.raises(DeviceError) as found:
        rows_on_card(short(), FakeDriver(topology, **given))
    assert all(word in str(found.value) for word in words), found.value
    assert "\n" not in str(found.value)


def test_without_a_driver(topology):
    """The bindings look for it when they are first used."""

    class Without(FakeDriver):
        def cuInit(self, flags):
            raise RuntimeError("Failed to dlopen\nlibcuda.so.1.")

    with pytest.raises(
        DeviceError, match="no NVIDIA driver on this machine .Failed to dlopen libcuda.so.1.; install one"
    ):
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
