"""Contact-rich runs keep their bits: what a change of the house must not move. A change of the physics takes
the hashes anew and says why.

The twelve of ``RICH`` hold for every loop, as many lanes as a register may have, any number of threads and
any processor: what takes long of that is in `tests/verification`. Examples begin as `vfife run` has them
begin: examined, with the forces of their ideal reference, closed and assembled; nothing is rounded.
``make golden`` takes the hashes anew.
"""

from __future__ import annotations

import hashlib
import json
from concurrent.futures import ThreadPoolExecutor
from functools import cache
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import vfife
from choice import default_cases
from fake_card import rows_on_card
from vfife.assembly.assemble import assemble
from vfife.assembly.assembled import Assembly
from vfife.simulation.simulate import prepare
from vfife.solvers.arguments import RunArguments
from vfife.solvers.record import Record
from vfife.solvers.transient import run

ROOT = Path(__file__).resolve().parents[2]
HASHES = Path(__file__).with_name("hashes.json")
CASES = {
    "four_bar": 0.002, "four_bar_case_b": 0.002, "four_bar_case_c": 0.004, "four_bar_ideal": 0.01,
    "slider_crank_loose_guide": 0.01, "slider_crank_loose_pin": 0.003, "journal_in_bearing": 0.001,
    "block_on_incline": 0.01, "squeezer": 0.003, "elastic_pendulum": 0.2, "gear_train": 0.05,
    "scotch_yoke": 0.05, "six_bar_press": 0.2, "double_pendulum": 0.2, "jansen_leg": 0.2,
}  # fmt: skip
# Mechanisms of one of each kind that no example has: seconds, and the mechanism.
KINDS = {
    "every kind": (0.004, "everything"),
    "every drive": (0.006, "every_drive"),
    "every law": (0.0006, "every_law"),
}
# Models that loops are compared by: seconds, and the step (s).
MODELS = {
    "rigid_bars": (0.01, 2e-6), "two_particle_bars": (0.008, 1e-6), "one_clearance": (0.01, 2e-6),
    "swing": (0.02, 4e-6), "journals": (0.004, 1e-6),
    "machinery": (0.02, 4e-6), "worn_bars": (0.01, 2e-6),
}  # fmt: skip
RICH = (
    "four_bar",
    "four_bar_case_b",
    "four_bar_case_c",
    "slider_crank_loose_guide",
    "block_on_incline",
    "every law",
    *MODELS,
)
ON_CARD = ("four_bar_case_c", "two_particle_bars", "machinery")


@cache
def start(name: str) -> Assembly:
    """The case assembled, for a run of so many seconds."""
    if name in KINDS:
        duration, made = KINDS[name]
        return assemble(
            getattr(import_module("mechanisms"), made)(), 2e-6, duration=duration, outputs=40, force_step=True
        )
    if name in MODELS:
        duration, step = MODELS[name]
        return assemble(
            getattr(import_module("lane_models"), name)(0),
            step,
            duration=duration,
            outputs=40,
            force_step=True,
        )
    return prepare(
        vfife.load_model(ROOT / "examples" / f"{name}.toml"), RunArguments(duration=CASES[name])
    ).assembly


def record(name: str, loop: str, companions: int = 0) -> Record:
    """The case run, with so many companions beside it."""
    found = run(start(name), loop=loop, companions=companions)  # type: ignore[arg-type]
    assert found.status == "complete"
    return found


once = cache(record)  # for tests that look at the same run


def digest(name: str, loop: str, companions: int = 0) -> str:
    """Hash of all that is recorded: state and extremes, signs of zeros with them."""
    return hashed(record(name, loop, companions).rows)


def hashed(rows: np.ndarray) -> str:
    """Hash of rows, to the bit."""
    return hashlib.sha256(rows.astype("<f8").tobytes()).hexdigest()[:32]


def digest_on_card(name: str, driver: Any = None) -> str:
    """Hash of what a graphics card records; unless its ``driver`` is given, its text, threads and addresses
    are carried out by the processor.
    """
    return hashed(rows_on_card(start(name), driver))


def known(name: str) -> str:
    """The hash that was taken."""
    found: str = json.loads(HASHES.read_text())[name]
    return found


@pytest.mark.parametrize("name", [*CASES, *(name for name in RICH if name not in CASES)])
def test_bits_are_as_before(name):
    assert digest(name, "data-driven") == known(name)


# Every kind and every law are in these two; the other texts are compiled in `make system`.
STRAIGHT = ("every kind", "every law")


@pytest.mark.parametrize(
    "name",
    default_cases(
        [*RICH, "every kind", "every drive"],
        lambda name: name in STRAIGHT or name.startswith("four_bar"),
        "compiles a straight line",
    ),
)
def test_bits_are_those_of_the_straight_line(name):
    assert hashed(once(name, "generated").rows) == known(name)


@pytest.mark.parametrize("name", ON_CARD)
def test_bits_are_those_of_a_card_at_its_addresses(name):
    """The others of RICH are in `tests/verification`."""
    assert digest_on_card(name) == known(name)


@pytest.mark.parametrize("threads", [2, 8])
def test_bits_are_the_same_in_so_many_threads(threads):
    """As many runs at once, of three mechanisms that share neither topology nor laws."""
    names = [("four_bar_case_c", "rigid_bars", "two_particle_bars")[k % 3] for k in range(threads)]
    with ThreadPoolExecutor(threads) as pool:
        assert list(pool.map(lambda name: digest(name, "generated"), names)) == [
            known(name) for name in names
        ]


@pytest.mark.parametrize("name", RICH)
def test_the_cases_are_rich_in_contact(name):
    """Contacts begin, end or rub; steps are taken again in parts."""
    found = once(name, "generated")
    assert found.block("contact_force_squared_max").max() > 0.0
    assert (found.block("contact_onsets")[-1].sum() >= 2) or (found.block("repeated")[-1] >= 5).all()


def test_zeros_have_no_sign():
    rows = once("slider_crank_loose_guide", "generated").rows
    assert (rows == 0.0).any() and not np.signbit(rows[rows == 0.0]).any()


if __name__ == "__main__":
    taken = {
        name: digest(name, "data-driven" if name in CASES else "generated")
        for name in (*CASES, *KINDS, *MODELS)
    }
    HASHES.write_text(json.dumps(taken, indent=1) + "\n")
