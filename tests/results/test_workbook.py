"""Workbooks and tables with a decimal comma give back the names that were written, and numbers with
the digits of readers.
"""

from __future__ import annotations

import csv
import math
import random
import struct
from collections.abc import Iterable
from pathlib import Path
from typing import Any
from xml.etree import ElementTree
from zipfile import ZipFile

import numpy as np
import pytest

import vfife
from vfife import files
from vfife.files import workbook
from vfife.files.workbook import write_workbook

MAIN = "{http://schemas.openxmlformats.org/spreadsheetml/2006/main}"
RELATED = "{http://schemas.openxmlformats.org/officeDocument/2006/relationships}id"
PACKAGE = "{http://schemas.openxmlformats.org/package/2006/relationships}"


def cell(one: ElementTree.Element) -> Any:
    kind, value = one.get("t"), one.findtext(f"{MAIN}v")
    if kind == "inlineStr":
        return "".join(text.text or "" for text in one.iter(f"{MAIN}t"))
    if value is None:
        return None
    return {"b": lambda: value == "1", "e": lambda: math.nan}.get(kind or "", lambda: float(value))()


def read(path: Path) -> dict[str, list[list[Any]]]:
    """Sheets by their titles, found as a spreadsheet finds them: by way of the relations."""
    with ZipFile(path) as archive:
        assert archive.testzip() is None
        types = ElementTree.fromstring(archive.read("[Content_Types].xml"))
        named = {one.get("PartName") for one in types} - {None}
        assert named <= {f"/{name}" for name in archive.namelist()}
        (root,) = ElementTree.fromstring(archive.read("_rels/.rels")).iter(f"{PACKAGE}Relationship")
        assert root.get("Target") == "xl/workbook.xml"
        relations = ElementTree.fromstring(archive.read("xl/_rels/workbook.xml.rels"))
        targets = {one.get("Id"): f"xl/{one.get('Target')}" for one in relations}
        book = ElementTree.fromstring(archive.read("xl/workbook.xml"))
        return {
            str(sheet.get("name")): [
                [cell(one) for one in row]
                for row in ElementTree.fromstring(archive.read(targets[sheet.get(RELATED)])).iter(
                    f"{MAIN}row"
                )
            ]
            for sheet in book.iter(f"{MAIN}sheet")
        }


def written(tmp_path: Path, **tables: Iterable[Iterable[Any]]) -> dict[str, list[list[Any]]]:
    files.write_tables(tmp_path / "t.xlsx", tables)
    return read(tmp_path / "t.xlsx")


def test_numbers_come_back_to_the_last_bit(tmp_path: Path) -> None:
    chance = random.Random(4)
    every = [struct.unpack("d", chance.randbytes(8))[0] for _ in range(400)]
    every = [one for one in every if math.isfinite(one)] + [0.1 + 0.2, 5e-324, -0.0, 1.7976931348623157e308]
    values = [[np.float64(1 / 3), np.int64(7), True, None, math.nan, math.inf, ""]]
    with open(tmp_path / "t.xlsx", "wb") as stream:
        write_workbook(stream, {"t": [["x"], *([one] for one in every)], "u": [["a"] * 7, *values]})
    sheets = read(tmp_path / "t.xlsx")
    assert [one.hex() for (one,) in sheets["t"][1:]] == [one.hex() for one in every]
    [row] = sheets["u"][1:]
    assert row[:4] == [1 / 3, 7, True, None] and math.isnan(row[4]) and row[5:] == ["inf", None]


def test_tables_for_spreadsheets_have_seven_digits_and_exact_angles(tmp_path: Path) -> None:
    """Angles reduced to one turn miss their multiples by rounding; outputs of a long run stay apart."""
    step = 5.7077625570776256e-05
    heads = ["crank_angle [deg]", "time [s]", "force [N]", "count"]
    rows = [[3.3853575591797833e-13, 40.0, -0.0, 3], [0.500000000001248, 40.0 + step, 2232.0236215094856, 4]]
    rows += [[359.9999999999, math.inf, 1.2345678e-9, None]]
    shown = [[0.0, 40.0, 0.0, 3], [0.5, 40.00005708, 2232.024, 4], [360.0, "inf", 1.234568e-09, None]]
    found = written(tmp_path, t=[heads, *rows])["t"]
    assert found[2:] == shown
    files.write_rows(tmp_path / "t.csv", [heads, *rows], "comma")
    text = (tmp_path / "t.csv").read_text("utf-8-sig").splitlines()
    assert text[1:3] == ["0,0;40,0;0,0;3", "0,5;40,00005708;2232,024;4"]
    files.write_rows(tmp_path / "t.csv", [heads, *rows])
    assert "3.3853575591797833e-13,40.0,-0.0,3" in (tmp_path / "t.csv").read_text("utf-8")


