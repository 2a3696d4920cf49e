"""Tables in CSV files beside a model: their numbers become the model's, faults name line and column, and
nothing outside the folder is read.
"""

import math
from pathlib import Path

import pytest
from typer.testing import CliRunner

import vfife
from model_texts import COMPRESSOR as MODEL
from model_texts import GAS
from vfife.cli.app import app
from vfife.cli.commands.check import defaults_of, reader_of
from vfife.errors import ModelError
from vfife.modelfile import csvtables, dump, load, loads

TABLE = "angle (deg), force (kN)\n# from the test rig\n0, 0\n90, 1.5\n\n180, 2\n360, 0\n"


def model(folder: Path, text: str, table: str | bytes = TABLE, name: str = "gas.csv") -> Path:
    """A model file with a table beside it."""
    (folder / name).write_bytes(table if isinstance(table, bytes) else table.encode())
    path = folder / "model.toml"
    path.write_text(MODEL + text)
    return path


def test_its_numbers_are_the_models(tmp_path):
    path = model(tmp_path, GAS + 'table = "gas.csv"\n')
    m = load(path)
    inline = loads(
        MODEL + GAS + 'angles = ["0 deg", "90 deg", "180 deg", "360 deg"]\nforce = [0, "1.5 kN", "2 kN", 0]\n'
    )
    assert m.loads == inline.loads
    (tmp_path / "gas.csv").unlink()
    assert loads(dump(m)) == m, "what is written holds the numbers, and needs no file"


@pytest.mark.parametrize(
    ("text", "table", "wanted"),
    [
        (
            GAS,
            "travel [mm];pressure (bar);pressure back (bar)\n150;1;1\n250;6;6\n",
            {"travels": (0.15, 0.25), "pressure_back": (1e5, 6e5)},
        ),
        (
            GAS,
            "﻿Travels (mm)\tForce (N)\n100\t-3e1\n200\t.5\n",
            {"travels": (0.1, 0.2), "force": (-30.0, 0.5)},
        ),
        (GAS, "\ufefftime (s);force (N)\n0,0;-1,5e2\n0,5;2\n", {"times": (0.0, 0.5), "force": (-150.0, 2.0)}),
        (GAS, "time (s),force (N)\n0,1\n0.5,2\n", {"times": (0.0, 0.5), "force": (1.0, 2.0)}),
        (
            '[load.gas]\nat = "rod.end"\nforce = [1, 0]\n',
            "times (ms), factor (%)\r\n0, 100\r\n500, 50\r\n",
            {"times": (0.0, 0.5), "factors": (1.0, 0.5)},
        ),
    ],
)
def test_heads_units_and_separators(tmp_path, text, table, wanted):
    bore = 'bore = "50 mm"\n' if "pressure" in table else ""
    found = load(model(tmp_path, text + bore + 'table = "gas.csv"\n', table)).loads["gas"]
    assert {key: getattr(found, key) for key in wanted} == wanted


def test_drivers_have_tables_too(tmp_path):
    text = MODEL.replace('speed = "600 rpm"', 'table = "way.csv"')
    path = model(tmp_path, "", "time (s), angle (deg)\n0, 0\n1, 90\n2, 360\n", "way.csv")
    path.write_text(text)
    driver = load(path).drivers["crank"]
    assert driver.values == pytest.approx((0.0, math.pi / 2, 2.0 * math.pi)) and driver.times == (
        0.0,
        1.0,
        2.0,
    )
    (tmp_path / "way.csv").write_text("speed (rpm), torque (N m)\n0, 3\n3000, 0\n")
    assert load(path).drivers["crank"].speeds == pytest.approx((0.0, 100.0 * math.pi))


FAULTS = {
    "a word": (
        TABLE.replace("1.5", "much"),
        'line 4, column 2 (force (kN)): this is a text that does not begin with a number ("much")',
    ),
    "a comma": (
        "angle (deg); force (kN)\n0; 1,5\n1; 2.5\n",
        "line 2, column 2 (force (kN)): this is a text with a comma",
    ),
    "commas of both kinds": ("angle (deg), force (kN)\n0,5, 1,5\n1,0, 2,5\n", "with semicolons"),
    "a unit in a cell": (TABLE.replace("1.5", "1.5 kN"), "line 4, column 2"),
    "not a number": (
        TABLE.replace("1.5", "nan"),
        "line 4, column 2 (force (kN)): this is not a finite number",
    ),
    "too few": (TABLE.replace("90, 1.5", "90"), "line 4 has 1 values"),
    "descends": (
        TABLE.replace("180", "80"),
        "line 6, column 1 (angle (deg)): this is not above the value before it",
    ),
    "a unit that does not fit": (TABLE.replace("kN", "mm"), "line 1, column 2: its unit is that of a length"),
    "an unknown unit": (
        TABLE.replace("kN", "kiloNewtn"),
        'table = "gas.csv": line 1, column 2: its unit "kiloNewtn" is unknown',
    ),
    "no unit": ("angle, force\n0, 0\n1, 2\n", 'For example "angle (deg)"'),
    "no unit in the second": ("angle (deg), force\n0, 0\n1, 2\n", "line 1, column 2: the column"),
    "no such column": (TABLE.replace("force", "forze"), 'Did you mean "force"'),
    "twice": (TABLE.replace("angle (deg), force (kN)", "force (kN), force (kN)"), "names a column twice"),
    "no quantity": (
        "Kurbelwinkel (°);force (kN)\n0;0\n1;2\n",
        "time (s), angle (deg), travel (mm), speed (m/s), factor, force (N), pressure (bar)",
    ),
    "nearly a quantity": ("angel (deg);force (kN)\n0;0\n1;2\n", 'id you mean "angle"'),
    "no head": ("0, 0\n1, 2\n", "line 1, column 1: this names no column"),
    # hours, by a careless pattern
    "a head of many spaces": (
        "angle" + " " * 3000 + "!, force\n0, 0\n",
        "line 1, column 1: this names no column",
    ),
    "one row": ("angle (deg), force (kN)\n0, 0\n", "has 1 rows of numbers"),
    "empty": ("", "does not name two columns"),
    "not UTF-8": (TABLE.encode() + b"\xff\xfe", "line 8 is not UTF-8"),
    "an open quote": ('angle (deg), force (kN)\n0, "1\n' + "x" * 200_000, "is not valid CSV"),
}


