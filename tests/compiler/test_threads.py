"""Several threads may write, compile and run steps at once, though Python 3.11 loses count when two parse
syntax trees at a time.
"""

import shutil
import sys
import threading
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

from support import SQUARE, bits, four_bar, go, journal_in_bearing, rounds
from vfife.assembly.assemble import assemble
from vfife.compiler.backends.python import module
from vfife.compiler.runtime import cache, loops
from vfife.compiler.trace import traceable
from vfife.compiler.trace.source import data_driven
from vfife.laws import Flores, Frictionless, HuntCrossley, LuGre
from vfife.model.mechanism import Mechanism

MODELS = (
    four_bar("C", contact=HuntCrossley(restitution=0.6, stiffness=1e9)),
    four_bar("BD", friction=LuGre()),
    journal_in_bearing(contact=Flores(restitution=0.7, stiffness=1e10), friction=Frictionless()),
    four_bar("BCD", "two-particle", section=SQUARE),
)


def forget() -> None:
    """As a new process begins."""
    for known in (loops.straight_line, loops.data_driven_loop, traceable.function_code, traceable.text_code):
        known.cache_clear()
    traceable._files.clear()


@pytest.fixture
def empty(monkeypatch, tmp_path):
    """An empty cache, and threads that take turns as often as they can."""
    monkeypatch.setenv("VFIFE_CACHE", str(tmp_path / "cache"))
    before = sys.getswitchinterval()
    sys.setswitchinterval(1e-5)
    yield
    sys.setswitchinterval(before)
    forget()


def together(work) -> list:
    """What the work gives for each model, all at once."""
    gate = threading.Barrier(2 * len(MODELS))

    def begun(model: Mechanism):
        gate.wait()
        return work(model)

    with ThreadPoolExecutor(2 * len(MODELS)) as pool:
        return list(pool.map(begun, 2 * MODELS))


def rows(model: Mechanism, loop: str = "generated") -> np.ndarray:
    return go(model, 2e-6, duration=4e-4, loop=loop).rows


@pytest.fixture(scope="module")
def alone() -> list[np.ndarray]:
    """The rows of each model, by the loop that is compiled already."""
    return [rows(model, "data-driven") for model in MODELS]


@pytest.mark.system("compiles in several threads")
@pytest.mark.rounds
def test_steps_are_traced_compiled_and_run_at_once(alone, empty):
    for _ in range(rounds(3)):
        forget()
        shutil.rmtree(cache.cache_folder(), ignore_errors=True)
        for k, found in enumerate(together(rows)):
            assert (bits(found) == bits(alone[k % len(MODELS)])).all()


@pytest.mark.system("compiles in several threads")
@pytest.mark.rounds
def test_texts_are_written_at_once(empty):
    def text(model: Mechanism) -> tuple[str, str]:
        topology = assemble(model, 2e-6, duration=4e-4, force_step=True).topology
        return module(topology), data_driven(topology.contact_laws, topology.friction_laws)

    alone = [text(model) for model in MODELS]
    for _ in range(rounds(2)):
        forget()
        assert together(text) == alone * 2
