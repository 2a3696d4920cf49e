"""What other programs read of a run is what the run has: joint by joint, as one table, and in the files of
each of them.
"""

from __future__ import annotations

import csv
import os
import sys
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import vfife
from vfife import files
from vfife.cli.commands import result as of_the_command
from vfife.plots import PICTURES
from vfife.results.export import RESULT_FORMATS, Names


@cache
def result() -> vfife.Result:
    """A short run with contact, elastic links, a spring and names that need care; no test changes it."""
    m = vfife.gallery.four_bar()
    m.spring("return 1", "ground.A", "follower.end", stiffness="10 N/m")
    m.spring("return/1", "ground.A", "coupler.end", stiffness="10 N/m")
    return vfife.simulate(m, duration="1 ms", outputs=20, loop="data-driven", companions=0, reference=False)


@pytest.fixture(autouse=True)
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)


def test_all_about_a_joint_a_body_and_a_spring() -> None:
    data, joint, body = result().data, result().joint("C"), result().body("coupler")
    assert np.array_equal(joint.force, data.joint_force.sel(joint="C"))
    assert np.array_equal(joint.penetration, data.penetration.sel(clearance="C"))
    assert joint.force.attrs["units"] == "N" and joint.force.dims == ("time",)
    assert np.array_equal(body.angular_velocity, data.body_angular_velocity.sel(body="coupler"))
    assert set(body.element.values) == {name for name in data.element.values if name.startswith("coupler.")}
    assert np.array_equal(result().body("crank").torque, data.driver_torque.sel(driver="crank"))
    assert np.array_equal(result().spring("return 1").force_x, data.spring_force_x.sel(spring="return 1"))
    assert "crank_angle" in joint.coords


@pytest.mark.parametrize(
    ("ask", "said"), [("joint", "there are A, B, C, D"), ("body", "there are crank"), ("spring", "return 1")]
)
def test_a_name_that_is_not_there_is_told(ask: str, said: str) -> None:
    with pytest.raises(vfife.VfifeError, match=f'no {ask} "nobody".*{said}'):
        getattr(result(), ask)("nobody")


def test_corners_of_a_block_stay_apart() -> None:
    m = vfife.Mechanism("block", gravity=(0.0, -9.81))
    m.point("O", 0.0, 0.0)
    m.rigid_body("block", mass=1.0, inertia=0.01)
    m.clearance_slider("S", "ground.O", "block.center", clearance="0.1 mm", length=0.1, height=0.05)
    found = vfife.simulate(m, duration=1e-4, outputs=2, step=1e-6, loop="data-driven", companions=0).joint(
        "S"
    )
    assert list(found.clearance.values) == ["S.1", "S.2", "S.3", "S.4"] and found.force.dims == ("time",)


def test_a_data_frame_has_a_column_for_each_series() -> None:
    table, data = result().to_dataframe(), result().data
    assert table.index.name == "time [s]" and np.array_equal(table.index, data.time)
    assert np.array_equal(table["C.force [N]"], data.joint_force.sel(joint="C"))
    assert np.array_equal(table["kinetic_energy [J]"], data.kinetic_energy)
    assert (
        table.attrs["units"]["crank.angle [rad]"] == "rad"
        and "centre of mass" in table.attrs["meanings"]["crank.x [m]"]
    )
    assert not any("particle" in name for name in table) and any(
        "element_stress" in name for name in result().to_dataframe(fine=True)
    )
    some = result().to_dataframe("C", "crank", units=False)
    assert {name.partition(".")[0] for name in some} == {"crank_angle", "crank", "C"} and "C.force" in some
    assert some["C.force"].equals(table["C.force [N]"].rename("C.force"))


def test_columns_go_by_the_names_of_series() -> None:
    plain = result().to_dataframe(units=False)
    for name, values in result().series.items():
        if name in plain:
            assert np.array_equal(plain[name], values)
    assert set(plain) - {"crank_angle"} <= set(result().series)


def test_csv_gives_every_bit_back() -> None:
    result().export("out.csv")
    with open("out.csv", encoding="utf-8", newline="") as stream:
        head, *rows = csv.reader(stream)
    back = np.array(rows, dtype=float)
    table = result().to_dataframe()
    assert head == [table.index.name, *table.columns]
    assert np.array_equal(back[:, 0], table.index) and np.array_equal(back[:, 1:], table.to_numpy())


def test_matlab_gives_it_back() -> None:
    import scipy.io

    result().export("out.mat")
    found = scipy.io.loadmat("out.mat", simplify_cells=True)
    assert np.array_equal(found["result"]["C"]["force"], result().data.joint_force.sel(joint="C"))
    assert found["units"]["C"]["force"] == "N" and found["units"]["time"] == "s"
    assert {"return_1", "return_1_2"} <= set(found["result"])  # two names that MATLAB could not tell apart
    assert found["about"]["model"] == result().name


