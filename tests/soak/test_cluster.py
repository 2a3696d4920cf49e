"""Five hundred cases on a cluster of which a process is killed after every eighty that are done; and a
case that kills each of its workers.
"""

from __future__ import annotations

import multiprocessing
import os
import random
import signal
import threading
from collections.abc import Sequence
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import pytest

from vfife import load_model
from vfife.studies import Study
from vfife.studies.engine import study_engine
from vfife.studies.engine.cases import run_cases
from vfife.studies.engine.cluster import DEATHS, BatchResult, BatchTask, ClusterRunner, cluster, run_batch
from vfife.studies.spec.plan import CaseSpec
from vfife.studies.spec.study_file import StudyTables

pytestmark = [
    pytest.mark.soak,
    pytest.mark.skipif(find_spec("distributed") is None, reason="no distributed here"),
]

BASE = Path(__file__).parents[2] / "examples" / "four_bar_case_c.toml"
EVERY = 80  # cases between two kills
RAW = {
    "measures": ["C.force.max", "C.impacts", "follower.angular_acceleration.max"],
    "turns": 10,
    "method": "latin",
    "count": 500,
    "vary": {
        "play": {"path": "joint.C.clearance", "from": "0.05 mm", "to": "0.5 mm"},
        "speed": {"path": "driver.crank.speed", "from": "500 rpm", "to": "1500 rpm"},
    },
}


class Reaper(threading.Thread):
    """Kills a worker after every so many cases of a study file: a process that a nanny of this process has
    begun.
    """

    def __init__(self, path: Path) -> None:
        super().__init__(daemon=True)
        self.path, self.ended, self.kills = path, threading.Event(), 0

    def run(self) -> None:
        draw = random.Random(1)
        while not self.ended.wait(0.05):
            if Study.open(self.path).counts["complete"] < EVERY * (self.kills + 1):
                continue
            workers = sorted(one.pid for one in multiprocessing.active_children() if one.pid is not None)
            if workers:
                os.kill(draw.choice(workers), signal.SIGKILL)
                self.kills += 1


def test_workers_that_are_killed_again_and_again_lose_nothing_and_change_no_bit(tmp_path: Path) -> None:
    plan, base = StudyTables(RAW, "study", base=load_model(BASE)).plan(), load_model(BASE)
    with study_engine.open_study(
        tmp_path / "own.study", study_engine.description_of(plan), plan.numbers()
    ) as file:
        assert study_engine.Engine(file, base).run()
        own = study_engine.Engine(file, base).study()
    reaper, asked = Reaper(tmp_path / "far.study"), study_engine.description_of(plan)
    with (
        cluster("local", 2) as runner,
        study_engine.open_study(tmp_path / "far.study", asked, plan.numbers()) as file,
    ):
        reaper.start()
        assert study_engine.Engine(file, base, runner=runner).run()
        reaper.ended.set()
        reaper.join()
    far = Study.open(tmp_path / "far.study")
    print(f"{reaper.kills} workers killed, {far.counts}")
    assert reaper.kills > 3
    assert far.counts == own.counts == {"complete": 500, "left": 0}
    assert far.rows() == own.rows()


def deadly(killer: float, folder: str) -> Any:
    """The work of a worker that one case kills. Sent by value."""

    def work(task: BatchTask, numbers: Sequence[Any], lanes: int | None) -> BatchResult:
        if any(one["joint.C.clearance"] == killer for one in numbers):
            os.close(os.open(f"{folder}/{os.getpid()}", os.O_CREAT))
            os.kill(os.getpid(), signal.SIGKILL)
        return run_batch(task, numbers, lanes)

    return work


def test_a_case_that_kills_its_workers_is_marked_and_the_rest_finish(tmp_path: Path) -> None:
    base, wanted = load_model(BASE), CaseSpec(("C.force.max",), 1)
    numbers = [{"joint.C.clearance": 1e-4 + 1e-6 * k} for k in range(60)]
    own = dict(run_cases(base, numbers, wanted))
    with cluster("local", 2) as runner:
        work = deadly(numbers[31]["joint.C.clearance"], str(tmp_path))
        found = dict(ClusterRunner(runner.client, work)(base, numbers, wanted))
    assert found[31].status == "killed"
    assert len(list(tmp_path.iterdir())) == 2 * DEATHS  # in its batch, and alone
    assert {k: one for k, one in found.items() if k != 31} == {k: one for k, one in own.items() if k != 31}