@pytest.mark.parametrize("name", FAULTS)
def test_a_fault_is_told_with_its_line_and_column(tmp_path, name):
    table, what = FAULTS[name]
    with pytest.raises(ModelError) as told:
        load(model(tmp_path, GAS + 'table = "gas.csv"\n', table))
    said = str(told.value)
    assert '[load.gas] table = "gas.csv": ' in said and what in said, said
    assert len(told.value.faults) == 1, said


@pytest.mark.parametrize(
    "name",
    [
        "/etc/hostname",
        "../outside.csv",
        "sub/../../outside.csv",
        "link.csv",
        "C:\\\\x.csv",
        "a\\u0000b",
        "x" * 5000,
    ],
)
def test_nothing_outside_the_folder_is_read(tmp_path, name):
    folder = tmp_path / "model"
    (folder / "sub").mkdir(parents=True)
    (tmp_path / "outside.csv").write_text(TABLE)
    (folder / "link.csv").symlink_to(tmp_path / "outside.csv")
    with pytest.raises(ModelError, match="leads out of the folder|no such file|no name of a file"):
        load(model(folder, GAS + f'table = "{name}"\n'))


def test_what_is_no_file_or_too_large_is_told(tmp_path, monkeypatch):
    (tmp_path / "folder.csv").mkdir()
    (tmp_path / "round.csv").symlink_to(tmp_path / "round.csv")
    for name, what in (
        ("folder.csv", "no such file"),
        ("round.csv", "no such file|no name of a file"),
        ("gaz.csv", 'Did you mean "gas.csv"'),
    ):
        with pytest.raises(ModelError, match=what):
            load(model(tmp_path, GAS + f'table = "{name}"\n'))
    with pytest.raises(ModelError, match="this is a whole number"):
        load(model(tmp_path, GAS + "table = 3\n"))
    with pytest.raises(ModelError, match="which has no folder"):
        loads(MODEL + GAS + 'table = "gas.csv"\n')
    with pytest.raises(ModelError, match="has a column for force, which the model has too"):
        load(model(tmp_path, GAS + 'table = "gas.csv"\nforce = 3\n'))
    monkeypatch.setattr(csvtables, "LARGEST", 40)
    with pytest.raises(ModelError, match="too large"):
        load(model(tmp_path, GAS + 'table = "gas.csv"\n'))
    monkeypatch.undo()
    monkeypatch.setattr(csvtables, "MOST_ROWS", 3)
    with pytest.raises(ModelError, match="line 7 is too many"):
        load(model(tmp_path, GAS + 'table = "gas.csv"\n'))


def test_check_tells_its_defaults(tmp_path):
    path = model(tmp_path, GAS + 'table = "gas.csv"\n')
    assert {"load.gas.interpolation", "load.gas.reverse"} <= {
        one["path"] for one in defaults_of(reader_of(path, []))
    }
    answer = CliRunner().invoke(app, ["check", str(path)])
    assert answer.exit_code == 0, answer.output


def test_other_faults_are_told_beside_it(tmp_path):
    with pytest.raises(ModelError) as told:
        load(
            model(tmp_path, GAS + 'table = "gone.csv"\n').with_name("model.toml"),
            set=[("body.rod.length", "-1 m")],
        )
    assert len(told.value.faults) == 2


def test_a_run_goes_on_without_the_file(tmp_path):
    """The run's copy of the model has the numbers."""
    m = load(model(tmp_path, GAS + 'table = "gas.csv"\n'))
    run = tmp_path / "run"
    vfife.simulate(
        m, turns=0.1, step=1e-4, outputs=100, force_step=True, reference=False, loop="data-driven"
    ).save(run)
    (tmp_path / "gas.csv").unlink()
    again = vfife.load_result(run)
    assert again.record.assembly.mechanism.loads == m.loads
    on = vfife.resume(run, until=0.02)
    assert on.record.status == "complete" and on.time[-1] == pytest.approx(0.02)
