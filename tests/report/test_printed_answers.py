"""print() of an answer shows its tables and sentences; repr is one line without arrays."""

from __future__ import annotations

import subprocess
import sys
from functools import cache
from pathlib import Path
from typing import Any

import pytest

import vfife
from dynamics.test_maps import oscillator
from studies.studies import ASKED, Closed
from support import four_bar
from vfife.studies.engine import study_engine

QUICK: dict[str, Any] = {"turns": 4, "dropped": 2, "step": 2e-4, "series": ["block.x"]}


@cache
def result() -> vfife.Result:
    """A short run with contact, which no test changes."""
    return vfife.simulate(four_bar("C"), turns=0.5, step=2e-6, companions=0, reference=False, outputs=100)


def test_a_section_and_a_diagram_print_their_verdicts() -> None:
    section = vfife.dynamics.poincare_section(oscillator(), **QUICK)
    assert section.verdict.kind in str(section) and "turns after 2 discarded turns" in str(section)
    assert str(section.verdict) == f"{section.verdict.kind}: {section.verdict.evidence}"
    sweep = vfife.bifurcation(oscillator(), "spring.spring.damping", 1.0, 2.0, count=2, companions=0, **QUICK)
    assert "values on the way up" in str(sweep) and "Whether there is chaos is not known" in str(sweep)
    assert repr(sweep).startswith("<Bifurcation of") and "\n" not in repr(sweep)


def test_a_comparison_prints_its_table() -> None:
    comparison = vfife.compare(four_bar("C"), "hertz", turns=0.1, step=2e-6, force_step=True)
    assert "penetration" not in str(comparison) and "deepest" in str(comparison)
    assert f"{comparison.rows[0]['force']:,.6g}" in str(comparison), "no number is broken into two lines"


def test_a_study_prints_its_tables_and_counts_what_failed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(study_engine, "run_cases", Closed(fails=2e-4))
    path = tmp_path / "s.toml"
    path.write_text(ASKED)
    study = vfife.study(path)
    assert "6 of 6 cases (2 failed, see .failed)" in repr(study)
    assert "C.force.max" in str(study) and "case 2: " in str(study)
    assert "settle" not in study.data.attrs


@pytest.mark.system("starts a process")
@pytest.mark.parametrize("name", ["Study", "Comparison"])
def test_methods_belong_to_a_class_however_it_is_imported(name: str) -> None:
    """Also in a process that only loads a file, in which nothing was studied."""
    text = f"from vfife.studies import {name} as one; print(one.__str__ is not object.__str__)"
    done = subprocess.run([sys.executable, "-c", text], capture_output=True, text=True)
    assert done.stdout.strip() == "True", done.stderr


@pytest.mark.system("starts a process")
def test_a_loaded_study_and_fit_can_be_plotted_in_a_new_process() -> None:
    text = "from vfife.studies import load_study; from vfife.identification import load_fit\n"
    text += "import vfife.results.study as s, vfife.results.fit as f\n"
    text += "print(hasattr(s.Study, 'plot'), hasattr(f.Fit, 'plot'))"
    done = subprocess.run([sys.executable, "-c", text], capture_output=True, text=True)
    assert done.stdout.strip() == "True True", done.stderr


def test_repr_has_no_arrays() -> None:
    run = result()
    answers = [run.ledger, run.spectrum("C.force"), run.spectrogram("C.force"), run.envelope("C.force")]
    answers += run.channels.values()
    for one in answers:
        assert "array(" not in repr(one) and len(repr(one)) < 500


def test_impacts_are_counted_with_their_entries() -> None:
    impacts = result().impacts
    assert repr(impacts).startswith(f"<{impacts.count} impacts in {len(impacts.entries)} entries")


def test_a_transformed_series_plots_itself() -> None:
    run = result()
    for one in (run.spectrum("C.force"), run.spectrogram("C.force"), run.envelope("C.force")):
        assert one.plot().axes[0].lines or one.plot().axes[0].collections


def test_data_names_the_motion() -> None:
    run = vfife.simulate(four_bar("C"), turns=1, companions=0, reference=False)
    assert run.motion is not None and run.data.attrs["motion"] == run.motion.motion