def test_names_for_matlab_are_its_own_and_differ() -> None:
    names = Names()
    made = [names[one] for one in ("a b", "a_b", "1", "_x", "é", "x" * 80, "x" * 81)]
    assert len(set(made)) == len(made)
    assert all(one.isascii() and one.isidentifier() and one[0].isalpha() and len(one) <= 63 for one in made)


def test_parquet_gives_it_back() -> None:
    parquet = pytest.importorskip("pyarrow.parquet")
    result().export("out.parquet")
    table = parquet.read_table("out.parquet")
    assert np.array_equal(table["C.force"].to_numpy(), result().data.joint_force.sel(joint="C"))
    assert table.schema.field("C.force").metadata[b"units"] == b"N"


def test_parquet_without_pyarrow_gets_a_sentence(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "pyarrow", None)
    with pytest.raises(vfife.VfifeError, match=r'pip install "vfife\[parquet\]", or write \.csv'):
        result().export("out.parquet")
    assert os.listdir() == []


HEADS = {".svg": b"<?xml", ".pdf": b"%PDF", ".png": b"\x89PNG"}


@pytest.mark.system("draws every figure of a run")
@pytest.mark.parametrize("ending", PICTURES)
def test_figures_go_by_name(ending: str) -> None:
    result().export(f"mechanism{ending}")
    assert Path(f"mechanism{ending}").read_bytes().startswith(HEADS[ending])


def test_a_figure_may_lie_under_another_name() -> None:
    result().export("drawing.svg", figure="mechanism")
    assert os.listdir() == ["drawing.svg"]
    with pytest.raises(vfife.VfifeError, match=r'no figure "drawing"'):
        result().export("drawing.svg")
    with pytest.raises(vfife.VfifeError, match=r"\.svg, \.pdf, \.png"):
        result().export("drawing.csv", figure="mechanism")


@pytest.mark.parametrize("name", ["out.csv", "out.mat", "mechanism.png"])
def test_what_cannot_be_written_leaves_what_was_there(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    Path(name).write_text("before")

    def fails(*_: Any) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(files.os, "fsync", fails)
    with pytest.raises(OSError, match="No space"):
        result().export(name)
    assert os.listdir() == [name] and Path(name).read_text() == "before"


def test_an_unknown_ending_is_no_format_of_data_or_of_figures() -> None:
    with pytest.raises(
        vfife.VfifeError, match=r'".foo" is no format of an export; data are .*\.csv.*'
    ) as told:
        result().export("x.foo")
    assert all(ending in str(told.value) for ending in (*RESULT_FORMATS, *PICTURES))
    with pytest.raises(vfife.VfifeError, match=r"export; figures are written as") as told:
        result().export("x.foo", figure="mechanism")
    assert ".csv" not in str(told.value)


def test_the_status_of_a_run_is_a_text() -> None:
    assert result().status == "complete" and result().status == result().summary["status"]


def test_the_command_knows_what_is_written() -> None:
    assert set(of_the_command.ENDINGS) == {*RESULT_FORMATS, *PICTURES}


@pytest.mark.system("draws every figure of a run")
def test_a_notebook_shows_summary_and_figures_and_escapes_names() -> None:
    shown = vfife.simulate(
        renamed("<i>&"), duration="0.1 ms", outputs=2, loop="data-driven", companions=0, reference=False
    )
    page = shown._repr_html_()
    assert "&lt;i&gt;&amp;" in page and "<i>&" not in page
    assert page.count("data:image/png;base64,") >= 2 and "Cautions" in page


def renamed(name: str) -> vfife.Mechanism:
    """The four-bar under another name."""
    m = vfife.gallery.four_bar()
    m.name = name
    return m


def test_remainders_of_rounding_are_zero_for_readers(tmp_path: Path) -> None:
    """1.73e-322 is a zero that rounding left, with commas and points; other numbers keep all bits."""
    heads = ["ram.angle [deg]", "x [m]"]
    rows = [heads, [1.73e-322, -8.4e-318], [-1.1e-301, 1.0 / 3.0], [1.1e-300, -0.0]]
    files.write_rows(tmp_path / "a.csv", rows, "comma")
    lines = (tmp_path / "a.csv").read_text(encoding="utf-8-sig").splitlines()
    assert lines[1:] == ["0,0;0,0", "0,0;0,3333333", "0,0;0,0"]
    files.write_rows(tmp_path / "b.csv", rows)
    lines = (tmp_path / "b.csv").read_text().splitlines()
    assert lines[1:] == ["0.0,0.0", "0.0,0.3333333333333333", "1.1e-300,-0.0"]
