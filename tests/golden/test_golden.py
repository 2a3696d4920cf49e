"""Contact-rich runs keep their bits: what a change of the house must not move. A change of the physics takes the hashes anew and says why.

``python tests/golden/test_golden.py`` writes them. A start is closed by linear algebra whose last bits depend on the machine, so the start is
rounded to single precision first, and what is nothing but round-off is made zero: what follows is the step's own arithmetic, which is the same
everywhere.
"""

from __future__ import annotations

import dataclasses
import hashlib
import json
import sys
from importlib import import_module
from pathlib import Path

import numpy as np
import pytest

import vfife
from vfife.assembly.assemble import assemble
from vfife.solvers.transient import run

ROOT = Path(__file__).resolve().parents[2]
HASHES = Path(__file__).with_name("hashes.json")
CASES = {
    "four_bar": 0.002, "four_bar_case_b": 0.002, "four_bar_case_c": 0.004, "four_bar_ideal": 0.01, "slider_crank_loose_guide": 0.01,
    "slider_crank_loose_pin": 0.003, "journal_in_bearing": 0.001, "block_on_incline": 0.01, "squeezer": 0.003, "elastic_pendulum": 0.2,
    "gear_train": 0.05, "scotch_yoke": 0.05, "six_bar_press": 0.2, "double_pendulum": 0.2, "jansen_leg": 0.2,
}  # fmt: skip
# Mechanisms of one of each kind that no example has: seconds, and the mechanism.
KINDS = {"every kind": (0.004, "everything"), "every drive": (0.006, "every_drive"), "every law": (0.0006, "every_law")}
NOTHING = 1e-9  # in units of SI; a force of a start is round-off below it


def digest(name: str, loop: str) -> str:
    """Hash of the recorded rows of a run of so many seconds."""
    if name in KINDS:
        duration, made = KINDS[name]
        assembly = assemble(getattr(import_module("mechanisms"), made)(), 2e-6, duration=duration, outputs=40, force_step=True)
    else:
        assembly = assemble(vfife.load_model(ROOT / "examples" / f"{name}.toml"), duration=CASES[name])
    state = assembly.state.astype(np.float32).astype(float)
    moving = assembly.layout.of("state", "memory")
    state[moving] = np.where(np.abs(state[moving]) < NOTHING, 0.0, state[moving])
    record = run(dataclasses.replace(assembly, state=state), loop=loop)  # type: ignore[arg-type]
    assert record.status == "complete"
    return hashlib.sha256((record.rows + 0.0).astype("<f8").tobytes()).hexdigest()[:32]  # + 0.0: signs of zeros may differ


@pytest.mark.parametrize("name", CASES)
def test_bits_are_as_before(name):
    assert digest(name, "data-driven") == json.loads(HASHES.read_text())[name]


@pytest.mark.parametrize("name", ["four_bar_case_c", "slider_crank_loose_guide"])
def test_bits_are_those_of_the_straight_line(name):
    assert digest(name, "generated") == json.loads(HASHES.read_text())[name]


@pytest.mark.parametrize("name", KINDS)
def test_bits_of_every_kind_are_as_before(name):
    assert digest(name, "generated") == json.loads(HASHES.read_text())[name]


if __name__ == "__main__":
    sys.path.insert(0, str(ROOT / "tests"))
    HASHES.write_text(
        json.dumps({name: digest(name, "generated" if name in KINDS else "data-driven") for name in (*CASES, *KINDS)}, indent=1) + "\n"
    )
