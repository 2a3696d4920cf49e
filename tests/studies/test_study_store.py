"""A study file loses nothing and computes nothing twice, whenever its writer is killed; what fails is kept
with its reason.
"""

from __future__ import annotations

import math
import os
import signal
import sqlite3
from pathlib import Path

import numpy as np
import pytest

import vfife
from studies.studies import ASKED, BASE, Closed
from vfife.errors import DamageWarning, HeldError, ModelError, RunFileError, VfifeError
from vfife.job.job import Job
from vfife.report.study import document
from vfife.results.study import Study
from vfife.store import studyfile
from vfife.store.studyfile import StudyCase, StudyFile
from vfife.studies import forecast
from vfife.studies.engine import study_engine
from vfife.studies.engine.cases import run_cases
from vfife.studies.engine.cluster import Resources
from vfife.studies.engine.outcome import Outcome
from vfife.studies.spec.plan import CaseSpec
from vfife.studies.spec.study_file import StudyTables
from vfife.studies.study_work import StudyWork


@pytest.fixture
def closed(monkeypatch: pytest.MonkeyPatch) -> Closed:
    found = Closed()
    monkeypatch.setattr(study_engine, "run_cases", found)
    monkeypatch.setattr(forecast, "WORTH", math.inf)  # no case is run for a forecast
    return found


@pytest.fixture
def asked(tmp_path: Path) -> Path:
    path = tmp_path / "asked.toml"
    path.write_text(ASKED)
    return path


def told(study: Study) -> list[object]:
    """All that a study says of its cases, to the bit."""
    return [(sorted(one.numbers.items()), {**study.outcomes[one.number]}) for one in study.done]


def killed(work: object) -> int:
    """Does some work in a process of its own; the signal that ended it, 0 for none."""
    child = os.fork()
    if child == 0:
        try:
            work()  # type: ignore[operator]
        finally:
            os._exit(0)
    return os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])


