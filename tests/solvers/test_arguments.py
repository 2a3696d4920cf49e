"""What a run is asked for is checked before anything is done, all faults at once."""

import dataclasses
import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import vfife
from support import four_bar, journal_in_bearing
from vfife.errors import ModelError
from vfife.solvers.arguments import RunArguments

NONSENSE = [
    ("turns", -1, "negative"),
    ("turns", 0, "zero or negative"),
    ("turns", math.nan, "not a finite number"),
    ("turns", True, "true or false"),
    ("turns", "2 mm", "a length"),
    ("duration", -0.1, "negative"),
    ("duration", math.inf, "not a finite number"),
    ("duration", [1.0], "a list"),
    ("step", 0.0, "zero or negative"),
    ("step", "1 um", "a length"),
    ("step", "soon", "does not begin with a number"),
    ("step", False, "true or false"),
    ("outputs", -3, "too small"),
    ("outputs", 0, "too small"),
    ("outputs", 2.5, "a number"),
    ("outputs", True, "true or false"),
    ("outputs", "720", "a text"),
    ("outputs", 10**15, "too large"),
    ("loop", "numba", "there is no such loop"),
    ("loop", None, "there is no such loop"),
    ("reference", "yes", "a text"),
    ("force_step", "no", "a text"),
    ("start", 3.0, "a number"),
    ("progress", "bar", "a text"),
    ("file", 3, "a whole number"),
]


@pytest.mark.parametrize(("name", "value", "words"), NONSENSE)
def test_nonsense_is_told(name: str, value: Any, words: str) -> None:
    with pytest.raises(ModelError) as told:
        vfife.simulate(journal_in_bearing(), **{name: value})
    (fault,) = told.value.faults
    assert fault.where == name and words in fault.what
    assert str(told.value).startswith(f"simulate(), {name} = ") and fault.remedy


def test_all_faults_are_told_at_once() -> None:
    with pytest.raises(vfife.VfifeError) as told:
        vfife.simulate(
            journal_in_bearing(), turns=-1, duration=1.0, outputs=-3, loop="data driven", step="1 mm"
        )
    text = str(told.value)
    assert text.startswith("simulate() has 5 faults:")
    for words in (
        "turns and duration exclude each other",
        "turns = -1: this is negative",
        "outputs = -3: this is too small",
        'Did you mean "data-driven"?',
        "20 ms",
    ):
        assert words in text


def test_a_path_is_no_mechanism() -> None:
    with pytest.raises(vfife.VfifeError, match=r"Read it first: vfife.load\(path\)"):
        vfife.simulate("model.toml")  # type: ignore[arg-type]


def test_quantities_carry_units() -> None:
    """Numbers of NumPy are numbers, and texts have units, as in a model file."""
    numbers = {"step": np.float64(2e-6), "duration": 1e-3, "outputs": np.int64(20)}
    texts = {"step": "2 us", "duration": "1 ms", "outputs": 20}
    one, other = (
        vfife.simulate(journal_in_bearing(), loop="data-driven", **given) for given in (numbers, texts)
    )
    assert one.record.assembly.choice == other.record.assembly.choice
    assert one.record.assembly.choice.step == pytest.approx(2e-6)
    assert len(one.time) == 21


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"step": -1e-6}, "step = -1e-06: this is negative"),
        ({"step": [1e-6, "x"]}, 'step[1] = "x" (entry 2): this is a text that does not begin'),
        ({"step": [1e-6]}, "1 values for 2 mechanisms"),
        ({"step": None}, "no step is given"),
        ({"turns": 2.5}, "turns = 2.5: this is a number"),
        ({"turns": None}, "turns = None: a value is missing"),
        ({"outputs": 0}, "outputs = 0: this is too small"),
        ({"lanes": 0}, "lanes = 0: this is too small"),
        ({"workers": -1}, "workers = -1: this is too small"),
        ({"tolerance": -0.1}, "tolerance = -0.1: this is negative"),
        ({"tolerance": math.nan}, "tolerance = nan: this is not a finite number"),
        ({"loop": "fast"}, 'loop = "fast": there is no such loop'),
        ({"device": "gpu"}, 'device = "gpu": there is no such device; allowed: "cuda"'),
    ],
)
def test_an_ensemble_is_asked_the_same(given: dict[str, Any], words: str) -> None:
    with pytest.raises(ModelError) as told:
        vfife.studies.ensemble([four_bar(), four_bar()], **{"step": "2 us", "turns": 1, **given})
    assert words in str(told.value)


