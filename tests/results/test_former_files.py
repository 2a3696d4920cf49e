"""Run files of former versions are read: version 0.1 kept no start, other block names, and the text of laws of the user's own."""

import json
from pathlib import Path

import pytest

import vfife
from vfife.analysis.measured import present_name
from vfife.results.runfile import RunFile

FORMER = Path(__file__).parent / "former"


@pytest.mark.parametrize("name", ["four_bar", "own_law"])
def test_a_file_of_the_first_format_gives_its_numbers(name: str) -> None:
    """``own_law`` ran with a law from a file that is not here: its table stands for it, and nothing of it is run."""
    told = json.loads((FORMER / f"{name}.json").read_text())
    with RunFile.open(FORMER / f"{name}.sqlite") as file:
        assert "assembly" not in file.meta
        assert any(block.startswith("clearance_") for block, _ in file.meta["kept"])
    result = vfife.load_result(FORMER / f"{name}.sqlite")
    now = {present_name(key) or key: value for key, value in told.items()}
    assert {name: float(result.measures[name]) for name in now} == pytest.approx(now, rel=1e-12)
    assert result.record.status is vfife.Status.COMPLETE
    assert "soft" not in vfife.ContactLaw.registry
    if name == "four_bar":
        assert result.reference is not None and result.ledger.error < 1e-2


def test_it_is_written_in_the_present_format(tmp_path: Path) -> None:
    former = vfife.load_result(FORMER / "own_law.sqlite")
    former.save(tmp_path / "run.sqlite")
    with RunFile.open(tmp_path) as file:
        assert {"assembly", "start", "tables"} <= set(file.meta)
    assert vfife.load_result(tmp_path).data.identical(former.data)
