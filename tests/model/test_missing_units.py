"""A length, inertia or speed whose unit is missing is refused or cautioned about, in every shipped model;
nothing is said of random mechanisms. Numbers of tables are treated as single ones.
"""

import dataclasses
import math
from collections.abc import Callable
from pathlib import Path

import pytest

import loose_sample
import vfife
from vfife import gallery
from vfife.errors import Fault, VfifeError
from vfife.files import GALLERY
from vfife.laws import Tabulated
from vfife.model.mechanism import Mechanism
from vfife.model.validation import faults
from vfife.model.validation.plausibility import suspects
from vfife.modelfile.parameter import number_at, numbers, with_values
from vfife.modelfile.read import load

TEMPLATES = Path(vfife.__file__).parent / "modelfile" / "templates"
FILES = [GALLERY / f"{name}.toml" for name in gallery.__all__] + sorted(TEMPLATES.glob("*.toml"))
# From the units of drawings to those of a model: mm, mm^2, mm^4, kg mm^2 and mm/s.
MISSING_UNITS = {"m": 1e3, "m^2": 1e6, "m^4": 1e12, "kg m^2": 1e6, "m/s": 1e3}
# A small number among larger ones, or among those of its own list, may be meant a thousand times larger.
PLAUSIBLE = {
    "squeezer": {"body.K1.center.0", "body.K2.position.1"},
    "williams_toggle": {"body.toggle.nodes.apex.1"},
}


def is_told(m: Mechanism, path: str, value: float) -> bool:
    try:
        changed = with_values(m, {path: value})
    except (VfifeError, Fault):
        return True
    return bool(faults(changed) or suspects(changed))


@pytest.mark.parametrize("file", FILES, ids=lambda file: file.stem)
def test_every_length_inertia_and_speed_without_its_unit_is_told(file: Path) -> None:
    m = load(file)
    assert suspects(m) == ()
    silent, compared = set(), 0
    for path, value in numbers(m).items():
        place = number_at(m, path.split("."))
        if place is not None and value and (factor := MISSING_UNITS.get(place[2].unit)):
            compared += 1
            if not is_told(m, path, factor * value):
                silent.add(path)
    assert compared and silent == PLAUSIBLE.get(file.stem, set())


@pytest.mark.parametrize("kind", loose_sample.KINDS)
def test_nothing_is_said_of_random_mechanisms(kind: str) -> None:
    for seed in range(loose_sample.EACH):
        assert suspects(loose_sample.drawn(kind, seed).m) == ()


TABLES: dict[str, tuple[Callable[[Mechanism, float], object], float, float, str]] = {
    "motor over rpm": (
        lambda m, unit: m.torque("crank", speeds=(0.0, 400.0 * unit, 600.0 * unit), value=(4.0, 3.0, 0.0)),
        1.0, math.pi / 30.0, "driver.crank.speeds reach 600 rad/s, which is 5,729.58 rpm: are they in rpm?",
    ),
    "motor over degrees": (
        lambda m, unit: m.torque("crank", angles=(0.0, 45.0 * unit, 90.0 * unit), value=(4.0, 3.0, 0.0)),
        1.0, math.pi / 180.0, "driver.crank.angles cover 90 rad, 14.3 turns: are they in degrees?",
    ),
    "motor over milliseconds": (
        lambda m, unit: m.torque("crank", times=(0.0, 400.0 * unit), value=(0.0, 3.0)),
        1.0, 1e-3, "driver.crank.times cover 400 s, 800 times the run of 0.5 s: are they in ms?",
    ),
    "motion in degrees": (
        lambda m, unit: m.motion("crank", times=(0.0, 0.2, 0.4), values=(0.0, 30.5 * unit, 0.0)),
        1.0, math.pi / 180.0, "driver.crank.angles cover 30.5 rad, 4.85 turns: are they in degrees?",
    ),
    "force over milliseconds": (
        lambda m, unit: m.force("push", at="rod.end", force=(1.0, 0.0), factors=(0.0, 1.0, 0.0),
                                times=(0.0, 80.0 * unit, 160.0 * unit)),
        1.0, 1e-3, "load.push.times cover 160 s, 320 times the run of 0.5 s: are they in ms?",
    ),
    "force over degrees": (
        lambda m, unit: m.force("push", at="rod.end", force=(1.0, 0.0), crank="crank", repeat=False,
                                angles=(0.0, 20.0 * unit, 40.0 * unit), factors=(0.0, 1.0, 0.0)),
        1.0, math.pi / 180.0, "load.push.angles cover 40 rad, 6.37 turns: are they in degrees?",
    ),
    "torque in newton millimetres": (
        lambda m, unit: m.torque("crank", times=(0.0, 0.1), value=(2e5 * unit, 4e5 * unit)),
        1.0, 1e-3, "driver.crank.torque reaches 400000 N m",
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", TABLES)
def test_a_table_without_its_unit_is_told_as_a_number_is(name: str) -> None:
    """In the unit that is meant nothing is said."""
    add, wrong, right, words = TABLES[name]
    for unit in (wrong, right):
        m = gallery.slider_crank()
        m.settings = dataclasses.replace(m.settings, turns=None, duration=0.5)
        if not name.startswith("force"):
            m.drivers.clear()
        add(m, unit)
        said = [text for text in suspects(m) if words in text]
        assert bool(said) == (unit == wrong), suspects(m)
        assert unit == wrong or not any("driver.crank" in text or "load.push" in text for text in suspects(m))


def test_a_list_of_a_body_and_a_measured_law_is_treated_as_a_number_is() -> None:
    """A speed of rotation, a mass at a pin, the penetrations of a table of a contact law."""
    m = gallery.slider_crank_loose_pin()
    assert suspects(m) == ()
    rod = dataclasses.replace(m.bodies["rod"], masses={"end": 500.0})
    crank = dataclasses.replace(m.bodies["crank"], velocity=(0.0, 0.0, 1500.0))
    law = Tabulated(loading=((0.0, 0.0), (0.01, 1000.0)))
    pin = dataclasses.replace(m.joints["pin"], contact=law)
    m.bodies |= {"rod": rod, "crank": crank}
    m.joints["pin"] = pin
    said = " ".join(suspects(m))
    words = "body.rod.masses.end is 500 kg", "velocity turns at 1,500 rad/s", "contact.loading is 0.01 m"
    assert all(one in said for one in words), said