def test_the_members_of_an_ensemble_are_examined() -> None:
    with pytest.raises(
        ModelError, match=r"ensemble\(\), mechanisms = .*: this is a Mechanism; allowed: a list of Mechanisms"
    ):
        vfife.studies.ensemble(four_bar(), step="2 us", turns=1)  # type: ignore[arg-type]
    with pytest.raises(ModelError, match=r"mechanisms\[1\] = 3"):
        vfife.studies.ensemble([four_bar(), 3], step="2 us", turns=1)  # type: ignore[list-item]
    with pytest.raises(ModelError, match="clearance"):
        vfife.studies.ensemble([four_bar(), four_bar(clearance=-1e-4)], step="2 us", turns=1)


def test_a_comparison_is_asked_the_same() -> None:
    with pytest.raises(ModelError, match=r"compare\(\), turns = -1: this is negative"):
        vfife.compare(four_bar(), ["pereira"], turns=-1)


def test_a_static_analysis_has_no_use_for_them() -> None:
    model = Path(__file__).resolve().parents[2] / "examples" / "williams_toggle.toml"
    with pytest.raises(ValueError, match="turns = 2 has no meaning"):
        vfife.simulate(vfife.load_model(model), turns=2)
    with pytest.raises(ModelError, match="there is no such loop"):
        vfife.simulate(vfife.load_model(model), loop="numba")


def test_a_length_in_turns_takes_the_place_of_one_in_time() -> None:
    model = journal_in_bearing()
    model.settings = dataclasses.replace(model.settings, duration=1e-3, outputs=7)
    found = RunArguments(turns=2.0, companions=0).in_settings(model).settings
    assert (found.turns, found.duration, found.outputs, found.companions) == (2.0, None, 7, 0)
    assert RunArguments().in_settings(model) == model


VARY = {"joint.pin.clearance": ("0.1 mm", "0.2 mm")}
ENTRIES: dict[str, Callable[[vfife.Mechanism], object]] = {
    "simulate": vfife.simulate,
    "check": lambda m: m.check(),
    "to_toml": lambda m: m.to_toml(),
    "live": lambda m: m.live(),
    "section": lambda m: vfife.dynamics.poincare_section(m, turns=4),
    "section with a step": lambda m: vfife.dynamics.poincare_section(m, turns=4, step="2 us"),
    "bifurcation": lambda m: vfife.bifurcation(m, "joint.pin.clearance", 1e-4, 2e-4, count=2, turns=2),
    "basins": lambda m: vfife.dynamics.basins(
        m, ("start.crank", 0, 1), ("start.pin.x", 0, 1e-5), count=(2, 2)
    ),
    "study": lambda m: vfife.study(m, {"joint.pin.clearance": [1e-4]}, ["pin.force.max"], turns=2),
    "compare": lambda m: vfife.compare(m, contact=["hertz"], turns=1),
    "sensitivity": vfife.sensitivity,
    "wear": lambda m: vfife.wear(m, turns=10),
    "ensemble": lambda m: vfife.studies.ensemble([m], turns=1, step=1e-6),
    "stepped by a script": vfife.Simulation,
    "design": vfife.design,
}


@pytest.mark.parametrize("entry", ENTRIES)
def test_the_name_of_a_law_in_its_place_is_a_fault_everywhere(entry: str) -> None:
    m = vfife.gallery.slider_crank_loose_pin()
    m.joints["pin"] = dataclasses.replace(m.joints["pin"], contact="flores")
    with pytest.raises(vfife.VfifeError) as caught:
        ENTRIES[entry](m)
    words = 'contact = "flores": this is the name of a law; allowed: a ContactLaw. Give the law itself:'
    assert "joint.pin" in str(caught.value)
    assert f"{words} vfife.laws.Flores()" in " ".join(str(caught.value).split())