def after(count: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """Has this process killed before its ``count``-th statement of SQL."""
    seen = [0]
    former = sqlite3.connect

    def statement(_: str) -> None:
        seen[0] += 1
        if seen[0] >= count:
            os.kill(os.getpid(), signal.SIGKILL)

    def connect(*given: object, **named: object) -> sqlite3.Connection:
        connection = former(*given, **named)  # type: ignore[call-overload]
        connection.set_trace_callback(statement)
        return connection  # type: ignore[no-any-return]

    monkeypatch.setattr(sqlite3, "connect", connect)


@pytest.mark.system("breaks a study off before each statement")
@pytest.mark.skipif(os.name != "posix", reason="a process is forked and killed")
def test_killed_before_any_statement_and_gone_on_with_it_is_what_nobody_stopped(
    asked: Path, tmp_path: Path, closed: Closed, monkeypatch: pytest.MonkeyPatch
) -> None:
    plan = StudyTables.load(asked).plan()
    monkeypatch.setattr(studyfile, "GATHER", 0.0)
    whole = StudyWork(tmp_path / "whole.study", plan).run(Job("study", None, False, None))[0]
    assert len(whole.done) == 6
    statements, survived, kept = 0, False, set()
    while not survived:
        statements += 5
        path = tmp_path / f"{statements}.study"

        def once(path: Path = path, count: int = statements) -> None:
            after(count, monkeypatch)
            StudyWork(path, plan).run(Job("study", None, False, None))[0]

        survived = killed(once) == 0
        before = len(Study.open(path).done) if path.exists() else -1
        kept.add(before)
        closed.computed.clear()
        again = StudyWork(path, plan).run(Job("study", None, False, None))[0]
        assert told(again) == told(whole) and again.repeats == whole.repeats and len(again.repeats) == 6
        assert len(closed.computed) == 6 - max(before, 0)
    assert {-1, 0, 6} < kept and len(kept) > 5, "kills fell before, between and after all cases"


def test_a_case_is_known_by_its_numbers_in_any_order() -> None:
    one = {"joint.C.clearance": 1e-4, "driver.crank.speed": 100.0}
    assert (
        studyfile.hash_of(one)
        == studyfile.hash_of(dict(reversed(one.items())))
        != studyfile.hash_of({**one, "driver.crank.speed": 101.0})
    )


def test_what_came_of_other_numbers_is_not_taken_for_a_member(
    asked: Path, tmp_path: Path, closed: Closed
) -> None:
    """A whole outcome in the place of another case is computed again."""
    plan = StudyTables.load(asked).plan()
    path = tmp_path / "x.study"
    whole = told(StudyWork(path, plan).run(Job("study", None, False, None))[0])
    with StudyFile.write(path) as file:
        first, second = file.cases()[:2]
        other = StudyCase(first.number, second.hash, first.numbers)
        file.record(other, Outcome({"C.force.max": 1.0, "C.impacts": 1.0}, turns=2, step=1e-6, steps=7))
    closed.computed.clear()
    assert (
        told(StudyWork(path, plan).run(Job("study", None, False, None))[0]) == whole
        and len(closed.computed) == 1
    )


@pytest.mark.system("kills a process")
@pytest.mark.skipif(os.name != "posix", reason="a process is forked and killed")
def test_real_cases_after_a_kill_are_those_of_a_study_nobody_stopped(
    asked: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    asked.write_text(
        ASKED.replace("turns = 2", "turns = 1\nstep = 1e-5")
        .replace('"0.3 mm"', '"0.25 mm"')
        .replace('"0.1 mm", ', "")
    )
    plan = StudyTables.load(asked).plan()
    record = StudyFile.record

    def recorded_twice(self: StudyFile, *given: object, **named: object) -> None:
        record(self, *given)  # type: ignore[arg-type]
        if len(self.keys("outcomes")) == 2:
            os.kill(os.getpid(), signal.SIGKILL)

    def once() -> None:
        monkeypatch.setattr(studyfile, "GATHER", 0.0)
        monkeypatch.setattr(StudyFile, "record", recorded_twice)
        StudyWork(tmp_path / "b.study", plan, Resources(1)).run(Job("study", None, False, None))[0]

    assert killed(once) == -signal.SIGKILL
    assert len(Study.open(tmp_path / "b.study").done) == 2
    whole, again = (
        StudyWork(tmp_path / name, plan, Resources(1)).run(Job("study", None, False, None))[0]
        for name in ("a.study", "b.study")
    )
    assert told(whole) == told(again)
    assert len(whole.done) == 4
    numbers = [dict(one.numbers) for one in whole.cases]
    own = dict(run_cases(plan.base, numbers, CaseSpec(("C.force.max", "C.impacts"), 1, step=1e-5), workers=1))
    assert [own[k].values["C.force.max"] for k in range(4)] == whole.values("C.force.max").tolist()


def test_adding_computes_only_what_is_new(asked: Path, tmp_path: Path, closed: Closed) -> None:
    path = tmp_path / "s.study"
    vfife.study(asked, file=path)
    assert len(closed.computed) == 6
    closed.computed.clear()
    asked.write_text(ASKED.replace('"0.3 mm"]', '"0.3 mm", "400 um"]'))
    found = vfife.study(asked, file=path)
    assert closed.computed == [
        {"joint.C.clearance": 4e-4, "driver.crank.speed": speed} for speed in (200.0, 100.0)
    ]
    assert found.data["C.force.max"].dims == ("play", "speed")
    play, speed = found.data.play.values, found.data.speed.values
    assert np.array_equal(found.data["C.force.max"].values, speed[None, :] * speed[None, :] * play[:, None])
    assert found.data["C.force.max"].attrs["units"] == "N"
    closed.computed.clear()
    vfife.study(asked, file=path)
    assert closed.computed == []


def test_a_case_that_fails_is_kept_with_its_reason_and_the_rest_finish(
    asked: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(study_engine, "run_cases", Closed(fails=2e-4, without=1e-4))
    found = vfife.study(asked)
    assert found.counts == {"complete": 4, "diverged": 2, "left": 0}
    reasons = {one.numbers["joint.C.clearance"]: reason for one, reason in found.failed}
    assert reasons == {2e-4: "diverged after 7 steps", 1e-4: "it has no measure C.impacts"}
    assert np.isnan(found.data["C.force.max"].sel(play=2e-4)).all()
    assert np.isnan(found.data["C.impacts"].sel(play=1e-4)).all()
    assert np.isfinite(found.data["C.force.max"].sel(play=[1e-4, 3e-4])).all()


def test_cases_that_failed_are_tried_again_where_that_is_asked_for(
    asked: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "s.study"
    first = Closed(fails=2e-4)
    monkeypatch.setattr(study_engine, "run_cases", first)
    assert vfife.study(asked, file=path).counts["diverged"] == 2
    assert sorted(one["joint.C.clearance"] for one in first.computed) == [1e-4] * 2 + [2e-4] * 2 + [3e-4] * 2
    closed = Closed()
    monkeypatch.setattr(study_engine, "run_cases", closed)
    assert vfife.study(asked, file=path).counts["diverged"] == 2 and closed.computed == []
    found = vfife.study(asked, file=path, retry=True)
    assert [one["joint.C.clearance"] for one in closed.computed] == [2e-4, 2e-4]
    assert found.counts == {"complete": 6, "diverged": 0, "left": 0} or found.counts == {
        "complete": 6,
        "left": 0,
    }


def test_interrupted_study_keeps_what_ended(asked: Path, tmp_path: Path, closed: Closed) -> None:
    def stop(done: int, of: int) -> None:
        if done == 2:
            raise KeyboardInterrupt

    found = vfife.study(asked, file=tmp_path / "s.study", progress=stop)
    assert (len(found.done), found.status) == (2, "interrupted")
    closed.computed.clear()
    assert vfife.study(asked, file=tmp_path / "s.study").status == "complete"
    assert len(closed.computed) == 4


def test_it_is_read_while_it_grows_and_has_one_writer(
    asked: Path, tmp_path: Path, closed: Closed, monkeypatch: pytest.MonkeyPatch
) -> None:
    path, seen = tmp_path / "s.study", []

    def look(done: int, of: int) -> None:
        seen.append(len(Study.open(path).done))
        with pytest.raises(HeldError, match=r"s\.study: process \d+ on .* writes this study"):
            vfife.study(asked, file=path)

    plan = StudyTables.load(asked).plan()
    monkeypatch.setattr(studyfile, "GATHER", 0.0)
    StudyWork(path, plan).run(Job("study", path, False, lambda one: look(one.done, one.steps)))
    assert seen == [1, 2, 3, 4, 5, 6]


@pytest.mark.parametrize(
    ("before", "after_", "says"),
    [
        ("turns = 2", "turns = 3", "other measures, turns"),
        ("joint.C.clearance", "joint.C.bearing_radius", "varies other numbers"),
        ("turns = 2", 'turns = 2\n[set]\n"joint.C.friction.coefficient" = 0.2\n', "another model"),
    ],
)
def test_another_study_is_not_mixed_with_it(
    before: str, after_: str, says: str, asked: Path, tmp_path: Path, closed: Closed
) -> None:
    path = tmp_path / "s.study"
    vfife.study(asked, file=path)
    asked.write_text(
        ASKED.replace(before, after_).replace(
            '"0.1 mm", "0.2 mm", "0.3 mm"', '"11 mm", "12 mm"' if "radius" in after_ else '"0.1 mm"'
        )
    )
    with pytest.raises(VfifeError, match=says):
        vfife.study(asked, file=path)
    assert len(Study.open(path).done) == 6


def test_another_text_of_the_step_or_of_ones_own_laws_is_another_study(
    asked: Path, tmp_path: Path, closed: Closed
) -> None:
    path = tmp_path / "s.study"
    vfife.study(asked, file=path)
    with StudyFile.open(path) as file:
        kept = file.meta["study"]
        law = {"kind": "contact", "name": "mine", "text": "one"}
        for change, says in (
            ({"step": "0"}, "whose steps differ"),
            ({"own_laws": [law]}, "another text of your own laws"),
            ({}, ""),
        ):
            assert says in study_engine.difference(
                file.meta[study_engine.SPECIFICATION], {**kept, **change}
            ) and bool(says) == bool(
                study_engine.difference(file.meta[study_engine.SPECIFICATION], {**kept, **change})
            )


def test_a_study_with_other_turns_of_its_means_is_another_one(
    asked: Path, tmp_path: Path, closed: Closed
) -> None:
    """A former version measured one turn, as last = 1 does."""
    path = tmp_path / "s.study"
    asked.write_text(ASKED.replace("turns = 2", 'turns = 2\nsettle = "1 %"\nlast = 1'))
    vfife.study(asked, file=path)
    with StudyFile.open(path) as file:
        assert "period_means" not in file.meta["study"]["wanted"]
    asked.write_text(ASKED.replace("turns = 2", 'turns = 2\nsettle = "1 %"'))
    with pytest.raises(VfifeError, match="measures one turn where turns alternate.*last = 1"):
        vfife.study(asked, file=path)


def test_damaged_rows_are_left_out_and_computed_again(asked: Path, tmp_path: Path, closed: Closed) -> None:
    path = tmp_path / "s.study"
    whole = vfife.study(asked, file=path)
    with sqlite3.connect(path) as connection:
        connection.execute("UPDATE outcomes SET measures = '{\"C.force.max\": 1.0}' WHERE number = 3")
    with pytest.warns(DamageWarning, match="1 outcomes are damaged"):
        assert len(Study.open(path).done) == 5
    closed.computed.clear()
    assert told(vfife.study(asked, file=path)) == told(whole)
    assert len(closed.computed) == 1
    with sqlite3.connect(path) as connection:
        connection.execute("UPDATE meta SET json = '{}' WHERE key = 'study'")
    with pytest.raises(RunFileError, match="this study file is damaged"):
        Study.open(path)


def test_what_is_no_study_file_is_refused(tmp_path: Path) -> None:
    other = tmp_path / "x.study"
    with pytest.raises(RunFileError, match="there is no study file"):
        Study.open(other)
    other.write_text("nothing of the kind")
    with pytest.raises(RunFileError, match="this is not a study file"):
        Study.open(other)


def test_from_python_with_a_mechanism(closed: Closed) -> None:
    base = vfife.load(BASE)
    found = vfife.study(base, {"joint.C.clearance": np.array([1e-4, 2e-4])}, "C.force.max", turns=1)
    assert found.data["C.force.max"].dims == ("joint.C.clearance",)
    assert found.values("C.force.max").tolist() == [1e4 * 1e-4, 1e4 * 2e-4]
    with pytest.raises(ModelError, match="turns"):
        vfife.study(base, {"joint.C.clearance": [1e-4]}, "C.force.max", turns=0)


def with_former_measures(path: Path, **keys: object) -> bytes:
    """Make a study of cases with a duration, its file as older versions wrote it; return its content."""
    vfife.study(vfife.load_model(BASE), {"joint.C.clearance": [1e-4]}, ["C.force.max"], file=path, **keys)
    with StudyFile.write(path) as file:
        spec = dict(file.meta[studyfile.SPECIFICATION])
        del spec[studyfile.MEASURE_VERSION_KEY]
        file.put({studyfile.SPECIFICATION: spec})
    return path.read_bytes()


def test_cases_of_another_definition_of_measures_are_not_mixed(tmp_path: Path) -> None:
    """Older versions measured another turn of cases with a duration: such a file is shown, with a caution,
    and not continued.
    """
    path, model = tmp_path / "old.study", vfife.load_model(BASE)
    long = {"duration": 1.2 * 60.0 / 1500.0, "step": 8e-6}
    content = with_former_measures(path, **long)
    more = {"joint.C.clearance": [1e-4, 2e-4]}
    with pytest.raises(VfifeError, match=r"older version.*not be comparable.*another file"):
        vfife.study(model, more, ["C.force.max"], file=path, **long)
    with pytest.raises(VfifeError, match="older version"):
        plan = study_engine.extended_plan(path, {"joint.C.clearance": "0.2 mm"})
        study_engine.open_study(path, study_engine.description_of(plan), plan.numbers())
    assert path.read_bytes() == content
    old = Study.open(path)
    assert len(old.done) == 1 and "older version" in str(document(old).parts)
    new = vfife.study(model, more, ["C.force.max"], file=path, force=True, **long)
    assert len(new.done) == 2 and "older version" not in str(document(new).parts)


def test_cases_shorter_than_a_turn_continue_in_files_of_older_versions(tmp_path: Path) -> None:
    """Their measures are of the whole run in all versions."""
    path, short = tmp_path / "old.study", {"duration": 1e-3, "step": 8e-6}
    with_former_measures(path, **short)
    more = {"joint.C.clearance": [1e-4, 2e-4]}
    study = vfife.study(vfife.load_model(BASE), more, ["C.force.max"], file=path, **short)
    assert len(study.done) == 2 and not study.has_former_measures
    assert study.request[studyfile.MEASURE_VERSION_KEY] == studyfile.MEASURE_VERSION
