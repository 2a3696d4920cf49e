"""Bits flipped, pages zeroed and pages exchanged in files of every kind: the answer is the one that was
written, or the damage is reported.
"""

from __future__ import annotations

import dataclasses
import math
import random
import sqlite3
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import vfife
from choice import default_cases
from vfife.errors import DamageWarning, VfifeError
from vfife.model.wear import Wear

EXAMPLES = Path(__file__).parents[2] / "examples"
PAGE = 4096
COUNT = 12  # of each kind of damage; `make soak` makes 300


def run_file(folder: Path) -> Path:
    model = vfife.load_model(EXAMPLES / "slider_crank_loose_pin.toml")
    vfife.simulate(model, turns=0.05, outputs=100, step=1e-5).save(folder / "a.sqlite")
    return folder / "a.sqlite"


def study_file(folder: Path) -> Path:
    vary = {"body.coupler.length": [f"{k} um" for k in range(260_000, 260_060)]}
    model = vfife.gallery.four_bar_ideal()
    vfife.study(model, vary, ["C.force.max"], turns=1, step=1e-4, file=folder / "a.study")
    return folder / "a.study"


def map_file(folder: Path) -> Path:
    model, given = (
        vfife.load_model(EXAMPLES / "slider_crank_loose_pin.toml"),
        {"turns": 4, "dropped": 2, "step": 1e-5, "companions": 0},
    )
    vfife.bifurcation(model, "joint.pin.clearance", 2e-4, 3e-4, count=12, **given, file=folder / "a.map")
    return folder / "a.map"


def wear_file(folder: Path) -> Path:
    model = vfife.gallery.slider_crank_loose_pin(friction=0.05, clearance=2e-4, restitution=0.5)
    model.joints["pin"] = dataclasses.replace(model.joints["pin"], wear=Wear(bearing=1e-15, journal=2e-16))
    vfife.wear(model, 4e6, block=1, settle=1, step=1e-5, file=folder / "a.wear")
    return folder / "a.wear"


def fit_file(folder: Path) -> Path:
    model = vfife.Mechanism("oscillator", gravity=(0.0, 0.0))
    model.point("O", 0.0, 0.0)
    model.point_mass("b", mass=2.0, position=(0.11, 0.0))
    model.spring("k", "ground.O", "b.center", stiffness=800.0, damping=3.0, free_length=0.1)
    times = np.linspace(0.0, 0.5, 40)
    rows = [f"{t:.9g}, {0.1 + 0.01 * math.exp(-1.25 * t) * math.cos(15.76 * t):.9g}" for t in times]
    (folder / "s.csv").write_text("\n".join(["time (s), b.x (m)", *rows]) + "\n")
    given = {"screened": 8, "starts": 1, "derivatives": "differences", "step": "1 ms"}
    vfife.fit(
        model,
        folder / "s.csv",
        {"spring.k.stiffness": ("200 N/m", "1000 N/m")},
        **given,
        file=folder / "a.fit",
    )
    return folder / "a.fit"


def answer_of_run(path: Path) -> Any:
    result = vfife.load_result(path)
    return (
        result.record.rows.tobytes(),
        repr(dict(result.measures)),
        repr(result.record.companions and result.record.companions.rows.tobytes()),
    )


def answer_of_study(path: Path) -> Any:
    study = vfife.studies.load_study(path)
    return (
        [(one.numbers, study.outcomes.get(one.number)) for one in study.cases],
        study.name,
        study.status,
        study.measures,
    )


def answer_of_map(path: Path) -> Any:
    found = vfife.dynamics.load_map(path)
    return (
        {name: points.tobytes() for name, points in found.points.items()},
        found.kinds,
        found.exponents.tobytes(),
        found.spec,
    )


def answer_of_wear(path: Path) -> Any:
    found = vfife.tribology.load_wear(path)
    return (
        found.turns.tobytes(),
        found.depth.tobytes(),
        found.rate.tobytes(),
        found.step_difference,
        found.complete,
    )


def answer_of_fit(path: Path) -> Any:
    return vfife.identification.load_fit(path).json() | {"seconds": 0.0}  # of the clock


KINDS: dict[str, tuple[Callable[[Path], Path], Callable[[Path], Any]]] = {
    "run": (run_file, answer_of_run), "study": (study_file, answer_of_study),
    "map": (map_file, answer_of_map),
    "wear": (wear_file, answer_of_wear), "fit": (fit_file, answer_of_fit),
}  # fmt: skip


def flip(data: bytearray, chance: random.Random) -> None:
    """One bit."""
    data[chance.randrange(len(data))] ^= 1 << chance.randrange(8)


