"""Threads beside each other read runs, models and laws, and simulate: none sees what another
one is reading.
"""

import threading
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest

import vfife
from support import bits, journal_in_bearing
from vfife.laws import ContactLaw, FrictionLaw
from vfife.laws.stored import Recorded, standing_in
from vfife.store.runfile import RunFile

FORMER = Path(__file__).parent / "former" / "own_law.sqlite"  # its law, "soft", is not loaded here
TIMES = 12


def registries() -> list[dict[str, type]]:
    return [dict(kind.registry) for kind in (ContactLaw, FrictionLaw)]


@pytest.mark.system("runs four threads")
def test_four_threads_simulate_and_read_at_once(tmp_path: Path) -> None:
    before, begin = registries(), threading.Barrier(4)
    own = ContactLaw.registry.copy()
    alone = vfife.simulate(journal_in_bearing(), duration=2e-4, step=1e-6, loop="data-driven")
    alone.save(tmp_path / "run.sqlite")
    told = vfife.load_result(FORMER).measures
    with RunFile.open(FORMER) as file:
        text = str(file.meta["model"])
    (tmp_path / "soft.toml").write_text(text)

    def simulating() -> None:
        for _ in range(TIMES):
            again = vfife.simulate(journal_in_bearing(), duration=2e-4, step=1e-6, loop="data-driven")
            assert (bits(again.record.rows) == bits(alone.record.rows)).all()

    def reading_a_law_of_ones_own() -> None:
        for _ in range(TIMES):
            result = vfife.load_result(FORMER)
            assert result.measures == told
            assert issubclass(type(result.record.assembly.mechanism.clearances["J"].contact), Recorded)

    def reading() -> None:
        for _ in range(TIMES):
            assert vfife.load_result(tmp_path).measures == alone.measures

    def knowing_nothing_of_it() -> None:
        for _ in range(20 * TIMES):
            with pytest.raises(vfife.VfifeError, match="there is no contact law of this name"):
                vfife.load_model(tmp_path / "soft.toml")
            assert dict(ContactLaw.registry) == own

    def at_once(work) -> None:
        begin.wait()
        work()

    with ThreadPoolExecutor(4) as pool:
        works = (simulating, reading_a_law_of_ones_own, reading, knowing_nothing_of_it)
        for done in [pool.submit(at_once, work) for work in works]:
            done.result()
    assert registries() == before


def test_what_stands_in_is_known_in_its_thread_only() -> None:
    with RunFile.open(FORMER) as file:
        entries = file.meta["own_laws"]
    beside: list[bool] = []
    with standing_in(entries):
        assert issubclass(ContactLaw.known()["soft"], Recorded) and "soft" not in FrictionLaw.known()
        thread = threading.Thread(target=lambda: beside.append("soft" in ContactLaw.known()))
        thread.start()
        thread.join()
    assert beside == [False] and "soft" not in ContactLaw.known() and "soft" not in ContactLaw.registry
