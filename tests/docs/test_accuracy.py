"""The page of accuracy says which steps `vfife run` refuses."""

import re
from pathlib import Path

import pytest

import vfife
from vfife.errors import StepError

ROOT = Path(__file__).resolve().parents[2]
SENTENCE = r"stable step of case c is ([\d.]+) µs.*refuses steps above 0\.9 of it \(([\d.]+) µs\)"


def test_the_page_states_the_step_beyond_which_a_run_is_refused() -> None:
    text = (ROOT / "docs" / "accuracy.md").read_text(encoding="utf-8")
    ((stable, limit),) = re.findall(SENTENCE, text)
    model = vfife.load_model(ROOT / "examples" / "four_bar_case_c.toml")
    below, above = 0.999e-6 * float(limit), 1.005e-6 * float(limit)
    result = vfife.simulate(model, step=below, turns=0.1, companions=0)
    assert f"{1e6 * result.record.assembly.choice.stable:.2g}" == stable
    with pytest.raises(StepError, match="too large"):
        vfife.simulate(model, step=above, turns=0.1, companions=0)
