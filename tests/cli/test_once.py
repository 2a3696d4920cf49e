"""One run reads its model once, writes it once, assembles it once and cuts each elastic body once; the ideal
reference is its own assembly.
"""

import tomllib
from collections import Counter
from collections.abc import Callable
from pathlib import Path

import pytest

from vfife import modelfile
from vfife.assembly import assemble as assembling
from vfife.model import lumping
from vfife.modelfile import read
from vfife.results import provenance
from vfife.simulation import start

EXAMPLES = Path(__file__).resolve().parents[2] / "examples"


@pytest.fixture
def counted(monkeypatch: pytest.MonkeyPatch) -> Counter[str]:
    """How often a model was parsed, written, assembled and cut, ideal ones apart."""
    found: Counter[str] = Counter()

    def watch(module: object, name: str, word: str) -> None:
        original = getattr(module, name)

        def watched(*args, **kwargs):
            ideal = word in ("assemble", "dump") and not args[0].contacts
            found[f"{word} ideal" if ideal else word] += 1
            return original(*args, **kwargs)

        monkeypatch.setattr(module, name, watched)

    watch(tomllib, "loads", "parse")
    for module in {modelfile, read, provenance}:
        if hasattr(module, "dump"):
            watch(module, "dump", "dump")
    for module in (start, assembling):
        watch(module, "assemble", "assemble")
    for name in ("_link", "_frame"):
        watch(lumping, name, "mesh")
    return found


@pytest.mark.parametrize(("model", "elastic"), [("four_bar", 2), ("four_bar_case_c", 0)])
def test_one_run_does_it_once(command: Callable, counted: Counter[str], model: str, elastic: int) -> None:
    done = command("run", EXAMPLES / f"{model}.toml", "--turns", 0.02, "--step", "1 us", "--quiet")
    assert done.exit_code == 0, done.stderr
    assert counted == +Counter(
        {"parse": 1, "dump": 1, "dump ideal": 1, "assemble": 1, "assemble ideal": 1, "mesh": elastic}
    )


def test_an_elastic_model_without_joints_with_play(command: Callable, counted: Counter[str]) -> None:
    done = command("run", EXAMPLES / "elastic_pendulum.toml", "--duration", "1 ms", "--quiet")
    assert done.exit_code == 0, done.stderr
    assert counted == Counter({"parse": 1, "dump ideal": 1, "assemble ideal": 1, "mesh": 1})
    counted.clear()
    assert command("info", "runs/elastic_pendulum").exit_code == 0
    assert counted == Counter({"parse": 1})
    counted.clear()
    assert command("export", "runs/elastic_pendulum", "out.nc").exit_code == 0
    assert counted["assemble"] + counted["assemble ideal"] == 0 and counted["parse"] == 1