def test_names_come_back_and_units_have_a_row(tmp_path: Path) -> None:
    names = ["Zähler & <Nenner>", '"=1+1"', "  two  spaces ", "λ\n]]>", "C [a].force"]
    found = written(tmp_path, **{"a&<ü": [[*names, "force [N]"], *[[*names, 1.0]]]})
    assert found == {"a&<ü": [[*names, "force"], [*[None] * len(names), "N"], [*names, 1.0]]}
    assert written(tmp_path, t=[["\x00bell\x07"]]) == {"t": [["\ufffdbell\ufffd"]]}


def test_titles_are_what_a_sheet_may_have(tmp_path: Path) -> None:
    assert list(written(tmp_path, **{"a/b:[c]*?\\": [["x"]]})) == ["a b  c"]
    assert list(written(tmp_path, **{"x" * 40: [["x"]], "": [["x"]]})) == ["x" * 31, "table"]
    twice = written(tmp_path, **{"about": [["a"]], "About ": [["b"]], "x" * 31: [["c"]], "x" * 32: [["d"]]})
    assert list(twice) == ["about", "About 2", "x" * 31, "x" * 29 + " 2"]


def test_the_same_tables_are_the_same_bytes(tmp_path: Path) -> None:
    for name in ("a.xlsx", "b.xlsx"):
        files.write_tables(tmp_path / name, {"t": [["x [m]"], [1.0]]})
    assert (tmp_path / "a.xlsx").read_bytes() == (tmp_path / "b.xlsx").read_bytes()


def test_too_large_a_table_gets_a_sentence(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    target = tmp_path / "t.xlsx"
    target.write_text("before")
    monkeypatch.setattr(workbook, "MOST_ROWS", 5)
    with pytest.raises(vfife.VfifeError, match="more rows than the 5 of a sheet; write .csv"):
        files.write_tables(target, {"t": [["x [m]"], *([0.0] for _ in range(4))]})
    files.write_tables(target, {"t": [["x [m]"], *([0.0] for _ in range(3))]})
    with (
        pytest.raises(vfife.VfifeError, match="has 16,385 columns"),
        open(tmp_path / "u.xlsx", "wb") as stream,
    ):
        write_workbook(stream, {"t": [["x"] * 16_385]})


def result() -> vfife.Result:
    m = vfife.gallery.four_bar()
    m.name = "Vier & <gelenk>ä"
    m.spring("Feder ü", "ground.A", "follower.end", stiffness="10 N/m")
    return vfife.simulate(m, duration="1 ms", outputs=20, loop="data-driven", companions=0, reference=False)


def test_a_run_in_a_workbook_and_with_commas_is_the_run(tmp_path: Path) -> None:
    run = result()
    table = run.to_dataframe().reset_index()
    run.export(tmp_path / "r.xlsx")
    sheets = read(tmp_path / "r.xlsx")
    (heads, units, *rows), about = sheets["Vier & <gelenk>ä"], dict(sheets["about"])
    both = [head if unit is None else f"{head} [{unit}]" for head, unit in zip(heads, units, strict=True)]
    assert both == list(table.columns) and "Feder ü.force_x" in heads and "N" in units
    of_readers = np.array(
        [[float(f"{x:.{10 if k == 0 else 7}g}") for k, x in enumerate(row)] for row in table.to_numpy()]
    )
    assert heads[0] == "time" and np.array_equal(np.array(rows, dtype=float), of_readers)
    assert about["model"] == run.name and "vfife_version" in about

    run.export(tmp_path / "r.csv", decimal="comma")
    with open(tmp_path / "r.csv", encoding="utf-8-sig", newline="") as stream:
        text = stream.read()
    head, *lines = csv.reader(text.splitlines(), delimiter=";")
    assert head == list(table.columns) and "." not in "".join(map("".join, lines))
    back = np.array([[float(one.replace(",", ".")) for one in line] for line in lines])
    assert np.array_equal(back, of_readers)


def test_a_decimal_comma_elsewhere_gets_a_sentence(tmp_path: Path) -> None:
    run = result()
    for name in ("r.xlsx", "forces.png"):
        with pytest.raises(vfife.VfifeError, match=r'decimal = "comma" is for \.csv'):
            run.export(tmp_path / name, decimal="comma")
    with pytest.raises(vfife.VfifeError, match='"komma" is neither "point" nor "comma"'):
        run.export(tmp_path / "r.csv", decimal="komma")
    assert not list(tmp_path.iterdir())


def test_measures_and_impacts_have_workbooks(tmp_path: Path) -> None:
    run = result()
    run.measures.write_table(tmp_path / "m.xlsx")
    ((heads, *rows),) = read(tmp_path / "m.xlsx").values()
    assert heads[0] == next(iter(run.measures.table()))[0] and len(rows) == len(run.measures)
    run.impacts.write_table(tmp_path / "i.xlsx")
    run.impacts.write_table(tmp_path / "i.csv")
    assert list(read(tmp_path / "i.xlsx")) == ["Impacts"] and (tmp_path / "i.csv").read_text().startswith(
        "joint"
    )
