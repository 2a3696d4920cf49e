"""Ranges of shares and friction energy hold the values at a sixteenth of the step, in 20 chains."""

from __future__ import annotations

import pytest

import vfife
from hanging_chain import variant

KINDS = (".share.free_flight", ".share.continuous_contact", ".friction_energy.total")


@pytest.mark.verify
@pytest.mark.parametrize("k", range(20))
def test_shares_and_friction_energy_hold_the_truth(k: int) -> None:
    result = vfife.simulate(variant(k), reference=False)
    step = result.record.assembly.choice.step / 16.0
    truth = vfife.simulate(variant(k), step=step, companions=0, reference=False).measures
    missed = {
        name: (measure, truth[name])
        for name, measure in result.measures.items()
        if name.endswith(KINDS) and not measure.low <= truth[name] <= measure.high
    }
    assert not missed
