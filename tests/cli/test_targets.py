"""What a command reads it does not write over: the model, the data, the tables that a model names; nor a
folder, nor one file twice.
"""

from collections.abc import Callable
from pathlib import Path

import pytest

from cli.models import ROOT
from vfife.cli.outputs import refuse_inputs

MODEL = """[joint.C.contact]
law = "table"
loading = "press.csv"
"""
SWEPT = ("--over", "joint.C.clearance=0.1..1mm")
BAD = {
    "the model, worn": ("wear", "m.toml", "--worn", "m.toml"),
    "the model by a link": ("wear", "m.toml", "--worn", "link.toml"),
    "no folder for the worn model": ("wear", "m.toml", "--worn", "none/w.toml"),
    "data of a fit": ("fit", "m.toml", "data.csv", "-p", "a=1..2", "--csv", "data.csv"),
    "a curve": ("fit", "--law", "impact", "data.csv", "--csv", "data.csv"),
    "a table of the model": ("sensitivity", "m.toml", "--csv", "press.csv"),
    "the same of a map": ("map", "m.toml", *SWEPT, "--csv", "press.csv"),
    "the same of a section": ("map", "section", "m.toml", "--csv", "press.csv"),
    "the same of basins": ("map", "basins", "m.toml", *SWEPT, "--csv", "press.csv"),
    "the same of a waterfall": ("waterfall", "m.toml", *SWEPT, "--csv", "press.csv"),
    "the model as a map": ("map", "m.toml", *SWEPT, "-o", "m.toml"),
    "a folder": ("sensitivity", "m.toml", "--figure", "d.png"),
    "a folder of a spectrum": ("spectrum", "run", "--csv", "d.csv"),
}


@pytest.mark.parametrize("case", BAD)
def test_what_is_read_stays(command, tmp_path, case):
    texts = {
        "m.toml": MODEL,
        "press.csv": "penetration (um), force (N)\n0,0\n1,1\n",
        "data.csv": "time (s), C.force (N)\n0,1\n",
    }
    for name, text in texts.items():
        (tmp_path / name).write_text(text)
    (tmp_path / "link.toml").symlink_to(tmp_path / "m.toml")
    for name in ("d.png", "d.csv"):
        (tmp_path / name).mkdir()
    before = sorted(path.name for path in tmp_path.iterdir())
    done = command(*BAD[case])
    said = ("would be overwritten; name another file", "this is a folder; name a file", "make it first")
    assert done.exit_code == 2 and any(one in " ".join(done.stderr.split()) for one in said), done.stderr
    assert {name: (tmp_path / name).read_text() for name in texts} == texts
    assert sorted(path.name for path in tmp_path.iterdir()) == before


def test_two_targets_are_two_files_and_all_faults_are_told(tmp_path):
    (tmp_path / "m.toml").write_text(MODEL)
    one = tmp_path / "a.csv"
    with pytest.raises(ValueError, match="--csv is written there too.*--worn .*would be overwritten"):
        refuse_inputs(
            (("--csv", one), ("--figure", one), ("--worn", tmp_path / "m.toml")), (tmp_path / "m.toml",)
        )
    refuse_inputs((("--csv", one), ("--figure", None)), (tmp_path / "m.toml", tmp_path / "none.toml", None))


SAID = {
    "skipped for ever": (
        ("fit", "pin.toml", "data.csv", "-p", "joint.pin.clearance=0.1..1mm", "--skip", "inf"),
        "skip = inf: this is not a finite number",
    ),
    "a name twice": (
        ("fit", "pin.toml", "twice.csv", "-p", "joint.pin.clearance=0.1..1mm"),
        "several columns of this name",
    ),
    "a law has no use for it": (
        ("fit", "--law", "impact", "data.csv", "--fitted", "w.toml", "-p", "a=1..2"),
        "--parameter, --fitted: the fit of a law does not use this",
    ),
    "no number of turns": (("sensitivity", "pin.toml", "--turns", "nan"), "turns"),
    "one number twice": (
        ("map", "basins", "pin.toml", *("--over", "start.pin.x=0..0.2mm") * 2, "--turns", "3", "--drop", "1"),
        "x and y are the same number",
    ),
    "a map that is not there": (("map", "show", "none.map"), "there is no map file of this name"),
    "a picture of somebody's": (("wear", "pin.toml", "-o", "mine.wear"), "this picture is not one of vfife"),
}


@pytest.mark.parametrize("case", SAID)
def test_what_is_wrong_is_told_with_a_next_step(command, tmp_path, case):
    (tmp_path / "pin.toml").write_text((ROOT / "examples" / "slider_crank_loose_pin.toml").read_text())
    rows = "".join(f"{k}e-4,{k % 5},{k}\n" for k in range(12))
    (tmp_path / "data.csv").write_text(f"time (s), pin.force (N), x\n{rows}")
    (tmp_path / "twice.csv").write_text(f"time (s), pin.force (N), pin.force (kN)\n{rows}")
    (tmp_path / "mine-wear.png").write_bytes(b"\x89PNG, drawn by hand")
    words, said = SAID[case]
    done = command(*words)
    text = " ".join(done.stderr.split())
    assert (
        done.exit_code == 2 and said in text and "cannot convert" not in text and "Traceback" not in text
    ), text
    assert (tmp_path / "mine-wear.png").read_bytes() == b"\x89PNG, drawn by hand" and not (
        tmp_path / "mine.wear"
    ).exists()


@pytest.mark.parametrize(
    "words",
    [
        (
            "fit",
            "pin.toml",
            "data.csv",
            "-p",
            "joint.pin.clearance=0.1..0.3mm",
            "--screened",
            "2",
            "--starts",
            "1",
            "--step",
            "10us",
        ),
        ("map", "section", "pin.toml", "--turns", "3", "--step", "10us"),
        (
            "waterfall",
            "pin.toml",
            "--over",
            "driver.crank.speed=800..900rpm",
            "--count",
            "2",
            "--turns",
            "3",
            "--step",
            "10us",
        ),
    ],
    ids=lambda words: words[0],
)
def test_where_no_folder_of_runs_can_be_made_a_sentence_says_so(command, tmp_path, words):
    """A file of that name stands for a folder that nobody may write in: tests may be run by one who may."""
    (tmp_path / "pin.toml").write_text((ROOT / "examples" / "slider_crank_loose_pin.toml").read_text())
    (tmp_path / "data.csv").write_text(
        "time (s), pin.force (N)\n" + "".join(f"{k}e-4,{k % 5}\n" for k in range(20))
    )
    (tmp_path / "runs").write_text("mine")
    done = command(*words)
    assert isinstance(done.exception, SystemExit) and done.exit_code == 2 and "File exists" in done.stderr, (
        done.exception,
        done.stderr,
    )
    assert (tmp_path / "runs").read_text() == "mine"


def test_an_export_names_its_file_as_other_commands_do(command: Callable, case_c_run: Path) -> None:
    """With -o, or as the last word; not twice, and not at all."""
    for words in (["-o", "a.csv"], ["b.csv"]):
        done = command("export", case_c_run, *words)
        assert done.exit_code == 0 and Path(words[-1]).stat().st_size > 1000, done.stderr
    assert Path("a.csv").read_bytes() == Path("b.csv").read_bytes()
    for words in ([], ["c.csv", "-o", "d.csv"]):
        done = command("export", case_c_run, *words)
        assert done.exit_code == 2 and "name one file to write, as in -o out.csv" in done.stderr
