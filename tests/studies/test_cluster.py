"""A real cluster of processes on this machine, of which some are killed: nothing is lost, no bit differs, who
kills is found.
"""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from collections.abc import Callable, Iterator, Sequence
from importlib.util import find_spec
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from vfife import load_model
from vfife.errors import VfifeError
from vfife.studies.engine import cluster as room
from vfife.studies.engine.cases import run_cases
from vfife.studies.engine.cluster import BatchResult, BatchTask, ClusterRunner, cluster
from vfife.studies.spec.plan import CaseSpec

pytestmark = pytest.mark.skipif(find_spec("distributed") is None, reason="needs distributed")

BASE = Path(__file__).parents[2] / "examples" / "four_bar_case_b.toml"
WANTED = CaseSpec(("C.force.max", "C.impacts"), 1, step=2e-5)
PATH = "joint.C.clearance"
NUMBERS = [{PATH: 1e-4 + 1e-5 * k} for k in range(12)]


@pytest.fixture(scope="module")
def runner() -> Iterator[ClusterRunner]:
    with cluster("local", 2) as found:
        yield found


def deadly(mark: str) -> Callable[..., BatchResult]:
    """The work of a worker that is killed once, in the first batch that finds no mark. Sent by value."""

    def work(task: BatchTask, numbers: Sequence[Any], lanes: int | None) -> BatchResult:
        from vfife.studies.engine.cluster import run_batch

        try:
            os.close(os.open(mark, os.O_CREAT | os.O_EXCL))
        except FileExistsError:
            return run_batch(task, numbers, lanes)
        os.kill(os.getpid(), signal.SIGKILL)
        raise AssertionError

    return work


@pytest.mark.system("starts a cluster")
def test_a_killed_worker_loses_nothing_and_changes_no_bit(runner: ClusterRunner, tmp_path: Path) -> None:
    base = load_model(BASE)
    found = list(ClusterRunner(runner.client, deadly(str(tmp_path / "mark")))(base, NUMBERS, WANTED))
    assert sorted(k for k, _ in found) == list(range(12))
    assert dict(found) == dict(run_cases(base, NUMBERS, WANTED))
    assert all(one.status == "complete" for _, one in found)
    assert (tmp_path / "mark").exists()


@pytest.mark.system("starts a cluster")
def test_a_case_that_cannot_be_assembled_is_an_outcome(runner: ClusterRunner) -> None:
    found = dict(runner(load_model(BASE), [{PATH: -1.0}, {}], WANTED))
    assert [found[k].status for k in (0, 1)] == ["failed", "complete"]


@pytest.mark.system("starts a cluster")
def test_a_worker_of_another_version_is_told(runner: ClusterRunner, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("vfife.studies.engine.cluster.sources", lambda: b"other")
    with pytest.raises(VfifeError, match="another text of the step"):
        list(runner(load_model(BASE), NUMBERS, WANTED))


class Farm:
    """A client of a scheduler that gives every batch up whose case is among ``killers``, and one that waited
    beside such a batch.
    """

    status = "running"

    def __init__(self, killers: set[int], bystander: int = -1) -> None:
        self.killers, self.bystander, self.threads = killers, bystander, 2
        self.killed, self.running = list[list[int]](), set[str]()
        self.most = 0  # batches at the workers beside one of a single case that kills

    def nthreads(self) -> dict[str, int]:
        return {"w0": self.threads} if self.threads else {}

    def submit(self, work: Any, task: Any, numbers: list[dict[str, float]], lanes: Any, pure: bool) -> Any:
        cases = [int(one["k"]) for one in numbers]
        future = SimpleNamespace(key=str(cases), add_done_callback=lambda call: call(future))
        self.running.add(future.key)
        if len(cases) == 1 and cases[0] in {*self.killers, self.bystander}:
            self.most = max(self.most, len(self.running))

        def result(timeout: float) -> BatchResult:
            self.running.discard(future.key)
            if self.killers & set(cases) or (self.bystander in cases and len(cases) > 1):
                self.killed.append(cases)
                raise room.imported().KilledWorker(future.key, "w0", 1)
            return BatchResult([{"values": {"k": float(k)}} for k in cases], 1.0)

        future.result = result
        return future

    def cancel(self, futures: Any) -> None: ...


def test_a_case_that_kills_its_workers_is_given_up_and_the_rest_finish() -> None:
    farm, base = Farm({5, 17}, bystander=30), load_model(BASE)
    found = list(ClusterRunner(farm)(base, [{"k": float(k)} for k in range(40)], WANTED))
    outcomes = dict(found)
    assert len(found) == len(outcomes) == 40
    assert {k for k, one in outcomes.items() if one.status == "killed"} == {5, 17}
    assert outcomes[5].reason == "2 workers died while they ran it alone"
    assert all(one.values == {"k": float(k)} for k, one in outcomes.items() if k not in (5, 17))
    for killer in (5, 17):
        assert [len(cases) for cases in farm.killed if killer in cases][1:] == [1]
    assert farm.most == 1, "something ran beside a suspect"


def test_a_cluster_without_workers_or_scheduler_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(room, "LOOK", 0.005)
    monkeypatch.setattr(room, "PATIENCE", 0.02)
    farm = Farm(set())
    farm.threads = 0
    with pytest.raises(VfifeError, match="no worker for"):
        list(ClusterRunner(farm)(load_model(BASE), NUMBERS, WANTED))

    def gone() -> dict[str, int]:
        raise OSError("Timed out trying to connect")

    farm.nthreads = gone  # type: ignore[method-assign]
    with pytest.raises(VfifeError, match=r"scheduler .* is lost \(Timed out.*the same command continues"):
        list(ClusterRunner(farm)(load_model(BASE), NUMBERS, WANTED))


def test_what_is_no_cluster_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(room, "ANSWER", 0.3)
    with pytest.raises(VfifeError, match=r"cluster nonsense:1: no scheduler answers"), cluster("nonsense:1"):
        pass
    monkeypatch.setitem(__import__("sys").modules, "distributed", None)
    with pytest.raises(VfifeError, match=r"vfife\[cluster\]"):
        room.imported()


@pytest.mark.system("starts a cluster")
def test_no_other_machine_can_reach_a_local_cluster(runner: ClusterRunner) -> None:
    """Scheduler, dashboard and workers listen on this machine alone."""
    psutil = pytest.importorskip("psutil")
    list(runner(load_model(BASE), NUMBERS[:2], WANTED))
    own = psutil.Process()
    listening = [
        one.laddr.ip
        for process in (own, *own.children(recursive=True))
        for one in process.net_connections("inet")
        if one.status == "LISTEN"
    ]
    assert len(listening) >= 4 and set(listening) == {"127.0.0.1"}


@pytest.mark.system("starts processes")
def test_the_tracker_of_semaphores_says_nothing() -> None:
    """The option is given while a cluster of this machine runs, and only then."""
    before = list(sys.warnoptions)
    with room.quiet_tracker():
        assert room.TRACKER in sys.warnoptions
        assert any("resource_tracker" in one for one in subprocess._args_from_interpreter_flags())
    assert sys.warnoptions == before
