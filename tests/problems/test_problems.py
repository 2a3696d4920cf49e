"""The two problems for other programs: their texts agree, scores are right, and vfife answers them."""

from __future__ import annotations

import csv
import importlib
import math
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

FOLDER = Path(__file__).resolve().parents[2] / "problems"
sys.path.insert(0, str(FOLDER))
# Scripts of the folder of problems, which is no package.
answer_of_vfife, equations, score = (
    importlib.import_module(name) for name in ("answer_of_vfife", "equations", "score")
)


def random_state(problem: str, seed: int) -> tuple[float, list[float], list[float], int]:
    """A time and a state at the start, disturbed, in the coordinates of both texts; the number
    of contacts.
    """
    random = np.random.default_rng(seed)
    if problem == "four_bar":
        pins = equations.FourBarAtPins()
        t, y = random.uniform(0.0, 1e-6), np.array(pins.start())
        y += random.normal(size=12) * np.array([2e-4, 2e-4, 2e-4] * 2 + [1.0] * 6)
        return t, list(centres_of(y)), list(y), 3
    model = equations.SliderCrankAtCentres()
    t, y = random.uniform(0.0, 1e-6), np.array(model.start())
    y += random.normal(size=4) * np.array([3e-3, 8e-4, 5.0, 1.0])
    angle, x, w, u = (float(one) for one in y)
    return t, [angle, x, w, u], [0.12 * math.cos(angle), 0.12 * math.sin(angle), x, w, u, angle], 1


def centres_of(y: np.ndarray) -> np.ndarray:
    """Places and rates of the centres of two rods from those of their first pins."""
    result = y.copy()
    for k, length in ((0, 0.26), (3, 0.46)):
        c, s, w = 0.5 * length * math.cos(y[k + 2]), 0.5 * length * math.sin(y[k + 2]), y[k + 8]
        result[k : k + 2] += c, s
        result[k + 6 : k + 8] += -w * s, w * c
    return result


TEXTS: dict[str, tuple[Any, Any]] = {
    "four_bar": (equations.FourBarAtCentres, equations.FourBarAtPins),
    "slider_crank": (equations.SliderCrankAtCentres, equations.SliderCrankInComplexNumbers),
}


@pytest.mark.parametrize("problem", TEXTS)
def test_both_texts_have_the_same_forces_and_accelerations(problem: str) -> None:
    first, second = (text() for text in TEXTS[problem])
    touched = 0
    for seed in range(30):
        t, y, z, _ = random_state(problem, seed)
        gaps = first.gaps(t, y)
        modes = [(gap[0] > 0.0, 0.7, equations.band_of(gap[2])) for gap in gaps]
        touched += sum(mode[0] for mode in modes)
        a, b = np.array(first.outputs(t, y, modes)), np.array(second.outputs(t, z, modes))
        scale = np.maximum(np.abs(a), 1e-6 * np.abs(a).max())
        assert np.all(np.abs(a - b) < 1e-6 * scale + 1e-12)
    assert touched > 10  # or nothing of the contacts was compared


def changed(path: Path, factor: float) -> Path:
    """The reference of the four-bar as an answer with one column wrong by a factor."""
    with (FOLDER / "four_bar/reference.csv").open(newline="") as file, path.open("w", newline="") as out:
        writer = csv.writer(out)
        writer.writerow(["t", "force_C", "coupler_x"])
        for row in csv.DictReader(file):
            writer.writerow([row["t"], repr(factor * float(row["force_C"])), row["coupler_x"]])
    return path


def test_the_score_of_an_answer_is_its_error(tmp_path: Path) -> None:
    reference = score.table(FOLDER / "four_bar/reference.csv")
    force, place = score.errors(reference, score.table(changed(tmp_path / "a.csv", 1.002)))
    last = list(force.items())
    assert place["until 0.08 s"] == 0.0 and place["near until"] == pytest.approx(0.08)
    assert last[3][1] == pytest.approx(0.002, rel=1e-6)
    assert 0.0 < float(str(force["near until"])) < 0.08


def test_the_score_says_where_the_reference_is_not_certain(tmp_path: Path) -> None:
    reference = score.table(FOLDER / "four_bar/reference.csv")
    (force, _) = score.errors(reference, score.table(changed(tmp_path / "a.csv", 1.0 + 1e-14)))
    assert force["until 0.08 s"] in (0.0, "not certain")


def test_an_answer_with_an_unknown_column_is_refused(tmp_path: Path) -> None:
    (tmp_path / "a.csv").write_text("t,force_X\n0,1\n")
    done = subprocess.run(
        [sys.executable, FOLDER / "score.py", "four_bar", tmp_path / "a.csv"], capture_output=True, text=True
    )
    assert done.returncode == 1 and "force_X" in done.stderr and "Traceback" not in done.stderr


@pytest.mark.verify
@pytest.mark.parametrize(
    ("problem", "part", "rows", "largest"), [("four_bar", 3, 2e-4, 5e-5), ("slider_crank", 1, 5e-6, 0.1)]
)
def test_vfife_answers_the_problem(
    problem: str, part: int, rows: float, largest: float, tmp_path: Path
) -> None:
    """Errors against the certified references at a step of 0.05 us: over the whole of problem 1, over the
    first tenth of problem 2, whose motion parts from any neighbour later.
    """
    answer_of_vfife.answer(problem, "0.05 us", tmp_path)
    reference = score.table(FOLDER / problem / "reference.csv")
    for entry in score.errors(reference, score.table(tmp_path / "answer.csv")):
        error = list(entry.values())[part]
        assert error == "not certain" or float(str(error)) < rows, entry
    for entry in score.largest_errors(FOLDER / problem / "largest.csv", tmp_path / "largest.csv"):
        assert abs(float(str(entry["error"]))) < largest, entry
