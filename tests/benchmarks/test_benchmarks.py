"""The benchmarks tell the truth: of candidates that diverge, and of numbers that were taken with another
step.
"""

import ast
import importlib
import importlib.util
import json
import sys
from pathlib import Path
from types import SimpleNamespace

import pytest

from fake_card import FakeDriver, in_this_machine
from vfife import load_model
from vfife.assembly.assemble import assemble

ROOT = Path(__file__).resolve().parents[2]


@pytest.fixture(autouse=True)
def benchmarks(monkeypatch):
    """Its files are scripts beside each other, not a package."""
    monkeypatch.syspath_prepend(str(ROOT / "benchmarks"))
    before = set(sys.modules)
    yield
    for name in set(sys.modules) - before:
        if str(getattr(sys.modules[name], "__file__", "")).startswith(str(ROOT / "benchmarks")):
            del sys.modules[name]


def test_the_page_says_so_when_the_step_has_changed():
    from page import tables

    report = json.loads((ROOT / "benchmarks" / "latest.json").read_text()) | {"step": "0123"}
    assert "is the one that was measured" in tables("0123", report)["@TOLD@"]
    assert "has changed since" in tables("4567", report)["@TOLD@"]
    del report["step"]
    assert "has changed since" in tables("0123", report)["@TOLD@"]


def test_every_mark_of_the_page_is_filled():
    from page import tables

    text = (ROOT / "docs" / "benchmarks.md").read_text()
    for mark, table in tables("").items():
        assert text.count(mark) == 1
        text = text.replace(mark, table)
    assert "@" not in text


def test_the_hash_is_that_of_what_is_computed(monkeypatch):
    """A comment is no change; a coefficient is."""
    import measure

    before = measure.step_text()
    assert measure.step_text() == before
    module = measure.module
    monkeypatch.setattr(
        measure, "module", lambda *args: module(*args).replace("0x3FE0000000000000", "0x3FE0000000000001")
    )
    assert measure.step_text() != before


def test_a_run_that_diverges_is_told_as_such(monkeypatch):
    """It has no second revolution and so no maximum; it is the wrong end of a scan, not an error."""
    import peers

    diverged = SimpleNamespace(status="diverged", wall=1.0)
    monkeypatch.setattr(peers, "advance", lambda *given, **options: diverged)
    case = peers.Case("b")
    found = case.run(1.6e-5, "generated")
    assert found["ms"] == float("inf")
    assert peers.row("b", 1.6e-5, found)[2] == "diverged"
    assert case.largest_good_step((1.6e-5, 1e-5))[0] == 1e-5
    assert measured_json(found) == {
        "ms": None,
        "err_alpha": None,
        "err_force": None,
        "refused_by_default": 1.0,
    }


def measured_json(found):
    import measure

    return json.loads(json.dumps(measure.plain(found), allow_nan=False))


@pytest.mark.parametrize(
    "said", [{"err_alpha": None, "err_force": 0.1}, {"err_alpha": float("nan"), "err_force": 0.1}]
)
def test_another_program_that_diverges_is_told_as_such(monkeypatch, said):
    import peers

    monkeypatch.setattr(peers, "run", lambda *given: {"wall_per_rev_s": 1.0, **said})
    candidate = peers.CANDIDATES["b"][0]
    assert "mujoco diverged at a step of" in peers.peer(candidate, "b", 1)["missing"]


def test_members_on_a_card_are_counted_and_a_card_that_is_missing_is_told(monkeypatch):
    """With a card that the processor plays: no time of it means anything."""
    import card
    from measure import Options

    with in_this_machine(FakeDriver(None, cuInit=100)):
        assert "no card" in card.measure(Options(quick=True)).notes[0]
    monkeypatch.setattr(card, "MEMBERS", (40,))
    monkeypatch.setattr(card, "STEPS", 20)
    monkeypatch.setattr(card, "ONE", 1000)
    monkeypatch.setattr(card, "SETTLED", 30)
    topology = assemble(load_model(ROOT / "examples" / "four_bar_case_c.toml"), turns=1000).topology
    with in_this_machine(FakeDriver(topology)) as driver:
        found = card.measure(Options(quick=True))
    assert set(found.ratios) == {"card.members_64"} and found.ratios["card.members_64"] > 0.0
    assert driver.threads == [64, 64]


@pytest.mark.parametrize("path", sorted((ROOT / "benchmarks").glob("*.py")), ids=lambda path: path.stem)
def test_what_a_part_imports_of_the_package_is_there(path):
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.ImportFrom) and (node.module or "").partition(".")[0] == "vfife":
            module = importlib.import_module(node.module)
            missing = [
                one.name
                for one in node.names
                if not hasattr(module, one.name) and not importlib.util.find_spec(f"{node.module}.{one.name}")
            ]
            assert not missing, f"{path.name}, line {node.lineno}: {node.module} has no {', '.join(missing)}"
