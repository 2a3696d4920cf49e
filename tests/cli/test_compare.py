"""`vfife compare` and vfife.compare: the runs are those that `vfife run` makes with each law, and nothing
else differs.
"""

import csv
import errno
import json
import os
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

import vfife
from cli.models import CASE_C
from laws.test_own_laws import COPY
from vfife import files
from vfife.cli.commands import compare as module
from vfife.plots.sensitivity import bars
from vfife.plots.style import STYLE
from vfife.studies.methods import compare as study
from vfife.studies.methods.compare import Parts
from vfife.studies.methods.comparison_rows import influence_on

pytestmark = pytest.mark.usefixtures("only_built_in_laws")

SHORT = {"turns": 0.5}


def drawn(figure: Any) -> list[Any]:
    """Return all texts of a figure."""
    return list(figure.findobj(lambda artist: hasattr(artist, "get_text")))


def test_each_run_is_the_run_of_its_law() -> None:
    """Parameters that both laws have are kept (restitution 0.6, coefficient), those of its own are the law's
    defaults.
    """
    model = vfife.load_model(CASE_C, set=[("joint.B.contact.restitution", 0.6)])
    found = vfife.compare(model, ["pereira", vfife.laws.LankaraniNikravesh], ["ambrosio", "none"], **SHORT)
    assert [(row["contact"], row["friction"]) for row in found.rows] == [
        ("pereira", "ambrosio"), ("pereira", "none"), ("lankarani-nikravesh", "ambrosio"),
        ("lankarani-nikravesh", "none"),
    ]  # fmt: skip
    for row, name, friction in (
        (found.rows[1], "pereira", "none"),
        (found.rows[2], "lankarani-nikravesh", "ambrosio"),
    ):
        laws = [
            (f"joint.{joint}.{kind}.law", law)
            for joint in "BCD"
            for kind, law in (("contact", name), ("friction", friction))
        ]
        alone = vfife.simulate(
            vfife.load_model(CASE_C, set=[("joint.B.contact.restitution", 0.6), *laws]), companions=0, **SHORT
        )
        for joint in "BCD":
            assert row["joints"][joint]["force.max"] == alone.measures[f"{joint}.force.max"]
            assert row["joints"][joint]["lip_force"] == alone.measures[f"{joint}.force.lip"]
        assert row["impacts"] == sum(alone.measures[f"{joint}.impacts"] for joint in "BCD")
        lost = alone.ledger.terms["contact_loss"][-1] + alone.ledger.terms["friction_loss"][-1]
        assert row["energy_lost"] == lost
    text = " ".join(str(found).split())
    assert "carries the load by each of these laws; that by a law without damping may be several" in text
    joint = found.results[0].record.assembly.mechanism.clearances
    assert joint["B"].contact == vfife.laws.Pereira(restitution=0.6)
    assert joint["C"].friction.coefficient == model.clearances["C"].friction.coefficient
    assert found.results[2].record.assembly.mechanism.clearances["C"].contact.stiffness == 6.6e10
    assert found.rows[1]["energy_lost"] != found.rows[0]["energy_lost"]


def test_a_force_or_acceleration_that_the_ideal_mechanism_has_not_has_no_change() -> None:
    """The block of a Scotch yoke does not turn but for rounding; the change was 3.5e22 %."""
    ideal = {"block.angular_acceleration.max": 1e-20, "rod.angular_acceleration.max": 40.0}
    loose = {"block.angular_acceleration.max": 5.0, "rod.angular_acceleration.max": 50.0}
    lips = {"block.angular_acceleration.lip": 5e22, "rod.angular_acceleration.lip": 25.0}
    run = SimpleNamespace(measures=loose | lips, reference=SimpleNamespace(measures=ideal))
    assert influence_on(run, "block.angular_acceleration") is None
    assert influence_on(run, "rod.angular_acceleration") == 25.0
    assert influence_on(SimpleNamespace(measures=loose, reference=None), "rod.angular_acceleration") is None


def test_numbers_have_the_ranges_of_their_runs() -> None:
    """With companions those of ``vfife run``; without, no row has any, and the table says so once."""
    model, options = vfife.load_model(CASE_C), {"turns": 0.5, "step": 1e-6}
    found = vfife.compare(model, "lankarani-nikravesh", companions=3, **options)
    alone, row = vfife.simulate(model, companions=3, **options).measures, found.rows[0]
    for joint in "BCD":
        force = alone[f"{joint}.force.max"]
        numbers = row["joints"][joint]
        assert force.high > force.low
        assert (numbers["force.max.low"], numbers["force.max.high"]) == (force.low, force.high)
    assert row["force.high"] == max(alone[f"{joint}.force.max"].high for joint in "BCD")
    assert row["impacts.low"] == sum(alone[f"{joint}.impacts"].low for joint in "BCD")
    heads = next(iter(found.table()))
    assert {"force.max.low", "force.max.high", "lip_acceleration.low"} <= set(heads)
    assert "energy_lost.low" not in heads
    assert "Ranges by runs with other step sizes" in str(found)
    assert "uncertainty not estimated: lost." in str(found)
    assert f"{row['force']:,.6g}" not in str(found), "no digit is finer than the range"
    assert any("other step sizes" in text.get_text() for text in drawn(bars(found)))

    bare = vfife.compare(model, "hertz", **options)
    assert not any(head.endswith((".low", ".high")) for head in next(iter(bare.table())))
    assert str(bare).count("not estimated") == 1 and "--companions 3" in " ".join(str(bare).split())
    assert any("errors not estimated" in text.get_text() for text in drawn(bars(bare)))


