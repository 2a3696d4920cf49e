"""An answer that was interrupted tells first how much of it is computed, as text, figure and table."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from functools import partial
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

import vfife
from dynamics.test_maps import GIVEN, loose
from dynamics.test_maps import oscillator as driven_oscillator
from identification.test_identification import BOUNDS, QUICK, oscillator, swing, written
from support import four_bar
from tribology.test_wear import GIVEN as WEAR
from tribology.test_wear import loose_pin
from vfife.dynamics import basins, load_map, poincare_section, waterfall
from vfife.dynamics.step_check import CheckedMap
from vfife.plots.sensitivity import bars, forces
from vfife.report.dynamics import _chaos
from vfife.report.front import conclusion
from vfife.report.html import document_of, text
from vfife.report.overview import heading_sentence
from vfife.results.derivatives import Sensitivity

CLEARANCE = "joint.pin.clearance"


def stop_after(count: int) -> Callable[..., None]:
    """Progress function that acts as Ctrl-C does after so many items."""

    def stop(done: Any, *_: object) -> None:
        if done == count:
            raise KeyboardInterrupt

    return stop


def check(result: Any, progress: str, title: str = "") -> str:
    """Check text, representation, attributes of a table and title of a figure; return the text."""
    printed = text(result)
    first = next(line for line in printed.splitlines()[0:2] if progress in line)
    assert first.startswith("Not complete: only"), printed
    assert result.progress == progress
    frame = result.to_dataframe()
    assert frame.attrs["complete"] is False and frame.attrs["computed"] == progress
    if title:
        assert title in result.plot().get_suptitle().replace("\n", " ")
    return printed


def test_a_diagram(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "a.map"
    ends: tuple[float, float] = (2e-4, 3e-4)
    part = vfife.bifurcation(loose(), CLEARANCE, *ends, **GIVEN, file=path, progress=stop_after(1))
    assert "was interrupted after 1 of 3 values; it returns" in capsys.readouterr().err
    for found in (part, load_map(path)):
        printed = check(found, "1 of 3 values", "not complete, 1 of 3 values; ")
        assert "1 of 3 values" in repr(found)
        assert "not computed from 250 µm to 300 µm" in printed, printed
        assert "not computed from 200 µm to 250 µm" in printed
        assert "No chaos was found." not in printed
    whole = vfife.bifurcation(loose(), CLEARANCE, *ends, **GIVEN, file=path)
    assert "ot complete" not in text(whole) + repr(whole) + whole.plot().get_suptitle()
    assert "not computed" not in text(whole) and whole.to_dataframe().attrs == {"complete": True}


def test_no_chaos_is_limited_to_what_is_computed() -> None:
    given: dict[str, Any] = {"count": 3, "turns": 120, "step": 2e-4, "series": ["block.x"], "companions": 0}
    part = vfife.bifurcation(
        driven_oscillator(), "spring.spring.damping", 1.0, 2.0, **given, progress=stop_after(2)
    )
    assert "No chaos was found within 120 turns at 2 of 3 values from 1 to 2" in text(part).replace(
        " N s/m", ""
    )


def test_no_chaos_is_not_said_of_motions_that_are_not_decided() -> None:
    def words(*kinds: str) -> str:
        diagram: Any = SimpleNamespace(
            shown=(1.0, "m"),
            progress="",
            kinds=[kinds],
            spec=SimpleNamespace(ways=["up"], values=(1.0, 2.0), turns=60),
        )
        return _chaos(diagram)

    place = "within 60 turns at 2 values from 1 m to 2 m"
    assert words("period 1", "period 2") == f"No chaos was found {place}."
    assert words("not settled", "not decided").startswith("Whether there is chaos is not known")
    assert (
        words("period 1", "not settled") == f"No chaos was found {place}; of 1 of 2 motions nothing is known."
    )


def test_chaos_is_limited_to_the_turns_that_are_computed() -> None:
    def words(*companions: object) -> str:
        diagram: Any = SimpleNamespace(
            shown=(1.0, "m"), progress="", kinds=[("chaotic", "period 1")], companions=companions,
            spec=SimpleNamespace(ways=["up"], values=(1.0, 2.0), turns=90),
        )  # fmt: skip
        diagram.words_of = partial(CheckedMap.words_of, diagram)
        return _chaos(diagram)

    found = "Chaotic within 90 turns: on the way up at 1 m (1 of 2 values); a longer transient is possible: "
    assert words() == f"{found}--turns 900."
    assert words(1) == f"{found}--turns 900. Companions make as many turns and do not show it."


def test_basins(tmp_path: Path) -> None:
    path = tmp_path / "a.map"
    axes: list[Any] = [("start.crank", 0.0, 1.0), ("start.pin.x", -1e-4, 1e-4)]
    given = {**GIVEN, "count": 2, "exponents": False, "series": ["rod.angular_velocity"]}
    part = basins(loose(), *axes, **given, file=path, progress=stop_after(2))
    for found in (part, load_map(path)):
        printed = check(found, f"{found.done} of 4 starts", "not complete, ")
        assert (
            f"share of these {len(found.verdicts)}" in printed and "Companions: not computed yet." in printed
        )


def test_a_waterfall_and_a_section() -> None:
    given = {"count": 3, "turns": 2, "last": 2, "outputs": 120, "highest": 20.0, "step": 1e-5}
    sweep = waterfall(loose(), "driver.crank.speed", 90.0, 100.0, **given, window="rectangular",
                      series=["pin.force"], progress=stop_after(1))  # fmt: skip
    check(sweep, "1 of 3 runs", "not complete, 1 of 3 runs; ")
    given = {"turns": 120, "dropped": 10, "step": 2e-4, "series": ["block.x"]}
    section = poincare_section(driven_oscillator(), **given, progress=stop_after(60))
    assert 0 < section.done < 110
    check(section, f"{section.done} of 110 turns", "not complete, ")


def test_a_comparison_and_sensitivities() -> None:
    comparison = vfife.compare(four_bar("C"), "hertz", turns=0.1, step=2e-6, force_step=True)
    part = dataclasses.replace(comparison, planned=3)
    check(part, "1 of 3 runs")
    assert "1 of 3 runs" in repr(part)
    assert "1 of 3 runs" in bars(part).get_suptitle() and "1 of 3 runs" in forces(part).get_suptitle()
    check(Sensitivity("four-bar", {"C.force.max": 1.0}, complete=False), "0 of the derivatives")


def test_wear() -> None:
    worn = vfife.wear(loose_pin(), 4e6, **WEAR, progress=lambda turns, *_: stop_after(1)(turns > 0.0))
    assert 0.0 < worn.turns[-1] < 4e6
    check(worn, f"{worn.turns[-1]:,.0f} of 4,000,000 turns", "not complete, ")


def test_a_fit(tmp_path: Path) -> None:
    import numpy as np

    t, calls = np.linspace(0.0, 1.0, 120), []

    def interrupt(progress: object) -> None:
        calls.append(progress)
        if len(calls) == 2:
            raise KeyboardInterrupt

    given: dict[str, Any] = {**QUICK, "progress": interrupt}
    found = vfife.fit(oscillator(), written(tmp_path / "s.csv", t, swing(t)), BOUNDS, **given)
    check(found, f"{found.evaluations} runs of the search", "not complete, ")
    assert ": interrupted, " in repr(found)


def test_a_study(tmp_path: Path) -> None:
    vary: dict[str, Any] = {CLEARANCE: ["0.2 mm", "0.25 mm", "0.3 mm"]}
    given: dict[str, Any] = {"turns": 1, "step": 1e-5}
    found = vfife.study(loose(), vary, "pin.force.max", **given, progress=stop_after(1))
    count = f"{len(found.done)} of 3 cases"
    assert len(found.done) < 3 and found.to_dataframe().attrs["computed"] == count
    first = document_of(found).parts[0]
    assert count in getattr(first, "text", "")
    titles = [figure.get_suptitle().replace("\n", " ") for figure in found.plot().values()]
    assert titles and all(f"not complete, {count}" in title for title in titles)


def test_a_run() -> None:
    def stop(progress: Any) -> None:
        if progress.done > 0.4 * progress.steps:
            raise KeyboardInterrupt

    result = vfife.simulate(four_bar("C"), turns=0.5, step=2e-6, reference=False, companions=0, progress=stop)
    turns = result.summary["run"]["turns"]
    assert result.status == "interrupted" and 0.1 < turns < 0.5
    assert f" · {turns:.4g} of 0.5 turns · " in str(result).replace("\n", " ")
    assert conclusion(result.summary)[0].startswith(
        f"The run was interrupted after {turns:.4g} of 0.5 turns;"
    )
    whole = vfife.simulate(four_bar("C"), turns=0.1, step=2e-6, reference=False, companions=0)
    assert " of " not in heading_sentence(whole.summary).partition("values")[0]
    assert not any("interrupted" in text for text in conclusion(whole.summary))