def zero(data: bytearray, chance: random.Random) -> None:
    """A page, as after a block of the disk was lost; the first one has the header."""
    at = PAGE * chance.randrange(1, len(data) // PAGE)
    data[at : at + PAGE] = bytes(PAGE)


def exchange(data: bytearray, chance: random.Random) -> None:
    """Two pages."""
    one, other = (PAGE * k for k in chance.sample(range(1, len(data) // PAGE), 2))
    data[one : one + PAGE], data[other : other + PAGE] = data[other : other + PAGE], data[one : one + PAGE]


def cut(data: bytearray, chance: random.Random) -> None:
    """Without its end, as a copy that was interrupted."""
    del data[chance.randrange(len(data) // 2, len(data)) :]


def head(data: bytearray, chance: random.Random) -> None:
    """One bit of the head, except those that say what the file is."""
    data[chance.choice([*range(16, 60), *range(72, 100)])] ^= 1 << chance.randrange(8)


@pytest.fixture(
    scope="module",
    params=default_cases(KINDS, lambda kind: kind in ("run", "map"), "makes a file of each kind"),
)
def kind(
    request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory
) -> tuple[bytes, Callable[[Path], Any], Any]:
    make, answer = KINDS[request.param]
    path = make(tmp_path_factory.mktemp(request.param))
    with warnings.catch_warnings():
        warnings.simplefilter("error", DamageWarning)
        return path.read_bytes(), answer, answer(path)


@pytest.mark.parametrize("damage", [flip, zero, exchange, cut], ids=lambda one: one.__name__)
def test_no_damage_goes_unreported(kind, damage, tmp_path):
    unreported(kind, damage, tmp_path / "b", COUNT)


LONG = pytest.mark.system("computes a study or a fit again for each damage")


@pytest.mark.parametrize("name", [pytest.param("study", marks=LONG), "map", pytest.param("fit", marks=LONG)])
def test_a_file_with_damaged_pages_is_made_whole_by_the_same_command(name: str, tmp_path: Path) -> None:
    """The remedy that the warning names works for each page that it is printed for: what is readable goes
    into a new file, the damaged one stays beside it, and the answer is that of the whole file.
    """
    make, answer = KINDS[name]
    whole_path = make(tmp_path)
    whole, right = whole_path.read_bytes(), answer(whole_path)
    repaired = 0
    for page in range(1, len(whole) // PAGE):
        folder = tmp_path / f"{page}"
        folder.mkdir()
        data = bytearray(whole)
        data[PAGE * page] ^= 1 << 4  # the kind of the page
        path = folder / f"a.{name}"
        path.write_bytes(data)
        with warnings.catch_warnings(record=True) as heard:
            warnings.simplefilter("always")
            try:
                answer(path)
            except VfifeError:  # no remedy is promised: the specification is on this page
                continue
            words = " ".join(str(one.message) for one in heard)
            if "pages do not fit together" not in words or "cannot be continued" in words:
                continue
            make(folder)
        kept = folder / f"a.{name}.damaged"
        assert kept.read_bytes() == data and any(str(kept) in str(one.message) for one in heard)
        with warnings.catch_warnings():
            warnings.simplefilter("error", DamageWarning)
            assert answer(path) == right
        repaired += 1
    assert repaired > 2


def test_a_damaged_head_loses_nothing(kind, tmp_path):
    whole, answer, right = kind
    chance = random.Random("head")
    for _ in range(COUNT):
        data = bytearray(whole)
        head(data, chance)
        (tmp_path / "b").write_bytes(data)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", DamageWarning)
            assert answer(tmp_path / "b") == right


@pytest.mark.system("cuts files at many places")
def test_a_cut_file_is_read_up_to_its_end(tmp_path: Path) -> None:
    """All outputs before the cut, with a warning; the command that made a study completes it."""
    path = run_file(tmp_path)
    whole, rows = path.read_bytes(), vfife.load_result(path).record.rows
    path.write_bytes(whole[: 3 * len(whole) // 4])
    with pytest.warns(DamageWarning, match="damaged: its summary; the ideal reference"):
        found = vfife.load_result(path).record.rows
    assert np.array_equal(found, rows)
    path = study_file(tmp_path)
    whole, right = path.read_bytes(), answer_of_study(path)
    path.write_bytes(whole[: 3 * len(whole) // 4])
    with pytest.warns(DamageWarning, match="its head does not fit its pages"):
        study_file(tmp_path)
    assert answer_of_study(path) == right


@pytest.mark.system("starts a process")
def test_a_warning_blames_the_line_of_the_user(tmp_path):
    path = tmp_path / "a.study"
    path.write_bytes(study_file(tmp_path).read_bytes())
    with sqlite3.connect(path) as connection:
        connection.execute("DELETE FROM outcomes WHERE number = 3")
    connection.close()
    with pytest.warns(
        DamageWarning, match="1 outcomes are missing; the rest is used. Running the same study again"
    ) as heard:
        vfife.studies.load_study(path)
    assert heard[0].filename == __file__


@pytest.mark.soak
@pytest.mark.parametrize("damage", [flip, zero, exchange, cut], ids=lambda one: one.__name__)
def test_no_damage_of_three_hundred_goes_unreported(kind, damage, tmp_path):
    unreported(kind, damage, tmp_path / "b", 300)


def unreported(
    kind: tuple[bytes, Callable[[Path], Any], Any], damage: Callable, path: Path, count: int
) -> None:
    """Fail where an answer is another one and nothing was reported; every error has words."""
    whole, answer, right = kind
    chance, told = random.Random(damage.__name__), 0
    for k in range(count):
        data = bytearray(whole)
        damage(data, chance)
        path.write_bytes(data)
        with warnings.catch_warnings(record=True) as heard:
            warnings.simplefilter("always")
            try:
                found = answer(path)
            except VfifeError as error:
                assert str(error).strip() and str(path) in str(error), error
                told += 1
                continue
            reported = any(
                issubclass(one.category, DamageWarning) and str(path) in str(one.message) for one in heard
            )
        told += reported
        assert reported or found == right, f"{damage.__name__} {k}: another answer, and nothing is reported"
    assert told >= count // 20
