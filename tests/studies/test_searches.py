"""What a study file asks of a search is understood as written; the files of the documentation
are such files.
"""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from vfife.studies.methods.allocation import read_allotment
from vfife.studies.methods.optimise import read_search
from vfife.studies.spec.distributions import Truncated
from vfife.studies.spec.plan import case_numbers
from vfife.studies.spec.study_file import StudyTables

ROOT = Path(__file__).parents[2]
BLOCKS = re.findall(
    r"```toml\n(.*?)```", (ROOT / "docs" / "tolerance.md").read_text(encoding="utf-8"), re.DOTALL
)


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (tmp_path / "four_bar_case_c.toml").write_text((ROOT / "examples" / "four_bar_case_c.toml").read_text())
    return tmp_path


def test_the_files_of_the_documentation_are_understood(folder: Path) -> None:
    sample, costs, search = BLOCKS
    (folder / "crank.toml").write_text(sample + costs)
    plan = StudyTables.load(folder / "crank.toml").plan()
    assert len(plan.cases) == 500
    mass = plan.parameters[2].distribution
    assert isinstance(mass, Truncated) and mass.limits == (
        pytest.approx(mass.centre - 0.05),
        pytest.approx(mass.centre + 0.05),
    )
    _, task = read_allotment(StudyTables.load(folder / "crank.toml"))
    assert [len(one) for one in task.options] == [7, 3, 1]
    assert task.chosen == (True, True, False)
    assert task.bound.high == 2000.0
    assert all(
        one.cost == pytest.approx(cost)
        for one, cost in zip(task.options[0], (4, 5, 6, 8, 10, 14, 18), strict=True)
    )
    ranges = sample.replace('fit = "H8/f7"\ndiameter = "20 mm"', 'from = "0.1 mm"\nto = "0.2 mm"').replace(
        'fit = "H8/f7"\ndiameter = "25 mm"', 'values = ["0.1 mm", "0.2 mm"]'
    )
    ranges = re.sub(r"\[vary.mass\].*?\n\n", "", ranges, flags=re.DOTALL).replace(
        'method = "random"\ncount = 500\n', ""
    )
    (folder / "crank.toml").write_text(
        ranges.replace('"C.penetration.max"]', '"C.penetration.max", "crank.torque.ripple"]') + search
    )
    plan, found = read_search(StudyTables.load(folder / "crank.toml"))
    assert found.minimised == ("C.force.max", "crank.torque.ripple") and found.cases == 400
    (folder / "old.toml").write_text(
        (folder / "crank.toml").read_text().replace("cases = 400", "members = 400")
    )
    with pytest.warns(DeprecationWarning, match="members of .optimise. is cases now"):
        assert read_search(StudyTables.load(folder / "old.toml"))[1] == found
    assert [(one.low, one.high) for one in found.axes[:1]] == [(1e-4, 2e-4)]
    assert found.axes[1].values == (1e-4, 2e-4)
    assert case_numbers(plan.parameters, {"clearance_C": 1.5e-4, "clearance_D": 2e-4}) == {
        "joint.C.clearance": 1.5e-4,
        "joint.D.clearance": 2e-4,
    }
