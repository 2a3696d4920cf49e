"""Files of version 0.2 are read: runs, and the first format of studies, maps, wear and fits, which had no
tally. Those of 0.1 are refused.
"""

import json
import sqlite3
import warnings
from pathlib import Path

import numpy as np
import pytest

import vfife
from vfife.errors import DamageWarning, RunFileError
from vfife.files.kinds import APPLICATIONS
from vfife.store.runfile import RunFile
from vfife.store.schemas import FIT, MAP, RUN, STUDY, WEAR
from vfife.store.studyfile import MapFile, StudyFile, WearFile

FORMER = Path(__file__).parent / "former"
WRITTEN = json.loads((FORMER / "former.json").read_text())


@pytest.mark.parametrize("name", ["slider_crank", "own_law"])
def test_a_run_gives_its_numbers(name: str, tmp_path: Path) -> None:
    """``own_law`` ran with a law from a file that is not here: its table stands for it, and nothing of it is
    run.
    """
    result = vfife.load_result(FORMER / f"{name}.sqlite")
    then = json.loads((FORMER / f"{name}.json").read_text())
    assert {key: float(result.measures[key]) for key in then} == pytest.approx(then, rel=1e-12)
    assert result.record.status is vfife.Status.COMPLETE
    assert "soft" not in vfife.laws.ContactLaw.registry
    result.save(tmp_path / "run.sqlite")
    again = vfife.load_result(tmp_path)
    assert again.data.identical(result.data) and again.measures == result.measures


def test_a_run_with_a_driven_slider_goes_on_as_it_began(tmp_path: Path) -> None:
    """Version 0.2 booked the work of such drivers as that of loads, and so does what continues its run."""
    path = tmp_path / "run.sqlite"
    path.write_bytes((FORMER / "driven_slider.sqlite").read_bytes())
    result = vfife.load_result(path)
    assert float(result.data.external_work[-1]) == 0.35530590784424876
    assert not result.data.driver_work.values.any() and "actuator_force" not in result.data
    longer = vfife.resume(path, until=1.0)
    assert float(longer.data.external_work[-1]) == pytest.approx(2.0 * 0.355306, rel=1e-5)
    assert longer.ledger.error < 1e-5 and "Driver" not in str(longer)


def test_answers_of_the_first_format_are_read_without_a_warning() -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error", DamageWarning)
        assert (
            vfife.studies.load_study(FORMER / "a.study").values("pin.force.max").tolist() == WRITTEN["study"]
        )
        assert {
            name: one.tolist() for name, one in vfife.dynamics.load_map(FORMER / "a.map").points.items()
        } == WRITTEN["map"]
        wear = vfife.tribology.load_wear(FORMER / "a.wear")
        assert wear.turns.tolist() == WRITTEN["wear"] and float(wear.depth.max()) == WRITTEN["depth"]
        assert (
            json.loads(json.dumps(vfife.identification.load_fit(FORMER / "a.fit").json(), default=float))
            == WRITTEN["fit"]
        )


def test_a_file_of_the_first_format_has_a_tally_when_something_was_added(tmp_path: Path) -> None:
    path = tmp_path / "a.study"
    path.write_bytes((FORMER / "a.study").read_bytes())
    with StudyFile.write(path) as file:
        assert file.version == 1
        file.add([{"joint.pin.clearance": 3e-4}], file.spec)
    with StudyFile.open(path) as file:
        assert file.version == 2 and not file.damage and len(file.cases()) == 3
    with sqlite3.connect(path) as connection:
        connection.execute("DELETE FROM outcomes WHERE number = 1")
    with StudyFile.open(path) as file:
        assert file.damage == ("1 outcomes are missing",)


@pytest.mark.parametrize("kind", [MapFile, WearFile])
def test_the_last_state_goes_on(kind: type[MapFile | WearFile]) -> None:
    with kind.open(FORMER / f"a.{kind.schema.kind}") as file:
        state = file.state(1 if kind is MapFile else 0)
        assert np.isfinite(state).all() and state.size


def test_runs_of_the_first_version_are_refused(tmp_path: Path) -> None:
    path = tmp_path / "run.sqlite"
    path.write_bytes((FORMER / "own_law.sqlite").read_bytes())
    for version in (1, 2):
        with sqlite3.connect(path) as connection:
            connection.execute(f"PRAGMA user_version = {version}")
        with pytest.raises(RunFileError, match=r"vfife 0\.1; install version 0\.2"):
            RunFile.open(path)


def test_kinds_are_told_apart() -> None:
    schemas = (RUN, STUDY, MAP, WEAR, FIT)
    assert {one.kind: one.application for one in schemas} == APPLICATIONS
    assert len(set(APPLICATIONS.values())) == len(schemas)
    for one in schemas:
        assert set(one.rows) < set(one.tables) and one.oldest <= one.format


def test_a_row_that_is_replaced_counts_once(tmp_path: Path) -> None:
    """The tally of a table holds the seal of the new row, not that of the old one."""
    with MapFile.create(tmp_path / "a.map", {"map": {}}) as file:
        for value in (1.0, 2.0, 3.0):
            file.write_row("arrays", "noise", np.full(3, value))
    with MapFile.open(tmp_path / "a.map") as file:
        stored = file.array("noise")
        assert file.damage == () and stored is not None and stored.tolist() == [3.0, 3.0, 3.0]
