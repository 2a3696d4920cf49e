"""Long runs: memory stays flat, the ledger closes, the journal never leaves."""

import resource
from pathlib import Path

import pytest

import vfife

CASE_C = Path(__file__).parents[2] / "examples" / "four_bar_case_c.toml"


def peak() -> int:
    """Largest resident memory so far (kB)."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss


@pytest.mark.soak
@pytest.mark.parametrize("loop", ["data-driven", "generated"])
def test_five_hundred_turns(loop: str) -> None:
    """Ten million steps with as many outputs as a short run keep the memory of the short run."""
    vfife.simulate(vfife.load_model(CASE_C), turns=5, step=2e-6, outputs=400, loop=loop)
    before = peak()
    result = vfife.simulate(vfife.load_model(CASE_C), turns=500, step=2e-6, outputs=4, loop=loop)
    assert result.record.status == "complete"
    assert peak() - before < 20_000
    assert result.ledger.error < 1e-4
    assert result.measures["C.penetration.max"] < 0.5e-3