def test_only_the_joint_that_is_named_changes() -> None:
    found = vfife.compare(vfife.load_model(CASE_C), ["pereira"], joints=["C"], **SHORT)
    laws = {
        name: joint.contact.name
        for name, joint in found.results[0].record.assembly.mechanism.clearances.items()
    }
    assert laws == {"B": "lankarani-nikravesh", "C": "pereira", "D": "lankarani-nikravesh"}
    assert list(found.rows[0]["joints"]) == ["C"] and found.rows[0]["friction"] == "ambrosio"


def test_an_interrupt_keeps_what_is_complete() -> None:
    def progress(name: str) -> None:
        if name.startswith("2 of 3"):
            raise KeyboardInterrupt

    try:
        found = vfife.compare(vfife.load_model(CASE_C), ["pereira"] * 3, progress=progress, **SHORT)
    except KeyboardInterrupt:
        pytest.fail("the run that was complete is lost")
    assert len(found.rows) == 1 and found.planned == 3


class Killed(BaseException):
    """What nobody catches."""


@pytest.mark.system("kills a process")
def test_a_comparison_that_was_killed_goes_on(command: Callable, monkeypatch: pytest.MonkeyPatch) -> None:
    """With the runs that were complete, to the bit; nothing is run again, and what kept them is gone at the
    end.
    """
    words = (
        "compare",
        CASE_C,
        "--contact",
        "lankarani-nikravesh,pereira,hertz,flores",
        "--turns",
        0.2,
        "--no-figures",
        "--json",
    )
    whole = json.loads(command(*words, "-o", "whole").stdout)["runs"]
    keep, asked, made, limit = Parts.save, study.run_all, list[str](), 2

    def kept(self: Parts, one: Any, result: vfife.Result) -> None:
        made.append("")
        if len(made) == limit:
            raise broken()
        keep(self, one, result)

    def carried(ready: Any, told: Any) -> Any:
        left.append(len(ready))
        return asked(ready, told)

    monkeypatch.setattr(Parts, "save", kept)
    monkeypatch.setattr(study, "run_all", carried)
    broken: type[BaseException] = Killed
    left: list[int] = []
    with pytest.raises(Killed):
        command(*words, "-o", "out")
    made.clear()
    broken = KeyboardInterrupt
    done = command(*words, "-o", "out")
    assert (
        done.exit_code == 130
        and "2 of 4 runs are complete" in done.stderr
        and "with -o out continues after them" in done.stderr
    )
    other = command(*words, "-o", "out", "--set", "joint.B.clearance=0.3 mm")
    assert other.exit_code == 2 and "of another model" in other.stderr
    made.clear()
    done = command(*words, "-o", "out")
    assert done.exit_code == 0 and left == [4, 3, 2]
    for one, again in zip(whole, json.loads(done.stdout)["runs"], strict=True):
        assert {**one, "wall_s": 0.0} == {**again, "wall_s": 0.0}
    assert sorted(path.name for path in Path("out").iterdir()) == [
        "compare.csv",
        "compare.json",
        "model.toml",
    ]
    before = Path("out/compare.json").read_bytes()
    refused = command(*words, "-o", "out")
    assert (
        refused.exit_code == 2
        and "--force" in refused.stderr
        and Path("out/compare.json").read_bytes() == before
    )
    monkeypatch.setattr(Parts, "save", keep)
    assert command(*words, "-o", "out", "--force").exit_code == 0


def test_a_part_that_is_damaged_is_made_again(tmp_path: Path) -> None:
    model, laws = vfife.load_model(CASE_C), ["pereira", "hertz", "flores"]
    last = list[str]()

    def progress(name: str) -> None:
        if name.startswith("3 of 3") and not last:
            last.append(name)
            raise KeyboardInterrupt

    assert len(vfife.compare(model, laws, progress=progress, folder=tmp_path, turns=0.1).rows) == 2
    for part in tmp_path.iterdir():
        part.write_bytes(part.read_bytes()[:5000])
    found = vfife.compare(model, laws, progress=progress, folder=tmp_path, turns=0.1)
    assert [row["status"] for row in found.rows] == ["complete"] * 3 and found.rows[0]["impacts"] >= 0


@pytest.mark.parametrize("what", ["keep", "summary"])
def test_a_full_disk_is_told(command: Callable, monkeypatch: pytest.MonkeyPatch, what: str) -> None:
    words = ("compare", CASE_C, "--contact", "pereira,hertz", "--turns", 0.1, "-o", "out", "--no-figures")

    def full(*args: Any, **how: Any) -> Any:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC), "somewhere")

    with monkeypatch.context() as context:
        context.setattr(
            *((files.os, "replace") if what == "keep" else (vfife.studies.Comparison, "write_csv")), full
        )
        done = command(*words, "--json")
    assert done.exit_code == 5 and "bytes are free there" in done.stderr and "continue" in done.stderr, (
        done.stderr,
        done.exception,
    )
    assert json.loads(done.stdout)["status"] == "storage" and not Path("out/run.lock").exists()
    assert command(*words, *(["--force"] if what == "summary" else []), "--quiet").exit_code == 0


def test_the_command(command: Callable, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(STYLE, "savefig.dpi", 160)  # sizes of pictures are those that a user has
    (tmp_path / "my_laws.py").write_text(COPY)
    words = (
        "compare",
        CASE_C,
        "--contact",
        "lankarani-nikravesh,mine,pereira",
        "--laws",
        "my_laws.py",
        "--turns",
        0.5,
    )
    done = command(*words, "-o", "out", "--json")
    assert done.exit_code == 0, done.stderr
    said = json.loads(done.stdout)
    first, mine, pereira = said["runs"]
    assert first["joints"] == mine["joints"] and first["force"] == mine["force"] != pereira["force"]
    assert json.loads(Path("out/compare.json").read_text())["runs"] == said["runs"]
    table = list(csv.DictReader(Path("out/compare.csv").read_text().splitlines()))
    assert len(table) == 9 and float(table[0]["force.max"]) == first["joints"]["B"]["force.max"]
    assert {path.name for path in Path("out").iterdir()} == {
        "compare.json",
        "compare.csv",
        "model.toml",
        "forces.png",
        "bars.png",
    }
    assert all(Path(f"out/{name}.png").stat().st_size > 20_000 for name in ("forces", "bars"))
    text = command(*words, "--quiet", "--no-figures", "--joint", "C")
    assert (
        text.exit_code == 0
        and text.stdout == ""
        and Path("runs/four_bar_case_c-compare/compare.csv").exists()
    )


@pytest.mark.parametrize(
    ("words", "expected"),
    [
        ([], "name contact laws"),
        (["--contact", "perreira"], 'did you mean "pereira"'),
        (["--contact", "ambrosio"], "no contact law"),
        (
            ["--contact", "impact"],
            "--set joint.name.contact.law=impact --set joint.name.contact.stiffness=value",
        ),
        (["--contact", "impact"], "exponent (in 1) and damping_coefficient (in n s/m)"),
        (["--contact", "pereira,table"], "no default for loading"),
        (["--friction", "pereira"], "no friction law"),
        (["--contact", "pereira", "--joint", "A"], "joint a is ideal"),
        (["--contact", "pereira", "--joint", "Q"], "there is no joint"),
        (["--contact", "pereira", "--set", "joint.C.clearance=0.5 um"], "no exponent for a clearance"),
        (["--contact", "pereira", "--step", "1 ms"], "too large"),
        (["--contact", "pereira", "--laws", "none.py"], "cannot be read"),
    ],
)
def test_what_cannot_be_compared_is_told(command: Callable, words: list[str], expected: str) -> None:
    done = command("compare", CASE_C, *words)
    assert done.exit_code == 2 and expected in done.stderr.lower(), done.stderr
    assert "Traceback" not in done.output and not Path("runs").exists()


def test_all_laws_are_those_with_defaults(monkeypatch: pytest.MonkeyPatch) -> None:
    """One that needs a number of its own would stop all others; it is named and left out."""
    told: list[str] = []
    monkeypatch.setattr(module, "tell", lambda word, sentence, *_: told.append(sentence))
    names = module.law_names("all", "contact")
    assert "pereira" in names and not {"impact", "kelvin-voigt", "table"} & set(names)
    assert "impact" in told[0] and "no default" in told[0]
    mechanism = vfife.load_model(CASE_C)
    assert len(list(study.law_variants(mechanism, names, [], ["C"]))) == len(names)


def test_a_model_without_clearance(command: Callable, pendulum: Path) -> None:
    done = command("compare", pendulum, "--contact", "pereira")
    assert done.exit_code == 2 and "no pin of this mechanism has clearance" in done.stderr
